//! A body of a scene: its model, the discretization that is simulated, and the surface that is embedded in it.
//!
//! A solid is embedded in a [`Lattice`] of cubic cells, or of the tetrahedra of its file; a sheet is simulated on its own mesh ([`Sheet`]). Either way
//! [`pliant_solver::System`] holds nodes and elements, and [`Skin`] the positions of the model's vertices that follow from them.

mod broken_surface;
mod cell_corners;
mod cutting;
mod discretization;
mod divide;
mod failed_triangles;
mod fibres;
mod fields;
mod fixing;
mod folds;
mod grid_pool;
mod lattice;
mod look;
mod model;
mod near;
mod pages;
mod paint;
mod painted_factors;
mod reflection;
mod reshape;
mod rest_shape;
mod samples;
mod sheet;
mod skin;
mod state;
mod stiffness;
mod stitch;
mod surface_layer;
mod symmetry;
mod tint;

pub use broken_surface::ExposedFaces;
pub use cell_corners::CellCorners;
pub use discretization::Discretization;
pub use divide::{DivideError, Division};
pub use failed_triangles::FailedTriangles;
pub use fibres::{Curve, DirectionCloud, FibreEntry, FibreLines, FibrePart, Fibres};
pub use fields::{FieldSurface, Fields, Layer, factor_at};
pub use fixing::{Fixing, Place, displacement_along};
pub(crate) use folds::{Moves, Unfolded, Unresolved, limit_folds};
pub use grid_pool::{GridPool, PooledGrid};
pub use lattice::{
    BodyInterior, CellFragment, CellSource, ContactBuffers, ContactPoint, ContactSurface, Lattice, LatticeError,
    NodeBounds, NodeKey, RegionSettings, Repair, TetrahedralCells,
};
pub use look::{ABSENT, CAP, TriangleLook};
pub use model::{Model, Subdivision};
pub use pages::{PAGE, PageStamps};
pub use painted_factors::{FactorChange, PaintedFactors};
pub use reflection::{Axes, Reflection, mirrored};
pub use reshape::RestChange;
pub use rest_shape::{FlatPart, RestDifference, RestShape};
pub(crate) use samples::MAX_COLLECTED;
pub use samples::Samples;
pub use sheet::{Sheet, Warp};
pub use skin::{EmbeddedPoint, NOT_EMBEDDED, Skin, interpolate};
pub(crate) use skin::{NearestTriangle, nearest_triangle};
pub use state::BodyState;
pub use stiffness::StiffnessFactor;
pub use stitch::Stitched;
pub use surface_layer::PaintDepth;
pub use symmetry::{Symmetry, SymmetryPlane};
pub use tint::{PINNED_TINT, tint_of};

use cutting::CutMargins;

pub use pliant_cut::CutMesh;
use pliant_host::{HostError, Library, Material, ParamSettings};
use pliant_solver::{Pool, System, Vec3};
use std::sync::Arc;

/// What a material was opened with.
pub(crate) struct MaterialRecipe {
    pub(crate) library: &'static Library,
    /// Id of the plugin.
    pub(crate) id: String,
    pub(crate) settings: ParamSettings,
    /// Largest step, s.
    pub(crate) dt: f64,
}

impl MaterialRecipe {
    /// Opens the material once more.
    ///
    /// # Errors
    /// Those of [`Material::open`].
    fn open(&self) -> Result<Material, HostError> {
        Material::open(self.library, &self.id, &self.settings, self.dt)
    }
}

/// A body of a session, with its state.
pub struct Body {
    /// Name of the body in the scene.
    pub name: String,
    /// Number of the body in its session. A part of a body that was split has one of its own.
    pub(crate) number: u32,
    /// The model at rest; it changes only with a cut.
    pub model: Arc<Model>,
    /// The mesh that blades cut; `None` where no edit of the scene is a cut.
    pub cut: Option<Box<CutMesh>>,
    pub(crate) cut_margins: CutMargins,
    /// Present positions of the surface.
    pub skin: Skin,
    /// Nodes, elements and material.
    pub system: System,
    /// Plugin and parameters of the material, to open it once more for a part of the body.
    pub(crate) recipe: Arc<MaterialRecipe>,
    /// How the nodes are chosen, and how the surface follows them.
    pub discretization: Discretization,
    /// Points of the surface of a solid for contact with tools; empty where no tool touches it.
    pub samples: Arc<Samples>,
    /// N/m^3, stiffness of the elastic layer (Winkler bed) on the surface: force per depth and area
    pub layer_stiffness: f64,
    /// Mass of the nodes at the surface per area, kg/m^2; of a solid.
    pub layer_mass: f64,
    /// Parameters of the material that may vary over the body, in the order of their planes.
    pub params: Vec<String>,
    /// Largest ratio by which painting may raise stiffness over mass of any part; infinite where the integrator follows any.
    pub most_stiffening: f64,
    /// Triangles that have failed because the material says so.
    pub failed_triangles: FailedTriangles,
    /// Tints of pinned and painted vertices, for viewers.
    pub(crate) tints: tint::Tints,
    /// Nodes that are held or driven along a path.
    pub fixings: Vec<Fixing>,
    /// Pairs of vertices that edits with symmetry keep mirrored.
    pub symmetry: Option<Symmetry>,
    /// Reason why the body is in quarantine and no longer moves: its material failed or its state was no longer finite.
    pub frozen: Option<String>,
}

impl Body {
    /// Updates the position of every vertex that active nodes move: for a picture, a file or the end of a run. Steps update vertices
    /// near tools alone.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn update_skin(&mut self, pool: &Pool) -> Result<(), LatticeError> {
        self.embed_skin(pool)?;
        if let Some(symmetry) = &self.symmetry {
            symmetry.apply(&self.model, &mut self.skin);
        }
        self.skin.follow_welds(self.model.document.welds());
        Ok(())
    }

    /// Updates the positions as the nodes have them, without symmetry.
    fn embed_skin(&mut self, pool: &Pool) -> Result<(), LatticeError> {
        // The mean of a pair moves the one that no active node moves, too. Every vertex of a sheet is a node.
        if self.symmetry.is_some() && self.discretization.lattice().is_some() {
            self.skin.settle_inactive();
        }
        self.discretization.embed_all(pool, &self.system.nodes, &self.model, &mut self.skin)?;
        self.embed_exposed_faces();
        Ok(())
    }

    /// The shape was changed by no edit of a tool: what is now displaced on one side alone stays so.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(crate) fn find_one_sided(&mut self, pool: &Pool) -> Result<(), LatticeError> {
        if self.symmetry.is_none() {
            return Ok(());
        }
        self.embed_skin(pool)?;
        if let Some(symmetry) = &mut self.symmetry {
            symmetry.find_one_sided(&self.model, &self.skin);
        }
        Ok(())
    }

    /// Vertices no longer have mirror images. They are from now on where the nodes have them, as an undo of later edits will find them.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(crate) fn end_symmetry(&mut self, pool: &Pool) -> Result<(), LatticeError> {
        let embedded = if self.symmetry.is_some() { self.embed_skin(pool) } else { Ok(()) };
        self.symmetry = None;
        embedded
    }

    /// Makes the present shape the rest shape, with zero velocity. The surface of a solid is unfolded first, unless that moves a vertex by more than `most` (m) or
    /// leaves folds. Returns what was unfolded, or how many folds are left.
    ///
    /// # Errors
    /// Returns the error of the grid plugin, or of the material if it refuses the new rest shape.
    pub(crate) fn keep(&mut self, pool: &Pool, most: f64) -> Result<Unfolded, LatticeError> {
        self.update_skin(pool)?;
        let unfolded = if self.discretization.lattice().is_some() { self.unfold(most) } else { Unfolded::default() };
        let Self { model, skin, system, discretization, .. } = self;
        discretization.keep(model, skin, system)?;
        if self.symmetry.is_some() && self.discretization.lattice().is_some() {
            self.skin.keep_inactive(&self.model);
        }
        Ok(unfolded)
    }

    /// Moves vertices of the present surface by up to `most` (m) each so that no edge is folded that was not at rest, or none of them.
    fn unfold(&mut self, most: f64) -> Unfolded {
        let Skin { x, settled, cell, .. } = &mut self.skin;
        let pairs = x.iter().zip(settled.iter()).zip(cell.iter()).enumerate();
        let moved = pairs.filter(|(_, ((x, settled), cell))| **cell != NOT_EMBEDDED && x != settled);
        let mut moves: Moves = moved.map(|(v, ((x, settled), _))| (v as u32, x - settled)).collect();
        let before = moves.clone();
        let unfolded = limit_folds(&self.model, settled, cell, &mut moves, Unresolved::Leave);
        if unfolded.left > 0 || unfolded.moved > most {
            return Unfolded { edges: 0, left: unfolded.edges, moved: 0.0, place: unfolded.place };
        }
        for ((v, d), _) in moves.iter().zip(&before).filter(|(now, before)| now != before) {
            x[*v as usize] = settled[*v as usize] + d;
        }
        unfolded
    }

    /// Has viewers that have looked at `other` copy all of this body, which is shown in its place.
    pub(crate) fn take_place_of(&mut self, other: &Self) {
        self.skin.pages.take_place_of(&other.skin.pages, self.skin.x.len());
        let count = self.model.surface.triangles.len();
        Arc::make_mut(&mut self.model).pages.take_place_of(&other.model.pages, count);
    }

    /// Position of a point of the rest shape (m) in the present shape. A point outside of all active elements keeps its place.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_point(&self, point: Vec3) -> Result<EmbeddedPoint, LatticeError> {
        self.discretization.embed_point(point, &self.model, &self.skin, &self.system.nodes)
    }

    /// Estimate of the memory of the body, bytes: its largest arrays.
    pub fn bytes(&self) -> usize {
        let nodes = self.system.nodes.len() * 200;
        let elements: usize = self.system.sets.iter().map(|s| s.count() * 40).sum();
        let matrix = self.system.matrix.as_ref().map_or(0, pliant_solver::Matrix::bytes);
        nodes + elements + matrix + self.model.bytes() + self.discretization.bytes()
    }
}
