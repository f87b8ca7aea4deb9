//! The contact patch over which the load of a small tool or a grip is distributed.
//!
//! The stiffness of a single node is 0.816 E h, so a load on one node would feel softer the finer the grid is. The load is therefore spread over
//! a disc three cells wide with the Hertz pressure `sqrt(1 - (r/a)^2)` of a ball (Hertz 1881). The disc is sampled in the rest shape, so the
//! cost does not depend on the resolution of the surface.

use pliant_solver::Vec3;

/// Sample points of a disc with their fractions of the load.
#[derive(Debug, Default)]
pub struct Patch {
    /// Points in the rest shape, m (s x 3).
    pub points: Vec<Vec3>,
    /// Fraction of the load at each point (s); they add up to 1.
    pub fractions: Vec<f64>,
}

/// Radius of the disc, in cell edges.
const RADIUS: f64 = 1.5;
/// Number of concentric rings of samples.
const RINGS: usize = 3;

impl Patch {
    /// Samples the disc around `centre` (m) in the rest shape, perpendicular to `normal` (any length), for cells with this `edge` (m).
    // With `libm`, 4 of these 54 values differ from those of glibc in the last bit, which would change the results of pulls.
    #[allow(clippy::disallowed_methods, reason = "sines and cosines of 27 fixed angles")]
    pub fn sample(&mut self, centre: Vec3, normal: Vec3, edge: f64) {
        let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::z);
        let along = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
        let across = normal.cross(&along);
        self.points.clear();
        self.fractions.clear();
        for ring in 0..RINGS {
            let (r, count) = ((ring as f64 + 0.5) / RINGS as f64, 6 * ring + 3);
            let pressure = (1.0 - r * r).sqrt();
            for i in 0..count {
                let angle = (i as f64 + 0.5 * (ring % 2) as f64) / count as f64 * std::f64::consts::TAU;
                let offset = RADIUS * edge * r * (angle.cos() * along + angle.sin() * across);
                self.points.push(centre + offset);
                self.fractions.push(pressure * r / count as f64);
            }
        }
        let total: f64 = self.fractions.iter().sum();
        self.fractions.iter_mut().for_each(|s| *s /= total);
    }
}
