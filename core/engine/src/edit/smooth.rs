//! Smooth: the rest shape is faired by moving every vertex towards the mean of its neighbours.

use super::flow::{BrushRegion, GoalDisplacement, RestShapeFlow};
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, EditKind};
use crate::body::NOT_EMBEDDED;
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_mesh::geometry::place_bits;
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
/// neighbours on the border alone. A seam of a solid, where faces meet that share no vertices, is no border: its vertices would part.
fn fair(region: &BrushRegion<'_>) -> Vec<Vec3> {
    let mut faces: BTreeMap<u32, u32> = BTreeMap::new();
    let mut places = None;
    let displacement = |&(v, _): &(u32, f64)| {
        faces.clear();
        others_around(region, v, |other| *faces.entry(other).or_default() += 1);
        let border = faces.values().any(|count| *count == 1);
        if border && region.skin.cell[v as usize] != NOT_EMBEDDED {
            let places = places.get_or_insert_with(|| vertices_by_place(region));
            if let Some(seam) = places.get(&place(region, v)).filter(|seam| seam.len() > 1) {
                return fair_seam(region, seam);
            }
        }
        let neighbours = faces.iter().filter(|(_, faces)| !border || **faces == 1);
        to_mean(region.rest(v), neighbours.map(|(other, _)| region.rest(*other)))
    };
    region.vertices.iter().map(displacement).collect()
}

/// Calls `visit` with the other two corners of each triangle around a vertex.
fn others_around(region: &BrushRegion<'_>, v: u32, mut visit: impl FnMut(u32)) {
    for &t in region.model.around(v).iter().filter(|t| !region.model.is_lid(**t)) {
        region.model.surface.triangles[t as usize].into_iter().filter(|o| *o != v).for_each(&mut visit);
    }
}

/// The displacement from a place to the mean of others, m; zero if there are none.
fn to_mean(from: Vec3, others: impl Iterator<Item = Vec3>) -> Vec3 {
    let (sum, count) = others.fold((Vec3::zeros(), 0.0), |(sum, count), other| (sum + other, count + 1.0));
    if count > 0.0 { sum / count - from } else { Vec3::zeros() }
}

/// Bits of a rest position, see [`place_bits`].
type PlaceBits = [u64; 3];

/// The cell that carries a vertex, and its rest position. Vertices at one place on two sides of a cut have different cells.
fn place(region: &BrushRegion<'_>, v: u32) -> (u32, PlaceBits) {
    (region.skin.cell[v as usize], place_bits(region.rest(v)))
}

/// The vertices of the region at each place, ascending.
fn vertices_by_place(region: &BrushRegion<'_>) -> BTreeMap<(u32, PlaceBits), Vec<u32>> {
    let mut places: BTreeMap<_, Vec<u32>> = BTreeMap::new();
    for &(v, _) in region.vertices {
        places.entry(place(region, v)).or_default().push(v);
    }
    places
}

/// Goal displacement of vertices at one place, m: as if they were one vertex, and so were their neighbours at one place.
fn fair_seam(region: &BrushRegion<'_>, seam: &[u32]) -> Vec3 {
    let own = region.rest(seam[0]);
    let mut faces: BTreeMap<PlaceBits, u32> = BTreeMap::new();
    for &v in seam {
        others_around(region, v, |other| *faces.entry(place_bits(region.rest(other))).or_default() += 1);
    }
    faces.remove(&place_bits(own));
    let border = faces.values().any(|count| *count == 1);
    let neighbours = faces.iter().filter(|(_, faces)| !border || **faces == 1);
    to_mean(own, neighbours.map(|(bits, _)| bits.map(f64::from_bits).into()))
}
