//! Errors of an advance.

use thiserror::Error;

/// An advance that is impossible. Mesh and stroke are unchanged, so the next advance spans both.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("cut refused: {reason}: {entity}, {value}")]
pub struct Refused {
    /// Why the advance is impossible.
    pub reason: Refusal,
    /// The entity at fault, for messages.
    pub entity: &'static str,
    /// Measured value or index; its unit is given by the reason.
    pub value: f64,
}

/// Reason why an advance is impossible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Error)]
pub enum Refusal {
    /// A coordinate is not finite, or its magnitude is above 1e9 m.
    #[error("a coordinate is not finite or its magnitude is above 1e9 m")]
    NotFinite,
    /// The two ends of the blade coincide.
    #[error("the length of the blade (m) is zero")]
    NoLength,
    /// The cut would leave a triangle with too small an angle.
    #[error("a sliver would be left (smallest angle in degrees)")]
    Sliver,
    /// The cut would separate a part too small to be of any use.
    #[error("a crumb would be left (volume in m^3)")]
    Crumb,
    /// The cut crosses itself within one strip: a surface that passes through itself, or two that nearly touch.
    #[error("lines of the cut cross each other (number of lines, or index of the node or triangle)")]
    Crossed,
    /// The winding numbers of a body are inconsistent, so its interior is undefined.
    #[error("inside and outside are undefined (index of the body)")]
    Undefined,
    /// Separated parts would remain connected in a way that shared vertices cannot represent.
    #[error("separated vertices would remain one (index of the vertex, or number of rounds)")]
    Merged,
    /// The result failed verification.
    #[error("the result failed verification (m^3 for the volume, m^2 for the area, otherwise an index)")]
    Invalid,
}
