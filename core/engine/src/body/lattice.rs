//! A lattice: the discretization of a solid by cells, all of them or a local region around contacts. Cells are cubes of a grid plugin, each divided into
//! tetrahedra, or the tetrahedra of a file, which are simulated as a whole.
//!
//! A local region (Qi, Zhu and Fan 2019) has the cells around each contact, and cells that contacts have left and that are not yet back at
//! rest. Nodes near a contact are free. Nodes on the border of the region, and nodes that contacts have left, return to their rest positions
//! along a critically damped path before they are released, so the surface has no jump in time. The cost of a step depends on the size of
//! the region and not on the size of the model.
//!
//! A material with a history, such as clay, has displaced nodes in equilibrium. Then the region keeps every displaced cell, its nodes stay
//! free, and border nodes are fixed where they are.

mod bounds;
mod cell_source;
mod contact_points;
mod cut;
mod deformation;
mod directions;
mod embed;
mod exposed_faces;
mod face_table;
mod failed_cells;
mod fields;
mod fragments;
mod heal;
mod history;
mod hold;
mod majority;
mod momentum;
mod paint;
mod parts;
mod point_bindings;
mod region;
mod reshape;
mod rest_offsets;
mod smooth;
mod state;
mod surface_parts;
mod tetrahedral_cells;
mod torn_triangles;
mod untangle;

use super::fibres::Fibres;
use super::fields::Fields;
use super::fixing::Fixing;
use super::stiffness::StiffnessFactor;
pub use bounds::NodeBounds;
pub use cell_source::CellSource;
pub use contact_points::{ContactBuffers, ContactPoint, ContactSurface};
pub(in crate::body) use exposed_faces::{BrokenSurface, ExposedCorner, NodePlace};
use failed_cells::FailedCells;
use fragments::Fragments;
pub use fragments::{BodyInterior, CellFragment, NodeKey, VoxelParts};
use paint::LatticePaint;
pub(in crate::body) use parts::{LatticeComponents, LatticePart, PartCells};
use pliant_host::{HostError, Region};
use pliant_mesh::Surface;
use pliant_plugin_api::abi::{self, Ball, Level};
use pliant_solver::ForceError;
use pliant_solver::{Constraint, Nodes, StepTime, System, Vec3};
use point_bindings::PointBindings;
pub(in crate::body) use rest_offsets::{RestOffset, RestOffsets};
use smooth::SmoothEmbedding;
pub use state::LatticeState;
pub use tetrahedral_cells::TetrahedralCells;
pub use untangle::Repair;

use std::collections::HashMap;
use std::sync::Arc;
use thiserror::Error;

/// Settings of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionSettings {
    /// Grid level of the cells; 1 is the root.
    pub level: u32,
    /// Radius around a contact within which cells are active, m; infinite for the whole body.
    pub radius: f64,
    /// Time constant with which nodes that contacts have left return to rest, s.
    pub relaxation: f64,
    /// Whether the surface follows the nodes with continuous slopes; only where the weights of the grid are trilinear.
    pub smooth: bool,
}

/// Error of the discretization of a body.
#[derive(Debug, Error)]
pub enum LatticeError {
    /// A call to the grid or material plugin failed.
    #[error(transparent)]
    Host(#[from] HostError),
    /// The contact law of a tool failed on a body, given by its index.
    #[error("{error}")]
    ContactLaw {
        /// Index of the body.
        body: u32,
        /// Why it failed.
        error: Box<HostError>,
    },
    /// The material refused its elements.
    #[error(transparent)]
    Force(#[from] ForceError),
    /// The material needs a kind of element that the discretization does not have.
    #[error(
        "material `{material}` wants {wanted}, which a {discretization} does not give; grids give points, links and tetrahedra, sheets (`sheet = {{}}` in the body) points, links, \
         triangles and hinges, tetrahedral meshes points and tetrahedra"
    )]
    Unsupported {
        /// `grid`, `sheet` or `tetrahedral mesh`.
        discretization: &'static str,
        /// Id of the material.
        material: String,
        /// The kind of element.
        wanted: &'static str,
    },
    /// A node has no positive finite mass.
    #[error("{origin}: node {node} at {at:?} m has mass {mass} kg; allowed is a finite mass above 0")]
    Massless {
        /// The material and its file.
        origin: String,
        /// Number of the node.
        node: usize,
        /// Rest position of the node, m.
        at: [f64; 3],
        /// Its mass, kg.
        mass: f64,
    },
    /// A region that has grown to more cells than there is memory for.
    #[error("a region of {cells} cells; allowed is {most} in the memory of the session, which `--memory SIZE` changes")]
    Memory {
        /// Number of cells of the region.
        cells: usize,
        /// Largest allowed number.
        most: usize,
    },
    /// No cell of the level is occupied.
    #[error("level {level} of the grid has no occupied cell")]
    Empty {
        /// The level of the settings.
        level: u32,
    },
}

/// The discretization of a solid.
pub struct Lattice {
    /// Where its cells come from.
    pub source: CellSource,
    /// What names the model and all settings the cells were made with.
    pub key: String,
    /// Level and region.
    pub settings: RegionSettings,
    /// Facts about the level of the grid, or about the tetrahedra.
    pub facts: Level,
    /// Largest number of active cells that there is memory for.
    pub most_cells: usize,
    /// Families of links that the material uses, as a bit mask.
    families: u32,
    /// Active nodes and cells.
    region: Region,
    /// The next region while it is made, then the one before.
    spare: Region,
    /// For a body with cuts, the active nodes and cells of the grid before cells are replaced by fragments.
    grid_region: Region,
    /// Balls around contacts for which the region was made.
    contact_balls: Vec<Ball>,
    /// The last such balls that were not empty.
    last_contact_balls: Vec<Ball>,
    /// Whether the contact balls take in so much of the body that all of it is active.
    is_nearly_whole: bool,
    /// Points of the rest shape that hands grip, m; empty unless there are two or more.
    grips: Vec<Vec3>,
    /// Two grips (m) in regions that do not meet, so that what is between them stays at rest.
    pub grips_apart: Option<[Vec3; 2]>,
    /// The grips have changed: constraints must be made again.
    has_new_grips: bool,
    /// Whether the material has history variables.
    has_history: bool,
    /// Whether displaced cells stay active and nodes do not return to rest: the material has a history, or pins hold nodes away from rest.
    keeps_displaced: bool,
    /// Pins and painted factors.
    paint: LatticePaint,
    /// Active nodes that pins hold (n); empty without pins.
    pinned: Vec<bool>,
    /// Fields of parameters of the material.
    pub fields: Option<Arc<Fields>>,
    /// Directions of fibres, if the material takes them and the scene gives them.
    pub fibres: Option<Arc<Fibres>>,
    /// Factor of the material's stiffness; `None` if the material has none that may change.
    pub stiffness: Option<StiffnessFactor>,
    /// Factors of cells by id; evaluated on first use.
    factors_of_cell: HashMap<u64, Arc<[f64]>>,
    /// Directions of the fibres of cells by id, in the undeformed grid; evaluated on first use.
    direction_of_cell: HashMap<u64, Vec3>,
    /// Nodes whose velocity returns them to rest.
    returning: Vec<u32>,
    driven: Vec<DrivenNode>,
    /// Nodes whose rest positions edits have moved.
    rest_offsets: RestOffsets,
    /// Cells that blades have cut.
    fragments: Fragments,
    /// Surface points that a cut has made or moved to another cell.
    bindings: PointBindings,
    /// A cut has changed cells: the region must be made again.
    needs_rebuild: bool,
    /// First row of `weights` of each active cell, or [`NO_WEIGHTS`] (c).
    weights_of: Vec<u32>,
    /// Trilinear weights of the surface points of a cell at its corners; computed on first use.
    weights: Vec<[f64; 8]>,
    /// Longest edge of the surface at a vertex embedded in each active cell, m (c).
    longest_edge_of: Vec<f64>,
    scratch: embed::Scratch,
    /// Embedding with continuous slopes; `None` where the surface follows the grid's weights.
    smooth: Option<Box<SmoothEmbedding>>,
    /// Whether the weights of the grid have been checked to be trilinear.
    is_grid_checked: bool,
    /// Steps since the region was last made.
    steps: u32,
    /// Tetrahedra that have failed.
    failed: FailedCells,
    /// The surface that the grid was built around, if that is not the one of the model's file: of a part of a body that was split.
    built_around: Option<Arc<Surface>>,
}

/// A node that moves along the path of a fixing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct DrivenNode {
    pub node: u32,
    /// Index in the list of fixings.
    pub fixing: u32,
}

/// Value of `weights_of` for a cell whose weights have not been computed.
const NO_WEIGHTS: u32 = u32::MAX;

impl Lattice {
    /// A lattice of the cells of a grid that was built around a model, or of tetrahedra, without active nodes. `families` is the mask of links that the material
    /// uses, `key` names the model and all settings the cells were made with.
    ///
    /// # Errors
    /// Returns the error of the grid plugin; [`LatticeError::Empty`] if the level has no occupied cell.
    pub fn new(source: CellSource, key: String, settings: RegionSettings, families: u32) -> Result<Self, LatticeError> {
        let facts = source.level(settings.level)?;
        if facts.surface_cells + facts.inside_cells == 0 {
            return Err(LatticeError::Empty { level: settings.level });
        }
        // Slopes are continued along the axes of cubes.
        let is_smooth = settings.smooth && !source.is_nonlinear() && source.tetrahedra().is_none();
        let smooth = is_smooth.then(Box::default);
        Ok(Self {
            source,
            key,
            settings,
            facts,
            most_cells: usize::MAX,
            families,
            region: Region::default(),
            spare: Region::default(),
            grid_region: Region::default(),
            contact_balls: Vec::new(),
            last_contact_balls: Vec::new(),
            is_nearly_whole: false,
            grips: Vec::new(),
            grips_apart: None,
            has_new_grips: false,
            has_history: false,
            keeps_displaced: false,
            paint: LatticePaint::default(),
            pinned: Vec::new(),
            fields: None,
            fibres: None,
            stiffness: None,
            factors_of_cell: HashMap::new(),
            direction_of_cell: HashMap::new(),
            returning: Vec::new(),
            driven: Vec::new(),
            rest_offsets: RestOffsets::new(),
            fragments: Fragments::new(facts.edge),
            bindings: PointBindings::default(),
            needs_rebuild: false,
            weights_of: Vec::new(),
            weights: Vec::new(),
            longest_edge_of: Vec::new(),
            scratch: embed::Scratch::default(),
            smooth,
            is_grid_checked: false,
            steps: 0,
            failed: FailedCells::default(),
            built_around: None,
        })
    }

    /// Whether the whole body is simulated.
    pub fn is_whole(&self) -> bool {
        self.settings.radius == f64::INFINITY
    }

    /// Active nodes and cells.
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// Edge of a cell, m.
    pub fn edge(&self) -> f64 {
        self.facts.edge
    }

    /// Longest edge of the surface at a vertex embedded in an active cell, m.
    pub fn longest_edge(&self, cell: u32) -> f64 {
        self.longest_edge_of[cell as usize]
    }

    /// Prescribes the velocity of driven and returning nodes for a step.
    pub fn prescribe(&self, nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
        let (dt, rate) = (time.dt, 1.0 / self.settings.relaxation);
        for &node in &self.returning {
            let i = node as usize;
            // u'' = -2 w u' - w^2 u, critically damped, by implicit Euler: stable for any step, without overshoot.
            let u = nodes.x[i] - nodes.rest[i];
            let slowed = (1.0 + rate * dt).powi(2);
            nodes.prescribed[i] = (nodes.v[i] - dt * rate * rate * u) / slowed;
        }
        drive_fixed(&self.driven, nodes, fixings, time);
    }

    /// Estimate of the memory, bytes: the largest arrays.
    pub fn bytes(&self) -> usize {
        let occupied = (self.facts.surface_cells + self.facts.inside_cells) as usize;
        let links = 2 * self.region.link_family.capacity() + self.grid_region.link_family.capacity();
        let source = self.source.tetrahedra().map_or(occupied * 16, |cells| cells.bytes());
        source + self.weights.len() * 64 + links * 20
    }
}

/// Constrains the nodes that fixings hold. Returns those that move along a path. `number` gives the number by which fixings know a node.
pub(super) fn constrain_fixed(fixings: &[Fixing], nodes: &mut Nodes, number: impl Fn(u32) -> u32) -> Vec<DrivenNode> {
    let mut driven = Vec::new();
    for i in 0..nodes.len() {
        if let Some(fixing) = fixings.iter().position(|f| f.place.contains(number(i as u32), nodes.rest[i])) {
            nodes.constraint[i] = Constraint::Fixed;
            if fixings[fixing].moves() {
                driven.push(DrivenNode { node: i as u32, fixing: fixing as u32 });
            }
        }
    }
    driven
}

/// Prescribes the mean velocity of driven nodes over a step.
pub(super) fn drive_fixed(driven: &[DrivenNode], nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
    for &DrivenNode { node, fixing } in driven {
        let fixing = &fixings[fixing as usize];
        let (from, to) = (fixing.displacement(time.start), fixing.displacement(time.end()));
        nodes.prescribed[node as usize] = (to - from) / time.dt;
    }
}

/// Returns [`LatticeError::Massless`] for the first node without a finite mass above zero.
pub(super) fn check_mass(system: &System) -> Result<(), LatticeError> {
    let Some(node) = system.massless() else { return Ok(()) };
    let (at, mass) = (system.nodes.rest[node].into(), system.nodes.mass[node]);
    Err(LatticeError::Massless { origin: system.material.origin(), node, at, mass })
}

/// Name of a kind of element in messages.
///
/// # Panics
/// For a number that is no kind.
pub(super) fn kind_name(kind: u32) -> &'static str {
    match kind {
        abi::POINT => "points",
        abi::LINK => "links",
        abi::TRIANGLE => "triangles",
        abi::HINGE => "hinges",
        abi::TETRAHEDRON => "tetrahedra",
        kind => unreachable!("the host opens no material with elements of kind {kind}"),
    }
}
