//! What a matrix is assembled from.

use crate::coupled::{Coupled, is_coupled_hinges};
use crate::elements::ElementSet;
use crate::elements::chunk::Chunk;
use crate::factors::Factors;
use crate::force_model::{ForceError, ForceModel, StepTime};
use crate::nodes::Nodes;
use crate::outer::Precision;
use pliant_plugin_api::{TangentScale, abi};

/// A state, and what is to be made of it.
pub struct Assembly<'a> {
    pub material: &'a dyn ForceModel,
    pub sets: &'a [ElementSet],
    pub nodes: &'a Nodes,
    /// Of the state.
    pub time: StepTime,
    /// With the strains of the state, where hinges are coupled and have a part in it.
    pub coupled: Option<&'a Coupled>,
    pub factors: Factors,
}

impl Assembly<'_> {
    /// Adds what a chunk of a set does to `blocks`, of which the first is in slot `first`.
    ///
    /// # Errors
    /// What the material says.
    pub fn add<T: Precision>(
        &self,
        set: usize,
        chunk: &Chunk,
        (first, blocks): (usize, &mut [[T; 9]]),
    ) -> Result<(), ForceError> {
        let set = &self.sets[set];
        if set.has(abi::HAS_FORCES) {
            let call = set.call(chunk, self.nodes, &self.nodes.v, self.time);
            let scale = TangentScale { stiffness: self.factors.stiffness, damping: self.factors.damping };
            T::add_tangent(self.material, &call, scale, (&set.slots, first), blocks)?;
        }
        if let Some(coupled) = self.coupled.filter(|_| is_coupled_hinges(set)) {
            let factors = (self.factors.stiffness, self.factors.stand_in);
            coupled.add_tangent(set, chunk.range.clone(), factors, (first, blocks));
        }
        Ok(())
    }
}
