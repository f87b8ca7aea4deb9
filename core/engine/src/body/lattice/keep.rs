//! What keeping a shape leaves at the nodes: rest positions that have moved, and slopes of the surface.

use super::smooth::{Jet, NO_JET, SmoothEmbedding, add};
use super::{Kept, Lattice, LatticeError};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;

/// Cells whose weights are looked at before a grid is taken for trilinear.
const PROBES: usize = 8;
/// Where in a cell that is done, in its edges.
const PROBE: [f64; 3] = [0.3, 0.6, 0.8];
/// Most a weight or corner may be off, as a share of 1 or of an edge: far above rounding, far below what would be seen.
const TRILINEAR: f64 = 1e-6;

impl Lattice {
    /// Lists what the slopes of the surface follow from, after the region has changed.
    ///
    /// # Errors
    /// What the grid says.
    pub(super) fn list_slopes(&mut self) -> Result<(), LatticeError> {
        if !self.is_probed && !self.region.cell_id.is_empty() {
            self.is_probed = true;
            if self.smooth.is_some() && !self.is_trilinear()? {
                self.smooth = None;
            }
        }
        let Some(smooth) = &mut self.smooth else { return Ok(()) };
        let keys = self.region.node_id.iter().zip(&self.region.node_copy);
        let kept = match self.kept.is_empty() {
            true => Vec::new(),
            false => keys.map(|(id, copy)| self.kept.get(&(*id, *copy)).map_or(NO_JET, |kept| kept.jet)).collect(),
        };
        smooth.list(&self.region, kept);
        Ok(())
    }

    /// Whether cells are cubes of the level's edge and weights in them are trilinear.
    fn is_trilinear(&self) -> Result<bool, LatticeError> {
        let edge = self.facts.edge;
        for corners in self.region.cell_corners.iter().take(PROBES) {
            let least = self.grid_rest(corners[0]);
            let at = |corner: usize| least + edge * Vec3::from_fn(|axis, _| (corner >> axis & 1) as f64);
            let place = least + edge * Vec3::from(PROBE);
            let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
            self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
            for (corner, &node) in corners.iter().enumerate() {
                let along = |axis: usize| if corner >> axis & 1 == 1 { PROBE[axis] } else { 1.0 - PROBE[axis] };
                let wanted = along(0) * along(1) * along(2);
                let is_off = (self.grid_rest(node) - at(corner)).amax() > TRILINEAR * edge;
                if is_off || (weights[0][corner] - wanted).abs() > TRILINEAR {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Adds to the slopes that are kept those of a field of displacements `of(node)`, m.
    pub(super) fn keep_slopes(&mut self, of: impl Fn(u32) -> Vec3) {
        let Some(smooth) = &mut self.smooth else { return };
        let nodes = self.region.node_id.len();
        let jets: Vec<Jet> = (0..nodes as u32).map(|node| smooth.jet(&self.region, node, &of)).collect();
        let SmoothEmbedding { kept, .. } = &mut **smooth;
        kept.resize(nodes, NO_JET);
        kept.iter_mut().zip(&jets).for_each(|(kept, jet)| add(kept, jet));
        smooth.forget();
    }

    /// Takes note of where a node is at rest: moved by `moved`, m, from where the grid has it.
    pub(super) fn keep_node(&mut self, node: u32, moved: Vec3) {
        let kept = self.smooth.as_ref().and_then(|smooth| smooth.kept.get(node as usize));
        let jet = kept.copied().unwrap_or(NO_JET);
        let key = (self.region.node_id[node as usize], self.region.node_copy[node as usize]);
        if moved != Vec3::zeros() || jet != NO_JET {
            self.kept.insert(key, Kept { moved, jet });
        }
    }
}
