//! Grow and shrink: the rest shape is scaled about the centroid of the region.

use super::brush::Brush;
use super::flow::{GoalDisplacement, RestShapeFlow};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::body::Body;
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Scales the rest shape where the tool touches.
pub(super) struct Scale {
    name: &'static str,
    summary: &'static str,
    /// The kind that does the opposite.
    opposite: &'static Self,
    /// Goal displacement of each node of the brush at unit rate, m.
    displacements: fn(&Brush, &Body) -> Vec<Vec3>,
}

/// Scales it up.
pub(super) static GROW: Scale = Scale {
    name: "grow",
    summary: "Have the shape at rest grow where the tool touches.",
    opposite: &SHRINK,
    displacements: outwards,
};
/// Scales it down.
pub(super) static SHRINK: Scale = Scale {
    name: "shrink",
    summary: "Have the shape at rest shrink where the tool touches.",
    opposite: &GROW,
    displacements: inwards,
};

/// Default strain rate, 1/s.
const RATE: f64 = 1.0;

impl EditKind for Scale {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn keys(&self) -> &'static [Key] {
        &[
            RADIUS,
            FALLOFF,
            Key { name: KeyName::Strength, default: "1 Hz", summary: "Rate of the strain at the centre, Hz." },
        ]
    }

    fn strength(&self) -> Option<Strength> {
        Some(Strength { unit: "Hz", default: RATE, range: None })
    }

    fn changes_body(&self) -> bool {
        true
    }

    fn opposite(&self) -> Option<&'static dyn EditKind> {
        Some(self.opposite)
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        RestShapeFlow::begin(edit, tool, RATE, GoalDisplacement::Nodes(self.displacements))
    }
}

/// Vectors from the centroid of the region to its nodes, m (k x 3).
fn outwards(brush: &Brush, body: &Body) -> Vec<Vec3> {
    let rest = &body.system.nodes.rest;
    let centre = brush.mean(rest);
    brush.nodes.iter().map(|&n| rest[n as usize] - centre).collect()
}

/// Vectors from the nodes of the region to its centroid, m (k x 3).
fn inwards(brush: &Brush, body: &Body) -> Vec<Vec3> {
    let mut displacements = outwards(brush, body);
    displacements.iter_mut().for_each(|displacement| *displacement = -*displacement);
    displacements
}
