//! Schedule for refreshing the coarse levels of a preconditioner.
//!
//! A body changes little from step to step, so coarse levels are used for several steps. They are refreshed part by part, so that steps take
//! equally long, and as a whole if the iterations have grown or the scale of the matrix has changed.

/// The state of the schedule.
#[derive(Debug, Default)]
pub struct Refresh {
    /// Whether the levels are usable.
    valid: bool,
    /// Next part to refresh.
    part: usize,
    /// Scale of the matrix the levels were built for.
    scale: f64,
    /// Iterations of the first solve after a full refresh.
    first: Option<usize>,
}

/// The parts to refresh for the next matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// All parts of the coarse levels.
    All,
    /// One of [`PARTS`].
    Part(usize),
}

/// Number of parts; after this number of matrices every part has been refreshed.
pub const PARTS: usize = 8;

/// Growth of the iterations that does not cause a full refresh.
const MAX_GROWTH: usize = 8;

impl Refresh {
    /// Marks all levels as outdated.
    pub fn end(&mut self) {
        self.valid = false;
    }

    /// Returns the parts to refresh for the next matrix with this scale, and counts them as refreshed.
    pub fn due(&mut self, scale: f64) -> Due {
        if !self.valid || self.scale != scale {
            *self = Self { valid: true, part: 0, scale, first: None };
            return Due::All;
        }
        let part = self.part;
        self.part = (part + 1) % PARTS;
        if self.part == 0 {
            self.first = None;
        }
        Due::Part(part)
    }

    /// Records the iterations of a solve.
    pub fn record_iterations(&mut self, iterations: usize) {
        let first = *self.first.get_or_insert(iterations);
        if iterations > first + first / 4 + MAX_GROWTH {
            self.end();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_refreshed_in_parts_and_fully_when_slow_or_rescaled() {
        let mut refresh = Refresh::default();
        let made = |refresh: &mut Refresh, iterations: &[usize]| -> Vec<Due> {
            let serve = |&count: &usize| {
                let due = refresh.due(0.5);
                refresh.record_iterations(count);
                due
            };
            iterations.iter().map(serve).collect()
        };
        let rounds: Vec<Due> = (0..19).map(|k| Due::Part(k % PARTS)).collect();
        assert_eq!(made(&mut refresh, &[20; 20]), [&[Due::All], &rounds[..]].concat());
        refresh.end();
        let slow = [Due::All, Due::Part(0), Due::Part(1), Due::Part(2), Due::All];
        assert_eq!(made(&mut refresh, &[20, 21, 33, 34, 20]), slow);
        assert_eq!((refresh.due(1.0), refresh.due(1.0)), (Due::All, Due::Part(0)));
    }
}
