//! Self-convergence of a scene: errors by its step, its solver's tolerance and its grid, relative to a refined solution.
//!
//! Runs that compute the same thing, the motion of the scene's own grid, have one reference for all integrators, steps and tolerances: the most
//! accurate integrator with the finest step and tolerance. Grids of other levels are other discrete bodies; their reference is the finest
//! level. The discretisation error is estimated by the difference of two solutions, and its order shows whether refinement converges
//! (Roache 1998).

mod front;
mod page;
mod run;
mod series;

pub use run::{SceneInput, self_convergence};
