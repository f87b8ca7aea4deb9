//! Refinement of cut surfaces: vertices in their interior.
//!
//! The walls of a strip have vertices on its border only, so their triangles reach from one side of the section to the other, and nothing that is
//! pressed into them could show. Once a stroke has ended, edges that are too long are divided at their midpoints, the longest first, and edges are flipped
//! towards a Delaunay triangulation after each division (as Shewchuk, 2002, does in the plane).
//!
//! Two walls face each other, and what comes later cuts both at once, so they have to stay the same triangulation. An edge is therefore known by the
//! places of its ends, which both walls share, and is divided or flipped in all of them or in none. Edges that a wall shares with the original surface stay, as
//! its faces would change with them.

use std::collections::{BinaryHeap, HashMap};

use super::Vec3;
use super::advance::Advance;
use super::fans::{split_coincident_edges, split_edge_ring};
use super::mesh::CutMesh;
use super::record::{NONE, Origin};

/// Distance between a midpoint and the opposite corner of a triangle, in longest edges, below which the edge is not divided. A blade that bends leaves strips much
/// narrower than an edge, and one that was not divided would keep all beside it from being divided.
const LEAST_DISTANCE: f64 = 1e-6;
/// Bound of the number of divisions, in squares of the longest edge on the cut surface.
const DIVISIONS_PER_SQUARE: f64 = 16.0;

/// The ends of an edge: two places, the lower first.
pub(super) type Ends = [u32; 2];

/// The walls of all cuts while they are refined.
pub(super) struct Walls<'m> {
    pub mesh: &'m mut CutMesh,
    /// Length above which an edge is divided, m.
    pub longest: f64,
    /// Position of each place, m.
    pub positions: Vec<Vec3>,
    /// Normal of the walls at each place, in either of its directions. Its length is an area, m^2.
    pub normals: Vec<Vec3>,
    /// Half-edges of the walls by their ends.
    pub half_edges: HashMap<Ends, Vec<u32>>,
    /// Place of each vertex of a wall, [`NONE`] for others (n).
    place: Vec<u32>,
    /// Edges to divide, as the bits of their squared lengths and their ends; the longest comes first.
    waiting: BinaryHeap<(u64, Ends)>,
}

/// An edge of walls.
pub(super) struct WallEdge {
    /// Its half-edges, by the connected ones.
    pub rings: Vec<Vec<u32>>,
    /// Places opposite to it, ascending, each once.
    pub apexes: Vec<u32>,
}

impl CutMesh {
    /// Divides the edges inside of cut surfaces that are longer than `longest` (m), where something was cut since the last time, as an advance without blade. Edges that a cut surface shares with the
    /// original surface stay as they are, and so do edges of a triangle whose longest edge is one of those. `None` if there is nothing to divide, or if
    /// what came out does not pass verification; the mesh is then as it was.
    pub fn refine_cut_surfaces(&mut self, longest: f64) -> Option<Advance> {
        let is_cap = |t: &u32| self.is_cap(*t);
        let caps: Vec<u32> = (0..self.surface.triangles.len() as u32).filter(is_cap).collect();
        let [first_triangle, first_vertex] = [self.surface.triangles.len(), self.surface.points.len()];
        let mut new = self.unrefined();
        new.retain(is_cap);
        if new.is_empty() {
            return None;
        }
        self.begin_step();
        Walls::new(self, &caps, longest).divide_long_edges(&new);
        let mut touched: Vec<u32> = self.changed().0;
        touched.extend(first_triangle as u32..self.surface.triangles.len() as u32);
        if touched.is_empty() || split_coincident_edges(self, &mut touched).is_err() || self.verify().is_err() {
            self.revert_step();
            return None;
        }
        self.index_triangles(first_triangle);
        self.refit();
        self.tree.regroup();
        self.commit_refinement();
        Some(Advance {
            changed: self.changed().0,
            first_triangle: first_triangle as u32,
            pieces_of: self.pieces_of(),
            first_vertex: first_vertex as u32,
            ..Advance::default()
        })
    }
}

impl<'m> Walls<'m> {
    fn new(mesh: &'m mut CutMesh, caps: &[u32], longest: f64) -> Self {
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        let (mut place, mut positions) = (vec![NONE; mesh.surface.points.len()], Vec::new());
        for &vertex in caps.iter().flat_map(|t| &mesh.surface.triangles[*t as usize]) {
            if place[vertex as usize] == NONE {
                let position = mesh.point(vertex);
                place[vertex as usize] = *known.entry(position.map(f64::to_bits).into()).or_insert_with(|| {
                    positions.push(position);
                    positions.len() as u32 - 1
                });
            }
        }
        let (normals, waiting) = (vec![Vec3::zeros(); positions.len()], BinaryHeap::new());
        let mut walls = Self { mesh, longest, positions, normals, half_edges: HashMap::new(), place, waiting };
        for &triangle in caps {
            walls.list(triangle);
            let cross = walls.mesh.cross(triangle);
            for corner in 3 * triangle..3 * triangle + 3 {
                let place = walls.place_of(corner) as usize;
                let sum = &mut walls.normals[place];
                *sum += if sum.dot(&cross) < 0.0 { -cross } else { cross };
            }
        }
        walls
    }

    /// Divides and flips until no edge of some triangles, and of what comes of them, is too long.
    fn divide_long_edges(&mut self, begin: &[u32]) {
        let all: Vec<Ends> = begin.iter().flat_map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).map(|h| self.ends(h)).collect();
        if !all.iter().any(|ends| self.is_long(*ends) && self.edge(*ends).is_some()) {
            return;
        }
        let area: f64 = begin.iter().map(|t| 0.5 * self.mesh.cross(*t).norm()).sum();
        let most = (DIVISIONS_PER_SQUARE * area / self.longest.powi(2)) as usize + begin.len();
        all.iter().for_each(|ends| self.wait(*ends));
        self.flip_around(all);
        let mut count = 0;
        while let Some((_, ends)) = self.waiting.pop() {
            if count == most {
                break;
            }
            if let Some(edge) = self.edge(ends).filter(|edge| self.can_divide(ends, edge)) {
                let opposite = self.divide(ends, &edge);
                self.flip_around(opposite);
                count += 1;
            }
        }
    }

    /// Whether an edge may be divided: no triangle at it has a longer one, which then has to stay, or a corner close to the midpoint. Otherwise midpoints
    /// would pile up along what stays.
    fn can_divide(&self, ends: Ends, edge: &WallEdge) -> bool {
        let (length, middle) = (self.length(ends), self.middle(ends));
        edge.apexes.iter().all(|&apex| {
            (self.positions[apex as usize] - middle).norm() > LEAST_DISTANCE * self.longest
                && ends.iter().all(|end| self.length(ordered(*end, apex)) <= length)
        })
    }

    /// Divides an edge at its midpoint in all walls. Returns the edges opposite to the midpoint.
    fn divide(&mut self, ends: Ends, edge: &WallEdge) -> Vec<Ends> {
        let x = self.middle(ends);
        let middle = self.positions.len() as u32;
        self.positions.push(x);
        let [n, other] = ends.map(|end| self.normals[end as usize]);
        self.normals.push(0.5 * if n.dot(&other) < 0.0 { n - other } else { n + other });
        for ring in &edge.rings {
            ring.iter().for_each(|half| self.unlist(half / 3));
            let origin = Origin::Edge { ends: [self.mesh.tail(ring[0]), self.mesh.head(ring[0])], t: 0.5 };
            let vertex = self.mesh.add_vertex(x, origin);
            self.place.push(middle);
            let triangles = split_edge_ring(self.mesh, ring, vertex);
            triangles.iter().for_each(|t| self.list(*t));
        }
        ends.iter().chain(&edge.apexes).for_each(|place| self.wait(ordered(*place, middle)));
        let opposite: Vec<Ends> = edge.apexes.iter().flat_map(|apex| ends.map(|end| ordered(end, *apex))).collect();
        // What was kept from being divided by a longer edge may be now.
        opposite.iter().for_each(|ends| self.wait(*ends));
        opposite
    }

    /// The edge with these ends; `None` if it is shared with the original surface or gone.
    pub fn edge(&self, ends: Ends) -> Option<WallEdge> {
        let half_edges = self.half_edges.get(&ends)?;
        let mut edge = WallEdge { rings: Vec::new(), apexes: Vec::new() };
        for &half in half_edges {
            if edge.rings.iter().any(|ring| ring.contains(&half)) {
                continue;
            }
            let ring: Vec<u32> = self.mesh.around(half).collect();
            if ring.iter().any(|half| !self.mesh.is_cap(half / 3)) {
                return None;
            }
            edge.rings.push(ring);
        }
        edge.apexes = half_edges.iter().map(|half| self.apex(*half)).collect();
        edge.apexes.sort_unstable();
        edge.apexes.dedup();
        Some(edge)
    }

    /// Has an edge wait to be divided if it is too long.
    pub fn wait(&mut self, ends: Ends) {
        if self.is_long(ends) {
            // Squares of lengths are positive, and their bits have the same order.
            self.waiting.push((self.length(ends).powi(2).to_bits(), ends));
        }
    }

    /// Lists the half-edges of a triangle.
    pub fn list(&mut self, triangle: u32) {
        for half in 3 * triangle..3 * triangle + 3 {
            self.half_edges.entry(self.ends(half)).or_default().push(half);
        }
    }

    /// Removes the half-edges of a triangle from the list, before it changes.
    pub fn unlist(&mut self, triangle: u32) {
        for half in 3 * triangle..3 * triangle + 3 {
            let ends = self.ends(half);
            if let Some(half_edges) = self.half_edges.get_mut(&ends) {
                half_edges.retain(|listed| *listed != half);
                if half_edges.is_empty() {
                    self.half_edges.remove(&ends);
                }
            }
        }
    }

    /// The place opposite to a half-edge in its triangle.
    pub fn apex(&self, half: u32) -> u32 {
        self.place_of(half - half % 3 + (half % 3 + 2) % 3)
    }

    fn ends(&self, half: u32) -> Ends {
        ordered(self.place_of(half), self.place_of(half - half % 3 + (half % 3 + 1) % 3))
    }

    /// The place of a corner.
    pub fn place_of(&self, corner: u32) -> u32 {
        self.place[self.mesh.tail(corner) as usize]
    }

    fn middle(&self, [a, b]: Ends) -> Vec3 {
        self.positions[a as usize].lerp(&self.positions[b as usize], 0.5)
    }

    fn length(&self, [a, b]: Ends) -> f64 {
        (self.positions[b as usize] - self.positions[a as usize]).norm()
    }

    fn is_long(&self, ends: Ends) -> bool {
        self.length(ends) > self.longest
    }
}

/// The edge between two places.
pub(super) fn ordered(a: u32, b: u32) -> Ends {
    [a.min(b), a.max(b)]
}
