//! A guard over the energy of implicit steps.
//!
//! Forces of a body are not linear, and one Newton iteration does not solve them, so a step that is long for the forces may give a body energy,
//! and many such steps of a midpoint rule give it any amount. So what steps gain beyond the work of their loads is added up, as a passivity
//! observer does for a device (Hannaford and Ryu 2002). A step that would bring the sum too high is taken again with backward Euler and more Newton
//! iterations.

use super::Loads;
use crate::algebra::Vec3;
use crate::nodes::Nodes;

/// Most that steps may gain together, as a fraction of the largest energy so far: the midpoint rule swings about the true energy by terms of
/// second order in the step.
const ALLOWANCE: f64 = 0.02;

/// What steps have gained together, and what that is measured by.
#[derive(Debug, Default)]
pub(super) struct EnergyGuard {
    /// What steps have gained together beyond the work of the loads, J; losses pay back.
    gained: f64,
    /// Largest energy and work of a step so far, J.
    scale: f64,
}

impl EnergyGuard {
    /// Forgets what was gained, as after a change of the state from outside.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Enters a step that took the energy (kinetic and elastic, J) from `before` to `after` under loads that did the `work` (J). Returns whether
    /// the step may stand; otherwise nothing is entered.
    pub fn admit(&mut self, before: f64, after: f64, work: f64) -> bool {
        let scale = self.scale.max(before.abs()).max(work.abs());
        let gained = self.gained + (after - before - work);
        let stands = gained <= ALLOWANCE * scale;
        if stands {
            (self.gained, self.scale) = (gained.max(-ALLOWANCE * scale), scale);
        }
        stands
    }
}

/// Work of the loads and of the contacts' and fixings' forces `held` (N, n x 3) on nodes that came from the positions `x` (m) and the velocities
/// `v` (m/s) to where they are, J.
pub(super) fn work(loads: &Loads<'_>, nodes: &Nodes, held: &[Vec3], [x, v]: [&[Vec3]; 2]) -> f64 {
    let moved = |i: usize| nodes.x[i] - x[i];
    let weight: f64 = (0..nodes.len()).map(|i| nodes.mass[i] * loads.gravity.dot(&moved(i))).sum();
    let forces: f64 = loads.forces.iter().enumerate().map(|(i, f)| f.dot(&moved(i))).sum();
    let held: f64 = held.iter().enumerate().map(|(i, f)| f.dot(&moved(i))).sum();
    let tools = loads.tools.iter().map(|springs| springs.work([x, v], [&nodes.x, &nodes.v]));
    weight + forces + held + tools.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swing_is_admitted_and_a_steady_gain_is_not() {
        let mut guard = EnergyGuard::default();
        for step in 0..1000 {
            let swing = if step % 2 == 0 { 0.015 } else { -0.015 };
            assert!(guard.admit(1.0, 1.0 + swing, 0.0), "{step}");
        }
        let (mut guard, mut energy) = (EnergyGuard::default(), 1.0);
        let admitted = (0..1000).take_while(|_| {
            let gained = energy * 1.001;
            let stands = guard.admit(energy, gained, 0.0);
            energy = if stands { gained } else { energy };
            stands
        });
        assert!(admitted.count() <= 20);
        assert!(energy < 1.0 + 1.01 * ALLOWANCE, "{energy}");
        assert!(!EnergyGuard::default().admit(1.0, f64::NAN, 0.0));
    }

    #[test]
    fn work_of_loads_is_no_gain() {
        let mut guard = EnergyGuard::default();
        assert!(guard.admit(0.0, 5.0, 5.0));
        assert!(guard.admit(5.0, 1.0, -4.0));
        assert!(!guard.admit(1.0, 5.0, 3.0));
    }
}
