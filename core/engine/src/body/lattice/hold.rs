//! Where a local region is held although no cell of the body lies beyond it.
//!
//! A region that takes in the whole of a body, or of one of several parts, has no border: pushed by a hand it would float away, and
//! with it everything an artist never touched. Each connected part without a held node is therefore held at its far side, as
//! if in a vice.

use super::Lattice;
use pliant_solver::{Constraint, Nodes, Vec3};

/// Share of the way from the nearest to the farthest node of a part, seen from the contact, beyond which nodes are held.
const HELD_FROM: f64 = 0.75;

impl Lattice {
    /// Holds the far side of every part without a held node; these nodes return to rest like those of a border, unless what is displaced
    /// stays where it is.
    pub(super) fn constrain_detached_parts(&mut self, nodes: &mut Nodes) {
        let part_of = self.parts();
        let parts = part_of.iter().max().map_or(0, |last| *last as usize + 1);
        let mut is_held = vec![false; parts];
        let mut range = vec![(f64::INFINITY, 0.0_f64); parts];
        let from_contact = |i: u32| {
            let rest = self.grid_rest(i);
            self.last_balls.iter().map(|ball| (rest - Vec3::from(ball.centre)).norm()).fold(f64::INFINITY, f64::min)
        };
        let distance: Vec<f64> = (0..nodes.len() as u32).map(from_contact).collect();
        for (i, &part) in part_of.iter().enumerate() {
            let (near, far) = &mut range[part as usize];
            (*near, *far) = (near.min(distance[i]), far.max(distance[i]));
            is_held[part as usize] |= nodes.constraint[i] == Constraint::Fixed;
        }
        for (i, &part) in part_of.iter().enumerate().filter(|(_, part)| !is_held[**part as usize]) {
            let (near, far) = range[part as usize];
            if distance[i] >= near + HELD_FROM * (far - near) {
                nodes.constraint[i] = Constraint::Fixed;
                if !self.keeps_shape {
                    self.returning.push(i as u32);
                }
            }
        }
        self.returning.sort_unstable();
    }
}
