//! Initial guesses, extrapolated from the last solutions.
//!
//! First-order extrapolation is linear in the last two solutions, second-order extrapolation quadratic in the last three. For smooth motion
//! the second order leaves a smaller residual; under stick-slip solutions jump, and it doubles the jumps. No norm of the residual predicts
//! which order needs fewer iterations, so every 16th solve tries the other order, which is kept if it saves iterations.

use crate::algebra::Vec3;
use crate::threads::{NODES, Pool};

/// Extrapolation of one body's solutions.
#[derive(Debug, Default)]
pub struct InitialGuess {
    /// The solution before the last one (n x 3); single precision suffices for a guess.
    before: Vec<[f32; 3]>,
    /// Difference of `before` from the solution before it (n x 3).
    step: Vec<[f32; 3]>,
    choice: Choice,
}

/// The solution, the one before it and their last difference, number by number.
type Numbers<'a> = (&'a mut [f64], (&'a mut [f32], &'a mut [f32]));

impl InitialGuess {
    /// Sets the number of nodes and all previous solutions to zero.
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

    /// Replaces the last solution `x` (n x 3) by a guess of the next one.
    pub fn extrapolate(&mut self, pool: &Pool, x: &mut [Vec3]) {
        let second = self.choice.next();
        let [before, last] = [&mut self.before, &mut self.step].map(|field| field.as_flattened_mut());
        pool.par_chunks((bytemuck::cast_slice_mut(x), (before, last)), 3 * NODES, &|_,
                                                                                    (x, (before, last)): Numbers<
            '_,
        >| {
            for ((x, before), last) in x.iter_mut().zip(before).zip(last) {
                let step = *x - f64::from(*before);
                let curvature = if second { step - f64::from(*last) } else { 0.0 };
                (*before, *last) = (single(*x), single(step));
                *x += step + curvature;
            }
        });
    }

    /// Records the number of iterations of the solve from the last guess.
    pub fn record_iterations(&mut self, iterations: usize) {
        self.choice.record(iterations as f64);
    }

    /// Memory of the previous solutions, bytes.
    pub fn bytes(&self) -> usize {
        2 * self.before.len() * size_of::<[f32; 3]>()
    }
}

/// Rounds to single precision and flushes denormals, whose arithmetic is about a hundred times slower.
#[inline(always)]
fn single(value: f64) -> f32 {
    if value.abs() < f64::from(f32::MIN_POSITIVE) { 0.0 } else { value as f32 }
}

/// The choice of the order of extrapolation.
#[derive(Debug, Default)]
struct Choice {
    /// Whether the second order is the preferred one.
    second: bool,
    /// Guesses since the last trial of the other order.
    since_trial: u32,
    /// Moving average of the iterations with the preferred order; 0 before the first.
    iterations: f64,
    /// Moving average of the iterations that the other order saves.
    gain: f64,
}

/// Number of guesses from one trial of the other order to the next.
const TRIAL_INTERVAL: u32 = 16;
/// Smallest fraction of the iterations that the other order must save to become the preferred one.
const MIN_GAIN: f64 = 0.05;
/// Weight of the newest value in a moving average.
const AVERAGE_WEIGHT: f64 = 0.25;

impl Choice {
    /// Returns whether the next guess is of second order.
    fn next(&mut self) -> bool {
        self.since_trial = (self.since_trial + 1) % TRIAL_INTERVAL;
        self.second != self.is_trial()
    }

    /// Whether the last guess was a trial of the other order.
    fn is_trial(&self) -> bool {
        self.since_trial == 0
    }

    /// Records the iterations of the last guess and changes the preferred order if the other one saves enough.
    fn record(&mut self, iterations: f64) {
        if !self.is_trial() {
            let weight = if self.iterations > 0.0 { AVERAGE_WEIGHT } else { 1.0 };
            self.iterations += weight * (iterations - self.iterations);
            return;
        }
        self.gain += AVERAGE_WEIGHT * (self.iterations - iterations - self.gain);
        if self.gain > MIN_GAIN * self.iterations {
            (self.second, self.iterations, self.gain) = (!self.second, self.iterations - self.gain, -self.gain);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error of the guess after `steps` solutions given by the function `of`, and whether the second order is preferred then.
    fn guess_error(of: impl Fn(f64) -> f64, iterations: impl Fn(f64) -> usize, steps: usize) -> (f64, bool) {
        let (pool, mut guess, mut x) = (Pool::new(1), InitialGuess::default(), vec![Vec3::zeros(); 5]);
        guess.resize(5);
        let mut error = 0.0;
        for step in 0..steps {
            guess.extrapolate(&pool, &mut x);
            let expected = of(step as f64);
            error = (x[3][1] - expected).abs();
            guess.record_iterations(iterations(error));
            x.fill(Vec3::repeat(expected));
        }
        (error, guess.choice.second)
    }

    #[test]
    fn smooth_solutions_prefer_the_second_order_and_jumps_the_first() {
        let (count, many) = (|error: f64| (error * 1e6) as usize, 40 * TRIAL_INTERVAL as usize - 1);
        let parabola = |t: f64| 1e-5 * t * t;
        let (error, second) = guess_error(parabola, count, many);
        assert!(second && error < 2e-6, "the second order leaves nothing of a parabola: {error}");
        let jumps = |t: f64| if (t as u64).is_multiple_of(2) { 1.0 } else { -1.0 };
        assert!(!guess_error(jumps, count, many).1);
        let (first, trial) =
            (guess_error(parabola, |_| 10, 10).0, guess_error(parabola, |_| 10, TRIAL_INTERVAL as usize).0);
        assert!((first - 2e-5).abs() < 1e-6 && trial < 1e-6, "{first} {trial}");
    }
}
