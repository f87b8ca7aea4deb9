//! A viewer's copy of a body's surface, for drawing and picking.
//!
//! It is updated from frames and topology patches and reports the changes, so that only changed vertices of a large surface are uploaded.

mod adjacency;
mod cut_normals;
mod edges;
mod normals;
mod pick;
mod split;

pub use pick::{Hit, Picker};
pub use split::DrawnVertex;

use adjacency::Adjacency;
use cut_normals::{KeptNormal, ShownBefore};
use normals::Facet;
use pliant_engine::body::TriangleLook;
use pliant_live::{BodyTopology, BodyView, TopologyPatch};
use pliant_solver::Vec3;
use std::collections::HashMap;
use std::ops::Range;

/// The surface of a body for drawing.
///
/// A mesh vertex has several *drawn vertices* if hard edges, texture seams or materials meet at it; they share its position, and each has its own normal and
/// texture coordinates.
pub struct ViewSurface {
    /// Name of the body in the scene.
    pub name: String,
    /// Point of the scene that positions are relative to, m.
    pub origin: Vec3,
    /// Positions of mesh vertices relative to the origin, m (n x 3).
    positions: Vec<[f32; 3]>,
    /// Distance of each mesh vertex from its rest position, m (n).
    displacements: Vec<f32>,
    /// Tint of each mesh vertex: what is pinned or painted there (n).
    tints: Vec<f32>,
    triangles: Vec<Option<TriangleLook>>,
    /// Normal and angles of each triangle, for the places that `refresh` has seen last.
    facets: Vec<Facet>,
    around: Adjacency,
    /// Drawn vertices of a mesh vertex: `drawn[first..first + count]` (n).
    span_of: Vec<(u32, u32)>,
    drawn: Vec<DrawnVertex>,
    /// Unit normal of each drawn vertex; zero if all of its triangles are degenerate.
    normals: Vec<[f32; 3]>,
    /// Drawn vertex at each corner of each triangle; three times the same vertex for an invisible triangle.
    corners: Vec<[u32; 3]>,
    /// Number of vertices at the opening: later ones are made by cuts.
    opened: usize,
    /// Normals that were shown at vertices before they were at a cut.
    kept_normals: HashMap<u32, Vec<KeptNormal>>,
    /// Number of the last frame that was applied.
    frame: u64,
    /// Vertices whose normals must be updated, each once.
    dirty: Vec<u32>,
    is_dirty: Vec<bool>,
    /// Triangles whose facets must be updated, each once.
    stale: Vec<u32>,
    is_stale: Vec<bool>,
}

/// Changes of the drawn surface by a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceChanges {
    /// Ranges of drawn vertices with a changed position, normal or displacement; ascending and disjoint.
    pub vertices: Vec<Range<usize>>,
    /// Ranges of drawn vertices that are new or have changed texture coordinates or material; ascending.
    pub looks: Vec<Range<usize>>,
    /// Ranges of triangles that are new or have changed corners; ascending.
    pub triangles: Vec<Range<usize>>,
    /// Mesh vertices that have moved or changed their tint, ascending.
    pub moved: Vec<u32>,
}

impl SurfaceChanges {
    /// Whether there are no changes.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty() && self.looks.is_empty() && self.triangles.is_empty()
    }
}

/// Largest gap between ranges that are merged, in vertices, because an upload call costs more than a few vertices.
const GAP: usize = 64;

impl ViewSurface {
    /// The surface of a body at the opening of its session.
    pub fn new(topology: &BodyTopology) -> Self {
        let triangles = topology.triangles.as_ref().clone();
        let count = topology.positions.len();
        let mut surface = Self {
            name: topology.name.clone(),
            origin: topology.origin,
            positions: topology.positions.clone(),
            displacements: vec![0.0; count],
            tints: vec![0.0; count],
            around: Adjacency::new(count, &triangles),
            corners: vec![[0; 3]; triangles.len()],
            facets: vec![Facet::default(); triangles.len()],
            stale: Vec::new(),
            is_stale: vec![false; triangles.len()],
            triangles,
            span_of: vec![(0, 0); count],
            drawn: Vec::with_capacity(count),
            normals: Vec::new(),
            opened: count,
            kept_normals: HashMap::new(),
            frame: 0,
            dirty: Vec::new(),
            is_dirty: vec![false; count],
        };
        for vertex in 0..count as u32 {
            surface.split(vertex);
        }
        surface.normals = vec![[0.0; 3]; surface.drawn.len()];
        for triangle in 0..surface.triangles.len() as u32 {
            surface.update_facet(triangle);
        }
        for vertex in 0..count as u32 {
            surface.update_normals(vertex);
        }
        surface
    }

    /// The surface of a body that has become one of its own in a session, in which `view` is its first frame: empty before that is applied.
    pub fn of_new_body(name: String, view: &BodyView) -> Self {
        Self::new(&BodyTopology { name, origin: view.origin, moves: true, ..BodyTopology::default() })
    }

    /// Positions of mesh vertices relative to the origin, m (n x 3).
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Appearance of each triangle; `None` if it is invisible.
    pub fn triangles(&self) -> &[Option<TriangleLook>] {
        &self.triangles
    }

    /// The drawn vertices.
    pub fn drawn(&self) -> &[DrawnVertex] {
        &self.drawn
    }

    /// Unit normals of the drawn vertices.
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// Drawn vertices at the corners of the triangles.
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// Position of a drawn vertex relative to the origin, m; zero if undoing a cut has removed its mesh vertex.
    pub fn position(&self, drawn: usize) -> [f32; 3] {
        self.positions.get(self.drawn[drawn].vertex as usize).copied().unwrap_or_default()
    }

    /// Distance of a drawn vertex from its rest position, m.
    pub fn displacement(&self, drawn: usize) -> f32 {
        self.displacements.get(self.drawn[drawn].vertex as usize).copied().unwrap_or_default()
    }

    /// Tint of a drawn vertex, as [`pliant_engine::body::Body::tints`]; 0 where nothing is pinned or painted.
    pub fn tint(&self, drawn: usize) -> f32 {
        self.tints.get(self.drawn[drawn].vertex as usize).copied().unwrap_or_default()
    }

    /// Positions of a triangle's corners in the scene, m; `None` if it is invisible.
    pub fn corner_places(&self, triangle: u32) -> Option<[Vec3; 3]> {
        let look = self.triangles.get(triangle as usize)?.as_ref()?;
        Some(look.corners.map(|v| self.place(v)))
    }

    /// Position of a mesh vertex in the scene, m.
    fn place(&self, vertex: u32) -> Vec3 {
        let [x, y, z] = self.positions[vertex as usize].map(f64::from);
        self.origin + Vec3::new(x, y, z)
    }

    /// Triangles around a mesh vertex.
    pub fn around(&self, vertex: u32) -> &[u32] {
        self.around.of(vertex)
    }

    /// Applies a newer frame with the patches of this body up to it. Returns the changes.
    pub fn update(&mut self, number: u64, view: &BodyView, patches: &[TopologyPatch]) -> SurfaceChanges {
        let mut changes = SurfaceChanges::default();
        let moved_pages: Vec<Range<usize>> = view.changed_after(self.frame).collect();
        self.frame = number;
        self.resize(view.positions.len());
        for range in moved_pages {
            for vertex in range {
                let (place, displacement) = (view.positions[vertex], view.displacements[vertex]);
                let is_painted = view.tints[vertex] != self.tints[vertex];
                self.tints[vertex] = view.tints[vertex];
                if is_painted || place != self.positions[vertex] || displacement != self.displacements[vertex] {
                    self.positions[vertex] = place;
                    self.displacements[vertex] = displacement;
                    changes.moved.push(vertex as u32);
                }
            }
        }
        // A patch may name vertices that a later one has taken away again.
        let corners =
            patches.iter().flat_map(|patch| &patch.changed).filter_map(|(_, look)| Some(look.as_ref()?.corners));
        let most = corners.flatten().map(|vertex| vertex as usize + 1).max().unwrap_or(0);
        self.resize(most.max(view.positions.len()));
        for patch in patches {
            self.patch(patch, &mut changes);
        }
        self.resize(view.positions.len());
        self.dirty.retain(|vertex| (*vertex as usize) < view.positions.len());
        self.refresh(&mut changes);
        changes
    }

    /// Sets the number of mesh vertices.
    fn resize(&mut self, count: usize) {
        self.positions.resize(count, [0.0; 3]);
        self.displacements.resize(count, 0.0);
        self.tints.resize(count, 0.0);
        self.span_of.resize(count, (0, 0));
        self.is_dirty.resize(count, false);
    }

    /// Updates normals around moved vertices and lists the changed drawn vertices.
    fn refresh(&mut self, changes: &mut SurfaceChanges) {
        for at in 0..changes.moved.len() {
            let vertex = changes.moved[at];
            self.mark(vertex);
            for place in 0..self.around.of(vertex).len() {
                let triangle = self.around.of(vertex)[place];
                if std::mem::replace(&mut self.is_stale[triangle as usize], true) {
                    continue;
                }
                self.stale.push(triangle);
                if let Some(look) = self.triangles[triangle as usize] {
                    look.corners.iter().for_each(|corner| self.mark(*corner));
                }
            }
        }
        for triangle in std::mem::take(&mut self.stale) {
            self.is_stale[triangle as usize] = false;
            self.update_facet(triangle);
        }
        let mut dirty = std::mem::take(&mut self.dirty);
        dirty.sort_unstable();
        let mut touched = Vec::with_capacity(dirty.len());
        for &vertex in &dirty {
            self.is_dirty[vertex as usize] = false;
            self.update_normals(vertex);
            let (first, count) = self.span_of[vertex as usize];
            touched.push(first as usize..(first + count) as usize);
        }
        dirty.clear();
        self.dirty = dirty;
        changes.vertices = merge(touched, GAP);
        changes.looks = merge(std::mem::take(&mut changes.looks), GAP);
        // A later patch of the same update may have taken triangles away again.
        let count = self.corners.len();
        let ranges = changes.triangles.drain(..).map(|range| range.start.min(count)..range.end.min(count));
        changes.triangles = merge(ranges.collect(), GAP);
    }

    fn mark(&mut self, vertex: u32) {
        if let Some(mark) = self.is_dirty.get_mut(vertex as usize)
            && !*mark
        {
            *mark = true;
            self.dirty.push(vertex);
        }
    }

    /// Applies the changes of a cut.
    fn patch(&mut self, patch: &TopologyPatch, changes: &mut SurfaceChanges) {
        let before = self.triangles.len();
        let gone = patch.count.min(before)..before;
        let changed = patch.changed.iter().filter(|(t, _)| (*t as usize) < patch.count);
        let (mut vertices, mut shown) = (Vec::new(), ShownBefore::default());
        let old = changed.clone().map(|(t, _)| *t as usize).filter(|t| *t < before).chain(gone);
        for triangle in old {
            self.note_shown(triangle as u32, &mut shown);
            if let Some(look) = self.triangles[triangle].take() {
                for vertex in look.corners {
                    self.around.remove(vertex, triangle as u32);
                    vertices.push(vertex);
                }
            }
        }
        self.triangles.resize(patch.count, None);
        self.corners.resize(patch.count, [0; 3]);
        self.facets.resize(patch.count, Facet::default());
        self.is_stale.resize(patch.count, false);
        if patch.count > before {
            changes.triangles.push(before..patch.count);
        }
        for &(triangle, look) in changed {
            self.triangles[triangle as usize] = look;
            changes.triangles.push(triangle as usize..triangle as usize + 1);
            match look {
                Some(look) => {
                    for vertex in look.corners {
                        self.around.insert(vertex, triangle);
                        vertices.push(vertex);
                    }
                }
                None => self.corners[triangle as usize] = [0; 3],
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        vertices.retain(|v| (*v as usize) < self.positions.len());
        for &vertex in &vertices {
            for place in 0..self.around.of(vertex).len() {
                self.update_facet(self.around.of(vertex)[place]);
            }
        }
        for &vertex in &vertices {
            let (first, count) = self.span_of[vertex as usize];
            self.split(vertex);
            let (new_first, new_count) = self.span_of[vertex as usize];
            self.normals.resize(self.drawn.len(), [0.0; 3]);
            if (first, count) != (new_first, new_count) {
                // The corners of its triangles have changed.
                let around = self.around.of(vertex);
                changes.triangles.extend(around.iter().map(|t| *t as usize..*t as usize + 1));
            }
            changes.looks.push(new_first as usize..(new_first + new_count) as usize);
            self.mark(vertex);
        }
        self.keep_normals(&vertices, &shown);
    }
}

/// Sorts ranges and merges those that touch or are at most `gap` apart.
fn merge(mut ranges: Vec<Range<usize>>, gap: usize) -> Vec<Range<usize>> {
    ranges.retain(|range| !range.is_empty());
    ranges.sort_unstable_by_key(|range| range.start);
    let mut merged: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match merged.last_mut() {
            Some(last) if range.start <= last.end + gap => last.end = last.end.max(range.end),
            _ => merged.push(range),
        }
    }
    merged
}

#[cfg(test)]
mod tests;
