//! Threads for a step. What they compute never depends on how many there are.

use std::ops::Range;

/// A fixed number of threads; one means the caller's own.
pub struct Pool {
    threads: usize,
    workers: Option<rayon::ThreadPool>,
}

/// Items in a block of a sum: fixed, so that sums have one order.
const SUM_BLOCK: usize = 1024;

impl Pool {
    /// A pool of `threads`, at least one. Falls back to the caller's thread where the system gives no more.
    pub fn new(threads: usize) -> Self {
        let build = || rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok();
        let workers = if threads > 1 { build() } else { None };
        Self { threads: if workers.is_some() { threads } else { 1 }, workers }
    }

    /// Threads that work.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Runs `work` on the pool, so that [`Pool::join`] inside it does not have to wake anyone from outside.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.workers {
            Some(workers) => workers.install(work),
            None => work(),
        }
    }

    /// Both, at once if there are threads.
    pub fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        if self.threads > 1 { rayon::join(a, b) } else { (a(), b()) }
    }

    /// Splits `out` into pieces of at least `least` items and runs `work` on each with the place of its first item.
    pub fn pieces<T: Send>(&self, out: &mut [T], least: usize, work: &(impl Fn(usize, &mut [T]) + Sync)) {
        self.piece(0, out, least.max(1), work);
    }

    fn piece<T: Send>(&self, first: usize, out: &mut [T], least: usize, work: &(impl Fn(usize, &mut [T]) + Sync)) {
        if self.threads == 1 || out.len() < 2 * least {
            return work(first, out);
        }
        let half = out.len() / 2;
        let (left, right) = out.split_at_mut(half);
        self.join(|| self.piece(first, left, least, work), || self.piece(first + half, right, least, work));
    }

    /// The sum of `term` over blocks of `0..count`, always added in the same tree.
    pub fn sum(&self, count: usize, term: &(impl Fn(Range<usize>) -> f64 + Sync)) -> f64 {
        self.sum_blocks(0, count.div_ceil(SUM_BLOCK), count, term)
    }

    fn sum_blocks(&self, begin: usize, end: usize, count: usize, term: &(impl Fn(Range<usize>) -> f64 + Sync)) -> f64 {
        match end - begin {
            0 => 0.0,
            1 => term(begin * SUM_BLOCK..count.min(end * SUM_BLOCK)),
            blocks => {
                let middle = begin + blocks / 2;
                let left = || self.sum_blocks(begin, middle, count, term);
                let right = || self.sum_blocks(middle, end, count, term);
                let (left, right) = if blocks > 8 { self.join(left, right) } else { (left(), right()) };
                left + right
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bytes_for_any_number_of_threads() {
        let terms: Vec<f64> = (0..100_003).map(|i| (i as f64).sin() * 1e3_f64.powi(i % 7)).collect();
        let sum = |threads| Pool::new(threads).sum(terms.len(), &|range| terms[range].iter().sum());
        let one = sum(1);
        assert_eq!(one.to_bits(), sum(2).to_bits());
        assert_eq!(one.to_bits(), sum(4).to_bits());
        assert_ne!(one.to_bits(), terms.iter().sum::<f64>().to_bits(), "the order matters for these terms");
    }

    #[test]
    fn pieces_cover_everything_once() {
        for threads in [1, 3] {
            let mut out = vec![0_usize; 10_000];
            Pool::new(threads).pieces(&mut out, 64, &|first, piece| {
                for (i, o) in piece.iter_mut().enumerate() {
                    *o += first + i;
                }
            });
            assert!(out.iter().enumerate().all(|(i, &o)| i == o));
        }
    }
}
