//! The disc a small tool or a grip presses on.
//!
//! A load on one node makes the touch as soft as the grid is fine (a node's stiffness is 0.816 E h), so it is spread over
//! three cells, with the pressure `sqrt(1 - (r/a)^2)` of a ball (Hertz 1881). The disc is sampled in the rest shape, so its
//! cost does not depend on how fine the surface is.

use pliant_solver::Vec3;

/// Weighted rest places of a disc.
#[derive(Debug, Default)]
pub struct Patch {
    /// Places, m (s x 3).
    pub places: Vec<Vec3>,
    /// Share of the load at each (s), sum 1
    pub shares: Vec<f64>,
}

/// Radius, in edges of a cell.
const RADIUS: f64 = 1.5;
/// Rings of samples.
const RINGS: usize = 3;

impl Patch {
    /// Samples the disc around a rest place with a normal of any length there.
    // With `libm` 4 of these 54 values would differ in the last bit from those of glibc, and so would what a pull leaves.
    #[allow(clippy::disallowed_methods, reason = "sines and cosines of 27 fixed angles")]
    pub fn sample(&mut self, centre: Vec3, normal: Vec3, edge: f64) {
        let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::z);
        let along = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
        let across = normal.cross(&along);
        self.places.clear();
        self.shares.clear();
        for ring in 0..RINGS {
            let (r, count) = ((ring as f64 + 0.5) / RINGS as f64, 6 * ring + 3);
            let pressure = (1.0 - r * r).sqrt();
            for i in 0..count {
                let angle = (i as f64 + 0.5 * (ring % 2) as f64) / count as f64 * std::f64::consts::TAU;
                let offset = RADIUS * edge * r * (angle.cos() * along + angle.sin() * across);
                self.places.push(centre + offset);
                self.shares.push(pressure * r / count as f64);
            }
        }
        let total: f64 = self.shares.iter().sum();
        self.shares.iter_mut().for_each(|s| *s /= total);
    }
}
