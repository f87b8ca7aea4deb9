//! Friction between yarns that slide past each other in bending: the hysteretic part of a hinge's torque.
//!
//! A spring in series with a slider (Jenkins 1962): it yields where its moment reaches half of 2HB, the width of the hysteresis loop of a
//! Kawabata test (Kawabata 1980). The angle by which the slider has moved is the history of the hinge. Each hinge slides by itself,
//! and limits add up, so the loop has the measured width along the axes of a grid of right triangles and is wider where edges lie
//! across the bending direction.

/// Bending friction of a fabric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct YarnFriction {
    /// Moment per width at which yarns slide, half of 2HB, N.
    pub(crate) moment: f64,
    /// Curvature at which yarns begin to slide, 1/m.
    pub(crate) curvature: f64,
}

/// The friction element of a hinge: a spring and a slider in series.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrictionElement {
    /// Stiffness of the spring, N m.
    pub(crate) stiffness: f64,
    /// Torque at which the slider moves, N m.
    pub(crate) limit: f64,
}

impl YarnFriction {
    /// The element of a hinge with an edge of `length` (m) between triangles of `area` (m^2) together.
    pub(crate) fn element(&self, length: f64, area: f64) -> FrictionElement {
        FrictionElement {
            stiffness: self.moment / self.curvature * length * length / area,
            limit: self.moment * length,
        }
    }
}

impl FrictionElement {
    /// Torque at an angle (rad) against the slider's position, N m.
    pub(crate) fn torque(&self, angle: f64) -> f64 {
        (self.stiffness * angle).clamp(-self.limit, self.limit)
    }

    /// A potential of the torque over one step, J: its derivative by the angle is the torque.
    pub(crate) fn energy(&self, angle: f64) -> f64 {
        let torque = self.torque(angle);
        torque * angle - 0.5 * torque * torque / self.stiffness
    }

    /// Derivative of the torque, N m: zero while the slider moves.
    pub(crate) fn tangent(&self, angle: f64) -> f64 {
        if (self.stiffness * angle).abs() < self.limit { self.stiffness } else { 0.0 }
    }

    /// The angle against the slider after the slider has moved, rad.
    pub(crate) fn angle_after_sliding(&self, angle: f64) -> f64 {
        self.torque(angle) / self.stiffness
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_is_the_derivative_of_the_energy() {
        let element = YarnFriction { moment: 1e-3, curvature: 20.0 }.element(0.01, 2e-4);
        for angle in [-0.9, -0.38, -0.1, 0.0, 0.2, 0.39, 0.41, 2.0] {
            let (h, torque) = (1e-6, element.torque(angle));
            let slope = (element.energy(angle + h) - element.energy(angle - h)) / (2.0 * h);
            assert!((slope - torque).abs() < 1e-6 * element.limit, "{angle}: {slope} {torque}");
            assert!((element.torque(element.angle_after_sliding(angle)) - torque).abs() < 1e-12 * element.limit);
            let tangent = (element.torque(angle + h) - element.torque(angle - h)) / (2.0 * h);
            assert!((tangent - element.tangent(angle)).abs() < 1e-6 * element.stiffness, "{angle}: {tangent}");
        }
        // A cylinder with a curvature of 20 1/m folds the hinge by 20 1/m * area / length = 0.4 rad.
        assert!(element.tangent(0.399) > 0.0 && element.tangent(0.401) == 0.0);
    }
}
