//! Worker threads that stay awake between steps.
//!
//! Waking a thread takes as long as a small step, so the calling thread is a member of the pool if possible, and idle workers poll for 1 ms before
//! they sleep. Polling is one `rayon` job for the lifetime of the pool, so neither sleeping nor waking allocates.

use rayon::{ThreadPool, ThreadPoolBuilder, Yield};
use std::cell::RefCell;
use std::hint::spin_loop;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Time for which an idle worker polls before it sleeps: the period of a haptic loop.
const POLL_TIME: Duration = Duration::from_millis(1);
/// Number of polls before a worker yields its processor.
const POLLS_BEFORE_YIELD: u32 = 64;
/// Pause between polls of a worker that has found nothing for long while others are at work.
const NAP: Duration = Duration::from_micros(100);

/// Worker threads of one pool.
pub struct WorkerPool {
    workers: ThreadPool,
    watch: Arc<Watch>,
}

/// Shared state that keeps workers awake or lets them sleep.
#[derive(Default)]
struct Watch {
    /// Calls of [`WorkerPool::run`] under way.
    calls: AtomicUsize,
    /// Calls so far.
    called: AtomicUsize,
    /// Workers that sleep or are about to.
    asleep: AtomicUsize,
    over: AtomicBool,
    door: Mutex<()>,
    bell: Condvar,
}

thread_local! {
    /// The pool of this thread, kept as long as the thread lives: a thread can be a member of one pool only.
    static OWN: RefCell<Option<Arc<WorkerPool>>> = const { RefCell::new(None) };
}

impl WorkerPool {
    /// A pool of `threads` whose first is the current one; `None` if the current thread is a member of another pool.
    pub fn here(threads: usize) -> Option<Arc<Self>> {
        OWN.with_borrow_mut(|own| {
            if own.is_none() && rayon::current_thread_index().is_none() {
                *own =
                    Self::new(ThreadPoolBuilder::new().num_threads(threads).use_current_thread(), true).map(Arc::new);
            }
            own.as_ref().filter(|pool| pool.workers.current_num_threads() == threads).cloned()
        })
    }

    /// A pool of `threads` besides the current one; `None` if the system refuses to create them.
    pub fn apart(threads: usize) -> Option<Self> {
        Self::new(ThreadPoolBuilder::new().num_threads(threads), false)
    }

    /// Builds a pool. If `leads`, the current thread is its first member, and does not poll for work.
    fn new(builder: ThreadPoolBuilder, leads: bool) -> Option<Self> {
        let pool = Self { workers: builder.build().ok()?, watch: Arc::default() };
        let watch = Arc::clone(&pool.watch);
        pool.workers.spawn_broadcast(move |thread| {
            if !(leads && thread.index() == 0) {
                watch.poll();
            }
        });
        if leads {
            // Removes the polling job that was queued for this thread.
            pool.workers.install(rayon::yield_now);
        }
        Some(pool)
    }

    /// Runs `work`, whose parts any of the threads may take.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let _call = Call::new(&self.watch);
        // On this thread, if it is a member.
        self.workers.install(work)
    }
}

impl Drop for WorkerPool {
    fn drop(&mut self) {
        self.watch.over.store(true, Ordering::SeqCst);
        self.watch.wake();
    }
}

/// A call under way: keeps workers awake until it is dropped.
struct Call<'a>(&'a Watch);

impl<'a> Call<'a> {
    fn new(watch: &'a Watch) -> Self {
        watch.called.fetch_add(1, Ordering::Relaxed);
        // Sequential consistency: either this call sees a worker that is about to sleep, or the worker sees this call.
        watch.calls.fetch_add(1, Ordering::SeqCst);
        if watch.asleep.load(Ordering::SeqCst) > 0 {
            watch.wake();
        }
        Self(watch)
    }
}

impl Drop for Call<'_> {
    fn drop(&mut self) {
        self.0.calls.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Watch {
    /// Polls for work until the pool is dropped.
    fn poll(&self) {
        let (mut last, mut looked, mut called) = (Instant::now(), 0_u32, 0);
        while !self.over.load(Ordering::Relaxed) {
            looked = looked.wrapping_add(1);
            match rayon::yield_now() {
                Some(Yield::Executed) => last = Instant::now(),
                _ if !looked.is_multiple_of(POLLS_BEFORE_YIELD) => spin_loop(),
                _ => {
                    let before = std::mem::replace(&mut called, self.called.load(Ordering::Relaxed));
                    if called != before {
                        last = Instant::now();
                    } else if last.elapsed() > POLL_TIME {
                        self.rest();
                    }
                    // There may be more threads than processors.
                    std::thread::yield_now();
                }
            }
        }
    }

    /// Sleeps until there is a call; only briefly while one is under way, which may still split off work.
    fn rest(&self) {
        if self.calls.load(Ordering::SeqCst) > 0 {
            return std::thread::sleep(NAP);
        }
        let mut inside = self.door();
        self.asleep.fetch_add(1, Ordering::SeqCst);
        while self.calls.load(Ordering::SeqCst) == 0 && !self.over.load(Ordering::SeqCst) {
            inside = self.bell.wait(inside).unwrap_or_else(PoisonError::into_inner);
        }
        self.asleep.fetch_sub(1, Ordering::SeqCst);
    }

    fn wake(&self) {
        drop(self.door());
        self.bell.notify_all();
    }

    fn door(&self) -> MutexGuard<'_, ()> {
        self.door.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_makes_a_crew_works_in_it_and_others_can_use_it_too() {
        let own = WorkerPool::here(2).unwrap();
        assert!(Arc::ptr_eq(&own, &WorkerPool::here(2).unwrap()));
        assert!(WorkerPool::here(3).is_none(), "a thread is one of a single pool");
        let me = std::thread::current().id();
        let here = || std::thread::current().id();
        assert_eq!(own.run(here), me);
        assert_ne!(WorkerPool::apart(2).unwrap().run(here), me);
        let nested = WorkerPool::apart(2).unwrap();
        assert!(nested.run(|| WorkerPool::here(2).is_none()), "nor is a thread of another one");
        // Both halves wait for each other, so they have two threads.
        let met = std::sync::Barrier::new(2);
        let meet = || {
            met.wait();
            here()
        };
        let (left, right) = own.run(|| rayon::join(meet, meet));
        assert!(left == me && right != me, "{left:?} {right:?}");
    }

    fn until(what: &str, is: impl Fn() -> bool) {
        let begun = Instant::now();
        while !is() {
            assert!(begun.elapsed() < Duration::from_secs(60), "{what}");
            std::thread::yield_now();
        }
    }

    #[test]
    fn threads_without_work_sleep_and_are_woken() {
        for pool in [WorkerPool::here(2).unwrap(), Arc::new(WorkerPool::apart(2).unwrap())] {
            let others =
                pool.workers.current_num_threads() - usize::from(pool.workers.current_thread_index().is_some());
            for _ in 0..20 {
                until("they still look for work", || pool.watch.asleep.load(Ordering::SeqCst) == others);
                let met = std::sync::Barrier::new(2);
                pool.run(|| rayon::join(|| met.wait(), || met.wait()));
            }
        }
    }

    #[test]
    fn threads_end_with_the_one_that_leads_them() {
        for asleep in [0, 1] {
            let lead = move || {
                let pool = WorkerPool::here(2).unwrap();
                assert_eq!(pool.run(|| 7), 7);
                until("it does not sleep", || pool.watch.asleep.load(Ordering::SeqCst) >= asleep);
                Arc::downgrade(&pool.watch)
            };
            let watch = std::thread::spawn(lead).join().unwrap();
            until("a thread without a leader is still there", || watch.strong_count() == 0);
        }
    }

    #[test]
    fn a_thread_that_finds_nothing_for_long_still_takes_what_comes() {
        let pool = WorkerPool::here(2).unwrap();
        let met = std::sync::Barrier::new(2);
        pool.run(|| {
            std::thread::sleep(5 * POLL_TIME);
            rayon::join(|| met.wait(), || met.wait())
        });
    }
}
