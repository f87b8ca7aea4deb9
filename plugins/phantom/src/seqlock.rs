//! A sequence lock (Boehm 2012): one thread writes a group of numbers, others read the group as a whole, and no thread waits for another.

use std::sync::atomic::{AtomicU64, Ordering, fence};

/// `N` words that are written and read together.
pub struct SeqLock<const N: usize> {
    /// Odd while the words are being written.
    sequence: AtomicU64,
    words: [AtomicU64; N],
}

/// Attempts of a reader before it gives up, so that it does not wait for a writer.
const MAX_READ_ATTEMPTS: usize = 64;

impl<const N: usize> Default for SeqLock<N> {
    fn default() -> Self {
        Self { sequence: AtomicU64::new(0), words: [const { AtomicU64::new(0) }; N] }
    }
}

impl<const N: usize> SeqLock<N> {
    /// Replaces the words. Only one thread may call it.
    pub fn write(&self, words: [u64; N]) {
        let sequence = self.sequence.load(Ordering::Relaxed);
        self.sequence.store(sequence + 1, Ordering::Relaxed);
        fence(Ordering::Release);
        self.words.iter().zip(words).for_each(|(to, from)| to.store(from, Ordering::Relaxed));
        self.sequence.store(sequence + 2, Ordering::Release);
    }

    /// The words of the last write, zeros before the first; `None` if every attempt met a write.
    pub fn read(&self) -> Option<[u64; N]> {
        for _ in 0..MAX_READ_ATTEMPTS {
            let before = self.sequence.load(Ordering::Acquire);
            let words = std::array::from_fn(|i| self.words[i].load(Ordering::Relaxed));
            fence(Ordering::Acquire);
            if before.is_multiple_of(2) && self.sequence.load(Ordering::Relaxed) == before {
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
    fn words_are_read_as_they_were_written_together() {
        let shared = SeqLock::<8>::default();
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
