//! What a step of cutting has done.

use crate::body::LatticeError;
use pliant_cut::Refused;
use pliant_solver::Vec3;

/// Result of one step of cutting.
#[derive(Clone, Copy, Debug, Default)]
pub struct CutStep {
    /// Number of advances that changed a mesh.
    pub advances: usize,
    /// Cut area of solids, m^2.
    pub area: f64,
    /// Cut length of sheets, m.
    pub length: f64,
    /// The last refused advance, with the index of its body.
    pub refused: Option<(usize, Refused)>,
    /// A body that the blade was drawn right through and that it has not parted, at the end of the edit.
    pub held: Option<HeldBody>,
    /// A body that the blade left by the slit of an earlier cut, or cut nothing of because it was in one, at the end of the edit.
    pub again: Option<CutAgain>,
}

/// A body that was to be cut along an earlier cut.
#[derive(Clone, Copy, Debug)]
pub struct CutAgain {
    /// Index of the body.
    pub body: usize,
    /// A point of the rest shape where the blade came into the slit, m.
    pub place: Vec3,
    /// Length of its way in there, m.
    pub way: f64,
}

/// A body whose parts still hold together where a blade was drawn through.
#[derive(Clone, Copy, Debug)]
pub struct HeldBody {
    /// Index of the body.
    pub body: usize,
    /// A point of the rest shape where the cut ends, m.
    pub place: Vec3,
    /// Distance from there to the end of what was drawn, m.
    pub width: f64,
    /// Force that the next piece resists with, N.
    pub resistance: f64,
    /// Force of the hand on the blade, N.
    pub pull: f64,
}

/// A successful advance.
pub struct Advanced {
    /// Cutting resistance, N.
    pub force: f64,
    /// Cut area, m^2.
    pub area: f64,
    /// Cut length, m.
    pub length: f64,
    /// Whether the mesh changed.
    pub has_cut: bool,
}

/// Why an advance failed.
pub enum AdvanceError {
    /// The mesh refused it and is unchanged.
    Refused(Refused),
    /// A plugin failed.
    Failed(LatticeError),
}

impl CutStep {
    /// Adds what came of an advance in the body `index`. Returns the cutting resistance, N, if it was made.
    ///
    /// # Errors
    /// Returns the error of a plugin.
    pub fn add(
        &mut self,
        index: usize,
        advanced: Result<Option<Advanced>, AdvanceError>,
    ) -> Result<Option<f64>, LatticeError> {
        match advanced {
            Ok(None) => Ok(None),
            Ok(Some(advanced)) => {
                self.advances += usize::from(advanced.has_cut);
                self.area += advanced.area;
                self.length += advanced.length;
                Ok(Some(advanced.force))
            }
            Err(AdvanceError::Refused(refused)) => {
                self.refused = Some((index, refused));
                Ok(None)
            }
            Err(AdvanceError::Failed(error)) => Err(error),
        }
    }
}
