//! Friction of yarns that bend past each other: the part of a hinge's moment that depends on how it got there.
//!
//! A spring that gives way where its moment comes to half the width of the loop between bending to and fro, 2HB of a
//! Kawabata test (Kawabata 1980): the angle by which it has given way is the history of the hinge. Each edge is taken alone, and
//! limits add up: the loop has its width along the axes of a grid of right triangles, and more where edges lie across.

/// Of a fabric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slip {
    /// N, moment by width at which yarns slide: half of 2HB
    pub(crate) moment: f64,
    /// 1/m, curvature that they bear before
    pub(crate) curvature: f64,
}

/// Of a hinge: rest data behind its angle and stiffness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Catch {
    /// N m
    pub(crate) stiffness: f64,
    /// N m, the largest torque
    pub(crate) limit: f64,
}

impl Slip {
    /// Of an edge of length `l` (m) between triangles of `area` (m^2) together.
    pub(crate) fn on(&self, l: f64, area: f64) -> Catch {
        Catch { stiffness: self.moment / self.curvature * l * l / area, limit: self.moment * l }
    }
}

impl Catch {
    /// N m, against the angle by which it is off where it caught last.
    pub(crate) fn torque(&self, off: f64) -> f64 {
        (self.stiffness * off).clamp(-self.limit, self.limit)
    }

    /// J, whose slope is the torque
    pub(crate) fn energy(&self, off: f64) -> f64 {
        let torque = self.torque(off);
        torque * off - 0.5 * torque * torque / self.stiffness
    }

    /// N m, the torque's slope
    pub(crate) fn slope(&self, off: f64) -> f64 {
        if (self.stiffness * off).abs() < self.limit { self.stiffness } else { 0.0 }
    }

    /// What of `off` is left once it has given way.
    pub(crate) fn caught(&self, off: f64) -> f64 {
        self.torque(off) / self.stiffness
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_energy_has_the_torque_for_its_slope() {
        let catch = Slip { moment: 1e-3, curvature: 20.0 }.on(0.01, 2e-4);
        for off in [-0.9, -0.38, -0.1, 0.0, 0.2, 0.39, 0.41, 2.0] {
            let (step, torque) = (1e-6, catch.torque(off));
            let slope = (catch.energy(off + step) - catch.energy(off - step)) / (2.0 * step);
            assert!((slope - torque).abs() < 1e-6 * catch.limit, "{off}: {slope} {torque}");
            assert!((catch.torque(catch.caught(off)) - torque).abs() < 1e-12 * catch.limit);
            let bends = (catch.torque(off + step) - catch.torque(off - step)) / (2.0 * step);
            assert!((bends - catch.slope(off)).abs() < 1e-6 * catch.stiffness, "{off}: {bends}");
        }
        // It slides where the cylinder of that curvature folds it: 20 1/m over 0.02 m.
        assert!(catch.slope(0.399) > 0.0 && catch.slope(0.401) == 0.0);
    }
}
