//! Jets of nodes as far as they are known, and those of a cell's corners.

use super::{Jet, NO_JET};

/// Jets of the corners of a cell: for each component corner by corner, eight derivatives each.
pub(in super::super) struct CellJets(pub(super) [[f64; 64]; 3]);

impl CellJets {
    /// Puts the jets of the corners side by side.
    pub fn new(corners: [&Jet; 8]) -> Self {
        let mut out = [[0.0; 64]; 3];
        for (corner, jet) in corners.into_iter().enumerate() {
            for (out, values) in out.iter_mut().zip(jet) {
                out[8 * corner..8 * corner + 8].copy_from_slice(values);
            }
        }
        Self(out)
    }

    /// The sum of two fields.
    pub fn plus(mut self, other: &Self) -> Self {
        self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()).for_each(|(a, b)| *a += b);
        self
    }

    /// Whether nothing in the cell moves.
    pub fn is_zero(&self) -> bool {
        self.0.as_flattened().iter().all(|value| *value == 0.0)
    }
}

/// Jets of nodes, computed when first asked for after nodes have moved.
#[derive(Default)]
pub(in super::super) struct JetCache {
    jets: Vec<Jet>,
    /// The round in which each jet was computed.
    round: Vec<u32>,
    now: u32,
}

impl JetCache {
    /// Declares all jets outdated, of `nodes` nodes.
    pub fn forget(&mut self, nodes: usize) {
        if self.jets.len() < nodes {
            self.jets.resize(nodes, NO_JET);
            self.round.resize(nodes, self.now);
        }
        if self.now == u32::MAX {
            self.round.fill(0);
            self.now = 0;
        }
        self.now += 1;
    }

    /// The jet of a node, as [`JetCache::know`] has left it.
    pub fn get(&self, node: u32) -> &Jet {
        &self.jets[node as usize]
    }

    /// Computes the jet of a node if it is outdated.
    pub fn know(&mut self, node: u32, compute: impl FnOnce() -> Jet) {
        let n = node as usize;
        if self.round[n] != self.now {
            (self.jets[n], self.round[n]) = (compute(), self.now);
        }
    }
}
