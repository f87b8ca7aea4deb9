//! Threads that stay awake from one step to the next.
//!
//! Waking a thread takes as long as a small step. So whoever steps works along, where it can, and waits for no other to begin with
//! or to be woken by at the end; and the others look for more for a while before they sleep.

use rayon::{ThreadPool, ThreadPoolBuilder, Yield};
use std::cell::{Cell, RefCell};
use std::hint::spin_loop;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How long a thread without work looks for more before it sleeps: the period of a haptic loop.
const ATTENTIVE: Duration = Duration::from_millis(1);
/// Looks after which it lets others have its processor.
const POLITE: u32 = 64;

/// Threads that work together.
pub struct Crew {
    workers: ThreadPool,
    /// Whether the thread that made it is the first of them, and looks for no work.
    leads: bool,
    watch: Arc<Watch>,
}

/// What keeps threads awake.
#[derive(Default)]
struct Watch {
    /// Threads that look for work, or were told to.
    awake: AtomicUsize,
    /// Times there was work.
    calls: AtomicUsize,
}

thread_local! {
    /// Kept as long as the thread lives, for a thread can be one of a single crew.
    static OWN: RefCell<Option<Arc<Crew>>> = const { RefCell::new(None) };
    /// Whether this thread is at work, or looks for some.
    static BUSY: Cell<bool> = const { Cell::new(false) };
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

    fn new(builder: ThreadPoolBuilder, leads: bool) -> Option<Self> {
        Some(Self { workers: builder.build().ok()?, leads, watch: Arc::default() })
    }

    /// Does `work`, whose parts any of the threads may take.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.call();
        // Where this thread is one of them, here.
        self.workers.install(|| {
            let _busy = Busy::new();
            work()
        })
    }

    /// Tells the threads that there is work, and those that sleep to look for it.
    fn call(&self) {
        self.watch.calls.fetch_add(1, Ordering::Relaxed);
        let leads = self.leads;
        let others = self.workers.current_num_threads() - usize::from(leads);
        if self.watch.awake.compare_exchange(0, others, Ordering::AcqRel, Ordering::Relaxed).is_err() {
            return;
        }
        let watch = Arc::clone(&self.watch);
        self.workers.spawn_broadcast(move |thread| {
            if !(leads && thread.index() == 0) {
                watch.attend();
                watch.awake.fetch_sub(1, Ordering::AcqRel);
            }
        });
    }
}

impl Watch {
    /// Does what others leave to be done. A thread that works already, and only waits for another, is not held up.
    fn attend(&self) {
        if BUSY.get() {
            return;
        }
        let _busy = Busy::new();
        let (mut last, mut looked, mut calls) = (Instant::now(), 0_u32, 0);
        loop {
            looked += 1;
            match rayon::yield_now() {
                Some(Yield::Executed) => last = Instant::now(),
                _ if !looked.is_multiple_of(POLITE) => spin_loop(),
                _ => {
                    let before = std::mem::replace(&mut calls, self.calls.load(Ordering::Relaxed));
                    if calls != before {
                        last = Instant::now();
                    } else if last.elapsed() > ATTENTIVE {
                        break;
                    }
                    // There may be more threads than processors.
                    std::thread::yield_now();
                }
            }
        }
    }
}

/// Marks a thread as one that does not attend elsewhere.
struct Busy(bool);

impl Busy {
    fn new() -> Self {
        Self(BUSY.replace(true))
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        BUSY.set(self.0);
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

    #[test]
    fn threads_without_work_sleep() {
        let crew = Crew::apart(2).unwrap();
        crew.run(|| ());
        assert!(crew.watch.awake.load(Ordering::Acquire) > 0);
        let begun = Instant::now();
        while crew.watch.awake.load(Ordering::Acquire) > 0 {
            assert!(begun.elapsed() < Duration::from_secs(60), "they still look for work");
            std::thread::yield_now();
        }
        assert_eq!(crew.run(|| 7), 7);
    }
}
