//! A worker pool for parallel loops whose results do not depend on the number of threads.

mod worker_pool;

use std::hint::spin_loop;
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use worker_pool::WorkerPool;

/// A worker pool of a fixed number of threads; a pool of one runs everything on the calling thread.
pub struct Pool {
    threads: usize,
    /// Depth of the binary splits that give each thread one part of a loop, the same part in every loop, whose data are in its cache.
    halvings: u32,
    /// Workers for a calling thread that already belongs to another pool.
    apart: OnceLock<Option<WorkerPool>>,
    /// Whether the system refused to create threads.
    alone: AtomicBool,
}

/// Largest number of threads of a pool: more than any machine of today has processors, and fewer than a process may start.
pub const MAX_THREADS: usize = 1024;
/// Smallest number of nodes in a chunk of a vector for a thread.
pub const NODES: usize = 1024;
/// Number of items in a block of a sum; constant, so that the order of additions is too.
const SUM_BLOCK: usize = 256;
/// Smallest number of blocks per thread for which a sum is split.
const PARALLEL_BLOCKS: usize = 8;
/// Number of spins of a waiting thread before it yields its processor.
const SPINS_BEFORE_YIELD: u32 = 1024;

impl Pool {
    /// A pool of `threads` threads including the calling thread, at least 1 and at most [`MAX_THREADS`].
    pub fn new(threads: usize) -> Self {
        let threads = threads.clamp(1, MAX_THREADS);
        let halvings = threads.next_power_of_two().ilog2();
        Self { threads, halvings, apart: OnceLock::new(), alone: AtomicBool::new(false) }
    }

    /// Number of threads: one if the system refused to create more, which is known after the first use.
    pub fn threads(&self) -> usize {
        if self.alone.load(Ordering::Relaxed) { 1 } else { self.threads }
    }

    /// Whether the system refused to create the threads, so that everything runs on the calling thread; known after the first use.
    pub fn is_refused(&self) -> bool {
        self.alone.load(Ordering::Relaxed)
    }

    /// Depth of the binary splits that give each thread one part of a loop.
    pub fn halvings(&self) -> u32 {
        self.halvings
    }

    /// Runs `work` on the pool: on the calling thread and on workers, which stay awake for about 1 ms afterwards. If the system refuses to create
    /// threads, it runs on the calling thread alone.
    ///
    /// A thread that calls this becomes a permanent member of the pool: its direct calls of `rayon` run there too.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        if self.threads == 1 || self.alone.load(Ordering::Relaxed) {
            return work();
        }
        if let Some(pool) = WorkerPool::here(self.threads) {
            return pool.run(work);
        }
        match self.apart.get_or_init(|| WorkerPool::apart(self.threads)) {
            Some(pool) => pool.run(work),
            None => {
                self.alone.store(true, Ordering::Relaxed);
                work()
            }
        }
    }

    /// Runs both closures, in parallel if there is more than one thread. Called outside of any pool, it does so within [`install`](Self::install):
    /// `rayon` would start a pool of its own, of as many threads as there are processors.
    pub fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        if self.threads == 1 || self.alone.load(Ordering::Relaxed) {
            return (a(), b());
        }
        if rayon::current_thread_index().is_none() {
            return self.install(|| self.join(a, b));
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

    /// Splits `items` into chunks of at least `min_len` items and runs `work` on each with the index of its first item.
    pub fn par_chunks<P: Splittable>(&self, items: P, min_len: usize, work: &(impl Fn(usize, P) + Sync)) {
        self.par_chunks_from(0, items, min_len.max(1), self.halvings, work);
    }

    fn par_chunks_from<P: Splittable>(
        &self,
        first: usize,
        items: P,
        min_len: usize,
        halvings: u32,
        work: &(impl Fn(usize, P) + Sync),
    ) {
        if halvings == 0 || items.count() < 2 * min_len {
            return work(first, items);
        }
        let half = items.count() / 2;
        let (left, right) = items.split_at(half);
        let less = halvings - 1;
        self.join(
            || self.par_chunks_from(first, left, min_len, less, work),
            || self.par_chunks_from(first + half, right, min_len, less, work),
        );
    }

    /// Runs `work` on blocks of `items`, each with the index of its first item, and returns the sum of the results. Blocks and the tree of
    /// additions are always the same, so the sum does not depend on the number of threads.
    pub fn fold<P: Splittable>(&self, items: P, work: &(impl Fn(usize, P) -> f64 + Sync)) -> f64 {
        self.fold_blocks(0, items, self.halvings, work)
    }

    fn fold_blocks<P: Splittable>(
        &self,
        first: usize,
        items: P,
        halvings: u32,
        work: &(impl Fn(usize, P) -> f64 + Sync),
    ) -> f64 {
        let blocks = items.count().div_ceil(SUM_BLOCK);
        if blocks <= 1 {
            return if blocks == 0 { 0.0 } else { work(first, items) };
        }
        let middle = blocks / 2 * SUM_BLOCK;
        let (left, right) = items.split_at(middle);
        let less = halvings.saturating_sub(1);
        let left = || self.fold_blocks(first, left, less, work);
        let right = || self.fold_blocks(first + middle, right, less, work);
        let apart = halvings > 0 && blocks >= PARALLEL_BLOCKS;
        let (left, right) = if apart { self.join(left, right) } else { (left(), right()) };
        left + right
    }
}

/// Whether one part of a join was started by another thread, and whether it is done.
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

    /// Waits until the part is done, if another thread started it. It spins, because the system's scheduler would put the thread to sleep after a few
    /// microseconds.
    fn wait(&self) {
        let mut looked = 0_u32;
        while self.begun.load(Ordering::Acquire) && !self.over.load(Ordering::Acquire) {
            looked += 1;
            // Yields in case there are more threads than processors.
            if looked.is_multiple_of(SPINS_BEFORE_YIELD) { std::thread::yield_now() } else { spin_loop() }
        }
    }
}

/// Sets the flag on drop, so a panic sets it too.
struct Finish<'a>(&'a AtomicBool);

impl Drop for Finish<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// A sequence of items that can be split in two, such as a slice, or several slices of equal length.
pub trait Splittable: Send + Sized {
    /// Number of items.
    fn count(&self) -> usize;
    /// The items before index `at`, and those from it on.
    fn split_at(self, at: usize) -> (Self, Self);
}

impl<T: Send> Splittable for &mut [T] {
    fn count(&self) -> usize {
        self.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        self.split_at_mut(at)
    }
}

impl Splittable for Range<usize> {
    fn count(&self) -> usize {
        self.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        (self.start..self.start + at, self.start + at..self.end)
    }
}

impl<A: Splittable, const K: usize> Splittable for [A; K] {
    fn count(&self) -> usize {
        self.first().map_or(0, A::count)
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let mut right = [const { None }; K];
        let mut rest = right.iter_mut();
        let left = self.map(|parts| {
            let (left, right) = parts.split_at(at);
            if let Some(place) = rest.next() {
                *place = Some(right);
            }
            left
        });
        (left, right.map(|part| part.expect("one for each")))
    }
}

impl<A: Splittable, B: Splittable> Splittable for (A, B) {
    fn count(&self) -> usize {
        self.0.count()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.split_at(at), self.1.split_at(at));
        ((a, b), (c, d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn a_panic_in_one_part_ends_the_loop() {
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
    fn absurd_numbers_of_threads_are_clamped() {
        assert_eq!([0, 1, usize::MAX].map(|threads| Pool::new(threads).threads()), [1, 1, MAX_THREADS]);
        assert_eq!(Pool::new(usize::MAX).halvings(), 10);
    }

    #[test]
    fn without_system_threads_the_calling_thread_works() {
        let pool = Pool::new(3);
        assert_eq!(pool.threads(), 3);
        pool.apart.set(None).ok();
        // A member of another pool is not a member of this one.
        Pool::new(2).install(|| assert_eq!(pool.install(|| pool.join(|| 1, || 2)), (1, 2)));
        assert!(pool.threads() == 1 && pool.is_refused());
    }

    #[test]
    fn loops_outside_of_a_pool_run_on_its_threads() {
        let run = || {
            let pool = Pool::new(3);
            let inside = || rayon::current_thread_index().map(|_| rayon::current_num_threads());
            assert_eq!(pool.join(inside, inside), (Some(3), Some(3)));
            let (sum, seen) = (AtomicUsize::new(0), std::sync::Mutex::new(Vec::new()));
            pool.par_chunks(0..4000, 100, &|_, part: Range<usize>| {
                sum.fetch_add(part.len(), Ordering::Relaxed);
                seen.lock().unwrap().push(inside());
            });
            assert_eq!(sum.into_inner(), 4000);
            let seen = seen.into_inner().unwrap();
            assert!(seen.len() > 1 && seen.iter().all(|threads| *threads == Some(3)), "{seen:?}");
        };
        // On a thread that belongs to no pool yet.
        std::thread::spawn(run).join().unwrap();
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
    fn chunks_cover_every_item_once() {
        for threads in [1, 3] {
            let mut out = vec![0_usize; 10_000];
            Pool::new(threads).par_chunks(&mut out[..], 64, &|first, piece: &mut [usize]| {
                for (i, o) in piece.iter_mut().enumerate() {
                    *o += first + i;
                }
            });
            assert!(out.iter().enumerate().all(|(i, &o)| i == o));
        }
    }
}
