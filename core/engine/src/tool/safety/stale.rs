//! How a force fades when nothing new comes from the simulation.

/// How long an answer of the simulation stands, s.
pub const PATIENCE: f64 = 0.05;
/// Fades in which the force goes to zero after that, s.
pub const FADES: f64 = 0.1;

/// Share of a force that is left `age` (s) after the sample of the hand that it answers; none for an age that is no number.
pub fn fresh(age: f64) -> f64 {
    if age <= PATIENCE { 1.0 } else { (1.0 - (age - PATIENCE) / FADES).max(0.0) }
}
