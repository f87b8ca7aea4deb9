//! Watchdog: stops the devices when the haptic thread makes no progress, because a driver hangs or no processor is free.

use crate::device::StopDevice;
use crate::haptic_thread::ThreadSignals;
use crate::thread;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

/// Longest time without a tick before the devices are stopped.
const TIMEOUT: Duration = Duration::from_millis(50);
/// Time between two checks.
const POLL_PERIOD: Duration = Duration::from_millis(5);

/// The watchdog thread. Dropping it ends the thread, and the haptic thread with it.
pub(crate) struct Watchdog {
    thread: Option<JoinHandle<()>>,
    signals: Arc<ThreadSignals>,
    /// Number of times the devices were stopped.
    trips: Arc<AtomicU64>,
}

impl Watchdog {
    /// Starts watching; `stops` has the emergency stop of each device.
    pub(crate) fn start(stops: Vec<StopDevice>, signals: Arc<ThreadSignals>) -> std::io::Result<Self> {
        let trips = Arc::new(AtomicU64::new(0));
        let (of_thread, count) = (Arc::clone(&signals), Arc::clone(&trips));
        let watch = move || {
            let (mut ticks, mut since, mut stopped) = (u64::MAX, Instant::now(), false);
            while !of_thread.stop.load(Ordering::Relaxed) {
                let now = of_thread.ticks_begun.load(Ordering::Relaxed);
                if now != ticks {
                    (ticks, since, stopped) = (now, Instant::now(), false);
                } else if since.elapsed() > TIMEOUT && !stopped {
                    stops.iter().for_each(|stop| stop());
                    stopped = true;
                    count.fetch_add(1, Ordering::Relaxed);
                }
                sleep(POLL_PERIOD);
            }
        };
        Ok(Self { thread: Some(thread::start("watchdog", watch)?), signals, trips })
    }

    /// Ends the thread. Returns the number of times it stopped the devices.
    pub(crate) fn end(&mut self) -> u64 {
        self.signals.stop.store(true, Ordering::Relaxed);
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
