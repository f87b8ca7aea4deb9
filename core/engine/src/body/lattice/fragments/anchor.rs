//! The part of a cell that carries a place.
//!
//! Where a cut passes close to the face of a cell it leaves a slice there that no voxel is in. What lies in the slice is
//! carried by the next cell, where its own side of the cut goes on; else it would follow the other side.

use super::voxels::SIDE;
use super::{CutCell, Fragments};
use pliant_solver::Vec3;
use std::collections::BTreeSet;

/// Where a place is carried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Its own cell, or one close by.
    pub cell: u64,
    /// Part of the cell.
    pub fragment: usize,
    /// m, the place itself, or the one of the cell closest to it
    pub place: Vec3,
}

/// How far away the next voxel may be, in voxels.
const FAR: f64 = 3.0;
/// How far inside of another cell a place is put, in edges of a cell.
const WITHIN: f64 = 1e-9;

impl Fragments {
    /// Where a place in the cell `id` is carried.
    pub fn anchor(&self, id: u64, place: Vec3) -> Anchor {
        let own = |fragment: usize| Anchor { cell: id, fragment, place };
        let Some(cell) = self.cells.get(&id) else { return own(0) };
        let size = self.edge / SIDE as f64;
        let mut best = cell.voxels.reached(self.edge, place).map(|(fragment, away)| (away, own(fragment)));
        // One further off than the next voxel may be reached past the end of the cut only.
        if let Some((_, anchor)) = best.filter(|(away, _)| *away <= size * size) {
            return anchor;
        }
        for other in self.round(id, cell) {
            let Some(next) = self.cells.get(&other) else { continue };
            for (voxel, middle) in next.voxels.whole() {
                let away = (middle - place).norm_squared();
                if away >= best.map_or((FAR * size).powi(2), |(least, _)| least)
                    || cell.voxels.parts(place, middle)
                    || next.voxels.parts(place, middle)
                {
                    continue;
                }
                best = Some((away, self.anchor_in((other, next.voxels.fragment(voxel)), place)));
            }
        }
        best.map_or_else(|| own(cell.voxels.fragment_at(self.edge, place)), |(_, anchor)| anchor)
    }

    /// A place carried by a fragment of a cell, wherever it lies.
    pub fn anchor_in(&self, (cell, fragment): (u64, usize), place: Vec3) -> Anchor {
        let within = |i: usize, _: usize| {
            let (low, spare) = (self.cells[&cell].reference[i], WITHIN * self.edge);
            place[i].clamp(low + spare, low + self.edge - spare)
        };
        Anchor { cell, fragment, place: Vec3::from_fn(within) }
    }

    /// Whether two fragments, each with its cell, share nodes; `None` where their cells have none in common.
    pub fn are_connected(&self, a: (u64, usize), b: (u64, usize)) -> Option<bool> {
        if a.0 == b.0 {
            return Some(a.1 == b.1);
        }
        let [one, other] = [a, b].map(|(cell, f)| self.cells.get(&cell).and_then(|cell| cell.fragments.get(f)));
        let (one, other) = (one?, other?);
        let common = one.nodes.iter().flat_map(|x| other.nodes.iter().filter(|y| y.0 == x.0).map(move |y| x == y));
        common.reduce(|any, same| any || same)
    }

    /// Cells at most two faces away.
    fn round(&self, id: u64, cell: &CutCell) -> BTreeSet<u64> {
        let mut round: BTreeSet<u64> = cell.neighbours.into_iter().collect();
        for first in cell.neighbours.iter().filter_map(|id| self.cells.get(id)) {
            round.extend(first.neighbours);
        }
        round.remove(&id);
        round
    }
}
