//! What the suite changes and compares of the input of calls.

use super::super::tested_material::MaterialUnderTest;
use super::{Body, ElementSet};
use crate::fault::Fault;

impl Body {
    /// Multiplies the measure of each element of a kind by `factor(element)`. The material writes its rest data again.
    ///
    /// # Errors
    /// The material's fault.
    pub(in crate::kit) fn scale_measures<S: MaterialUnderTest + ?Sized>(
        &mut self,
        material: &S,
        kind: u32,
        factor: impl Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        for set in self.sets.iter_mut().filter(|set| set.request.kind == kind) {
            set.measure.iter_mut().enumerate().for_each(|(e, measure)| *measure *= factor(e));
        }
        self.write_rest_data(material)
    }

    /// Bits of everything a call reads and may not write, with guard planes: positions, velocities, measures, rest data, histories, fields.
    pub(in crate::kit) fn input_bits(&self) -> Vec<u64> {
        let nodes = [&self.rest, &self.x, &self.v].into_iter().flatten().flatten().map(|v| v.to_bits());
        let of_set = |s: &ElementSet| {
            let lists = s.measure.iter().chain(&s.material).map(|v| v.to_bits());
            lists.chain(s.rest_data.bits()).chain(s.history.bits()).chain(s.fields.bits()).collect::<Vec<_>>()
        };
        nodes.chain(self.sets.iter().flat_map(of_set)).collect()
    }
}
