//! Smooth: the shape at rest is faired, every vertex towards the mean of its neighbours.

use super::flow::{Flow, Flowing, Place};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// Fairs the shape at rest where the tool touches.
pub(super) struct Smooth;

/// 1/s
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
        Some(Strength { unit: "Hz", default: RATE })
    }

    fn reshapes(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Flowing::begin(edit, tool, RATE, Flow::Surface(fair))
    }
}

/// To the mean of the neighbours (the umbrella operator; Taubin 1995); along a border, of those on the border.
fn fair(place: &Place<'_>) -> Vec<Vec3> {
    let mut faces: BTreeMap<u32, u32> = BTreeMap::new();
    let way = |&(v, _): &(u32, f64)| {
        faces.clear();
        for &t in place.model.around(v).iter().filter(|t| !place.model.is_lid(**t)) {
            for other in place.model.surface.triangles[t as usize].into_iter().filter(|o| *o != v) {
                *faces.entry(other).or_default() += 1;
            }
        }
        let border = faces.values().any(|count| *count == 1);
        let (mut sum, mut count) = (Vec3::zeros(), 0.0);
        for (other, _) in faces.iter().filter(|(_, faces)| !border || **faces == 1) {
            sum += place.at(*other);
            count += 1.0;
        }
        if count > 0.0 { sum / count - place.at(v) } else { Vec3::zeros() }
    };
    place.vertices.iter().map(way).collect()
}
