//! Makes a checked mesh of what a file holds.

use super::boundary;
use super::error::TetMeshProblem;
use super::groups;
use super::index::NodeIndex;
use super::raw::{RawCell, RawMesh};
use super::words::Located;
use super::{Note, TetMesh};
use crate::geometry::Vec3;
use std::path::PathBuf;

/// Six times the volume of a tetrahedron over the cube of its longest edge, below which it is refused as flat: rounding of coordinates with eight digits
/// leaves about this much.
const FLAT: f64 = 1e-8;
/// The same, below which a tetrahedron is noted as nearly flat.
const SLIVER: f64 = 1e-3;

/// Makes a mesh, without its name.
///
/// # Errors
/// The byte and the problem of what is not allowed.
pub(super) fn assemble(raw: RawMesh) -> Result<TetMesh, Located> {
    if raw.tetrahedra.is_empty() {
        let count = |count: usize, what: &str| (count > 0).then(|| format!("{count} {what}"));
        let left_out = raw.left_out.iter().map(|(kind, count)| format!("{count} of kind {kind}"));
        let known =
            [count(raw.nodes.len(), "nodes"), count(raw.triangles.len(), "triangles"), count(raw.lines.len(), "lines")];
        let others: Vec<String> = known.into_iter().flatten().chain(left_out).collect();
        let others = if others.is_empty() { "nothing else either".into() } else { others.join(", ") };
        return Err((raw.end, TetMeshProblem::NoTetrahedra { others }));
    }
    for (entity, found) in [("nodes", raw.nodes.len()), ("tetrahedra", raw.tetrahedra.len())] {
        let most = u32::MAX as usize / 4; // four faces each have a number
        if found > most {
            return Err((raw.end, TetMeshProblem::TooMany { entity, found, most }));
        }
    }
    let mut index = NodeIndex::new(&raw)?;
    check_nodes(&raw.points, "point", &index)?;
    check_nodes(&raw.lines, "line", &index)?;
    check_nodes(&raw.triangles, "triangle", &index)?;
    check_nodes(&raw.tetrahedra, "tetrahedron", &index)?;
    for node in raw.tetrahedra.iter().flat_map(|cell| cell.nodes) {
        index.mark(node);
    }
    let places = index.number_marked();
    let points: Vec<Vec3> = places.iter().map(|place| raw.nodes[*place].1).collect();
    let node_number: Vec<u64> = places.iter().map(|place| raw.nodes[*place].0).collect();
    let mut notes = Vec::new();
    let tetrahedra = oriented(&raw, &index, &points, &mut notes)?;
    let unused = index.unused().count();
    if let Some(first) = index.unused().next() {
        notes.push(Note::UnusedNodes { count: unused, first: raw.nodes[first].0 });
    }
    coincident(&points, &node_number, &mut notes);
    let element_number: Vec<u64> = raw.tetrahedra.iter().map(|cell| cell.number).collect();
    let boundary = boundary::faces(&tetrahedra, |[first, second], third| {
        let [first, second] = [first, second].map(|cell| &raw.tetrahedra[cell as usize]);
        let (at, a, b) = (second.at, first.number, second.number);
        match third {
            None => (at, TetMeshProblem::Overlap { first: a, second: b }),
            Some(third) => {
                let third = raw.tetrahedra[third as usize].number;
                (at, TetMeshProblem::CommonFace { first: a, second: b, third })
            }
        }
    })?;
    boundary::note(&tetrahedra, &boundary, &node_number, &mut notes);
    let mut vertices: Vec<u32> = boundary.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let groups = groups::collect(&raw, &index);
    notes.extend(raw.left_out.iter().map(|(kind, count)| Note::LeftOut { kind, count: *count }));
    if !raw.sections.is_empty() {
        notes.push(Note::Sections(raw.sections));
    }
    Ok(TetMesh {
        name: PathBuf::new(),
        points,
        node_number,
        tetrahedra,
        element_number,
        groups,
        notes,
        boundary,
        vertices,
    })
}

/// Checks that all nodes of cells are there.
fn check_nodes<const CORNERS: usize>(
    cells: &[RawCell<CORNERS>],
    cell: &'static str,
    index: &NodeIndex,
) -> Result<(), Located> {
    for of in cells {
        if let Some(&node) = of.nodes.iter().find(|node| index.place(**node).is_none()) {
            let problem = TetMeshProblem::NoNode { cell, number: of.number, node, allowed: index.allowed() };
            return Err((of.at, problem));
        }
    }
    Ok(())
}

/// The tetrahedra with positive volumes.
fn oriented(
    raw: &RawMesh,
    index: &NodeIndex,
    points: &[Vec3],
    notes: &mut Vec<Note>,
) -> Result<Vec<[u32; 4]>, Located> {
    let mut tetrahedra = Vec::with_capacity(raw.tetrahedra.len());
    let (mut turned, mut first_turned) = (0, None);
    let (mut slivers, mut worst) = (0, (f64::INFINITY, 0));
    for cell in &raw.tetrahedra {
        let number = cell.number;
        if let Some(at) = (1..4).find(|at| cell.nodes[..*at].contains(&cell.nodes[*at])) {
            return Err((cell.at, TetMeshProblem::NodeRepeated { number, node: cell.nodes[at] }));
        }
        // All nodes are there and marked.
        let mut nodes = cell.nodes.map(|node| index.used(node).unwrap_or_default());
        let mut six_volumes = TetMesh::six_volumes(points, nodes);
        if six_volumes < 0.0 {
            nodes.swap(2, 3);
            six_volumes = -six_volumes;
            turned += 1;
            first_turned = first_turned.or(Some(number));
        }
        let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        let squares = edges.map(|[a, b]| (points[nodes[a] as usize] - points[nodes[b] as usize]).norm_squared());
        let longest = squares.into_iter().fold(0.0, f64::max).sqrt();
        let share = six_volumes / (longest * longest * longest);
        if share.is_nan() || share < FLAT {
            let share = if share.is_nan() { 0.0 } else { share };
            return Err((cell.at, TetMeshProblem::Flat { number, share, least: FLAT }));
        }
        if share < SLIVER {
            slivers += 1;
            worst = if share < worst.0 { (share, number) } else { worst };
        }
        tetrahedra.push(nodes);
    }
    if let Some(first) = first_turned {
        notes.push(Note::Reoriented { count: turned, of: tetrahedra.len(), first });
    }
    if slivers > 0 {
        notes.push(Note::Slivers { count: slivers, worst: worst.1, share: worst.0 });
    }
    Ok(tetrahedra)
}

/// Notes nodes at one place.
fn coincident(points: &[Vec3], node_number: &[u64], notes: &mut Vec<Note>) {
    // -0 is at the place of 0.
    let place = |node: u32| <[f64; 3]>::from(points[node as usize]).map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by_key(|node| (place(*node), *node));
    let pairs = || order.windows(2).filter(|pair| place(pair[0]) == place(pair[1]));
    if let Some(first) = pairs().map(|pair| [pair[0], pair[1]]).min_by_key(|pair| pair[1]) {
        let first = first.map(|node| node_number[node as usize]);
        notes.push(Note::CoincidentNodes { count: pairs().count(), first });
    }
}
