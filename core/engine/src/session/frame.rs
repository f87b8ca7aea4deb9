//! Results of a step.

use crate::edit::EditKind;
use pliant_solver::Vec3;

/// A tool at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolFrame {
    /// Position of the hand, m.
    pub hand: Vec3,
    /// Position of the proxy, m.
    pub proxy: Vec3,
    /// Index of the body it touches or grips.
    pub contact: Option<u32>,
    /// Kind of its active edit.
    pub edit: Option<&'static dyn EditKind>,
    /// Whether it grips a body.
    pub grips: bool,
    /// Displacement of the surface at the contact, inwards or outwards, m.
    pub depth: f64,
    /// Force on the hand, in axes of the scene, N.
    pub force: Vec3,
    /// Force rendered by the device, in its axes, N.
    pub device_force: Vec3,
    /// Whether the scene has an edit with this tool that renders torque.
    pub has_torque: bool,
    /// Torque on the hand of an edit that rotates with it, in axes of the scene, N m.
    pub torque: Vec3,
    /// Torque rendered by the device, in its axes, N m; zero if it renders none.
    pub device_torque: Vec3,
}

/// Results at the end of a step. Positions are in the session.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Simulated time, s.
    pub time: f64,
    /// One for each tool.
    pub tools: Vec<ToolFrame>,
    /// Number of active nodes of all bodies.
    pub nodes: usize,
    /// Number of active elements, of all bodies.
    pub elements: usize,
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Elastic energy, J.
    pub elastic_energy: f64,
    /// Energy dissipated by friction between tips and sheets in the step, J.
    pub friction_work: f64,
    /// Number of substeps of each body.
    pub substeps: usize,
    /// Iterations of all linear solves.
    pub iterations: usize,
    /// Largest final relative residual of a linear solve.
    pub residual: f64,
    /// Wall-clock time of the step, s.
    pub seconds: f64,
    /// Wall-clock times of its stages, s: regions, contact, integration.
    pub parts: [f64; 3],
    /// Wall-clock times of the integration, s: assembly of forces and matrix, and linear solves.
    pub work: [f64; 2],
}

impl Frame {
    /// Clears it for the next step and keeps its buffers.
    pub(super) fn begin(&mut self) {
        let mut tools = std::mem::take(&mut self.tools);
        tools.clear();
        *self = Self { tools, ..Self::default() };
    }
}
