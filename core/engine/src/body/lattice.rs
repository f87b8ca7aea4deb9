//! The nodes that carry a body, from a grid plugin: all of them, or those around the hand.
//!
//! A local region is the cells around each contact, and those the hand has left that are not yet back at rest. Nodes near
//! a contact move freely; nodes on the region's border, and those the hand has left, return to their rest positions along a
//! critically damped path and are then given up, so nothing ever snaps (Qi, Zhu and Fan 2019 leave this open). Cost grows
//! with the region, never with the model.
//!
//! Of a material with a history, such as clay, what is displaced does not belong at rest. There the region keeps every cell that is
//! displaced, free to find its equilibrium, and nodes that must be held are held where they are.

mod bound;
mod bounds;
mod cut;
mod embed;
mod fields;
mod fragments;
mod history;
mod hold;
mod keep;
mod mend;
mod region;
mod reshape;
mod smooth;
mod state;
mod strays;
mod untangle;

use super::fields::Fields;
use super::fixing::Fixing;
use super::grid_pool::PooledGrid;
use bound::Bound;
pub use bounds::NodeBounds;
pub use fragments::Inner;
use fragments::{Fragments, NodeKey};
use pliant_host::{HostError, Region};
use pliant_plugin_api::abi::{self, Ball, Level};
use pliant_solver::ForceError;
use pliant_solver::{Constraint, Nodes, StepTime, System, Vec3};
use smooth::{Jet, SmoothEmbedding};
pub use state::LatticeState;
pub use untangle::Repair;

use std::collections::HashMap;
use std::sync::Arc;
use thiserror::Error;

/// How much of a body is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionSettings {
    /// Level of the grid, 1 the root.
    pub level: u32,
    /// m; infinite: the whole body
    pub radius: f64,
    /// s, time constant of the return to rest of what the hand has left
    pub relaxation: f64,
    /// Whether the surface follows the nodes with continuous slopes, where the weights of the grid are trilinear.
    pub smooth: bool,
}

/// Why a body cannot be carried.
#[derive(Debug, Error)]
pub enum LatticeError {
    /// The grid or the material failed.
    #[error(transparent)]
    Host(#[from] HostError),
    /// The material failed.
    #[error(transparent)]
    Force(#[from] ForceError),
    /// A material wants what its discretization does not give.
    #[error("material `{material}` wants {wanted}, which a {discretization} does not give")]
    Unsupported {
        /// grid or sheet
        discretization: &'static str,
        /// Id of the material.
        material: String,
        /// The kind of element.
        wanted: &'static str,
    },
    /// A node without mass.
    #[error("{origin}: node {node} at {at:?} m has mass {mass} kg; allowed is a finite mass above 0")]
    Massless {
        /// The material and its file.
        origin: String,
        /// Number of the node.
        node: usize,
        /// m, its rest position
        at: [f64; 3],
        /// What the material gave it.
        mass: f64,
    },
    /// No cell of the level is occupied.
    #[error("level {level} of the grid has no occupied cell")]
    Empty {
        /// The level that was asked for.
        level: u32,
    },
}

/// The discretization of a body.
pub struct Lattice {
    /// The grid plugin.
    pub grid: PooledGrid,
    /// How much is simulated.
    pub settings: RegionSettings,
    /// Facts about the working level.
    pub facts: Level,
    families: u32,
    region: Region,
    spare: Region,
    /// Of a body with cuts, the region as the grid has it.
    uncut: Region,
    balls: Vec<Ball>,
    /// The last contacts there were.
    last_balls: Vec<Ball>,
    /// Whether the material has a history: what has flowed stays active, and nothing is brought back to rest.
    keeps_shape: bool,
    /// Parameters of the material that differ from place to place.
    pub fields: Option<Arc<Fields>>,
    /// Factors of cells by their id, as far as they were asked for.
    factors_of_cell: HashMap<u64, Arc<[f64]>>,
    /// Nodes on their way back to rest, or there.
    returning: Vec<u32>,
    /// Nodes that are driven, and by which fixing.
    driven: Vec<(u32, u32)>,
    /// Where the rest positions of nodes were moved by keeping shapes
    kept: HashMap<NodeKey, Kept>,
    /// What a blade has cut.
    fragments: Fragments,
    /// Points of the surface that a cut has made or moved to another cell.
    bound: Bound,
    /// The cells must be listed anew.
    stale: bool,
    /// First of each cell's weights, or `NO_WEIGHTS` (c)
    weights_of: Vec<u32>,
    weights: Vec<[f64; 8]>,
    /// m, the longest edge at a vertex of each cell (c)
    edge_of: Vec<f64>,
    scratch: embed::Scratch,
    /// How the surface follows the nodes; `None`: as the grid says.
    smooth: Option<Box<SmoothEmbedding>>,
    /// Whether the grid's weights were looked at.
    is_probed: bool,
    steps: u32,
}

/// What shapes that were kept have done to a node.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// Displacement of its rest position, m.
    moved: Vec3,
    /// Jet of the surface there, as it was when the shapes were kept: a cut beside it changes how the surface follows, not where it is.
    jet: Jet,
}

const NO_WEIGHTS: u32 = u32::MAX;

impl Lattice {
    /// A body on a grid that was built around its model. No node is active yet.
    ///
    /// # Errors
    /// What the grid says; a level without an occupied cell.
    pub fn new(grid: PooledGrid, settings: RegionSettings, families: u32) -> Result<Self, LatticeError> {
        let facts = grid.level(settings.level)?;
        if facts.surface_cells + facts.inside_cells == 0 {
            return Err(LatticeError::Empty { level: settings.level });
        }
        let smooth = (settings.smooth && !grid.is_nonlinear()).then(Box::default);
        Ok(Self {
            grid,
            settings,
            facts,
            families,
            region: Region::default(),
            spare: Region::default(),
            uncut: Region::default(),
            balls: Vec::new(),
            last_balls: Vec::new(),
            keeps_shape: false,
            fields: None,
            factors_of_cell: HashMap::new(),
            returning: Vec::new(),
            driven: Vec::new(),
            kept: HashMap::new(),
            fragments: Fragments::new(facts.edge),
            bound: Bound::default(),
            stale: false,
            weights_of: Vec::new(),
            weights: Vec::new(),
            edge_of: Vec::new(),
            scratch: embed::Scratch::default(),
            smooth,
            is_probed: false,
            steps: 0,
        })
    }

    /// Whether the whole body is simulated.
    pub fn is_whole(&self) -> bool {
        self.settings.radius == f64::INFINITY
    }

    /// Nodes and cells that are active now.
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// m, the edge of a cell.
    pub fn edge(&self) -> f64 {
        self.facts.edge
    }

    /// m, the longest edge of the surface at a vertex of an active cell.
    pub fn longest_edge(&self, cell: u32) -> f64 {
        self.edge_of[cell as usize]
    }

    /// Sets what driven and returning nodes do in a step.
    pub fn prescribe(&self, nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
        let (dt, rate) = (time.dt, 1.0 / self.settings.relaxation);
        for &node in &self.returning {
            let i = node as usize;
            // u'' = -2 w u' - w^2 u, implicitly: stable at any step, and u goes to zero without passing it.
            let u = nodes.x[i] - nodes.rest[i];
            let slowed = (1.0 + rate * dt).powi(2);
            nodes.prescribed[i] = (nodes.v[i] - dt * rate * rate * u) / slowed;
        }
        drive_fixed(&self.driven, nodes, fixings, time);
    }

    /// Bytes of the largest parts.
    pub fn bytes(&self) -> usize {
        let occupied = (self.facts.surface_cells + self.facts.inside_cells) as usize;
        let links = 2 * self.region.link_family.capacity() + self.uncut.link_family.capacity();
        occupied * 16 + self.weights.len() * 64 + links * 20
    }
}

/// Constrains the nodes that fixings hold, by their number and rest position. Returns those that move along a path, each with its
/// fixing.
pub(super) fn constrain_fixed(fixings: &[Fixing], nodes: &mut Nodes, number: impl Fn(u32) -> u32) -> Vec<(u32, u32)> {
    let mut driven = Vec::new();
    for i in 0..nodes.len() {
        if let Some(fixing) = fixings.iter().position(|f| f.place.holds(number(i as u32), nodes.rest[i])) {
            nodes.constraint[i] = Constraint::Fixed;
            if fixings[fixing].moves() {
                driven.push((i as u32, fixing as u32));
            }
        }
    }
    driven
}

/// Prescribes the velocity of nodes that move along a path.
pub(super) fn drive_fixed(driven: &[(u32, u32)], nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
    for &(node, fixing) in driven {
        let fixing = &fixings[fixing as usize];
        let (from, to) = (fixing.displacement(time.start), fixing.displacement(time.end()));
        nodes.prescribed[node as usize] = (to - from) / time.dt;
    }
}

/// Refuses a node without a finite mass above zero.
pub(super) fn check_mass(system: &System) -> Result<(), LatticeError> {
    let Some(node) = system.massless() else { return Ok(()) };
    let (at, mass) = (system.nodes.rest[node].into(), system.nodes.mass[node]);
    Err(LatticeError::Massless { origin: system.material.origin(), node, at, mass })
}

/// What an element kind is called.
fn kind_name(kind: u32) -> &'static str {
    match kind {
        abi::POINT => "points",
        abi::LINK => "links",
        abi::TRIANGLE => "triangles",
        abi::HINGE => "hinges",
        _ => "tetrahedra",
    }
}
