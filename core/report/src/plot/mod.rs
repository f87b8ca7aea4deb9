//! Pictures as SVG texts: curves, maps and stacked bars. Every axis has a name and a unit; legends stand beside the picture,
//! where nothing can lie under them.

mod bars;
mod heat;
mod lines;
mod svg;

pub use bars::Bars;
pub use heat::Heat;
pub use lines::{Curve, Lines};
pub(super) use svg::{escape, short};

/// What an axis shows.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// Its name and unit, for example `step (s)`.
    pub label: String,
    /// Logarithmic.
    pub log: bool,
}

impl Axis {
    /// Logarithmic.
    pub fn log(label: &str) -> Self {
        Self { label: label.into(), log: true }
    }

    /// Linear.
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), log: false }
    }
}
