//! Limits the number of concurrent runs to those whose estimated memory fits the budget.

use pliant_engine::memory::MemoryBudget;
use std::time::Duration;

/// Time after which further runs may start even if the first has not reported its memory: it reports once its session is open, so a model that
/// takes longer to open than this must not leave the other processors idle.
const FIRST_RUN_TIMEOUT: Duration = Duration::from_secs(10);

/// Number of processors of this process.
pub(super) fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Largest number of concurrent runs that fit into a memory, at least 1. `edit_memory` is the memory per run, bytes.
pub(crate) fn max_concurrent(memory: MemoryBudget, edit_memory: u64) -> usize {
    memory
        .bytes()
        .checked_div(edit_memory)
        .map_or(usize::MAX, |count| usize::try_from(count).unwrap_or(usize::MAX))
        .max(1)
}

/// Admits runs while their memory is within the budget. Each is assumed to need the limit or the largest estimate so far.
#[derive(Debug)]
pub(super) struct Admission {
    /// Total memory that concurrent runs may use; `None` admits any number.
    budget: Option<MemoryBudget>,
    /// Memory assumed per run: the limit or the largest estimate so far, bytes; 0 while unknown.
    edit_memory: u64,
    /// Smallest limit at which a run waited for memory.
    memory_limited_at: Option<usize>,
}

impl Admission {
    /// The admission of runs within `budget`. `limit` is the memory limit per run, bytes.
    pub(super) fn new(budget: Option<MemoryBudget>, limit: Option<u64>) -> Self {
        Self { budget, edit_memory: limit.unwrap_or(0), memory_limited_at: None }
    }

    /// Whether another run may start while `running` are active; `elapsed` is the age of the oldest. A refusal for lack of memory is recorded.
    pub(super) fn try_admit(&mut self, running: usize, elapsed: Duration) -> bool {
        let Some(budget) = self.budget else { return true };
        if running == 0 {
            return true;
        }
        if self.edit_memory == 0 {
            return elapsed > FIRST_RUN_TIMEOUT;
        }
        let limit = max_concurrent(budget, self.edit_memory);
        if running >= limit {
            self.memory_limited_at = Some(self.memory_limited_at.map_or(limit, |least| least.min(limit)));
        }
        running < limit
    }

    /// Raises the assumed memory per run to `estimate`, bytes; a smaller estimate changes nothing.
    pub(super) fn update(&mut self, estimate: u64) {
        self.edit_memory = self.edit_memory.max(estimate);
    }

    /// Memory assumed per run: the limit or the largest estimate so far, bytes; 0 while unknown.
    pub(super) fn edit_memory(&self) -> u64 {
        self.edit_memory
    }

    /// Smallest limit at which a run waited for memory; `None` if none did.
    pub(super) fn memory_limited_at(&self) -> Option<usize> {
        self.memory_limited_at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of runs that are admitted at once, at most `asked`.
    fn admitted(admission: &mut Admission, asked: usize) -> usize {
        (0..asked).take_while(|running| admission.try_admit(*running, Duration::ZERO)).count()
    }

    #[test]
    fn concurrency_follows_the_largest_estimate() {
        let budget = Some(MemoryBudget::new(1000));
        let mut admission = Admission::new(budget, None);
        assert_eq!(admitted(&mut admission, 8), 1, "the first run reports its memory");
        assert_eq!(admission.memory_limited_at(), None, "waiting for the first estimate is not counted");
        for (estimate, count) in [(100, 8), (300, 3), (200, 3), (501, 1), (5000, 1)] {
            admission.update(estimate);
            assert_eq!(admitted(&mut admission, 8), count, "{estimate}");
        }
        assert_eq!((admission.memory_limited_at(), admission.edit_memory()), (Some(1), 5000));
        assert_eq!(admitted(&mut Admission::new(budget, Some(400)), 8), 2, "a limit is known before the first run");
        assert_eq!(admitted(&mut Admission::new(None, Some(400)), 8), 8);
    }

    #[test]
    fn a_slow_first_run_delays_the_others_only_until_the_timeout() {
        let mut admission = Admission::new(Some(MemoryBudget::new(1000)), None);
        assert!(!admission.try_admit(1, FIRST_RUN_TIMEOUT) && admission.try_admit(1, 2 * FIRST_RUN_TIMEOUT));
    }
}
