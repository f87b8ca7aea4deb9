//! A kit for hyperelastic solids of tetrahedra: a material gives an energy density, and this module does the rest at the speed of the
//! built-in solids.
//!
//! Implement [`SolidEnergy`] for the density, its stress and its second derivative. The functions are generic over a scalar and a vector
//! register ([`Real`](crate::lanes::Real)), so they compute one element or one for each lane; mark them `#[inline(always)]`, or they are not
//! compiled for the vector unit. A material then forwards its calls: [`requests`], [`write_rest_data`], [`add_mass`] and [`SolidCall`].
//! `pliant plugin new NAME --kind material` writes one of about 100 lines.
//!
//! The parts can be used alone: 3 x 3 matrices, eigenvalues and singular values ([`svd`]), kinematics ([`Tetrahedron`]), stiffness blocks made
//! positive semi-definite ([`EnergyHessian`]), viscosity ([`Damping`]), and gathering and scattering of registers ([`gather`], [`scatter`]).

mod call;
mod energy;
mod fibres;
mod hessian;
mod kernel;
pub mod matrix;
mod neo_hookean;
mod registers;
mod svd;
#[cfg(test)]
mod tests;
mod tetrahedron;
mod viscosity;

pub use call::{Shapes, SolidCall, add_mass, requests};
pub use energy::SolidEnergy;
pub use fibres::{FIBRE_STRIDE, FibreEnergy, with_fibres, write_fibres};
pub use hessian::{EnergyHessian, PrincipalModes, Stiffness};
pub use matrix::Mat3;
pub use neo_hookean::{StableNeoHookean, lame_constants};
pub use registers::{CORNER_PAIRS, ElementBlocks, gather, scatter};
pub use svd::{Eigen, Svd, svd, symmetric_eigen};
pub use tetrahedron::{STRIDE, Tetrahedron, at_corners, rest_planes, write_rest_data};
pub use viscosity::{Damping, ViscosityCoefficients, add_viscous_stress};
