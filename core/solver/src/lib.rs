//! How a body moves: state, elements, matrix, solver and time integration.
//!
//! Nothing here knows what a material is made of, or what a scene is. A [`System`] holds nodes and elements; an
//! [`Integrator`] moves them by one step.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod algebra;
mod constraint;
mod coupled;
mod elements;
mod factors;
mod force_model;
mod integrate;
mod lanes;
mod matrix;
mod multilevel;
mod nodes;
mod normals;
mod outer;
mod single;
mod solver;
mod springs;
mod system;
mod threads;

pub use algebra::{Block, Vec3, matrix3};
pub use constraint::Constraint;
pub use elements::chunk::{Chunk, Schedule};
pub use elements::{ElementList, ElementSet};
pub use factors::{Factors, StandIn};
pub use force_model::{ElementCall, ForceError, ForceModel, StepTime};
pub use integrate::holds::{Doubt, Holds, HoldsNothing, Outcome};
pub use integrate::limit::{Frequencies, StepLimit};
pub use integrate::{Integrator, Loads, Scheme, StepError, StepReport};
pub use lanes::Vectors;
pub use matrix::Matrix;
pub use nodes::Nodes;
pub use single::Single;
pub use solver::peek::Peek;
pub use solver::solve::{Solve, SolveReport};
pub use solver::{Pcg, Preconditioner};
pub use springs::NodeSprings;
pub use system::System;
pub use threads::{Parts, Pool};
