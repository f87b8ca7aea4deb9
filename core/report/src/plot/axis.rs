//! Axes of a picture.

/// Label and scale of an axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// Name and unit, for example `step (s)`.
    pub label: String,
    /// Whether the scale is logarithmic.
    pub log: bool,
}

impl Axis {
    /// A logarithmic axis.
    pub fn log(label: &str) -> Self {
        Self { label: label.into(), log: true }
    }

    /// A linear axis.
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), log: false }
    }
}
