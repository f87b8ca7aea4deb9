//! Constraints of a local region that covers a whole connected part of the body.
//!
//! Such a region has no border nodes to hold it: a contact would push it away as a rigid body, and with it surface that was never touched.
//! Every connected part without a constrained node is therefore constrained at its side far from the contacts. A part that two hands grip is not:
//! they hold it, and a constraint between them would keep it from stretching and bending there.

use super::{Lattice, LatticeError};
use pliant_solver::{Constraint, Nodes, Vec3};

/// Nodes are constrained from this share on of the range of distances between a part's nodes and the nearest contact.
const HELD_FROM: f64 = 0.75;

impl Lattice {
    /// Constrains the far side of every part that has no constrained node and less than two grips. These nodes return to rest like border nodes,
    /// unless the material has a history.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn constrain_detached_parts(&mut self, nodes: &mut Nodes) -> Result<(), LatticeError> {
        let part_of = self.parts();
        let parts = part_of.iter().max().map_or(0, |last| *last as usize + 1);
        let mut is_held = vec![false; parts];
        // Smallest and largest distance from a contact, m.
        let mut range = vec![(f64::INFINITY, 0.0_f64); parts];
        let from_contact = |i: u32| {
            let rest = self.grid_rest(i);
            let balls = self.last_contact_balls.iter();
            balls.map(|ball| (rest - Vec3::from(ball.centre)).norm()).fold(f64::INFINITY, f64::min)
        };
        let distance: Vec<f64> = (0..nodes.len() as u32).map(from_contact).collect();
        for (i, &part) in part_of.iter().enumerate() {
            let (near, far) = &mut range[part as usize];
            (*near, *far) = (near.min(distance[i]), far.max(distance[i]));
            is_held[part as usize] |= nodes.constraint[i] == Constraint::Fixed;
        }
        let has_border = is_held.clone();
        let mut grips = vec![0; parts];
        let mut gripped = Vec::with_capacity(self.grips.len());
        for grip in &self.grips {
            if let Some(cell) = self.cell_of(*grip)? {
                let part = part_of[self.region.cell_corners[cell][0] as usize] as usize;
                grips[part] += 1;
                is_held[part] |= grips[part] >= 2;
                gripped.push((part, *grip));
            }
        }
        // A part without a border is all that there is of it.
        gripped.retain(|(part, _)| has_border[*part]);
        let apart = gripped.windows(2).find(|pair| pair[0].0 != pair[1].0);
        self.grips_apart = apart.map(|pair| [pair[0].1, pair[1].1]);
        for (i, &part) in part_of.iter().enumerate().filter(|(_, part)| !is_held[**part as usize]) {
            let (near, far) = range[part as usize];
            if distance[i] >= near + HELD_FROM * (far - near) {
                nodes.constraint[i] = Constraint::Fixed;
                if !self.keeps_displaced {
                    self.returning.push(i as u32);
                }
            }
        }
        self.returning.sort_unstable();
        Ok(())
    }
}
