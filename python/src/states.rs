//! Hands, tools and figures of a step as Python has them.

use super::failure::Failure;
use nalgebra::{Quaternion, UnitQuaternion};
use pliant_engine::session::{Frame, HandPose, ToolFrame};
use pliant_solver::Vec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A place (m) and a quaternion (x, y, z, w) in the scene, with buttons as bits.
pub fn hand_pose(position: [f64; 3], [x, y, z, w]: [f64; 4], buttons: u32) -> Result<HandPose, Failure> {
    if !position.iter().all(|c| c.is_finite()) {
        return Err(Failure::argument(format!("position {position:?}; allowed are finite numbers in metres")));
    }
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9).ok_or_else(|| {
        Failure::argument(format!("rotation ({x}, {y}, {z}, {w}); allowed is a quaternion (x, y, z, w) with a length"))
    })?;
    Ok(HandPose { position: position.into(), rotation, buttons })
}

/// The figures of a step.
pub fn frame_dict<'py>(py: Python<'py>, frame: &Frame) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("time", frame.time)?;
    dict.set_item("nodes", frame.nodes)?;
    dict.set_item("elements", frame.elements)?;
    dict.set_item("kinetic_energy", frame.kinetic_energy)?;
    dict.set_item("elastic_energy", frame.elastic_energy)?;
    dict.set_item("substeps", frame.substeps)?;
    dict.set_item("iterations", frame.iterations)?;
    dict.set_item("residual", frame.residual)?;
    dict.set_item("seconds", frame.seconds)?;
    Ok(dict)
}

/// A tool at the end of a step; `bodies` are the names of those that move.
pub fn tool_dict<'py>(py: Python<'py>, felt: &ToolFrame, bodies: &[String]) -> PyResult<Bound<'py, PyDict>> {
    let vector = |v: Vec3| (v.x, v.y, v.z);
    let dict = PyDict::new(py);
    dict.set_item("hand", vector(felt.hand))?;
    dict.set_item("proxy", vector(felt.proxy))?;
    let body = felt.contact.and_then(|index| bodies.get(index as usize));
    dict.set_item("contact", body)?;
    dict.set_item("holds", felt.grips)?;
    dict.set_item("depth", felt.depth)?;
    dict.set_item("force", vector(felt.force))?;
    dict.set_item("device_force", vector(felt.device_force))?;
    Ok(dict)
}
