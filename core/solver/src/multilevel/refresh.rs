//! Schedule for refreshing the coarse levels of a preconditioner.
//!
//! A body changes little from step to step, so coarse levels serve several steps. They are refreshed part by part, so that no step takes
//! longer than others, and as a whole when iterations have grown or the matrix has another scale.

/// The state of the schedule.
#[derive(Debug, Default)]
pub struct Refresh {
    /// Whether the levels are usable.
    valid: bool,
    /// Next part to refresh.
    part: usize,
    /// Scale of the matrix the levels were built for.
    scale: f64,
    /// Iterations of the first solve since the round began.
    first: Option<usize>,
}

/// What to refresh for the next matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// Everything.
    All,
    /// One of [`PARTS`].
    Part(usize),
}

/// Number of parts: after so many matrices every part was refreshed.
pub const PARTS: usize = 8;

/// Growth in iterations that is no sign of outdated levels.
const FEW: usize = 8;

impl Refresh {
    /// Declares the levels outdated.
    pub fn end(&mut self) {
        self.valid = false;
    }

    /// What to refresh for the next matrix; counts as done.
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
        if iterations > first + first / 4 + FEW {
            self.end();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_valid_until_it_is_slow_or_of_another_scale_and_is_made_anew_part_by_part() {
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
