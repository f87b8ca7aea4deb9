//! What strokes have painted on a sheet: pinned vertices, and factors of the material's parameters by triangle. Pieces of a cut triangle inherit its
//! factors; a vertex that a cut makes between pinned or fixed ones is pinned.

use super::{GHOST_MASS, Sheet, sorted};
use crate::body::lattice::{LatticeError, check_mass};
use crate::body::model::Model;
use crate::body::painted_factors::{PaintStroke, PaintedFactors};
use pliant_solver::{Constraint, Nodes, System, Vec3};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Pins and painted factors; shared with saved states until they change.
#[derive(Clone, Default)]
pub(super) struct SheetPaint {
    /// Vertices of the model that a stroke has pinned, ascending.
    pub(super) pins: Arc<BTreeSet<u32>>,
    /// Factors by triangle of the model.
    pub(super) factors: Arc<PaintedFactors>,
}

/// Triangles on both sides of each edge, as elements, by the nodes of the edge.
pub(super) type Sides = HashMap<[u32; 2], Vec<u32>>;

impl Sheet {
    /// Painted factors, by triangle.
    pub fn painted(&self) -> &PaintedFactors {
        &self.paint.factors
    }

    /// Pinned vertices, ascending.
    pub fn pinned_vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.paint.pins.iter().copied()
    }

    /// Whether a vertex is pinned.
    pub fn is_pinned(&self, vertex: u32) -> bool {
        self.paint.pins.contains(&vertex)
    }

    /// Pins (or frees) nodes; nodes that the scene fixes are left alone. Returns whether any has changed.
    pub(in crate::body) fn change_pins(&mut self, chosen: &[u32], nodes: &mut Nodes, pins: bool) -> bool {
        let mut has_changed = false;
        for &node in chosen {
            let Some(vertex) = self.vertex_of(node) else { continue };
            let (i, is_pinned) = (node as usize, self.is_pinned(vertex));
            if is_pinned == pins || pins && !nodes.constraint[i].is_free() {
                continue;
            }
            has_changed = true;
            let known = Arc::make_mut(&mut self.paint.pins);
            if pins {
                known.insert(vertex)
            } else {
                known.remove(&vertex)
            };
            nodes.constraint[i] = if pins { Constraint::Fixed } else { Constraint::Free };
            (nodes.v[i], nodes.prescribed[i]) = (Vec3::zeros(), Vec3::zeros());
        }
        self.has_changed |= has_changed;
        has_changed
    }

    /// Moves the factors of the triangles that a stroke reaches, and gives them to the elements; with a layer those of its side alone, whatever its
    /// thickness. The material has `planes` parameters. Returns whether any factor has changed.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(in crate::body) fn paint(
        &mut self,
        stroke: &PaintStroke<'_>,
        planes: usize,
        model: &Model,
        system: &mut System,
    ) -> Result<bool, LatticeError> {
        let triangles = self.triangle_of.iter().map(|t| (u64::from(*t), self.nodes_of(model, *t)));
        let is_painted = |t: u64| stroke.layer.as_ref().is_none_or(|layer| layer.has(t as u32));
        let place = |t, middle| is_painted(t).then_some(middle);
        let triangles = stroke.weights(triangles, &system.nodes.rest, place);
        if !Arc::make_mut(&mut self.paint.factors).approach(triangles.into_iter(), planes, stroke.change) {
            return Ok(false);
        }
        self.renew_parameters(model, system)?;
        Ok(true)
    }

    /// Gives the elements their factors, and has the material compute rest data and masses anew.
    pub(super) fn renew_parameters(&self, model: &Model, system: &mut System) -> Result<(), LatticeError> {
        let triangles = self.triangles(&model.surface);
        self.list_fields(system, &triangles);
        system.renew_parameters()?;
        system.nodes.mass[self.vertex_of.len()..].fill(GHOST_MASS);
        check_mass(system)
    }

    /// Painted factors of the triangle of element `e`; empty where nothing is painted.
    pub(super) fn painted_at(&self, e: u32) -> &[f64] {
        self.paint.factors.get(u64::from(self.triangle_of[e as usize])).unwrap_or(&[])
    }
}

/// The triangles of each edge.
pub(super) fn sides(triangles: &[[u32; 3]]) -> Sides {
    let mut sides = Sides::new();
    for (e, corners) in (0..).zip(triangles) {
        for i in 0..3 {
            sides.entry(sorted([corners[i], corners[(i + 1) % 3]])).or_default().push(e);
        }
    }
    sides
}
