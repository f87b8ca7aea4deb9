//! Worker pools of a session, and the choice of the one that steps a body.

use super::thread_choice::ThreadChoice;
use pliant_solver::Pool;
use std::time::Instant;

/// Number of elements below which a body is stepped by one thread.
const MAX_SINGLE_THREAD: usize = 1500;
/// Number of elements from which a body is stepped by all threads.
const MIN_ALL_THREADS: usize = 5000;

/// Number of processors that this process may use, at least 1.
pub fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// A pool of all threads and one of a single thread, for small bodies and where more threads are slower.
pub(super) struct Workers {
    /// The pool of all threads of the session.
    pub(super) all: Pool,
    /// Number of threads that was asked for.
    pub(super) asked: usize,
    alone: Pool,
    /// Choice for each body.
    choices: Vec<ThreadChoice>,
}

impl Workers {
    /// Pools of `threads` threads, of the `asked` ones, and of one, for `bodies` bodies.
    pub(super) fn new(asked: usize, threads: usize, bodies: usize) -> Self {
        Self { all: Pool::new(threads), asked, alone: Pool::new(1), choices: vec![ThreadChoice::default(); bodies] }
    }

    /// The pool for work on a body with this number of elements that is not timed.
    pub(super) fn pool(&self, elements: usize) -> &Pool {
        if elements < MAX_SINGLE_THREAD { &self.alone } else { &self.all }
    }

    /// Adapts to another number of bodies.
    pub(super) fn resize(&mut self, bodies: usize) {
        self.choices.resize_with(bodies, ThreadChoice::default);
    }

    /// Runs the step of body number `index` with this number of elements on the threads that suit it.
    pub(super) fn run<R: Send>(&mut self, index: usize, elements: usize, step: impl FnOnce(&Pool) -> R + Send) -> R {
        let choice = &mut self.choices[index];
        let has_choice = (MAX_SINGLE_THREAD..MIN_ALL_THREADS).contains(&elements) && self.all.threads() > 1;
        let is_alone = elements < MAX_SINGLE_THREAD || (has_choice && choice.is_alone());
        let pool = if is_alone { &self.alone } else { &self.all };
        let start = Instant::now();
        let result = pool.install(|| step(pool));
        match has_choice {
            true => choice.took(start.elapsed().as_secs_f64()),
            false => *choice = ThreadChoice::default(),
        }
        result
    }
}
