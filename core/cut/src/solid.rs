//! Closed bodies of a mesh, and winding numbers of points.
//!
//! A connected component is a closed body if every edge has two triangles with opposite orientations and the component encloses a volume. A
//! component with inverted orientation inside of another one is a cavity of it. Each body gets its own caps, so intersecting bodies stay
//! separate.

use robust::orient3d;

use super::blade::{coord, sign};
use super::record::OPEN;
use pliant_mesh::Surface;
use pliant_mesh::geometry::Vec3;

/// A closed body, including its cavities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    /// Whether the normals of its faces point inwards.
    pub inverted: bool,
    /// Volume within its outer surface before any cut, m^3.
    pub volume: f64,
}

/// Ratio of volume to area^(3/2) below which a closed component counts as a folded sheet.
const MIN_VOLUME_RATIO: f64 = 1e-9;

/// Whether a closed component with this volume (m^3) and area (m^2) counts as a folded sheet.
pub(super) fn is_flat(volume: f64, area: f64) -> bool {
    volume.abs() <= MIN_VOLUME_RATIO * area * area.sqrt()
}

/// Returns the body of each triangle (m), or [`OPEN`], and the list of bodies.
pub(super) fn find(surface: &Surface, links: &[[u32; 3]]) -> (Vec<u32>, Vec<Body>) {
    let count = surface.triangles.len();
    let mut component = vec![OPEN; count];
    let (mut members, mut start, mut closed) = (Vec::with_capacity(count), vec![0], Vec::new());
    for seed in 0..count {
        if component[seed] != OPEN {
            continue;
        }
        let number = closed.len() as u32;
        let mut sound = true;
        component[seed] = number;
        members.push(seed as u32);
        let mut at = start[closed.len()];
        while at < members.len() {
            let triangle = members[at] as usize;
            for side in 0..3 {
                let half = 3 * triangle as u32 + side as u32;
                let other = links[triangle][side];
                sound &= other != half
                    && links[other as usize / 3][other as usize % 3] == half
                    && surface.triangles[triangle][side]
                        == surface.triangles[other as usize / 3][(other as usize + 1) % 3];
                if component[other as usize / 3] == OPEN {
                    component[other as usize / 3] = number;
                    members.push(other / 3);
                }
            }
            at += 1;
        }
        start.push(members.len());
        closed.push(sound);
    }
    let mut body_of = vec![OPEN; closed.len()];
    let (mut bodies, mut hollows) = (Vec::new(), Vec::new());
    for number in (0..closed.len()).filter(|&number| closed[number]) {
        let corners = |t: &u32| surface.triangles[*t as usize].map(|vertex| surface.points[vertex as usize]);
        let (volume, area) = measure(members[start[number]..start[number + 1]].iter().map(corners));
        if is_flat(volume, area) {
            continue;
        }
        if volume < 0.0 {
            hollows.push((number, -volume));
            continue;
        }
        body_of[number] = bodies.len() as u32;
        bodies.push(Body { inverted: false, volume });
    }
    for (hollow, volume) in hollows {
        let point = surface.points[surface.triangles[members[start[hollow]] as usize][0] as usize];
        let round = (0..closed.len()).find(|&number| {
            let shell = &members[start[number]..start[number + 1]];
            body_of[number] != OPEN && winding(surface, shell.iter().copied(), point, reach(surface)).unwrap_or(0) > 0
        });
        body_of[hollow] = round.map_or_else(
            || {
                bodies.push(Body { inverted: true, volume });
                bodies.len() as u32 - 1
            },
            |number| body_of[number],
        );
    }
    (component.iter().map(|&number| body_of[number as usize]).collect(), bodies)
}

/// Winding number of closed surfaces around a point.
pub(super) fn winding(
    surface: &Surface,
    triangles: impl Iterator<Item = u32> + Clone,
    point: Vec3,
    reach: f64,
) -> Option<i32> {
    RAYS.iter().find_map(|&ray| {
        let far = end(point, ray, reach);
        let corners = |t: u32| surface.triangles[t as usize].map(|vertex| surface.points[vertex as usize]);
        triangles.clone().try_fold(0, |sum, t| Some(sum + crossing(corners(t), point, far)?))
    })
}

/// A length, m, at least the diameter of the surface: a ray of this length from any of its points ends outside.
pub(super) fn reach(surface: &Surface) -> f64 {
    let bounds = surface.bounds();
    2.0 * (0..3).map(|i| bounds.max[i] - bounds.min[i]).sum::<f64>() + 1e-9
}

/// Ray directions that are unlikely to be parallel to faces or to hit edges.
pub(super) const RAYS: [Vec3; 4] = [
    Vec3::new(0.613_421, 0.527_913, 0.587_239),
    Vec3::new(-0.410_927, 0.761_833, 0.500_741),
    Vec3::new(0.338_171, -0.292_837, -0.894_377),
    Vec3::new(-0.771_913, -0.611_217, 0.174_329),
];

pub(super) fn end(point: Vec3, ray: Vec3, reach: f64) -> Vec3 {
    point + reach * ray
}

/// Intersection of a segment with a triangle: 1 if it leaves through the front, -1 if it enters, 0 if it misses; `None` if it touches an edge of
/// the triangle.
pub(super) fn crossing(corners: [Vec3; 3], from: Vec3, to: Vec3) -> Option<i32> {
    let [a, b, c, p, q] = [corners[0], corners[1], corners[2], from, to].map(coord);
    let (here, there) = (sign(orient3d(a, b, c, p)), sign(orient3d(a, b, c, q)));
    if here == there {
        return (here != 0).then_some(0);
    }
    let rims = [sign(orient3d(p, q, a, b)), sign(orient3d(p, q, b, c)), sign(orient3d(p, q, c, a))];
    if rims.contains(&1) && rims.contains(&-1) {
        return Some(0);
    }
    if here == 0 || there == 0 || rims.contains(&0) {
        return None;
    }
    Some(i32::from(here)) // a start below the front face is inside
}

/// Signed volume (m^3) and area (m^2) of triangles.
pub(super) fn measure(triangles: impl Iterator<Item = [Vec3; 3]>) -> (f64, f64) {
    let mut origin = None;
    triangles.fold((0.0, 0.0), |(volume, area), corners| {
        let [a, b, c] = corners;
        let origin = *origin.get_or_insert(a);
        let cross = (b - a).cross(&(c - a));
        (volume + (a - origin).dot(&cross) / 6.0, area + 0.5 * cross.norm())
    })
}
