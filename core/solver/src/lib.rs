//! Dynamics of one body: nodes, elements, matrix, linear solver and time integration.
//!
//! The crate knows neither materials, which it calls through [`ForceModel`], nor scenes. A [`System`] holds nodes and elements; an
//! [`Integrator`] advances them by one step.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

mod algebra;
mod constraint;
mod coupled;
mod elements;
mod f32_matrix;
mod force_model;
mod hinge_assembly;
mod integrate;
mod interrupts;
mod lanczos;
mod lanes;
mod matrix;
mod multilevel;
mod nodes;
mod normals;
mod solver;
mod springs;
mod system;
mod system_scales;
mod threads;

pub use algebra::{Block, Vec3, matrix3};
pub use constraint::Constraint;
pub use coupled::CoupledHinges;
pub use elements::chunk::{Chunk, Schedule};
pub use elements::corner_weights::CornerWeights;
pub use elements::{ElementList, ElementSet};
pub use f32_matrix::F32Matrix;
pub use force_model::{ElementCall, ForceError, ForceModel, StepTime};
pub use integrate::contact_constraints::{
    ContactConstraints, ErrorBound, MAX_ACTIVE_SET_PASSES, NoContacts, TrialStep,
};
pub use integrate::limit::{Frequencies, SpringRates, StepLimit};
pub use integrate::scheme::Scheme;
pub use integrate::{Integrator, Loads, StepError, StepReport};
pub use interrupts::{CancelToken, Interrupts};
pub use lanes::Vectors;
pub use matrix::Matrix;
pub use nodes::Nodes;
pub use normals::NormalsEnergy;
pub use solver::filtered_system::{FilteredSystem, SolveReport};
pub use solver::partial_solution::PartialSolution;
pub use solver::{Momentum, Pcg, Preconditioner};
pub use springs::NodeSprings;
pub use system::{System, SystemState};
pub use system_scales::{HessianApproximation, SystemScales};
pub use threads::{MAX_THREADS, Pool, Splittable};
