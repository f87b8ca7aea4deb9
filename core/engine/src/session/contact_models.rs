//! Contact models of a step for haptic loops that are faster than the simulation.

use super::{Session, ToolSlot};
use crate::tool::{ContactModel, TipMass, separate};
use pliant_solver::{Block, Vec3};

/// Default mass of a live hand's tip on sheets, kg (an assumption).
pub const LIVE_TIP_MASS: f64 = 0.01;

impl Session {
    /// Gives every tip on sheets a mass, driven by its hand through the coupling, as live hands need.
    pub fn drive_tips(&mut self) {
        if self.bodies.iter().any(|body| body.discretization.sheet().is_some()) {
            self.tools.iter_mut().for_each(|slot| slot.tip = slot.tip.or(Some(TipMass::new(LIVE_TIP_MASS))));
        }
    }

    /// Moves the tips with mass over a step of `dt` (s).
    pub(super) fn move_tips(&mut self, dt: f64) {
        for slot in &mut self.tools {
            let touches = slot.touches();
            let Some(tip) = &mut slot.tip else { continue };
            let hand = slot.hand.position;
            if !touches {
                tip.leave();
                slot.hand_was = None;
                continue;
            }
            let speed = slot.hand_was.map_or(Vec3::zeros(), |was| (hand - was) / dt);
            slot.hand_was = Some(hand);
            tip.drive_kinematic(hand, speed, &slot.tool.coupling, slot.on_sheets, dt);
        }
        for second in 1..self.tools.len() {
            let (before, after) = self.tools.split_at_mut(second);
            let b = &mut after[0];
            for a in before {
                let (shape_a, shape_b) = (a.tool.proxy.shape.shape(), b.tool.proxy.shape.shape());
                // Only round fingertips are separated from each other, for pinches.
                if let (Some(tip_a), Some(tip_b), true) =
                    (&mut a.tip, &mut b.tip, shape_a.is_round() && shape_b.is_round())
                {
                    separate(tip_a, shape_a.length_scale(), tip_b, shape_b.length_scale());
                }
            }
        }
        for slot in self.tools.iter_mut().filter(|slot| slot.touches()) {
            if let (Some(tip), None) = (&slot.tip, slot.tool.proxy.touch) {
                slot.tool.proxy.position = tip.position;
            }
        }
    }

    /// Writes the contact models of the last step, one for each tool, for hands sampled at `time` (ns).
    ///
    /// # Panics
    /// If `out` has fewer elements than there are tools.
    pub fn contact_models(&self, time: u64, out: &mut [ContactModel]) {
        assert_eq!(out.len(), self.tools.len(), "one for each tool");
        for ((slot, felt), out) in self.tools.iter().zip(&self.frame.tools).zip(out) {
            *out = ContactModel { time, at: felt.hand, ..ContactModel::default() };
            if felt.contact.is_none() {
                continue;
            }
            (out.force, out.drift) = (felt.force, slot.drift);
            (out.stiffness, out.normal) = slope(slot, felt.force);
        }
    }
}

/// Stiffness of a force against displacements of the hand, N/m, and the outward normal of a unilateral contact.
fn slope(slot: &ToolSlot, force: Vec3) -> (Block, Option<Vec3>) {
    let k = slot.tool.coupling_factor * slot.tool.coupling.stiffness;
    let all = std::array::from_fn(|e| if e % 4 == 0 { k } else { 0.0 });
    let Some(touch) = slot.tool.proxy.touch.filter(|_| slot.tool.is_fingertip()) else { return (all, None) };
    let n = touch.normal;
    let press = force.dot(&n);
    let along = force - press * n;
    if along.norm() < 0.99 * slot.tool.friction.kinetic_coefficient * press {
        return (all, Some(n)); // a sticking contact resists in all directions
    }
    (std::array::from_fn(|e| k * n[e / 3] * n[e % 3]), Some(n))
}
