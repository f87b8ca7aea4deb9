//! Changes of the rest shape by a displacement field of the nodes, and the surface at rest that follows.
//!
//! The present shape is not changed: elastic forces then pull the nodes towards the new rest shape.

use super::{Body, Discretization, LatticeError, Moves, Unresolved, limit_folds};
use pliant_solver::Vec3;
use std::sync::Arc;

/// A change of the rest shape.
#[derive(Debug, Default)]
pub struct RestChange {
    /// Displacement of the rest position of each node, m (n x 3).
    pub nodes: Vec<Vec3>,
    /// Vertices with a displacement (m) in addition to the interpolated one of the nodes: details finer than a cell.
    pub points: Vec<(u32, Vec3)>,
}

impl RestChange {
    /// Sets a change of zero for `nodes` nodes.
    pub fn clear(&mut self, nodes: usize) {
        self.nodes.clear();
        self.nodes.resize(nodes, Vec3::zeros());
        self.points.clear();
    }
}

impl Body {
    /// Changes the rest shape. In a lattice `change` is first limited: nodes of cells that it would invert or flatten stay, by the
    /// volume limit of [`super::Lattice::untangle`], and vertices of edges that it would fold move with those around them, or stay.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn reshape(&mut self, change: &mut RestChange) -> Result<(), LatticeError> {
        let Self { model, skin, system, discretization, .. } = self;
        let mut moved: Vec<u32> = Vec::new();
        match discretization {
            Discretization::Lattice(lattice) => {
                lattice.limit_change(&mut change.nodes, &system.nodes.rest);
                let mut moves = Moves::new();
                lattice.move_points(change, &system.nodes.rest, model, &mut moves)?;
                moves.extend_from_slice(&change.points);
                // Stable: the sum of two displacements of a vertex has one order.
                moves.sort_by_key(|(vertex, _)| *vertex);
                moves.dedup_by(|second, first| {
                    let is_same = second.0 == first.0;
                    if is_same {
                        first.1 += second.1;
                    }
                    is_same
                });
                limit_folds(model, &skin.settled, &skin.cell, &mut moves, Unresolved::Stop);
                lattice.move_rest(&change.nodes, &mut system.nodes.rest);
                let settled = Arc::make_mut(&mut skin.settled);
                for (vertex, d) in moves {
                    settled[vertex as usize] += d;
                    moved.push(vertex);
                }
                lattice.list_directions(system);
                system.rest()?;
            }
            Discretization::Sheet(sheet) => {
                let settled = Arc::make_mut(&mut skin.settled);
                for (node, d) in change.nodes.iter().enumerate().filter(|(_, d)| **d != Vec3::zeros()) {
                    system.nodes.rest[node] += *d;
                    if let Some(vertex) = sheet.vertex_of(node as u32) {
                        settled[vertex as usize] = system.nodes.rest[node];
                        moved.push(vertex);
                    }
                }
                for (&vertex, &of) in sheet.welds() {
                    if settled[vertex as usize] != settled[of as usize] {
                        settled[vertex as usize] = settled[of as usize];
                        moved.push(vertex);
                    }
                }
                sheet.flatten_rest(model, system)?;
            }
        }
        let mut triangles: Vec<u32> = moved.iter().flat_map(|v| model.around(*v)).copied().collect();
        triangles.sort_unstable();
        triangles.dedup();
        Arc::make_mut(&mut skin.tree).refit(&skin.settled, &model.surface.triangles, &triangles);
        // Faces that have come to light are at nodes, whose rest positions have moved.
        if !self.failed_triangles.is_empty() || !self.failed_triangles.exposed().triangles().is_empty() {
            self.failed_triangles.outdate();
        }
        Ok(())
    }
}
