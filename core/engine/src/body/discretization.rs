//! The discretization of a body: which nodes are simulated, and how the surface follows them.

use super::fixing::Fixing;
use super::lattice::{Lattice, LatticeError, NodeKey};
use super::model::Model;
use super::sheet::Sheet;
use super::skin::{EmbeddedPoint, Skin};
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Nodes, Pool, StepTime, System, Vec3};

/// The discretization of a body; a `match` on it is the only place where solids and sheets differ.
pub enum Discretization {
    /// A solid, embedded in a regular grid of cubic cells.
    Lattice(Box<Lattice>),
    /// A sheet, whose vertices are the nodes.
    Sheet(Box<Sheet>),
}

impl Discretization {
    /// The lattice of a solid; `None` for a sheet.
    pub fn lattice(&self) -> Option<&Lattice> {
        match self {
            Self::Lattice(lattice) => Some(lattice),
            Self::Sheet(_) => None,
        }
    }

    /// The lattice of a solid; `None` for a sheet.
    pub fn lattice_mut(&mut self) -> Option<&mut Lattice> {
        match self {
            Self::Lattice(lattice) => Some(lattice),
            Self::Sheet(_) => None,
        }
    }

    /// The sheet; `None` for a solid.
    pub fn sheet(&self) -> Option<&Sheet> {
        match self {
            Self::Lattice(_) => None,
            Self::Sheet(sheet) => Some(sheet),
        }
    }

    /// The sheet; `None` for a solid.
    pub fn sheet_mut(&mut self) -> Option<&mut Sheet> {
        match self {
            Self::Lattice(_) => None,
            Self::Sheet(sheet) => Some(sheet),
        }
    }

    /// Distance between neighbouring nodes, m: the edge of a cell, or the mean edge of a sheet.
    pub fn edge(&self) -> f64 {
        match self {
            Self::Lattice(lattice) => lattice.edge(),
            Self::Sheet(sheet) => sheet.edge(),
        }
    }

    /// The name of a node, which it has in every region and after every cut: that of the grid, or the number of its vertex.
    pub fn node_key(&self, node: u32) -> NodeKey {
        match self {
            Self::Lattice(lattice) => lattice.node_key(node),
            Self::Sheet(sheet) => NodeKey { node: sheet.vertex_of(node).map_or(u64::MAX, u64::from), copy: 0 },
        }
    }

    /// Whether the whole body is simulated, not only cells around contacts.
    pub fn is_whole(&self) -> bool {
        self.lattice().is_none_or(Lattice::is_whole)
    }

    /// Radius around a contact within which cells are simulated, m; infinite where the whole body is.
    pub fn radius(&self) -> f64 {
        self.lattice().map_or(f64::INFINITY, |lattice| lattice.settings.radius)
    }

    /// Activates the cells within the `wanted` balls around contacts. Returns whether nodes or elements changed.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin; the active cells are then those before.
    pub fn follow(
        &mut self,
        wanted: &[Ball],
        model: &Model,
        fixings: &[Fixing],
        skin: &mut Skin,
        system: &mut System,
    ) -> Result<bool, LatticeError> {
        match self {
            Self::Lattice(lattice) => lattice.follow(wanted, model, fixings, skin, system),
            Self::Sheet(sheet) => sheet.activate(model, fixings, system),
        }
    }

    /// Prescribes the velocity of driven and returning nodes for a step.
    pub fn prescribe(&self, nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
        match self {
            Self::Lattice(lattice) => lattice.prescribe(nodes, fixings, time),
            Self::Sheet(sheet) => sheet.prescribe(nodes, fixings, time),
        }
    }

    /// Updates the position of every vertex that active nodes move.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_all(
        &mut self,
        pool: &Pool,
        nodes: &Nodes,
        model: &Model,
        skin: &mut Skin,
    ) -> Result<(), LatticeError> {
        match self {
            Self::Lattice(lattice) => lattice.embed_all(pool, nodes, model, skin),
            Self::Sheet(sheet) => {
                sheet.embed(nodes, skin);
                Ok(())
            }
        }
    }

    /// Makes the present shape of the active nodes their rest shape, with zero velocity.
    ///
    /// # Errors
    /// Returns the error of the material, if it refuses the new rest shape.
    pub fn keep(&mut self, model: &Model, skin: &mut Skin, system: &mut System) -> Result<(), LatticeError> {
        match self {
            Self::Lattice(lattice) => lattice.keep(model, skin, system).map(drop),
            Self::Sheet(sheet) => sheet.keep(model, skin, system),
        }
    }

    /// Position of a point of the rest shape (m) in the present shape, as [`super::Body::embed_point`].
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_point(
        &self,
        point: Vec3,
        model: &Model,
        skin: &Skin,
        nodes: &Nodes,
    ) -> Result<EmbeddedPoint, LatticeError> {
        match self {
            Self::Lattice(lattice) => lattice.embed_point(point, nodes),
            Self::Sheet(sheet) => Ok(sheet.embed_point(point, model, skin, nodes)),
        }
    }

    /// Estimate of the memory, bytes: the largest arrays.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Lattice(lattice) => lattice.bytes(),
            Self::Sheet(sheet) => sheet.bytes(),
        }
    }
}
