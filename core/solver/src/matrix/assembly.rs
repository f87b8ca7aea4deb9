//! Assembly of a matrix from element sets.

use crate::coupled::{CoupledHinges, is_coupled_hinges};
use crate::elements::chunk::Chunk;
use crate::force_model::ForceError;
use crate::hinge_assembly::{BlocksMut, Precision};
use crate::system::SystemState;
use crate::system_scales::SystemScales;
use pliant_plugin_api::{TangentScale, abi};

/// What a matrix is assembled from.
pub struct Assembly<'a> {
    /// Element sets, nodes and time.
    pub state: SystemState<'a>,
    /// Coupled hinges with the strains of the state, if they have stiffness.
    pub coupled: Option<&'a CoupledHinges>,
    /// Factors of mass, stiffness and damping.
    pub scales: SystemScales,
}

impl Assembly<'_> {
    /// Adds the tangent of a chunk of set number `set` to `blocks`.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn add<T: Precision>(&self, set: usize, chunk: &Chunk, mut blocks: BlocksMut<'_, T>) -> Result<(), ForceError> {
        let SystemState { material, sets, nodes, time } = self.state;
        let set = &sets[set];
        if set.has(abi::HAS_FORCES) {
            let scale = TangentScale { stiffness: self.scales.stiffness, damping: self.scales.damping };
            set.for_each_intact(chunk, |chunk| {
                set.add_tangent(material, chunk, nodes, time, scale, blocks.reborrow())
            })?;
        }
        if let Some(coupled) = self.coupled.filter(|_| is_coupled_hinges(set)) {
            coupled.add_tangent(set, chunk.range.clone(), &self.scales, blocks);
        }
        Ok(())
    }
}
