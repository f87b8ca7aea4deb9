//! Rendering of contacts on a tactile array under a fingertip: contact pressure, and the vibration of a slipping weave.
//!
//! Contact points of a ball are mapped to the pad by arc length, and each force is distributed to the four pins around its point with bilinear
//! weights, which conserves force and centroid (docs/devices.md). Forces outside of the array are counted and not rendered. Close to the limit
//! of a pin its response saturates. Slip at speed u over a weave of period L modulates the pins with the frequency u/L. The array is that of
//! Tripicchio, D'Avella and Ruffaldi (2022); the rendering is our own.

use nalgebra::UnitQuaternion;
use pliant_plugin_api::abi::DeviceInfo;
use pliant_solver::Vec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Geometry and limit of the pins of an array, as the device reports them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaxelArray {
    /// Number of rows, along the finger.
    pub rows: usize,
    /// Number of columns, across the finger.
    pub columns: usize,
    /// Distance between adjacent pins, m.
    pub pitch: f64,
    /// Largest force of one pin, N.
    pub limit: f64,
}

/// Texture of a surface, rendered as vibration under slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Distance between adjacent threads, m.
    pub period: f64,
    /// Modulation of a pin per force, 1/N; 0 for no vibration.
    pub roughness: f64,
}

impl Default for Texture {
    /// A plain weave with a period of half a millimetre (an assumption).
    fn default() -> Self {
        Self { period: 5e-4, roughness: 10.0 }
    }
}

/// Fraction of a pin's largest force up to which its response is linear.
const LINEAR_RANGE: f64 = 0.7;
/// Largest depth of the modulation.
const MAX_MODULATION: f64 = 0.5;
/// Slip speed at which the modulation has half of its depth, m/s.
const HALF_SPEED: f64 = 0.01;
/// Frequencies, as fractions of the update rate, between which the vibration fades to zero; 0.5 is the Nyquist limit.
const FADE: [f64; 2] = [0.4, 0.5];

/// State of one tactile pad.
#[derive(Clone, Debug)]
pub struct TactilePad {
    array: TaxelArray,
    /// The pad's unit axes in those of the hand: along the finger, across it, and outwards.
    axes: [Vec3; 3],
    texture: Texture,
    /// Requested force of each pin, N (rows x columns).
    pressed: Vec<f64>,
    /// Rendered force of each pin, after its response, N (rows x columns).
    pub taxels: Vec<f64>,
    /// Phase of the vibration at the centre of the pad, in cycles.
    phase: f64,
    /// Force outside of the array in the last step, N.
    pub beside: f64,
    /// Force above the pins' range in the last step, N.
    pub clipped: f64,
}

impl TactilePad {
    /// The pad of an effector with a tactile array: it faces -z of the effector's axes, with the finger along y. `None` without an array.
    pub fn of(info: &DeviceInfo) -> Option<Self> {
        let (rows, columns) = (info.taxel_rows as usize, info.taxel_columns as usize);
        let sound = |v: f64| v.is_finite() && v > 0.0;
        let array = TaxelArray { rows, columns, pitch: info.taxel_pitch, limit: info.taxel_force };
        let there = rows * columns > 0 && sound(array.pitch) && sound(array.limit);
        there.then(|| Self::new(array, Vec3::new(0.0, 0.0, -1.0), Vec3::y(), Texture::default()))
    }

    /// A pad with these unit vectors outwards and along the finger, in axes of the hand.
    pub fn new(array: TaxelArray, outward: Vec3, along: Vec3, texture: Texture) -> Self {
        let out = outward.try_normalize(0.0).unwrap_or_else(Vec3::z);
        let along = (along - along.dot(&out) * out).try_normalize(1e-9);
        let along = along.unwrap_or_else(|| out.cross(&Vec3::ith(out.iamin(), 1.0)).normalize());
        let axes = [along, out.cross(&along), out];
        let pins = vec![0.0; array.rows * array.columns];
        Self { array, axes, texture, pressed: pins.clone(), taxels: pins, phase: 0.0, beside: 0.0, clipped: 0.0 }
    }

    /// The array of taxels whose values this computes.
    pub fn array(&self) -> TaxelArray {
        self.array
    }

    /// Begins a step: sets all forces to zero.
    pub fn begin(&mut self) {
        self.pressed.fill(0.0);
        self.beside = 0.0;
    }

    /// Adds a contact of a ball with this radius (m) and rotation: a force of magnitude `size` (N) at the surface point in `direction` (a unit
    /// vector in axes of the scene) from its centre.
    pub fn press(&mut self, rotation: &UnitQuaternion<f64>, radius: f64, direction: Vec3, size: f64) {
        let d = rotation.inverse() * direction;
        let Some(d) = d.try_normalize(1e-12).filter(|_| size > 0.0 && size.is_finite()) else { return };
        let [t1, t2, out] = self.axes.map(|axis| d.dot(&axis));
        let angle = libm::acos(out.clamp(-1.0, 1.0));
        let scale = if angle < 1e-6 { radius } else { radius * angle / libm::sin(angle) };
        // The back of the finger has no pins.
        if angle > FRAC_PI_2 || !self.splat(scale * t1, scale * t2, size) {
            self.beside += size;
        }
    }

    /// Distributes a force (N) to the four pins around a point of the pad, in m from its centre. Returns whether the point is within the array.
    fn splat(&mut self, along: f64, across: f64, size: f64) -> bool {
        let place = |at: f64, count: usize| {
            let at = at / self.array.pitch + 0.5 * (count as f64 - 1.0);
            let inside = (-1e-9..=count as f64 - 1.0 + 1e-9).contains(&at);
            let low = (at.max(0.0) as usize).min(count.saturating_sub(2));
            inside.then(|| (low, (at - low as f64).clamp(0.0, 1.0)))
        };
        let (rows, columns) = (self.array.rows, self.array.columns);
        let (Some((row, u)), Some((column, v))) = (place(along, rows), place(across, columns)) else { return false };
        for (i, share_i) in [(row, 1.0 - u), (row + 1, u)] {
            for (j, share_j) in [(column, 1.0 - v), (column + 1, v)] {
                if i < rows && j < columns {
                    self.pressed[i * columns + j] += share_i * share_j * size;
                }
            }
        }
        true
    }

    /// Ends a step of `dt` (s) with the slip velocity `slip` (m/s) and computes the rendered forces.
    pub fn end(&mut self, rotation: &UnitQuaternion<f64>, slip: Vec3, dt: f64) {
        let slip = rotation.inverse() * slip;
        let [along, across] = [self.axes[0], self.axes[1]].map(|axis| slip.dot(&axis));
        // A slip that is not finite counts as zero.
        let speed = Some(libm::hypot(along, across)).filter(|speed| speed.is_finite()).unwrap_or(0.0);
        let frequency = speed / self.texture.period;
        self.phase = (self.phase + frequency * dt).fract();
        let [fade, over] = FADE.map(|share| share / dt);
        let faded = ((over - frequency) / (over - fade)).clamp(0.0, 1.0);
        let felt = if speed > 0.0 { faded * speed / (speed + HALF_SPEED) } else { 0.0 };
        self.clipped = 0.0;
        if self.pressed.iter().all(|force| *force == 0.0) {
            self.taxels.fill(0.0);
            return;
        }
        for i in 0..self.array.rows {
            for j in 0..self.array.columns {
                let pin = i * self.array.columns + j;
                let force = self.pressed[pin];
                // A thread passes one pin after the other, so the phase varies over the pad.
                let ahead = self.array.pitch * (i as f64 * along + j as f64 * across);
                let place = if speed > 0.0 { ahead / speed / self.texture.period } else { 0.0 };
                let depth = (self.texture.roughness * force).min(MAX_MODULATION) * felt;
                let wanted = force * (1.0 + depth * libm::sin(TAU * (self.phase - place)));
                let given = respond(wanted, self.array.limit);
                self.clipped += wanted - given;
                self.taxels[pin] = given;
            }
        }
    }
}

/// Response of a pin with the limit `limit` to a requested force, both in N: linear up to 70 % of the limit, then saturating with a continuous
/// slope.
fn respond(force: f64, limit: f64) -> f64 {
    let (knee, room) = (LINEAR_RANGE * limit, (1.0 - LINEAR_RANGE) * limit);
    if force <= knee { force.max(0.0) } else { limit - room * libm::exp(-(force - knee) / room) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 8e-3;

    fn pad() -> TactilePad {
        let array = TaxelArray { rows: 5, columns: 6, pitch: 2.5e-3, limit: 0.073 };
        TactilePad::new(array, Vec3::z(), Vec3::x(), Texture::default())
    }

    fn still() -> UnitQuaternion<f64> {
        UnitQuaternion::identity()
    }

    /// Direction of a point of the pad with these coordinates along and across the finger, m.
    fn towards(along: f64, across: f64) -> Vec3 {
        let angle = along.hypot(across) / RADIUS;
        let (a, b) = if angle > 0.0 { (along / (angle * RADIUS), across / (angle * RADIUS)) } else { (0.0, 0.0) };
        Vec3::new(a * angle.sin(), b * angle.sin(), angle.cos())
    }

    fn centroid(pad: &TactilePad) -> [f64; 2] {
        let (mut sum, mut at) = (0.0, [0.0; 2]);
        for (pin, force) in pad.taxels.iter().enumerate() {
            let (i, j) = (pin / 6, pin % 6);
            sum += force;
            at[0] += force * 2.5e-3 * (i as f64 - 2.0);
            at[1] += force * 2.5e-3 * (j as f64 - 2.5);
        }
        at.map(|c| c / sum)
    }

    #[test]
    fn pins_render_the_normal_force_with_the_contact_as_centroid() {
        let mut pad = pad();
        for (along, across) in [(0.0, 0.0), (1e-3, -2e-3), (-4.9e-3, 6.1e-3), (5e-3, -6.25e-3)] {
            pad.begin();
            pad.press(&still(), RADIUS, towards(along, across), 0.04);
            pad.end(&still(), Vec3::zeros(), 1e-3);
            assert!((pad.taxels.iter().sum::<f64>() - 0.04).abs() < 1e-15 && pad.beside == 0.0 && pad.clipped == 0.0);
            let at = centroid(&pad);
            assert!((at[0] - along).abs() < 1e-12 && (at[1] - across).abs() < 1e-12, "{at:?}");
        }
    }

    #[test]
    fn forces_outside_of_the_array_are_counted_and_not_rendered() {
        let mut pad = pad();
        for direction in [towards(9e-3, 0.0), Vec3::new(0.0, 0.0, -1.0), towards(0.0, 6.4e-3)] {
            pad.begin();
            pad.press(&still(), RADIUS, direction, 0.02);
            pad.end(&still(), Vec3::zeros(), 1e-3);
            assert!(pad.beside == 0.02 && pad.taxels.iter().all(|t| *t == 0.0), "{direction:?}");
        }
    }

    #[test]
    fn pin_forces_stay_within_their_limit() {
        let mut pad = pad();
        let mut last = 0.0;
        for size in [0.0, 0.03, 0.06, 0.1, 1.0, 1e9, f64::INFINITY, f64::NAN, -1.0] {
            pad.begin();
            pad.press(&still(), RADIUS, towards(0.0, 1.25e-3), size);
            pad.end(&still(), Vec3::new(0.0, 0.1, 0.0), 1e-3);
            assert!(pad.taxels.iter().all(|t| (0.0..=0.073).contains(t)), "{size}");
        }
        for step in 0..200 {
            let given = respond(f64::from(step) * 1e-3, 0.073);
            assert!(given > last || step == 0 || given == 0.073, "rises: {given}");
            last = given;
        }
        assert_eq!(respond(0.05, 0.073), 0.05);
    }

    #[test]
    fn a_symmetric_contact_gives_a_symmetric_pattern() {
        let mut pad = pad();
        pad.begin();
        for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            pad.press(&still(), RADIUS, towards(a * 1.7e-3, b * 3.1e-3), 0.01);
        }
        pad.end(&still(), Vec3::zeros(), 1e-3);
        for i in 0..5 {
            for j in 0..6 {
                let [here, mirrored] = [pad.taxels[i * 6 + j], pad.taxels[(4 - i) * 6 + 5 - j]];
                assert!((here - mirrored).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn slip_over_threads_vibrates_with_speed_over_period() {
        let mut pad = pad();
        let (mut crossings, mut above) = (0, false);
        // A slip of 100 mm/s over a period of 0.5 mm gives 200 Hz; one second is simulated.
        for _ in 0..1000 {
            pad.begin();
            pad.press(&still(), RADIUS, towards(0.0, 1.25e-3), 0.04);
            pad.end(&still(), Vec3::new(0.1, 0.0, 0.0), 1e-3);
            let now = pad.taxels[2 * 6 + 3] > 0.04;
            crossings += usize::from(now && !above);
            above = now;
        }
        assert!((199..=201).contains(&crossings), "{crossings} Hz");
        // Above the Nyquist frequency nothing is rendered.
        pad.begin();
        pad.press(&still(), RADIUS, towards(0.0, 1.25e-3), 0.04);
        pad.end(&still(), Vec3::new(0.3, 0.0, 0.0), 1e-3);
        assert_eq!(pad.taxels[2 * 6 + 3], 0.04);
    }

    #[test]
    fn a_rotated_finger_gets_the_same_forces_on_its_pad() {
        let turn = UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0);
        let (mut straight, mut turned) = (pad(), pad());
        let direction = towards(1e-3, 2e-3);
        let other = turn * direction;
        for (pad, rotation, direction) in [(&mut straight, still(), direction), (&mut turned, turn, other)] {
            pad.begin();
            pad.press(&rotation, RADIUS, direction, 0.05);
            pad.end(&rotation, Vec3::zeros(), 1e-3);
        }
        let differ = straight.taxels.iter().zip(&turned.taxels).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(differ < 1e-15, "{differ}");
    }
}
