//! The interface between pliant and its plugins: the C ABI, and safe Rust on top of it.
//!
//! A plugin is a shared library with one exported symbol. It offers materials (constitutive laws), grids (cells around a surface, and
//! the embedding of the surface in them), devices (haptic hardware) or contact laws (tractions between tools and bodies); the host does
//! everything else. A plugin sees no scene, no body and no solver. [`abi`] is the binary interface, the same as in `include/pliant.h`.
//! Implement [`Material`], [`Grid`], [`Device`] or [`ContactLaw`], call [`export_plugins`], and test the plugin with the conformance suite
//! of [`kit`].
//!
//! The host reads a plugin's descriptor and checks the scene's parameters against it, creates an instance, sets its parameters,
//! activates it (the trait's `new`: the last chance to allocate), calls it from the thread classes the header states, then
//! deactivates and destroys it. The library stays loaded until the program ends.
//!
//! # Example
//! A contact law: a layer of springs (Winkler), whose traction is proportional to the overlap.
//! ```
//! use pliant_plugin_api::*;
//!
//! struct Winkler { stiffness: f64 }
//! impl ContactLaw for Winkler {
//!     const INFO: Info = Info {
//!         id: c"org.example.winkler",
//!         name: c"Winkler",
//!         version: c"1.0.0",
//!         summary: c"a layer of springs (Winkler 1867)",
//!         params: &[Param::number(c"stiffness", c"Pa/m", 1.0..=1e12, 1e7, c"traction over overlap")],
//!     };
//!     fn new(params: &Params<'_>) -> Result<Self, Fault> {
//!         Ok(Self { stiffness: params.number("stiffness") })
//!     }
//!     fn traction(&self, point: &ContactPoint, _: &[f64]) -> Result<PointTraction, Fault> {
//!         let slope = if point.gap < 0.0 { -self.stiffness } else { 0.0 * point.gap };
//!         Ok(PointTraction { normal: slope * point.gap, normal_by_gap: slope, ..PointTraction::default() })
//!     }
//! }
//! export_plugins!(AsContactLaw<Winkler>);
//!
//! fn main() {
//!     let overlap = ContactPoint { gap: -1e-3, ..ContactPoint::default() }; // m
//!     assert_eq!(Winkler { stiffness: 2e7 }.traction(&overlap, &[]).unwrap().normal, 2e4); // Pa
//!     kit::check::<AsContactLaw<Winkler>>();
//! }
//! ```

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
