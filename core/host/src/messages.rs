//! Messages of plugins: one line at a time, from any thread, without waiting.

use pliant_plugin_api::abi;
use std::ffi::{CStr, c_char};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// One message of a plugin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// [`abi::INFO`], [`abi::WARNING`] or [`abi::ERROR`].
    pub severity: u32,
    /// Text of at most 255 bytes.
    pub text: String,
}

/// Messages that have come and were not yet read. A full or busy inbox drops the message and counts it.
#[derive(Default)]
pub(crate) struct Inbox {
    lines: Mutex<Lines>,
    dropped: AtomicU64,
}

/// Messages that an inbox holds.
const CAPACITY: usize = 32;
/// Bytes of a slot: a text and the 0 behind it.
const SLOT: usize = 256;

/// Messages in slots that are made ahead, so that taking one needs no memory.
struct Lines {
    count: usize,
    /// Severity and text, padded with zeros.
    slots: [(u32, [u8; SLOT]); CAPACITY],
}

impl Default for Lines {
    fn default() -> Self {
        Self { count: 0, slots: [(0, [0; SLOT]); CAPACITY] }
    }
}

impl Inbox {
    /// Messages since the last call, and the number of those that were lost.
    pub(crate) fn take(&self) -> (Vec<Message>, u64) {
        let mut lines = self.lines.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let read = |(severity, bytes): &(u32, [u8; SLOT])| {
            let end = bytes.iter().position(|b| *b == 0).unwrap_or(SLOT - 1);
            Message { severity: *severity, text: String::from_utf8_lossy(&bytes[..end]).into_owned() }
        };
        let messages = lines.slots[..lines.count].iter().map(read).collect();
        lines.count = 0;
        (messages, self.dropped.swap(0, Ordering::Relaxed))
    }

    /// Puts a message in, or counts it as lost.
    fn push(&self, severity: u32, text: &[u8]) {
        match self.lines.try_lock() {
            Ok(mut lines) if lines.count < CAPACITY => {
                let at = lines.count;
                let len = text.len().min(SLOT - 1);
                lines.slots[at] = (severity, [0; SLOT]);
                lines.slots[at].1[..len].copy_from_slice(&text[..len]);
                lines.count += 1;
            }
            _ => {
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

/// `report` of the host table: takes a message of a plugin. `[any]`
#[allow(unsafe_code, reason = "called from the other side of the border")]
pub(crate) unsafe extern "C" fn receive(host: *const abi::Host, severity: u32, text: *const c_char) {
    // SAFETY: the host table handed to a plugin has an `Inbox` behind `data` that outlives the instance; a plugin passes a
    // C string, or null, which is ignored.
    unsafe {
        if let Some(host) = host.as_ref()
            && !text.is_null()
        {
            (*host.data.cast::<Inbox>()).push(severity, CStr::from_ptr(text).to_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_lines_in_order_and_counts_what_it_drops() {
        let inbox = Inbox::default();
        for i in 0..CAPACITY + 3 {
            inbox.push(abi::INFO, format!("line {i}").as_bytes());
        }
        inbox.push(abi::ERROR, &[b'x'; 400]);
        let (messages, dropped) = inbox.take();
        assert_eq!((messages.len(), dropped), (CAPACITY, 4));
        assert_eq!(messages[5].text, "line 5");
        inbox.push(abi::ERROR, &[b'x'; 400]);
        assert_eq!(inbox.take().0[0].text.len(), 255);
    }
}
