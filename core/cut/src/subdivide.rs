//! Subdivision of the triangles that a facet intersects, so that the intersection lines become edges.
//!
//! A triangle is split along the whole line of the plane, also beyond the facet; only the piece within is opened. A straight stroke, which
//! continues along the same line, finds its edges already there, and the end of the blade causes no small angles.

use std::collections::{BTreeSet, HashMap};

use super::Vec3;
use super::error::{Refusal, Refused};
use super::mesh::CutMesh;
use super::polygon::{Vertex, smallest_angle, triangulate};
use super::record::{NONE, Origin, Triangle};
use super::trace::{Location, Trace};

/// Result of the subdivision.
#[derive(Default)]
pub(super) struct Split {
    /// Node of each new vertex.
    pub node: HashMap<u32, u32>,
    /// All triangles that may have a side on a line, including pieces; ascending.
    pub triangles: Vec<u32>,
    vertex: HashMap<([u32; 2], u32), u32>, // by ends of the edge, or triangle and `NONE`, and node
    texture: HashMap<([u32; 2], u32), u32>, // row, by rows at the ends and node
    shading: HashMap<([u32; 2], u32), u32>,
}

/// A vertex on the boundary of a triangle, or on the line through it.
#[derive(Clone, Copy)]
struct Item {
    vertex: u32,
    node: u32,
    weights: Vec3,
    rows: [u32; 2], // texture, shading
    sides: u8,
}

const LINE: u8 = 8;

/// Splits all triangles that contain pieces of lines within the facet. No new angle is smaller than `sharpest` (degrees), except in triangles that
/// had nearly such an angle.
pub(super) fn subdivide(mesh: &mut CutMesh, trace: &Trace, near: &[u32], sharpest: f64) -> Result<Split, Refused> {
    let mut split = Split::default();
    let wanted = wanted(trace);
    let mut triangles: BTreeSet<u32> = near.iter().copied().collect();
    triangles.extend(beside(mesh, trace, near, &wanted));
    let mut pieces = Vec::new();
    for &triangle in &triangles {
        let inside = near.binary_search(&triangle).is_ok();
        let across = inside.then(|| trace.run_across(mesh.surface.triangles[triangle as usize])).flatten();
        let across = across.filter(|&run| trace.runs[run as usize].piece.is_some());
        let outline = split.outline(mesh, trace, triangle, &wanted);
        if outline.len() == 3 && across.is_none() {
            continue;
        }
        pieces.push((triangle, split.polygons(mesh, trace, triangle, outline, across)?));
    }
    let whole = |half: &u32| pieces.binary_search_by_key(&(half / 3), |(triangle, _)| *triangle).is_err();
    let sides = pieces.iter().flat_map(|(triangle, _)| 3 * triangle..3 * triangle + 3);
    let mut loose: Vec<u32> = sides.flat_map(|half| mesh.around(half).filter(whole)).collect(); // to be linked again
    let mut changed = Vec::new();
    for (triangle, polygons) in &pieces {
        changed.extend(replace(mesh, *triangle, polygons, sharpest)?);
    }
    loose.extend(changed.iter().flat_map(|t| [3 * t, 3 * t + 1, 3 * t + 2]));
    join(mesh, loose);
    triangles.extend(changed);
    split.triangles = triangles.into_iter().collect();
    Ok(split)
}

/// Links half-edges with the same two vertices; `halves` contains all or none of the half-edges of an edge.
pub(super) fn join(mesh: &mut CutMesh, mut halves: Vec<u32>) {
    let key = |mesh: &CutMesh, half: u32| {
        let (tail, head) = (mesh.tail(half), mesh.head(half));
        (tail.min(head), tail.max(head))
    };
    halves.sort_unstable();
    halves.dedup();
    halves.sort_by_key(|&half| key(mesh, half));
    let groups: Vec<&[u32]> = halves.chunk_by(|&a, &b| key(mesh, a) == key(mesh, b)).collect();
    for group in groups {
        mesh.link_around_edge(group);
    }
}

/// Whether each node becomes a vertex.
fn wanted(trace: &Trace) -> Vec<bool> {
    let mut wanted = vec![false; trace.nodes.len()];
    for run in trace.runs.iter().filter(|run| !run.is_open_already()) {
        if let Some(piece) = run.piece {
            run.ends.iter().chain(&piece).for_each(|&node| wanted[node as usize] = true);
        }
    }
    wanted
}

/// Triangles that are not near the facet but get a vertex on a side: neighbours, and triangles on the other side of an open cut.
fn beside(mesh: &CutMesh, trace: &Trace, near: &[u32], wanted: &[bool]) -> Vec<u32> {
    let mut found = Vec::new();
    for &triangle in near {
        for half in 3 * triangle..3 * triangle + 3 {
            let nodes = trace.nodes_on(mesh, mesh.tail(half), mesh.head(half));
            for node in nodes.into_iter().filter(|&node| wanted[node as usize]) {
                found.extend(mesh.around(half).map(|half| half / 3));
                mesh.tree.near(trace.nodes[node as usize].x, 0.0, |other| {
                    let on = |half: u32| trace.nodes_on(mesh, mesh.tail(half), mesh.head(half)).contains(&node);
                    if (3 * other..3 * other + 3).any(on) {
                        found.push(other);
                    }
                });
            }
        }
    }
    found
}

impl Split {
    /// The node at a vertex, or [`NONE`].
    pub fn node_of(&self, mesh: &CutMesh, trace: &Trace, vertex: u32) -> u32 {
        self.node.get(&vertex).copied().or_else(|| trace.node_at(mesh, vertex)).unwrap_or(NONE)
    }

    /// The boundary of a triangle with the new vertices on its sides.
    fn outline(&mut self, mesh: &mut CutMesh, trace: &Trace, triangle: u32, wanted: &[bool]) -> Vec<Item> {
        let record = mesh.triangle(triangle);
        let mut outline = Vec::new();
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let [a, b] = [corner, next].map(|at| record.corners[at]);
            let sides = (1 << corner) | (1 << ((corner + 2) % 3));
            let start = Item {
                vertex: a,
                node: trace.node_at(mesh, a).unwrap_or(NONE),
                weights: Vec3::from_fn(|i, _| if i == corner { 1.0 } else { 0.0 }),
                rows: [record.texture[corner], record.shading[corner]],
                sides,
            };
            let end_rows = [record.texture[next], record.shading[next]];
            outline.push(start);
            for node in trace.nodes_on(mesh, a, b) {
                let Location::Edge(sites, t) = trace.nodes[node as usize].place else { continue };
                if !wanted[node as usize] {
                    continue;
                }
                let upward = trace.site(mesh, a) == Some(sites[0]);
                let (ends, rows) =
                    if upward { ([a, b], [start.rows, end_rows]) } else { ([b, a], [end_rows, start.rows]) };
                let from_start = if upward { t } else { 1.0 - t };
                let mut weights = Vec3::zeros();
                (weights[corner], weights[next]) = (1.0 - from_start, from_start);
                let edge = [a.min(b), a.max(b)];
                let vertex = self.vertex(mesh, trace, edge, node, Origin::Edge { ends, t });
                outline.push(Item { vertex, node, weights, rows: self.rows(mesh, rows, t, node), sides: 1 << corner });
            }
        }
        outline
    }

    /// The polygons on either side of the line through a triangle; the whole boundary if there is no line.
    fn polygons(
        &mut self,
        mesh: &mut CutMesh,
        trace: &Trace,
        triangle: u32,
        mut outline: Vec<Item>,
        across: Option<u32>,
    ) -> Result<Vec<Vec<Item>>, Refused> {
        let Some(run) = across.map(|run| &trace.runs[run as usize]) else { return Ok(vec![outline]) };
        let unclear = Refused { reason: Refusal::Crossed, entity: "triangle", value: f64::from(triangle) };
        let place = |node: u32| outline.iter().position(|item| item.node == node);
        let (Some(from), Some(to)) = (place(run.ends[0]), place(run.ends[1])) else { return Err(unclear) };
        let corners = mesh.surface.triangles[triangle as usize];
        let ends = [outline[from], outline[to]];
        let mut line = Vec::new();
        for node in run.piece.into_iter().flatten().filter(|node| !run.ends.contains(node)) {
            let Location::Face(between, t) = trace.nodes[node as usize].place else { return Err(unclear) };
            let [low, high] = if between[0] == run.ends[0] { ends } else { [ends[1], ends[0]] };
            let weights = low.weights + t * (high.weights - low.weights);
            let vertex = self.vertex(mesh, trace, [triangle, NONE], node, Origin::Face { corners, weights });
            line.push(Item {
                vertex,
                node,
                weights,
                rows: self.rows(mesh, [low.rows, high.rows], t, node),
                sides: LINE,
            });
        }
        outline[from].sides |= LINE;
        outline[to].sides |= LINE;
        outline.rotate_left(from);
        let to = (to + outline.len() - from) % outline.len();
        let mut second: Vec<Item> = outline[to..].to_vec();
        second.push(outline[0]);
        second.extend(&line);
        outline.truncate(to + 1);
        outline.extend(line.iter().rev());
        Ok(vec![outline, second])
    }

    /// The vertex of a node of the trace at a site, which is an edge by its ends, ascending, or a triangle and `NONE`; it is added where there is none yet.
    fn vertex(&mut self, mesh: &mut CutMesh, trace: &Trace, site: [u32; 2], node: u32, origin: Origin) -> u32 {
        let vertex =
            *self.vertex.entry((site, node)).or_insert_with(|| mesh.add_vertex(trace.nodes[node as usize].x, origin));
        self.node.insert(vertex, node);
        vertex
    }

    /// Rows of a new vertex at the parameter `t` between two others.
    fn rows(&mut self, mesh: &mut CutMesh, [from, to]: [[u32; 2]; 2], t: f64, node: u32) -> [u32; 2] {
        let mix = |a: f64, b: f64| a + t * (b - a);
        let texture = between([from[0], to[0]], node, &mut self.texture, || {
            let [a, b] = [from[0], to[0]].map(|row| mesh.texcoords[row as usize]);
            mesh.texcoords.push([mix(a[0], b[0]), mix(a[1], b[1])]);
            mesh.texcoords.len() as u32 - 1
        });
        let shading = between([from[1], to[1]], node, &mut self.shading, || {
            let [a, b] = [from[1], to[1]].map(|row| mesh.normals[row as usize]);
            let length = mix(a.norm(), b.norm());
            let normal = a.lerp(&b, t).try_normalize(1e-9).unwrap_or(a);
            mesh.normals.push(length * normal);
            mesh.normals.len() as u32 - 1
        });
        [texture, shading]
    }
}

fn between(rows: [u32; 2], node: u32, known: &mut HashMap<([u32; 2], u32), u32>, make: impl FnOnce() -> u32) -> u32 {
    if rows.contains(&NONE) || rows[0] == rows[1] {
        return if rows[0] == rows[1] { rows[0] } else { NONE };
    }
    *known.entry((rows, node)).or_insert_with(make)
}

/// Replaces a triangle by the triangulations of some polygons and returns them. No angle may be smaller than `sharpest` (degrees), unless the
/// triangle had nearly such an angle.
fn replace(mesh: &mut CutMesh, triangle: u32, polygons: &[Vec<Item>], sharpest: f64) -> Result<Vec<u32>, Refused> {
    let record = mesh.triangle(triangle);
    let cross = mesh.cross(triangle);
    let whole = mesh.corners_of(triangle);
    let sharpest = sharpest.min(0.1 * smallest_angle(whole));
    let mut made = Vec::new();
    let mut area = 0.0;
    for polygon in polygons {
        let vertices: Vec<Vertex> =
            polygon.iter().map(|item| Vertex { x: mesh.point(item.vertex), sides: item.sides }).collect();
        let sliver = |value: f64| Refused { reason: Refusal::Sliver, entity: "triangle", value };
        for piece in triangulate(&vertices).ok_or(sliver(0.0))? {
            let corners = piece.map(|at| vertices[at].x);
            let turned = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let angle = smallest_angle(corners);
            if angle < sharpest || turned.dot(&cross) <= 0.0 {
                return Err(sliver(angle));
            }
            area += turned.norm();
            let items = piece.map(|at| polygon[at]);
            let new = Triangle {
                corners: items.map(|item| item.vertex),
                texture: items.map(|item| item.rows[0]),
                shading: items.map(|item| item.rows[1]),
                links: [0; 3],
                ..record
            };
            if made.is_empty() {
                mesh.set_triangle(triangle, new);
                made.push(triangle);
            } else {
                made.push(mesh.add_piece(triangle, new));
            }
        }
    }
    let longest = (0..3).map(|i| (whole[i] - whole[(i + 1) % 3]).norm_squared()).fold(0.0, f64::max);
    if (area - cross.norm()).abs() > 1e-12 * cross.norm() + 1e-14 * longest {
        return Err(Refused { reason: Refusal::Sliver, entity: "area", value: area - cross.norm() });
    }
    Ok(made)
}
