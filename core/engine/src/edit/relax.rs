//! Relax: the shape at rest creeps towards the present one, so that what is pressed stays pressed.

use super::brush::Brush;
use super::flow::{GoalDisplacement, RestShapeFlow};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::body::Body;
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Relaxes stresses where the tool touches.
pub(super) struct Relax;

/// Default rate, 1/s.
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
        Some(Strength { unit: "Hz", default: RATE, range: None })
    }

    fn changes_body(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        RestShapeFlow::begin(edit, tool, RATE, GoalDisplacement::Nodes(to_present))
    }
}

/// Goal displacement of each node of the brush: its current minus its rest position, m (k x 3).
fn to_present(brush: &Brush, body: &Body) -> Vec<Vec3> {
    let nodes = &body.system.nodes;
    brush.nodes.iter().map(|&n| nodes.x[n as usize] - nodes.rest[n as usize]).collect()
}
