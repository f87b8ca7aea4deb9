//! The state of one arm that the servo thread and the host share.

use crate::hd::{self, Handle};
use crate::seqlock::SeqLock;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

/// Time without a force error before the output is switched on again, ns.
pub(crate) const FORCE_ERROR_PAUSE_NS: u64 = 100_000_000;
/// Time over which the force rises after the output was switched on, ns.
pub(crate) const FORCE_RAMP_NS: u64 = 200_000_000;

/// Counters of one arm.
#[derive(Default)]
pub struct ArmCounters {
    /// Ticks of the servo loop.
    pub ticks: AtomicU64,
    /// Errors of the class `Force`.
    pub force_errors: AtomicU64,
    /// Errors after which the arm counted as lost.
    pub losses: AtomicU64,
    /// Errors of the classes `Usage`, `Frame` and `Scheduler`.
    pub usage_errors: AtomicU64,
    /// Times the arm was opened again.
    pub recoveries: AtomicU64,
    /// The code of the last error; 0 before the first.
    pub newest_code: AtomicU32,
}

/// One arm. The servo thread writes `state` and `applied_force`, the host `command`; the thread that opens the arm writes the handles.
pub struct Arm {
    /// Handle for the servo loop; [`hd::INVALID_HANDLE`] if the arm is not open or lost.
    pub(crate) handle: AtomicU32,
    /// Handle that must be closed before the arm is opened again; kept when the arm is lost.
    pub(crate) unclosed_handle: AtomicU32,
    /// [`ArmState`] as words; all 0 before the first tick.
    state: SeqLock<13>,
    /// The commanded force (N, as bits) and when it expires (ns).
    command: SeqLock<4>,
    /// Whether the force must be zero until the next command.
    is_stopped: AtomicBool,
    /// The force the last tick gave to the driver, N, as bits.
    applied_force: SeqLock<3>,
    /// Largest force, N, as bits.
    peak_force: AtomicU64,
    /// Time of the last force error, ns; 0 before the first.
    pub(crate) force_error_ns: AtomicU64,
    /// Whether the force output is on.
    pub(crate) is_output_on: AtomicBool,
    /// Time since which it is on, ns.
    pub(crate) output_on_since_ns: AtomicU64,
    /// Servo ticks, errors and recoveries since the arm was opened.
    pub counters: ArmCounters,
}

impl Default for Arm {
    fn default() -> Self {
        Self {
            handle: AtomicU32::new(hd::INVALID_HANDLE),
            unclosed_handle: AtomicU32::new(hd::INVALID_HANDLE),
            state: SeqLock::default(),
            command: SeqLock::default(),
            is_stopped: AtomicBool::new(false),
            applied_force: SeqLock::default(),
            peak_force: AtomicU64::new(0),
            force_error_ns: AtomicU64::new(0),
            is_output_on: AtomicBool::new(false),
            output_on_since_ns: AtomicU64::new(0),
            counters: ArmCounters::default(),
        }
    }
}

/// What the driver reports of an arm in one tick.
#[derive(Clone, Copy, Debug)]
pub struct ArmState {
    /// Time of the tick, ns since the driver was opened.
    pub time_ns: u64,
    /// Pressed buttons; bit i is button i.
    pub buttons: u32,
    /// Whether the stylus is in the inkwell.
    pub in_inkwell: bool,
    /// Position of the tip, m.
    pub position: [f64; 3],
    /// Orientation of the stylus, a unit quaternion x y z w.
    pub orientation: [f64; 4],
    /// Velocity of the tip, m/s.
    pub velocity: [f64; 3],
}

impl ArmState {
    fn to_words(self) -> [u64; 13] {
        let numbers = self.position.iter().chain(&self.orientation).chain(&self.velocity);
        let mut words = [0; 13];
        words[0] = self.time_ns;
        words[1] = u64::from(self.buttons);
        words[2] = u64::from(self.in_inkwell);
        words[3..].iter_mut().zip(numbers).for_each(|(word, n)| *word = n.to_bits());
        words
    }

    fn from_words(words: [u64; 13]) -> Self {
        let number = |i: usize| f64::from_bits(words[i]);
        Self {
            time_ns: words[0],
            buttons: words[1] as u32,
            in_inkwell: words[2] != 0,
            position: [number(3), number(4), number(5)],
            orientation: [number(6), number(7), number(8), number(9)],
            velocity: [number(10), number(11), number(12)],
        }
    }
}

impl Arm {
    /// The state of the last tick; `None` before the first, or if every attempt to read met a write.
    pub fn state(&self) -> Option<ArmState> {
        self.state.read().filter(|words| words[0] != 0).map(ArmState::from_words)
    }

    /// Publishes the state of a tick, whose time must not be 0.
    pub(crate) fn set_state(&self, state: ArmState) {
        self.state.write(state.to_words());
    }

    /// Commands a force (N) until a time (ns since the driver was opened); ends a stop.
    pub fn command(&self, force: [f64; 3], expires_ns: u64) {
        let [x, y, z] = force.map(f64::to_bits);
        self.command.write([x, y, z, expires_ns]);
        self.is_stopped.store(false, Ordering::Release);
    }

    /// Commands zero force, from the next tick on.
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Release);
    }

    /// The force the last tick gave to the driver, N.
    pub fn applied_force(&self) -> [f64; 3] {
        self.applied_force.read().unwrap_or_default().map(f64::from_bits)
    }

    /// Records the force of a tick, N.
    pub(crate) fn set_applied_force(&self, force: [f64; 3]) {
        self.applied_force.write(force.map(f64::to_bits));
    }

    /// Sets the largest force, N.
    pub(crate) fn set_peak_force(&self, peak_force: f64) {
        self.peak_force.store(peak_force.to_bits(), Ordering::Relaxed);
    }

    /// Records that the arm was opened with its output on; the force rises from now on.
    pub(crate) fn set_open(&self, handle: Handle, now_ns: u64) {
        self.output_on_since_ns.store(now_ns.max(1), Ordering::Relaxed);
        self.is_output_on.store(true, Ordering::Relaxed);
        self.unclosed_handle.store(handle, Ordering::Relaxed);
        self.handle.store(handle, Ordering::Release);
    }

    /// The force to apply now, N: the commanded one, zero if it has expired, was stopped or is not finite, limited to the peak force, and
    /// scaled down while the force rises.
    pub(crate) fn force_to_apply(&self, now_ns: u64) -> [f64; 3] {
        let Some([x, y, z, expires_ns]) = self.command.read() else { return [0.0; 3] };
        let force = [x, y, z].map(f64::from_bits);
        if self.is_stopped.load(Ordering::Acquire) || now_ns >= expires_ns || !force.iter().all(|f| f.is_finite()) {
            return [0.0; 3];
        }
        let norm = force.iter().map(|f| f * f).sum::<f64>().sqrt();
        let peak_force = f64::from_bits(self.peak_force.load(Ordering::Relaxed));
        let on_ns = now_ns.saturating_sub(self.output_on_since_ns.load(Ordering::Relaxed));
        let ramp = (on_ns as f64 / FORCE_RAMP_NS as f64).min(1.0);
        let limit = if norm > peak_force { peak_force / norm } else { 1.0 };
        // The norm of finite numbers can overflow.
        let scale = if norm.is_finite() { ramp * limit } else { 0.0 };
        force.map(|f| scale * f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_rises_stays_within_the_peak_and_expires() {
        let arm = Arm::default();
        arm.set_peak_force(3.3);
        arm.set_open(1, 1);
        arm.command([33.0, 0.0, 0.0], 2 * FORCE_RAMP_NS);
        let x_at = |ns: u64| arm.force_to_apply(ns)[0];
        assert!((x_at(FORCE_RAMP_NS / 2) - 1.65).abs() < 1e-6 && (x_at(FORCE_RAMP_NS + 1) - 3.3).abs() < 1e-12);
        assert_eq!(arm.force_to_apply(2 * FORCE_RAMP_NS), [0.0; 3]);
        arm.command([f64::NAN, 0.0, 0.0], u64::MAX);
        assert_eq!(arm.force_to_apply(FORCE_RAMP_NS + 1), [0.0; 3]);
        arm.command([1.0, 0.0, 0.0], u64::MAX);
        arm.stop();
        assert_eq!(arm.force_to_apply(FORCE_RAMP_NS + 1), [0.0; 3]);
    }
}
