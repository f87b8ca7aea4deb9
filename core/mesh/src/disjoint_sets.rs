//! Disjoint sets of numbers (union-find with path halving, Tarjan 1975).

/// Disjoint sets of the numbers from 0 on.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    /// Parent of each number in its tree; a root is its own parent (n).
    parent: Vec<u32>,
}

impl DisjointSets {
    /// `count` sets of one number each.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// Adds a number in a set of its own, and returns it.
    pub fn add(&mut self) -> u32 {
        let number = self.parent.len() as u32;
        self.parent.push(number);
        number
    }

    /// Root of the set of a number: its lowest member.
    pub fn find(&mut self, mut number: u32) -> u32 {
        while self.parent[number as usize] != number {
            let grandparent = self.parent[self.parent[number as usize] as usize];
            self.parent[number as usize] = grandparent;
            number = grandparent;
        }
        number
    }

    /// Unites two sets. The lower root stays, so the result does not depend on the order of unions.
    pub fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
