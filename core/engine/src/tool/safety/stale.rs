//! Fading of a force whose simulation has stopped answering.

/// Age of a simulation result from which its force begins to fade, s.
pub const STALE_AFTER: f64 = 0.05;
/// Duration of the linear fade to zero after [`STALE_AFTER`], s.
pub const FADE_TIME: f64 = 0.1;

/// Factor, 0 to 1, for a force computed from a hand sample of this `age` (s); 0 if the age is NaN.
pub fn stale_fraction(age: f64) -> f64 {
    if age <= STALE_AFTER { 1.0 } else { (1.0 - (age - STALE_AFTER) / FADE_TIME).max(0.0) }
}
