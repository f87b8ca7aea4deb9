//! The haptic thread: ticks at absolute deadlines, with timing statistics.

use crate::deadline::Deadlines;
use crate::histogram::Histogram;
use crate::realtime::{RealtimeStatus, ThreadUsage, release, request, thread_usage};
use crate::servo::Servo;
use crate::thread;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

/// Clock of a live session, in ns since its start, shared by all threads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock(Instant);

impl Clock {
    /// Starts at 0 ns.
    pub(crate) fn start() -> Self {
        Self(Instant::now())
    }

    /// Time since the start, ns.
    pub(crate) fn now(&self) -> u64 {
        self.0.elapsed().as_nanos() as u64
    }

    /// Sleeps until `spin` (ns) before `due` (ns), then spins.
    fn wait_until(&self, due: u64, spin: u64) {
        loop {
            let now = self.now();
            match due.checked_sub(now) {
                None | Some(0) => return,
                Some(left) if left > spin => sleep(Duration::from_nanos(left - spin)),
                Some(_) => std::hint::spin_loop(),
            }
        }
    }
}

/// Time before a deadline from which the thread spins where a device needs exact ticks, ns: about the wake-up latency of the system.
const SPIN: u64 = 60_000;

/// Flags shared by the haptic thread, the watchdog and the simulation.
#[derive(Default)]
pub(crate) struct ThreadSignals {
    /// Whether the threads must end.
    pub(crate) stop: AtomicBool,
    /// Number of ticks begun.
    pub(crate) ticks_begun: AtomicU64,
    /// Number of missed deadlines: ticks not finished before the next one was due.
    pub(crate) missed: AtomicU64,
    /// Largest lateness of a tick's beginning since the simulation last read it, ns.
    pub(crate) worst_lateness: AtomicU64,
}

/// The servo and statistics of a haptic thread that has ended.
pub(crate) struct HapticResult {
    pub(crate) servo: Servo,
    pub(crate) realtime: RealtimeStatus,
    pub(crate) usage: Option<ThreadUsage>,
    /// Number of ticks finished.
    pub(crate) ticks: u64,
    /// Number of ticks not finished before the next was due.
    pub(crate) missed: u64,
    /// Time between the beginnings of two ticks.
    pub(crate) period: Histogram,
    /// Time from the deadline of a tick to its beginning.
    pub(crate) lateness: Histogram,
    /// Duration of a tick.
    pub(crate) latency: Histogram,
    /// Whether the thread ended by a panic.
    pub(crate) panicked: bool,
}

/// Starts the thread.
pub(crate) fn start(
    servo: Servo,
    clock: Clock,
    signals: Arc<ThreadSignals>,
) -> std::io::Result<JoinHandle<HapticResult>> {
    thread::start("haptic", move || run(servo, clock, &signals))
}

/// Runs ticks until it must stop or a tick panics, then stops the devices.
fn run(servo: Servo, clock: Clock, signals: &ThreadSignals) -> HapticResult {
    let (period, lateness, latency) = (Histogram::default(), Histogram::default(), Histogram::default());
    let (rate, spin) = (servo.rate(), if servo.needs_exact_ticks() { SPIN } else { 0 });
    let mut result = HapticResult {
        servo,
        realtime: request(),
        usage: None,
        ticks: 0,
        missed: 0,
        period,
        lateness,
        latency,
        panicked: false,
    };
    let usage_before = thread_usage();
    let looped = catch_unwind(AssertUnwindSafe(|| {
        let mut deadlines = Deadlines::new(clock.now(), rate);
        let mut last_began = None;
        while !signals.stop.load(Ordering::Relaxed) {
            clock.wait_until(deadlines.due(), spin);
            signals.ticks_begun.fetch_add(1, Ordering::Relaxed);
            let began = clock.now();
            result.servo.tick(began);
            let done = clock.now();
            let late = began.saturating_sub(deadlines.due());
            result.lateness.add(late);
            signals.worst_lateness.fetch_max(late, Ordering::Relaxed);
            result.latency.add(done - began);
            if let Some(last) = last_began.replace(began) {
                result.period.add(began - last);
            }
            result.ticks += 1;
            deadlines.finish_tick(done);
            result.missed = deadlines.missed;
            signals.missed.store(deadlines.missed, Ordering::Relaxed);
        }
    }));
    // Reached after a panic and after an orderly end.
    result.servo.stop();
    result.panicked = looped.is_err();
    result.usage = thread_usage().zip(usage_before).map(|(now, before)| now.since(before));
    release();
    result
}
