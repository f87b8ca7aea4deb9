//! Flatten: the rest shape moves to its mean plane.

use super::flow::{BrushRegion, GoalDisplacement, RestShapeFlow};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Flattens the rest shape where the tool touches.
pub(super) struct Flatten;

/// Default rate, 1/s.
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
        Some(Strength { unit: "Hz", default: RATE, range: None })
    }

    fn changes_body(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        RestShapeFlow::begin(edit, tool, RATE, GoalDisplacement::Side(to_plane))
    }
}

/// Goal displacement of each vertex along the mean normal to the plane through the centroid, m (k x 3). Normal and centroid are weighted by
/// falloff and area.
fn to_plane(region: &BrushRegion<'_>) -> Vec<Vec3> {
    let normal = region.normal();
    let (mut total, mut height) = (0.0, 0.0);
    for &(v, weight) in region.vertices {
        let factor = weight * region.area(v).norm();
        total += factor;
        height += factor * (region.rest(v) - region.centre).dot(&normal);
    }
    let mean = if total > 0.0 { height / total } else { 0.0 };
    region.vertices.iter().map(|&(v, _)| (mean - (region.rest(v) - region.centre).dot(&normal)) * normal).collect()
}
