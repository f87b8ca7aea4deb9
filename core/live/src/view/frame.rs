//! A frame for viewers: surfaces and tools of a session at one time.

use super::contact::{BladeEdgeView, ContactPoint};
use pliant_engine::body::{PAGE, TriangleLook};
use pliant_engine::session::ToolFrame;
use pliant_solver::Vec3;
use std::sync::Arc;

/// Surfaces and tools of a session at one time. [`BodyView::changed_after`] lists the changes since an earlier frame.
#[derive(Clone, Debug, Default)]
pub struct ViewFrame {
    /// Number of the frame, from 1; 0 if none was published yet.
    pub number: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Number of simulated steps.
    pub steps: u64,
    /// Moving bodies, in the order of the session. There are more than at its opening after a body was split; each new one begins without vertices and
    /// triangles.
    pub bodies: Vec<BodyView>,
    /// Tools, in the order of the session.
    pub tools: Vec<ToolFrame>,
    /// Points where tools touch bodies.
    pub contacts: Vec<ContactPoint>,
    /// Blades of the tools in hands that are present.
    pub blades: Vec<BladeEdgeView>,
    /// Number of simulated nodes.
    pub nodes: usize,
    /// Number of simulated elements.
    pub elements: usize,
    /// Corners of the simulated cells of all bodies, in axes of the scene, m (c x 8); empty unless enabled by [`ViewReader`](super::ViewReader).
    pub cells: Vec<[[f32; 3]; 8]>,
}

/// The surface of one body.
#[derive(Clone, Debug, Default)]
pub struct BodyView {
    /// Point of the scene that positions are relative to, m.
    pub origin: Vec3,
    /// Positions of the vertices relative to the origin, m (n x 3).
    pub positions: Vec<[f32; 3]>,
    /// Distance of each vertex from its rest position, m (n).
    pub displacements: Vec<f32>,
    /// Tint of each vertex: 0, or what is pinned or painted there, as [`pliant_engine::body::Body::tints`] (n).
    pub tints: Vec<f32>,
    /// Number of topology patches up to this frame.
    pub patches: u64,
    /// Number of the frame in which each page of [`PAGE`] vertices last changed.
    pub(super) stamps: Vec<u64>,
}

impl BodyView {
    /// A surface with all pages changed in the frame `number`.
    pub fn of_positions(origin: Vec3, positions: Vec<[f32; 3]>, number: u64) -> Self {
        let (displacements, stamps) = (vec![0.0; positions.len()], vec![number; positions.len().div_ceil(PAGE)]);
        let tints = displacements.clone();
        Self { origin, positions, displacements, tints, patches: 0, stamps }
    }

    /// Ranges of vertices that have changed after the frame with this number, in whole pages, ascending.
    pub fn changed_after(&self, frame: u64) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let count = self.positions.len();
        let pages = self.stamps.iter().enumerate().filter(move |(_, stamp)| **stamp > frame);
        pages.map(move |(page, _)| page * PAGE..((page + 1) * PAGE).min(count)).filter(|range| !range.is_empty())
    }
}

/// The triangles of a body at the opening of its session.
#[derive(Clone, Debug, Default)]
pub struct BodyTopology {
    /// Name of the body in the scene.
    pub name: String,
    /// Appearance of each triangle; `None` if it is invisible.
    pub triangles: Arc<Vec<Option<TriangleLook>>>,
    /// Point of the scene that positions are relative to, m.
    pub origin: Vec3,
    /// Positions of the vertices relative to the origin, at the opening of the session, m (n x 3).
    pub positions: Vec<[f32; 3]>,
    /// Whether the body moves; other bodies are in no frame.
    pub moves: bool,
}

/// Changes of a body's triangles by a cut or its undo.
#[derive(Clone, Debug, PartialEq)]
pub struct TopologyPatch {
    /// Index of the body among the moving bodies.
    pub body: usize,
    /// Number of the patch of this body, from 1.
    pub number: u64,
    /// New number of triangles.
    pub count: usize,
    /// New and changed triangles.
    pub changed: Vec<(u32, Option<TriangleLook>)>,
}

/// Difference of places in m, and of forces in N and torques in N m, that rounding leaves of a tool at rest: nobody sees it.
const ROUNDING: [f64; 2] = [1e-12, 1e-9];
/// The same, as a share of the larger one.
const RELATIVE_ROUNDING: f64 = 1e-9;

/// Whether tools look and feel the same, but for rounding: a tip with a mass comes to rest but for that.
pub(super) fn look_alike(before: &[ToolFrame], now: &[ToolFrame]) -> bool {
    let is_near = |a: f64, b: f64, floor: f64| (a - b).abs() <= floor + RELATIVE_ROUNDING * a.abs().max(b.abs());
    let are_near =
        |a: &Vec3, b: &Vec3, floor: f64| (a - b).norm() <= floor + RELATIVE_ROUNDING * a.norm().max(b.norm());
    let [place, force] = ROUNDING;
    let alike = |(before, now): (&ToolFrame, &ToolFrame)| {
        let places = [(before.hand, now.hand), (before.proxy, now.proxy)];
        let forces = [
            (before.force, now.force),
            (before.device_force, now.device_force),
            (before.torque, now.torque),
            (before.device_torque, now.device_torque),
        ];
        let rest = ToolFrame {
            hand: now.hand,
            proxy: now.proxy,
            depth: now.depth,
            force: now.force,
            device_force: now.device_force,
            torque: now.torque,
            device_torque: now.device_torque,
            ..*before
        };
        places.iter().all(|(a, b)| are_near(a, b, place))
            && is_near(before.depth, now.depth, place)
            && forces.iter().all(|(a, b)| are_near(a, b, force))
            && rest == *now
    };
    before.len() == now.len() && before.iter().zip(now).all(alike)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tools_look_alike_that_differ_by_rounding_and_no_others() {
        let tool = ToolFrame {
            hand: Vec3::new(0.1, 0.2, -0.3),
            proxy: Vec3::new(0.1, 0.2, -0.31),
            force: Vec3::new(0.0, 0.5, 0.0),
            ..ToolFrame::default()
        };
        let changed = |change: fn(&mut ToolFrame)| {
            let mut other = tool;
            change(&mut other);
            !look_alike(&[tool], &[other])
        };
        assert!(!changed(|_| {}));
        assert!(!changed(|tool| tool.proxy.x += 1e-16) && !changed(|tool| tool.force.x = 1e-13));
        assert!(changed(|tool| tool.proxy.x += 1e-9) && changed(|tool| tool.hand.z -= 1e-9));
        assert!(changed(|tool| tool.force.y += 1e-6) && changed(|tool| tool.depth = 1e-6));
        assert!(changed(|tool| tool.contact = Some(0)) && changed(|tool| tool.grips = true));
        assert!(!look_alike(&[tool], &[]));
    }
}
