//! Assembly of all element kinds in one pass over the body: blocks are cleared right before the first kind adds to them, and are still in
//! the cache when the next kind does.

use super::ElementSet;
use super::chunk::{Chunk, Schedule, chunks, part, window};
use crate::threads::Pool;
use std::ops::Range;

/// The order in which the elements of a body are assembled.
#[derive(Debug, Default)]
pub struct FusedAssembly {
    /// Passes over the body, one after the other.
    passes: Vec<Pass>,
    /// Nodes that no strip of the first pass covers.
    bare: Vec<Range<usize>>,
}

/// Element kinds whose lists traverse the body in the same order.
#[derive(Debug, Default)]
struct Pass {
    /// Colours of the strips, by index.
    schedule: Schedule,
    strips: Vec<Strip>,
}

/// Elements of all kinds of a pass in one part of the body.
#[derive(Debug)]
struct Strip {
    /// In the first pass: nodes that no earlier strip covers.
    fresh: Vec<Range<usize>>,
    /// Index of a set and a range of its elements.
    elements: Vec<(usize, Range<usize>)>,
}

impl FusedAssembly {
    /// Cuts the sets that `which` selects into strips, for `n` nodes.
    pub fn cut(n: usize, sets: &[ElementSet], which: impl Fn(&ElementSet) -> bool) -> Self {
        let mut passes: Vec<(Vec<usize>, Pass)> = Vec::new();
        for at in (0..sets.len()).filter(|at| which(&sets[*at]) && sets[*at].count() > 0) {
            let own = Pass::new(sets, &[at]);
            if let Some((before, pass)) = passes.last_mut() {
                let all = [&before[..], &[at]].concat();
                let joint = Pass::new(sets, &all);
                // One more colour is less than another pass; many are less than two threads.
                if joint.schedule.colours() <= 1 + own.schedule.colours().min(pass.schedule.colours()) {
                    (*before, *pass) = (all, joint);
                    continue;
                }
            }
            passes.push((vec![at], own));
        }
        let mut passes: Vec<Pass> = passes.into_iter().map(|(_, pass)| pass).collect();
        let mut met = vec![false; n];
        if let Some(Pass { schedule, strips }) = passes.first_mut() {
            for chunk in schedule.chunks() {
                strips[chunk.range.start].fresh = unmet(&mut met, chunk.window.clone());
            }
        }
        Self { passes, bare: unmet(&mut met, 0..n) }
    }

    /// Clears the items of each node in `out` (node i has items `row[i]..row[i + 1]`) and runs `add` on each chunk of each set with the items
    /// of the chunk's nodes.
    ///
    /// # Errors
    /// The first error in the order of strips; others may have run.
    pub fn run<T: Send, E: Send>(
        &self,
        pool: &Pool,
        row: &[usize],
        out: &mut [T],
        clear: &(impl Fn(Range<usize>, &mut [T]) + Sync),
        add: &(impl Fn(usize, &Chunk, &mut [T]) -> Result<(), E> + Sync),
    ) -> Result<(), E> {
        let of = |nodes: &Range<usize>, base: usize| row[nodes.start] - base..row[nodes.end] - base;
        for nodes in &self.bare {
            clear(nodes.clone(), &mut out[of(nodes, 0)]);
        }
        self.passes.iter().try_for_each(|Pass { schedule, strips }| {
            schedule.run(pool, out, &|node| row[node], &|Chunk { range, window }, out| {
                let Strip { fresh, elements } = &strips[range.start];
                for nodes in fresh {
                    clear(nodes.clone(), &mut out[of(nodes, row[window.start])]);
                }
                elements.iter().try_for_each(|(set, range)| {
                    add(*set, &Chunk { range: range.clone(), window: window.clone() }, out)
                })
            })
        })
    }
}

impl Pass {
    /// A pass over the sets `which`, each cut into as many parts as the longest list needs.
    fn new(sets: &[ElementSet], which: &[usize]) -> Self {
        let pieces = which.iter().map(|at| chunks(sets[*at].count())).max().unwrap_or(0);
        let strip = |k: usize| {
            let parts = which.iter().map(|at| (*at, part(sets[*at].count(), pieces, k)));
            Strip { fresh: Vec::new(), elements: parts.filter(|(_, range)| !range.is_empty()).collect() }
        };
        let strips: Vec<Strip> = (0..pieces).map(strip).collect();
        let window = |Strip { elements, .. }: &Strip| {
            let windows = elements.iter().map(|(at, range)| window(sets[*at].nodes(), sets[*at].corners, range));
            windows.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
        };
        let mut schedule = Schedule::default();
        schedule.assign(strips.iter().enumerate().map(|(k, strip)| Chunk { range: k..k + 1, window: window(strip) }));
        Self { schedule, strips }
    }
}

/// Ranges of nodes that were not visited before; marks them visited.
fn unmet(met: &mut [bool], nodes: Range<usize>) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for node in nodes.filter(|node| !std::mem::replace(&mut met[*node], true)) {
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
        let mut set = ElementSet::new(request);
        set.list_mut().nodes = nodes;
        set
    }

    /// Triangles in rows of forty nodes, and links, from node 7 on.
    fn sets(last: u32, order: impl Fn(u32) -> u32) -> Vec<ElementSet> {
        let triangles = (0..last).map(&order).flat_map(|i| [7 + i, 8 + i, 47 + i]).collect();
        let links = (0..2 * last).flat_map(|i| [7 + i / 2, 7 + i / 2 + 40]).collect();
        vec![set(abi::TRIANGLE, triangles), set(abi::LINK, Vec::new()), set(abi::LINK, links)]
    }

    /// What runs leave in place of what was there, for one and three threads.
    fn run(strips: &FusedAssembly, sets: &[ElementSet], n: usize) -> Vec<Vec<u32>> {
        let row: Vec<usize> = (0..=n).map(|i| 2 * i).collect();
        let mut results = Vec::new();
        for threads in [1, 3] {
            let mut out = vec![1000; 2 * n];
            let done: Result<(), Infallible> = strips.run(
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
    fn every_node_is_cleared_before_and_every_element_is_there_once() {
        let n = 10_100;
        for (order, passes) in [((|i| i) as fn(u32) -> u32, 1), (|i| i * 7919 % 10_000, 2)] {
            let sets = sets(10_000, order);
            let strips = FusedAssembly::cut(n, &sets, |_| true);
            assert_eq!(strips.passes.len(), passes, "lists that go over the body alike go together");
            let mut want = vec![0; 2 * n];
            sets.iter().flat_map(ElementSet::nodes).for_each(|i| want[2 * *i as usize + 1] += 1);
            for result in run(&strips, &sets, n) {
                assert_eq!(result, want);
            }
        }
    }

    #[test]
    fn what_is_not_asked_for_is_left_out_and_nothing_is_cleared_too() {
        let sets = sets(100, |i| i);
        let strips = FusedAssembly::cut(150, &sets, |set| set.corners == 3);
        assert_eq!(run(&strips, &sets, 150)[0].iter().sum::<u32>(), 300);
        assert_eq!(run(&FusedAssembly::cut(5, &[], |_| true), &[], 5)[0], [0; 10]);
    }
}
