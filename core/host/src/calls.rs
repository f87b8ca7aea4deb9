//! The call board: which call of which plugin each thread is in, so that a call that never returns can be named.
//!
//! A thread writes the call into its own slot before the call and clears the slot after it: a few relaxed stores. The slots are in memory of
//! this process, or in a file that another process has mapped too ([`share_calls`](crate::share_calls), [`CallBoard`](crate::CallBoard)): that
//! process can read them whatever the plugin does to this one.

use std::cell::Cell;
use std::sync::atomic::{AtomicPtr, AtomicU8, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Number of slots; calls of further threads are not recorded.
const SLOTS: usize = 256;
/// Number of plugin names on the board; calls of further plugins are recorded without a name.
const PLUGINS: usize = 64;
/// Bytes of a plugin's name, its id and the path of its file; longer names are cut off.
const NAME: usize = 512;
/// Bytes of the name of a call.
const CALL: usize = 16;

/// The call that a thread is in.
struct Slot {
    /// 0 outside of plugins; else the number of the call on its thread (upper 32 bits), and the index of the plugin's name plus 1.
    word: AtomicU64,
    /// Name of the call, padded with zeros.
    call: [AtomicU64; 2],
}

/// The calls of a process. A board of zeros, such as a new file, is empty.
#[repr(C)]
pub(crate) struct Board {
    /// Exit code plus 1 once the program has recorded it, else 0.
    exit_code: AtomicU64,
    /// A slot for each thread.
    slots: [Slot; SLOTS],
    /// Names of plugins, padded with zeros.
    names: [[AtomicU8; NAME]; PLUGINS],
}

/// The board of a process that does not share it.
static OWN: Board = Board {
    exit_code: AtomicU64::new(0),
    slots: [const { Slot { word: AtomicU64::new(0), call: [const { AtomicU64::new(0) }; 2] } }; SLOTS],
    names: [const { [const { AtomicU8::new(0) }; NAME] }; PLUGINS],
};

/// The board in use.
static BOARD: AtomicPtr<Board> = AtomicPtr::new((&raw const OWN).cast_mut());
/// Names on the board, in its order.
static NAMES: Mutex<Vec<String>> = Mutex::new(Vec::new());
/// Slots that no thread owns.
static FREE: Mutex<FreeSlots> = Mutex::new(FreeSlots { returned: Vec::new(), first_unused: 0 });

/// Slots that no thread owns.
struct FreeSlots {
    /// Indices of slots of threads that have ended.
    returned: Vec<usize>,
    /// Slots from this index on were never used.
    first_unused: usize,
}

/// Index of the slot of a thread without one.
const NONE: usize = usize::MAX;

thread_local! {
    /// Index of the slot of this thread, or [`NONE`].
    static SLOT: Cell<usize> = const { Cell::new(NONE) };
    /// Number of the next call of this thread.
    static NEXT: Cell<u64> = const { Cell::new(1) };
    /// Takes a slot at its first use and returns it when the thread ends.
    static OWNER: SlotOwner = SlotOwner::take();
}

/// A slot, by its index, that belongs to a thread.
struct SlotOwner(usize);

impl SlotOwner {
    /// Takes a free slot, or none if there is none.
    fn take() -> Self {
        let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = free.returned.pop().or_else(|| {
            free.first_unused += 1;
            (free.first_unused <= SLOTS).then(|| free.first_unused - 1)
        });
        Self(slot.unwrap_or(NONE))
    }
}

impl Drop for SlotOwner {
    fn drop(&mut self) {
        // A thread that ends the program inside of a call keeps its slot, which names the call.
        if self.0 != NONE && board().slots[self.0].word.load(Ordering::Relaxed) == 0 {
            SLOT.set(NONE);
            FREE.lock().unwrap_or_else(PoisonError::into_inner).returned.push(self.0);
        }
    }
}

/// The board in use.
#[allow(unsafe_code, reason = "the board may lie in memory that is shared with another process")]
pub(crate) fn board() -> &'static Board {
    // SAFETY: `OWN`, or a mapping that is never unmapped; every part of a board is atomic.
    unsafe { &*BOARD.load(Ordering::Acquire) }
}

/// Uses another board from now on. Call it before the first plugin is opened.
pub(crate) fn use_board(new: &'static Board) {
    BOARD.store(std::ptr::from_ref(new).cast_mut(), Ordering::Release);
}

/// Index of a plugin's name on the board; a new name is added.
pub(crate) fn register(name: &str) -> u32 {
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(index) = names.iter().position(|known| known == name) {
        return index as u32;
    }
    if let Some(bytes) = board().names.get(names.len()) {
        bytes.iter().zip(name.bytes().take(NAME)).for_each(|(to, from)| to.store(from, Ordering::Relaxed));
    }
    names.push(name.to_owned());
    names.len() as u32 - 1
}

/// Records that this thread is in a call, until it is dropped. Has the index of the thread's slot.
pub(crate) struct InCall(usize);

impl InCall {
    /// Enters `call` of the plugin whose name has the index `plugin`.
    #[inline]
    pub(crate) fn enter(plugin: u32, call: &'static str) -> Self {
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
            slot.word.store(number << 32 | u64::from(plugin + 1), Ordering::Release);
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
    /// Index of the thread among those that call plugins.
    pub thread: usize,
    /// Number of the call on its thread.
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
    /// The calls that threads are in.
    pub(crate) fn calls(&self) -> Vec<PluginCall> {
        let read = |(thread, slot): (usize, &Slot)| {
            let word = slot.word.load(Ordering::Acquire);
            let call = [0, 1].map(|half| slot.call[half].load(Ordering::Relaxed).to_le_bytes()).concat();
            let plugin = (word & u64::from(u32::MAX)).checked_sub(1)?;
            let name = self.names.get(plugin as usize).map_or(&[][..], |name| &name[..]);
            let name: Vec<u8> = name.iter().map(|byte| byte.load(Ordering::Relaxed)).collect();
            Some(PluginCall { thread, number: word >> 32, plugin: text(&name), call: text(&call) })
        };
        self.slots.iter().enumerate().filter_map(read).collect()
    }

    /// The recorded exit code, if there is one.
    pub(crate) fn exit_code(&self) -> Option<u8> {
        self.exit_code.load(Ordering::Acquire).checked_sub(1).and_then(|code| u8::try_from(code).ok())
    }

    /// Records the exit code of the program.
    pub(crate) fn record_exit_code(&self, code: u8) {
        self.exit_code.store(u64::from(code) + 1, Ordering::Release);
    }
}

/// The text before the first zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// The calls that threads of this process are in.
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
