//! The loop on the driver's servo thread. In each tick it runs one frame per arm: it reads the state, sets the force and handles the
//! errors.
//!
//! Nothing here waits, allocates, or calls anything but the driver. The force is set in every tick, because the driver clears it when a
//! frame begins; every frame that is begun is ended. An arm that is lost is left without force, and a stalled loop sets none.
#![allow(unsafe_code, reason = "calls a C library; each call says what makes it sound")]

use crate::arm::{Arm, ArmState, FORCE_ERROR_PAUSE_NS};
use crate::errors::{self, ErrorClass};
use crate::hd::{self, Api, Handle, capability, parameter};
use crate::rotation::quaternion;
use core::ffi::c_void;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Most arms of one driver.
pub const MAX_ARMS: usize = 2;
/// Most errors handled per frame; the others are handled in the next.
const MAX_ERRORS_PER_FRAME: usize = 16;
/// Metres per millimetre, the driver's unit of length.
const METRES_PER_MM: f64 = 1e-3;

/// What the servo loop and the host share.
pub struct Servo {
    /// The functions of the driver.
    pub(crate) api: Api,
    /// The arms; those that are not in use have no handle.
    pub arms: [Arm; MAX_ARMS],
    /// Origin of the time.
    pub(crate) start: Instant,
    /// Asks the loop to leave the arms without force and with the output off.
    pub(crate) is_closing: AtomicBool,
    /// Set by the loop when it has done so.
    pub(crate) is_closed: AtomicBool,
    /// Whether an arm whose stylus is in the inkwell gets no force.
    pub inkwell_disables_force: bool,
}

impl Servo {
    /// Time since the driver was opened, ns.
    pub fn now_ns(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    /// The callback of the scheduler.
    ///
    /// # Safety
    /// `data` points to a `Servo` that lives until the callback is unscheduled.
    pub(crate) unsafe extern "C" fn tick(data: *mut c_void) -> u32 {
        // SAFETY: see above; everything in a `Servo` may be shared between threads.
        let servo = unsafe { &*data.cast::<Self>() };
        // A panic must not cross the C frames below; atomics and calls of the driver do not panic.
        servo.run_frames();
        hd::CALLBACK_CONTINUE
    }

    fn run_frames(&self) {
        let now_ns = self.now_ns();
        let is_closing = self.is_closing.load(Ordering::Acquire);
        for arm in &self.arms {
            let handle = arm.handle.load(Ordering::Acquire);
            if handle != hd::INVALID_HANDLE {
                self.run_frame(arm, handle, is_closing, now_ns);
            }
        }
        if is_closing {
            self.is_closed.store(true, Ordering::Release);
        }
    }

    fn run_frame(&self, arm: &Arm, handle: Handle, is_closing: bool, now_ns: u64) {
        let api = &self.api;
        // SAFETY: published prototypes, on the driver's own thread, inside of one frame.
        unsafe {
            (api.make_current)(handle);
            (api.begin_frame)(handle);
        }
        let transform = api.doubles(parameter::TRANSFORM);
        let velocity = api.doubles(parameter::VELOCITY);
        let buttons = api.integer(parameter::BUTTONS);
        let in_inkwell = api.boolean(parameter::INKWELL);
        let is_off =
            is_closing || !arm.is_output_on.load(Ordering::Relaxed) || (in_inkwell && self.inkwell_disables_force);
        let force = if is_off { [0.0; 3] } else { arm.force_to_apply(now_ns) };
        // SAFETY: as above; the parameter has three numbers.
        unsafe {
            (api.set_doubles)(parameter::FORCE, force.as_ptr());
            (api.end_frame)(handle);
        }
        arm.counters.ticks.fetch_add(1, Ordering::Relaxed);
        arm.set_applied_force(force);
        let is_usable = self.handle_errors(arm, now_ns);
        if is_usable && transform[..15].iter().chain(&velocity[..3]).all(|n| n.is_finite()) {
            arm.set_state(ArmState {
                time_ns: now_ns.max(1),
                buttons: buttons as u32,
                in_inkwell,
                position: [12, 13, 14].map(|i: usize| transform[i] * METRES_PER_MM),
                orientation: quaternion(&transform),
                velocity: [0, 1, 2].map(|i: usize| velocity[i] * METRES_PER_MM),
            });
        }
        self.switch_output(arm, is_closing, now_ns);
    }

    /// Handles the errors of a frame by their class. Returns whether the values read in the frame can be used.
    fn handle_errors(&self, arm: &Arm, now_ns: u64) -> bool {
        let mut is_usable = true;
        for _ in 0..MAX_ERRORS_PER_FRAME {
            let Some(error) = self.api.pop_error() else { break };
            arm.counters.newest_code.store(error.code, Ordering::Relaxed);
            match errors::class(error.code) {
                ErrorClass::Force => {
                    arm.counters.force_errors.fetch_add(1, Ordering::Relaxed);
                    arm.force_error_ns.store(now_ns, Ordering::Relaxed);
                }
                ErrorClass::Lost | ErrorClass::Unknown | ErrorClass::Licence => {
                    arm.counters.losses.fetch_add(1, Ordering::Relaxed);
                    arm.handle.store(hd::INVALID_HANDLE, Ordering::Release);
                    arm.set_applied_force([0.0; 3]);
                    is_usable = false;
                }
                ErrorClass::Usage | ErrorClass::Frame | ErrorClass::Scheduler => {
                    arm.counters.usage_errors.fetch_add(1, Ordering::Relaxed);
                    is_usable = false;
                }
            }
        }
        is_usable
    }

    /// Switches the output off when closing or after a force error, and on again after a pause. The driver allows this only inside of a
    /// callback while the scheduler runs.
    fn switch_output(&self, arm: &Arm, is_closing: bool, now_ns: u64) {
        let is_on = arm.is_output_on.load(Ordering::Relaxed);
        let error_ns = arm.force_error_ns.load(Ordering::Relaxed);
        let pause_is_over = error_ns == 0 || now_ns.saturating_sub(error_ns) >= FORCE_ERROR_PAUSE_NS;
        // SAFETY: published prototypes, on the driver's own thread.
        unsafe {
            if is_on && (is_closing || !pause_is_over) {
                (self.api.disable)(capability::FORCE_OUTPUT);
                arm.is_output_on.store(false, Ordering::Relaxed);
            } else if !is_on && !is_closing && pause_is_over {
                (self.api.enable)(capability::FORCE_OUTPUT);
                arm.output_on_since_ns.store(now_ns, Ordering::Relaxed);
                arm.is_output_on.store(true, Ordering::Relaxed);
            }
        }
    }
}
