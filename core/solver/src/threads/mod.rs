//! Threads for a step. What they compute never depends on how many there are.

mod crew;

use crew::Crew;
use std::hint::spin_loop;
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// A fixed number of threads; one means the caller's own.
pub struct Pool {
    threads: usize,
    /// How often work is halved until each thread has a part of it: the same part of each, whose numbers are near it then.
    halvings: u32,
    /// For a thread that works elsewhere already.
    apart: OnceLock<Option<Crew>>,
    /// Whether the system gave no threads.
    alone: AtomicBool,
}

/// Nodes in a piece of a vector for a thread.
pub const NODES: usize = 1024;
/// Items in a block of a sum: fixed, so that sums have one order.
const SUM_BLOCK: usize = 256;
/// Blocks that are worth another thread.
const PARALLEL_BLOCKS: usize = 8;
/// Looks after which a thread that waits for a part of its own work lets others have its processor.
const PATIENT: u32 = 1024;

impl Pool {
    /// A pool of `threads`, at least one.
    pub fn new(threads: usize) -> Self {
        let threads = threads.max(1);
        let halvings = threads.next_power_of_two().ilog2();
        Self { threads, halvings, apart: OnceLock::new(), alone: AtomicBool::new(false) }
    }

    /// Threads that work: one where the system gave no more, which is known once they were needed.
    pub fn threads(&self) -> usize {
        if self.alone.load(Ordering::Relaxed) { 1 } else { self.threads }
    }

    /// How often work is halved until each thread has a part of it.
    pub fn halvings(&self) -> u32 {
        self.halvings
    }

    /// Runs `work` on the pool: on this thread and others, which stay awake for some time, or on this one alone where the system
    /// gives no more.
    ///
    /// The first time a thread comes here it becomes one of its pool's for good: what it gives to `rayon` itself runs there too.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        if self.threads == 1 || self.alone.load(Ordering::Relaxed) {
            return work();
        }
        if let Some(crew) = Crew::here(self.threads) {
            return crew.run(work);
        }
        match self.apart.get_or_init(|| Crew::apart(self.threads)) {
            Some(crew) => crew.run(work),
            None => {
                self.alone.store(true, Ordering::Relaxed);
                work()
            }
        }
    }

    /// Both, at once if there are threads.
    pub fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        if self.threads == 1 || self.alone.load(Ordering::Relaxed) {
            return (a(), b());
        }
        let other = Taken::default();
        rayon::join(
            || {
                let done = a();
                other.wait();
                done
            },
            || other.run(b),
        )
    }

    /// Splits `parts` into pieces of at least `least` items and runs `work` on each with the place of its first item.
    pub fn pieces<P: Parts>(&self, parts: P, least: usize, work: &(impl Fn(usize, P) + Sync)) {
        self.piece((0, parts), least.max(1), self.halvings, work);
    }

    fn piece<P: Parts>(
        &self,
        (first, parts): (usize, P),
        least: usize,
        halvings: u32,
        work: &(impl Fn(usize, P) + Sync),
    ) {
        if halvings == 0 || parts.count() < 2 * least {
            return work(first, parts);
        }
        let half = parts.count() / 2;
        let (left, right) = parts.part(half);
        let (left, right) = ((first, left), (first + half, right));
        self.join(|| self.piece(left, least, halvings - 1, work), || self.piece(right, least, halvings - 1, work));
    }

    /// Runs `work` on blocks of `parts`, each with the place of its first item, and adds up what it gives: always the same
    /// blocks, added in the same tree.
    pub fn fold<P: Parts>(&self, parts: P, work: &(impl Fn(usize, P) -> f64 + Sync)) -> f64 {
        self.fold_blocks((0, parts), self.halvings, work)
    }

    fn fold_blocks<P: Parts>(
        &self,
        (first, parts): (usize, P),
        halvings: u32,
        work: &(impl Fn(usize, P) -> f64 + Sync),
    ) -> f64 {
        let blocks = parts.count().div_ceil(SUM_BLOCK);
        if blocks <= 1 {
            return if blocks == 0 { 0.0 } else { work(first, parts) };
        }
        let middle = blocks / 2 * SUM_BLOCK;
        let (left, right) = parts.part(middle);
        let (left, right, less) = ((first, left), (first + middle, right), halvings.saturating_sub(1));
        let (left, right) = (|| self.fold_blocks(left, less, work), || self.fold_blocks(right, less, work));
        let apart = halvings > 0 && blocks >= PARALLEL_BLOCKS;
        let (left, right) = if apart { self.join(left, right) } else { (left(), right()) };
        left + right
    }
}

/// Whether a part of the work was taken by another thread, and is done.
#[derive(Default)]
struct Taken {
    begun: AtomicBool,
    over: AtomicBool,
}

impl Taken {
    fn run<R>(&self, work: impl FnOnce() -> R) -> R {
        self.begun.store(true, Ordering::Release);
        let _finish = Finish(&self.over);
        work()
    }

    /// Waits for it, if another thread is at it: left to the system's scheduler, a wait of more than some microseconds ends in
    /// a sleep.
    fn wait(&self) {
        let mut looked = 0_u32;
        while self.begun.load(Ordering::Acquire) && !self.over.load(Ordering::Acquire) {
            looked += 1;
            // There may be more threads than processors.
            if looked.is_multiple_of(PATIENT) { std::thread::yield_now() } else { spin_loop() }
        }
    }
}

/// Says so, also if the work panics.
struct Finish<'a>(&'a AtomicBool);

impl Drop for Finish<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Items that can be cut, such as slices of one length at the same place.
pub trait Parts: Send + Sized {
    /// Items there are.
    fn count(&self) -> usize;
    /// The items before a place, and those from it on.
    fn part(self, at: usize) -> (Self, Self);
}

impl<T: Send> Parts for &mut [T] {
    fn count(&self) -> usize {
        self.len()
    }

    fn part(self, at: usize) -> (Self, Self) {
        self.split_at_mut(at)
    }
}

impl Parts for Range<usize> {
    fn count(&self) -> usize {
        self.len()
    }

    fn part(self, at: usize) -> (Self, Self) {
        (self.start..self.start + at, self.start + at..self.end)
    }
}

impl<A: Parts, const K: usize> Parts for [A; K] {
    fn count(&self) -> usize {
        self.first().map_or(0, A::count)
    }

    fn part(self, at: usize) -> (Self, Self) {
        let mut right = [const { None }; K];
        let mut rest = right.iter_mut();
        let left = self.map(|parts| {
            let (left, right) = parts.part(at);
            if let Some(place) = rest.next() {
                *place = Some(right);
            }
            left
        });
        (left, right.map(|part| part.expect("one for each")))
    }
}

impl<A: Parts, B: Parts> Parts for (A, B) {
    fn count(&self) -> usize {
        self.0.count()
    }

    fn part(self, at: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.part(at), self.1.part(at));
        ((a, b), (c, d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_panics_in_one_part_ends_the_whole() {
        let pool = Pool::new(2);
        for fails in [[true, false], [false, true]] {
            let taken = AtomicBool::new(false);
            let run = || {
                pool.install(|| {
                    let left = || {
                        while !taken.load(Ordering::Acquire) {
                            spin_loop();
                        }
                        assert!(!fails[0], "on purpose");
                    };
                    let right = || {
                        taken.store(true, Ordering::Release);
                        assert!(!fails[1], "on purpose");
                    };
                    pool.join(left, right)
                })
            };
            assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
        }
        assert_eq!(pool.install(|| pool.join(|| 1, || 2)), (1, 2));
    }

    #[test]
    fn where_the_system_gives_no_threads_one_works() {
        let pool = Pool::new(3);
        assert_eq!(pool.threads(), 3);
        pool.apart.set(None).ok();
        // A thread of another crew is none of this one.
        Pool::new(2).install(|| assert_eq!(pool.install(|| pool.join(|| 1, || 2)), (1, 2)));
        assert_eq!(pool.threads(), 1);
    }

    #[test]
    fn sums_have_the_same_bytes_for_any_number_of_threads() {
        let terms: Vec<f64> = (0..100_003).map(|i| (i as f64).sin() * 1e3_f64.powi(i % 7)).collect();
        let sum = |threads| {
            let mut seen = vec![0.0; terms.len()];
            Pool::new(threads).fold(&mut seen[..], &|first, seen| {
                seen.copy_from_slice(&terms[first..first + seen.len()]);
                seen.iter().sum()
            })
        };
        let one = sum(1);
        assert_eq!(one.to_bits(), sum(2).to_bits());
        assert_eq!(one.to_bits(), sum(4).to_bits());
        assert_ne!(one.to_bits(), terms.iter().sum::<f64>().to_bits(), "the order matters for these terms");
    }

    #[test]
    fn pieces_cover_everything_once() {
        for threads in [1, 3] {
            let mut out = vec![0_usize; 10_000];
            Pool::new(threads).pieces(&mut out[..], 64, &|first, piece: &mut [usize]| {
                for (i, o) in piece.iter_mut().enumerate() {
                    *o += first + i;
                }
            });
            assert!(out.iter().enumerate().all(|(i, &o)| i == o));
        }
    }
}
