//! Cutting a list of elements into ranges that can run at once.
//!
//! Elements come in an order in which neighbours in the list are neighbours in space. A chunk is a range of the list and the
//! span of nodes its elements touch. Chunks of one colour have spans that do not overlap, so each may write to its own
//! slice of the nodes; colours run one after the other. The cut depends on the list alone, so results do not depend on the
//! number of threads.

use crate::threads::Pool;
use std::ops::Range;

/// A range of elements and the span of nodes they touch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Indices of the elements.
    pub range: Range<usize>,
    /// Indices from the first to the last node they touch.
    pub window: Range<usize>,
}

/// Chunks by colour, each colour in the order of its nodes.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    colours: Vec<Vec<Chunk>>,
}

/// Fewest elements of a chunk.
const MIN_CHUNK: usize = 512;
/// About how many chunks a list has: some for each thread, but few, for each colour traverses all nodes anew.
const CHUNKS: usize = 16;
/// With a multiple of so many chunks two threads share both colours evenly.
const EVEN: usize = 4;

/// Number of chunks for a list of `count` elements.
pub fn chunks(count: usize) -> usize {
    let chunks = count.div_ceil((count / CHUNKS).max(MIN_CHUNK));
    if chunks > EVEN / 2 { chunks.next_multiple_of(EVEN) } else { chunks }
}

/// The span of nodes that a range of elements of `corners` nodes each touches.
pub fn window(nodes: &[u32], corners: usize, range: &Range<usize>) -> Range<usize> {
    let nodes = &nodes[range.start * corners..range.end * corners];
    let low = nodes.iter().min().map_or(0, |low| *low as usize);
    low..nodes.iter().max().map_or(0, |high| *high as usize + 1)
}

/// Range k of `pieces` ranges of nearly equal length that cover `0..count`.
pub fn part(count: usize, pieces: usize, k: usize) -> Range<usize> {
    k * count / pieces..(k + 1) * count / pieces
}

impl Schedule {
    /// Cuts elements of `corners` nodes each. Keeps the buffers of an earlier cut.
    pub fn cut(&mut self, nodes: &[u32], corners: usize) {
        let count = nodes.len() / corners;
        let pieces = chunks(count);
        let ranges = (0..pieces).map(|k| part(count, pieces, k));
        self.assign(ranges.map(|range| Chunk { window: window(nodes, corners, &range), range }));
    }

    /// Colours the given chunks. Keeps the buffers of an earlier schedule.
    pub fn assign(&mut self, chunks: impl Iterator<Item = Chunk>) {
        self.colours.iter_mut().for_each(Vec::clear);
        chunks.for_each(|chunk| self.place(chunk));
        for colour in &mut self.colours {
            colour.sort_by_key(|c| c.window.start);
        }
    }

    /// Number of colours.
    pub fn colours(&self) -> usize {
        self.colours.iter().filter(|colour| !colour.is_empty()).count()
    }

    /// Adds a chunk to the first colour whose chunks it does not overlap.
    fn place(&mut self, chunk: Chunk) {
        let apart = |c: &Chunk| c.window.end <= chunk.window.start || chunk.window.end <= c.window.start;
        match self.colours.iter_mut().find(|colour| colour.iter().all(apart)) {
            Some(colour) => colour.push(chunk),
            None => self.colours.push(vec![chunk]),
        }
    }

    /// Every chunk, in the order it runs on one thread.
    pub fn chunks(&self) -> impl Iterator<Item = &Chunk> {
        self.colours.iter().flatten()
    }

    /// Runs `work` on every chunk with its slice of `out`. `bound(node)` is the first item of `out` that belongs to `node`.
    ///
    /// # Errors
    /// The first error in chunk order; other chunks may have run.
    pub fn run<T: Send, E: Send>(
        &self,
        pool: &Pool,
        out: &mut [T],
        bound: &(impl Fn(usize) -> usize + Sync),
        work: &(impl Fn(&Chunk, &mut [T]) -> Result<(), E> + Sync),
    ) -> Result<(), E> {
        self.colours.iter().try_for_each(|colour| ColourRun { pool, bound, work }.run(pool.halvings(), colour, 0, out))
    }
}

/// The work of one schedule on one colour.
struct ColourRun<'a, B, W> {
    pool: &'a Pool,
    /// First item of a node.
    bound: &'a B,
    work: &'a W,
}

impl<B: Fn(usize) -> usize + Sync, W: Sync> ColourRun<'_, B, W> {
    /// Runs chunks of one colour, halved `halvings` times between threads. `out` starts at item `first`.
    fn run<T: Send, E: Send>(&self, halvings: u32, chunks: &[Chunk], first: usize, out: &mut [T]) -> Result<(), E>
    where
        W: Fn(&Chunk, &mut [T]) -> Result<(), E>,
    {
        let Self { pool, bound, work } = self;
        if halvings == 0 || chunks.len() < 2 {
            return chunks.iter().try_for_each(|chunk| {
                work(chunk, &mut out[bound(chunk.window.start) - first..bound(chunk.window.end) - first])
            });
        }
        let (left, right) = chunks.split_at(chunks.len() / 2);
        let middle = bound(right[0].window.start);
        let (low, high) = out.split_at_mut(middle - first);
        let less = halvings - 1;
        let (a, b) = pool.join(|| self.run(less, left, first, low), || self.run(less, right, middle, high));
        a.and(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_of_a_colour_share_no_node_and_cover_all_elements() {
        let nodes: Vec<u32> = (0..50_000_u32).flat_map(|e| [e / 7, e / 7 + 40]).collect();
        let mut schedule = Schedule::default();
        schedule.cut(&nodes, 2);
        assert!(schedule.colours.len() > 1 && schedule.colours.len() < 5, "{}", schedule.colours.len());
        for colour in &schedule.colours {
            assert!(colour.windows(2).all(|w| w[0].window.end <= w[1].window.start));
        }
        let mut seen = vec![0; 50_000];
        schedule.chunks().for_each(|c| c.range.clone().for_each(|e| seen[e] += 1));
        assert!(seen.iter().all(|&s| s == 1));
    }

    #[test]
    fn every_chunk_gets_its_own_slice() {
        let nodes: Vec<u32> = (0..30_000_u32).flat_map(|e| [e / 5, e / 5 + 3]).collect();
        let mut schedule = Schedule::default();
        schedule.cut(&nodes, 2);
        for threads in [1, 4] {
            let mut out = vec![0_u32; 3 * 6003];
            let done: Result<(), ()> =
                schedule.run(&Pool::new(threads), &mut out, &|node| 3 * node, &|chunk, slice| {
                    for e in chunk.range.clone() {
                        slice[3 * (nodes[2 * e] as usize - chunk.window.start)] += 1;
                    }
                    Ok(())
                });
            assert!(done.is_ok() && out.iter().sum::<u32>() == 30_000 && out[3 * 5] == 5);
        }
    }
}
