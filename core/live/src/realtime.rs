//! Real-time settings of the haptic thread, requested before its first tick, and its processor use, read after its last tick.
//!
//! The thread is not pinned: on a fixed processor it would wait for kernel work while another processor is free.

use crate::priority;
use serde::Serialize;

/// Descriptions of the real-time settings the system granted to the haptic thread.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RealtimeStatus {
    /// Scheduling priority of the thread.
    pub priority: String,
    /// Timer slack: delay by which the system may postpone wake-ups.
    pub timer: String,
    /// Whether the memory of the process is locked against paging.
    pub memory: String,
}

/// Processor use of the haptic thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ThreadUsage {
    /// Time the thread ran, including spinning, s.
    #[serde(rename = "ran")]
    pub running: f64,
    /// Time the thread was runnable without a processor, s.
    #[serde(rename = "waited")]
    pub waiting: f64,
    /// Number of involuntary context switches.
    #[serde(rename = "preempted")]
    pub preemptions: u64,
    /// Number of page faults, minor and major.
    #[serde(rename = "faults")]
    pub page_faults: u64,
    /// Steal time of all processors, as reported by the hypervisor, s.
    #[serde(rename = "stolen")]
    pub steal_time: f64,
}

/// Requests all settings for the calling thread.
pub(crate) fn request() -> RealtimeStatus {
    RealtimeStatus { priority: priority::raise(), timer: timer(), memory: memory() }
}

/// Requests timers without slack. Returns a description of what was granted.
#[cfg(target_os = "linux")]
fn timer() -> String {
    // Threads with real-time priority have no slack anyway.
    match nix::sys::prctl::set_timerslack(1) {
        Ok(()) => "exact: no slack".into(),
        Err(why) => format!("the system's own slack ({why})"),
    }
}

/// Locks the present memory of the process. Returns a description of whether that was granted.
#[cfg(target_os = "linux")]
fn memory() -> String {
    use nix::sys::mman::{MlockAllFlags, mlockall};
    match mlockall(MlockAllFlags::MCL_CURRENT) {
        Ok(()) => "locked".into(),
        Err(why) => format!("not locked: the system refused ({why})"),
    }
}

/// Unlocks the memory, which is that of the whole process.
#[cfg(target_os = "linux")]
pub(crate) fn release() {
    let _ = nix::sys::mman::munlockall();
}

/// Does nothing: no memory was locked.
#[cfg(not(target_os = "linux"))]
pub(crate) fn release() {}

/// Nothing is asked for on this system.
#[cfg(not(target_os = "linux"))]
fn timer() -> String {
    "the system's own".into()
}

/// Nothing is asked for on this system.
#[cfg(not(target_os = "linux"))]
fn memory() -> String {
    "not locked: not asked for on this system".into()
}

/// Clock tick of /proc/stat (1 / USER_HZ), s.
const TICK: f64 = 0.01;

/// Processor use of the calling thread since its start; `None` if the system does not report it.
pub(crate) fn thread_usage() -> Option<ThreadUsage> {
    let read = |file: &str| std::fs::read_to_string(file).ok();
    let (schedule, status) = (read("/proc/thread-self/schedstat")?, read("/proc/thread-self/status")?);
    let stat = read("/proc/thread-self/stat")?;
    let mut ns = schedule.split_whitespace().map_while(|n| n.parse::<f64>().ok());
    let (running, waiting) = (1e-9 * ns.next()?, 1e-9 * ns.next()?);
    let preemptions =
        status.lines().find_map(|l| l.strip_prefix("nonvoluntary_ctxt_switches:"))?.trim().parse().ok()?;
    // Fields after the name, which may contain spaces: the state is field 3, minor faults 10, major faults 12 (proc_pid_stat(5)).
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let number = |field: usize| fields.get(field - 3).and_then(|n| n.parse::<u64>().ok());
    let page_faults = number(10)? + number(12)?;
    let steal_ticks = read("/proc/stat").and_then(|s| s.split_whitespace().nth(8)?.parse::<f64>().ok());
    Some(ThreadUsage { running, waiting, preemptions, page_faults, steal_time: TICK * steal_ticks.unwrap_or(0.0) })
}

impl ThreadUsage {
    /// The use since an earlier reading.
    pub(crate) fn since(self, earlier: Self) -> Self {
        Self {
            running: self.running - earlier.running,
            waiting: self.waiting - earlier.waiting,
            preemptions: self.preemptions - earlier.preemptions,
            page_faults: self.page_faults - earlier.page_faults,
            steal_time: self.steal_time - earlier.steal_time,
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn running_time_and_page_faults_of_a_thread_are_seen() {
        let before = thread_usage().expect("Linux tells");
        let began = std::time::Instant::now();
        let mut pages = vec![0_u8; 64 << 20];
        pages.iter_mut().step_by(4096).for_each(|byte| *byte = 1);
        while began.elapsed().as_secs_f64() < 0.05 {
            std::hint::spin_loop();
        }
        let used = thread_usage().expect("Linux tells").since(before);
        assert!(std::hint::black_box(pages).len() == 64 << 20 && used.page_faults > 0, "{used:?}");
        assert!(used.running > 0.0 && used.running + used.waiting >= 0.04, "{used:?}");
    }
}
