//! What the system gives a haptic thread, asked for before its first tick, and what it took from it, looked at after its last.
//!
//! Not asked for: a processor of its own. Tied to one, a thread in real time waits there for what the system does with that
//! processor, while another would have been free.

use super::priority;
use serde::Serialize;

/// What was asked for, and what became of it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Footing {
    /// Of its thread.
    pub priority: String,
    /// How late the system may wake it to save wake-ups.
    pub timer: String,
    /// Whether its memory stays in place.
    pub memory: String,
}

/// What the thread went without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Took {
    /// s, that it worked or spun
    pub ran: f64,
    /// s, that it was ready and had no processor
    pub waited: f64,
    /// How often another thread was put in its place.
    pub preempted: u64,
    /// Pages that had to be found first.
    pub faults: u64,
    /// s, of all processors, that went to other machines on the same hardware, as far as those tell
    pub stolen: f64,
}

/// Asks for everything, on the thread itself.
pub(super) fn take() -> Footing {
    Footing { priority: priority::raise(), timer: timer(), memory: memory() }
}

#[cfg(target_os = "linux")]
fn timer() -> String {
    // In real time the system adds none by itself.
    match nix::sys::prctl::set_timerslack(1) {
        Ok(()) => "exact: no slack".into(),
        Err(why) => format!("the system's own slack ({why})"),
    }
}

#[cfg(target_os = "linux")]
fn memory() -> String {
    use nix::sys::mman::{MlockAllFlags, mlockall};
    match mlockall(MlockAllFlags::MCL_CURRENT) {
        Ok(()) => "locked".into(),
        Err(why) => format!("not locked: the system refused ({why})"),
    }
}

/// Gives back what is the whole process's.
#[cfg(target_os = "linux")]
pub(super) fn leave() {
    let _ = nix::sys::mman::munlockall();
}

#[cfg(not(target_os = "linux"))]
pub(super) fn leave() {}

#[cfg(not(target_os = "linux"))]
fn timer() -> String {
    "the system's own".into()
}

#[cfg(not(target_os = "linux"))]
fn memory() -> String {
    "not locked: not asked for on this system".into()
}

/// What was taken from the calling thread since it began; `None` where the system does not tell.
pub(super) fn so_far() -> Option<Took> {
    let read = |file: &str| std::fs::read_to_string(file).ok();
    let (schedule, status) = (read("/proc/thread-self/schedstat")?, read("/proc/thread-self/status")?);
    let stat = read("/proc/thread-self/stat")?;
    let mut ns = schedule.split_whitespace().map_while(|n| n.parse::<f64>().ok());
    let (ran, waited) = (1e-9 * ns.next()?, 1e-9 * ns.next()?);
    let preempted = status.lines().find_map(|l| l.strip_prefix("nonvoluntary_ctxt_switches:"))?.trim().parse().ok()?;
    // Past the name, which may hold anything: state is field 3, minor faults 10, major 12.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let number = |field: usize| fields.get(field - 3).and_then(|n| n.parse::<u64>().ok());
    let faults = number(10)? + number(12)?;
    let stolen = read("/proc/stat").and_then(|s| s.split_whitespace().nth(8)?.parse::<f64>().ok());
    Some(Took { ran, waited, preempted, faults, stolen: 0.01 * stolen.unwrap_or(0.0) })
}

impl Took {
    /// What was taken since `before`.
    pub(super) fn since(self, before: Self) -> Self {
        Self {
            ran: self.ran - before.ran,
            waited: self.waited - before.waited,
            preempted: self.preempted - before.preempted,
            faults: self.faults - before.faults,
            stolen: self.stolen - before.stolen,
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn what_a_thread_did_is_seen() {
        let before = so_far().expect("Linux tells");
        let began = std::time::Instant::now();
        let mut pages = vec![0_u8; 64 << 20];
        pages.iter_mut().step_by(4096).for_each(|byte| *byte = 1);
        while began.elapsed().as_secs_f64() < 0.05 {
            std::hint::spin_loop();
        }
        let took = so_far().expect("Linux tells").since(before);
        assert!(std::hint::black_box(pages).len() == 64 << 20 && took.faults > 0, "{took:?}");
        assert!(took.ran > 0.0 && took.ran + took.waited >= 0.04, "{took:?}");
    }
}
