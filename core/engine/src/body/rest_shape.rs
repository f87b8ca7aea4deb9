//! The shape of a body at rest as a value: differences of two, sums, and the body in another one.
//!
//! It is what edits that keep their shape have made: displacements of the vertices and, of a lattice, of the nodes with their jets. All of these
//! are linear, so a sum of differences is a shape at rest too, as long as it turns no cell inside out.

use super::lattice::{NodeKey, RestOffset, RestOffsets};
use super::state::DiscretizationState;
use super::{Body, Discretization, LatticeError};
use pliant_solver::Vec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Smallest area of a triangle of a sheet at rest, relative to that in the file: a flat one has no directions of warp and weft.
const MIN_AREA: f64 = 1e-3;

/// The shape of a body at rest.
#[derive(Clone)]
pub struct RestShape {
    /// Positions of the vertices, m (n x 3).
    settled: Arc<Vec<Vec3>>,
    /// Changes by edits at the nodes of a lattice; empty for a sheet, whose nodes are its vertices.
    offsets: Arc<RestOffsets>,
}

/// The difference of two shapes at rest of a body with the same connectivity in both. Equal vertices and nodes are not stored.
#[derive(Clone, Default)]
pub struct RestDifference {
    /// Displacement of each vertex that differs, m.
    vertices: BTreeMap<u32, Vec3>,
    /// Difference of the offset of each lattice node that differs.
    nodes: BTreeMap<NodeKey, RestOffset>,
}

/// Cells or triangles that a shape at rest would turn inside out or flatten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatPart {
    /// `cells` of a lattice or `triangles` of a sheet.
    pub parts: &'static str,
    /// Number of these cells or triangles.
    pub count: usize,
    /// Place of the first in the model, m.
    pub place: Vec3,
}

impl RestShape {
    /// The difference from an earlier shape of the same body to this one.
    pub fn since(&self, before: &Self) -> RestDifference {
        let mut difference = RestDifference::default();
        if !Arc::ptr_eq(&self.settled, &before.settled) {
            let pairs = self.settled.iter().zip(before.settled.iter()).enumerate();
            let moved = pairs.filter(|(_, (now, then))| now != then);
            difference.vertices = moved.map(|(vertex, (now, then))| (vertex as u32, now - then)).collect();
        }
        for (key, now) in self.offsets.iter() {
            let then = before.offsets.get(key).copied().unwrap_or_else(|| RestOffset::zero(now.place));
            if *now != then {
                difference.nodes.insert(*key, now.plus(&then, -1.0));
            }
        }
        for (key, then) in before.offsets.iter().filter(|(key, _)| !self.offsets.contains_key(key)) {
            difference.nodes.insert(*key, RestOffset::zero(then.place).plus(then, -1.0));
        }
        difference
    }

    /// Adds `factor` times a difference.
    pub fn add(&mut self, difference: &RestDifference, factor: f64) {
        if factor == 0.0 || difference.is_empty() {
            return;
        }
        let (settled, offsets) = (Arc::make_mut(&mut self.settled), Arc::make_mut(&mut self.offsets));
        for (&vertex, d) in &difference.vertices {
            settled[vertex as usize] += factor * d;
        }
        for (key, d) in &difference.nodes {
            add_offset(offsets, *key, d, factor);
        }
    }

    /// Sets the vertices and nodes of `changed` to those of `now` minus `layers`, each a difference with its factor; the others stay.
    pub fn go_below<'a>(
        &mut self,
        now: &Self,
        changed: &RestDifference,
        layers: impl Iterator<Item = (&'a RestDifference, f64)>,
    ) {
        let (settled, offsets) = (Arc::make_mut(&mut self.settled), Arc::make_mut(&mut self.offsets));
        for &vertex in changed.vertices.keys() {
            settled[vertex as usize] = now.settled[vertex as usize];
        }
        for key in changed.nodes.keys() {
            match now.offsets.get(key) {
                Some(offset) => offsets.insert(*key, *offset),
                None => offsets.remove(key),
            };
        }
        for (difference, factor) in layers {
            for (&vertex, d) in difference.vertices.iter().filter(|(vertex, _)| changed.vertices.contains_key(vertex)) {
                settled[vertex as usize] -= factor * d;
            }
            for (key, d) in difference.nodes.iter().filter(|(key, _)| changed.nodes.contains_key(key)) {
                add_offset(offsets, *key, d, -factor);
            }
        }
    }
}

/// Adds `factor` times `d` to the offset of a node; offsets of zero are left out.
fn add_offset(offsets: &mut RestOffsets, key: NodeKey, d: &RestOffset, factor: f64) {
    let sum = offsets.get(&key).copied().unwrap_or_else(|| RestOffset::zero(d.place)).plus(d, factor);
    if sum.is_zero() {
        offsets.remove(&key);
    } else {
        offsets.insert(key, sum);
    }
}

impl RestDifference {
    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty() && self.nodes.is_empty()
    }

    /// Number of vertices that differ.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Adds another difference.
    pub fn add(&mut self, other: &Self) {
        for (vertex, d) in &other.vertices {
            *self.vertices.entry(*vertex).or_default() += d;
        }
        for (key, d) in &other.nodes {
            let sum = self.nodes.get(key).copied().unwrap_or_else(|| RestOffset::zero(d.place)).plus(d, 1.0);
            self.nodes.insert(*key, sum);
        }
    }
}

impl Body {
    /// The present shape at rest.
    pub fn rest_shape(&self) -> RestShape {
        let offsets = self.discretization.lattice().map(|lattice| lattice.all_rest_offsets());
        RestShape { settled: Arc::clone(&self.skin.settled), offsets: Arc::new(offsets.unwrap_or_default()) }
    }

    /// Cells or triangles that `shape` would turn inside out or flatten, among those that `changed` moves; `None` if there are none.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn flat_parts(&self, shape: &RestShape, changed: &RestDifference) -> Result<Option<FlatPart>, LatticeError> {
        let (parts, places) = match &self.discretization {
            Discretization::Lattice(lattice) => {
                let places = changed.nodes.values().map(|offset| offset.place);
                ("cells", lattice.tangled_at_rest(&shape.offsets, places)?)
            }
            Discretization::Sheet(_) => ("triangles", self.flat_triangles(shape, changed)),
        };
        Ok(places.first().map(|place| FlatPart { parts, count: places.len(), place: *place }))
    }

    /// First corners (m, in the model) of the triangles that `shape` would flatten, among those that `changed` moves.
    fn flat_triangles(&self, shape: &RestShape, changed: &RestDifference) -> Vec<Vec3> {
        let surface = &self.model.surface;
        let mut near: Vec<u32> = changed.vertices.keys().flat_map(|v| self.model.around(*v)).copied().collect();
        near.sort_unstable();
        near.dedup();
        let area = |triangle: u32, points: &[Vec3]| {
            let [a, b, c] = surface.triangles[triangle as usize].map(|v| points[v as usize]);
            (b - a).cross(&(c - a)).norm()
        };
        let is_flat = |t: &u32| {
            let now = area(*t, &shape.settled);
            now < MIN_AREA * area(*t, &surface.points) || now.is_nan()
        };
        let corner = |t: u32| surface.points[surface.triangles[t as usize][0] as usize];
        near.into_iter().filter(is_flat).map(corner).collect()
    }

    /// Gives the body another shape at rest, at once: nodes move with their rest positions, so what deforms the body stays. On an error the
    /// body is as it was.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn set_rest_shape(&mut self, shape: &RestShape) -> Result<(), LatticeError> {
        let before = self.save();
        let mut state = before.clone();
        state.settled = Arc::clone(&shape.settled);
        match (&self.discretization, &mut state.discretization) {
            (Discretization::Lattice(lattice), DiscretizationState::Lattice(saved)) => {
                saved.set_rest_offsets(&shape.offsets);
                lattice.move_to_offsets(&shape.offsets, &mut state.nodes);
            }
            (Discretization::Sheet(sheet), _) => {
                for node in 0..state.nodes.len() {
                    let Some(vertex) = sheet.vertex_of(node as u32) else { continue };
                    let rest = shape.settled[vertex as usize];
                    if rest == self.skin.settled[vertex as usize] {
                        continue; // a node and its vertex may differ by rounding
                    }
                    state.nodes.x[node] += rest - state.nodes.rest[node];
                    state.nodes.rest[node] = rest;
                }
            }
            (Discretization::Lattice(_), DiscretizationState::Sheet(_)) => {} // a body never changes its discretization
        }
        let taken = self.restore(&state).and_then(|()| match &mut self.discretization {
            // Masses and material coordinates are those of the new shape.
            Discretization::Sheet(sheet) if !state.nodes.is_empty() => {
                sheet.flatten_rest(&self.model, &mut self.system)
            }
            Discretization::Lattice(_) | Discretization::Sheet(_) => Ok(()),
        });
        taken.or_else(|error| self.restore(&before).and(Err(error)))
    }
}
