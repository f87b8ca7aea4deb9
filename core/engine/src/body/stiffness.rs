//! The factor of a body's stiffness that a session may change while the body is stepped.
//!
//! It multiplies the field of the material's parameter `young`, so it works with any material that lets this parameter differ from place to place,
//! and masses, rest shape and history stay.

use super::{Body, Discretization};
use pliant_solver::{ForceError, System};

/// A factor of the parameter `young` of a body's material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessFactor {
    /// Index of the parameter among the material's fields.
    plane: usize,
    /// Number of the material's fields.
    planes: usize,
    /// The factor, above 0; 1 when the body is opened.
    value: f64,
}

impl StiffnessFactor {
    /// The factor 1 for field number `plane` of `planes`.
    pub fn new(plane: usize, planes: usize) -> Self {
        Self { plane, planes, value: 1.0 }
    }

    /// Multiplies the factors of the elements, which have just been listed, by that of a body, if it has one.
    pub(super) fn apply(factor: Option<Self>, system: &mut System) {
        if let Some(factor) = factor.filter(|factor| factor.value != 1.0) {
            factor.scale(system, factor.value);
        }
    }

    /// Multiplies the field of all elements by `ratio`; elements without fields get some.
    fn scale(&self, system: &mut System, ratio: f64) {
        for set in &mut system.sets {
            let count = set.count();
            let fields = &mut set.list_mut().fields;
            if fields.is_empty() {
                fields.resize(self.planes * count, 1.0);
            }
            fields[self.plane * count..][..count].iter_mut().for_each(|factor| *factor *= ratio);
        }
    }
}

impl Body {
    /// The factor of its stiffness, 1 when it was opened; `None` if its material has no parameter `young` that may differ from place to place.
    pub fn stiffness_factor(&self) -> Option<f64> {
        let factor = match &self.discretization {
            Discretization::Lattice(lattice) => lattice.stiffness,
            Discretization::Sheet(sheet) => sheet.stiffness,
        };
        factor.map(|factor| factor.value)
    }

    /// Sets the factor of its stiffness, above 0, at its present shape: elastic and viscous forces change with it at once.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(crate) fn set_stiffness_factor(&mut self, value: f64) -> Result<(), ForceError> {
        let factor = match &mut self.discretization {
            Discretization::Lattice(lattice) => &mut lattice.stiffness,
            Discretization::Sheet(sheet) => &mut sheet.stiffness,
        };
        let Some(factor) = factor else { return Ok(()) };
        let ratio = value / factor.value;
        factor.value = value;
        factor.scale(&mut self.system, ratio);
        self.layer_stiffness *= ratio;
        self.system.renew_rest()
    }
}
