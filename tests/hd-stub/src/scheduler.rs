//! The scheduler: a thread that calls the servo loop and advances the simulated arms at its rate.
#![allow(unsafe_code, reason = "calls a callback of the C interface")]

use crate::state;
use std::cell::Cell;
use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

static IS_RUNNING: AtomicBool = AtomicBool::new(false);
static THREAD: Mutex<Option<JoinHandle<()>>> = Mutex::new(None);
/// How long the next tick is delayed, ms.
static STALL_MS: AtomicU64 = AtomicU64::new(0);

thread_local! {
    /// Whether this is the scheduler's thread, on which callbacks run.
    static IS_SCHEDULER_THREAD: Cell<bool> = const { Cell::new(false) };
}

pub(crate) fn is_running() -> bool {
    IS_RUNNING.load(Ordering::Relaxed)
}

pub(crate) fn is_in_callback() -> bool {
    IS_SCHEDULER_THREAD.get()
}

/// Delays the next tick.
pub(crate) fn stall(ms: u64) {
    STALL_MS.store(ms, Ordering::Relaxed);
}

/// Starts the thread if it does not run.
pub(crate) fn start() {
    let mut thread = THREAD.lock().unwrap_or_else(PoisonError::into_inner);
    if thread.is_none() {
        IS_RUNNING.store(true, Ordering::Relaxed);
        *thread = Some(std::thread::spawn(run));
    }
}

/// Stops the thread and waits for its end.
pub(crate) fn stop() {
    IS_RUNNING.store(false, Ordering::Relaxed);
    let thread = THREAD.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(thread) = thread {
        let _ = thread.join();
    }
}

fn run() {
    IS_SCHEDULER_THREAD.set(true);
    let mut due = Instant::now();
    while is_running() {
        let stall_ms = STALL_MS.swap(0, Ordering::Relaxed);
        if stall_ms > 0 {
            std::thread::sleep(Duration::from_millis(stall_ms));
        }
        let (callback, rate) = {
            let state = state::lock();
            (state.callback, state.rate)
        };
        if let Some(callback) = callback {
            // SAFETY: the interface requires that the data lives until the callback is unscheduled.
            unsafe { (callback.function)(callback.data as *mut c_void) };
        }
        let period = Duration::from_secs_f64(1.0 / f64::from(rate));
        for device in state::lock().devices.iter_mut().flatten() {
            device.advance(period.as_secs_f64());
        }
        due += period;
        match due.checked_duration_since(Instant::now()) {
            Some(wait) => std::thread::sleep(wait),
            // Too slow: missed ticks are skipped.
            None => due = Instant::now(),
        }
    }
}
