//! Opens a body along the lines of a cap surface and stitches the two walls to its faces.
//!
//! Around an edge the body is a ring of faces with substance between them. Where a cap goes off from the edge into the
//! substance, the two faces on either side are joined to the two walls instead of to each other. Where it ends within the
//! substance, the walls are joined to each other. Either way every edge has its two faces.

use super::Vec3;
use super::blade::Facet;
use super::cap::CapSurface;
use super::lines::{Half, Lines, classes};
use super::mesh::CutMesh;
use super::record::{NONE, Triangle};

/// The walls of a cap in the mesh.
#[derive(Default)]
pub(super) struct Walls {
    /// New triangles, each with its points in the cap.
    pub triangles: Vec<(u32, [u32; 3])>,
    /// Area of one wall, m^2.
    pub area: f64,
}

/// What is joined at a line, by layer of the triangle to its left or right.
#[derive(Clone, Copy)]
enum Joint {
    /// A layer and the two faces of a pair.
    Face { left: bool, layer: u32, pair: [u32; 2] },
    /// Layer on the left and layer on the right.
    Through(u32, u32),
    /// The walls of a layer, with each other.
    Front { left: bool, layer: u32 },
}

/// A line with the triangle to its left or the one to its right, and their sides on it.
struct CapLine {
    left: Option<(usize, usize)>,
    right: Option<(usize, usize)>,
    joints: Vec<Joint>,
}

/// Adds the walls of a cap to the mesh; none where it meets no face of the body, as of a blade that is all inside.
pub(super) fn stitch_walls(mesh: &mut CutMesh, cap: &CapSurface, lines: &Lines, facet: &Facet, body: u32) -> Walls {
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
    let mut made: Vec<Vec<[u32; 2]>> = vec![Vec::new(); cap.flats.len()];
    for flat in (0..cap.flats.len()).filter(|&flat| attached[flat]) {
        let [a, b, c] = cap.flats[flat].corners;
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
            made[flat].push([add([a, b, c], shading[0]), add([a, c, b], shading[1])]);
            walls.area += cap.area(flat);
        }
    }
    for flat in (0..cap.flats.len()).filter(|&flat| attached[flat]) {
        for side in (0..3).filter(|&side| cap.line(flat, side).is_none()) {
            let across = cap.flats[flat].across[side] as usize;
            if across < flat {
                continue;
            }
            let back = (0..3).find(|&back| cap.flats[across].across[back] == flat as u32).unwrap_or(0);
            for layer in 0..made[flat].len() {
                let (here, there) = (halves(made[flat][layer], side), halves(made[across][layer], back));
                mesh.link_around_edge(&[here[0], there[0]]);
                mesh.link_around_edge(&[here[1], there[1]]);
            }
        }
    }
    for cap_line in &cap_lines {
        let wall = |left: bool, layer: u32| {
            let (flat, side) = if left { cap_line.left } else { cap_line.right }?;
            made[flat].get(layer as usize).map(|walls| halves(*walls, side))
        };
        for joint in &cap_line.joints {
            match *joint {
                Joint::Face { left, layer, pair } => {
                    // The two walls run along the edge in opposite senses, like the two faces.
                    let Some([front, back]) = wall(left, layer) else { continue };
                    let upward = if left { pair[0] } else { pair[1] }; // runs as the back does
                    let downward = if left { pair[1] } else { pair[0] };
                    mesh.link_around_edge(&[front, downward]);
                    mesh.link_around_edge(&[back, upward]);
                }
                Joint::Through(a, b) => {
                    let (Some(a), Some(b)) = (wall(true, a), wall(false, b)) else { continue };
                    mesh.link_around_edge(&[a[0], b[0]]);
                    mesh.link_around_edge(&[a[1], b[1]]);
                }
                Joint::Front { left, layer } => {
                    let Some(walls) = wall(left, layer) else { continue };
                    mesh.link_around_edge(&walls);
                }
            }
        }
    }
    walls
}

/// The halves of two walls on a side of their triangle: the front wall's goes as the side does, the back's against it.
fn halves([front, back]: [u32; 2], side: usize) -> [u32; 2] {
    [3 * front + side as u32, 3 * back + 2 - side as u32]
}

/// Every line with its triangles, and what is to be joined there.
fn cap_lines(mesh: &CutMesh, cap: &CapSurface, lines: &Lines, body: u32) -> Vec<CapLine> {
    let mut cap_lines = Vec::new();
    for flat in 0..cap.flats.len() {
        for side in 0..3 {
            let across = cap.flats[flat].across[side];
            let Some((line, upward)) = cap.line(flat, side) else { continue };
            if across != NONE && (across as usize) < flat {
                continue; // seen from there
            }
            let there = (across != NONE).then(|| {
                let flats = &cap.flats[across as usize];
                (across as usize, (0..3).find(|&back| flats.across[back] == flat as u32).unwrap_or(0))
            });
            let (left, right) = if upward { (Some((flat, side)), there) } else { (there, Some((flat, side))) };
            let layers = |at: Option<(usize, usize)>| at.map_or(0, |(flat, _)| cap.layers[flat]);
            // Halves are told from the lower node, lines from the lower point.
            let [a, b] = [cap.flats[flat].corners[side], cap.flats[flat].corners[(side + 1) % 3]];
            let node = |point: u32| cap.points[point as usize].node;
            let same = node(a.min(b)) < node(a.max(b));
            let pairs = line.nodes.map(|nodes| pairs(mesh, lines, nodes, body, same)).unwrap_or_default();
            let joints = joints(layers(left), layers(right), &pairs);
            cap_lines.push(CapLine { left, right, joints });
        }
    }
    cap_lines
}

/// Two faces joined at a line: the one that runs upward along it first.
struct Pair {
    halves: [u32; 2],
    side: [i8; 2],
    folded: bool,
}

fn pairs(mesh: &CutMesh, lines: &Lines, nodes: [u32; 2], body: u32, same: bool) -> Vec<Pair> {
    let Some(halves) = lines.halves.get(&nodes) else { return Vec::new() };
    let of_body: Vec<Half> = halves.iter().filter(|half| mesh.body[half.half as usize / 3] == body).copied().collect();
    let mut pairs = Vec::new();
    for class in classes(mesh, &of_body) {
        let [a, b] = class[..] else { continue };
        let (up, down) = if a.upward == same { (a, b) } else { (b, a) };
        if up.upward == down.upward {
            continue;
        }
        let third = |half: &Half| {
            let corner = mesh.surface.triangles[half.half as usize / 3][(half.half as usize + 2) % 3];
            mesh.surface.points[corner as usize]
        };
        pairs.push(Pair {
            halves: [up.half, down.half],
            side: [up.side, down.side],
            folded: third(&up) == third(&down) || (up.side == 0 && down.side == 0),
        });
    }
    pairs
}

/// Shares the layers on either side of a line out.
fn joints(left: u32, right: u32, pairs: &[Pair]) -> Vec<Joint> {
    let (mut left, mut right) = (left, right);
    let mut joints = Vec::new();
    let mut free: Vec<&Pair> = Vec::new();
    for pair in pairs {
        match [pair.side[0] == -1, pair.side[1] == -1] {
            [false, true] if left > 0 => {
                left -= 1;
                joints.push(Joint::Face { left: true, layer: left, pair: pair.halves });
            }
            [true, false] if right > 0 => {
                right -= 1;
                joints.push(Joint::Face { left: false, layer: right, pair: pair.halves });
            }
            _ => free.push(pair),
        }
    }
    while left > 0 && right > 0 {
        (left, right) = (left - 1, right - 1);
        joints.push(Joint::Through(left, right));
    }
    free.retain(|pair| pair.folded || pair.side.contains(&0));
    free.sort_by_key(|pair| !pair.folded);
    let mut free = free.into_iter();
    for (count, is_left) in [(left, true), (right, false)] {
        for layer in (0..count).rev() {
            joints.push(match free.next() {
                Some(pair) => Joint::Face { left: is_left, layer, pair: pair.halves },
                None => Joint::Front { left: is_left, layer },
            });
        }
    }
    joints
}

/// Triangles of the cap that meet a face of the body, if only by others.
fn attached(cap: &CapSurface, cap_lines: &[CapLine]) -> Vec<bool> {
    let mut attached = vec![false; cap.flats.len()];
    let mut waiting = Vec::new();
    for cap_line in cap_lines {
        for joint in &cap_line.joints {
            if let Joint::Face { left, .. } = joint {
                waiting.extend(if *left { cap_line.left } else { cap_line.right }.map(|(flat, _)| flat));
            }
        }
    }
    while let Some(flat) = waiting.pop() {
        if std::mem::replace(&mut attached[flat], true) {
            continue;
        }
        let across = cap.flats[flat].across.into_iter().filter(|&across| across != NONE);
        waiting.extend(across.map(|across| across as usize).filter(|&across| cap.layers[across] > 0));
    }
    attached
}

/// Rows of normals for the front wall and the back, if the document has normals.
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
