//! Triangles within directed edges in a plane.

use super::Corner;
use crate::plane::triangulate;
use crate::record::NONE;
use pliant_mesh::geometry::Vec3;
use std::collections::BTreeMap;

/// Triangles within directed edges, to whose left they are. `at` gives the position of a corner, m, `plane` the corners of a triangle in their plane. Where rounding has
/// the edges cross, the triangles have a common corner and overlap; along the edges they always fit.
pub(super) fn fill(border: &[[Corner; 2]], at: impl Fn(Corner) -> Vec3, plane: [Vec3; 3]) -> Vec<[Corner; 3]> {
    if let [[a, b], [c, d], [e, f]] = *border {
        // A triangle.
        match (b == c && d == e && f == a, b == e && f == c && d == a) {
            (true, _) => return vec![[a, b, d]],
            (_, true) => return vec![[a, b, f]],
            _ => {}
        }
    }
    within(border, &at, plane).unwrap_or_else(|| fan(border))
}

/// Triangles from the first corner to all edges that do not have it.
fn fan(border: &[[Corner; 2]]) -> Vec<[Corner; 3]> {
    let Some([apex, _]) = border.first().copied() else { return Vec::new() };
    border.iter().filter(|edge| !edge.contains(&apex)).map(|[from, to]| [apex, *from, *to]).collect()
}

/// The constrained Delaunay triangulation within directed edges; `None` where rounding has them cross or corners coincide.
fn within(border: &[[Corner; 2]], at: &impl Fn(Corner) -> Vec3, [a, b, c]: [Vec3; 3]) -> Option<Vec<[Corner; 3]>> {
    let normal = (b - a).cross(&(c - a));
    let axis = normal.iamax();
    let [u, v] = if normal[axis] > 0.0 { [(axis + 1) % 3, (axis + 2) % 3] } else { [(axis + 2) % 3, (axis + 1) % 3] };
    let mut corners: Vec<Corner> = border.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    let number = |corner: &Corner| corners.binary_search(corner).map_or(NONE, |at| at as u32);
    let flat: Vec<[f64; 2]> = corners.iter().map(|corner| at(*corner) - a).map(|x| [x[u], x[v]]).collect();
    let mut lines: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for edge in border {
        *lines.entry([number(&edge[0]), number(&edge[1])]).or_default() += 1;
    }
    if lines.iter().any(|([a, b], count)| *count > 1 || lines.contains_key(&[*b, *a])) {
        return None;
    }
    let triangles = triangulate(&flat, lines.keys().copied())?;
    let side = |t: u32, i: usize| {
        let corners = triangles[t as usize].corners;
        [corners[i], corners[(i + 1) % 3]]
    };
    let sides = || (0..triangles.len() as u32).flat_map(|t| (0..3).map(move |i| (t, i)));
    let mut is_in = vec![false; triangles.len()];
    let mut waiting: Vec<u32> = sides().filter(|(t, i)| lines.contains_key(&side(*t, *i))).map(|(t, _)| t).collect();
    while let Some(t) = waiting.pop() {
        if std::mem::replace(&mut is_in[t as usize], true) {
            continue;
        }
        for i in 0..3 {
            let [from, to] = side(t, i);
            if lines.contains_key(&[to, from]) {
                return None;
            }
            if !lines.contains_key(&[from, to]) {
                match triangles[t as usize].neighbours[i] {
                    NONE => return None,
                    neighbour => waiting.push(neighbour),
                }
            }
        }
    }
    // Each edge has its triangle.
    let found = sides().filter(|(t, i)| is_in[*t as usize] && lines.contains_key(&side(*t, *i))).count();
    let filled = triangles.iter().zip(&is_in).filter(|(_, is_in)| **is_in);
    (found == lines.len()).then(|| filled.map(|(t, _)| t.corners.map(|c| corners[c as usize])).collect())
}
