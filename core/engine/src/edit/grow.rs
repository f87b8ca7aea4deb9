//! Grow and shrink: the shape at rest is scaled about the middle of the region.

use super::brush::Brush;
use super::flow::{Flow, Flowing};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::body::Body;
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Scales the shape at rest where the tool touches.
pub(super) struct Scale {
    name: &'static str,
    summary: &'static str,
    ways: fn(&Brush, &Body) -> Vec<Vec3>,
}

/// Scales it up.
pub(super) static GROW: Scale =
    Scale { name: "grow", summary: "Have the shape at rest grow where the tool touches.", ways: outwards };
/// Scales it down.
pub(super) static SHRINK: Scale =
    Scale { name: "shrink", summary: "Have the shape at rest shrink where the tool touches.", ways: inwards };

/// 1/s
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
        Some(Strength { unit: "Hz", default: RATE })
    }

    fn reshapes(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Flowing::begin(edit, tool, RATE, Flow::Nodes(self.ways))
    }
}

/// From the mean of the region.
fn outwards(brush: &Brush, body: &Body) -> Vec<Vec3> {
    let rest = &body.system.nodes.rest;
    let centre = brush.mean(rest);
    brush.nodes.iter().map(|&n| rest[n as usize] - centre).collect()
}

/// To the mean of the region.
fn inwards(brush: &Brush, body: &Body) -> Vec<Vec3> {
    let mut ways = outwards(brush, body);
    ways.iter_mut().for_each(|way| *way = -*way);
    ways
}
