//! Which nodes go together on a coarser level, and how much of each.
//!
//! Aggregates are a node and its neighbours, taken greedily in the order of the nodes (Vanek, Mandel and Brezina 1996). What is
//! carried over is smoothed by averaging over neighbours, with weights from the mesh alone: as good here as smoothing by the
//! matrix, and it does not change from step to step.

use super::squares::{Doubled, Laid, laid};
use crate::step::algebra::V3;
use crate::step::elements::ElementSet;
use pliant_plugin_api::abi;

/// Neighbours of each node, without itself, rising.
#[derive(Debug, Default)]
pub struct Graph {
    start: Vec<usize>,
    neighbour: Vec<u32>,
    laid: Option<Laid>,
}

/// A level that keeps more of the nodes than this is not worth it; and one that is coarser one way only.
const KEPT: f64 = 0.7;
const KEPT_ONE_WAY: f64 = 0.8;

/// A coarser level.
#[derive(Debug)]
pub struct Coarsened {
    pub graph: Graph,
    /// What carries it over.
    pub weights: Weights,
    /// Which ways it is coarser.
    pub doubled: Doubled,
}

/// From a coarser level to a finer one: weights that add up to one on each node.
#[derive(Debug, Default)]
pub struct Weights {
    /// (n + 1)
    pub start: Vec<u32>,
    /// Coarse nodes of each fine one, rising.
    pub coarse: Vec<u32>,
    /// 1
    pub weight: Vec<f32>,
}

impl Weights {
    /// The same the other way, from `coarse` nodes: fine ones of each.
    pub fn transposed(&self, coarse: usize) -> Self {
        let fine = 0..self.start.len() as u32 - 1;
        let mut terms: Vec<_> = fine.flat_map(|i| self.of(i as usize).map(move |(a, weight)| (a, i, weight))).collect();
        terms.sort_unstable_by_key(|term| (term.0, term.1));
        Self {
            start: (0..=coarse as u32).map(|a| terms.partition_point(|term| term.0 < a) as u32).collect(),
            coarse: terms.iter().map(|term| term.1).collect(),
            weight: terms.iter().map(|term| term.2).collect(),
        }
    }

    /// Coarse nodes of a fine one, with their weights; none of one past the last.
    pub fn of(&self, node: usize) -> impl Iterator<Item = (u32, f32)> {
        let end = |at: usize| self.start[at.min(self.start.len() - 1)] as usize;
        let row = end(node)..end(node + 1);
        self.coarse[row.clone()].iter().copied().zip(self.weight[row].iter().copied())
    }
}

impl Graph {
    /// Of `n` nodes and the pairs that `visit` is given.
    fn new(n: usize, mut pairs: Vec<[u32; 2]>) -> Self {
        // One number is compared sooner than two.
        pairs.sort_unstable_by_key(|[a, b]| u64::from(*a) << 32 | u64::from(*b));
        pairs.dedup();
        let start = (0..=n as u32).map(|i| pairs.partition_point(|p| p[0] < i)).collect();
        Self { start, neighbour: pairs.iter().map(|p| p[1]).collect(), laid: None }
    }

    /// Of nodes at rest, m (n x 3), and the elements that have stiffness; hinges reach further than their triangles and are left out.
    pub fn of_elements(rest: &[V3], sets: &[ElementSet]) -> Self {
        let mut pairs = Vec::new();
        for set in sets.iter().filter(|set| set.has(abi::HAS_FORCES) && set.request().kind != abi::HINGE) {
            for element in set.nodes().chunks_exact(set.corners) {
                for &a in element {
                    pairs.extend(element.iter().filter(|b| **b != a).map(|&b| [a, b]));
                }
            }
        }
        Self { laid: laid(rest, sets), ..Self::new(rest.len(), pairs) }
    }

    #[cfg(test)]
    pub fn of_triangles(laid: Option<Laid>, n: usize, triangles: &[[u32; 3]]) -> Self {
        let pairs = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *a], [*b, *c], [*c, *b], [*c, *a], [*a, *c]]);
        Self { laid, ..Self::new(n, pairs.collect()) }
    }

    /// Where its nodes are, if squares are laid over it.
    pub fn laid(&self) -> Option<&Laid> {
        self.laid.as_ref()
    }

    /// Nodes there are.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Neighbours of a node.
    pub fn of(&self, node: usize) -> &[u32] {
        &self.neighbour[self.start[node]..self.start[node + 1]]
    }

    /// The aggregate of each node, and how many there are.
    fn aggregates(&self) -> (Vec<u32>, usize) {
        const NONE: u32 = u32::MAX;
        let mut of = vec![NONE; self.len()];
        let mut count = 0_u32;
        for node in 0..self.len() {
            if of[node] == NONE && self.of(node).iter().all(|&j| of[j as usize] == NONE) {
                of[node] = count;
                self.of(node).iter().for_each(|&j| of[j as usize] = count);
                count += 1;
            }
        }
        // What is left lies between: each joins a neighbour that was taken above.
        let first = of.clone();
        for node in 0..self.len() {
            if of[node] == NONE {
                of[node] = self.of(node).iter().map(|&j| first[j as usize]).find(|&a| a != NONE).unwrap_or(NONE);
            }
            if of[node] == NONE {
                of[node] = count;
                count += 1;
            }
        }
        (of, count as usize)
    }

    /// The coarser graph, and what carries it over; `None` if it is hardly coarser.
    pub fn coarsen(&self) -> Option<Coarsened> {
        let is_worth = |nodes: usize, doubled| {
            let kept = if doubled == Doubled::Both { KEPT } else { KEPT_ONE_WAY };
            nodes as f64 <= kept * self.len() as f64
        };
        let Some(laid) = &self.laid else {
            return Some(self.gathered()).filter(|coarse| is_worth(coarse.graph.len(), coarse.doubled));
        };
        laid.next().iter().find_map(|&doubled| {
            let (corners, weights) = laid.corners(doubled, self);
            is_worth(corners.len(), doubled).then(|| self.squared(corners, weights, doubled))
        })
    }

    /// By squares, whose corners are joined where what they give to is.
    fn squared(&self, corners: Laid, weights: Weights, doubled: Doubled) -> Coarsened {
        let mut pairs = Vec::new();
        for node in 0..self.len() {
            // Corners of squares that are joined have a node in common, as long as widths are doubled both ways.
            let around = if doubled == Doubled::Both { &[] } else { self.of(node) };
            for near in around.iter().map(|near| *near as usize).chain([node]) {
                for (a, _) in weights.of(node) {
                    pairs.extend(weights.of(near).filter(|(b, _)| *b != a).map(|(b, _)| [a, b]));
                }
            }
        }
        let graph = Self::new(corners.len(), pairs);
        Coarsened { graph: Self { laid: Some(corners), ..graph }, weights, doubled }
    }

    /// By aggregates.
    fn gathered(&self) -> Coarsened {
        let (of, count) = self.aggregates();
        let mut weights = Weights { start: vec![0], ..Weights::default() };
        let mut pairs = Vec::new();
        for node in 0..self.len() {
            let around = self.of(node);
            let share = 1.0 / (1 + around.len()) as f32;
            let mut met: Vec<u32> = around.iter().map(|&j| of[j as usize]).chain([of[node]]).collect();
            pairs.extend(met.iter().filter(|a| **a != of[node]).map(|&a| [of[node], a]));
            met.sort_unstable();
            for group in met.chunk_by(|a, b| a == b) {
                weights.coarse.push(group[0]);
                weights.weight.push(share * group.len() as f32);
            }
            weights.start.push(weights.coarse.len() as u32);
        }
        Coarsened { graph: Self::new(count, pairs), weights, doubled: Doubled::Both }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_falls_into_threes_and_weights_add_up() {
        let n = 90;
        let pairs = (0..n - 1).flat_map(|i| [[i, i + 1], [i + 1, i]]).collect();
        let Coarsened { graph: coarse, weights, .. } = Graph::new(n as usize, pairs).coarsen().expect("coarser");
        assert!((25..=45).contains(&coarse.len()), "{}", coarse.len());
        for i in 0..n as usize {
            let row = weights.start[i] as usize..weights.start[i + 1] as usize;
            let sum: f32 = weights.weight[row.clone()].iter().sum();
            assert!((sum - 1.0).abs() < 1e-6 && weights.coarse[row].iter().all(|&c| (c as usize) < coarse.len()));
        }
        // Nobody alone: every coarse node has a neighbour, in both directions.
        assert!((0..coarse.len()).all(|a| !coarse.of(a).is_empty()));
        assert!((0..coarse.len()).all(|a| coarse.of(a).iter().all(|&b| coarse.of(b as usize).contains(&(a as u32)))));
    }
}
