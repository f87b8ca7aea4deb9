//! The conformance kit: small test bodies for a material's physics, and the conformance suite for every plugin.
//!
//! A plugin's own tests use [`material`], [`block`], [`sheet()`] and [`Body`] to compare a material with closed forms, and [`check`] to
//! run the conformance suite. `pliant plugin check` runs the same suite on a library written in any language.

mod allocations;
mod block;
mod body;
mod candidate;
mod cases;
mod contact_law;
mod device;
mod grid;
mod guarded;
mod guarded_planes;
mod instance;
mod normals;
mod protected_memory;
mod random;
mod sheet;
mod tested_material;

pub use allocations::{CountingAllocator, allocations};
pub use block::{Block, block};
pub use body::{Body, ElementPlanes, SummedBlocks};
pub use candidate::{Candidate, Kind};
pub use cases::{Case, Verdict, cases, check};
pub use contact_law::TestContactLaw;
pub use instance::TestInstance;
pub use protected_memory::ProtectedMemory;
pub use random::Random;
pub use sheet::{Sheet, sheet};
pub use tested_material::{Call, MaterialUnderTest};

use crate::fault::Fault;
use crate::material::Material;
use crate::param::{Params, Value, defaults, position};

/// A material with the given numbers, by parameter key and in the parameters' units, and defaults for the rest.
///
/// # Errors
/// The fault of [`Material::new`].
///
/// # Panics
/// On a key that is not declared.
pub fn material<M: Material>(numbers: &[(&str, f64)]) -> Result<M, Fault> {
    let mut values = defaults(M::INFO.params);
    for &(key, value) in numbers {
        let index = position(M::INFO.params, key).unwrap_or_else(|| panic!("parameter `{key}` is not declared"));
        values[index] = Value::Number(value);
    }
    M::new(&Params::new(M::INFO.params, &values))
}

/// The m elements of one kind, with k corners each.
#[derive(Clone, Debug, Default)]
pub struct ElementList {
    /// Nodes of each element (m x k).
    pub nodes: Vec<u32>,
    /// Family of each link (m); empty: all structural.
    pub family: Vec<u32>,
    /// Measure of each element (m), in the unit of its kind; empty: all 1.
    pub measure: Vec<f64>,
    /// Material coordinates of triangles, m (m x k x 2), or empty.
    pub material: Vec<f64>,
}

pub use crate::material::corners;
