//! Which triangles enclose something, and whether a point is inside.
//!
//! A component is a body when every edge has two triangles that run along it in opposite senses and it encloses a volume.
//! One that is turned inside out within another is a hollow of that other. Each body is capped for itself, so bodies that
//! stick in each other stay two.

use robust::orient3d;

use super::blade::{coord, sign};
use super::record::OPEN;
use pliant_mesh::Surface;
use pliant_mesh::geometry::Vec3;

/// A closed body, its hollows included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    /// Its faces turn their back outwards.
    pub inverted: bool,
}

/// Volume per area to the power of 3/2 below which a closed component counts as a folded sheet.
const FLAT: f64 = 1e-9;

/// Whether a closed component encloses next to nothing.
pub(super) fn is_flat(volume: f64, area: f64) -> bool {
    volume.abs() <= FLAT * area * area.sqrt()
}

/// The body of each triangle, or [`OPEN`], and all bodies.
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
            hollows.push(number);
            continue;
        }
        body_of[number] = bodies.len() as u32;
        bodies.push(Body { inverted: false });
    }
    for hollow in hollows {
        let point = surface.points[surface.triangles[members[start[hollow]] as usize][0] as usize];
        let round = (0..closed.len()).find(|&number| {
            let shell = &members[start[number]..start[number + 1]];
            body_of[number] != OPEN && winding(surface, shell.iter().copied(), point, reach(surface)).unwrap_or(0) > 0
        });
        body_of[hollow] = round.map_or_else(
            || {
                bodies.push(Body { inverted: true });
                bodies.len() as u32 - 1
            },
            |number| body_of[number],
        );
    }
    (component.iter().map(|&number| body_of[number as usize]).collect(), bodies)
}

/// How often the closed surface of some triangles winds around a point.
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

/// A length that leads out of the surface from everywhere in it.
pub(super) fn reach(surface: &Surface) -> f64 {
    let bounds = surface.bounds();
    2.0 * (0..3).map(|i| bounds.max[i] - bounds.min[i]).sum::<f64>() + 1e-9
}

/// Directions no modeler would choose.
pub(super) const RAYS: [Vec3; 4] = [
    Vec3::new(0.613_421, 0.527_913, 0.587_239),
    Vec3::new(-0.410_927, 0.761_833, 0.500_741),
    Vec3::new(0.338_171, -0.292_837, -0.894_377),
    Vec3::new(-0.771_913, -0.611_217, 0.174_329),
];

pub(super) fn end(point: Vec3, ray: Vec3, reach: f64) -> Vec3 {
    point + reach * ray
}

/// 1 where the segment leaves through the triangle's front, -1 where it comes in, 0 where it passes; `None` when it
/// touches the rim.
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
    Some(i32::from(here)) // below the front means inside
}

/// Volume and area of triangles.
pub(super) fn measure(triangles: impl Iterator<Item = [Vec3; 3]>) -> (f64, f64) {
    let mut origin = None;
    triangles.fold((0.0, 0.0), |(volume, area), corners| {
        let [a, b, c] = corners;
        let origin = *origin.get_or_insert(a);
        let cross = (b - a).cross(&(c - a));
        (volume + (a - origin).dot(&cross) / 6.0, area + 0.5 * cross.norm())
    })
}
