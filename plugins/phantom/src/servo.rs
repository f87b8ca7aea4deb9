//! What runs on the driver's servo thread: each tick, for each arm, one frame: read, set the force, pop the errors.
//!
//! Nothing here waits, allocates, or calls anything but the driver. Force is set in every tick, as the driver clears it at the
//! begin of a frame; every frame that is begun is ended; a callback that stalls or an arm that is lost leaves no force behind.
#![allow(unsafe_code, reason = "calls a C library; each call says what makes it sound")]

use crate::errors::{self, Class};
use crate::hd::{self, Api, Handle, get, switch};
use crate::snapshot::Snapshot;
use core::ffi::c_void;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::time::Instant;

/// Most arms of one driver.
pub const MOST_ARMS: usize = 2;
/// ns without an error of force before output is switched on again, and over which force then grows.
const REST: u64 = 100_000_000;
const RAMP: u64 = 200_000_000;
/// Millimetres in a metre.
const MM: f64 = 1e-3;

/// What counts for one arm.
#[derive(Default)]
pub struct Counts {
    /// Ticks of the servo loop.
    pub ticks: AtomicU64,
    /// Errors by class: force, lost, usage and frame.
    pub force: AtomicU64,
    /// See `force`.
    pub lost: AtomicU64,
    /// See `force`.
    pub usage: AtomicU64,
    /// Times it was opened again.
    pub recovered: AtomicU64,
    /// The newest code.
    pub newest: AtomicU32,
}

/// One arm, between the servo thread and the host.
pub struct Arm {
    /// The driver's handle; [`hd::INVALID_HANDLE`] while it is lost.
    pub handle: AtomicU32,
    /// The same, kept when it is lost: it is still to be given back.
    pub held: AtomicU32,
    /// ns, buttons, inkwell; then position (m), orientation x y z w, velocity (m/s), as bits.
    state: Snapshot<13>,
    /// N as bits, and until when, ns.
    command: Snapshot<4>,
    stopped: AtomicBool,
    /// N as bits, what was set in the last tick.
    set: Snapshot<3>,
    /// N, as bits
    peak: AtomicU64,
    /// ns, the last error of force; and since when output is on
    trouble: AtomicU64,
    on_since: AtomicU64,
    output: AtomicBool,
    /// What happened.
    pub counts: Counts,
}

impl Default for Arm {
    fn default() -> Self {
        Self {
            handle: AtomicU32::new(hd::INVALID_HANDLE),
            held: AtomicU32::new(hd::INVALID_HANDLE),
            state: Snapshot::default(),
            command: Snapshot::default(),
            stopped: AtomicBool::new(false),
            set: Snapshot::default(),
            peak: AtomicU64::new(0),
            trouble: AtomicU64::new(0),
            on_since: AtomicU64::new(0),
            output: AtomicBool::new(false),
            counts: Counts::default(),
        }
    }
}

/// Where an arm was.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// ns
    pub time: u64,
    /// Bit i is button i.
    pub buttons: u32,
    /// The stylus is in the inkwell.
    pub inkwell: bool,
    /// m
    pub position: [f64; 3],
    /// Unit quaternion x y z w.
    pub orientation: [f64; 4],
    /// m/s
    pub velocity: [f64; 3],
}

impl Arm {
    /// Where it was in the last tick; `None` before the first.
    pub fn state(&self) -> Option<State> {
        let words = self.state.read().filter(|w| w[0] != 0)?;
        let n = |i: usize| f64::from_bits(words[i]);
        Some(State {
            time: words[0],
            buttons: words[1] as u32,
            inkwell: words[2] != 0,
            position: [n(3), n(4), n(5)],
            orientation: [n(6), n(7), n(8), n(9)],
            velocity: [n(10), n(11), n(12)],
        })
    }

    /// Takes a force (N) until a time (ns).
    pub fn command(&self, force: [f64; 3], until: u64) {
        let [x, y, z] = force.map(f64::to_bits);
        self.command.write([x, y, z, until]);
        self.stopped.store(false, Ordering::Release);
    }

    /// Zero from the next tick on.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Release);
    }

    /// N, what was set in the last tick.
    pub fn set(&self) -> [f64; 3] {
        self.set.read().unwrap_or_default().map(f64::from_bits)
    }

    /// N, the most it may be given.
    pub fn limit(&self, peak: f64) {
        self.peak.store(peak.to_bits(), Ordering::Relaxed);
    }

    /// It was opened: output is on from `now` (ns), and force grows.
    pub fn opened(&self, handle: Handle, now: u64) {
        self.on_since.store(now.max(1), Ordering::Relaxed);
        self.output.store(true, Ordering::Relaxed);
        self.held.store(handle, Ordering::Relaxed);
        self.handle.store(handle, Ordering::Release);
    }

    /// N, what it is to be given at `now` (ns): what was asked for while it holds, within its peak, and grown in slowly.
    fn due(&self, now: u64) -> [f64; 3] {
        let Some([x, y, z, until]) = self.command.read() else { return [0.0; 3] };
        let force = [x, y, z].map(f64::from_bits);
        if self.stopped.load(Ordering::Acquire) || now >= until || !force.iter().all(|f| f.is_finite()) {
            return [0.0; 3];
        }
        let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
        let peak = f64::from_bits(self.peak.load(Ordering::Relaxed));
        let on = now.saturating_sub(self.on_since.load(Ordering::Relaxed));
        let ramp = (on as f64 / RAMP as f64).min(1.0);
        let scale = if size > peak { peak / size } else { 1.0 };
        let scale = if size.is_finite() { ramp * scale } else { 0.0 };
        force.map(|f| scale * f)
    }
}

/// What the callback is given.
pub struct Servo {
    /// The driver.
    pub api: Api,
    /// Those in use.
    pub arms: [Arm; MOST_ARMS],
    /// When time began.
    pub start: Instant,
    /// ns, of the last tick
    pub ticked: AtomicU64,
    /// The arms are to be left without force, and their output switched off.
    pub closing: AtomicBool,
    /// The callback has seen `closing`.
    pub closed: AtomicBool,
    /// Whether the inkwell keeps force away.
    pub rests: bool,
}

impl Servo {
    /// ns
    pub fn now(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    /// The callback.
    ///
    /// # Safety
    /// `data` is a `Servo` that lives until the callback was taken off the scheduler.
    pub unsafe extern "C" fn tick(data: *mut c_void) -> u32 {
        // SAFETY: the caller's promise; everything in it may be shared.
        let servo = unsafe { &*data.cast::<Self>() };
        // Atomics and calls of the driver only: there is nothing here that panics.
        servo.run();
        hd::CONTINUE
    }

    fn run(&self) {
        let now = self.now();
        let closing = self.closing.load(Ordering::Acquire);
        for arm in &self.arms {
            let handle = arm.handle.load(Ordering::Acquire);
            if handle != hd::INVALID_HANDLE {
                self.frame(arm, handle, closing, now);
            }
        }
        self.ticked.store(now.max(1), Ordering::Release);
        if closing {
            self.closed.store(true, Ordering::Release);
        }
    }

    fn frame(&self, arm: &Arm, handle: Handle, closing: bool, now: u64) {
        let api = &self.api;
        // SAFETY: published prototypes, on the driver's own thread, inside of one frame.
        unsafe {
            (api.make_current)(handle);
            (api.begin_frame)(handle);
        }
        let transform = api.numbers(get::TRANSFORM);
        let velocity = api.numbers(get::VELOCITY);
        let (buttons, inkwell) = (api.integer(get::BUTTONS), api.boolean(get::INKWELL));
        let off = closing || !arm.output.load(Ordering::Relaxed) || (inkwell && self.rests);
        let force = if off { [0.0; 3] } else { arm.due(now) };
        // SAFETY: as above; three numbers.
        unsafe {
            (api.set_doubles)(get::SET_FORCE, force.as_ptr());
            (api.end_frame)(handle);
        }
        arm.counts.ticks.fetch_add(1, Ordering::Relaxed);
        arm.set.write(force.map(f64::to_bits));
        let sound = self.errors(arm, now);
        if sound && transform[..15].iter().chain(&velocity[..3]).all(|n| n.is_finite()) {
            let position = [12, 13, 14].map(|i: usize| transform[i] * MM);
            let (q, v) = (quaternion(&transform), [0, 1, 2].map(|i: usize| velocity[i] * MM));
            let mut words = [0; 13];
            (words[0], words[1], words[2]) = (now.max(1), buttons as u32 as u64, u64::from(inkwell));
            let numbers = position.iter().chain(&q).chain(&v);
            words[3..].iter_mut().zip(numbers).for_each(|(to, n)| *to = n.to_bits());
            arm.state.write(words);
        }
        self.switch(arm, closing, now);
    }

    /// Pops what the frame left and does what each class asks for; gives whether its readings can be used.
    fn errors(&self, arm: &Arm, now: u64) -> bool {
        let mut sound = true;
        for _ in 0..16 {
            let Some(error) = self.api.pop() else { break };
            arm.counts.newest.store(error.code, Ordering::Relaxed);
            match errors::class(error.code) {
                Class::Force => {
                    arm.counts.force.fetch_add(1, Ordering::Relaxed);
                    arm.trouble.store(now, Ordering::Relaxed);
                }
                Class::Lost | Class::Unknown | Class::Licence => {
                    arm.counts.lost.fetch_add(1, Ordering::Relaxed);
                    arm.handle.store(hd::INVALID_HANDLE, Ordering::Release);
                    arm.set.write([0; 3]);
                    sound = false;
                }
                Class::Usage | Class::Frame | Class::Scheduler => {
                    arm.counts.usage.fetch_add(1, Ordering::Relaxed);
                    sound = false;
                }
            }
        }
        sound
    }

    /// Output off after an error of force, and on again when it has been quiet: inside of the callback, where it belongs.
    fn switch(&self, arm: &Arm, closing: bool, now: u64) {
        let on = arm.output.load(Ordering::Relaxed);
        let trouble = arm.trouble.load(Ordering::Relaxed);
        let quiet = trouble == 0 || now.saturating_sub(trouble) >= REST;
        // SAFETY: as above.
        unsafe {
            if on && (closing || !quiet) {
                (self.api.disable)(switch::FORCE_OUTPUT);
                arm.output.store(false, Ordering::Relaxed);
            } else if !on && !closing && quiet {
                (self.api.enable)(switch::FORCE_OUTPUT);
                arm.on_since.store(now, Ordering::Relaxed);
                arm.output.store(true, Ordering::Relaxed);
            }
        }
    }
}

/// x y z w of the rotation in a transform, column major (Shepperd 1978); none where it is no rotation.
fn quaternion(m: &[f64; 16]) -> [f64; 4] {
    let at = |row: usize, column: usize| m[4 * column + row];
    let trace = at(0, 0) + at(1, 1) + at(2, 2);
    let mut q = [0.0; 4];
    let largest = (0..3).fold(3, |best, i| {
        let value = |i: usize| if i == 3 { trace } else { at(i, i) };
        if value(i) > value(best) { i } else { best }
    });
    if largest == 3 {
        q[3] = 1.0 + trace;
        for i in 0..3 {
            q[i] = at((i + 2) % 3, (i + 1) % 3) - at((i + 1) % 3, (i + 2) % 3);
        }
    } else {
        let (i, j, k) = (largest, (largest + 1) % 3, (largest + 2) % 3);
        q[i] = 1.0 + at(i, i) - at(j, j) - at(k, k);
        q[j] = at(j, i) + at(i, j);
        q[k] = at(k, i) + at(i, k);
        q[3] = at(k, j) - at(j, k);
    }
    let size = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if size > 1e-9 { q.map(|c| c / size) } else { [0.0, 0.0, 0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Column-major matrix of a unit quaternion.
    fn matrix([x, y, z, w]: [f64; 4]) -> [f64; 16] {
        let rows = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        std::array::from_fn(|i| if i % 4 < 3 && i / 4 < 3 { rows[i % 4][i / 4] } else { 0.0 })
    }

    #[test]
    fn transforms_turn_into_their_quaternions() {
        for q in [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.5, 0.5, -0.5, 0.5], [0.1, -0.7, 0.7, 0.1]] {
            let size = q.iter().map(|c: &f64| c * c).sum::<f64>().sqrt();
            let q = q.map(|c| c / size);
            let found = quaternion(&matrix(q));
            let same: f64 = q.iter().zip(found).map(|(a, b)| a * b).sum();
            assert!((same.abs() - 1.0).abs() < 1e-12, "{q:?} {found:?}");
        }
        assert_eq!(quaternion(&[0.0; 16])[3], 1.0);
    }

    #[test]
    fn a_force_holds_until_its_time_grows_in_and_stays_within_the_peak() {
        let arm = Arm::default();
        arm.limit(3.3);
        arm.opened(1, 1);
        arm.command([33.0, 0.0, 0.0], 2 * RAMP);
        assert!((arm.due(RAMP / 2)[0] - 1.65).abs() < 1e-6 && (arm.due(RAMP + 1)[0] - 3.3).abs() < 1e-12);
        assert_eq!(arm.due(2 * RAMP), [0.0; 3]);
        arm.command([f64::NAN, 0.0, 0.0], u64::MAX);
        assert_eq!(arm.due(RAMP + 1), [0.0; 3]);
        arm.command([1.0, 0.0, 0.0], u64::MAX);
        arm.stop();
        assert_eq!(arm.due(RAMP + 1), [0.0; 3]);
    }
}
