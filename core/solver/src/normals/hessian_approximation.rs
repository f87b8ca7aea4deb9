//! The approximate Hessian of an energy of normals: a stiffness for the angle of every hinge.
//!
//! On a flat sheet the energy is `sum (s_t - g_i) . C_t (s_t - g_i) / 2` over the corners i of triangles t, with s_t the slope of a triangle and
//! g_i the mean slope around a node. Slopes of neighbouring triangles differ by the angle of their hinge, in the direction across it. Around a
//! node, the sum of the squared deviations from the mean slope is at most `1 / (2 - 2 cos a)` times that of the squared differences of
//! neighbours: an eigenvalue of second differences. The angle a is 2 pi / p for a ring of p triangles and pi / p for a fan; where a clamp
//! prescribes the normal it is pi / (p + 1) between two clamped edges and pi / (2 p + 1) beside one.
//!
//! Hinges with that factor, summed over both ends, are an upper bound of the energy if the triangles around each node are equal, and they do not
//! resist rotation. Measured, the energy is 0.26 to 1.0 of the bound on regular, alternating and equilateral meshes and on one whose nodes are
//! displaced by a quarter of a cell, and 1.03 on one with a third of a cell, for ratios of rigidities of 1 to 100.

use crate::system_scales::HessianApproximation;
use std::f64::consts::PI;

/// Factor of the bound where no bound is needed: the middle of the measured range, with which Newton's method converges fastest, and more than
/// the half that a step of backward Euler needs.
const MEAN: f64 = 0.65;
/// Factor of the bound where one is needed: the largest that was measured on irregular meshes, and a margin.
const MARGIN: f64 = 1.1;

/// Factor of the bounding stiffness for an approximation.
pub(super) fn bound_factor(which: HessianApproximation) -> f64 {
    match which {
        HessianApproximation::Unbounded | HessianApproximation::AtLeastHalf => MEAN,
        HessianApproximation::UpperBound => MARGIN,
    }
}

/// The triangles around a node.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Around {
    /// Number of triangles that can bend.
    pub(super) triangles: u32,
    /// Number of their hinges at the node.
    pub(super) hinges: u32,
    /// Whether a clamp prescribes the normal.
    pub(super) is_clamped: bool,
}

impl Around {
    /// Bound of the squared deviations from the mean slope over the squared differences of neighbours.
    pub(super) fn spread(&self) -> f64 {
        let (p, q) = (f64::from(self.triangles), self.hinges);
        let angle = match (self.is_clamped, q.cmp(&self.triangles)) {
            _ if q == 0 => return 0.0,
            (true, std::cmp::Ordering::Greater) => PI / (p + 1.0),
            (true, _) => PI / (2.0 * p + 1.0),
            (false, std::cmp::Ordering::Equal) => 2.0 * PI / p,
            (false, _) => PI / p,
        };
        0.5 / (1.0 - libm::cos(angle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_are_those_of_the_longest_waves() {
        let spread = |triangles, hinges, is_clamped| Around { triangles, hinges, is_clamped }.spread();
        // Slopes of the wave: squares over those of the differences.
        let ring = (0..6).map(|k| (PI * f64::from(k) / 3.0).cos()).collect::<Vec<_>>();
        let squares: f64 = ring.iter().map(|s| s * s).sum();
        let steps: f64 = (0..6).map(|k| (ring[k] - ring[(k + 1) % 6]).powi(2)).sum();
        assert!((spread(6, 6, false) - squares / steps).abs() < 1e-12);
        // A fan of two: +-1 and a difference of 2. One triangle beside a clamped edge, and one between two.
        assert!((spread(2, 1, false) - 0.5).abs() < 1e-12);
        assert!((spread(1, 1, true) - 1.0).abs() < 1e-12 && (spread(1, 2, true) - 0.5).abs() < 1e-12);
        assert!(spread(1, 0, false) == 0.0);
    }
}
