//! When what was made for one matrix is made anew.
//!
//! A body changes little from step to step, so the coarse levels of a preconditioner are good for a few. Part by part they are made
//! anew, so that no step takes longer than others; all of it where iterations have grown, or where the matrix has another scale.

/// Of something that was made for a matrix.
#[derive(Debug, Default)]
pub struct Refresh {
    /// Whether it serves at all.
    serves: bool,
    /// Next part to be made anew.
    part: usize,
    /// Of the matrix it was made for.
    scale: f64,
    /// Iterations that the first solve took since a round began.
    first: Option<usize>,
}

/// What is to be made anew for the next matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// Everything.
    All,
    /// One of [`PARTS`].
    Part(usize),
}

/// Matrices until all of it was made anew.
pub const PARTS: usize = 8;

/// Iterations that are no sign of age.
const FEW: usize = 8;

impl Refresh {
    /// It is not to serve any longer.
    pub fn end(&mut self) {
        self.serves = false;
    }

    /// What has to be made anew for the next matrix, which is taken for done.
    pub fn due(&mut self, scale: f64) -> Due {
        if !self.serves || self.scale != scale {
            *self = Self { serves: true, part: 0, scale, first: None };
            return Due::All;
        }
        let part = self.part;
        self.part = (part + 1) % PARTS;
        if self.part == 0 {
            self.first = None;
        }
        Due::Part(part)
    }

    /// Tells what the solve with it took.
    pub fn took(&mut self, iterations: usize) {
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
    fn it_serves_until_it_is_slow_or_of_another_scale_and_is_made_anew_part_by_part() {
        let mut refresh = Refresh::default();
        let made = |refresh: &mut Refresh, iterations: &[usize]| -> Vec<Due> {
            let serve = |&count: &usize| {
                let due = refresh.due(0.5);
                refresh.took(count);
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
