//! Sweeping of a body up to a blade: straight on, around what the mesh refuses, or with a bridge where there is no way around.

use super::body_stroke::{BodyStroke, Bridge, count_parts, midpoint, travel};
use super::cut_step::AdvanceError;
use super::detour::{Detoured, force, go_around};
use crate::body::{Body, Discretization, LatticeError};
use pliant_cut::{Advance, Blade, Refused};
use pliant_solver::Vec3;

/// Where a body is cut up to.
pub struct SweepTarget {
    /// The blade in the rest shape, m.
    pub blade: Blade,
    /// Distance between advances, m.
    pub stride: f64,
    /// Unit vector of the cutting direction in the rest shape; zero before the first cut.
    pub heading: Vec3,
    /// Whether no longer strip will follow that a refused one could wait for.
    pub last: bool,
}

/// What several advances have cut together.
#[derive(Default)]
pub struct Swept {
    /// Cut area, m^2.
    pub area: f64,
    /// Cut length, m.
    pub length: f64,
    /// Whether the mesh changed.
    pub has_cut: bool,
}

/// Distance from the last advance, in strides, up to which a refused cut waits for the blade to move on.
const WAIT_STRIDES: f64 = 3.0;

impl Swept {
    /// Has the body adopt an advance of its mesh.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn take(&mut self, body: &mut Body, advance: &Advance) -> Result<(), LatticeError> {
        self.area += advance.area;
        self.length += advance.length;
        if !advance.has_cut() {
            return Ok(());
        }
        self.has_cut = true;
        body.take_cut(advance)
    }
}

impl BodyStroke {
    /// Cuts a body up to `to`, as far as its mesh allows. `None` if a refused strip waits for a longer one. If the material of a sheet refuses the cut elements,
    /// the sheet is as it was.
    ///
    /// # Errors
    /// Returns why the mesh refuses every strip, or the error of a plugin.
    pub fn sweep(&mut self, body: &mut Body, to: &SweepTarget) -> Result<Option<Swept>, AdvanceError> {
        let before = body.discretization.sheet().is_some().then(|| body.save());
        let swept = self.sweep_anyhow(body, to);
        if let (Err(AdvanceError::Failed(_)), Some(before)) = (&swept, &before) {
            body.restore(before).map_err(AdvanceError::Failed)?;
        }
        swept
    }

    fn sweep_anyhow(&mut self, body: &mut Body, to: &SweepTarget) -> Result<Option<Swept>, AdvanceError> {
        let Some(mesh) = &mut body.cut else { return Ok(None) };
        let before = self.stroke.blade();
        // Elements of a sheet are its triangles: what does not meet the end of a cut there is seen to by wider snapping.
        let straight = match &body.discretization {
            Discretization::Lattice(_) => mesh.advance_without_bridges(&mut self.stroke, to.blade),
            Discretization::Sheet(_) => mesh.advance(&mut self.stroke, to.blade),
        };
        let mut swept = Swept::default();
        match straight {
            Ok(advance) => {
                self.previous = Some(before);
                swept.take(body, &advance).map_err(AdvanceError::Failed)?;
            }
            // A longer strip is often cut where this one would leave a sliver.
            Err(_) if !to.last && travel(&before, &to.blade) < WAIT_STRIDES * to.stride => return Ok(None),
            Err(refused) => self.sweep_around(body, to, refused, &mut swept)?,
        }
        Ok(Some(swept))
    }

    /// Cuts up to `to` where the straight strip is `refused`, and remembers the first place where that may have left a bridge.
    fn sweep_around(
        &mut self,
        body: &mut Body,
        to: &SweepTarget,
        refused: Refused,
        swept: &mut Swept,
    ) -> Result<(), AdvanceError> {
        let before = self.stroke.blade();
        // The parts are counted once in a stroke: it takes a look at the whole surface.
        let parts = self.bridge.map_or_else(|| count_parts(body), |bridge| bridge.parts);
        let bridge = Bridge { place: midpoint(&before), width: to.stride, parts };
        let ends = (&mut self.stroke, &mut self.previous);
        match go_around(body, ends, &to.blade, to.stride, swept).map_err(AdvanceError::Failed)? {
            Detoured::Onward => return Ok(()),
            Detoured::Through => {}
            Detoured::Nowhere => match force(body, &mut self.stroke, &to.blade, to.stride, to.heading) {
                Ok(advance) => swept.take(body, &advance).map_err(AdvanceError::Failed)?,
                Err(_) => {
                    let width = travel(&before, &self.stroke.blade());
                    if width > 0.0 {
                        self.bridge.get_or_insert(Bridge { width, ..bridge });
                    }
                    return Err(AdvanceError::Refused(refused));
                }
            },
        }
        self.bridge.get_or_insert(bridge);
        Ok(())
    }
}
