//! Real-time priority for the haptic thread, where the system gives it.

use std::fmt::Display;

/// First in, first out, of 99: above everything but what the system itself must do.
#[cfg(unix)]
const PRIORITY: u8 = 75;

/// Asks for it and says what became of it.
pub fn raise() -> String {
    match ask() {
        Ok(got) => got,
        Err(why) => format!("normal: the system refused real-time priority ({why})"),
    }
}

#[cfg(unix)]
fn ask() -> Result<String, impl Display> {
    use thread_priority::unix::{
        RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
    };
    let priority = thread_priority::ThreadPriority::Crossplatform(PRIORITY.try_into().unwrap_or_default());
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy)
        .map(|()| format!("real-time: first in, first out, {PRIORITY}"))
        .map_err(|error| format!("{error:?}"))
}

#[cfg(not(unix))]
fn ask() -> Result<String, impl Display> {
    thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max)
        .map(|()| "the highest a program may have".to_owned())
        .map_err(|error| format!("{error:?}"))
}
