//! Threads for a step. What they compute never depends on how many there are.

/// A fixed number of threads; one means the caller's own.
pub struct Pool {
    threads: usize,
    workers: Option<rayon::ThreadPool>,
}

/// Items in a block of a sum: fixed, so that sums have one order.
const SUM_BLOCK: usize = 256;
/// Blocks that are worth another thread.
const PARALLEL_BLOCKS: usize = 4;

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

    /// Runs `work` on blocks of `parts`, each with the place of its first item, and adds up what it gives: always the same
    /// blocks, added in the same tree.
    pub fn fold<P: Parts>(&self, parts: P, work: &(impl Fn(usize, P) -> f64 + Sync)) -> f64 {
        self.fold_blocks(0, parts, work)
    }

    fn fold_blocks<P: Parts>(&self, first: usize, parts: P, work: &(impl Fn(usize, P) -> f64 + Sync)) -> f64 {
        let blocks = parts.count().div_ceil(SUM_BLOCK);
        if blocks <= 1 {
            return if blocks == 0 { 0.0 } else { work(first, parts) };
        }
        let middle = blocks / 2 * SUM_BLOCK;
        let (left, right) = parts.part(middle);
        let (left, right) = (|| self.fold_blocks(first, left, work), || self.fold_blocks(first + middle, right, work));
        let (left, right) = if blocks >= PARALLEL_BLOCKS { self.join(left, right) } else { (left(), right()) };
        left + right
    }
}

/// Slices of one length that are cut at the same place.
pub trait Parts: Send + Sized {
    /// Items there are.
    fn count(&self) -> usize;
    /// The items before a place, and those from it on.
    fn part(self, at: usize) -> (Self, Self);
}

impl<T: Send> Parts for &mut [T] {
    fn count(&self) -> usize {
        self.len()
    }

    fn part(self, at: usize) -> (Self, Self) {
        self.split_at_mut(at)
    }
}

impl<A: Parts, B: Parts> Parts for (A, B) {
    fn count(&self) -> usize {
        self.0.count()
    }

    fn part(self, at: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.part(at), self.1.part(at));
        ((a, b), (c, d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bytes_for_any_number_of_threads() {
        let terms: Vec<f64> = (0..100_003).map(|i| (i as f64).sin() * 1e3_f64.powi(i % 7)).collect();
        let sum = |threads| {
            let mut seen = vec![0.0; terms.len()];
            Pool::new(threads).fold(&mut seen[..], &|first, seen| {
                seen.copy_from_slice(&terms[first..first + seen.len()]);
                seen.iter().sum()
            })
        };
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
