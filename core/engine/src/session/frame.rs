//! What a step gives.

use pliant_solver::Vec3;

/// A tool at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolFrame {
    /// m, the hand
    pub hand: Vec3,
    /// m, where the surface lets the tool be
    pub proxy: Vec3,
    /// The body it touches or holds.
    pub contact: Option<u32>,
    /// Whether it holds.
    pub grips: bool,
    /// m, how far the surface has gone in, or out
    pub depth: f64,
    /// N, on the hand
    pub force: Vec3,
    /// N, what the device was given, in its own axes
    pub device_force: Vec3,
    /// N m, on the hand, of an edit that turns with it
    pub torque: Vec3,
    /// N m, what the device was given, in its own axes; zero where it renders none
    pub device_torque: Vec3,
}

/// The state at the end of a step, but for the positions, which stay in the session.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// s
    pub time: f64,
    /// In order of the tools.
    pub tools: Vec<ToolFrame>,
    /// Nodes and elements that were active.
    pub nodes: usize,
    /// Number of active elements, of all bodies.
    pub elements: usize,
    /// J
    pub kinetic_energy: f64,
    /// J
    pub elastic_energy: f64,
    /// J, what friction between tips and sheets took in the step
    pub friction_work: f64,
    /// Substeps of each body.
    pub substeps: usize,
    /// Iterations of all solves.
    pub iterations: usize,
    /// The largest final relative residual.
    pub residual: f64,
    /// s, wall clock, of the step itself
    pub seconds: f64,
    /// s, of it: moving regions with the hands, contact, integration
    pub parts: [f64; 3],
    /// s, of the integration: forces and matrix of the elements, and the solves
    pub work: [f64; 2],
}

impl Frame {
    /// Empties it for the next step, in its own buffers.
    pub(super) fn begin(&mut self) {
        let mut tools = std::mem::take(&mut self.tools);
        tools.clear();
        *self = Self { tools, ..Self::default() };
    }
}
