//! Jets of the corners of a cell, and a cache of the jets of nodes.

use super::{Jet, NO_JET};

/// Jets of the corners of a cell, by component, then corner, then derivative (3 x 8 x 8).
pub(in super::super) struct CellJets(pub(super) [[f64; 64]; 3]);

impl CellJets {
    /// Arranges the jets of eight corners.
    pub fn new(corners: [&Jet; 8]) -> Self {
        let mut out = [[0.0; 64]; 3];
        for (corner, jet) in corners.into_iter().enumerate() {
            for (out, values) in out.iter_mut().zip(jet) {
                out[8 * corner..8 * corner + 8].copy_from_slice(values);
            }
        }
        Self(out)
    }

    /// Sum with the jets of another field.
    pub fn plus(mut self, other: &Self) -> Self {
        self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()).for_each(|(a, b)| *a += b);
        self
    }

    /// Whether all values and derivatives are zero.
    pub fn is_zero(&self) -> bool {
        self.0.as_flattened().iter().all(|value| *value == 0.0)
    }
}

/// Jets of nodes, computed on first use after nodes have moved.
#[derive(Default)]
pub(in super::super) struct JetCache {
    jets: Vec<Jet>,
    /// The generation in which each jet was computed; jets of older ones are outdated (n).
    generation: Vec<u32>,
    /// The present generation.
    current: u32,
}

impl JetCache {
    /// Marks the jets of all `nodes` nodes as outdated.
    pub fn forget(&mut self, nodes: usize) {
        if self.jets.len() < nodes {
            self.jets.resize(nodes, NO_JET);
            self.generation.resize(nodes, self.current);
        }
        if self.current == u32::MAX {
            self.generation.fill(0);
            self.current = 0;
        }
        self.current += 1;
    }

    /// The jet of a node as of its last [`JetCache::update`].
    pub fn get(&self, node: u32) -> &Jet {
        &self.jets[node as usize]
    }

    /// Computes the jet of a node if it is outdated.
    pub fn update(&mut self, node: u32, compute: impl FnOnce() -> Jet) {
        let n = node as usize;
        if self.generation[n] != self.current {
            (self.jets[n], self.generation[n]) = (compute(), self.current);
        }
    }
}
