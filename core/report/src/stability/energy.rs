//! The energy balance of a run.
//!
//! The work that gravity, hands and kinematic nodes have done is the most energy a body can hold. What it holds beyond was made by the
//! integration.

use pliant_engine::session::Session;
use pliant_solver::Vec3;

/// Excess of energy over the work done from which a run counts as growing.
pub(super) const GROWTH: f64 = 0.5;

/// (m/s)^2, square of a speed of 1 nm/s that rounding alone may cause
const ROUNDING_SPEED_SQUARED: f64 = 1e-18;

/// Work in and energy held, J, after every step.
#[derive(Clone, Debug, Default)]
pub(super) struct EnergyBalance {
    /// m, nodes of each body before the step
    before: Vec<Vec<Vec3>>,
    /// m, hand of each tool before the step
    hands: Vec<Vec3>,
    /// J, work of gravity, of what holds and drives nodes, and of tools
    pub(super) work: f64,
    /// J, part of the work that friction between tips and sheets dissipated
    pub(super) friction_work: f64,
    /// J, sum of the magnitudes of all work
    scale: f64,
    /// J, kinetic energy at the end of each step
    pub(super) kinetic: Vec<f64>,
    /// J, elastic energy at the end of each step
    pub(super) elastic: Vec<f64>,
    /// J, largest energy held beyond the work done
    pub(super) injected: f64,
    /// J, energy that rounding alone may cause
    floor: f64,
}

impl EnergyBalance {
    /// Adds a step.
    pub(super) fn step(&mut self, session: &Session) {
        let gravity = session.plan().gravity;
        for (index, body) in session.bodies.iter().enumerate() {
            let nodes = &body.system.nodes;
            if self.before.len() <= index {
                self.before.push(nodes.rest.clone());
            }
            let before = &mut self.before[index];
            self.floor = self.floor.max(ROUNDING_SPEED_SQUARED * nodes.mass.iter().sum::<f64>());
            // A region that has moved has other nodes, whose displacements are not known.
            if before.len() == nodes.len() {
                let g = if body.discretization.is_whole() { gravity } else { Vec3::zeros() };
                for (i, held) in session.reactions(index).iter().enumerate() {
                    let u = nodes.x[i] - before[i];
                    let done = (*held + nodes.mass[i] * g).dot(&u);
                    (self.work, self.scale) = (self.work + done, self.scale + done.abs());
                }
            }
            before.clone_from(&nodes.x);
        }
        let on_lattice = session.bodies.iter().any(|b| b.discretization.sheet().is_none());
        let frame = session.frame();
        for (i, tool) in frame.tools.iter().enumerate().filter(|_| on_lattice) {
            if let Some(before) = self.hands.get(i) {
                // The force on the hand is opposite to that on the body.
                let done = -tool.force.dot(&(tool.hand - *before));
                (self.work, self.scale) = (self.work + done, self.scale + done.abs());
            }
        }
        self.hands = frame.tools.iter().map(|t| t.hand).collect();
        // Reactions of a sheet do the work of the hand less friction.
        (self.work, self.friction_work) = (self.work + frame.friction_work, self.friction_work + frame.friction_work);
        let held = frame.kinetic_energy + frame.elastic_energy;
        self.injected =
            if held.is_finite() { self.injected.max(held + self.friction_work - self.work) } else { f64::INFINITY };
        self.kinetic.push(frame.kinetic_energy);
        self.elastic.push(frame.elastic_energy);
    }

    /// Largest energy held beyond the work done, over all work.
    pub(super) fn excess(&self) -> f64 {
        (self.injected / self.scale.max(self.floor).max(f64::MIN_POSITIVE)).max(0.0)
    }

    /// Whether the largest kinetic energy of the last quarter is less than half of that of the second.
    pub(super) fn is_damped(&self) -> bool {
        let quarter = self.kinetic.len() / 4;
        let largest = |range: std::ops::Range<usize>| self.kinetic[range].iter().copied().fold(0.0, f64::max);
        quarter > 0 && largest(3 * quarter..self.kinetic.len()) < 0.5 * largest(quarter..2 * quarter)
    }
}
