//! Nodes by their numbers in the file.

use super::error::TetMeshProblem;
use super::raw::RawMesh;
use super::words::Located;

/// Nodes by their numbers in the file: those that tetrahedra have get an index from 0 in the order of the file.
pub(super) struct NodeIndex {
    /// Number and place in the file of each node, ascending by number.
    by_number: Vec<(u64, u32)>,
    /// Index of each node of the file among those that are used, or [`UNUSED`].
    index_of: Vec<u32>,
}

/// Index of a node that no tetrahedron has.
const UNUSED: u32 = u32::MAX;

impl NodeIndex {
    /// Sorts the nodes of a file by number.
    ///
    /// # Errors
    /// A number that is there twice.
    pub(super) fn new(raw: &RawMesh) -> Result<Self, Located> {
        let mut by_number: Vec<(u64, u32)> = raw.nodes.iter().zip(0..).map(|((number, _), at)| (*number, at)).collect();
        by_number.sort_unstable();
        if let Some(pair) = by_number.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err((raw.node_at[pair[1].1 as usize], TetMeshProblem::NodeTwice { number: pair[0].0 }));
        }
        Ok(Self { by_number, index_of: vec![UNUSED; raw.nodes.len()] })
    }

    /// Place in the file of the node with a number; `None` if there is none.
    pub(super) fn place(&self, number: u64) -> Option<usize> {
        let at = self.by_number.binary_search_by_key(&number, |(of, _)| *of).ok()?;
        Some(self.by_number[at].1 as usize)
    }

    /// Which numbers nodes have, for messages.
    pub(super) fn allowed(&self) -> String {
        match (self.by_number.first(), self.by_number.last()) {
            (Some((first, _)), Some((last, _))) if last - first + 1 == self.by_number.len() as u64 => {
                format!("{first} to {last}")
            }
            (Some((first, _)), Some((last, _))) => {
                format!("the {} numbers of its nodes, from {first} to {last}", self.by_number.len())
            }
            _ => "none, as the file has no nodes".into(),
        }
    }

    /// Marks the node with a number as used, if it is there.
    pub(super) fn mark(&mut self, number: u64) {
        if let Some(place) = self.place(number) {
            self.index_of[place] = 0;
        }
    }

    /// Gives the marked nodes their indices. Returns their places in the file.
    pub(super) fn number_marked(&mut self) -> Vec<usize> {
        let mut places = Vec::new();
        for (place, index) in self.index_of.iter_mut().enumerate().filter(|(_, index)| **index != UNUSED) {
            *index = places.len() as u32;
            places.push(place);
        }
        places
    }

    /// Places in the file of nodes that are not used, ascending.
    pub(super) fn unused(&self) -> impl Iterator<Item = usize> + '_ {
        self.index_of.iter().enumerate().filter(|(_, index)| **index == UNUSED).map(|(place, _)| place)
    }

    /// Index of the node with a number; `None` if no tetrahedron has it or it is not there.
    pub(super) fn used(&self, number: u64) -> Option<u32> {
        Some(self.index_of[self.place(number)?]).filter(|index| *index != UNUSED)
    }
}
