//! Messages of plugins: lines of text from any thread, received without waiting.

use pliant_plugin_api::abi;
use std::ffi::{CStr, c_char};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

/// One message of a plugin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// [`abi::INFO`], [`abi::WARNING`] or [`abi::ERROR`].
    pub severity: u32,
    /// Text of at most 255 bytes.
    pub text: String,
}

/// Messages that were not read before.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NewMessages {
    /// The messages in order.
    pub messages: Vec<Message>,
    /// Number of messages that were lost.
    pub lost: u64,
}

/// Unread messages. A full or locked inbox drops a message and counts it.
#[derive(Default)]
pub(crate) struct Inbox {
    /// Messages that were not taken yet.
    lines: Mutex<Lines>,
    /// Number of messages dropped since the last read.
    dropped: AtomicU64,
    /// Number of calls under way in which a warning is about elements.
    element_calls: AtomicU32,
}

/// Largest number of unread messages.
const CAPACITY: usize = 32;
/// Bytes of a slot: a text and a final 0.
const SLOT: usize = 256;

/// Messages in preallocated slots.
struct Lines {
    /// Number of messages.
    count: usize,
    /// Slots; the first `count` are in use.
    slots: [Line; CAPACITY],
    /// The last warning about elements, which stays when messages are taken.
    element_warning: Option<Line>,
    /// The last warning about anything else, which stays too.
    warning: Option<Line>,
}

/// A message in a slot.
#[derive(Clone, Copy)]
struct Line {
    /// Severity, as in [`Message`].
    severity: u32,
    /// Text, padded with zeros.
    text: [u8; SLOT],
}

impl Default for Lines {
    fn default() -> Self {
        Self {
            count: 0,
            slots: [Line { severity: 0, text: [0; SLOT] }; CAPACITY],
            element_warning: None,
            warning: None,
        }
    }
}

impl Line {
    /// A line with the first bytes of `text`.
    fn new(severity: u32, text: &[u8]) -> Self {
        let (mut line, len) = (Self { severity, text: [0; SLOT] }, text.len().min(SLOT - 1));
        line.text[..len].copy_from_slice(&text[..len]);
        line
    }

    /// The line as a message.
    fn message(&self) -> Message {
        let end = self.text.iter().position(|b| *b == 0).unwrap_or(SLOT - 1);
        Message { severity: self.severity, text: String::from_utf8_lossy(&self.text[..end]).into_owned() }
    }
}

impl Inbox {
    /// Messages since the last call.
    pub(crate) fn take(&self) -> NewMessages {
        let mut lines = self.lines();
        let messages = lines.slots[..lines.count].iter().map(Line::message).collect();
        lines.count = 0;
        NewMessages { messages, lost: self.dropped.swap(0, Ordering::Relaxed) }
    }

    /// Text of the last warning that was not about elements, whether messages were taken since or not.
    pub(crate) fn last_warning(&self) -> Option<String> {
        self.lines().warning.as_ref().map(|line| line.message().text)
    }

    /// Text of the last warning about elements since [`Inbox::forget_element_warning`].
    pub(crate) fn element_warning(&self) -> Option<String> {
        self.lines().element_warning.as_ref().map(|line| line.message().text)
    }

    /// Forgets the warning about elements, which are about to be looked at anew.
    pub(crate) fn forget_element_warning(&self) {
        self.lines().element_warning = None;
    }

    /// Makes a call in which every warning is about elements.
    pub(crate) fn about_elements<T>(&self, make: impl FnOnce() -> T) -> T {
        self.element_calls.fetch_add(1, Ordering::Relaxed);
        let made = make();
        self.element_calls.fetch_sub(1, Ordering::Relaxed);
        made
    }

    fn lines(&self) -> MutexGuard<'_, Lines> {
        self.lines.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Stores a message, or counts it as lost.
    fn push(&self, severity: u32, text: &[u8]) {
        let Ok(mut lines) = self.lines.try_lock() else {
            self.dropped.fetch_add(1, Ordering::Relaxed);
            return;
        };
        let line = Line::new(severity, text);
        if severity == abi::WARNING {
            match self.element_calls.load(Ordering::Relaxed) {
                0 => lines.warning = Some(line),
                _ => lines.element_warning = Some(line),
            }
        }
        let at = lines.count;
        if at < CAPACITY {
            lines.slots[at] = line;
            lines.count += 1;
        } else {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// `report` of the host table: receives a message of a plugin. `[any]`
#[allow(unsafe_code, reason = "called by plugins")]
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
        let NewMessages { messages, lost } = inbox.take();
        assert_eq!((messages.len(), lost), (CAPACITY, 4));
        assert_eq!(messages[5].text, "line 5");
        inbox.push(abi::ERROR, &[b'x'; 400]);
        assert_eq!(inbox.take().messages[0].text.len(), 255);
        assert_eq!(inbox.last_warning(), None);
        (0..40).for_each(|i| inbox.push(abi::WARNING, format!("doubt {i}").as_bytes()));
        inbox.push(abi::INFO, b"line");
        assert_eq!(inbox.take().messages[3].text, "doubt 3");
        assert_eq!(inbox.last_warning().as_deref(), Some("doubt 39"), "of a full inbox too, and for good");
    }

    #[test]
    fn warnings_about_elements_are_kept_apart_until_elements_are_looked_at_anew() {
        let inbox = Inbox::default();
        inbox.push(abi::WARNING, b"no driver");
        inbox.about_elements(|| inbox.push(abi::WARNING, b"too wide"));
        inbox.push(abi::WARNING, b"slow");
        let warnings = || (inbox.element_warning(), inbox.last_warning());
        assert_eq!(warnings(), (Some("too wide".into()), Some("slow".into())));
        inbox.forget_element_warning();
        assert_eq!(warnings(), (None, Some("slow".into())));
    }
}
