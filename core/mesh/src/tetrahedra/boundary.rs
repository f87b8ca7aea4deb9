//! The boundary of a tetrahedral mesh: faces of one tetrahedron.

use super::words::Located;
use super::{Note, TetMesh, TetMeshError};
use crate::{EdgeTable, ObjDocument};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Corners of the faces of a tetrahedron with positive volume, counter-clockwise seen from outside; face i is opposite to corner i.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The tetrahedron on the other side of each face of each tetrahedron (m x 4), [`NO_NEIGHBOUR`] where there is none. Of three and more at a face the first two
/// are neighbours.
pub fn neighbours(tetrahedra: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let mut all: Vec<([u32; 3], u32)> = Vec::with_capacity(4 * tetrahedra.len());
    for (nodes, tetrahedron) in tetrahedra.iter().zip(0..) {
        for (face, corners) in FACES.iter().zip(0..) {
            let mut sorted = face.map(|corner| nodes[corner]);
            sorted.sort_unstable();
            all.push((sorted, 4 * tetrahedron + corners));
        }
    }
    all.sort_unstable();
    let mut neighbours = vec![[NO_NEIGHBOUR; 4]; tetrahedra.len()];
    for group in all.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b), ..] = *group {
            neighbours[a as usize / 4][a as usize % 4] = b / 4;
            neighbours[b as usize / 4][b as usize % 4] = a / 4;
        }
    }
    neighbours
}

/// In the place of a neighbour: the face is on the boundary.
pub const NO_NEIGHBOUR: u32 = u32::MAX;

/// Faces of one tetrahedron, counter-clockwise seen from outside, in the order of the tetrahedra (b x 3). Faces of two are inside, and `refuse` makes the error of
/// two that are on the same side of it, and of three at a face.
pub(super) fn faces(
    tetrahedra: &[[u32; 4]],
    refuse: impl Fn([u32; 2], Option<u32>) -> Located,
) -> Result<Vec<[u32; 3]>, Located> {
    // The sorted corners of each face, and the face: four times its tetrahedron, plus its number there.
    let mut all: Vec<([u32; 3], u32)> = Vec::with_capacity(4 * tetrahedra.len());
    let corners = |face: u32| FACES[face as usize % 4].map(|corner| tetrahedra[face as usize / 4][corner]);
    for face in 0..4 * tetrahedra.len() as u32 {
        let mut sorted = corners(face);
        sorted.sort_unstable();
        all.push((sorted, face));
    }
    all.sort_unstable();
    let mut outer = Vec::new();
    for group in all.chunk_by(|a, b| a.0 == b.0) {
        match *group {
            [(_, face)] => outer.push(face),
            [(_, a), (_, b)] if is_even(corners(a)) == is_even(corners(b)) => return Err(refuse([a / 4, b / 4], None)),
            [_, _] => {}
            [(_, a), (_, b), (_, c), ..] => return Err(refuse([a / 4, b / 4], Some(c / 4))),
            [] => {}
        }
    }
    outer.sort_unstable();
    Ok(outer.into_iter().map(corners).collect())
}

/// Whether three numbers are an even permutation of their ascending order.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    (u32::from(a > b) + u32::from(a > c) + u32::from(b > c)).is_multiple_of(2)
}

/// Notes edges of the boundary with more than two triangles, and parts that share no node.
pub(super) fn note(tetrahedra: &[[u32; 4]], boundary: &[[u32; 3]], node_number: &[u64], notes: &mut Vec<Note>) {
    let edges = EdgeTable::new(boundary);
    let mut wrong = edges.iter().filter(|(_, sides)| sides.len() != 2).map(|(ends, _)| ends);
    if let Some(first) = wrong.next() {
        notes.push(Note::NonManifold { edges: 1 + wrong.count(), first: first.map(|node| node_number[node as usize]) });
    }
    let mut root: Vec<u32> = (0..node_number.len() as u32).collect();
    for corners in tetrahedra {
        for pair in corners.windows(2) {
            let [a, b] = [find(&mut root, pair[0]), find(&mut root, pair[1])];
            root[a.max(b) as usize] = a.min(b);
        }
    }
    let count = (0..root.len() as u32).filter(|node| root[*node as usize] == *node).count();
    if count > 1 {
        notes.push(Note::Parts { count });
    }
}

/// The least node of the set of a node; halves the way to it.
fn find(root: &mut [u32], mut node: u32) -> u32 {
    while root[node as usize] != node {
        root[node as usize] = root[root[node as usize] as usize];
        node = root[node as usize];
    }
    node
}

/// The boundary as a document.
pub(super) fn document(mesh: &TetMesh) -> Result<ObjDocument, TetMeshError> {
    let file = mesh.name.file_name().map(|name| name.to_string_lossy().replace(char::is_control, "?"));
    let mut text = format!("# boundary of {}\n", file.unwrap_or_default());
    let mut vertex_of = vec![0_u32; mesh.points.len()];
    for (vertex, &node) in mesh.vertices.iter().enumerate() {
        vertex_of[node as usize] = vertex as u32;
        let point = mesh.points[node as usize];
        let [x, y, z] = [point.x, point.y, point.z];
        _ = writeln!(text, "v {x:?} {y:?} {z:?}"); // a String takes everything
    }
    let names = names_by_face(mesh);
    let mut now = "";
    for face in &mesh.boundary {
        let mut sorted = *face;
        sorted.sort_unstable();
        let name = names.get(&sorted).map_or("", String::as_str);
        if name != now {
            _ = writeln!(text, "g {name}");
            now = name;
        }
        let [a, b, c] = face.map(|node| vertex_of[node as usize] + 1);
        _ = writeln!(text, "f {a} {b} {c}");
    }
    let parsed = ObjDocument::parse(text.into_bytes(), &mesh.name);
    parsed.map_err(|error| TetMeshError::Boundary { file: mesh.name.clone(), error })
}

/// Names of the groups of each face in one, with blanks between.
fn names_by_face(mesh: &TetMesh) -> BTreeMap<[u32; 3], String> {
    let mut names: BTreeMap<[u32; 3], String> = BTreeMap::new();
    for group in &mesh.groups {
        for face in &group.faces {
            let name = names.entry(*face).or_default();
            if !name.is_empty() {
                name.push(' ');
            }
            name.push_str(&group.name);
        }
    }
    names
}
