//! Assembly of all element kinds in one pass over the body.
//!
//! A strip has the elements of every kind in one part of the body. Blocks are set to zero right before the first kind of a strip adds to them,
//! and are still in the cache when the next kind does.

use super::ElementSet;
use super::chunk::{Chunk, Schedule, chunk_count, part};
use crate::threads::Pool;
use std::ops::Range;

/// The order in which the elements of a body are assembled.
#[derive(Debug, Default)]
pub struct FusedAssembly {
    /// Passes over the body, one after the other.
    passes: Vec<Pass>,
    /// Nodes outside the windows of the first pass.
    uncovered: Vec<Range<usize>>,
}

/// Element sets whose lists traverse the body in a similar order, assembled together.
#[derive(Debug, Default)]
struct Pass {
    /// Colours of the strips: the range of a chunk is the index of its strip.
    schedule: Schedule,
    /// The parts of the body.
    strips: Vec<Strip>,
}

/// Elements of all sets of a pass in one part of the body.
#[derive(Debug)]
struct Strip {
    /// In the first pass: nodes of its window that no earlier strip covers, whose blocks it clears.
    to_clear: Vec<Range<usize>>,
    /// Elements of the strip in each set.
    elements: Vec<StripElements>,
}

/// Elements of one set in a strip.
#[derive(Debug)]
struct StripElements {
    /// Index of the set.
    set: usize,
    /// Indices of the elements.
    range: Range<usize>,
}

impl FusedAssembly {
    /// Divides the sets that `which` selects into strips, for `n` nodes.
    pub fn cut(n: usize, sets: &[ElementSet], which: impl Fn(&ElementSet) -> bool) -> Self {
        let mut passes: Vec<(Vec<usize>, Pass)> = Vec::new();
        for at in (0..sets.len()).filter(|at| which(&sets[*at]) && sets[*at].count() > 0) {
            let own = Pass::new(sets, &[at]);
            let is_divided = |set: &usize| !sets[*set].is_whole;
            let before = passes.last_mut().filter(|(before, _)| before.iter().chain([&at]).all(is_divided));
            if let Some((before, pass)) = before {
                let all = [&before[..], &[at]].concat();
                let joint = Pass::new(sets, &all);
                // A colour more costs less than another pass; with many colours few strips run in parallel.
                if joint.schedule.colours() <= 1 + own.schedule.colours().min(pass.schedule.colours()) {
                    (*before, *pass) = (all, joint);
                    continue;
                }
            }
            passes.push((vec![at], own));
        }
        let mut passes: Vec<Pass> = passes.into_iter().map(|(_, pass)| pass).collect();
        let mut visited = vec![false; n];
        if let Some(Pass { schedule, strips }) = passes.first_mut() {
            for chunk in schedule.chunks() {
                strips[chunk.range.start].to_clear = visit(&mut visited, chunk.window.clone());
            }
        }
        Self { passes, uncovered: visit(&mut visited, 0..n) }
    }

    /// Calls `clear(nodes, items)` for all nodes, and `add(set, chunk, items)` for chunks of each set with the items of the chunk's window. Items
    /// of node i are `out[row[i]..row[i + 1]]`.
    ///
    /// # Errors
    /// The first error of `add` in the order of strips; later strips of the same colour may have run.
    pub fn run<T: Send, E: Send>(
        &self,
        pool: &Pool,
        row: &[usize],
        out: &mut [T],
        clear: &(impl Fn(Range<usize>, &mut [T]) + Sync),
        add: &(impl Fn(usize, &Chunk, &mut [T]) -> Result<(), E> + Sync),
    ) -> Result<(), E> {
        let items = |nodes: &Range<usize>, first: usize| row[nodes.start] - first..row[nodes.end] - first;
        for nodes in &self.uncovered {
            clear(nodes.clone(), &mut out[items(nodes, 0)]);
        }
        self.passes.iter().try_for_each(|Pass { schedule, strips }| {
            schedule.run(pool, out, &|node| row[node], &|Chunk { range, window }, out| {
                let Strip { to_clear, elements } = &strips[range.start];
                for nodes in to_clear {
                    clear(nodes.clone(), &mut out[items(nodes, row[window.start])]);
                }
                elements.iter().try_for_each(|StripElements { set, range }| {
                    add(*set, &Chunk { range: range.clone(), window: window.clone() }, out)
                })
            })
        })
    }
}

impl Pass {
    /// A pass over the sets with the indices `which`, each divided into the number of chunks of the longest list.
    fn new(sets: &[ElementSet], which: &[usize]) -> Self {
        let chunks = |set: &ElementSet| if set.is_whole { 1 } else { chunk_count(set.count()) };
        let count = which.iter().map(|set| chunks(&sets[*set])).max().unwrap_or(0);
        let strip = |k: usize| {
            let elements = which.iter().map(|&set| {
                let parts = sets[set].parts();
                let Range { start, end } = part(sets[set].count() / parts, count, k);
                StripElements { set, range: start * parts..end * parts }
            });
            Strip { to_clear: Vec::new(), elements: elements.filter(|part| !part.range.is_empty()).collect() }
        };
        let strips: Vec<Strip> = (0..count).map(strip).collect();
        let window = |Strip { elements, .. }: &Strip| {
            let windows = elements.iter().map(|part| sets[part.set].window(&part.range));
            windows.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
        };
        let mut schedule = Schedule::default();
        schedule.assign(strips.iter().enumerate().map(|(k, strip)| Chunk { range: k..k + 1, window: window(strip) }));
        Self { schedule, strips }
    }
}

/// Marks nodes as visited. Returns those that were not, as ranges.
fn visit(visited: &mut [bool], nodes: Range<usize>) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for node in nodes.filter(|node| !std::mem::replace(&mut visited[*node], true)) {
        match found.last_mut().filter(|range| range.end == node) {
            Some(range) => range.end += 1,
            None => found.push(node..node + 1),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_plugin_api::{ElementRequest, abi};
    use std::convert::Infallible;

    fn set(kind: u32, nodes: Vec<u32>) -> ElementSet {
        let flags = abi::HAS_FORCES;
        let request = ElementRequest { kind, families: 0, flags, rest_stride: 0, history_stride: 0 };
        let mut set = ElementSet::new(request, false);
        set.list_mut().nodes = nodes;
        set
    }

    /// `last` triangles of a grid with rows of forty nodes, in an order, and links, from node 7 on.
    fn sets(last: u32, order: impl Fn(u32) -> u32) -> Vec<ElementSet> {
        let triangles = (0..last).map(&order).flat_map(|i| [7 + i, 8 + i, 47 + i]).collect();
        let links = (0..2 * last).flat_map(|i| [7 + i / 2, 7 + i / 2 + 40]).collect();
        vec![set(abi::TRIANGLE, triangles), set(abi::LINK, Vec::new()), set(abi::LINK, links)]
    }

    /// The number of elements at each node, as assembled over other values by one thread and by three.
    fn run(assembly: &FusedAssembly, sets: &[ElementSet], n: usize) -> Vec<Vec<u32>> {
        let row: Vec<usize> = (0..=n).map(|i| 2 * i).collect();
        let mut results = Vec::new();
        for threads in [1, 3] {
            let mut out = vec![1000; 2 * n];
            let done: Result<(), Infallible> = assembly.run(
                &Pool::new(threads),
                &row,
                &mut out,
                &|nodes, out| {
                    assert_eq!(out.len(), 2 * nodes.len());
                    out.fill(0);
                },
                &|set, Chunk { range, window }, out| {
                    let corners = sets[set].corners;
                    for node in &sets[set].nodes()[corners * range.start..corners * range.end] {
                        out[2 * (*node as usize - window.start) + 1] += 1;
                    }
                    Ok(())
                },
            );
            assert!(done.is_ok());
            results.push(out);
        }
        results
    }

    #[test]
    fn every_node_is_cleared_first_and_every_element_is_added_once() {
        let n = 10_100;
        for (order, passes) in [((|i| i) as fn(u32) -> u32, 1), (|i| i * 7919 % 10_000, 2)] {
            let sets = sets(10_000, order);
            let assembly = FusedAssembly::cut(n, &sets, |_| true);
            assert_eq!(assembly.passes.len(), passes, "lists in the same order make one pass");
            let mut want = vec![0; 2 * n];
            sets.iter().flat_map(ElementSet::nodes).for_each(|i| want[2 * *i as usize + 1] += 1);
            for result in run(&assembly, &sets, n) {
                assert_eq!(result, want);
            }
        }
    }

    #[test]
    fn a_set_that_is_called_as_a_whole_has_a_pass_of_its_own() {
        let mut sets = sets(10_000, |i| i);
        sets[2].is_whole = true;
        let assembly = FusedAssembly::cut(10_100, &sets, |_| true);
        let strips: Vec<usize> = assembly.passes.iter().map(|pass| pass.strips.len()).collect();
        assert_eq!(strips, [chunk_count(10_000), 1]);
        let alike = run(&assembly, &sets, 10_100);
        sets[2].is_whole = false;
        assert_eq!(alike, run(&FusedAssembly::cut(10_100, &sets, |_| true), &sets, 10_100));
    }

    #[test]
    fn unselected_sets_are_left_out_and_an_empty_body_is_cleared() {
        let sets = sets(100, |i| i);
        let assembly = FusedAssembly::cut(150, &sets, |set| set.corners == 3);
        assert_eq!(run(&assembly, &sets, 150)[0].iter().sum::<u32>(), 300);
        assert_eq!(run(&FusedAssembly::cut(5, &[], |_| true), &[], 5)[0], [0; 10]);
    }
}
