//! Momentum where a cut moves mass from one copy of a node to another.
//!
//! A sliver that is left between two cuts becomes part of a fragment beside it in the same cell, and its share of the mass goes from the copies of nodes that it had to those of
//! that fragment. The copies of a node have the same mass together as before, so what the receivers lack in momentum is what came with the mass.

use super::Lattice;
use pliant_solver::{Nodes, Vec3};
use std::collections::HashMap;
use std::ops::Range;

/// Mass and momentum of the copies of a node.
pub(super) struct CopyMomentum {
    /// Sum of the masses of the copies, kg.
    mass: f64,
    /// Sum of the momenta of the copies, kg m/s.
    momentum: Vec3,
    /// Mass of each copy by its number, kg.
    copies: Vec<(u32, f64)>,
}

/// Largest change of a mass that is rounding, as a share of it.
const ROUNDING: f64 = 1e-9;

impl Lattice {
    /// Mass and momentum of nodes with several copies, by their id.
    pub(super) fn copy_momenta(&self, nodes: &Nodes) -> HashMap<u64, CopyMomentum> {
        let ids = &self.region.node_id;
        if !self.has_cuts() || nodes.mass.len() != ids.len() || nodes.v.len() != ids.len() {
            return HashMap::new();
        }
        let mut found = HashMap::new();
        let mut first = 0;
        for group in ids.chunk_by(|a, b| a == b) {
            let range = first..first + group.len();
            first = range.end;
            if range.len() > 1 {
                found.insert(group[0], self.copy_momentum(range, nodes));
            }
        }
        found
    }

    fn copy_momentum(&self, range: Range<usize>, nodes: &Nodes) -> CopyMomentum {
        let mass = range.clone().map(|i| nodes.mass[i]).sum();
        let momentum = range.clone().map(|i| nodes.mass[i] * nodes.v[i]).sum();
        CopyMomentum { mass, momentum, copies: range.map(|i| (self.region.node_copy[i], nodes.mass[i])).collect() }
    }

    /// Gives copies of nodes that have received mass from others its momentum. `before` is from the region before.
    pub(super) fn keep_momenta(&self, before: &HashMap<u64, CopyMomentum>, nodes: &mut Nodes) {
        for (id, before) in before {
            let ids = &self.region.node_id;
            let range = ids.partition_point(|other| other < id)..ids.partition_point(|other| other <= id);
            let now = self.copy_momentum(range.clone(), nodes);
            let is_same_mass = (now.mass - before.mass).abs() <= ROUNDING * before.mass;
            // Elsewhere cells have come or gone with the region, or what holds the node takes up its momentum.
            if range.is_empty() || !is_same_mass || range.clone().any(|i| !nodes.constraint[i].is_free()) {
                continue;
            }
            let mass_before = |copy: u32| before.copies.iter().find(|(other, _)| *other == copy).map(|(_, mass)| *mass);
            let has_received = |i: &usize| {
                mass_before(self.region.node_copy[*i]).is_some_and(|mass| nodes.mass[*i] > (1.0 + ROUNDING) * mass)
            };
            let mut receivers: Vec<usize> = range.clone().filter(has_received).collect();
            if receivers.is_empty() {
                receivers = range.collect();
            }
            let mass: f64 = receivers.iter().map(|i| nodes.mass[*i]).sum();
            let missing = before.momentum - now.momentum;
            receivers.into_iter().for_each(|i| nodes.v[i] += missing / mass);
        }
    }
}
