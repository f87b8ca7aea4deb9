//! Any scene against its own refined solution: the error that its step, its solver's tolerance and its grid leave.
//!
//! The reference is the same scene with a step, tolerance or cell as much finer as the report affords. The discretisation error is then
//! estimated by the difference of two solutions, and its order tells whether refining converges (Roache 1998).

mod page;
mod run;
mod series;

pub use run::{SceneInput, self_convergence};
