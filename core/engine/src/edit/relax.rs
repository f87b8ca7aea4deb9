//! Relax: the shape at rest creeps towards the present one, so that what is pressed stays pressed.

use super::brush::Brush;
use super::flow::{Flow, Flowing};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::body::Body;
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Lets stresses go where the tool touches.
pub(super) struct Relax;

/// 1/s
const RATE: f64 = 5.0;

impl EditKind for Relax {
    fn name(&self) -> &'static str {
        "relax"
    }

    fn summary(&self) -> &'static str {
        "Let the shape at rest creep to the present one where the tool presses."
    }

    fn keys(&self) -> &'static [Key] {
        &[
            RADIUS,
            FALLOFF,
            Key { name: KeyName::Strength, default: "5 Hz", summary: "One over the time constant of the creep, Hz." },
        ]
    }

    fn strength(&self) -> Option<Strength> {
        Some(Strength { unit: "Hz", default: RATE })
    }

    fn reshapes(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Flowing::begin(edit, tool, RATE, Flow::Nodes(to_present))
    }
}

/// From where a node rests to where it is.
fn to_present(brush: &Brush, body: &Body) -> Vec<Vec3> {
    let nodes = &body.system.nodes;
    brush.nodes.iter().map(|&n| nodes.x[n as usize] - nodes.rest[n as usize]).collect()
}
