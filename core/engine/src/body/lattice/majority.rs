//! Corrects the fragment of surface points by their neighbours, after a cut.
//!
//! The fragment in which a point is embedded follows from the voxels of its cell, whose resolution is limited: beside a cut it can be the
//! wrong one. The mesh is exact: the corners of a triangle are on one side of every cut. So a point is moved to the fragment of its
//! neighbours where most of them are embedded in another one.

use super::Lattice;
use super::fragments::CellFragment;
use super::point_bindings::BoundPoint;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// The fragment in which each surface point is embedded.
pub(super) type Embeddings = BTreeMap<u32, CellFragment>;

/// Largest number of rounds. One round corrects single points, further ones rows of them.
const ROUNDS: usize = 4;

impl Lattice {
    /// Embeds points anew that are in another fragment than most points they share a triangle with. `containing` has the cell that each
    /// point lies in, `place` gives the rest position at which it is embedded (m), `neighbours` the points it shares a triangle with.
    pub(super) fn rebind_by_majority(
        &mut self,
        mut embeddings: Embeddings,
        containing: &BTreeMap<u32, u64>,
        place: impl Fn(u32) -> Vec3,
        neighbours: impl Fn(u32) -> Vec<u32>,
    ) {
        for _ in 0..ROUNDS {
            let mut moves = Vec::new();
            for (&point, &fragment) in &embeddings {
                let (mut same, mut others) = (0, BTreeMap::<CellFragment, usize>::new());
                for neighbour in neighbours(point) {
                    let Some(&other) = embeddings.get(&neighbour) else { continue };
                    match self.fragments.are_connected(fragment, other) {
                        Some(true) => same += 1,
                        Some(false) => *others.entry(other).or_default() += 1,
                        None => {}
                    }
                }
                let most = others.iter().max_by_key(|(_, count)| **count);
                if let Some((other, _)) = most.filter(|_| others.values().sum::<usize>() > same) {
                    moves.push((point, *other));
                }
            }
            if moves.is_empty() {
                return;
            }
            for (point, fragment) in moves {
                let old_cell = embeddings.insert(point, fragment).map_or(fragment.cell, |old| old.cell);
                self.bindings.remove(point);
                self.fragments.release_point(old_cell, point);
                let anchor = self.fragments.anchor_in(fragment, place(point));
                self.bind(BoundPoint { point, containing: containing[&point] }, &anchor);
            }
        }
    }
}
