//! Pinch: the surface is drawn from both sides to a line through the contact, as a crease is.

use super::flow::{Flow, Flowing, Place};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Draws the shape at rest to a line along the hand.
pub(super) struct Pinch;

/// 1/s
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
        Some(Strength { unit: "Hz", default: RATE })
    }

    fn reshapes(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Flowing::begin(edit, tool, RATE, Flow::Surface(to_line))
    }
}

/// Across the line of the hand's x axis in the plane of the region; along y where x stands on that plane.
fn to_line(place: &Place<'_>) -> Vec<Vec3> {
    let normal = place.normal();
    let in_plane = |axis: Vec3| (axis - axis.dot(&normal) * normal).try_normalize(0.1);
    let line = in_plane(place.hand * Vec3::x()).or_else(|| in_plane(place.hand * Vec3::y())).unwrap_or_else(Vec3::x);
    let across = normal.cross(&line);
    place.vertices.iter().map(|&(v, _)| -(place.at(v) - place.centre).dot(&across) * across).collect()
}
