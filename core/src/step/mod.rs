//! How a body moves: state, elements, matrix, solver and time integration.
//!
//! Nothing here knows what a material is made of, or what a scene is. A [`System`] holds nodes and elements; an
//! [`Integrator`] moves them by one step.

mod age;
mod aggregate;
mod assembly;
mod chebyshev;
mod chunk;
mod constraint;
mod coupled;
mod crew;
mod double;
mod each;
mod elements;
mod explicit;
mod galerkin;
mod guess;
mod held;
mod hinge;
mod holds;
mod implicit;
mod inner;
mod integrate;
mod inverses;
mod lanczos;
mod lanes;
mod limit;
mod lines;
mod matrix;
mod multilevel;
mod normals;
mod outer;
mod pcg;
mod peek;
mod pool;
mod product;
mod residual;
mod right_side;
mod rounded;
mod rounded_product;
mod settle;
mod single;
mod single_outer;
mod single_update;
mod sliced;
mod springs;
mod squares;
mod strips;
mod system;

pub use chunk::{Chunk, Schedule};
pub use constraint::Constraint;
pub use elements::{ElementList, ElementSet};
pub use holds::{Doubt, Holds, HoldsNothing, Outcome};
pub use integrate::{Integrator, Loads, Scheme, StepError, StepReport};
pub use lanes::Vectors;
pub use limit::{Frequencies, StepLimit};
pub use matrix::{Factors, Matrix, StandIn};
pub use pcg::{Pcg, Preconditioner, Solve, SolveReport};
pub use peek::Peek;
pub use pool::{Parts, Pool};
pub use single::Single;
pub use springs::NodeSprings;
pub use system::{Nodes, System};

/// A point or vector, m, m/s or N.
pub type V3 = [f64; 3];
/// A 3 x 3 block, row-major.
pub type Block = [f64; 9];

/// Sum of products.
#[inline(always)]
pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Block times vector.
#[inline(always)]
pub fn times(m: &Block, v: V3) -> V3 {
    [
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
        m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
    ]
}

/// `a + s b`
#[inline(always)]
pub fn axpy(a: V3, s: f64, b: V3) -> V3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// m/s; what is slower stands still.
const STILL: f64 = 1e-40;

/// A velocity without components that are nothing. A sheet's first touch spreads out of its plane as ever smaller numbers, and
/// processors take a hundred times as long over the smallest.
#[inline(always)]
fn without_dust(v: V3) -> V3 {
    v.map(|c| if c.abs() < STILL { 0.0 } else { c })
}
