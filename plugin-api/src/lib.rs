//! What crosses the border between pliant and a plugin.
//!
//! A plugin is a shared library with one exported symbol. It offers materials (what the force is), grids (which nodes carry
//! a surface) or devices (where the hand is); the host does everything else. [`abi`] is the wire format, the same as in
//! `include/pliant.h`; the rest is safe Rust on top of it: implement [`Material`], [`Grid`] or [`Device`], then call
//! [`export_plugins`].
//!
//! The life of an instance: the host reads the descriptor and checks the scene's parameters against it, creates the
//! instance, sets parameters, activates it (`new`: the last chance to allocate), calls it from the thread classes the header
//! names, deactivates and destroys it. The library stays loaded until the program ends.

pub mod abi;
pub mod batch;
pub mod blocks;
mod cell;
mod device;
#[doc(hidden)]
pub mod export;
mod fault;
mod grid;
mod info;
#[doc(hidden)]
pub mod instance;
pub mod kit;
#[cfg(feature = "lanes")]
pub mod lanes;
mod material;
mod normals;
pub mod param;
mod planes_mut;
mod prefetch;

pub use batch::{Elements, NodeScalars, NodeVectors, Planes};
pub use blocks::{Blocks, Entry, SingleBlocks, pair};
pub use cell::CELL_TETRAHEDRA;
pub use device::{AsDevice, Device, Finding};
pub use fault::Fault;
pub use grid::{AsGrid, Grid, Location, RegionRequest, RegionSink, SurfaceView};
pub use info::Info;
pub use material::{AsMaterial, ElementRequest, Material, Source, Tangent};
pub use normals::NormalForces;
pub use param::{Param, Params};
pub use planes_mut::PlanesMut;
pub use prefetch::prefetch;
