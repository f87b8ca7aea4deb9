//! What a tactile array under a fingertip shows of a contact: where it presses, and the buzz of threads that slip by.
//!
//! The pressed places of a ball are laid out on the pad by arc length, and each force goes to the four pins around its place with
//! bilinear shares, so forces are kept, and a contact that moves takes the centroid with it (docs/devices.md). What lies beside the
//! array is counted and not shown. Close to the limit of a pin the response bends and never passes it. Slip over a weave of
//! period L at speed u modulates the pins with the frequency u/L (Tripicchio, D'Avella and Ruffaldi 2022 describe the array; the
//! rendering is ours).

use nalgebra::UnitQuaternion;
use pliant_plugin_api::abi::DeviceInfo;
use pliant_solver::Vec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// The pins of one array, as a device describes them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaxelArray {
    /// Along the finger.
    pub rows: usize,
    /// Across it.
    pub columns: usize,
    /// Pitch, m.
    pub pitch: f64,
    /// Largest force of one pin, N.
    pub most: f64,
}

/// How a surface feels when it slips by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Period from one thread to the next, m.
    pub period: f64,
    /// Modulation of a pin at 1 N, 1/N; nothing is felt at 0.
    pub roughness: f64,
}

impl Default for Texture {
    /// A plain weave of half a millimetre. An assumption.
    fn default() -> Self {
        Self { period: 5e-4, roughness: 10.0 }
    }
}

/// The part of a pin's range that is linear.
const LINEAR: f64 = 0.7;
/// Most a slip modulates.
const DEEPEST: f64 = 0.5;
/// m/s, slip at which half of the modulation is felt
const SLOW: f64 = 0.01;
/// Share of the update rate above which a buzz is faded out, and where nothing is left of it.
const FADE: [f64; 2] = [0.4, 0.5];

/// What one pad shows.
#[derive(Clone, Debug)]
pub struct TactilePad {
    array: TaxelArray,
    /// The pad's axes in those of the hand: along the finger, across it, and out of it.
    axes: [Vec3; 3],
    texture: Texture,
    /// N, before the response of the pins (rows x columns)
    pressed: Vec<f64>,
    /// N, as given to the device (rows x columns)
    pub taxels: Vec<f64>,
    /// Cycles, of the buzz; the same for all pins but for their places.
    phase: f64,
    /// Force beside the array, and force that pins could not give, in the last step, N.
    pub beside: f64,
    /// See `beside`.
    pub clipped: f64,
}

impl TactilePad {
    /// The pad of an effector: it faces -z of the effector's own axes, and the finger goes along y.
    pub fn of(info: &DeviceInfo) -> Option<Self> {
        let (rows, columns) = (info.taxel_rows as usize, info.taxel_columns as usize);
        let sound = |v: f64| v.is_finite() && v > 0.0;
        let array = TaxelArray { rows, columns, pitch: info.taxel_pitch, most: info.taxel_force };
        let there = rows * columns > 0 && sound(array.pitch) && sound(array.most);
        there.then(|| Self::new(array, Vec3::new(0.0, 0.0, -1.0), Vec3::y(), Texture::default()))
    }

    /// A pad whose outward direction and direction along the finger are given in axes of the hand.
    pub fn new(array: TaxelArray, outward: Vec3, along: Vec3, texture: Texture) -> Self {
        let out = outward.try_normalize(0.0).unwrap_or_else(Vec3::z);
        let along = (along - along.dot(&out) * out).try_normalize(1e-9);
        let along = along.unwrap_or_else(|| out.cross(&Vec3::ith(out.iamin(), 1.0)).normalize());
        let axes = [along, out.cross(&along), out];
        let pins = vec![0.0; array.rows * array.columns];
        Self { array, axes, texture, pressed: pins.clone(), taxels: pins, phase: 0.0, beside: 0.0, clipped: 0.0 }
    }

    /// The array it was made for.
    pub fn array(&self) -> TaxelArray {
        self.array
    }

    /// A step begins: nothing is pressed.
    pub fn begin(&mut self) {
        self.pressed.fill(0.0);
        self.beside = 0.0;
    }

    /// A ball of `radius` (m), turned by `rotation`, is pressed with `size` (N) at a place in `direction` from its centre.
    pub fn press(&mut self, rotation: &UnitQuaternion<f64>, radius: f64, direction: Vec3, size: f64) {
        let d = rotation.inverse() * direction;
        let Some(d) = d.try_normalize(1e-12).filter(|_| size > 0.0 && size.is_finite()) else { return };
        let [t1, t2, out] = self.axes.map(|axis| d.dot(&axis));
        let angle = libm::acos(out.clamp(-1.0, 1.0));
        let scale = if angle < 1e-6 { radius } else { radius * angle / libm::sin(angle) };
        // The far side of the finger has no pins.
        if angle > FRAC_PI_2 || !self.splat(scale * t1, scale * t2, size) {
            self.beside += size;
        }
    }

    /// Shares a force over the four pins around a place on the pad, m from its middle; `false` beside them.
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

    /// Ends a step of `dt` (s) in which the surface slipped by at `slip` (m/s), and sets what the pins give.
    pub fn end(&mut self, rotation: &UnitQuaternion<f64>, slip: Vec3, dt: f64) {
        let slip = rotation.inverse() * slip;
        let [along, across] = [self.axes[0], self.axes[1]].map(|axis| slip.dot(&axis));
        // A slip that is not a number is none.
        let speed = Some(libm::hypot(along, across)).filter(|speed| speed.is_finite()).unwrap_or(0.0);
        let frequency = speed / self.texture.period;
        self.phase = (self.phase + frequency * dt).fract();
        let [fade, over] = FADE.map(|share| share / dt);
        let faded = ((over - frequency) / (over - fade)).clamp(0.0, 1.0);
        let felt = if speed > 0.0 { faded * speed / (speed + SLOW) } else { 0.0 };
        self.clipped = 0.0;
        if self.pressed.iter().all(|force| *force == 0.0) {
            self.taxels.fill(0.0);
            return;
        }
        for i in 0..self.array.rows {
            for j in 0..self.array.columns {
                let pin = i * self.array.columns + j;
                let force = self.pressed[pin];
                // A thread reaches one pin after the other.
                let ahead = self.array.pitch * (i as f64 * along + j as f64 * across);
                let place = if speed > 0.0 { ahead / speed / self.texture.period } else { 0.0 };
                let depth = (self.texture.roughness * force).min(DEEPEST) * felt;
                let wanted = force * (1.0 + depth * libm::sin(TAU * (self.phase - place)));
                let given = respond(wanted, self.array.most);
                self.clipped += wanted - given;
                self.taxels[pin] = given;
            }
        }
    }
}

/// What a pin gives that is asked for a force: the same up to 70 % of its most, then ever less more, with one tangent, N.
fn respond(force: f64, most: f64) -> f64 {
    let (knee, room) = (LINEAR * most, (1.0 - LINEAR) * most);
    if force <= knee { force.max(0.0) } else { most - room * libm::exp(-(force - knee) / room) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 8e-3;

    fn pad() -> TactilePad {
        let array = TaxelArray { rows: 5, columns: 6, pitch: 2.5e-3, most: 0.073 };
        TactilePad::new(array, Vec3::z(), Vec3::x(), Texture::default())
    }

    fn still() -> UnitQuaternion<f64> {
        UnitQuaternion::identity()
    }

    /// Direction of a place on the pad, m along and across.
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
    fn the_pins_give_the_normal_force_and_their_centroid_is_the_contact() {
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
    fn what_is_beside_the_array_is_counted_and_not_shown() {
        let mut pad = pad();
        for direction in [towards(9e-3, 0.0), Vec3::new(0.0, 0.0, -1.0), towards(0.0, 6.4e-3)] {
            pad.begin();
            pad.press(&still(), RADIUS, direction, 0.02);
            pad.end(&still(), Vec3::zeros(), 1e-3);
            assert!(pad.beside == 0.02 && pad.taxels.iter().all(|t| *t == 0.0), "{direction:?}");
        }
    }

    #[test]
    fn whatever_presses_the_pins_stay_within_what_they_can() {
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
    fn threads_that_slip_by_buzz_with_speed_over_period() {
        let mut pad = pad();
        let (mut crossings, mut above) = (0, false);
        // 100 mm/s over threads of 0.5 mm: 200 Hz, for a second.
        for _ in 0..1000 {
            pad.begin();
            pad.press(&still(), RADIUS, towards(0.0, 1.25e-3), 0.04);
            pad.end(&still(), Vec3::new(0.1, 0.0, 0.0), 1e-3);
            let now = pad.taxels[2 * 6 + 3] > 0.04;
            crossings += usize::from(now && !above);
            above = now;
        }
        assert!((199..=201).contains(&crossings), "{crossings} Hz");
        // Faster than the rate can carry nothing is left of it.
        pad.begin();
        pad.press(&still(), RADIUS, towards(0.0, 1.25e-3), 0.04);
        pad.end(&still(), Vec3::new(0.3, 0.0, 0.0), 1e-3);
        assert_eq!(pad.taxels[2 * 6 + 3], 0.04);
    }

    #[test]
    fn a_turned_finger_feels_the_same_on_its_own_pad() {
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
