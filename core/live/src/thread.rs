//! The haptic thread: ticks at absolute deadlines, and what is known of how well it kept them.

use super::deadline::Deadlines;
use super::footing::{self, Footing, Took};
use super::histogram::Histogram;
use super::servo::Servo;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle, sleep};
use std::time::{Duration, Instant};

/// ns since the start of a live session, the same for all of its threads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock(Instant);

impl Clock {
    pub(super) fn start() -> Self {
        Self(Instant::now())
    }

    pub(super) fn now(&self) -> u64 {
        self.0.elapsed().as_nanos() as u64
    }

    /// Sleeps until shortly before `due` (ns), then spins: the system wakes a thread late by about this much.
    fn wait_until(&self, due: u64) {
        loop {
            let now = self.now();
            match due.checked_sub(now) {
                None | Some(0) => return,
                Some(left) if left > SPIN => sleep(Duration::from_nanos(left - SPIN)),
                Some(_) => std::hint::spin_loop(),
            }
        }
    }
}

/// ns
const SPIN: u64 = 60_000;

/// What is shared with the thread.
#[derive(Default)]
pub(super) struct Shared {
    pub(super) stop: AtomicBool,
    /// Ticks begun.
    pub(super) beats: AtomicU64,
}

/// How it went.
pub(super) struct Ended {
    pub(super) servo: Servo,
    pub(super) footing: Footing,
    pub(super) took: Option<Took>,
    pub(super) ticks: u64,
    pub(super) missed: u64,
    pub(super) period: Histogram,
    pub(super) lateness: Histogram,
    pub(super) latency: Histogram,
    /// Whether it ended by a panic.
    pub(super) panicked: bool,
}

/// Starts ticking.
pub(super) fn start(servo: Servo, clock: Clock, shared: Arc<Shared>) -> std::io::Result<JoinHandle<Ended>> {
    Builder::new().name("haptic".into()).spawn(move || run(servo, clock, &shared))
}

fn run(servo: Servo, clock: Clock, shared: &Shared) -> Ended {
    let (period, lateness, latency) = (Histogram::default(), Histogram::default(), Histogram::default());
    let rate = servo.rate();
    let mut ended = Ended {
        servo,
        footing: footing::take(),
        took: None,
        ticks: 0,
        missed: 0,
        period,
        lateness,
        latency,
        panicked: false,
    };
    let before = footing::so_far();
    let looped = catch_unwind(AssertUnwindSafe(|| {
        let mut deadlines = Deadlines::new(clock.now(), rate);
        let mut before = None;
        while !shared.stop.load(Ordering::Relaxed) {
            clock.wait_until(deadlines.due());
            shared.beats.fetch_add(1, Ordering::Relaxed);
            let began = clock.now();
            ended.servo.tick(began);
            let done = clock.now();
            ended.lateness.add(began.saturating_sub(deadlines.due()));
            ended.latency.add(done - began);
            if let Some(before) = before.replace(began) {
                ended.period.add(began - before);
            }
            ended.ticks += 1;
            deadlines.done(done);
            ended.missed = deadlines.missed;
        }
    }));
    // Here the way out of a panic and of an orderly end are one.
    ended.servo.stop();
    ended.panicked = looped.is_err();
    ended.took = footing::so_far().zip(before).map(|(now, before)| now.since(before));
    footing::leave();
    ended
}
