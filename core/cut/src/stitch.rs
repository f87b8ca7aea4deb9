//! Opens a body along the edges of a cap surface and connects its faces to the two walls of the cut.
//!
//! The faces around an edge alternate with the interior of the body. If the cap starts at an edge into the interior, the two faces on either side
//! are connected to the two walls instead of to each other. If the cap ends in the interior, the two walls are connected to each other. In both
//! cases every edge keeps two faces.

use super::Vec3;
use super::blade::Facet;
use super::cap::CapSurface;
use super::cut_edges::{CutEdges, HalfEdgeRef, classes};
use super::mesh::CutMesh;
use super::record::{NONE, Triangle};

/// The two walls of a cut that were added to the mesh.
#[derive(Default)]
pub(super) struct Walls {
    /// New triangles, each with the indices of its points in the cap.
    pub triangles: Vec<(u32, [u32; 3])>,
    /// Area of one wall, m^2.
    pub area: f64,
}

/// A new connection of half-edges at an edge of the cap. A layer counts the winding of the body around a triangle of the cap.
#[derive(Clone, Copy)]
enum EdgeLink {
    /// A layer with the two faces of a pair.
    Face { left: bool, layer: u32, pair: [u32; 2] },
    /// The layer on the left with the layer on the right.
    Through(u32, u32),
    /// The two walls of a layer with each other.
    Front { left: bool, layer: u32 },
}

/// An edge of the cap with the triangles to its left and right and their sides on it.
struct CapLine {
    left: Option<(usize, usize)>,
    right: Option<(usize, usize)>,
    edge_links: Vec<EdgeLink>,
}

/// Adds the two walls of a cap to the mesh, except where the cap is connected to no face of the body, as for a blade that is entirely inside.
pub(super) fn stitch_walls(mesh: &mut CutMesh, cap: &CapSurface, lines: &CutEdges, facet: &Facet, body: u32) -> Walls {
    let cap_lines = cap_lines(mesh, cap, lines, body);
    let attached = attached(cap, &cap_lines);
    let mut walls = Walls::default();
    if !attached.contains(&true) {
        return walls;
    }
    let texture: Vec<u32> = cap
        .points
        .iter()
        .map(|point| {
            mesh.texcoords.push(facet.texture_at(point.flat));
            mesh.texcoords.len() as u32 - 1
        })
        .collect();
    let shading = shading(mesh, facet);
    let mut wall_triangles: Vec<Vec<[u32; 2]>> = vec![Vec::new(); cap.triangles.len()];
    for flat in (0..cap.triangles.len()).filter(|&flat| attached[flat]) {
        let [a, b, c] = cap.triangles[flat].corners;
        for _ in 0..cap.layers[flat] {
            let mut add = |points: [u32; 3], row: u32| {
                let triangle = mesh.add_triangle(Triangle {
                    corners: [NONE; 3],
                    links: [0; 3],
                    texture: points.map(|point| texture[point as usize]),
                    shading: [row; 3],
                    face: mesh.uncut.faces as u32,
                    body,
                });
                walls.triangles.push((triangle, points));
                triangle
            };
            wall_triangles[flat].push([add([a, b, c], shading[0]), add([a, c, b], shading[1])]);
            walls.area += cap.area(flat);
        }
    }
    for flat in (0..cap.triangles.len()).filter(|&flat| attached[flat]) {
        for side in (0..3).filter(|&side| cap.line(flat, side).is_none()) {
            let neighbour = cap.triangles[flat].neighbours[side] as usize;
            if neighbour < flat {
                continue;
            }
            let neighbour_side = (0..3)
                .find(|&neighbour_side| cap.triangles[neighbour].neighbours[neighbour_side] == flat as u32)
                .unwrap_or(0);
            for layer in 0..wall_triangles[flat].len() {
                let (here, there) = (
                    halves(wall_triangles[flat][layer], side),
                    halves(wall_triangles[neighbour][layer], neighbour_side),
                );
                mesh.link_around_edge(&[here[0], there[0]]);
                mesh.link_around_edge(&[here[1], there[1]]);
            }
        }
    }
    for cap_line in &cap_lines {
        let wall = |left: bool, layer: u32| {
            let (flat, side) = if left { cap_line.left } else { cap_line.right }?;
            wall_triangles[flat].get(layer as usize).map(|walls| halves(*walls, side))
        };
        for joint in &cap_line.edge_links {
            match *joint {
                EdgeLink::Face { left, layer, pair } => {
                    // The two walls have opposite directions along the edge, like the two faces.
                    let Some([front, back]) = wall(left, layer) else { continue };
                    let upward = if left { pair[0] } else { pair[1] }; // has the direction of the back wall
                    let downward = if left { pair[1] } else { pair[0] };
                    mesh.link_around_edge(&[front, downward]);
                    mesh.link_around_edge(&[back, upward]);
                }
                EdgeLink::Through(a, b) => {
                    let (Some(a), Some(b)) = (wall(true, a), wall(false, b)) else { continue };
                    mesh.link_around_edge(&[a[0], b[0]]);
                    mesh.link_around_edge(&[a[1], b[1]]);
                }
                EdgeLink::Front { left, layer } => {
                    let Some(walls) = wall(left, layer) else { continue };
                    mesh.link_around_edge(&walls);
                }
            }
        }
    }
    walls
}

/// The half-edges of the two walls on a side of a triangle: the front wall has the direction of the side, the back wall the opposite one.
fn halves([front, back]: [u32; 2], side: usize) -> [u32; 2] {
    [3 * front + side as u32, 3 * back + 2 - side as u32]
}

/// All edges of the cap with their triangles and the connections to make.
fn cap_lines(mesh: &CutMesh, cap: &CapSurface, lines: &CutEdges, body: u32) -> Vec<CapLine> {
    let mut cap_lines = Vec::new();
    for flat in 0..cap.triangles.len() {
        for side in 0..3 {
            let neighbour = cap.triangles[flat].neighbours[side];
            let Some((line, upward)) = cap.line(flat, side) else { continue };
            if neighbour != NONE && (neighbour as usize) < flat {
                continue; // handled from the other triangle
            }
            let there = (neighbour != NONE).then(|| {
                let triangles = &cap.triangles[neighbour as usize];
                (neighbour as usize, (0..3).find(|&back| triangles.neighbours[back] == flat as u32).unwrap_or(0))
            });
            let (left, right) = if upward { (Some((flat, side)), there) } else { (there, Some((flat, side))) };
            let layers = |at: Option<(usize, usize)>| at.map_or(0, |(flat, _)| cap.layers[flat]);
            // Half-edges are directed from the lower node, edges of the cap from the lower point.
            let [a, b] = [cap.triangles[flat].corners[side], cap.triangles[flat].corners[(side + 1) % 3]];
            let node = |point: u32| cap.points[point as usize].node;
            let same = node(a.min(b)) < node(a.max(b));
            let pairs = line.nodes.map(|nodes| pairs(mesh, lines, nodes, body, same)).unwrap_or_default();
            let edge_links = edge_links(layers(left), layers(right), &pairs);
            cap_lines.push(CapLine { left, right, edge_links });
        }
    }
    cap_lines
}

/// Two connected faces at an edge; first the one whose half-edge leads from the lower node to the higher.
struct Pair {
    halves: [u32; 2],
    side: [i8; 2],
    folded: bool,
}

fn pairs(mesh: &CutMesh, lines: &CutEdges, nodes: [u32; 2], body: u32, same: bool) -> Vec<Pair> {
    let Some(halves) = lines.halves.get(&nodes) else { return Vec::new() };
    let of_body: Vec<HalfEdgeRef> =
        halves.iter().filter(|half| mesh.body[half.half_edge as usize / 3] == body).copied().collect();
    let mut pairs = Vec::new();
    for class in classes(mesh, &of_body) {
        let [a, b] = class[..] else { continue };
        let (up, down) = if a.upward == same { (a, b) } else { (b, a) };
        if up.upward == down.upward {
            continue;
        }
        let third = |half: &HalfEdgeRef| {
            let corner = mesh.surface.triangles[half.half_edge as usize / 3][(half.half_edge as usize + 2) % 3];
            mesh.surface.points[corner as usize]
        };
        pairs.push(Pair {
            halves: [up.half_edge, down.half_edge],
            side: [up.side, down.side],
            folded: third(&up) == third(&down) || (up.side == 0 && down.side == 0),
        });
    }
    pairs
}

/// Assigns the layers on either side of an edge to faces and to each other.
fn edge_links(left: u32, right: u32, pairs: &[Pair]) -> Vec<EdgeLink> {
    let (mut left, mut right) = (left, right);
    let mut edge_links = Vec::new();
    let mut free: Vec<&Pair> = Vec::new();
    for pair in pairs {
        match [pair.side[0] == -1, pair.side[1] == -1] {
            [false, true] if left > 0 => {
                left -= 1;
                edge_links.push(EdgeLink::Face { left: true, layer: left, pair: pair.halves });
            }
            [true, false] if right > 0 => {
                right -= 1;
                edge_links.push(EdgeLink::Face { left: false, layer: right, pair: pair.halves });
            }
            _ => free.push(pair),
        }
    }
    while left > 0 && right > 0 {
        (left, right) = (left - 1, right - 1);
        edge_links.push(EdgeLink::Through(left, right));
    }
    free.retain(|pair| pair.folded || pair.side.contains(&0));
    free.sort_by_key(|pair| !pair.folded);
    let mut free = free.into_iter();
    for (count, is_left) in [(left, true), (right, false)] {
        for layer in (0..count).rev() {
            edge_links.push(match free.next() {
                Some(pair) => EdgeLink::Face { left: is_left, layer, pair: pair.halves },
                None => EdgeLink::Front { left: is_left, layer },
            });
        }
    }
    edge_links
}

/// Whether each triangle of the cap is connected to a face of the body, directly or through other triangles.
fn attached(cap: &CapSurface, cap_lines: &[CapLine]) -> Vec<bool> {
    let mut attached = vec![false; cap.triangles.len()];
    let mut waiting = Vec::new();
    for cap_line in cap_lines {
        for joint in &cap_line.edge_links {
            if let EdgeLink::Face { left, .. } = joint {
                waiting.extend(if *left { cap_line.left } else { cap_line.right }.map(|(flat, _)| flat));
            }
        }
    }
    while let Some(flat) = waiting.pop() {
        if std::mem::replace(&mut attached[flat], true) {
            continue;
        }
        let neighbour = cap.triangles[flat].neighbours.into_iter().filter(|&neighbour| neighbour != NONE);
        waiting.extend(neighbour.map(|neighbour| neighbour as usize).filter(|&neighbour| cap.layers[neighbour] > 0));
    }
    attached
}

/// Rows of normals for the front and the back wall; [`NONE`] if the document has no normals.
fn shading(mesh: &mut CutMesh, facet: &Facet) -> [u32; 2] {
    if mesh.uncut.normals == 0 {
        return [NONE; 2];
    }
    let normal = mesh.placement.rotation.inverse() * facet.normal;
    let rows: [Vec3; 2] = [normal, -normal];
    mesh.normals.extend(rows);
    let count = mesh.normals.len() as u32;
    [count - 2, count - 1]
}
