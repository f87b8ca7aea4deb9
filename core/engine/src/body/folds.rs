//! Changes of a surface that make no fold: no two triangles with a common edge come to lie on each other.
//!
//! That no cell is inverted is not enough. A surface is finer than cells, and what an edit moves beyond what nodes carry, or what a cubic embedding makes of
//! strongly sheared cells, may turn triangles over. Where displacements would fold an edge, its vertices take the mean of the displacements around them,
//! as nodes do in the repair of cells: a uniform displacement folds nothing.

use super::{Model, NOT_EMBEDDED};
use pliant_mesh::geometry::place_bits;
use pliant_solver::Vec3;
use std::collections::HashMap;

/// Cosine of 150 degrees, the largest angle to which a change turns the normals of two triangles with a common edge: what is left is a wedge of 30 degrees. Edges
/// that are sharper stay so or open.
const MIN_COSINE: f64 = -0.866_025_403_784_438_6;
/// Sweeps over the vertices of folded edges; after each [`SWEEPS_OF_A_ROUND`] their neighbours are included.
const SWEEPS: usize = 60;
/// Sweeps before the vertices around are included.
const SWEEPS_OF_A_ROUND: usize = 10;
/// Largest change of the cosine by rounding, where an edge that is as sharp already moves as a whole.
const ROUNDING: f64 = 1e-9;

/// Displacements of vertices (m), ascending.
pub type Moves = Vec<(u32, Vec3)>;

/// What becomes of an edge that is folded after all sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unresolved {
    /// Its vertices do not move. Then no edge is folded.
    Stop,
    /// It stays folded.
    Leave,
}

/// What displacements would have folded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unfolded {
    /// Number of edges.
    pub edges: usize,
    /// Number of edges that are folded after all.
    pub left: usize,
    /// Largest distance of a vertex from where it was displaced to, m.
    pub moved: f64,
    /// Where that vertex was displaced to, m.
    pub place: Vec3,
}

/// Changes the displacements of a surface with vertices at `points` (m, n x 3) so that they fold no edge. `cell` is the cell of each vertex (n), see [`super::Skin::cell`]:
/// vertices at one place of a cell that move together stay together.
pub fn limit_folds(
    model: &Model,
    points: &[Vec3],
    cell: &[u32],
    moves: &mut Moves,
    unresolved: Unresolved,
) -> Unfolded {
    let mut patch = Patch::new(model, points, cell, moves);
    let (edges, left) = patch.unfold(unresolved);
    let (mut moved, mut place) = (f64::NEG_INFINITY, Vec3::zeros());
    for ((v, displacement), vertex) in moves.iter_mut().zip(&patch.of_moves) {
        let limited = patch.displacements[*vertex as usize];
        let way = (limited - *displacement).norm();
        if way > moved {
            (moved, place) = (way, points[*v as usize] + *displacement);
        }
        *displacement = limited;
    }
    Unfolded { edges, left, moved: moved.max(0.0), place }
}

/// Two triangles with a common edge, each by its vertices.
struct Hinge([[u32; 3]; 2]);

/// The surface around the vertices that move. Vertices that move as one are one.
struct Patch {
    /// Positions before the change, m (v x 3).
    points: Vec<Vec3>,
    /// Displacements, m (v x 3).
    displacements: Vec<Vec3>,
    /// Vertices that share an edge with each (v); empty for those that do not move.
    neighbours: Vec<Vec<u32>>,
    /// Edges of which a triangle moves.
    hinges: Vec<Hinge>,
    /// Vertex of the patch of each displacement.
    of_moves: Vec<u32>,
}

impl Patch {
    fn new(model: &Model, points: &[Vec3], cell: &[u32], moves: &Moves) -> Self {
        let [vertex_count, triangle_count] = [points.len(), model.surface.triangles.len()];
        let corners = |triangles: &[u32]| {
            ascending(triangles.iter().flat_map(|t| model.surface.triangles[*t as usize]), vertex_count)
        };
        let around = |vertices: &[u32]| {
            let mut triangles = ascending(vertices.iter().flat_map(|v| model.around(*v)).copied(), triangle_count);
            triangles.retain(|t| !model.is_lid(*t));
            triangles
        };
        let moved: Vec<u32> = moves.iter().map(|(v, _)| *v).collect();
        // Triangles that move, and their neighbours.
        let triangles = around(&corners(&around(&moved)));
        let vertices = ascending(corners(&triangles).into_iter().chain(moved), vertex_count);
        let mut patch = Self {
            points: Vec::with_capacity(vertices.len()),
            displacements: Vec::with_capacity(vertices.len()),
            neighbours: Vec::new(),
            hinges: Vec::new(),
            of_moves: Vec::new(),
        };
        let (mut rest, mut by_place) = (moves.iter().peekable(), HashMap::new());
        let mut index = |v: u32| {
            let (at, cell) = (points[v as usize], cell[v as usize]);
            let moved = rest.next_if(|(of, _)| *of == v).map(|(_, d)| *d);
            let next = patch.points.len() as u32;
            let of = match moved {
                Some(d) if cell != NOT_EMBEDDED => {
                    *by_place.entry((cell, place_bits(at), place_bits(d))).or_insert(next)
                }
                _ => next,
            };
            if of == next {
                patch.points.push(at);
                patch.displacements.push(moved.unwrap_or_default());
            }
            of
        };
        let indices: Vec<u32> = vertices.iter().map(|v| index(*v)).collect();
        let first = vertices.first().copied().unwrap_or_default();
        let mut of_vertex = vec![0; vertices.last().map_or(0, |last| (last - first) as usize + 1)];
        vertices.iter().zip(&indices).for_each(|(v, index)| of_vertex[(v - first) as usize] = *index);
        let local = |v: u32| of_vertex[(v - first) as usize];
        patch.of_moves = moves.iter().map(|(v, _)| local(*v)).collect();
        let triangles: Vec<[u32; 3]> =
            triangles.into_iter().map(|t| model.surface.triangles[t as usize].map(local)).collect();
        let mut is_moved = vec![false; patch.points.len()];
        patch.of_moves.iter().for_each(|v| is_moved[*v as usize] = true);
        patch.connect(&triangles, &is_moved);
        patch
    }

    /// Finds neighbours and hinges.
    fn connect(&mut self, triangles: &[[u32; 3]], is_moved: &[bool]) {
        self.neighbours = vec![Vec::new(); self.points.len()];
        let edges = triangles
            .iter()
            .enumerate()
            .flat_map(|(t, &[a, b, c])| [[a, b], [b, c], [c, a]].map(|[a, b]| (a.min(b), (a.max(b), t as u32))));
        // Sorted by the lower vertex: those of each begin at `start`.
        let mut start = vec![0_u32; self.points.len() + 2];
        edges.clone().for_each(|(a, _)| start[a as usize + 2] += 1);
        (2..start.len()).for_each(|a| start[a] += start[a - 1]);
        let mut sorted = vec![(0, 0); 3 * triangles.len()];
        for (a, other) in edges {
            let at = &mut start[a as usize + 1];
            sorted[*at as usize] = other;
            *at += 1;
        }
        for (a, range) in start.windows(2).take(self.points.len()).enumerate() {
            let (a, others) = (a as u32, &mut sorted[range[0] as usize..range[1] as usize]);
            others.sort_unstable();
            for of_edge in others.chunk_by(|a, b| a.0 == b.0) {
                self.add_edge([a, of_edge[0].0], of_edge, triangles, is_moved);
            }
        }
    }

    /// Adds an edge, with its other vertex and the index of the triangle for each of its triangles.
    fn add_edge(&mut self, [a, b]: [u32; 2], of_edge: &[(u32, u32)], triangles: &[[u32; 3]], is_moved: &[bool]) {
        for (to, from) in [(a, b), (b, a)] {
            if is_moved[to as usize] {
                self.neighbours[to as usize].push(from);
            }
        }
        // An edge of more triangles has no two sides.
        let &[(_, first), (_, second)] = of_edge else { return };
        let triangles = [first, second].map(|t| triangles[t as usize]);
        if triangles.iter().flatten().any(|v| is_moved[*v as usize]) {
            self.hinges.push(Hinge(triangles));
        }
    }

    /// Whether a hinge is folded by the displacements.
    fn is_folded(&self, hinge: &Hinge) -> bool {
        let before = |v: u32| self.points[v as usize];
        let at = |v: u32| before(v) + self.displacements[v as usize];
        let now = cosine(hinge.0.map(|t| t.map(at)));
        now < MIN_COSINE && now < cosine(hinge.0.map(|t| t.map(before))) - ROUNDING
    }

    /// Changes the displacements until no edge is folded. Returns how many were and are.
    fn unfold(&mut self, unresolved: Unresolved) -> (usize, usize) {
        let mut is_repaired = vec![false; self.points.len()];
        let mut folded: Vec<usize> = (0..self.hinges.len()).filter(|h| self.is_folded(&self.hinges[*h])).collect();
        let (edges, mut sweep) = (folded.len(), 0);
        while !folded.is_empty() && (sweep < SWEEPS || unresolved == Unresolved::Stop) {
            let vertices: Vec<u32> = folded.iter().flat_map(|h| self.hinges[*h].0).flatten().collect();
            let widens = sweep > 0 && sweep % SWEEPS_OF_A_ROUND == 0;
            for v in vertices.iter().map(|v| *v as usize) {
                is_repaired[v] = true;
                if sweep >= SWEEPS {
                    self.displacements[v] = Vec3::zeros();
                } else if widens {
                    self.neighbours[v].iter().for_each(|w| is_repaired[*w as usize] = true);
                }
            }
            if sweep < SWEEPS {
                for v in (0..self.points.len()).filter(|v| is_repaired[*v]) {
                    let around = &self.neighbours[v];
                    if !around.is_empty() {
                        let sum: Vec3 = around.iter().map(|w| self.displacements[*w as usize]).sum();
                        self.displacements[v] = sum / around.len() as f64;
                    }
                }
            }
            // Others are as they were, and were not folded.
            let is_changed = |hinge: &Hinge| hinge.0.iter().flatten().any(|v| is_repaired[*v as usize]);
            let hinges = self.hinges.iter().enumerate();
            folded = hinges
                .filter(|(_, hinge)| is_changed(hinge) && self.is_folded(hinge))
                .map(|(index, _)| index)
                .collect();
            sweep += 1;
        }
        (edges, folded.len())
    }
}

/// Cosine of the angle between the normals of two triangles with these corners (m); 0 where one has no area.
fn cosine(corners: [[Vec3; 3]; 2]) -> f64 {
    let [a, b] = corners.map(|[a, b, c]| (b - a).cross(&(c - a)));
    let size = (a.norm_squared() * b.norm_squared()).sqrt();
    if size > 0.0 { a.dot(&b) / size } else { 0.0 }
}

/// The numbers below `limit`, ascending, each once.
fn ascending(numbers: impl Iterator<Item = u32>, limit: usize) -> Vec<u32> {
    let mut is_in = vec![0_u64; limit.div_ceil(64)];
    numbers.for_each(|number| is_in[number as usize / 64] |= 1 << (number % 64));
    let mut all = Vec::new();
    for (word, mut bits) in is_in.into_iter().enumerate() {
        while bits != 0 {
            all.push(64 * word as u32 + bits.trailing_zeros());
            bits &= bits - 1;
        }
    }
    all
}
