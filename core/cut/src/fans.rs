//! Duplication of vertices whose faces are no longer connected.
//!
//! A fan is a set of faces around a vertex that are connected by edges. If opening edges has left several fans at a vertex, the first keeps the
//! vertex and every other gets a copy. Fans that were separate before keep sharing it.

use std::collections::HashMap;

use super::Vec3;
use super::error::{Refusal, Refused};
use super::mesh::CutMesh;
use super::record::{NONE, OPEN, Origin};

/// A point of the cut surface inside of a body, for fans that have no vertex yet.
#[derive(Clone, Copy)]
pub(super) struct NewPoint {
    pub x: Vec3,
    pub strip: [f64; 2],
}

/// Corners of connected triangles around one vertex, and their previous vertices.
struct Fan {
    corners: Vec<u32>, // 3 t + c
    vertices: Vec<u32>,
    point: u32, // index of a point of the cut surface, or `NONE`
}

/// Separates the fans at all `corners` (3 t + c). `point` maps a corner of the new cut surface to its index in `new_points`. Returns each
/// duplicated vertex with its copy.
pub(super) fn duplicate_vertices(
    mesh: &mut CutMesh,
    corners: &[u32],
    point: &HashMap<u32, u32>,
    new_points: &[NewPoint],
) -> Result<Vec<[u32; 2]>, Refused> {
    let fans = fans(mesh, corners, point)?;
    let mut parted = Vec::new();
    let mut taken: HashMap<u32, ()> = HashMap::new();
    let mut at_point: HashMap<u32, u32> = HashMap::new();
    for fan in fans {
        let vertex = match fan.vertices[..] {
            [] => {
                let Some(place) = new_points.get(fan.point as usize) else { continue };
                let first = at_point.get(&fan.point).copied();
                let origin = first.map_or(Origin::Cap { strip: place.strip }, |of| Origin::Copy { of });
                let vertex = mesh.add_vertex(place.x, origin);
                match first {
                    Some(of) => parted.push([of, vertex]),
                    None => _ = at_point.insert(fan.point, vertex),
                }
                vertex
            }
            [vertex] if taken.insert(vertex, ()).is_none() => vertex,
            [of] => {
                let copy = mesh.add_vertex(mesh.surface.points[of as usize], Origin::Copy { of });
                parted.push([of, copy]);
                copy
            }
            [vertex, ..] => {
                return Err(Refused { reason: Refusal::Merged, entity: "vertex", value: f64::from(vertex) });
            }
        };
        for corner in fan.corners {
            if mesh.surface.triangles[corner as usize / 3][corner as usize % 3] != vertex {
                mesh.set_corner(corner, vertex);
            }
        }
    }
    Ok(parted)
}

/// The fans at some corners, by their lowest corner.
fn fans(mesh: &CutMesh, corners: &[u32], point: &HashMap<u32, u32>) -> Result<Vec<Fan>, Refused> {
    let mut seen: HashMap<u32, ()> = HashMap::new();
    let mut fans = Vec::new();
    for &seed in corners {
        if seen.contains_key(&seed) {
            continue;
        }
        let mut fan = Fan { corners: Vec::new(), vertices: Vec::new(), point: NONE };
        let mut waiting = vec![seed];
        while let Some(corner) = waiting.pop() {
            if seen.insert(corner, ()).is_some() {
                continue;
            }
            fan.corners.push(corner);
            let vertex = vertex_at(mesh, corner);
            match point.get(&corner) {
                Some(point) => fan.point = *point,
                None => fan.vertices.push(vertex),
            }
            let before = corner - corner % 3 + (corner + 2 - corner / 3 * 3) % 3;
            for (half, outgoing) in [(corner, true), (before, false)] {
                waiting.extend(mesh.around(half).skip(1).map(|other| same_end(mesh, half, other, outgoing)));
            }
        }
        fan.corners.sort_unstable();
        fan.vertices.sort_unstable();
        fan.vertices.dedup();
        fans.push(fan);
    }
    fans.sort_by_key(|fan| fan.corners[0]);
    Ok(fans)
}

/// The corner of the half-edge `other` at the tail (or head) of `half`; both belong to one edge.
fn same_end(mesh: &CutMesh, half: u32, other: u32, tail: bool) -> u32 {
    let (from, to) = (other, other - other % 3 + (other % 3 + 1) % 3);
    // In a closed body, or if a corner has no vertex yet, the two have opposite directions.
    if mesh.body[half as usize / 3] != OPEN {
        return if tail { to } else { from };
    }
    let vertex = if tail { mesh.tail(half) } else { mesh.head(half) };
    if mesh.tail(other) == vertex { from } else { to }
}

fn vertex_at(mesh: &CutMesh, corner: u32) -> u32 {
    mesh.surface.triangles[corner as usize / 3][corner as usize % 3]
}

/// Inserts a vertex at the midpoint of each of several unconnected edges with the same two vertices, so that unconnected edges always differ in
/// their vertices. Tests all sides of `triangles` and adds the new triangles to them.
pub(super) fn split_coincident_edges(mesh: &mut CutMesh, triangles: &mut Vec<u32>) -> Result<Vec<[u32; 2]>, Refused> {
    const ROUNDS: usize = 16;
    let mut parted = Vec::new();
    for _ in 0..ROUNDS {
        triangles.sort_unstable();
        triangles.dedup();
        let edges = coincident_edges(mesh, triangles);
        if edges.is_empty() {
            return Ok(parted);
        }
        let mut busy: HashMap<u32, ()> = HashMap::new();
        for classes in edges {
            let touched: Vec<u32> = classes.iter().flatten().map(|half| half / 3).collect();
            if touched.iter().any(|triangle| busy.contains_key(triangle)) {
                continue; // handled in the next round
            }
            busy.extend(touched.into_iter().map(|triangle| (triangle, ())));
            let mut first = None;
            for class in classes {
                let ends = [mesh.tail(class[0]), mesh.head(class[0])];
                let x = mesh.point(ends[0].min(ends[1])).lerp(&mesh.point(ends[0].max(ends[1])), 0.5);
                let origin = first.map_or(Origin::Edge { ends, t: 0.5 }, |of| Origin::Copy { of });
                let midpoint = mesh.add_vertex(x, origin);
                match first {
                    Some(of) => parted.push([of, midpoint]),
                    None => first = Some(midpoint),
                }
                let new = split_edge_ring(mesh, &class, midpoint);
                triangles.extend(new);
            }
        }
    }
    Err(Refused { reason: Refusal::Merged, entity: "edges", value: ROUNDS as f64 })
}

/// Groups of unconnected edges with the same two vertices; for each edge its half-edges.
fn coincident_edges(mesh: &CutMesh, triangles: &[u32]) -> Vec<Vec<Vec<u32>>> {
    let mut halves: Vec<(u32, u32, u32, u32)> = triangles
        .iter()
        .flat_map(|&t| [3 * t, 3 * t + 1, 3 * t + 2])
        .map(|half| {
            let (tail, head) = (mesh.tail(half), mesh.head(half));
            (tail.min(head), tail.max(head), mesh.around(half).min().unwrap_or(half), half)
        })
        .collect();
    halves.sort_unstable();
    let same = halves.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    let coincident = same.filter(|edge| edge[0].2 != edge[edge.len() - 1].2);
    let whole = |class: &[(u32, u32, u32, u32)]| mesh.around(class[0].2).collect();
    coincident.map(|edge| edge.chunk_by(|a, b| a.2 == b.2).map(whole).collect()).collect()
}

/// Splits all triangles of an edge at its midpoint. Returns the changed and the new triangles.
pub(super) fn split_edge_ring(mesh: &mut CutMesh, class: &[u32], midpoint: u32) -> Vec<u32> {
    let mut first = Vec::new(); // half-edges from the lower end
    let mut second = Vec::new();
    let mut triangles = Vec::new();
    let low = mesh.tail(class[0]).min(mesh.head(class[0]));
    let mut rows: HashMap<[u32; 2], [u32; 2]> = HashMap::new(); // one midpoint row for each pair of rows
    for &half in class {
        let (triangle, corner) = (half / 3, half as usize % 3);
        let next = (corner + 1) % 3;
        let old = mesh.triangle(triangle);
        let texture = [old.texture[corner], old.texture[next]];
        let key = [texture[0].min(texture[1]), texture[0].max(texture[1])];
        let row = rows.entry(key).or_insert_with(|| {
            let [a, b] = key;
            if a == b || b == NONE {
                return [if a == b { a } else { NONE }; 2];
            }
            let [a, b] = key.map(|row| mesh.texcoords[row as usize]);
            mesh.texcoords.push([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
            [mesh.texcoords.len() as u32 - 1; 2]
        })[0];
        let (mut near, mut far) = (old, old);
        (near.corners[next], far.corners[corner]) = (midpoint, midpoint);
        (near.texture[next], far.texture[corner]) = (row, row);
        // At the midpoint between two normals, either of them is used.
        far.shading[corner] = old.shading[next];
        near.shading[next] = old.shading[next];
        let before = (corner + 2) % 3;
        let made = mesh.add_piece(triangle, far);
        near.links = old.links;
        mesh.set_triangle(triangle, near);
        // The side from the next corner on now belongs to the new triangle.
        let (was, is) = (3 * triangle + next as u32, 3 * made + next as u32);
        rename(mesh, was, is);
        mesh.link_around_edge(&[was, 3 * made + before as u32]);
        let from_low = old.corners[corner] == low;
        let (a, b) = (3 * triangle + corner as u32, 3 * made + corner as u32);
        first.push(if from_low { a } else { b });
        second.push(if from_low { b } else { a });
        triangles.extend([triangle, made]);
    }
    mesh.link_around_edge(&first);
    mesh.link_around_edge(&second);
    triangles
}

/// Replaces the half-edge `old` by `new` in the links of its edge.
pub(super) fn rename(mesh: &mut CutMesh, old: u32, new: u32) {
    let ring: Vec<u32> = mesh.around(old).map(|half| if half == old { new } else { half }).collect();
    mesh.link_around_edge(&ring);
}
