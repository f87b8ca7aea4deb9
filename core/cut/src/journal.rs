//! Journal of the changes of every advance, for undo and redo.
//!
//! Vertices and rows are only appended, so undo truncates the arrays and restores the saved records of changed triangles. The cost is that of
//! the change, not of the mesh.

use super::Vec3;
use super::mesh::CutMesh;
use super::record::{Lengths, NONE, Origin, Step, Triangle};

impl CutMesh {
    /// Number of advances and refinements that can be undone.
    pub fn depth(&self) -> usize {
        self.journal.done.len()
    }

    /// Number of advances and refinements that can be redone.
    pub fn undone(&self) -> usize {
        self.journal.undone.len()
    }

    /// Undoes the last advance or refinement. Returns whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some(mut step) = self.journal.done.pop() else { return false };
        self.revert(&mut step);
        self.journal.undone.push(step);
        true
    }

    /// Redoes what was undone last. Returns whether there was anything.
    pub fn redo(&mut self) -> bool {
        let Some(mut step) = self.journal.undone.pop() else { return false };
        for (point, origin) in step.tail.points.drain(..) {
            self.surface.points.push(point);
            self.origins.push(origin);
        }
        self.texcoords.append(&mut step.tail.texcoords);
        self.normals.append(&mut step.tail.normals);
        for triangle in step.tail.triangles.drain(..) {
            self.append(triangle);
        }
        for (number, saved) in &mut step.saved {
            let now = self.triangle(*number);
            self.write_record(*number, *saved);
            *saved = now;
        }
        for triangle in step.before.triangles as u32..self.surface.triangles.len() as u32 {
            self.tree.set(triangle, self.corners_of(triangle));
        }
        for (number, _) in &step.saved {
            self.tree.set(*number, self.corners_of(*number));
        }
        self.journal.done.push(step);
        true
    }

    /// Opens a step that records all following changes.
    pub(super) fn begin_step(&mut self) {
        let before = self.lengths();
        self.journal.done.push(Step { before, ..Step::default() });
    }

    /// Closes the open step as one that can be undone.
    pub(super) fn commit_step(&mut self) {
        self.journal.undone.clear();
    }

    /// Closes the open step as a refinement.
    pub(super) fn commit_refinement(&mut self) {
        self.commit_step();
        if let Some(step) = self.journal.done.last_mut() {
            step.is_refinement = true;
        }
    }

    /// Triangles that cuts have added or changed since the last refinement, ascending.
    pub(super) fn unrefined(&self) -> Vec<u32> {
        let done = &self.journal.done;
        let cuts = &done[done.iter().rposition(|step| step.is_refinement).map_or(0, |last| last + 1)..];
        let count = self.surface.triangles.len();
        let first = cuts.first().map_or(count, |step| step.before.triangles) as u32;
        let mut changed: Vec<u32> = cuts.iter().flat_map(|step| step.saved.iter().map(|(t, _)| *t)).collect();
        changed.retain(|t| *t < first);
        changed.sort_unstable();
        changed.dedup();
        changed.extend(first..count as u32);
        changed
    }

    /// Reverts and discards the open step.
    pub(super) fn revert_step(&mut self) {
        if let Some(mut step) = self.journal.done.pop() {
            self.revert(&mut step);
        }
    }

    /// The old triangles changed by the open step, each once, and the index of the first new triangle.
    pub(super) fn changed(&self) -> (Vec<u32>, usize) {
        let Some(step) = self.journal.done.last() else { return (Vec::new(), self.surface.triangles.len()) };
        let mut changed: Vec<u32> = step.saved.iter().map(|(number, _)| *number).collect();
        changed.sort_unstable();
        changed.dedup();
        (changed, step.before.triangles)
    }

    /// The records before the open step of all old triangles it has changed.
    pub(super) fn previous_triangles(&self) -> Vec<(u32, Triangle)> {
        let mut saved = self.journal.done.last().map_or(Vec::new(), |step| step.saved.clone());
        saved.sort_by_key(|(number, _)| *number); // keeps the first of several in front
        saved.dedup_by_key(|(number, _)| *number);
        saved
    }

    /// Index of the first vertex the open step has added.
    pub(super) fn first_new_vertex(&self) -> u32 {
        self.journal.done.last().map_or(self.surface.points.len(), |step| step.before.points) as u32
    }

    pub(super) fn add_vertex(&mut self, point: Vec3, origin: Origin) -> u32 {
        self.surface.points.push(point);
        self.origins.push(origin);
        self.surface.points.len() as u32 - 1
    }

    /// Adds a triangle without neighbours.
    pub(super) fn add_triangle(&mut self, triangle: Triangle) -> u32 {
        let number = self.surface.triangles.len() as u32;
        self.append(Triangle { links: [3 * number, 3 * number + 1, 3 * number + 2], ..triangle });
        if let Some(step) = self.journal.done.last_mut() {
            step.pieces_of.push(NONE);
        }
        number
    }

    /// Adds a triangle that is a piece of another one.
    pub(super) fn add_piece(&mut self, of: u32, triangle: Triangle) -> u32 {
        let number = self.add_triangle(triangle);
        if let Some(step) = self.journal.done.last_mut() {
            let new = (of as usize).checked_sub(step.before.triangles);
            let whole = new.map_or(of, |new| step.pieces_of[new]);
            step.pieces_of[number as usize - step.before.triangles] = whole;
        }
        number
    }

    /// For each new triangle of the open step the one it is a piece of, or [`NONE`].
    pub(super) fn pieces_of(&self) -> Vec<u32> {
        self.journal.done.last().map_or(Vec::new(), |step| step.pieces_of.clone())
    }

    pub(super) fn set_triangle(&mut self, number: u32, triangle: Triangle) {
        self.save(number);
        self.write_record(number, triangle);
    }

    pub(super) fn set_corner(&mut self, half: u32, vertex: u32) {
        self.save(half / 3);
        self.surface.triangles[half as usize / 3][half as usize % 3] = vertex;
    }

    pub(super) fn set_link(&mut self, half: u32, next: u32) {
        self.save(half / 3);
        self.links[half as usize / 3][half as usize % 3] = next;
    }

    /// Links `halves` as all half-edges of one edge.
    pub(super) fn link_around_edge(&mut self, halves: &[u32]) {
        for (at, &half) in halves.iter().enumerate() {
            self.set_link(half, halves[(at + 1) % halves.len()]);
        }
    }

    fn save(&mut self, number: u32) {
        let record = self.triangle(number);
        if let Some(step) = self.journal.done.last_mut()
            && (number as usize) < step.before.triangles
        {
            step.saved.push((number, record));
        }
    }

    fn lengths(&self) -> Lengths {
        Lengths {
            points: self.surface.points.len(),
            triangles: self.surface.triangles.len(),
            texcoords: self.texcoords.len(),
            normals: self.normals.len(),
        }
    }

    fn revert(&mut self, step: &mut Step) {
        for (number, saved) in step.saved.iter_mut().rev() {
            let now = self.triangle(*number);
            self.write_record(*number, *saved);
            *saved = now;
        }
        let Lengths { points, triangles, texcoords, normals } = step.before;
        for triangle in triangles..self.surface.triangles.len() {
            self.tree.remove(triangle as u32);
            step.tail.triangles.push(self.triangle(triangle as u32));
        }
        let origins = self.origins.drain(points - self.uncut.points..);
        step.tail.points = self.surface.points.drain(points..).zip(origins).collect();
        step.tail.texcoords = self.texcoords.split_off(texcoords);
        step.tail.normals = self.normals.split_off(normals);
        self.surface.triangles.truncate(triangles);
        self.surface.face_of.truncate(triangles);
        self.links.truncate(triangles);
        self.texture.truncate(triangles);
        self.shading.truncate(triangles);
        self.body.truncate(triangles);
        for (number, _) in &step.saved {
            self.tree.set(*number, self.corners_of(*number));
        }
    }

    fn append(&mut self, triangle: Triangle) {
        self.surface.triangles.push(triangle.corners);
        self.surface.face_of.push(triangle.face);
        self.links.push(triangle.links);
        self.texture.push(triangle.texture);
        self.shading.push(triangle.shading);
        self.body.push(triangle.body);
    }

    fn write_record(&mut self, number: u32, triangle: Triangle) {
        let t = number as usize;
        self.surface.triangles[t] = triangle.corners;
        self.surface.face_of[t] = triangle.face;
        self.links[t] = triangle.links;
        self.texture[t] = triangle.texture;
        self.shading[t] = triangle.shading;
        self.body[t] = triangle.body;
    }
}
