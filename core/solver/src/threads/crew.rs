//! Threads that stay awake from one step to the next.
//!
//! Waking a thread takes as long as a small step. So whoever steps works along, where it can, and waits for no other to begin with
//! or to be woken by at the end; and the others look for more for a while before they sleep. What they look in is one job of
//! `rayon`'s for the life of the crew, so that neither sleep nor waking takes memory.

use rayon::{ThreadPool, ThreadPoolBuilder, Yield};
use std::cell::RefCell;
use std::hint::spin_loop;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long a thread without work looks for more before it sleeps: the period of a haptic loop.
const ATTENTIVE: Duration = Duration::from_millis(1);
/// Looks after which it lets others have its processor.
const POLITE: u32 = 64;
/// Between two looks of a thread that has found nothing for long, while others are at work.
const NAP: Duration = Duration::from_micros(100);

/// Threads that work together.
pub struct Crew {
    workers: ThreadPool,
    watch: Arc<Watch>,
}

/// What keeps threads awake.
#[derive(Default)]
struct Watch {
    /// Whoever has work done now.
    calls: AtomicUsize,
    /// Times there was work.
    called: AtomicUsize,
    /// Threads that sleep, or are about to.
    asleep: AtomicUsize,
    over: AtomicBool,
    door: Mutex<()>,
    bell: Condvar,
}

thread_local! {
    /// Kept as long as the thread lives, for a thread can be one of a single crew.
    static OWN: RefCell<Option<Arc<Crew>>> = const { RefCell::new(None) };
}

impl Crew {
    /// `threads` of which the current one is the first; `None` where it is one of another crew already.
    pub fn here(threads: usize) -> Option<Arc<Self>> {
        OWN.with_borrow_mut(|own| {
            if own.is_none() && rayon::current_thread_index().is_none() {
                *own =
                    Self::new(ThreadPoolBuilder::new().num_threads(threads).use_current_thread(), true).map(Arc::new);
            }
            own.as_ref().filter(|crew| crew.workers.current_num_threads() == threads).cloned()
        })
    }

    /// `threads` besides the current one; `None` where the system gives no more.
    pub fn apart(threads: usize) -> Option<Self> {
        Self::new(ThreadPoolBuilder::new().num_threads(threads), false)
    }

    /// `leads`: the current thread is the first of them, and looks for no work.
    fn new(builder: ThreadPoolBuilder, leads: bool) -> Option<Self> {
        let crew = Self { workers: builder.build().ok()?, watch: Arc::default() };
        let watch = Arc::clone(&crew.watch);
        crew.workers.spawn_broadcast(move |thread| {
            if !(leads && thread.index() == 0) {
                watch.attend();
            }
        });
        if leads {
            // Takes the one that is for this thread out of the way.
            crew.workers.install(rayon::yield_now);
        }
        Some(crew)
    }

    /// Does `work`, whose parts any of the threads may take.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let _call = Call::new(&self.watch);
        // Where this thread is one of them, here.
        self.workers.install(work)
    }
}

impl Drop for Crew {
    fn drop(&mut self) {
        self.watch.over.store(true, Ordering::SeqCst);
        self.watch.wake();
    }
}

/// Keeps threads from sleeping.
struct Call<'a>(&'a Watch);

impl<'a> Call<'a> {
    fn new(watch: &'a Watch) -> Self {
        watch.called.fetch_add(1, Ordering::Relaxed);
        // Either this sees that a thread is about to sleep, or that one sees this.
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
    /// Does what others leave to be done, until the crew is no more.
    fn attend(&self) {
        let (mut last, mut looked, mut called) = (Instant::now(), 0_u32, 0);
        while !self.over.load(Ordering::Relaxed) {
            looked = looked.wrapping_add(1);
            match rayon::yield_now() {
                Some(Yield::Executed) => last = Instant::now(),
                _ if !looked.is_multiple_of(POLITE) => spin_loop(),
                _ => {
                    let before = std::mem::replace(&mut called, self.called.load(Ordering::Relaxed));
                    if called != before {
                        last = Instant::now();
                    } else if last.elapsed() > ATTENTIVE {
                        self.rest();
                    }
                    // There may be more threads than processors.
                    std::thread::yield_now();
                }
            }
        }
    }

    /// Sleeps until there is work; for a moment where some is being done, which may come to have parts for others.
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
        let own = Crew::here(2).unwrap();
        assert!(Arc::ptr_eq(&own, &Crew::here(2).unwrap()));
        assert!(Crew::here(3).is_none(), "a thread is one of a single crew");
        let me = std::thread::current().id();
        let here = || std::thread::current().id();
        assert_eq!(own.run(here), me);
        assert_ne!(Crew::apart(2).unwrap().run(here), me);
        let nested = Crew::apart(2).unwrap();
        assert!(nested.run(|| Crew::here(2).is_none()), "nor is a thread of another one");
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
        for crew in [Crew::here(2).unwrap(), Arc::new(Crew::apart(2).unwrap())] {
            let others =
                crew.workers.current_num_threads() - usize::from(crew.workers.current_thread_index().is_some());
            for _ in 0..20 {
                until("they still look for work", || crew.watch.asleep.load(Ordering::SeqCst) == others);
                let met = std::sync::Barrier::new(2);
                crew.run(|| rayon::join(|| met.wait(), || met.wait()));
            }
        }
    }

    #[test]
    fn threads_end_with_the_one_that_leads_them() {
        for asleep in [0, 1] {
            let lead = move || {
                let crew = Crew::here(2).unwrap();
                assert_eq!(crew.run(|| 7), 7);
                until("it does not sleep", || crew.watch.asleep.load(Ordering::SeqCst) >= asleep);
                Arc::downgrade(&crew.watch)
            };
            let watch = std::thread::spawn(lead).join().unwrap();
            until("a thread without a leader is still there", || watch.strong_count() == 0);
        }
    }

    #[test]
    fn a_thread_that_finds_nothing_for_long_still_takes_what_comes() {
        let crew = Crew::here(2).unwrap();
        let met = std::sync::Barrier::new(2);
        crew.run(|| {
            std::thread::sleep(5 * ATTENTIVE);
            rayon::join(|| met.wait(), || met.wait())
        });
    }
}
