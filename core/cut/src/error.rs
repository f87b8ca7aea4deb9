//! Why an advance was not made.

use thiserror::Error;

/// An advance that cannot be made; the mesh is what it was. The stroke stays where it was too, so the next advance spans
/// both.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("cut refused: {reason}: {entity}, {value}")]
pub struct Refused {
    /// What is wrong.
    pub reason: Refusal,
    /// Of what.
    pub entity: &'static str,
    /// How much: in m, degrees, or a number, as the reason says.
    pub value: f64,
}

/// What can be wrong with an advance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Error)]
pub enum Refusal {
    /// A coordinate that is no number, or beyond 1e9 m.
    #[error("a coordinate is not finite")]
    NotFinite,
    /// The blade's ends are in one place.
    #[error("no length (m)")]
    NoLength,
    /// The cut would leave a triangle with too small an angle.
    #[error("a splinter would be left (degrees)")]
    Splinter,
    /// The cut crosses itself within one strip: a surface that passes through itself, or two that nearly touch.
    #[error("lines of the cut cross each other (number of lines)")]
    Crossed,
    /// What is inside of a body cannot be told.
    #[error("inside and outside cannot be told apart (body)")]
    Unclear,
    /// Parts would stay connected in a way that vertices cannot express.
    #[error("vertices would merge (vertex)")]
    Merged,
    /// The result did not pass its check.
    #[error("the result would be broken")]
    Broken,
}
