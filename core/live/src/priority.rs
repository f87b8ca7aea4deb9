//! Real-time priority for the haptic thread, where the system gives it.

use std::fmt::Display;

/// Priority of SCHED_FIFO, 1 to 99: above everything but the threads of the system itself.
#[cfg(unix)]
const PRIORITY: u8 = 75;

/// Asks for real-time priority of the calling thread and says what was granted.
pub(crate) fn raise() -> String {
    match ask() {
        Ok(got) => got,
        Err(why) => format!("normal: the system refused real-time priority ({why})"),
    }
}

/// Asks for SCHED_FIFO; says what was granted, or why not.
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

/// Asks for the highest priority of the system; says what was granted, or why not.
#[cfg(not(unix))]
fn ask() -> Result<String, impl Display> {
    thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max)
        .map(|()| "the highest a program may have".to_owned())
        .map_err(|error| format!("{error:?}"))
}
