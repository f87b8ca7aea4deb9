//! Flatten: the shape at rest goes to the plane that fits it.

use super::flow::{Flow, Flowing, Place};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Flattens the shape at rest where the tool touches.
pub(super) struct Flatten;

/// 1/s
const RATE: f64 = 10.0;

impl EditKind for Flatten {
    fn name(&self) -> &'static str {
        "flatten"
    }

    fn summary(&self) -> &'static str {
        "Bring the surface where the tool touches to the plane that fits it."
    }

    fn keys(&self) -> &'static [Key] {
        &[
            RADIUS,
            FALLOFF,
            Key {
                name: KeyName::Strength,
                default: "10 Hz",
                summary: "Share of its distance from the plane that a point loses in a second, Hz.",
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
        Flowing::begin(edit, tool, RATE, Flow::Surface(to_plane))
    }
}

/// Along the mean normal, to the plane through the mean place; both by weight and area.
fn to_plane(place: &Place<'_>) -> Vec<Vec3> {
    let normal = place.normal();
    let (mut total, mut height) = (0.0, 0.0);
    for &(v, weight) in place.vertices {
        let share = weight * place.area(v).norm();
        total += share;
        height += share * (place.at(v) - place.centre).dot(&normal);
    }
    let mean = if total > 0.0 { height / total } else { 0.0 };
    place.vertices.iter().map(|&(v, _)| (mean - (place.at(v) - place.centre).dot(&normal)) * normal).collect()
}
