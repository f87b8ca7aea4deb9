//! What the suite changes of the input of calls.

use super::super::tested_material::MaterialUnderTest;
use super::Body;
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
}
