//! Smooth: the rest shape is faired by moving every vertex towards the mean of its neighbours.

use super::flow::{BrushRegion, GoalDisplacement, RestShapeFlow};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// Fairs the rest shape where the tool touches.
pub(super) struct Smooth;

/// Default rate, 1/s.
const RATE: f64 = 30.0;

impl EditKind for Smooth {
    fn name(&self) -> &'static str {
        "smooth"
    }

    fn summary(&self) -> &'static str {
        "Fair the shape where the tool touches."
    }

    fn keys(&self) -> &'static [Key] {
        &[
            RADIUS,
            FALLOFF,
            Key {
                name: KeyName::Strength,
                default: "30 Hz",
                summary: "How often a second a vertex goes to the mean of its neighbours, Hz.",
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
        RestShapeFlow::begin(edit, tool, RATE, GoalDisplacement::Surface(fair))
    }
}

/// Goal displacement of each vertex to the mean of its neighbours, m (k x 3) (umbrella operator; Taubin 1995). Vertices of a border use their
/// neighbours on the border alone.
fn fair(region: &BrushRegion<'_>) -> Vec<Vec3> {
    let mut faces: BTreeMap<u32, u32> = BTreeMap::new();
    let displacement = |&(v, _): &(u32, f64)| {
        faces.clear();
        for &t in region.model.around(v).iter().filter(|t| !region.model.is_lid(**t)) {
            for other in region.model.surface.triangles[t as usize].into_iter().filter(|o| *o != v) {
                *faces.entry(other).or_default() += 1;
            }
        }
        let border = faces.values().any(|count| *count == 1);
        let (mut sum, mut count) = (Vec3::zeros(), 0.0);
        for (other, _) in faces.iter().filter(|(_, faces)| !border || **faces == 1) {
            sum += region.rest(*other);
            count += 1.0;
        }
        if count > 0.0 { sum / count - region.rest(v) } else { Vec3::zeros() }
    };
    region.vertices.iter().map(displacement).collect()
}
