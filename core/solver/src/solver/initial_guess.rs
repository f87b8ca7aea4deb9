//! Initial guesses, extrapolated from the last solutions.
//!
//! A guess of first order extrapolates the last two solutions linearly, one of second order the last three quadratically. Where a body
//! moves smoothly the second order leaves a smaller residual; where fabrics stick and slip, solutions jump, and it doubles the jumps. No
//! norm of the residual tells which order takes fewer iterations, so the other order is tried now and then, and kept if it took fewer.

use crate::algebra::Vec3;
use crate::threads::{NODES, Pool};

/// Extrapolation of one body's solutions.
#[derive(Debug, Default)]
pub struct InitialGuess {
    /// The solution before the last one (n x 3); a guess needs no more digits than single precision has.
    before: Vec<[f32; 3]>,
    /// How it differed from the one before it (n x 3).
    step: Vec<[f32; 3]>,
    choice: Choice,
}

/// The solution, the one before it and their last difference, number by number.
type Numbers<'a> = (&'a mut [f64], (&'a mut [f32], &'a mut [f32]));

impl InitialGuess {
    /// Makes room for `n` nodes, with solutions of zero.
    pub fn resize(&mut self, n: usize) {
        for field in [&mut self.before, &mut self.step] {
            field.clear();
            field.resize(n, [0.0; 3]);
        }
        self.choice = Choice::default();
    }

    /// Sets all previous solutions to zero.
    pub fn forget(&mut self) {
        self.resize(self.before.len());
    }

    /// Replaces the last solution with a guess for the next one.
    pub fn extrapolate(&mut self, pool: &Pool, x: &mut [Vec3]) {
        let second = self.choice.next();
        let [before, last] = [&mut self.before, &mut self.step].map(|field| field.as_flattened_mut());
        pool.par_chunks((bytemuck::cast_slice_mut(x), (before, last)), 3 * NODES, &|_,
                                                                                    (x, (before, last)): Numbers<
            '_,
        >| {
            for ((x, before), last) in x.iter_mut().zip(before).zip(last) {
                let step = *x - f64::from(*before);
                let turn = if second { step - f64::from(*last) } else { 0.0 };
                (*before, *last) = (single(*x), single(step));
                *x += step + turn;
            }
        });
    }

    /// Records how many iterations the solve from the last guess took.
    pub fn record_iterations(&mut self, iterations: usize) {
        self.choice.record(iterations as f64);
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        2 * self.before.len() * size_of::<[f32; 3]>()
    }
}

/// Rounds to single precision and flushes denormals, which are a hundred times as slow.
#[inline(always)]
fn single(value: f64) -> f32 {
    if value.abs() < f64::from(f32::MIN_POSITIVE) { 0.0 } else { value as f32 }
}

/// The choice of the order of extrapolation.
#[derive(Debug, Default)]
struct Choice {
    /// Whether the second order is the usual one.
    second: bool,
    /// Guesses since the other order was tried.
    usual: u32,
    /// Moving average of iterations from usual guesses; 0 before the first.
    iterations: f64,
    /// Moving average of the iterations that the other order saves.
    gain: f64,
}

/// Guesses from one trial to the next.
const TRIAL: u32 = 16;
/// Least share of the iterations that the other order has to save to become usual.
const WORTH: f64 = 0.05;
/// Weight of the newest number in a moving average.
const NEWEST: f64 = 0.25;

impl Choice {
    fn next(&mut self) -> bool {
        self.usual = (self.usual + 1) % TRIAL;
        self.second != self.is_trial()
    }

    fn is_trial(&self) -> bool {
        self.usual == 0
    }

    fn record(&mut self, iterations: f64) {
        if !self.is_trial() {
            let share = if self.iterations > 0.0 { NEWEST } else { 1.0 };
            self.iterations += share * (iterations - self.iterations);
            return;
        }
        self.gain += NEWEST * (self.iterations - iterations - self.gain);
        if self.gain > WORTH * self.iterations {
            (self.second, self.iterations, self.gain) = (!self.second, self.iterations - self.gain, -self.gain);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of solutions that go as `of` goes, after `steps`, and whether the second order is usual then.
    fn left(of: impl Fn(f64) -> f64, iterations: impl Fn(f64) -> usize, steps: usize) -> (f64, bool) {
        let (pool, mut guess, mut x) = (Pool::new(1), InitialGuess::default(), vec![Vec3::zeros(); 5]);
        guess.resize(5);
        let mut error = 0.0;
        for step in 0..steps {
            guess.extrapolate(&pool, &mut x);
            let want = of(step as f64);
            error = (x[3][1] - want).abs();
            guess.record_iterations(iterations(error));
            x.fill(Vec3::repeat(want));
        }
        (error, guess.choice.second)
    }

    #[test]
    fn smooth_solutions_are_gone_on_with_by_the_second_order_and_jumps_by_the_first() {
        let (count, many) = (|error: f64| (error * 1e6) as usize, 40 * TRIAL as usize - 1);
        let parabola = |t: f64| 1e-5 * t * t;
        let (error, second) = left(parabola, count, many);
        assert!(second && error < 2e-6, "the second order leaves nothing of a parabola: {error}");
        let jumps = |t: f64| if (t as u64).is_multiple_of(2) { 1.0 } else { -1.0 };
        assert!(!left(jumps, count, many).1);
        let (first, trial) = (left(parabola, |_| 10, 10).0, left(parabola, |_| 10, TRIAL as usize).0);
        assert!((first - 2e-5).abs() < 1e-6 && trial < 1e-6, "{first} {trial}");
    }
}
