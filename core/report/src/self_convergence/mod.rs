//! Self-convergence of a scene: errors by its step, its solver's tolerance and its grid, relative to a refined solution.
//!
//! The reference is the same scene with the finest step, tolerance or cell of the series. The discretisation error is estimated by the difference of two
//! solutions, and its order shows whether refinement converges (Roache 1998).

mod page;
mod run;
mod series;

pub use run::{SceneInput, self_convergence};
