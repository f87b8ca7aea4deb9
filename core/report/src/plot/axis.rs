//! Axes of a picture.

/// Label and scale of an axis.
#[derive(Clone, Debug, Default)]
pub(crate) struct Axis {
    /// Name and unit, for example `step (s)`.
    pub(crate) label: String,
    /// Whether the scale is logarithmic.
    pub(crate) log: bool,
}

impl Axis {
    /// A logarithmic axis.
    pub(crate) fn log(label: &str) -> Self {
        Self { label: label.into(), log: true }
    }

    /// A linear axis.
    pub(crate) fn linear(label: &str) -> Self {
        Self { label: label.into(), log: false }
    }
}
