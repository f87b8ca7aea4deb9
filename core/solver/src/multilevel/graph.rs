//! Adjacency of a level, and interpolation weights between levels.

/// Adjacency in CSR format: the neighbours of each node, without itself, ascending.
#[derive(Debug, Default)]
pub struct Graph {
    start: Vec<usize>,
    neighbour: Vec<u32>,
}

impl Graph {
    /// A graph of `n` nodes from its edges, each given in both directions.
    pub fn new(n: usize, mut pairs: Vec<[u32; 2]>) -> Self {
        // Sorting by one packed number is faster than by two.
        pairs.sort_unstable_by_key(|[a, b]| u64::from(*a) << 32 | u64::from(*b));
        pairs.dedup();
        let start = (0..=n as u32).map(|i| pairs.partition_point(|p| p[0] < i)).collect();
        Self { start, neighbour: pairs.iter().map(|p| p[1]).collect() }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Neighbours of a node.
    pub fn of(&self, node: usize) -> &[u32] {
        &self.neighbour[self.start[node]..self.start[node + 1]]
    }
}

/// Prolongation from a coarser level to a finer one; the weights of each fine node add up to one.
#[derive(Debug, Default)]
pub struct Weights {
    /// Index of the first term of each fine node (n + 1).
    pub start: Vec<u32>,
    /// Coarse nodes of each fine node, ascending.
    pub coarse: Vec<u32>,
    /// Weight of each term.
    pub weight: Vec<f32>,
}

impl Weights {
    /// The transpose (restriction): the fine nodes of each of `coarse` nodes.
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

    /// The coarse nodes of a fine node with their weights; empty for an index past the last node.
    pub fn of(&self, node: usize) -> impl Iterator<Item = (u32, f32)> {
        let end = |at: usize| self.start[at.min(self.start.len() - 1)] as usize;
        let row = end(node)..end(node + 1);
        self.coarse[row.clone()].iter().copied().zip(self.weight[row].iter().copied())
    }
}
