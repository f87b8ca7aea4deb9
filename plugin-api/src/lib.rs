//! The interface between pliant and its plugins.
//!
//! A plugin is a shared library with one exported symbol. It offers materials (constitutive laws), grids (cells around a surface, and
//! the embedding of the surface in them), devices (haptic hardware) or contact laws (tractions between tools and bodies); the host does
//! everything else. [`abi`] is the binary interface, the same as in `include/pliant.h`. The rest is safe Rust on top of it: implement
//! [`Material`], [`Grid`], [`Device`] or [`ContactLaw`], then call [`export_plugins`].
//!
//! The host reads a plugin's descriptor and checks the scene's parameters against it, creates an instance, sets its parameters,
//! activates it (the trait's `new`: the last chance to allocate), calls it from the thread classes the header states, then
//! deactivates and destroys it. The library stays loaded until the program ends.

#![deny(clippy::wildcard_enum_match_arm)]

pub mod abi;
pub mod batch;
pub mod blocks;
mod cell;
mod contact_law;
mod crack_band;
mod device;
#[doc(hidden)]
pub mod export;
mod fault;
mod grid;
mod info;
#[doc(hidden)]
pub mod instance;
pub mod kit;
pub mod lanes;
mod material;
mod normals;
pub mod param;
mod planes_mut;
#[cfg(feature = "lanes")]
pub mod solids;

pub use batch::{Elements, Field, NodeScalars, NodeVectors, NodeWindow, Planes};
pub use blocks::{BlockScalar, BlockWindow, Blocks, SingleBlocks, pair_index};
pub use cell::CELL_TETRAHEDRA;
pub use contact_law::{AsContactLaw, ContactLaw, ContactPoint, MAX_CONTACT_HISTORY, PointTraction};
pub use crack_band::{CrackBand, TooWide};
pub use device::{AsDevice, Device, Finding};
pub use fault::Fault;
pub use grid::{AsGrid, Grid, Location, RegionRequest, RegionSink, SurfaceView};
pub use info::Info;
pub use lanes::prefetch;
pub use material::{AsMaterial, ElementRequest, Material, Source, TangentScale};
pub use normals::NormalForces;
pub use param::{Param, Params};
pub use planes_mut::PlanesMut;
