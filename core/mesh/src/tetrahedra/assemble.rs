//! Makes a checked mesh of what a file holds.

use super::boundary;
use super::data;
use super::error::TetMeshProblem;
use super::groups;
use super::index::NodeIndex;
use super::quadratic::{self, Divided, PARTS};
use super::raw::{RawCell, RawMesh};
use super::words::Located;
use super::{Note, TetMesh};
use crate::geometry::{Vec3, place_bits};
use std::path::PathBuf;

/// Six times the volume of a tetrahedron over the cube of its longest edge, below which it is refused as flat: rounding of coordinates with eight digits
/// leaves about this much.
pub(super) const FLAT: f64 = 1e-8;
/// The same, below which a tetrahedron is noted as nearly flat.
const SLIVER: f64 = 1e-3;

/// Makes a mesh, without its name.
///
/// # Errors
/// The byte and the problem of what is not allowed.
pub(super) fn assemble(mut raw: RawMesh) -> Result<TetMesh, Located> {
    check_counts(&raw)?;
    let mut index = NodeIndex::new(&raw)?;
    check_nodes(&raw.points, "point", &index)?;
    check_nodes(&raw.lines, "line", &index)?;
    check_nodes(&raw.triangles, "triangle", &index)?;
    check_nodes(&raw.tetrahedra, "tetrahedron", &index)?;
    check_nodes(&raw.quadratic, "tetrahedron", &index)?;
    let divided = if raw.quadratic.is_empty() {
        raw.leave_out_curved();
        Divided::default()
    } else {
        check_nodes(&raw.curved_lines, "line", &index)?;
        check_nodes(&raw.curved_triangles, "triangle", &index)?;
        quadratic::divide(&mut raw, &index)?
    };
    // All nodes of a quadratic tetrahedron are corners of its parts.
    for node in raw.tetrahedra.iter().flat_map(|cell| cell.nodes) {
        index.mark(node);
    }
    let places = index.number_marked();
    let points: Vec<Vec3> = places.iter().map(|place| raw.nodes[*place].1).collect();
    let node_number: Vec<u64> = places.iter().map(|place| raw.nodes[*place].0).collect();
    let mut notes = Vec::new();
    // All nodes are there and marked.
    let nodes_of = |nodes: &[u64; quadratic::NODES]| nodes.map(|node| index.used(node).unwrap_or_default());
    let quadratic: Vec<[u32; quadratic::NODES]> = divided.cells.iter().map(|cell| nodes_of(&cell.nodes)).collect();
    let mut checked = Checked { turned: divided.turned, first_turned: divided.first_turned, ..Checked::default() };
    let tetrahedra = if quadratic.is_empty() {
        oriented(&raw, &index, &points, &mut checked)?
    } else {
        unfolded(&raw, &divided, &index, &points, &mut checked)?
    };
    checked.note(if quadratic.is_empty() { tetrahedra.len() } else { quadratic.len() }, &mut notes);
    let is_curved = quadratic.iter().any(|nodes| quadratic::is_curved(&nodes.map(|node| points[node as usize])));
    let unused = index.unused().count();
    if let Some(first) = index.unused().next() {
        notes.push(Note::UnusedNodes { count: unused, first: raw.nodes[first].0 });
    }
    coincident(&points, &node_number, &mut notes);
    let element_number: Vec<u64> = match quadratic.is_empty() {
        true => raw.tetrahedra.iter().map(|cell| cell.number).collect(),
        false => divided.cells.iter().map(|cell| cell.number).collect(),
    };
    let boundary = boundary::faces(&tetrahedra, |cells, third| overlap(&raw, cells, third))?;
    boundary::note(&tetrahedra, &boundary, &node_number, &mut notes);
    let mut vertices: Vec<u32> = boundary.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let groups = groups::collect(&raw, &index);
    let data = data::collect(&raw, &index, points.len(), &element_number);
    notes.extend(raw.left_out.iter().map(|(kind, count)| Note::LeftOut { kind, count: *count }));
    if !raw.sections.is_empty() {
        notes.push(Note::Sections(raw.sections));
    }
    Ok(TetMesh {
        name: PathBuf::new(),
        points,
        node_number,
        tetrahedra,
        quadratic,
        is_curved,
        element_number,
        groups,
        data,
        notes,
        boundary,
        vertices,
    })
}

/// Checks that there are tetrahedra, and no more of anything than can be numbered.
fn check_counts(raw: &RawMesh) -> Result<(), Located> {
    if raw.tetrahedra.is_empty() && raw.quadratic.is_empty() {
        let count = |count: usize, what: &str| (count > 0).then(|| format!("{count} {what}"));
        let left_out = raw.left_out.iter().map(|(kind, count)| format!("{count} of kind {kind}"));
        let known =
            [count(raw.nodes.len(), "nodes"), count(raw.triangles.len(), "triangles"), count(raw.lines.len(), "lines")];
        let others: Vec<String> = known.into_iter().flatten().chain(left_out).collect();
        let others = if others.is_empty() { "nothing else either".into() } else { others.join(", ") };
        return Err((raw.end, TetMeshProblem::NoTetrahedra { others }));
    }
    let tetrahedra = raw.tetrahedra.len().max(raw.quadratic.len() * PARTS);
    for (entity, found) in [("nodes", raw.nodes.len()), ("tetrahedra", tetrahedra)] {
        let most = u32::MAX as usize / 4; // four faces each have a number
        if found > most {
            return Err((raw.end, TetMeshProblem::TooMany { entity, found, most }));
        }
    }
    Ok(())
}

/// The problem of a face that two tetrahedra have on one side, or that a third one has.
fn overlap(raw: &RawMesh, cells: [u32; 2], third: Option<u32>) -> Located {
    let [first, second] = cells.map(|cell| &raw.tetrahedra[cell as usize]);
    let (at, a, b) = (second.at, first.number, second.number);
    match third {
        None => (at, TetMeshProblem::Overlap { first: a, second: b }),
        Some(third) => {
            let third = raw.tetrahedra[third as usize].number;
            (at, TetMeshProblem::CommonFace { first: a, second: b, third })
        }
    }
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

/// What was found of the shapes of elements.
#[derive(Default)]
struct Checked {
    /// Number of elements whose nodes were exchanged, and the number in the file of the first of them.
    turned: usize,
    first_turned: Option<u64>,
    /// Number of elements that are nearly flat.
    slivers: usize,
    /// The flattest of these; `None` if there are none.
    worst: Option<Sliver>,
}

/// An element that is nearly flat.
struct Sliver {
    /// Six times its volume over the cube of its longest edge.
    share: f64,
    /// Its number in the file.
    number: u64,
}

impl Checked {
    /// Checks that an element is not flat: six times its volume must be more than a small share of the cube of its longest edge.
    fn flatness(&mut self, at: usize, number: u64, six_volumes: f64, corners: [Vec3; 4]) -> Result<(), Located> {
        let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        let squares = edges.map(|[a, b]| (corners[a] - corners[b]).norm_squared());
        let longest = squares.into_iter().fold(0.0, f64::max).sqrt();
        let share = six_volumes / (longest * longest * longest);
        if share.is_nan() || share < FLAT {
            let share = if share.is_nan() { 0.0 } else { share };
            return Err((at, TetMeshProblem::Flat { number, share, least: FLAT }));
        }
        if share < SLIVER {
            self.slivers += 1;
            if self.worst.as_ref().is_none_or(|worst| share < worst.share) {
                self.worst = Some(Sliver { share, number });
            }
        }
        Ok(())
    }

    /// Notes what was found of `of` elements.
    fn note(self, of: usize, notes: &mut Vec<Note>) {
        if let Some(first) = self.first_turned {
            notes.push(Note::Reoriented { count: self.turned, of, first });
        }
        if let Some(Sliver { share, number }) = self.worst {
            notes.push(Note::Slivers { count: self.slivers, worst: number, share });
        }
    }
}

/// Linear tetrahedra with positive volumes.
fn oriented(
    raw: &RawMesh,
    index: &NodeIndex,
    points: &[Vec3],
    checked: &mut Checked,
) -> Result<Vec<[u32; 4]>, Located> {
    let mut tetrahedra = Vec::with_capacity(raw.tetrahedra.len());
    for cell in &raw.tetrahedra {
        let number = cell.number;
        if let Some(at) = (1..4).find(|at| cell.nodes[..*at].contains(&cell.nodes[*at])) {
            let (node, allowed) = (cell.nodes[at], "four different nodes");
            return Err((cell.at, TetMeshProblem::NodeRepeated { number, node, allowed }));
        }
        // All nodes are there and marked.
        let mut nodes = cell.nodes.map(|node| index.used(node).unwrap_or_default());
        let mut six_volumes = TetMesh::six_volumes(points, nodes);
        if six_volumes < 0.0 {
            nodes.swap(2, 3);
            six_volumes = -six_volumes;
            checked.turned += 1;
            checked.first_turned = checked.first_turned.or(Some(number));
        }
        checked.flatness(cell.at, number, six_volumes, nodes.map(|node| points[node as usize]))?;
        tetrahedra.push(nodes);
    }
    Ok(tetrahedra)
}

/// The parts of quadratic tetrahedra, which are not folded.
fn unfolded(
    raw: &RawMesh,
    divided: &Divided,
    index: &NodeIndex,
    points: &[Vec3],
    checked: &mut Checked,
) -> Result<Vec<[u32; 4]>, Located> {
    let of_part = |cell: &RawCell<4>| cell.nodes.map(|node| index.used(node).unwrap_or_default());
    let tetrahedra: Vec<[u32; 4]> = raw.tetrahedra.iter().map(of_part).collect();
    for (cell, parts) in divided.cells.iter().zip(tetrahedra.as_chunks::<PARTS>().0) {
        let at = cell.nodes.map(|node| index.used(node).map_or(Vec3::zeros(), |node| points[node as usize]));
        let corners = [at[0], at[1], at[2], at[3]];
        checked.flatness(cell.at, cell.number, TetMesh::six_volumes(&at, [0, 1, 2, 3]), corners)?;
        quadratic::check_shape(cell, &at, &parts.map(|part| TetMesh::six_volumes(points, part)))?;
    }
    Ok(tetrahedra)
}

/// Notes nodes at one place.
fn coincident(points: &[Vec3], node_number: &[u64], notes: &mut Vec<Note>) {
    let place = |node: u32| place_bits(points[node as usize]);
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by_key(|node| (place(*node), *node));
    let pairs = || order.windows(2).filter(|pair| place(pair[0]) == place(pair[1]));
    if let Some(first) = pairs().map(|pair| [pair[0], pair[1]]).min_by_key(|pair| pair[1]) {
        let first = first.map(|node| node_number[node as usize]);
        notes.push(Note::CoincidentNodes { count: pairs().count(), first });
    }
}
