//! How long what was made for one matrix serves those after it.
//!
//! A body changes little from step to step, so the coarse levels of a preconditioner are good for a few. They are made anew
//! before that where iterations have grown, or where the matrix has another scale.

/// Of something that was made for a matrix.
#[derive(Debug, Default)]
pub struct Age {
    /// Matrices it may still serve.
    left: u32,
    /// Of the matrix it was made for.
    scale: f64,
    /// Iterations that the first of them took.
    first: Option<usize>,
}

/// Matrices served, at most.
const MOST: u32 = 8;

impl Age {
    /// It is not to serve any longer.
    pub fn end(&mut self) {
        self.left = 0;
    }

    /// Whether it has to be made anew for the next matrix, which is taken for done.
    pub fn is_over(&mut self, scale: f64) -> bool {
        let over = self.left == 0 || self.scale != scale;
        if over {
            *self = Self { left: MOST, scale, first: None };
        }
        self.left -= 1;
        over
    }

    /// Tells what the solve with it took.
    pub fn took(&mut self, iterations: usize) {
        let first = *self.first.get_or_insert(iterations);
        if iterations > first + first / 4 + 2 {
            self.end();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_serves_until_it_is_old_slow_or_of_another_scale() {
        let mut age = Age::default();
        let made = |age: &mut Age, iterations: &[usize]| -> Vec<bool> {
            let serve = |&count: &usize| {
                let over = age.is_over(0.5);
                age.took(count);
                over
            };
            iterations.iter().map(serve).collect()
        };
        let mut want = vec![false; 20];
        (want[0], want[8], want[16]) = (true, true, true);
        assert_eq!(made(&mut age, &[20; 20]), want);
        age.end();
        assert_eq!(made(&mut age, &[20, 21, 27, 28, 20]), [true, false, false, false, true]);
        assert!(age.is_over(1.0) && !age.is_over(1.0));
    }
}
