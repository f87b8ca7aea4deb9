//! Plugin calls that do not return: which they are, and a watchdog in the same process that ends it.

use crate::outcome::Outcome;
use crate::output::note;
use pliant_host::{PluginCall, end_at_once, plugin_calls};
use std::collections::HashMap;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Time from one look at the calls to the next.
const TICK: Duration = Duration::from_millis(20);

/// Finds calls that have been under way for too long.
pub struct OverdueCalls {
    limit: Duration,
    /// For each thread, its call and when that was first seen.
    since: HashMap<usize, (u64, Instant)>,
}

impl OverdueCalls {
    /// Calls of longer than `limit` (s) are overdue.
    pub fn new(limit: f64) -> Self {
        Self { limit: Duration::try_from_secs_f64(limit).unwrap_or(Duration::MAX), since: HashMap::new() }
    }

    /// Longest time of a call.
    pub fn limit(&self) -> Duration {
        self.limit
    }

    /// A call that is overdue, among those under way now.
    pub fn find<'c>(&mut self, calls: &'c [PluginCall]) -> Option<&'c PluginCall> {
        let now = Instant::now();
        self.since.retain(|thread, (number, _)| calls.iter().any(|c| (c.thread, c.number) == (*thread, *number)));
        calls.iter().find(|call| {
            let (_, began) = self.since.entry(call.thread).or_insert((call.number, now));
            now.duration_since(*began) > self.limit
        })
    }
}

/// A thread that ends the program, devices first, when a plugin call does not return. Dropping it ends the thread.
pub struct CallWatchdog {
    /// Its end tells the thread to end.
    _end: Sender<()>,
}

impl CallWatchdog {
    /// Watches calls for longer than `limit` (s). `then` says what becomes of the work. Without a thread to be had nothing is watched, with a
    /// warning.
    pub fn start(limit: f64, then: &'static str) -> Self {
        let (end, ended) = channel();
        let watch = move || {
            let mut overdue = OverdueCalls::new(limit);
            while ended.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                if let Some(call) = overdue.find(&plugin_calls()) {
                    note(&format!("error: {call} did not return within {limit} s (`--call-limit`); {then}"));
                    end_at_once(Outcome::Plugin.exit_code());
                }
            }
        };
        if let Err(error) = std::thread::Builder::new().name("call watchdog".into()).spawn(watch) {
            note(&format!("warning: calls of plugins are not watched: {error}"));
        }
        Self { _end: end }
    }
}
