//! Numbers that one thread writes and others read as a whole, without a lock (a sequence lock of atomics, Boehm 2012).

use std::sync::atomic::{AtomicU64, Ordering, fence};

/// `N` numbers.
pub struct Snapshot<const N: usize> {
    turn: AtomicU64,
    words: [AtomicU64; N],
}

/// Tries before an old value has to do.
const TRIES: usize = 64;

impl<const N: usize> Default for Snapshot<N> {
    fn default() -> Self {
        Self { turn: AtomicU64::new(0), words: [const { AtomicU64::new(0) }; N] }
    }
}

impl<const N: usize> Snapshot<N> {
    /// Puts a new value in its place; one thread only.
    pub fn write(&self, words: [u64; N]) {
        let turn = self.turn.load(Ordering::Relaxed);
        self.turn.store(turn + 1, Ordering::Relaxed);
        fence(Ordering::Release);
        self.words.iter().zip(words).for_each(|(to, from)| to.store(from, Ordering::Relaxed));
        self.turn.store(turn + 2, Ordering::Release);
    }

    /// The newest value; `None` if it was being written all the time.
    pub fn read(&self) -> Option<[u64; N]> {
        for _ in 0..TRIES {
            let before = self.turn.load(Ordering::Acquire);
            let words = std::array::from_fn(|i| self.words[i].load(Ordering::Relaxed));
            fence(Ordering::Acquire);
            if before.is_multiple_of(2) && self.turn.load(Ordering::Relaxed) == before {
                return Some(words);
            }
            std::hint::spin_loop();
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_was_written_together() {
        let shared = Snapshot::<8>::default();
        std::thread::scope(|scope| {
            scope.spawn(|| (1..=200_000).for_each(|i| shared.write([i; 8])));
            let mut last = 0;
            while last < 200_000 {
                if let Some(words) = shared.read() {
                    assert!(words.iter().all(|w| *w == words[0]) && words[0] >= last);
                    last = words[0];
                }
            }
        });
    }
}
