//! The surface of a solid whose elements have failed: triangles of failed elements go, and pieces of them that are left and faces that have come to light are
//! added behind the others.
//!
//! What is shown follows from which elements have failed and not from the order in which they did: faces that have come to light are taken away
//! and found anew at every change. Their vertices are nodes, or lie on edges between two.

use super::lattice::{BrokenSurface, ExposedCorner, NodePlace};
use super::{Body, Discretization, LatticeError, Samples};
use pliant_plugin_api::abi;
use pliant_solver::{ElementSet, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Faces of a body that have come to light where elements have failed, and pieces of triangles that were partly on those.
#[derive(Clone, Debug, Default)]
pub struct ExposedFaces {
    /// Number of vertices of the body without those of the faces.
    first_vertex: u32,
    /// Number of triangles of the body without the faces.
    first_triangle: u32,
    /// Corners of the triangles, counter-clockwise seen from outside, as vertices; they are the last of the body (f x 3).
    triangles: Vec<[u32; 3]>,
    /// The triangle of the surface of which each is a piece, `None` for a face that has come to light (f).
    of: Vec<Option<u32>>,
    /// Where the vertices of the faces are that the body had not before.
    places: Vec<NodePlace>,
}

impl ExposedFaces {
    /// Corners of the triangles, counter-clockwise seen from outside, as vertices of the body (f x 3).
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The triangle of the surface of which each triangle is a piece, `None` for one of a face that has come to light (f).
    pub fn pieces_of(&self) -> &[Option<u32>] {
        &self.of
    }

    /// The triangle of the surface of which a triangle of the body is a piece.
    pub fn piece_of(&self, triangle: u32) -> Option<u32> {
        let index = triangle.checked_sub(self.first_triangle)?;
        self.of.get(index as usize).copied().flatten()
    }

    /// The first vertex of the body that is of these faces alone; they are the last ones. `None` where no face has come to light.
    pub fn first_vertex(&self) -> Option<u32> {
        (!self.triangles.is_empty()).then_some(self.first_vertex)
    }

    /// Nodes that carry the vertices that are of these faces alone, in their order, with their weights.
    pub(crate) fn carriers(&self) -> impl Iterator<Item = [(u32, f64); 3]> + '_ {
        self.places.iter().map(|at| [0, 1, 2].map(|i| (at.nodes[i], at.weights[i])))
    }

    /// Vertices of the body that are of these faces alone.
    pub(crate) fn vertices(&self) -> std::ops::Range<u32> {
        self.first_vertex..self.first_vertex + self.places.len() as u32
    }
}

impl Body {
    /// Takes the faces away that have come to light, before the model changes otherwise or other elements have failed.
    pub(super) fn withdraw_exposed_faces(&mut self) {
        let ExposedFaces { first_vertex, triangles, .. } = std::mem::take(&mut self.failed_triangles.exposed);
        if triangles.is_empty() {
            return;
        }
        let known = self.model.surface.triangles.len();
        let count = known - triangles.len();
        let model = Arc::make_mut(&mut self.model);
        model.truncate(first_vertex as usize, count);
        model.measure_edges(triangles.iter().flatten().copied().filter(|v| *v < first_vertex));
        let mut settled = std::mem::take(&mut self.skin.settled);
        Arc::make_mut(&mut settled).truncate(first_vertex as usize);
        self.skin.take_cut(&self.model, settled, &[], count as u32..known as u32);
        if let Discretization::Lattice(lattice) = &mut self.discretization {
            lattice.withdraw_surface_cells();
        }
        // They are found anew with the next look at the elements.
        self.failed_triangles.outdate();
    }

    /// Brings the surface of a solid up to date with the tetrahedra that have failed. Returns whether it has changed.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn update_broken_surface(&mut self) -> Result<bool, LatticeError> {
        let can_fail = |set: &&ElementSet| set.request().kind == abi::TETRAHEDRON && set.has(abi::CAN_FAIL);
        let Some(set) = self.system.sets.iter().find(can_fail) else { return Ok(false) };
        let Discretization::Lattice(lattice) = &self.discretization else { return Ok(false) };
        if !lattice.lists_all_tetrahedra(set.nodes()) || !self.failed_triangles.take_changes(set.failed_changes()) {
            return Ok(false);
        }
        let shows_failure = lattice.has_failed_cells() || !self.failed_triangles.is_empty();
        if set.failed_count() == 0 && !shows_failure && self.failed_triangles.exposed.triangles.is_empty() {
            let Discretization::Lattice(lattice) = &mut self.discretization else { return Ok(false) };
            lattice.prepare_failure(set.nodes(), &self.model)?;
            return Ok(false);
        }
        self.withdraw_exposed_faces();
        let Self { system, discretization: Discretization::Lattice(lattice), model, .. } = self else {
            return Ok(false);
        };
        let Some(set) = system.sets.iter().find(can_fail) else { return Ok(false) };
        self.failed_triangles.take_changes(set.failed_changes());
        let mut broken = lattice.break_surface(set.nodes(), set.failed(), model)?;
        broken.is_gone.resize(model.surface.triangles.len(), false);
        let changed = self.failed_triangles.replace(std::mem::take(&mut broken.is_gone));
        let (model, tree) = (Arc::make_mut(model), Arc::make_mut(&mut self.skin.tree));
        for &t in &changed {
            model.pages.mark(t);
            if !self.failed_triangles.contains(t) && !model.is_lid(t) {
                tree.set(t, model.surface.triangles[t as usize].map(|v| self.skin.settled[v as usize]));
            }
        }
        // All of them: where the shape at rest has changed, those that had failed before are in the tree again.
        let gone = (0..model.surface.triangles.len() as u32).filter(|t| self.failed_triangles.contains(*t));
        gone.for_each(|t| tree.remove(t));
        lattice.set_loose(Vec::new());
        self.add_exposed_faces(broken);
        if let Discretization::Lattice(lattice) = &mut self.discretization {
            lattice.measure_longest_edges(&self.model)?;
        }
        self.list_loose_vertices();
        self.sample_broken_surface()?;
        self.update_tints()?;
        Ok(true)
    }

    /// Adds triangles that failure has made behind those of the body.
    fn add_exposed_faces(&mut self, broken: BrokenSurface) {
        let BrokenSurface { places, exposed, .. } = broken;
        if exposed.is_empty() {
            return;
        }
        let (first_vertex, first_triangle) =
            (self.model.surface.points.len() as u32, self.model.surface.triangles.len());
        let vertex = |corner: ExposedCorner| match corner {
            ExposedCorner::Vertex(vertex) => vertex,
            ExposedCorner::Place(place) => first_vertex + place,
        };
        let triangles: Vec<[u32; 3]> = exposed.iter().map(|triangle| triangle.corners.map(vertex)).collect();
        let of: Vec<Option<u32>> = exposed.iter().map(|triangle| triangle.of).collect();
        let points: Vec<Vec3> = places.iter().map(|place| place.rest).collect();
        let Discretization::Lattice(lattice) = &self.discretization else { return };
        let rest = &self.system.nodes.rest;
        let at_rest = |place: &NodePlace| {
            let offset = |n: u32| rest[n as usize] - lattice.grid_rest(n);
            place.moved(place.rest, |n| rest[n as usize], offset)
        };
        let mut settled = std::mem::take(&mut self.skin.settled);
        Arc::make_mut(&mut settled).extend(places.iter().map(at_rest));
        let model = Arc::make_mut(&mut self.model);
        model.add_inner(&points, &triangles);
        for (triangle, of) in (first_triangle..).zip(&of) {
            if let Some(of) = of {
                model.surface.face_of[triangle] = model.surface.face_of[*of as usize];
            }
        }
        let new: Vec<u32> = (first_triangle as u32..self.model.surface.triangles.len() as u32).collect();
        self.skin.take_cut(&self.model, settled, &new, 0..0);
        self.failed_triangles.exposed =
            ExposedFaces { first_vertex, first_triangle: first_triangle as u32, triangles, of, places };
        self.embed_exposed_faces();
    }

    /// Lists the vertices all of whose triangles have failed.
    fn list_loose_vertices(&mut self) {
        let Self { model, failed_triangles, discretization: Discretization::Lattice(lattice), .. } = self else {
            return;
        };
        let gone = (0..model.surface.triangles.len() as u32).filter(|t| failed_triangles.contains(*t));
        let mut loose: Vec<u32> = gone.flat_map(|t| model.surface.triangles[t as usize]).collect();
        loose.sort_unstable();
        loose.dedup();
        loose.retain(|v| model.around(*v).iter().all(|t| failed_triangles.contains(*t)));
        lattice.set_loose(loose);
    }

    /// Pairs of vertices that tetrahedra which are left connect, where some have failed: of each part of them its first vertex with every other.
    pub(super) fn vertices_of_one_part(&self) -> Vec<[u32; 2]> {
        let left = self.discretization.lattice().and_then(super::Lattice::parts_left);
        let Some((part_of, node_of_triangle)) = left else { return Vec::new() };
        let (mut first_of, mut pairs) = (BTreeMap::new(), Vec::new());
        let mut connect = |vertex: u32, node: u32| {
            let first = *first_of.entry(part_of[node as usize]).or_insert(vertex);
            if first != vertex {
                pairs.push([first, vertex]);
            }
        };
        for ((corners, node), t) in self.model.surface.triangles.iter().zip(&node_of_triangle).zip(0..) {
            let node = node.filter(|_| !self.failed_triangles.contains(t));
            node.iter().for_each(|node| corners.iter().for_each(|vertex| connect(*vertex, *node)));
        }
        let exposed = &self.failed_triangles.exposed;
        exposed.vertices().zip(&exposed.places).for_each(|(vertex, place)| connect(vertex, place.nodes[0]));
        pairs
    }

    /// Moves the vertices of faces that have come to light with their nodes.
    pub(crate) fn embed_exposed_faces(&mut self) {
        let (nodes, exposed) = (&self.system.nodes, &self.failed_triangles.exposed);
        for (vertex, place) in exposed.vertices().zip(&exposed.places) {
            let displacement = |n: u32| nodes.x[n as usize] - nodes.rest[n as usize];
            let place = place.moved(self.skin.settled[vertex as usize], |n| nodes.x[n as usize], displacement);
            if self.skin.x[vertex as usize] != place {
                self.skin.x[vertex as usize] = place;
                self.skin.pages.mark(vertex);
            }
        }
    }

    /// Samples the surface anew, if it is sampled, without what has failed and with what has come to light.
    fn sample_broken_surface(&mut self) -> Result<(), LatticeError> {
        let Discretization::Lattice(lattice) = &self.discretization else { return Ok(()) };
        if self.samples.is_empty() {
            return Ok(());
        }
        let surface = &self.model.surface;
        let left = (0..surface.triangles.len() as u32)
            .filter(|t| !self.failed_triangles.contains(*t) && !self.model.is_lid(*t))
            .map(|t| surface.triangles[t as usize].map(|v| surface.points[v as usize]));
        let mut samples = match lattice.has_failed_cells() {
            true => Samples::of_broken(left, lattice)?,
            false => Samples::new(surface, lattice)?,
        };
        if lattice.has_cuts() {
            let cells: Vec<u64> = lattice.cut_cells().collect();
            samples.take_cut(&cells, &self.model, &self.skin, lattice)?;
        }
        self.samples = Arc::new(samples);
        Ok(())
    }
}
