//! A sheet that buckles at a scale below the mesh: compression gives way, tension stays (a tension field: Reissner 1938).
//!
//! The energy is the least one over all shortenings by wrinkles, `min C : (e + z)^2 / 2` over z that have no negative part
//! (Pipkin 1986). Its slope is C : e where that has no negative part, nothing where every direction is short, and one line of
//! tension in between: `max E(t) e(t)^2 / 2` over directions t.

use crate::tensor::Tensor;

/// Directions looked at before the best is refined, and the angle between two, pi over their number: cosine and sine.
const DIRECTIONS: usize = 24;
const STEP: [f64; 2] = [0.9914448613738104, 0.13052619222005157];
/// Halvings of twice that angle, to the last digit.
const HALVINGS: usize = 55;

/// Stress (11, 22, 12), N/m, and energy, J/m^2, of a strain (11, 22, gamma).
pub(crate) fn relaxed(c: &Tensor, e: [f64; 3]) -> ([f64; 3], f64) {
    let q = c.stress(e);
    if q[0] + q[1] >= 0.0 && q[0] * q[1] >= q[2] * q[2] {
        return (q, 0.5 * (q[0] * e[0] + q[1] * e[1] + q[2] * e[2]));
    }
    if e[0] + e[1] <= 0.0 && 4.0 * e[0] * e[1] >= e[2] * e[2] {
        return ([0.0; 3], 0.0);
    }
    let mut d = [1.0, 0.0];
    let mut best = (0.0, d);
    for _ in 0..DIRECTIONS {
        let (stretch, soft) = along(c, e, d);
        let gain = if stretch > 0.0 { stretch * stretch / soft } else { 0.0 };
        best = if gain > best.0 { (gain, d) } else { best };
        d = [STEP[0] * d[0] - STEP[1] * d[1], STEP[0] * d[1] + STEP[1] * d[0]];
    }
    // No length matters of t: the gain is of degree 0.
    let t = best.1;
    let at = |x: f64| [t[0] - x * t[1], t[1] + x * t[0]];
    let wide = STEP[1] / STEP[0];
    let (mut low, mut high) = (-wide, wide);
    for _ in 0..HALVINGS {
        let x = 0.5 * (low + high);
        let (d, n) = (at(x), [-t[1], t[0]]);
        let (stretch, soft) = along(c, e, d);
        let stretching = 2.0 * (e[0] * d[0] * n[0] + e[1] * d[1] * n[1]) + e[2] * (d[0] * n[1] + d[1] * n[0]);
        let line = [d[0] * d[0], d[1] * d[1], d[0] * d[1]];
        let change = [2.0 * d[0] * n[0], 2.0 * d[1] * n[1], d[0] * n[1] + d[1] * n[0]];
        let softening = 2.0 * c.compliant(line, change);
        let rises = if stretch > 0.0 { 2.0 * stretching * soft > stretch * softening } else { x < 0.0 };
        (low, high) = if rises { (x, high) } else { (low, x) };
    }
    let d = at(0.5 * (low + high));
    let (stretch, soft) = along(c, e, d);
    let pull = stretch.max(0.0) / soft;
    ([pull * d[0] * d[0], pull * d[1] * d[1], pull * d[0] * d[1]], 0.5 * pull * stretch)
}

/// Stretch along a direction, and the compliance against tension along it.
fn along(c: &Tensor, e: [f64; 3], d: [f64; 2]) -> (f64, f64) {
    let line = [d[0] * d[0], d[1] * d[1], d[0] * d[1]];
    (e[0] * line[0] + e[1] * line[1] + e[2] * line[2], c.compliant(line, line))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stress_is_the_slope_and_has_no_negative_part() {
        let c = Tensor::from_moduli(1000.0, 60.0, 0.9, 25.0).unwrap();
        let mut lines = 0;
        for i in 0..400 {
            let wave = |k: f64| 0.05 * (k * f64::from(i) + k).sin();
            let e = [wave(1.7), wave(2.9), 2.0 * wave(0.7)];
            let (q, energy) = relaxed(&c, e);
            let whole = c.stress(e);
            assert!(energy <= 0.5 * (whole[0] * e[0] + whole[1] * e[1] + whole[2] * e[2]) + 1e-12);
            assert!(q[0] + q[1] >= 0.0 && q[0] * q[1] - q[2] * q[2] >= -1e-9, "{e:?}: {q:?}");
            lines += usize::from(q != whole && q != [0.0; 3]);
            for k in 0..3 {
                let at = |step: f64| {
                    let mut e = e;
                    e[k] += step;
                    relaxed(&c, e).1
                };
                let slope = (at(1e-7) - at(-1e-7)) / 2e-7;
                assert!((slope - q[k]).abs() < 1e-4, "{e:?} {k}: {slope} {}", q[k]);
            }
        }
        assert!(lines > 100, "{lines}");
    }

    #[test]
    fn pulled_along_warp_it_narrows_for_nothing() {
        let c = Tensor::from_moduli(1000.0, 500.0, 0.3, 50.0).unwrap();
        let (q, energy) = relaxed(&c, [0.01, -0.02, 0.0]);
        assert!((q[0] - 10.0).abs() < 1e-9 && q[1].abs() < 1e-9 && (energy - 0.05).abs() < 1e-12, "{q:?} {energy}");
    }
}
