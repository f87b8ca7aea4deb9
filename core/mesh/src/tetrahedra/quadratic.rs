//! Quadratic tetrahedra of a file: checks, and their eight parts.
//!
//! Surfaces, contact and points inside follow linear tetrahedra, so a quadratic one is divided into eight whose corners are its ten nodes: one at each corner,
//! and four between them around the shortest of three diagonals. So an outer face of six nodes is four triangles.

use super::TetMesh;
use super::assemble::FLAT;
use super::error::TetMeshProblem;
use super::index::NodeIndex;
use super::raw::{RawCell, RawMesh};
use super::words::Located;
use crate::geometry::Vec3;
use std::collections::HashMap;

/// Nodes of a quadratic tetrahedron: its corners, and the middles of its edges in the order of [`EDGES`].
pub const NODES: usize = 10;
/// Linear tetrahedra into which a quadratic one is divided.
pub const PARTS: usize = 8;

/// Ends of the edges whose middles are nodes 4 to 9.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
/// Order of the nodes of a quadratic tetrahedron after corners 2 and 3 have been exchanged.
const TURNED: [usize; NODES] = [0, 1, 3, 2, 4, 8, 7, 6, 5, 9];
/// Nodes of the part at each corner, which stands at its own place.
const OUTER: [[usize; 4]; 4] = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];
/// Middles of the edges of the face opposite to each corner, counter-clockwise seen from outside.
const MIDDLES: [[usize; 3]; 4] = [[5, 9, 8], [7, 9, 6], [4, 8, 7], [6, 5, 4]];
/// Ends of the three diagonals between opposite edges.
const DIAGONALS: [[usize; 2]; 3] = [[4, 9], [5, 7], [6, 8]];

/// Largest distance of a node from the middle of its straight edge, as a share of the edge, up to which the edge counts as straight: rounding of coordinates
/// with eight digits leaves less.
const STRAIGHT: f64 = 1e-6;

/// The quadratic tetrahedra of a file after [`divide`].
#[derive(Default)]
pub(super) struct Divided {
    /// The elements, with their corners in the order of a positive volume.
    pub cells: Vec<RawCell<NODES>>,
    /// Number of elements that the file has in the other order.
    pub turned: usize,
    /// Number in the file of the first of them.
    pub first_turned: Option<u64>,
}

/// Takes the quadratic tetrahedra of a file out, and lists their parts among the tetrahedra and those of curved triangles and lines among straight ones.
///
/// # Errors
/// Linear tetrahedra beside quadratic ones, an edge with two middles, and a node that is a corner and a middle.
pub(super) fn divide(raw: &mut RawMesh, index: &NodeIndex) -> Result<Divided, Located> {
    let mut cells = std::mem::take(&mut raw.quadratic);
    if let (Some(linear), Some(quadratic)) = (raw.tetrahedra.first(), cells.first()) {
        let at = linear.at.max(quadratic.at);
        return Err((at, TetMeshProblem::Mixed { linear: linear.number, quadratic: quadratic.number }));
    }
    let place = |node: u64| index.place(node).map_or(Vec3::zeros(), |place| raw.nodes[place].1);
    let (mut turned, mut first_turned) = (0, None);
    for cell in &mut cells {
        if let Some(at) = (1..NODES).find(|at| cell.nodes[..*at].contains(&cell.nodes[*at])) {
            let (number, node) = (cell.number, cell.nodes[at]);
            return Err((cell.at, TetMeshProblem::NodeRepeated { number, node, allowed: "ten different nodes" }));
        }
        let points = cell.nodes.map(place);
        if TetMesh::six_volumes(&points, [0, 1, 2, 3]) < 0.0 {
            cell.nodes = TURNED.map(|node| cell.nodes[node]);
            turned += 1;
            first_turned = first_turned.or(Some(cell.number));
        }
        raw.tetrahedra.extend(parts(cell.nodes, place).map(|nodes| cell.with_nodes(nodes)));
    }
    check_edges(&cells)?;
    for cell in std::mem::take(&mut raw.curved_triangles) {
        let [a, b, c, ab, bc, ca] = cell.nodes;
        let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
        raw.triangles.extend(parts.map(|nodes| cell.with_nodes(nodes)));
    }
    for cell in std::mem::take(&mut raw.curved_lines) {
        let [a, b, middle] = cell.nodes;
        raw.lines.extend([[a, middle], [middle, b]].map(|nodes| cell.with_nodes(nodes)));
    }
    Ok(Divided { cells, turned, first_turned })
}

/// The parts of a quadratic tetrahedron: that at each corner, and that at the middle of the face opposite to each.
fn parts(nodes: [u64; NODES], place: impl Fn(u64) -> Vec3) -> [[u64; 4]; PARTS] {
    let length = |[a, b]: [usize; 2]| (place(nodes[a]) - place(nodes[b])).norm_squared();
    let shortest = DIAGONALS.into_iter().reduce(|best, other| if length(other) < length(best) { other } else { best });
    let [a, b] = shortest.unwrap_or(DIAGONALS[0]);
    let inner = MIDDLES.map(|face| {
        let apex = if face.contains(&a) { b } else { a };
        [apex, face[0], face[1], face[2]]
    });
    let all: [[usize; 4]; PARTS] = std::array::from_fn(|part| if part < 4 { OUTER[part] } else { inner[part - 4] });
    all.map(|part| part.map(|node| nodes[node]))
}

/// Checks that elements agree about the middles of their common edges.
fn check_edges(cells: &[RawCell<NODES>]) -> Result<(), Located> {
    /// A node in one of two roles, with the element that has it so.
    #[derive(Clone, Copy)]
    enum Role {
        Corner(u64),
        Middle([u64; 2], u64),
    }
    let mut middle_of: HashMap<[u64; 2], (u64, u64)> = HashMap::new();
    let mut role_of: HashMap<u64, Role> = HashMap::new();
    for cell in cells {
        let second = cell.number;
        for corner in &cell.nodes[..4] {
            if let Role::Middle(_, first) = *role_of.entry(*corner).or_insert(Role::Corner(second)) {
                return Err((cell.at, TetMeshProblem::CornerAndMiddle { node: *corner, first, second }));
            }
        }
        for (ends, &middle) in EDGES.iter().zip(&cell.nodes[4..]) {
            let [a, b] = ends.map(|corner| cell.nodes[corner]);
            let edge = [a.min(b), a.max(b)];
            let &mut (known, first) = middle_of.entry(edge).or_insert((middle, second));
            if known != middle {
                let problem = TetMeshProblem::Middles { edge, first, second, nodes: [known, middle] };
                return Err((cell.at, problem));
            }
            match *role_of.entry(middle).or_insert(Role::Middle(edge, second)) {
                Role::Corner(first) => {
                    return Err((
                        cell.at,
                        TetMeshProblem::CornerAndMiddle { node: middle, first: second, second: first },
                    ));
                }
                Role::Middle(other, first) if other != edge => {
                    return Err((
                        cell.at,
                        TetMeshProblem::TwoEdges { node: middle, edges: [other, edge], first, second },
                    ));
                }
                Role::Middle(..) => {}
            }
        }
    }
    Ok(())
}

/// Checks that the map of a quadratic tetrahedron from its straight shape is not folded: its Jacobian determinant at its nodes and the points
/// of integration, and the volumes of its parts.
///
/// # Errors
/// The place with the least value, if that is not positive.
pub(super) fn check_shape(cell: &RawCell<NODES>, points: &[Vec3; NODES], parts: &[f64]) -> Result<(), Located> {
    let edges = EDGES.map(|[a, b]| (points[a] - points[b]).norm());
    let cube = edges.into_iter().fold(0.0, f64::max).powi(3);
    let at_nodes = (0..NODES).map(|node| {
        let mut place = [0.0; 4];
        match node.checked_sub(4) {
            None => place[node] = 1.0,
            Some(edge) => EDGES[edge].into_iter().for_each(|corner| place[corner] = 0.5),
        }
        (format!("at its node {}", cell.nodes[node]), jacobian(points, place))
    });
    let inside = integration_points().map(|place| ("at a point of integration".to_owned(), jacobian(points, place)));
    let of_parts = parts.iter().enumerate().map(|(part, six_volumes)| {
        // A part has an eighth of the volume.
        (format!("in its part {} of the eight that its surface follows", part + 1), 8.0 * six_volumes)
    });
    let all = at_nodes.chain(inside).chain(of_parts).map(|(place, value)| (place, value / cube));
    let worst = all.reduce(|worst, other| if other.1 < worst.1 || other.1.is_nan() { other } else { worst });
    let Some((place, share)) = worst.filter(|(_, share)| share.is_nan() || *share < FLAT) else { return Ok(()) };
    let share = if share.is_nan() { 0.0 } else { share };
    Err((cell.at, TetMeshProblem::Folded { number: cell.number, place, share, least: FLAT }))
}

/// Determinant of the derivative of the position by the three last barycentric coordinates, the first following from them: six times the volume
/// of a tetrahedron with straight edges.
pub(super) fn jacobian(points: &[Vec3; NODES], place: [f64; 4]) -> f64 {
    let mut slopes = [0, 1, 2, 3].map(|corner| (4.0 * place[corner] - 1.0) * points[corner]);
    for ([a, b], middle) in EDGES.into_iter().zip(&points[4..]) {
        slopes[a] += 4.0 * place[b] * middle;
        slopes[b] += 4.0 * place[a] * middle;
    }
    let [first, u, v, w] = slopes;
    (u - first).dot(&(v - first).cross(&(w - first)))
}

/// Points of a rule that is exact for polynomials of degree 3, with equal weights: the volume of a quadratic tetrahedron is a sixth of the mean of
/// [`jacobian`] at them.
pub(super) fn integration_points() -> impl Iterator<Item = [f64; 4]> {
    [0.112_956_794_512_511_03, 0.328_861_649_930_202_9].into_iter().flat_map(|other| {
        (0..4).map(move |corner| {
            let mut place = [other; 4];
            place[corner] = 1.0 - 3.0 * other;
            place
        })
    })
}

/// Whether an edge of a quadratic tetrahedron is curved, or its node is not in the middle.
pub(super) fn is_curved(points: &[Vec3; NODES]) -> bool {
    EDGES.into_iter().zip(&points[4..]).any(|([a, b], middle)| {
        let [a, b] = [points[a], points[b]];
        (middle - 0.5 * (a + b)).norm() > STRAIGHT * (b - a).norm()
    })
}

impl TetMesh {
    /// Volume of a quadratic tetrahedron with nodes at `points`, in cubed units of the points.
    pub fn quadratic_volume(points: &[Vec3], nodes: &[u32; NODES]) -> f64 {
        let points = nodes.map(|node| points[node as usize]);
        integration_points().map(|place| jacobian(&points, place)).sum::<f64>() / 48.0
    }
}
