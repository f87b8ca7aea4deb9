//! The stiffness of all bodies as a factor that may change while they are held.
//!
//! A stiffness that jumps is a force that jumps. So the factor goes to the one that is asked for at a limited rate: by one octave in
//! [`OCTAVE_TIME`] at most, and so that the force of no tool changes by more than half of its `slew` on account of it. The other half is left to
//! the motion of the hand.

use super::{EventKind, Session};

/// Shortest time in which the stiffness doubles or halves, s.
const OCTAVE_TIME: f64 = 0.05;
/// Share of the tool's `slew` that a change of stiffness may take.
const SLEW_SHARE: f64 = 0.5;
/// Factors that may be asked for.
const ALLOWED: [f64; 2] = [1e-3, 1e3];
/// Ratio by which a factor is lowered until an explicit integrator is stable with it.
const LOWER: f64 = 0.9;

/// The factor of the stiffness of all bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessState {
    /// The present factor; 1 is the stiffness of the scene.
    pub now: f64,
    /// The factor that is asked for.
    pub wanted: f64,
    /// Whether the force of a tool slows the change down.
    pub is_limited: bool,
}

impl Default for StiffnessState {
    fn default() -> Self {
        Self { now: 1.0, wanted: 1.0, is_limited: false }
    }
}

impl Session {
    /// The stiffness of all bodies relative to that of the scene, and where it goes.
    pub fn stiffness(&self) -> StiffnessState {
        self.motion.stiffness
    }

    /// Asks for a stiffness of all bodies, as a factor of that of the scene, 0.001 to 1000. Returns whether there is a body whose material lets it
    /// change.
    pub(super) fn want_stiffness(&mut self, factor: f64) -> bool {
        let time = self.time();
        for body in self.bodies.iter().filter(|body| body.stiffness_factor().is_none()) {
            let (name, material) = (&body.name, body.system.material.name());
            self.events.add(EventKind::Message, time, || {
                format!("body `{name}`: its stiffness stays, because `{material}` has no field `young`")
            });
        }
        let asked = factor.clamp(ALLOWED[0], ALLOWED[1]);
        let mut wanted = asked;
        while wanted > self.motion.stiffness.now && !self.motion.limits.allow_stiffness(wanted, self.clock.dt) {
            wanted *= LOWER;
        }
        if wanted < asked {
            wanted = wanted.max(self.motion.stiffness.now.min(asked));
            let (scheme, most) = (self.motion.limits.scheme.name(), self.motion.limits.max_substeps);
            self.events.add(EventKind::Message, time, || {
                format!("stiffness {asked:.3} of the scene's: allowed is {wanted:.3}, what {scheme} follows with {most} substeps")
            });
        }
        self.motion.stiffness.wanted = wanted;
        self.bodies.iter().any(|body| body.stiffness_factor().is_some())
    }

    /// Moves the stiffness towards the one that is asked for, by as much as a step allows.
    pub(super) fn change_stiffness(&mut self, time: f64) {
        let StiffnessState { now, wanted, .. } = self.motion.stiffness;
        self.motion.stiffness.is_limited = false;
        if now == wanted {
            return;
        }
        let rate = std::f64::consts::LN_2 / OCTAVE_TIME * self.clock.dt;
        let allowed = self.tools.iter().zip(&self.frame.tools).fold(rate, |allowed, (slot, felt)| {
            allowed.min(SLEW_SHARE * slot.safety.limits().slew * self.clock.dt / felt.force.norm())
        });
        let way = libm::log(wanted / now);
        let next = if way.abs() <= allowed { wanted } else { now * libm::exp(allowed.copysign(way)) };
        self.motion.stiffness.is_limited = way.abs() > allowed && allowed < rate;
        self.motion.stiffness.now = next;
        for index in 0..self.bodies.len() {
            if self.bodies[index].stiffness_factor().is_none() {
                continue;
            }
            // It may move again in its new equilibrium.
            self.motion.sleep.wake(index);
            if let Err(error) = self.bodies[index].set_stiffness_factor(next) {
                self.freeze(index, time, error.to_string());
            }
        }
    }
}
