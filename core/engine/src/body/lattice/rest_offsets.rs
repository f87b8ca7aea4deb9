//! Changes of the rest shape, stored by node: displaced rest positions and jets of the surface, which outlive the region.

use super::fragments::NodeKey;
use super::smooth::{Jet, NO_JET, SmoothEmbedding, add};
use super::{Lattice, LatticeError};
use pliant_solver::{Nodes, Vec3};
use std::collections::HashMap;

/// What edits have changed of the rest shape at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::body) struct RestOffset {
    /// Position of the node in the undeformed grid, m.
    pub(in crate::body) place: Vec3,
    /// Displacement of the rest position from the grid, m.
    pub(in crate::body) displacement: Vec3,
    /// Jet of that displacement. It is stored, as a later cut changes the fit at the node but must not move the surface at rest.
    pub(super) jet: Jet,
}

/// Offsets of the nodes whose rest positions edits have moved.
pub(in crate::body) type RestOffsets = HashMap<NodeKey, RestOffset>;

impl RestOffset {
    /// No displacement of the node at `place` (m).
    pub(in crate::body) fn zero(place: Vec3) -> Self {
        Self { place, displacement: Vec3::zeros(), jet: NO_JET }
    }

    /// Whether it displaces nothing.
    pub(in crate::body) fn is_zero(&self) -> bool {
        self.displacement == Vec3::zeros() && self.jet == NO_JET
    }

    /// This offset and `factor` times another one of the same node.
    pub(in crate::body) fn plus(mut self, other: &Self, factor: f64) -> Self {
        self.displacement += factor * other.displacement;
        for (to, from) in self.jet.iter_mut().flatten().zip(other.jet.iter().flatten()) {
            *to += factor * from;
        }
        self
    }
}

/// Cells whose weights are checked before a grid is treated as trilinear.
const CHECKED_CELLS: usize = 8;
/// The point of a cell at which they are checked, in edges.
const CHECKED_POINT: [f64; 3] = [0.3, 0.6, 0.8];
/// Largest error of a weight (1) or a corner (edges): far above rounding, far below a visible displacement.
const TRILINEAR_TOLERANCE: f64 = 1e-6;

impl Lattice {
    /// Prepares the smooth embedding for a new region. A grid whose weights are not trilinear gets none.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn update_smooth_embedding(&mut self) -> Result<(), LatticeError> {
        if !self.is_grid_checked && !self.region.cell_id.is_empty() {
            self.is_grid_checked = true;
            if self.smooth.is_some() && !self.is_trilinear()? {
                self.smooth = None;
            }
        }
        let Some(smooth) = &mut self.smooth else { return Ok(()) };
        let keys = self.region.node_id.iter().zip(&self.region.node_copy);
        let rest_jets = match self.rest_offsets.is_empty() {
            true => Vec::new(),
            false => keys
                .map(|(&node, &copy)| {
                    self.rest_offsets.get(&NodeKey { node, copy }).map_or(NO_JET, |offset| offset.jet)
                })
                .collect(),
        };
        smooth.list(&self.region, rest_jets);
        Ok(())
    }

    /// Whether cells are cubes with the level's edge and the weights in them are trilinear.
    fn is_trilinear(&self) -> Result<bool, LatticeError> {
        let edge = self.facts.edge;
        for corners in self.region.cell_corners.iter().take(CHECKED_CELLS) {
            let least = self.grid_rest(corners[0]);
            let at = |corner: usize| least + edge * Vec3::from_fn(|axis, _| (corner >> axis & 1) as f64);
            let weights = self.locate(least + edge * Vec3::from(CHECKED_POINT))?.weights;
            for (corner, &node) in corners.iter().enumerate() {
                let along =
                    |axis: usize| if corner >> axis & 1 == 1 { CHECKED_POINT[axis] } else { 1.0 - CHECKED_POINT[axis] };
                let trilinear = along(0) * along(1) * along(2);
                let is_displaced = (self.grid_rest(node) - at(corner)).amax() > TRILINEAR_TOLERANCE * edge;
                if is_displaced || (weights[corner] - trilinear).abs() > TRILINEAR_TOLERANCE {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Adds the jets of a displacement field `of(node)` (m) to those of the rest shape.
    pub(super) fn add_rest_jets(&mut self, of: impl Fn(u32) -> Vec3) {
        let Some(smooth) = &mut self.smooth else { return };
        let nodes = self.region.node_id.len();
        let jets: Vec<Jet> = (0..nodes as u32).map(|node| smooth.jet(&self.region, node, &of)).collect();
        let SmoothEmbedding { rest_jets, .. } = &mut **smooth;
        rest_jets.resize(nodes, NO_JET);
        rest_jets.iter_mut().zip(&jets).for_each(|(rest, jet)| add(rest, jet));
        smooth.forget();
    }

    /// Stores the displacement (m) of a node's rest position from the grid, and its jet.
    pub(super) fn store_rest_offset(&mut self, node: u32, displacement: Vec3) {
        let jet = self.smooth.as_ref().and_then(|smooth| smooth.rest_jets.get(node as usize));
        let jet = jet.copied().unwrap_or(NO_JET);
        if displacement != Vec3::zeros() || jet != NO_JET {
            let place = self.grid_rest(node);
            self.rest_offsets.insert(self.node_key(node), RestOffset { place, displacement, jet });
        }
    }

    /// Whether edits have left the body in another shape than that of its file.
    pub fn has_rest_offsets(&self) -> bool {
        !self.rest_offsets.is_empty()
    }

    /// The offsets of all nodes, with those of copies that a cut has made and the next region will have.
    pub(in crate::body) fn all_rest_offsets(&self) -> RestOffsets {
        let mut offsets = self.rest_offsets.clone();
        for new in &self.fragments.new_copies {
            if let Some(offset) = offsets.get(&new.original).copied() {
                offsets.insert(new.key, offset);
            }
        }
        offsets
    }

    /// Moves the active nodes, whose state is `nodes`, with their rest positions to those of other offsets.
    pub(in crate::body) fn move_to_offsets(&self, offsets: &RestOffsets, nodes: &mut Nodes) {
        for i in 0..nodes.len() {
            let grid = self.grid_rest(i as u32);
            let rest = offsets.get(&self.node_key(i as u32)).map_or(grid, |offset| grid + offset.displacement);
            nodes.x[i] += rest - nodes.rest[i];
            nodes.rest[i] = rest;
        }
    }

    /// The key of an active node.
    pub(in crate::body) fn node_key(&self, node: u32) -> NodeKey {
        NodeKey { node: self.region.node_id[node as usize], copy: self.region.node_copy[node as usize] }
    }
}
