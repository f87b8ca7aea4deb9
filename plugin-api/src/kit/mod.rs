//! Tests for plugins: a small body to hold a material against, and the conformance suite every plugin is held to.
//!
//! An author's own tests use [`material`], [`block`] and [`Body`] for the physics, and [`check`] for the promises of the
//! border. `pliant plugin check` runs the same suite on a library of any language.

mod allocations;
mod block;
mod body;
mod candidate;
mod cases;
mod normals;
mod opened;
mod opened_device;
mod opened_grid;
mod sheet;
mod subject;

pub use allocations::{CountingAllocator, allocations};
pub use block::{Block, block};
pub use body::Body;
pub use candidate::{Candidate, Kind};
pub use cases::{Case, Verdict, cases, check};
pub use opened::Opened;
pub use sheet::{Sheet, sheet};
pub use subject::{Call, Subject};

use crate::abi;
use crate::fault::Fault;
use crate::material::Material;
use crate::param::{Params, Value, defaults, position};

/// Makes a material from its defaults and the given numbers, as a host would.
///
/// # Errors
/// What the material says of its parameters.
///
/// # Panics
/// On a key that is not declared.
pub fn material<M: Material>(numbers: &[(&str, f64)]) -> Result<M, Fault> {
    let mut values = defaults(M::INFO.params);
    for &(key, value) in numbers {
        let at = position(M::INFO.params, key).unwrap_or_else(|| panic!("parameter `{key}` is not declared"));
        values[at] = Value::Number(value);
    }
    M::new(&Params::new(M::INFO.params, &values))
}

/// Elements of one kind, as an author gives them.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// (m x k), k nodes each
    pub nodes: Vec<u32>,
    /// (m), or empty for all structural
    pub family: Vec<u32>,
    /// (m), or empty for all 1
    pub measure: Vec<f64>,
    /// m (m x k x 2), or empty
    pub material: Vec<f64>,
}

/// Corners of an element kind.
///
/// # Panics
/// On a kind there is not.
pub fn corners(kind: u32) -> usize {
    match kind {
        abi::POINT => 1,
        abi::LINK => 2,
        abi::TRIANGLE => 3,
        abi::HINGE | abi::TETRAHEDRON => 4,
        _ => panic!("no element kind {kind}"),
    }
}
