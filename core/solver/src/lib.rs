//! Dynamics of one body: nodes, elements, matrix, linear solver and time integration.
//!
//! The crate knows no scenes, meshes, tools or plugins; a material is a [`ForceModel`], called on ranges of elements. A [`System`] holds
//! [`Nodes`], [`ElementSet`]s and the material; an [`Integrator`] advances it by one step of a [`Scheme`] under [`Loads`], by [`Pcg`] on
//! its [`Matrix`] if the scheme is implicit. A [`Pool`] runs loops on threads; no result depends on their number.
//!
//! # Example
//! Two masses m on a spring of stiffness k and rest length 0 are back where they started after the period `2 pi sqrt(m / 2 k)`:
//! ```
//! use pliant_plugin_api::{ElementRequest, TangentScale, abi};
//! use pliant_solver::*;
//!
//! const K: f64 = 100.0; // N/m
//! struct Spring([ElementRequest; 1]);
//! impl ForceModel for Spring {
//!     fn name(&self) -> &str { "spring" }
//!     fn requests(&self) -> &[ElementRequest] { &self.0 }
//!     fn forces(&self, call: &ElementCall<'_>, out: &mut [[f64; 3]]) -> Result<(), ForceError> {
//!         let pull = [0, 1, 2].map(|i| K * (call.x[1][i] - call.x[0][i]));
//!         (0..3).for_each(|i| (out[0][i], out[1][i]) = (out[0][i] + pull[i], out[1][i] - pull[i]));
//!         Ok(())
//!     }
//! #   fn rest(&self, _: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> { Ok(()) }
//! #   fn mass(&self, _: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> { Ok(()) }
//! #   fn energy(&self, _: &ElementCall<'_>) -> Result<f64, ForceError> { Ok(0.0) }
//! #   fn tangent(&self, _: &ElementCall<'_>, _: TangentScale, _: &[u32], _: usize, _: &mut [[f64; 9]]) -> Result<(), ForceError> { Ok(()) }
//! }
//! # fn main() -> Result<(), StepError> {
//! let link = ElementRequest { kind: abi::LINK, families: abi::STRUCTURAL, flags: abi::HAS_FORCES, rest_stride: 0, history_stride: 0 };
//! let mut system = System::new(Box::new(Spring([link])));
//! system.nodes = Nodes::at_rest(vec![[0.0; 3].into(), [0.1, 0.0, 0.0].into()]); // m
//! *system.sets[0].list_mut() = ElementList { nodes: vec![0, 1], measure: vec![0.1], ..ElementList::default() };
//! system.prepare()?;
//! system.nodes.mass.fill(0.02); // kg
//! let mut integrator = Integrator::new(Scheme::SymplecticEuler, 1e-8, 100);
//! integrator.resize(2);
//! let dt = std::f64::consts::TAU * (0.02 / (2.0 * K)).sqrt() / 1000.0; // s
//! for step in 0..1000 {
//!     integrator.step(&Pool::new(1), &mut system, &Loads::default(), StepTime { start: f64::from(step) * dt, dt }, 1)?;
//! }
//! assert!((system.nodes.x[1] - system.nodes.rest[1]).norm() < 1e-5 * 0.1);
//! # Ok(())
//! # }
//! ```

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
