//! A body of a scene: the model an artist handed in, the nodes that carry it, and how its surface follows them.

mod cell_corners;
mod cutting;
mod discretization;
mod fields;
mod fixing;
mod grid_pool;
mod lattice;
mod look;
mod model;
mod near;
mod pages;
mod reshape;
mod samples;
mod sheet;
mod skin;
mod state;
mod symmetry;

pub use cell_corners::CellCorners;
pub use discretization::Discretization;
pub use fields::{FieldSurface, Fields, Layer, factor_at};
pub use fixing::{Fixing, Place};
pub use grid_pool::{GridPool, PooledGrid};
pub use lattice::{Inner, Lattice, LatticeError, NodeBounds, RegionSettings, Repair};
pub use look::{ABSENT, CAP, TriangleLook};
pub use model::Model;
pub use pages::{PAGE, PageStamps};
pub use reshape::RestChange;
pub use samples::Samples;
pub use sheet::{Sheet, Warp};
pub use skin::{NOT_CARRIED, Skin, interpolate};
pub use state::BodyState;
pub use symmetry::{Axes, Symmetry, mirrored};

use cutting::CutMargins;
use pliant_cut::CutMesh;
use pliant_solver::{Pool, System, Vec3};
use std::sync::Arc;

/// Everything about one body.
pub struct Body {
    /// As the scene calls it.
    pub name: String,
    /// What does not change while it deforms.
    pub model: Arc<Model>,
    /// The mesh a blade cuts; none where no edit is a cut.
    pub cut: Option<Box<CutMesh>>,
    pub(crate) cut_margins: CutMargins,
    /// Where its surface is now.
    pub skin: Skin,
    /// Nodes, elements and material.
    pub system: System,
    /// Which nodes there are, and how the surface follows them.
    pub discretization: Discretization,
    /// Its surface as a ball feels it; none where no tool is a ball.
    pub samples: Arc<Samples>,
    /// N/m for a m^2, of the soft layer a tool lies in on its surface
    pub layer_stiffness: f64,
    /// Nodes that are held.
    pub fixings: Vec<Fixing>,
    /// Pairs of vertices that edits with symmetry keep mirrored.
    pub symmetry: Option<Symmetry>,
    /// Why it no longer moves, once its material failed or its state was no longer finite.
    pub frozen: Option<String>,
}

impl Body {
    /// Brings the surface of every node up to date: for a picture, a file or the end of a run.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn update_skin(&mut self, pool: &Pool) -> Result<(), LatticeError> {
        self.discretization.embed_all(pool, &self.system.nodes, &self.model, &mut self.skin)?;
        if let Some(symmetry) = &self.symmetry {
            symmetry.apply(&self.model, &mut self.skin);
        }
        Ok(())
    }

    /// Where the nodes carry one rest place, and where they would if they were at rest. What no node carries stays.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_point(&self, place: Vec3) -> Result<(Vec3, Vec3), LatticeError> {
        self.discretization.embed_point(place, &self.model, &self.skin, &self.system.nodes)
    }

    /// Bytes of the largest parts.
    pub fn bytes(&self) -> usize {
        let nodes = self.system.nodes.len() * 200;
        let elements: usize = self.system.sets.iter().map(|s| s.count() * 40).sum();
        let matrix = self.system.matrix.as_ref().map_or(0, pliant_solver::Matrix::bytes);
        nodes + elements + matrix + self.model.bytes() + self.discretization.bytes()
    }
}
