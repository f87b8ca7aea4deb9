//! Points of the surface that a cut has bound against their neighbours.
//!
//! Which part of a cell carries a point is told from the lattice's own view of the cut, in voxels. Beside a wall it can be
//! wrong by a hair. The mesh is exact: corners of one triangle are on one side of every cut. So a point that most of its
//! neighbours disagree with goes where they are.

use super::Lattice;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// Where points are carried: cell and fragment.
pub(super) type Hosts = BTreeMap<u32, (u64, usize)>;

/// Rounds, at most: one mends a single point, more a row of them.
const ROUNDS: usize = 4;

impl Lattice {
    /// Binds points anew that go with another part than most points they share a triangle with. `place` is where a point is
    /// bound.
    pub(super) fn mend<'a>(
        &mut self,
        mut hosts: Hosts,
        own: &BTreeMap<u32, u64>,
        place: impl Fn(u32) -> Vec3,
        neighbours: impl Fn(u32) -> Vec<u32> + 'a,
    ) {
        for _ in 0..ROUNDS {
            let mut moves = Vec::new();
            for (&point, &host) in &hosts {
                let (mut with, mut against) = (0, BTreeMap::<(u64, usize), usize>::new());
                for other in neighbours(point) {
                    let Some(&there) = hosts.get(&other) else { continue };
                    match self.fragments.are_connected(host, there) {
                        Some(true) => with += 1,
                        Some(false) => *against.entry(there).or_default() += 1,
                        None => {}
                    }
                }
                let most = against.iter().max_by_key(|(_, count)| **count);
                if let Some((there, _)) = most.filter(|_| against.values().sum::<usize>() > with) {
                    moves.push((point, *there));
                }
            }
            if moves.is_empty() {
                return;
            }
            for (point, there) in moves {
                let from = hosts.insert(point, there).map_or(there.0, |(cell, _)| cell);
                self.bound.leave(point);
                self.fragments.release_point(from, point);
                let anchor = self.fragments.anchor_in(there, place(point));
                self.fragments.bind(&anchor, point);
                self.bound.bind(point, own[&point], anchor.cell, anchor.place);
            }
        }
    }
}
