//! Lids: triangles that close the small holes of nearly closed components for cuts.
//!
//! Scans have holes at the support of the object, and models where they are not visible. A component that can be closed with little additional
//! area is a closed body. Its lids are cut like other triangles, so everything that holds for closed bodies holds for it. Lids are neither written
//! nor touched: the hole stays, and the edge of a cut surface goes straight across it.

use std::collections::{HashMap, HashSet};

use super::polygon::smallest_angle;
use super::solid;
use pliant_mesh::Surface;

/// Largest area of lids, as a fraction of the component's area.
const MAX_AREA: f64 = 0.05;
/// Largest number of vertices of a hole.
const MAX_VERTICES: usize = 200;
/// Smallest angle of a lid's triangle, degrees.
const MIN_ANGLE: f64 = 0.5;
/// Weight of the squared perimeter relative to the area in the cost of a triangle: prefers well-shaped triangles among equal areas.
const PERIMETER_WEIGHT: f64 = 0.01;

/// The lids of all components that can be closed.
pub(super) fn find(surface: &Surface, links: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut lids = Vec::new();
    let on_border = border_vertices(surface, links);
    if on_border.is_empty() {
        return lids;
    }
    // A lid along an existing edge would be a third face at it.
    let mut taken: HashSet<[u32; 2]> = HashSet::new();
    for [a, b, c] in &surface.triangles {
        let sides =
            [(a, b), (b, c), (c, a)].into_iter().filter(|(a, b)| on_border.contains(a) && on_border.contains(b));
        taken.extend(sides.map(|(a, b)| [*a.min(b), *a.max(b)]));
    }
    for component in components(links) {
        let Some(holes) = holes(surface, links, &component).filter(|holes| !holes.is_empty()) else { continue };
        let mut own = Vec::new();
        let mut sides = taken.clone();
        let closed = holes.iter().all(|hole| close(surface, hole, &mut sides, &mut own));
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| surface.points[vertex as usize]);
        let skin = || component.iter().map(|&t| corners(&surface.triangles[t as usize]));
        let (_, area) = solid::measure(skin());
        let (volume, whole) = solid::measure(skin().chain(own.iter().map(corners)));
        if closed && whole - area <= MAX_AREA * area && !solid::is_flat(volume, whole) {
            lids.append(&mut own);
            taken = sides;
        }
    }
    lids
}

fn border_vertices(surface: &Surface, links: &[[u32; 3]]) -> HashSet<u32> {
    let halves = (0..3 * links.len() as u32).filter(|half| links[*half as usize / 3][*half as usize % 3] == *half);
    halves.flat_map(|half| ends(surface, half)).collect()
}

fn ends(surface: &Surface, half: u32) -> [u32; 2] {
    let triangle = surface.triangles[half as usize / 3];
    [triangle[half as usize % 3], triangle[(half as usize + 1) % 3]]
}

/// Triangles that are connected by edges.
fn components(links: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut seen = vec![false; links.len()];
    let mut all = Vec::new();
    for seed in 0..links.len() {
        if std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let mut component = vec![seed as u32];
        let mut at = 0;
        while at < component.len() {
            for other in links[component[at] as usize].map(|half| half / 3) {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    component.push(other);
                }
            }
            at += 1;
        }
        all.push(component);
    }
    all
}

/// The loops of border edges of a component; `None` if it is non-manifold or not oriented, or if loops touch.
fn holes(surface: &Surface, links: &[[u32; 3]], component: &[u32]) -> Option<Vec<Vec<u32>>> {
    let mut next: HashMap<u32, u32> = HashMap::new();
    let mut order = Vec::new();
    for half in component.iter().flat_map(|t| 3 * t..3 * t + 3) {
        let other = links[half as usize / 3][half as usize % 3];
        let [tail, head] = ends(surface, half);
        if other == half {
            order.push(tail);
            if next.insert(tail, head).is_some() {
                return None;
            }
        } else if links[other as usize / 3][other as usize % 3] != half || ends(surface, other) != [head, tail] {
            return None;
        }
    }
    let mut holes = Vec::new();
    for start in order {
        let mut hole = Vec::new();
        let mut at = start;
        while let Some(head) = next.remove(&at) {
            hole.push(at);
            at = head;
        }
        if !hole.is_empty() {
            if at != start {
                return None;
            }
            hole.reverse(); // a lid has the opposite direction along the border
            holes.push(hole);
        }
    }
    Some(holes)
}

/// Adds the triangulation of a polygon in space with the least cost (Klincsek 1980; Barequet and Sharir 1995) that uses no side in `taken`. Returns
/// whether there is one.
fn close(surface: &Surface, hole: &[u32], taken: &mut HashSet<[u32; 2]>, lids: &mut Vec<[u32; 3]>) -> bool {
    let n = hole.len();
    if !(3..=MAX_VERTICES).contains(&n) {
        return false;
    }
    let point = |i: usize| surface.points[hole[i] as usize];
    let side = |i: usize, j: usize| [hole[i].min(hole[j]), hole[i].max(hole[j])];
    let cost = |i: usize, j: usize, k: usize| {
        let [a, b, c] = [point(i), point(j), point(k)];
        let round = (b - a).norm() + (c - b).norm() + (a - c).norm();
        let sharp = smallest_angle([a, b, c]) < MIN_ANGLE;
        if sharp { f64::INFINITY } else { 0.5 * (b - a).cross(&(c - a)).norm() + PERIMETER_WEIGHT * round * round }
    };
    // Row i, column k: the least cost of the polygon from vertex i to vertex k, and the third corner of its triangle at side i-k.
    let mut best = vec![(0.0_f64, 0); n * n];
    for span in 2..n {
        for i in 0..n - span {
            let k = i + span;
            let barred = span < n - 1 && taken.contains(&side(i, k));
            let costs = (i + 1..k).map(|j| (best[i * n + j].0 + best[j * n + k].0, j));
            let open = costs.filter(|(so_far, _)| !barred && so_far.is_finite());
            let least = open.map(|(so_far, j)| (so_far + cost(i, j, k), j)).min_by(|a, b| a.0.total_cmp(&b.0));
            best[i * n + k] = least.unwrap_or((f64::INFINITY, 0));
        }
    }
    if !best[n - 1].0.is_finite() {
        return false;
    }
    let mut waiting = vec![(0, n - 1)];
    while let Some((i, k)) = waiting.pop() {
        let j = best[i * n + k].1;
        lids.push([hole[i], hole[j], hole[k]]);
        taken.extend([side(i, j), side(j, k), side(i, k)]);
        waiting.extend([(i, j), (j, k)].into_iter().filter(|(from, to)| to - from > 1));
    }
    true
}
