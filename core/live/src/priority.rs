//! Real-time priority of the haptic thread.

use std::fmt::Display;

/// SCHED_FIFO priority, 1 to 99: above everything but kernel threads.
#[cfg(unix)]
const PRIORITY: u8 = 75;

/// Requests real-time priority for the calling thread. Returns a description of what was granted.
pub(crate) fn raise() -> String {
    match ask() {
        Ok(got) => got,
        Err(why) => format!("normal: the system refused real-time priority ({why})"),
    }
}

/// Requests SCHED_FIFO. Returns a description of what was granted, or the error.
#[cfg(unix)]
fn ask() -> Result<String, impl Display> {
    use thread_priority::unix::{
        RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
    };
    let priority = thread_priority::ThreadPriority::Crossplatform(PRIORITY.try_into().unwrap_or_default());
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy)
        .map(|()| format!("real-time: SCHED_FIFO {PRIORITY}"))
        .map_err(|error| format!("{error:?}"))
}

/// Requests the highest priority of the system. Returns a description of what was granted, or the error.
#[cfg(not(unix))]
fn ask() -> Result<String, impl Display> {
    thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max)
        .map(|()| "the highest a program may have".to_owned())
        .map_err(|error| format!("{error:?}"))
}
