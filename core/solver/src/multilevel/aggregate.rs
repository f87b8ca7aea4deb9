//! Coarsening by aggregation: an aggregate is a node with its neighbours, chosen greedily in the order of the nodes (Vanek, Mandel and Brezina
//! 1996).
//!
//! The prolongation is smoothed by averaging over neighbours, with weights from the mesh alone. It needs as many iterations as smoothing with the
//! matrix, and it does not change from step to step.

use super::graph::{Graph, Weights};

/// Returns the graph of the aggregates and the prolongation from them.
pub fn aggregated(graph: &Graph) -> (Graph, Weights) {
    let (of, count) = aggregates(graph);
    let mut weights = Weights { start: vec![0], ..Weights::default() };
    let mut pairs = Vec::new();
    for node in 0..graph.len() {
        let around = graph.of(node);
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
    (Graph::new(count, pairs), weights)
}

/// Returns the aggregate of each node (n) and the number of aggregates.
fn aggregates(graph: &Graph) -> (Vec<u32>, usize) {
    const NONE: u32 = u32::MAX;
    let mut of = vec![NONE; graph.len()];
    let mut count = 0_u32;
    for node in 0..graph.len() {
        if of[node] == NONE && graph.of(node).iter().all(|&j| of[j as usize] == NONE) {
            of[node] = count;
            graph.of(node).iter().for_each(|&j| of[j as usize] = count);
            count += 1;
        }
    }
    // The remaining nodes lie between aggregates and join that of a neighbour.
    let first = of.clone();
    for node in 0..graph.len() {
        if of[node] == NONE {
            of[node] = graph.of(node).iter().map(|&j| first[j as usize]).find(|&a| a != NONE).unwrap_or(NONE);
        }
        if of[node] == NONE {
            of[node] = count;
            count += 1;
        }
    }
    (of, count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_aggregated_in_threes_and_weights_sum_to_one() {
        let n = 90;
        let pairs = (0..n - 1).flat_map(|i| [[i, i + 1], [i + 1, i]]).collect();
        let (coarse, weights) = aggregated(&Graph::new(n as usize, pairs));
        assert!((25..=45).contains(&coarse.len()), "{}", coarse.len());
        for i in 0..n as usize {
            let row = weights.start[i] as usize..weights.start[i + 1] as usize;
            let sum: f32 = weights.weight[row.clone()].iter().sum();
            assert!((sum - 1.0).abs() < 1e-6 && weights.coarse[row].iter().all(|&c| (c as usize) < coarse.len()));
        }
        // Every coarse node has a neighbour, and adjacency is symmetric.
        assert!((0..coarse.len()).all(|a| !coarse.of(a).is_empty()));
        assert!((0..coarse.len()).all(|a| coarse.of(a).iter().all(|&b| coarse.of(b as usize).contains(&(a as u32)))));
    }
}
