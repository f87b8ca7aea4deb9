//! What a viewer is shown: surfaces and tools of a session at one time.

use pliant_engine::body::{PAGE, TriangleLook};
use pliant_engine::session::ToolFrame;
use pliant_solver::Vec3;
use std::sync::Arc;

/// Surfaces and tools of a session at one time. A viewer that has seen an earlier frame finds what has changed since by
/// [`BodyView::changed_after`].
#[derive(Clone, Debug, Default)]
pub struct ViewFrame {
    /// Number of the frame, from 1; 0: nothing was published yet.
    pub number: u64,
    /// s, simulated time
    pub time: f64,
    /// Number of steps the simulation had taken.
    pub steps: u64,
    /// Bodies that move, in the order of the session.
    pub bodies: Vec<BodyView>,
    /// The tools in the order of the session.
    pub tools: Vec<ToolFrame>,
    /// Nodes that are simulated.
    pub nodes: usize,
    /// Elements that are simulated.
    pub elements: usize,
    /// Corners of the simulated cells of all bodies in metres of the scene (c x 8), where a viewer has asked for them.
    pub cells: Vec<[[f32; 3]; 8]>,
}

/// The surface of one body.
#[derive(Clone, Debug, Default)]
pub struct BodyView {
    /// m, place of the scene that positions are relative to
    pub origin: Vec3,
    /// m (n x 3), vertices relative to the origin
    pub positions: Vec<[f32; 3]>,
    /// m (n), distance of each vertex from its place at rest
    pub displacements: Vec<f32>,
    /// Number of topology patches that come before this frame.
    pub patches: u64,
    /// Frame in which each page of [`PAGE`] vertices last changed.
    pub(super) stamps: Vec<u64>,
}

impl BodyView {
    /// A surface of which every page changed in the frame `number`.
    pub fn of_positions(origin: Vec3, positions: Vec<[f32; 3]>, number: u64) -> Self {
        let (displacements, stamps) = (vec![0.0; positions.len()], vec![number; positions.len().div_ceil(PAGE)]);
        Self { origin, positions, displacements, patches: 0, stamps }
    }

    /// Ranges of vertices that have changed after the frame of this number, in whole pages, rising.
    pub fn changed_after(&self, frame: u64) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let count = self.positions.len();
        let pages = self.stamps.iter().enumerate().filter(move |(_, stamp)| **stamp > frame);
        pages.map(move |(page, _)| page * PAGE..((page + 1) * PAGE).min(count)).filter(|range| !range.is_empty())
    }
}

/// The triangles of a body when its session was opened.
#[derive(Clone, Debug, Default)]
pub struct BodyTopology {
    /// As the scene calls the body.
    pub name: String,
    /// `None` for triangles that are not seen.
    pub triangles: Arc<Vec<Option<TriangleLook>>>,
    /// m, place of the scene that positions are relative to
    pub origin: Vec3,
    /// m (n x 3), vertices relative to the origin, as the session was opened
    pub positions: Vec<[f32; 3]>,
    /// Whether the body moves; one that stands is in no frame.
    pub moves: bool,
}

/// What a cut, or taking one back, has changed of a body's triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct TopologyPatch {
    /// Index of the body among those that move.
    pub body: usize,
    /// Number of the patch of this body, from 1.
    pub number: u64,
    /// Number of triangles there are now.
    pub count: usize,
    /// Triangles that are new or have changed.
    pub changed: Vec<(u32, Option<TriangleLook>)>,
}
