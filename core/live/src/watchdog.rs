//! Stops the devices when the haptic thread no longer comes round: a driver that hangs, a machine that is starved.

use super::haptic::StopNow;
use super::thread::Shared;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle, sleep};
use std::time::{Duration, Instant};

/// How long the haptic thread may be silent.
const PATIENCE: Duration = Duration::from_millis(50);
/// How often it is looked at.
const LOOK: Duration = Duration::from_millis(5);

pub(super) struct Watchdog {
    thread: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
    trips: Arc<AtomicU64>,
}

impl Watchdog {
    pub(super) fn start(stops: Vec<StopNow>, shared: Arc<Shared>) -> std::io::Result<Self> {
        let trips = Arc::new(AtomicU64::new(0));
        let (of_thread, count) = (Arc::clone(&shared), Arc::clone(&trips));
        let watch = move || {
            let (mut beats, mut since, mut stopped) = (u64::MAX, Instant::now(), false);
            while !of_thread.stop.load(Ordering::Relaxed) {
                let now = of_thread.beats.load(Ordering::Relaxed);
                if now != beats {
                    (beats, since, stopped) = (now, Instant::now(), false);
                } else if since.elapsed() > PATIENCE && !stopped {
                    stops.iter().for_each(|stop| stop());
                    stopped = true;
                    count.fetch_add(1, Ordering::Relaxed);
                }
                sleep(LOOK);
            }
        };
        Ok(Self { thread: Some(Builder::new().name("watchdog".into()).spawn(watch)?), shared, trips })
    }

    /// Ends it; how often it had to stop the devices.
    pub(super) fn end(&mut self) -> u64 {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        self.trips.load(Ordering::Relaxed)
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.end();
    }
}
