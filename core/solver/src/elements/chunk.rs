//! Division of a list of elements into chunks, and colouring of chunks that can run in parallel.
//!
//! Elements that are neighbours in the list are usually neighbours in space. A chunk is a range of the list with its window: the span of node
//! indices that its elements touch. Windows of chunks of one colour do not overlap, so each chunk writes to its own slice of the nodes; colours
//! run one after the other. Chunks and colours depend on the list alone, so results do not depend on the number of threads.

use crate::threads::Pool;
use std::ops::Range;

/// A range of elements and the span of node indices they touch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Indices of the elements.
    pub range: Range<usize>,
    /// Node indices from the lowest to the highest of their corners.
    pub window: Range<usize>,
}

/// Chunks by colour, those of a colour in the order of their windows.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    colours: Vec<Vec<Chunk>>,
}

/// Fewest elements of a chunk.
const MIN_CHUNK: usize = 512;
/// Approximate number of chunks of a long list: enough for all threads, but few, as each colour traverses all nodes again.
const CHUNKS: usize = 16;
/// The number of chunks is a multiple of this, so that two threads share two colours evenly.
const EVEN: usize = 4;

/// Number of chunks for a list of `count` elements.
pub fn chunk_count(count: usize) -> usize {
    let chunks = count.div_ceil((count / CHUNKS).max(MIN_CHUNK));
    if chunks > EVEN / 2 { chunks.next_multiple_of(EVEN) } else { chunks }
}

/// The span of node indices of a range of elements; `nodes` are those of all elements (m x corners).
pub fn window(nodes: &[u32], corners: usize, range: &Range<usize>) -> Range<usize> {
    let nodes = &nodes[range.start * corners..range.end * corners];
    let low = nodes.iter().min().map_or(0, |low| *low as usize);
    low..nodes.iter().max().map_or(0, |high| *high as usize + 1)
}

/// Range k of `parts` ranges of nearly equal length that cover `0..count`.
pub fn part(count: usize, parts: usize, k: usize) -> Range<usize> {
    k * count / parts..(k + 1) * count / parts
}

impl Schedule {
    /// Divides elements into chunks and colours them. `each` of them follow each other at the same nodes (stencils x nodes of a stencil), and stay
    /// together. Reuses the buffers of the last call.
    pub fn cut(&mut self, nodes: &[u32], stencil: usize, each: usize) {
        let count = nodes.len() / stencil;
        let parts = chunk_count(count * each);
        let ranges = (0..parts).map(|k| part(count, parts, k));
        self.assign(ranges.map(|range| {
            let elements = range.start * each..range.end * each;
            Chunk { window: window(nodes, stencil, &range), range: elements }
        }));
    }

    /// Colours the given chunks. Reuses the buffers of the last call.
    pub fn assign(&mut self, chunks: impl Iterator<Item = Chunk>) {
        self.colours.iter_mut().for_each(Vec::clear);
        chunks.for_each(|chunk| self.colour(chunk));
        for colour in &mut self.colours {
            colour.sort_by_key(|c| c.window.start);
        }
    }

    /// Number of colours.
    pub fn colours(&self) -> usize {
        self.colours.iter().filter(|colour| !colour.is_empty()).count()
    }

    /// Adds a chunk to the first colour whose chunks it does not overlap.
    fn colour(&mut self, chunk: Chunk) {
        let is_apart = |c: &Chunk| c.window.end <= chunk.window.start || chunk.window.end <= c.window.start;
        match self.colours.iter_mut().find(|colour| colour.iter().all(is_apart)) {
            Some(colour) => colour.push(chunk),
            None => self.colours.push(vec![chunk]),
        }
    }

    /// Every chunk, in the order in which one thread runs them.
    pub fn chunks(&self) -> impl Iterator<Item = &Chunk> {
        self.colours.iter().flatten()
    }

    /// Runs `work` on every chunk with the items of `out` of its window. `first_item(node)` is the index of the first item of a node.
    ///
    /// # Errors
    /// The first error in the order of chunks; later chunks of the same colour may have run.
    pub fn run<T: Send, E: Send>(
        &self,
        pool: &Pool,
        out: &mut [T],
        first_item: &(impl Fn(usize) -> usize + Sync),
        work: &(impl Fn(&Chunk, &mut [T]) -> Result<(), E> + Sync),
    ) -> Result<(), E> {
        let run = ColourRun { pool, first_item, work };
        self.colours.iter().try_for_each(|colour| run.run(pool.halvings(), colour, 0, out))
    }
}

/// Work on chunks of one colour.
struct ColourRun<'a, F, W> {
    pool: &'a Pool,
    /// Index of the first item of a node.
    first_item: &'a F,
    /// Work on a chunk with its items.
    work: &'a W,
}

impl<F: Fn(usize) -> usize + Sync, W: Sync> ColourRun<'_, F, W> {
    /// Runs chunks, divided into halves between threads `halvings` times. `out` begins with item `first`.
    fn run<T: Send, E: Send>(&self, halvings: u32, chunks: &[Chunk], first: usize, out: &mut [T]) -> Result<(), E>
    where
        W: Fn(&Chunk, &mut [T]) -> Result<(), E>,
    {
        let Self { pool, first_item, work } = self;
        if halvings == 0 || chunks.len() < 2 {
            return chunks.iter().try_for_each(|chunk| {
                work(chunk, &mut out[first_item(chunk.window.start) - first..first_item(chunk.window.end) - first])
            });
        }
        let (left, right) = chunks.split_at(chunks.len() / 2);
        let middle = first_item(right[0].window.start);
        let (low, high) = out.split_at_mut(middle - first);
        let halvings = halvings - 1;
        let (a, b) = pool.join(|| self.run(halvings, left, first, low), || self.run(halvings, right, middle, high));
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
        schedule.cut(&nodes, 2, 1);
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
        schedule.cut(&nodes, 2, 1);
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
