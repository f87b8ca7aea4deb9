//! Pinch: the surface is drawn from both sides to a line through the contact, which forms a crease.

use super::flow::{BrushRegion, GoalDisplacement, RestShapeFlow};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Draws the rest shape to a line along the x axis of the hand.
pub(super) struct Pinch;

/// Default rate, 1/s.
const RATE: f64 = 3.0;

impl EditKind for Pinch {
    fn name(&self) -> &'static str {
        "pinch"
    }

    fn summary(&self) -> &'static str {
        "Draw the surface where the tool touches from both sides to a line along the hand's x axis."
    }

    fn keys(&self) -> &'static [Key] {
        &[
            RADIUS,
            FALLOFF,
            Key {
                name: KeyName::Strength,
                default: "3 Hz",
                summary: "Share of its distance from the line that a point loses in a second, Hz.",
            },
        ]
    }

    fn strength(&self) -> Option<Strength> {
        Some(Strength { unit: "Hz", default: RATE, range: None })
    }

    fn changes_body(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        RestShapeFlow::begin(edit, tool, RATE, GoalDisplacement::Surface(to_line))
    }
}

/// Goal displacements to the line through the contact along the hand's x axis, projected to the region's plane, m (k x 3); the y axis replaces an x
/// axis that is perpendicular to the plane.
fn to_line(region: &BrushRegion<'_>) -> Vec<Vec3> {
    let normal = region.normal();
    let in_plane = |axis: Vec3| (axis - axis.dot(&normal) * normal).try_normalize(0.1);
    let line = in_plane(region.hand * Vec3::x()).or_else(|| in_plane(region.hand * Vec3::y())).unwrap_or_else(Vec3::x);
    let across = normal.cross(&line);
    region.vertices.iter().map(|&(v, _)| -(region.rest(v) - region.centre).dot(&across) * across).collect()
}
