//! Velocity of a fingertip with a mass in a step of a sheet that it touches.
//!
//! The tip moves with `V = free + dt F / inertia`, F the force of the sheet on it; the sheet's step gives F for a V. While the active set stays, F is linear in V
//! with a symmetric slope, the Schur complement of the tip in the system of both, which resists it. It is learnt from the velocities that are tried
//! (symmetric rank-one update: Davidon 1968), so that few of them are needed.

use nalgebra::Matrix3;
use pliant_solver::Vec3;

/// How the velocity of a tip with a mass depends on the force of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipResponse {
    /// Velocity at the end of the step without that force, m/s.
    pub free: Vec3,
    /// Impulse over change of velocity: the mass, and the coupling over the step, kg.
    pub inertia: f64,
    /// Length of the step, s.
    pub dt: f64,
}

impl TipResponse {
    /// Velocity at the end of the step under the force `force` (N), m/s.
    pub fn velocity(&self, force: Vec3) -> Vec3 {
        self.free + self.dt / self.inertia * force
    }
}

/// Solves for the velocity of one tip in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TipMotion {
    /// Number of velocities that were tried.
    pub tried: usize,
    /// Largest speed against the sheet that is tried, m/s, from the first search of the step on.
    most: Option<f64>,
    search: Option<Search>,
}

/// What is known of the error `V - wanted(V)`.
#[derive(Clone, Copy, Debug)]
struct Search {
    /// Slope of the error.
    slope: Matrix3<f64>,
    /// Velocity that was tried last and the error there, m/s.
    last: [Vec3; 2],
    /// Size of the first error, m/s.
    first: f64,
}

/// Largest number of velocities that are tried in a step.
pub(super) const MOST_TRIED: usize = 8;
/// Error of a displacement, in length scales of the tip, that is left to the next step.
const SMALL: f64 = 3e-3;
/// Largest speed against the sheet that is tried, relative to that which the tip comes with: a force that is a reaction does not throw it back faster.
const FASTEST: f64 = 1.5;
/// Error of the velocity at which a search ends, relative to the one it began with.
const ACCURACY: f64 = 1e-3;
/// Cosine below which a change tells nothing of the slope.
const ROUNDING: f64 = 1e-8;

impl TipMotion {
    /// Whether a velocity is being tried.
    pub fn is_searching(&self) -> bool {
        self.search.is_some()
    }

    /// The velocity to try next, m/s, after a tip of `length` (m) moved at `velocity` and met a force that would give it the velocity `wanted`; the sheet
    /// moved at `sheet` before. `None` if the velocity may stand.
    pub fn next(
        &mut self,
        velocity: Vec3,
        wanted: Vec3,
        sheet: Vec3,
        length: f64,
        response: &TipResponse,
    ) -> Option<Vec3> {
        let error = velocity - wanted;
        let size = error.norm();
        let is_small = match &self.search {
            None => size * response.dt <= SMALL * length,
            Some(search) => size <= ACCURACY * search.first,
        };
        if is_small || self.tried >= MOST_TRIED || !size.is_finite() {
            self.search = None;
            return None;
        }
        let search = self.search.get_or_insert_with(|| {
            // A sheet that stays as it is pushes less, and the tip may stop where the sheet is.
            let to_sheet = (velocity - sheet).dot(&error) / size;
            let way = if to_sheet > 0.0 { to_sheet.min(size) } else { size };
            Search { slope: Matrix3::from_diagonal_element(size / way), last: [velocity, error], first: size }
        });
        let (moved, change) = (velocity - search.last[0], error - search.last[1]);
        let unknown = change - search.slope * moved;
        let along = unknown.dot(&moved);
        if along.abs() > ROUNDING * unknown.norm() * moved.norm() {
            search.slope += unknown * unknown.transpose() / along;
        }
        search.last = [velocity, error];
        let step = search.slope.try_inverse().map_or(error, |inverse| inverse * error);
        let fastest = || FASTEST * (response.free - sheet).norm().max((velocity - sheet).norm());
        let most = *self.most.get_or_insert_with(fastest);
        let against = velocity - step - sheet;
        self.tried += 1;
        Some(sheet + against * (most / against.norm()).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_that_resists_by_any_factor_is_balanced_in_few_tries() {
        for stiffness in [1e-3, 1.0, 1e3, 1e9] {
            for (inertia, dt) in [(1e-3, 1e-4), (0.01, 1e-3), (1.0, 3e-2)] {
                let direction = Vec3::new(0.6, 0.0, -0.8);
                let response = TipResponse { free: 3.0 * direction, inertia, dt };
                // Resists like a mass over the step, relative to the velocity it had, and across by a thousand times as much.
                let had = -0.5 * direction;
                let across = Vec3::new(0.8, 0.0, 0.6);
                let mass = |along: f64| stiffness * inertia * (if along == 0.0 { 1000.0 } else { along });
                let wanted = |velocity: Vec3| {
                    let past = velocity - had;
                    let skew = Vec3::new(0.0, 0.2, 0.0) * past.dot(&direction);
                    let force = mass(1.0) * past.dot(&direction) * direction + mass(0.0) * past.dot(&across) * across;
                    response.velocity(-1.0 / dt * (force + mass(1.0) * (skew + 0.2 * past.y * direction)))
                };
                let (mut motion, mut velocity) = (TipMotion::default(), response.free);
                while let Some(next) = motion.next(velocity, wanted(velocity), had, 1e-5, &response) {
                    velocity = next;
                }
                let error = (velocity - wanted(velocity)).norm();
                let first = (response.free - wanted(response.free)).norm();
                assert!(error <= ACCURACY * first || error * dt <= SMALL * 1e-5, "{stiffness}: {error} of {first}");
                assert!(motion.tried <= 5, "{stiffness}: {} tries", motion.tried);
            }
        }
    }

    #[test]
    fn no_velocity_is_tried_that_is_much_faster_than_the_tip_came() {
        let free = Vec3::new(0.0, 0.0, -2.0);
        let response = TipResponse { free, inertia: 0.01, dt: 1e-3 };
        let (mut motion, mut velocity) = (TipMotion::default(), free);
        // An error that hardly changes asks for ever more.
        while let Some(next) = motion.next(velocity, velocity - free - 1e-3 * velocity, Vec3::zeros(), 8e-3, &response)
        {
            velocity = next;
            assert!(velocity.norm() <= FASTEST * free.norm() * (1.0 + 1e-12), "{} m/s", velocity.norm());
        }
        assert_eq!(motion.tried, MOST_TRIED);
    }

    #[test]
    fn a_small_error_is_left_to_the_next_step() {
        let v = Vec3::new(0.0, 0.0, -0.1);
        let response = TipResponse { free: v, inertia: 0.01, dt: 1e-3 };
        let mut motion = TipMotion::default();
        assert_eq!(motion.next(v, 0.8 * v, Vec3::zeros(), 8e-3, &response), None, "0.02 mm");
        assert!(motion.next(v, -v, Vec3::zeros(), 8e-3, &response).is_some(), "0.2 mm");
    }
}
