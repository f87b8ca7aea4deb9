//! How many edits run at a time: as many as are asked for, as the processors can run and as fit into memory.

use pliant_engine::memory::MemoryBudget;
use std::time::Duration;

/// Longest time for which the first edit runs alone, until its memory is known.
const UNKNOWN: Duration = Duration::from_secs(10);

/// Number of processors of this process.
pub(super) fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Number of edits that fit into a memory, at least 1. `edit_memory` is that of each edit, bytes.
pub(crate) fn fitting(memory: MemoryBudget, edit_memory: u64) -> usize {
    memory
        .bytes()
        .checked_div(edit_memory)
        .map_or(usize::MAX, |count| usize::try_from(count).unwrap_or(usize::MAX))
        .max(1)
}

/// Lets edits begin while their memory is within the budget. The memory of each is taken as that of the largest edit so far.
#[derive(Debug)]
pub(super) struct Admission {
    /// Memory of all edits at a time; `None` admits any number.
    budget: Option<MemoryBudget>,
    /// Memory of the largest edit so far, or the limit of every edit, bytes; 0 while it is unknown.
    edit_memory: u64,
    /// Fewest edits at a time beyond which one had to wait for memory.
    held_at: Option<usize>,
}

impl Admission {
    /// The admission of edits within `budget`. `limit` is what each edit may take, if it is limited.
    pub(super) fn new(budget: Option<MemoryBudget>, limit: Option<u64>) -> Self {
        Self { budget, edit_memory: limit.unwrap_or(0), held_at: None }
    }

    /// Whether an edit may begin beside `running` ones, of which the first began `elapsed` ago.
    pub(super) fn admits(&mut self, running: usize, elapsed: Duration) -> bool {
        let Some(budget) = self.budget else { return true };
        if running == 0 {
            return true;
        }
        if self.edit_memory == 0 {
            return elapsed > UNKNOWN;
        }
        let fitting = fitting(budget, self.edit_memory);
        if running >= fitting {
            self.held_at = Some(self.held_at.map_or(fitting, |fewest| fewest.min(fitting)));
        }
        running < fitting
    }

    /// Takes the estimated memory of an edit into account, bytes.
    pub(super) fn update(&mut self, estimate: u64) {
        self.edit_memory = self.edit_memory.max(estimate);
    }

    /// Memory of the largest edit so far, bytes; 0 while it is unknown.
    pub(super) fn edit_memory(&self) -> u64 {
        self.edit_memory
    }

    /// Fewest edits at a time beyond which one had to wait for memory; `None` if none had to.
    pub(super) fn held_at(&self) -> Option<usize> {
        self.held_at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many edits begin side by side, at most `asked`.
    fn side_by_side(admission: &mut Admission, asked: usize) -> usize {
        (0..asked).take_while(|running| admission.admits(*running, Duration::ZERO)).count()
    }

    #[test]
    fn edits_begin_while_the_largest_so_far_fits_that_often() {
        let budget = Some(MemoryBudget::new(1000));
        let mut admission = Admission::new(budget, None);
        assert_eq!(side_by_side(&mut admission, 8), 1, "the first shows what an edit takes");
        assert_eq!(admission.held_at(), None, "its wait is none for memory");
        for (estimate, count) in [(100, 8), (300, 3), (200, 3), (501, 1), (5000, 1)] {
            admission.update(estimate);
            assert_eq!(side_by_side(&mut admission, 8), count, "{estimate}");
        }
        assert_eq!((admission.held_at(), admission.edit_memory()), (Some(1), 5000));
        assert_eq!(side_by_side(&mut Admission::new(budget, Some(400)), 8), 2, "a limit is known before the first");
        assert_eq!(side_by_side(&mut Admission::new(None, Some(400)), 8), 8);
    }

    #[test]
    fn a_first_edit_that_does_not_open_holds_no_other_for_long() {
        let mut admission = Admission::new(Some(MemoryBudget::new(1000)), None);
        assert!(!admission.admits(1, UNKNOWN) && admission.admits(1, 2 * UNKNOWN));
    }
}
