//! Cutting a list of elements into ranges that can run at once.
//!
//! Elements come in an order in which neighbours in the list are neighbours in space. A chunk is a range of the list and the
//! span of nodes its elements touch. Chunks of one colour have spans that do not overlap, so each may write to its own
//! slice of the nodes; colours run one after the other. The cut depends on the list alone, so results do not depend on the
//! number of threads.

use super::pool::Pool;
use crate::host::Planes;
use std::ops::Range;

/// A range of elements and the nodes they touch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Elements.
    pub range: Range<usize>,
    /// Nodes.
    pub window: Range<usize>,
}

/// Chunks by colour, in order of their nodes.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    colours: Vec<Vec<Chunk>>,
}

/// Elements in a chunk: the more the better for memory, but a few chunks for each thread.
const CHUNK: std::ops::RangeInclusive<usize> = 512..=2048;
/// Chunks of a short list.
const CHUNKS: usize = 16;

impl Schedule {
    /// Cuts elements of `corners` nodes each. Keeps the buffers of an earlier cut.
    pub fn cut(&mut self, nodes: &[u32], corners: usize) {
        self.colours.iter_mut().for_each(Vec::clear);
        let count = nodes.len() / corners;
        let size = (count / CHUNKS).clamp(*CHUNK.start(), *CHUNK.end());
        for begin in (0..count).step_by(size) {
            let range = begin..count.min(begin + size);
            let (mut low, mut high) = (usize::MAX, 0);
            for &node in &nodes[range.start * corners..range.end * corners] {
                low = low.min(node as usize);
                high = high.max(node as usize + 1);
            }
            self.place(Chunk { range, window: low..high });
        }
        for colour in &mut self.colours {
            colour.sort_by_key(|c| c.window.start);
        }
    }

    /// Puts a chunk into the first colour it fits.
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
        self.colours.iter().try_for_each(|colour| colour_run((pool, pool.halvings()), colour, 0, out, bound, work))
    }

    /// Runs `work` on every chunk with the planes of its elements.
    ///
    /// # Errors
    /// The first error in chunk order; other chunks may have run.
    pub fn run_planes<E: Send>(
        &self,
        pool: &Pool,
        mut planes: Planes<'_>,
        work: &(impl Fn(&Chunk, &mut Planes<'_>) -> Result<(), E> + Sync),
    ) -> Result<(), E> {
        self.colours.iter().try_for_each(|colour| {
            if colour.is_sorted_by_key(|chunk| chunk.range.start) {
                return colour_planes((pool, pool.halvings()), colour, planes.again(), work);
            }
            colour.iter().try_for_each(|chunk| work(chunk, &mut planes))
        })
    }
}

fn colour_planes<E: Send>(
    (pool, halvings): (&Pool, u32),
    chunks: &[Chunk],
    mut planes: Planes<'_>,
    work: &(impl Fn(&Chunk, &mut Planes<'_>) -> Result<(), E> + Sync),
) -> Result<(), E> {
    if halvings == 0 || chunks.len() < 2 {
        return chunks.iter().try_for_each(|chunk| work(chunk, &mut planes));
    }
    let (left, right) = chunks.split_at(chunks.len() / 2);
    let (low, high) = planes.part(right[0].range.start);
    let less = (pool, halvings - 1);
    let (a, b) = pool.join(|| colour_planes(less, left, low, work), || colour_planes(less, right, high, work));
    a.and(b)
}

/// `out` starts at item `first`.
fn colour_run<T: Send, E: Send>(
    (pool, halvings): (&Pool, u32),
    chunks: &[Chunk],
    first: usize,
    out: &mut [T],
    bound: &(impl Fn(usize) -> usize + Sync),
    work: &(impl Fn(&Chunk, &mut [T]) -> Result<(), E> + Sync),
) -> Result<(), E> {
    if halvings == 0 || chunks.len() < 2 {
        return chunks.iter().try_for_each(|chunk| {
            work(chunk, &mut out[bound(chunk.window.start) - first..bound(chunk.window.end) - first])
        });
    }
    let (left, right) = chunks.split_at(chunks.len() / 2);
    let middle = bound(right[0].window.start);
    let (low, high) = out.split_at_mut(middle - first);
    let less = (pool, halvings - 1);
    let (a, b) = pool.join(
        || colour_run(less, left, first, low, bound, work),
        || colour_run(less, right, middle, high, bound, work),
    );
    a.and(b)
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
