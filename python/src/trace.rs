//! The trace of a run as arrays, a row for each step.

use super::arrays::copy_vectors;
use numpy::PyArray1;
use pliant_engine::session::{Frame, Session};
use pliant_solver::Vec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The trace of a run: an entry of each array for each step.
pub struct Trace {
    /// End of each step, s.
    time: Vec<f64>,
    tools: Vec<ToolTrace>,
    nodes: Vec<u64>,
    elements: Vec<u64>,
    /// Kinetic energy of all bodies, J.
    kinetic_energy: Vec<f64>,
    /// Elastic energy of all bodies, J.
    elastic_energy: Vec<f64>,
    substeps: Vec<u64>,
    iterations: Vec<u64>,
    residual: Vec<f64>,
    /// Wall-clock time of each step, s.
    seconds: Vec<f64>,
}

/// The trace of one tool: an entry of each array for each step.
#[derive(Default)]
struct ToolTrace {
    name: String,
    /// Position of the hand, m.
    hand: Vec<Vec3>,
    /// Position of the proxy, m.
    proxy: Vec<Vec3>,
    /// Index of the body it was in contact with, -1 for none.
    contact: Vec<i64>,
    holds: Vec<bool>,
    /// Displacement of the surface at the contact, m.
    depth: Vec<f64>,
    /// Force on the hand, in axes of the scene, N.
    force: Vec<Vec3>,
    /// Force rendered by the device, in its axes, N.
    device_force: Vec<Vec3>,
}

impl Trace {
    /// An empty trace of a session, with room for `steps` steps.
    pub fn new(session: &Session, steps: usize) -> Self {
        let tool = |name: &String| ToolTrace { name: name.clone(), ..ToolTrace::default() };
        Self {
            time: Vec::with_capacity(steps),
            tools: session.tools.iter().map(|slot| tool(&slot.tool.name)).collect(),
            nodes: Vec::with_capacity(steps),
            elements: Vec::with_capacity(steps),
            kinetic_energy: Vec::with_capacity(steps),
            elastic_energy: Vec::with_capacity(steps),
            substeps: Vec::with_capacity(steps),
            iterations: Vec::with_capacity(steps),
            residual: Vec::with_capacity(steps),
            seconds: Vec::with_capacity(steps),
        }
    }

    /// Appends the state at the end of a step.
    pub fn step(&mut self, frame: &Frame) {
        self.time.push(frame.time);
        self.nodes.push(frame.nodes as u64);
        self.elements.push(frame.elements as u64);
        self.kinetic_energy.push(frame.kinetic_energy);
        self.elastic_energy.push(frame.elastic_energy);
        self.substeps.push(frame.substeps as u64);
        self.iterations.push(frame.iterations as u64);
        self.residual.push(frame.residual);
        self.seconds.push(frame.seconds);
        for (trace, felt) in self.tools.iter_mut().zip(&frame.tools) {
            trace.hand.push(felt.hand);
            trace.proxy.push(felt.proxy);
            trace.contact.push(felt.contact.map_or(-1, i64::from));
            trace.holds.push(felt.grips);
            trace.depth.push(felt.depth);
            trace.force.push(felt.force);
            trace.device_force.push(felt.device_force);
        }
    }

    /// As a dict of arrays, with a dict for each tool in `tools`.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("time", PyArray1::from_slice(py, &self.time))?;
        dict.set_item("nodes", PyArray1::from_slice(py, &self.nodes))?;
        dict.set_item("elements", PyArray1::from_slice(py, &self.elements))?;
        dict.set_item("kinetic_energy", PyArray1::from_slice(py, &self.kinetic_energy))?;
        dict.set_item("elastic_energy", PyArray1::from_slice(py, &self.elastic_energy))?;
        dict.set_item("substeps", PyArray1::from_slice(py, &self.substeps))?;
        dict.set_item("iterations", PyArray1::from_slice(py, &self.iterations))?;
        dict.set_item("residual", PyArray1::from_slice(py, &self.residual))?;
        dict.set_item("seconds", PyArray1::from_slice(py, &self.seconds))?;
        let tools = PyDict::new(py);
        for tool in &self.tools {
            tools.set_item(&tool.name, tool.to_dict(py)?)?;
        }
        dict.set_item("tools", tools)?;
        Ok(dict)
    }
}

impl ToolTrace {
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("hand", copy_vectors(py, &self.hand))?;
        dict.set_item("proxy", copy_vectors(py, &self.proxy))?;
        dict.set_item("contact", PyArray1::from_slice(py, &self.contact))?;
        dict.set_item("holds", PyArray1::from_slice(py, &self.holds))?;
        dict.set_item("depth", PyArray1::from_slice(py, &self.depth))?;
        dict.set_item("force", copy_vectors(py, &self.force))?;
        dict.set_item("device_force", copy_vectors(py, &self.device_force))?;
        Ok(dict)
    }
}
