//! Which call of which plugin every thread is in, so that a call that never returns can be named.
//!
//! A thread writes the call into a slot of its own before the call and clears the slot after it: a few relaxed stores. The slots are
//! in memory of this process, or in a file that another process has mapped too ([`share_calls`], [`CallBoard`]): that process can read
//! them whatever the plugin does to this one.

use std::cell::Cell;
use std::sync::atomic::{AtomicPtr, AtomicU8, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Threads that can be in a plugin at a time and are seen; calls of further threads are not noted.
const SLOTS: usize = 256;
/// Plugins that have a name on the board; calls of further plugins are noted without one.
const PLUGINS: usize = 64;
/// Bytes of a plugin's name: its id and the path of its file. A longer one is cut off.
const NAME: usize = 512;
/// Bytes of the name of a call.
const CALL: usize = 16;

/// What a thread is in.
struct Slot {
    /// 0 outside of plugins; else a number that differs from call to call (upper half), and the place of the plugin's name plus 1.
    word: AtomicU64,
    /// Name of the call, padded with zeros.
    call: [AtomicU64; 2],
}

/// The calls of a process. All zero is an empty one, as a new file is.
#[repr(C)]
pub(crate) struct Board {
    /// Exit code plus 1 once the program has ended by itself, else 0.
    ended: AtomicU64,
    slots: [Slot; SLOTS],
    names: [[AtomicU8; NAME]; PLUGINS],
}

/// The board of this process where no other process reads it.
static OWN: Board = Board {
    ended: AtomicU64::new(0),
    slots: [const { Slot { word: AtomicU64::new(0), call: [const { AtomicU64::new(0) }; 2] } }; SLOTS],
    names: [const { [const { AtomicU8::new(0) }; NAME] }; PLUGINS],
};

/// The board in use.
static BOARD: AtomicPtr<Board> = AtomicPtr::new((&raw const OWN).cast_mut());
/// Names on the board, in order.
static NAMES: Mutex<Vec<String>> = Mutex::new(Vec::new());
/// Places of slots that no thread has; places from the second number on were never given out.
static FREE: Mutex<(Vec<usize>, usize)> = Mutex::new((Vec::new(), 0));

/// Stands for the place of a slot where a thread has none.
const NONE: usize = usize::MAX;

thread_local! {
    /// Slot of this thread, or [`NONE`].
    static SLOT: Cell<usize> = const { Cell::new(NONE) };
    /// Number of the next call of this thread.
    static NEXT: Cell<u64> = const { Cell::new(1) };
    /// Takes a slot when it is first used, and gives it back when the thread ends.
    static OWNER: SlotOwner = SlotOwner::take();
}

/// A slot that belongs to a thread.
struct SlotOwner(usize);

impl SlotOwner {
    fn take() -> Self {
        let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = free.0.pop().or_else(|| {
            free.1 += 1;
            (free.1 <= SLOTS).then(|| free.1 - 1)
        });
        Self(slot.unwrap_or(NONE))
    }
}

impl Drop for SlotOwner {
    fn drop(&mut self) {
        // A thread that ends the program inside of a call keeps its slot: it says where.
        if self.0 != NONE && board().slots[self.0].word.load(Ordering::Relaxed) == 0 {
            SLOT.set(NONE);
            FREE.lock().unwrap_or_else(PoisonError::into_inner).0.push(self.0);
        }
    }
}

/// The board in use.
#[allow(unsafe_code, reason = "the board may lie in memory that is shared with another process")]
pub(crate) fn board() -> &'static Board {
    // SAFETY: `OWN`, or a mapping that is never unmapped; every part of a board is atomic.
    unsafe { &*BOARD.load(Ordering::Acquire) }
}

/// Uses another board from now on; to be called before the first plugin is opened.
pub(crate) fn use_board(new: &'static Board) {
    BOARD.store(std::ptr::from_ref(new).cast_mut(), Ordering::Release);
}

/// Place of a plugin's name on the board, which is added if it is new.
pub(crate) fn register(name: &str) -> u32 {
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(place) = names.iter().position(|known| known == name) {
        return place as u32;
    }
    if let Some(bytes) = board().names.get(names.len()) {
        bytes.iter().zip(name.bytes().take(NAME)).for_each(|(to, from)| to.store(from, Ordering::Relaxed));
    }
    names.push(name.to_owned());
    names.len() as u32 - 1
}

/// Notes that this thread is in a call until it is dropped.
pub(crate) struct InCall(usize);

impl InCall {
    /// Enters `call` of the plugin whose name is at `place`.
    #[inline]
    pub(crate) fn enter(place: u32, call: &'static str) -> Self {
        let mut slot = SLOT.get();
        if slot == NONE {
            slot = OWNER.try_with(|owner| owner.0).unwrap_or(NONE);
            SLOT.set(slot);
        }
        if slot != NONE {
            let number = NEXT.get();
            NEXT.set(number + 1);
            let mut name = [0; CALL];
            let len = call.len().min(CALL);
            name[..len].copy_from_slice(&call.as_bytes()[..len]);
            let name = u128::from_le_bytes(name);
            let slot = &board().slots[slot];
            slot.call[0].store(name as u64, Ordering::Relaxed);
            slot.call[1].store((name >> 64) as u64, Ordering::Relaxed);
            slot.word.store(number << 32 | u64::from(place + 1), Ordering::Release);
        }
        Self(slot)
    }
}

impl Drop for InCall {
    #[inline]
    fn drop(&mut self) {
        if self.0 != NONE {
            board().slots[self.0].word.store(0, Ordering::Release);
        }
    }
}

/// A call that a thread is in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PluginCall {
    /// Place of the thread among those that have called plugins.
    pub thread: usize,
    /// Unlike that of the thread's other calls.
    pub number: u64,
    /// Id of the plugin and path of its file, or the path of the library that is being opened.
    pub plugin: String,
    /// Function of the plugin interface; `open` while a library is opened.
    pub call: String,
}

impl std::fmt::Display for PluginCall {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` of plugin {}", self.call, self.plugin)
    }
}

impl Board {
    /// Every call that a thread is in.
    pub(crate) fn calls(&self) -> Vec<PluginCall> {
        let read = |(thread, slot): (usize, &Slot)| {
            let word = slot.word.load(Ordering::Acquire);
            let call = [0, 1].map(|half| slot.call[half].load(Ordering::Relaxed).to_le_bytes()).concat();
            let place = (word & u64::from(u32::MAX)).checked_sub(1)?;
            let name = self.names.get(place as usize).map_or(&[][..], |name| &name[..]);
            let name: Vec<u8> = name.iter().map(|byte| byte.load(Ordering::Relaxed)).collect();
            Some(PluginCall { thread, number: word >> 32, plugin: text(&name), call: text(&call) })
        };
        self.slots.iter().enumerate().filter_map(read).collect()
    }

    /// The exit code with which the program has ended by itself; `None` if it has not.
    pub(crate) fn ended(&self) -> Option<u8> {
        self.ended.load(Ordering::Acquire).checked_sub(1).and_then(|code| u8::try_from(code).ok())
    }

    /// Notes that the program ends by itself, with an exit code.
    pub(crate) fn end(&self, code: u8) {
        self.ended.store(u64::from(code) + 1, Ordering::Release);
    }
}

/// The text before the first zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// Calls of plugins that threads of this process are in.
pub fn plugin_calls() -> Vec<PluginCall> {
    board().calls()
}

/// The call that this thread is in, if it is in one.
pub(crate) fn own_call() -> Option<PluginCall> {
    let slot = SLOT.get();
    board().calls().into_iter().find(|call| call.thread == slot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_of_every_thread_are_seen_while_they_last() {
        let place = register("springs (/a/b.so)");
        assert_eq!(register("springs (/a/b.so)"), place);
        let outer = InCall::enter(place, "forces");
        let first = own_call().expect("in a call");
        assert_eq!((first.plugin.as_str(), first.call.as_str()), ("springs (/a/b.so)", "forces"));
        let other = std::thread::spawn(move || {
            let _in = InCall::enter(place, "a_name_of_more_than_16_bytes");
            let calls = plugin_calls();
            (own_call().expect("in a call"), calls)
        });
        let (other, calls) = other.join().expect("no panic");
        assert_eq!(other.call, "a_name_of_more_t");
        assert!(calls.contains(&first) && calls.contains(&other) && first.thread != other.thread);
        drop(outer);
        assert_eq!(own_call(), None);
        let _again = InCall::enter(place, "forces");
        assert_ne!(own_call().expect("in a call").number, first.number);
    }

    #[test]
    fn slots_of_ended_threads_are_used_again() {
        for _ in 0..3 * SLOTS {
            let seen = std::thread::spawn(|| {
                let _in = InCall::enter(0, "energy");
                own_call().is_some()
            });
            assert!(seen.join().expect("no panic"));
        }
    }
}
