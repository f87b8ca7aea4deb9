//! What strokes have painted on a lattice: pinned nodes, and factors of the material's parameters by cell. Both outlive the region, and the parts of a
//! cut cell inherit them.
//!
//! A surface point is pinned if all corners of its cell are. Where the surface has continuous slopes it also depends on the nodes around these corners,
//! so they are held too. Where a pinned node is away from rest, the region keeps all cells at pinned nodes, and nodes that contacts have left stay free:
//! the shape between pins is an equilibrium and not the rest shape.

use super::fragments::{CellFragment, NodeKey};
use super::{Lattice, LatticeError};
use crate::body::painted_factors::{PaintBall, PaintStroke, PaintedFactors};
use pliant_solver::{Nodes, System, Vec3};
use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

/// Pins and painted factors; shared with saved states until they change.
#[derive(Clone, Default)]
pub(super) struct LatticePaint {
    /// Pinned nodes; those around them are held in a smooth embedding.
    pins: Arc<HashSet<NodeKey>>,
    /// Surface points whose cells have only pinned corners.
    held: Arc<BTreeSet<u32>>,
    /// Factors by the id of a cell.
    pub(super) factors: Arc<PaintedFactors>,
}

impl LatticePaint {
    /// Whether a node is pinned itself.
    pub(super) fn is_pinned_node(&self, key: &NodeKey) -> bool {
        self.pins.contains(key)
    }

    /// Pins a node.
    pub(super) fn pin_node(&mut self, key: NodeKey) {
        Arc::make_mut(&mut self.pins).insert(key);
    }

    /// The paint of a part of a body, whose surface points are `own`.
    pub(super) fn of_part(&self, own: impl Fn(u32) -> bool) -> Self {
        let mut part = self.clone();
        Arc::make_mut(&mut part.held).retain(|point| own(*point));
        part
    }

    /// Pins the copies of pinned nodes.
    pub(super) fn pin_copies<'a>(&mut self, copies: impl Iterator<Item = (&'a NodeKey, &'a NodeKey)>) {
        for (copy, original) in copies {
            if self.pins.contains(original) {
                Arc::make_mut(&mut self.pins).insert(*copy);
            }
        }
    }
}

impl Lattice {
    /// Painted factors, by the id of a cell.
    pub fn painted(&self) -> &PaintedFactors {
        &self.paint.factors
    }

    /// Pinned surface points, ascending.
    pub fn pinned_points(&self) -> impl Iterator<Item = u32> + '_ {
        self.paint.held.iter().copied()
    }

    /// Whether a surface point is pinned.
    pub fn is_pinned(&self, point: u32) -> bool {
        self.paint.held.contains(&point)
    }

    /// Pins (or frees) the nodes of a ball and those that the surface points in it, `settled` (m), are embedded in. Nodes are held from the next
    /// [`Lattice::follow`] on. Returns whether any node has changed.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn change_pins(
        &mut self,
        ball: PaintBall<'_>,
        settled: &[Vec3],
        pins: bool,
    ) -> Result<bool, LatticeError> {
        let mut chosen = vec![false; self.region.node_id.len()];
        ball.nodes.iter().for_each(|n| chosen[*n as usize] = true);
        for (cell, corners) in self.region.cell_corners.iter().enumerate() {
            let is_near = corners.iter().any(|n| ball.nodes.binary_search(n).is_ok());
            let is_inside = |v: &u32| (settled[*v as usize] - ball.centre).norm() <= ball.radius;
            if is_near && self.points(cell as u32)?.iter().any(is_inside) {
                corners.iter().for_each(|n| chosen[*n as usize] = true);
            }
        }
        let keys = (0..chosen.len() as u32).filter(|n| chosen[*n as usize]).map(|n| self.node_key(n));
        let keys: Vec<NodeKey> = keys.filter(|key| self.paint.pins.contains(key) != pins).collect();
        if keys.is_empty() {
            return Ok(false);
        }
        let known = Arc::make_mut(&mut self.paint.pins);
        for key in keys {
            if pins {
                known.insert(key)
            } else {
                known.remove(&key)
            };
        }
        let mut held = std::mem::take(&mut self.paint.held);
        let list = Arc::make_mut(&mut held);
        for (cell, corners) in self.region.cell_corners.iter().enumerate() {
            if !corners.iter().any(|n| chosen[*n as usize]) {
                continue;
            }
            let is_held = corners.iter().all(|n| self.paint.pins.contains(&self.node_key(*n)));
            for point in self.points(cell as u32)? {
                if is_held {
                    list.insert(*point)
                } else {
                    list.remove(point)
                };
            }
        }
        self.paint.held = held;
        self.needs_rebuild = true;
        Ok(true)
    }

    /// Finds the active nodes that pins hold, after nodes have got their positions.
    pub(super) fn find_pinned(&mut self, nodes: &Nodes) {
        self.pinned.clear();
        self.keeps_displaced = self.has_history;
        if self.paint.pins.is_empty() {
            return;
        }
        let own: Vec<bool> = (0..nodes.x.len() as u32).map(|n| self.paint.pins.contains(&self.node_key(n))).collect();
        self.pinned.clone_from(&own);
        if self.smooth.is_some() {
            let around = self.region.cell_corners.iter().filter(|corners| corners.iter().any(|n| own[*n as usize]));
            around.flatten().for_each(|n| self.pinned[*n as usize] = true);
        }
        let is_away = |(i, pinned): (usize, &bool)| *pinned && nodes.x[i] != nodes.rest[i];
        self.keeps_displaced |= self.pinned.iter().enumerate().any(is_away);
    }

    /// Whether any node is pinned.
    pub(super) fn has_pins(&self) -> bool {
        !self.paint.pins.is_empty()
    }

    /// Whether pins hold an active node.
    pub(super) fn holds(&self, node: usize) -> bool {
        self.pinned.get(node).copied().unwrap_or(false)
    }

    /// Moves the factors of the cells that a stroke reaches, and gives them to the elements. In a layer the point of the surface over a cell has the
    /// distance that its weight follows from. The material has `planes` parameters. Returns whether any factor has changed.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(in crate::body) fn paint(
        &mut self,
        stroke: &PaintStroke<'_>,
        planes: usize,
        system: &mut System,
    ) -> Result<bool, LatticeError> {
        let cells = self.region.cell_id.iter().copied().zip(self.region.cell_corners.iter().copied());
        let (layer, edge) = (stroke.layer.as_ref(), self.facts.edge);
        let place = |_, middle| layer.map_or(Some(middle), |layer| layer.point_over(middle, edge));
        let rest = &system.nodes.rest;
        let mut cells = match self.source.plugin() {
            Some(_) => stroke.weights(cells, rest, place),
            None => stroke.weights(cells.map(|(id, [a, b, c, d, ..])| (id, [a, b, c, d])), rest, place),
        };
        // Fragments of a cell have the factor of the cell.
        cells.dedup_by_key(|(id, _)| *id);
        if !Arc::make_mut(&mut self.paint.factors).approach(cells.into_iter(), planes, stroke.change) {
            return Ok(false);
        }
        self.list_fields(system);
        system.renew_parameters()?;
        super::check_mass(system)?;
        Ok(true)
    }

    /// Calls `each` with every surface point of the cell with this id.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn for_points_of_cell(&self, id: u64, mut each: impl FnMut(u32)) -> Result<(), LatticeError> {
        if self.fragments.contains(id) {
            let parts = (0..).map_while(|fragment| self.fragments.part(CellFragment { cell: id, fragment }));
            parts.flatten().for_each(|point| each(*point));
            return Ok(());
        }
        self.source.points_of(self.settings.level, id)?.iter().for_each(|point| each(*point));
        Ok(())
    }
}
