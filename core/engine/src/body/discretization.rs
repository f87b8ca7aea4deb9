//! What carries a body: the nodes that are simulated, and how the surface follows them.

use super::fixing::Fixing;
use super::lattice::{Lattice, LatticeError};
use super::model::Model;
use super::sheet::Sheet;
use super::skin::Skin;
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Nodes, Pool, StepTime, System, Vec3};

/// The nodes of a body.
pub enum Discretization {
    /// Those of a grid around it.
    Lattice(Box<Lattice>),
    /// Its own vertices.
    Sheet(Box<Sheet>),
}

impl Discretization {
    /// The lattice, if it is one.
    pub fn lattice(&self) -> Option<&Lattice> {
        match self {
            Self::Lattice(lattice) => Some(lattice),
            Self::Sheet(_) => None,
        }
    }

    /// The lattice, if it is one.
    pub fn lattice_mut(&mut self) -> Option<&mut Lattice> {
        match self {
            Self::Lattice(lattice) => Some(lattice),
            Self::Sheet(_) => None,
        }
    }

    /// The sheet, if it is one.
    pub fn sheet(&self) -> Option<&Sheet> {
        match self {
            Self::Lattice(_) => None,
            Self::Sheet(sheet) => Some(sheet),
        }
    }

    /// The sheet, if it is one.
    pub fn sheet_mut(&mut self) -> Option<&mut Sheet> {
        match self {
            Self::Lattice(_) => None,
            Self::Sheet(sheet) => Some(sheet),
        }
    }

    /// The distance of neighbouring nodes, m.
    pub fn edge(&self) -> f64 {
        match self {
            Self::Lattice(lattice) => lattice.edge(),
            Self::Sheet(sheet) => sheet.edge(),
        }
    }

    /// Whether the whole body is simulated.
    pub fn is_whole(&self) -> bool {
        self.lattice().is_none_or(Lattice::is_whole)
    }

    /// m, radius of the cells that are simulated around a contact; infinite: the whole body
    pub fn radius(&self) -> f64 {
        self.lattice().map_or(f64::INFINITY, |lattice| lattice.settings.radius)
    }

    /// Makes what is around `wanted` contacts active. Returns whether anything changed.
    ///
    /// # Errors
    /// What grid or material say; what is active is then as it was.
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

    /// Sets what driven and returning nodes do in the step from `time` of `dt` (s).
    pub fn prescribe(&self, nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
        match self {
            Self::Lattice(lattice) => lattice.prescribe(nodes, fixings, time),
            Self::Sheet(sheet) => sheet.prescribe(nodes, fixings, time),
        }
    }

    /// Brings every active point of the surface up to date.
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

    /// Makes the present shape of the active nodes their rest shape, at rest.
    ///
    /// # Errors
    /// What the material says of the new rest shape.
    pub fn keep(&mut self, model: &Model, skin: &mut Skin, system: &mut System) -> Result<(), LatticeError> {
        match self {
            Self::Lattice(lattice) => lattice.keep(model, skin, system).map(drop),
            Self::Sheet(sheet) => sheet.keep(model, skin, system),
        }
    }

    /// Where the nodes carry one rest place, and where they would if they were at rest. What no node carries stays.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_point(
        &self,
        place: Vec3,
        model: &Model,
        skin: &Skin,
        nodes: &Nodes,
    ) -> Result<(Vec3, Vec3), LatticeError> {
        match self {
            Self::Lattice(lattice) => lattice.embed_point(place, nodes),
            Self::Sheet(sheet) => Ok(sheet.embed_point(place, model, skin, nodes)),
        }
    }

    /// Bytes of the largest parts.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Lattice(lattice) => lattice.bytes(),
            Self::Sheet(sheet) => sheet.bytes(),
        }
    }
}
