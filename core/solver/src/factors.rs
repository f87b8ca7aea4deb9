//! What a matrix is asked to be made of.

/// What may stand for the stiffness of coupled hinges, whose own matrix is full, and of an energy of normals, whose matrix joins
/// nodes that share no element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandIn {
    /// Good enough where a line search follows.
    Searched,
    /// At least half the exact one: a step of backward Euler that is linearised once is stable with it.
    Half,
    /// Nowhere below the exact one: for step limits, and schemes that do not damp.
    Certain,
}

/// What a matrix is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// Of the masses.
    pub mass: f64,
    /// Of the stiffness.
    pub stiffness: f64,
    /// Of the damping.
    pub damping: f64,
    /// What may stand for a stiffness that is not at hand.
    pub stand_in: StandIn,
    /// Whether the forces of the same state were found last.
    pub after_forces: bool,
    /// Whether blocks may be in single precision, if the material has them.
    pub rounded: bool,
}
