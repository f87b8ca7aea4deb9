//! Schemes and steps: stability, bytes, sleep and precision.

mod coupling;
mod determinism;
mod explicit_extremes;
mod extreme;
mod integrator_choice;
mod integrators;
mod sleep;
