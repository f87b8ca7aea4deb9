//! Estimates of the memory of a body from counts that are known before it is allocated.
//!
//! Constants are bytes for each item of all lists that hold it, with the unused capacity of lists that grow, rounded up; they were measured on
//! boxes, spheres and sheets, and `tests/tests/memory.rs` holds them to the peak memory of runs.

use crate::body::MAX_COLLECTED;
use pliant_mesh::tetrahedra::PARTS;
use pliant_mesh::{ObjDocument, Surface};
use pliant_plugin_api::ElementRequest;
use pliant_plugin_api::abi::{self, Level};
use serde::Serialize;

/// The program, its plugins and threads without any body, bytes: all pages of a debug build (18 MB), system libraries (3 MB) and 3 MB of its
/// own. How many of those pages are resident is the system's choice and differs from machine to machine.
pub(super) const PROGRAM_BYTES: u64 = 24_000_000;
/// Bytes for each byte of a model's file: the text, and the least that its lines become.
const FILE_BYTE: u64 = 3;
/// Bytes for each vertex and triangle of a model: document, surface, adjacency, tree, skin.
const VERTEX: u64 = 200;
const TRIANGLE: u64 = 450;
/// Bytes of text for each triangle of a generated shape.
const SHAPE_TEXT: u64 = 60;
/// Bytes for each cube of the finest level of a grid, occupied or not; foreign grids are taken to need as much.
const CUBE: f64 = 5.0;
/// Samples of the surface for each square of a third of a cell: a tilted plane passes through up to 1.73 boxes for each such square.
const SAMPLES_PER_SQUARE: f64 = 1.73;
/// Bytes for each sample, and for each piece of a triangle before pieces are merged.
const SAMPLE: f64 = 180.0;
const PIECE: f64 = 80.0;
/// Bytes for each node of the region: state, lists of the region, vectors of the integrator, the smooth embedding.
const NODE: f64 = 1000.0;
/// Bytes for each node of an implicit scheme: 14 blocks of its row in double and single precision, the multilevel hierarchy, vectors of the solver.
const IMPLICIT_NODE: f64 = 4200.0;
/// Bytes for each link in the lists of the region.
const LINK: f64 = 60.0;
/// Families of links with the number of links that a node has, one direction each.
const LINKS_OF_NODE: [(u32, f64); 4] =
    [(abi::STRUCTURAL, 3.0), (abi::SHEAR, 6.0), (abi::FLEXION, 3.0), (abi::BODY_DIAGONAL, 4.0)];
/// Bytes for each triangle of a sheet with its nodes and hinges, by an explicit and by an implicit scheme.
const SHEET_TRIANGLE: u64 = 1000;
const IMPLICIT_SHEET_TRIANGLE: u64 = 3600;

/// Bytes for each node and each tetrahedron of a file: as they are read, sorted by their faces, and as cells with their boxes.
const NODE_OF_FILE: u64 = 150;
const TETRAHEDRON_OF_FILE: u64 = 400;

/// Estimate of the memory of a body by its parts, bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BodyMemory {
    /// Name of the body.
    pub body: String,
    /// The document, its surface and what follows from it.
    pub model: u64,
    /// The levels of the grid.
    pub grid: u64,
    /// Samples of the surface for contact.
    pub samples: u64,
    /// Nodes, elements and the solver.
    pub elements: u64,
}

impl BodyMemory {
    /// Sum of the parts, bytes.
    pub fn total(&self) -> u64 {
        [self.grid, self.samples, self.elements].into_iter().fold(self.model, u64::saturating_add)
    }
}

/// Memory of the program with these bodies, bytes.
pub(crate) fn total(bodies: &[BodyMemory]) -> u64 {
    bodies.iter().map(BodyMemory::total).fold(PROGRAM_BYTES, u64::saturating_add)
}

/// Least memory of the model in a file of this size, bytes.
pub(crate) fn file_bytes(size: u64) -> u64 {
    size.saturating_mul(FILE_BYTE)
}

/// Memory of the model of a document, bytes.
pub(crate) fn document_bytes(document: &ObjDocument) -> u64 {
    let triangles: usize = document.faces().map(|face| face.corners.len().saturating_sub(2)).sum();
    2 * document.bytes().len() as u64 + VERTEX * document.positions().len() as u64 + TRIANGLE * triangles as u64
}

/// Memory of the model of a shape that is generated with this many triangles, bytes.
pub(crate) fn shape_bytes(triangles: u64) -> u64 {
    triangles.saturating_mul(TRIANGLE + VERTEX / 2 + 2 * SHAPE_TEXT)
}

/// Memory of a grid up to `level`, bytes.
pub(crate) fn grid_bytes(level: u32) -> u64 {
    // The largest float that fits stands for all above.
    (CUBE * 8.0_f64.powi(level.saturating_sub(1).min(1000) as i32)) as u64
}

/// Memory of the samples of a surface in cells with this edge, m, bytes: the pieces of its triangles before they are merged, and the samples.
pub(crate) fn sample_bytes(surface: &Surface, edge: f64) -> u64 {
    let size = edge / 3.0;
    let pieces = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| surface.points[v as usize]);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let squares = 0.5 * (b - a).cross(&(c - a)).norm() / (size * size);
        // A sliver has a row of pieces along its longest edge, other triangles two for each square.
        1.0 + longest / size + 2.0 * squares
    };
    let pieces: f64 = surface.triangles.iter().map(pieces).sum();
    let squares = surface.areas().iter().sum::<f64>() / (size * size);
    (PIECE * pieces.min(MAX_COLLECTED as f64) + SAMPLE * SAMPLES_PER_SQUARE * squares) as u64
}

/// Memory of a sheet's nodes, elements and solver, bytes.
pub(crate) fn sheet_bytes(triangles: u64, implicit: bool) -> u64 {
    triangles.saturating_mul(if implicit { IMPLICIT_SHEET_TRIANGLE } else { SHEET_TRIANGLE })
}

/// Memory of a tetrahedral mesh of a file, bytes: numbers and positions of its nodes; corners, tags, volumes and boxes of its tetrahedra, and its faces while it is read.
pub(crate) fn tetrahedra_bytes(nodes: u64, tetrahedra: u64) -> u64 {
    nodes.saturating_mul(NODE_OF_FILE).saturating_add(tetrahedra.saturating_mul(TETRAHEDRON_OF_FILE))
}

/// Number of tetrahedra into which a cube is divided.
pub(crate) const TETRAHEDRA_OF_CUBE: f64 = 5.0;

/// What a simulated cell takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellCosts {
    /// Bytes for each node and for each cell without its nodes.
    per_node: f64,
    per_cell: f64,
}

impl CellCosts {
    /// The costs of a material with these requests, in cells of this many tetrahedra, with a matrix if `implicit`.
    pub(crate) fn new(requests: &[ElementRequest], tetrahedra: f64, implicit: bool) -> Self {
        let families = requests.iter().fold(0, |all, r| all | r.families);
        let mut costs = Self { per_node: NODE + LINK * links_of_node(families), per_cell: 150.0 };
        if implicit {
            costs.per_node += IMPLICIT_NODE;
        }
        for request in requests {
            let corners = request.corners() as f64;
            let numbers = 2.0 + f64::from(request.rest_stride) + 3.0 * f64::from(request.history_stride);
            // Lists grow to at most twice their length; half of that on the average.
            let element = 1.5 * (4.0 * corners + 8.0 * numbers);
            let map = if implicit { 4.0 * corners * corners } else { 0.0 };
            match request.kind {
                abi::POINT => costs.per_node += element + map,
                abi::LINK => costs.per_node += links_of_node(request.families) * (element + map),
                abi::TETRAHEDRON if request.flags & abi::INNER_TETRAHEDRON != 0 => costs.per_cell += element + map,
                abi::TETRAHEDRON => costs.per_cell += tetrahedra * (element + map),
                abi::TRIANGLE | abi::HINGE => {} // a solid refuses them when it lists its elements
                kind => unreachable!("the host opens no material with elements of kind {kind}"),
            }
        }
        costs
    }

    /// The costs where elements have ten nodes each, and a cell is an eighth of one: rows of the matrix have twice as many blocks, and lists have the slots of the
    /// pairs of ten nodes and what takes the place of nodes in calls of the material.
    pub(crate) fn of_quadratic_tetrahedra(requests: &[ElementRequest], parts: usize, implicit: bool) -> Self {
        let parts = parts as f64 / PARTS as f64;
        let mut costs = Self::new(requests, parts, implicit);
        if implicit {
            costs.per_node += IMPLICIT_NODE;
            costs.per_cell += 1.5 * 4.0 * 55.0 / PARTS as f64;
        }
        costs.per_cell += 1.5 * 4.0 * (14.0 * parts + 10.0 / PARTS as f64);
        costs
    }

    /// Bytes for each simulated cell of a level with its share of the nodes.
    pub(crate) fn per_simulated_cell(&self, facts: &Level) -> f64 {
        let nodes = facts.nodes as f64 / ((facts.surface_cells + facts.inside_cells).max(1)) as f64;
        self.per_cell + nodes * self.per_node
    }
}

/// Number of links of a node, of these families.
fn links_of_node(families: u32) -> f64 {
    LINKS_OF_NODE.iter().filter(|(family, _)| families & family != 0).map(|(_, links)| links).sum()
}
