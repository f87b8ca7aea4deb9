//! Where edges of tetrahedra cross triangles of a surface, and edges of the surface faces of tetrahedra.

use super::{Carving, Corner};
use pliant_mesh::geometry::Vec3;
use robust::{Coord3D, orient3d};
use std::collections::BTreeMap;

/// Where an edge and a triangle cross: as shares of vertices of the surface, and of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Vertices of the triangle of the surface; of an edge of the surface its ends, the second twice.
    pub vertices: [u32; 3],
    /// Shares of the vertices; they add up to 1.
    pub vertex_weights: [f64; 3],
    /// Nodes of the face; of an edge between two nodes these, the second twice.
    pub nodes: [u32; 3],
    /// Shares of the nodes; they add up to 1.
    pub node_weights: [f64; 3],
}

/// A crossing on an edge: the share of the way from the lower end, the crossing, and whether what is asked for begins there on the way from the lower end.
type OnEdge = (f64, Corner, bool);

/// The crossings of a surface and faces, by triangle, by face and by edge.
#[derive(Default)]
pub(super) struct Crossings {
    /// Every crossing once, in the order in which it was found.
    pub all: Vec<Crossing>,
    /// Their positions by the vertices of the surface, m.
    pub places: Vec<Vec3>,
    /// Segments in which each triangle meets faces, what is left of the faces to their left.
    pub of_triangle: BTreeMap<u32, Vec<[Corner; 2]>>,
    /// The same by face.
    pub of_face: BTreeMap<u32, Vec<[Corner; 2]>>,
    /// Crossings on each edge of the surface, by its ends, the lower first: what is left of the surface begins.
    sides: BTreeMap<[u32; 2], Vec<OnEdge>>,
    /// Crossings on each edge between nodes, the lower first: the inside begins.
    edges: BTreeMap<[u32; 2], Vec<OnEdge>>,
    /// Number of pairs that do not meet in one segment.
    pub doubtful: usize,
}

/// What is known by what meets in a crossing: an edge between nodes and a triangle, or a face and an edge of the surface.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    EdgeOfNodes([u32; 2], u32),
    EdgeOfSurface(u32, [u32; 2]),
}

/// Six times the volume above a triangle: positive on the side from which its corners are counter-clockwise.
fn above([a, b, c]: [Vec3; 3], x: Vec3) -> f64 {
    let coord = |p: Vec3| Coord3D { x: p.x, y: p.y, z: p.z };
    -orient3d(coord(a), coord(b), coord(c), coord(x))
}

/// An edge through a triangle: distances of its ends on their sides of it, and shares of the triangle's corners where it goes through.
struct Hit {
    ends: [f64; 2],
    shares: [f64; 3],
}

/// How an edge goes through a triangle, if it does.
fn hit(triangle: [Vec3; 3], [p, q]: [Vec3; 2]) -> Option<Hit> {
    let ends = [above(triangle, p), above(triangle, q)];
    if (ends[0] >= 0.0) == (ends[1] >= 0.0) {
        return None;
    }
    let [a, b, c] = triangle;
    let around = [[b, c], [c, a], [a, b]].map(|[from, to]| above([p, q, from], to));
    let is_positive = around[0] >= 0.0;
    if around.iter().any(|volume| (*volume >= 0.0) != is_positive) {
        return None;
    }
    let sum: f64 = around.iter().sum();
    let shares = if sum == 0.0 { [1.0 / 3.0; 3] } else { around.map(|volume| volume / sum) };
    Some(Hit { ends, shares })
}

/// The two ends of an edge, the lower first, and whether they were exchanged.
fn sorted([a, b]: [u32; 2]) -> ([u32; 2], bool) {
    if a < b { ([a, b], false) } else { ([b, a], true) }
}

impl Crossings {
    /// Finds all crossings of a surface and faces.
    pub(super) fn find(carving: &Carving<'_>) -> Self {
        let mut found = Self::default();
        let mut known: BTreeMap<Key, u32> = BTreeMap::new();
        for [t, f] in carving.pairs() {
            found.meet(carving, t, f, &mut known);
        }
        for list in found.sides.values_mut().chain(found.edges.values_mut()) {
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        found
    }

    /// Adds the segment in which a triangle and a face meet.
    fn meet(&mut self, carving: &Carving<'_>, t: u32, f: u32, known: &mut BTreeMap<Key, u32>) {
        let (vertices, nodes) = (carving.triangles[t as usize], carving.faces[f as usize]);
        let triangle = vertices.map(|v| carving.points[v as usize]);
        let face = nodes.map(|n| carving.nodes[n as usize]);
        // The segment goes along the product of the normals of face and triangle: what is inside is to its left on the face.
        let (mut start, mut end, mut count) = (None, None, 0);
        for i in 0..3 {
            let ([low, high], is_turned) = sorted([nodes[i], nodes[(i + 1) % 3]]);
            let ends = [low, high].map(|n| carving.nodes[n as usize]);
            if let Some(Hit { ends, shares }) = hit(triangle, ends) {
                let share = ends[0].abs() / (ends[0].abs() + ends[1].abs());
                let crossing = Crossing {
                    vertices,
                    vertex_weights: shares,
                    nodes: [low, high, high],
                    node_weights: [1.0 - share, share, 0.0],
                };
                let is_new = !known.contains_key(&Key::EdgeOfNodes([low, high], t));
                let at = self.number(Key::EdgeOfNodes([low, high], t), crossing, carving, known);
                // Above the triangle is outside.
                let enters = ends[0] >= 0.0;
                if is_new {
                    self.edges.entry([low, high]).or_default().push((share, at, enters));
                }
                *(if enters == is_turned { &mut start } else { &mut end }) = Some(at);
                count += 1;
            }
        }
        for i in 0..3 {
            let ([low, high], is_turned) = sorted([vertices[i], vertices[(i + 1) % 3]]);
            let ends = [low, high].map(|v| carving.points[v as usize]);
            if let Some(Hit { ends, shares }) = hit(face, ends) {
                let share = ends[0].abs() / (ends[0].abs() + ends[1].abs());
                let crossing = Crossing {
                    vertices: [low, high, high],
                    vertex_weights: [1.0 - share, share, 0.0],
                    nodes,
                    node_weights: shares,
                };
                let is_new = !known.contains_key(&Key::EdgeOfSurface(f, [low, high]));
                let at = self.number(Key::EdgeOfSurface(f, [low, high]), crossing, carving, known);
                // Above the face is what has gone.
                let enters = ends[0] >= 0.0;
                if is_new {
                    self.sides.entry([low, high]).or_default().push((share, at, enters));
                }
                *(if enters == is_turned { &mut end } else { &mut start }) = Some(at);
                count += 1;
            }
        }
        match (count, start, end) {
            (0, ..) => {}
            (2, Some(start), Some(end)) => {
                self.of_triangle.entry(t).or_default().push([start, end]);
                self.of_face.entry(f).or_default().push([start, end]);
            }
            _ => self.doubtful += 1,
        }
    }

    /// The number of a crossing, which is new if its key is.
    fn number(
        &mut self,
        key: Key,
        crossing: Crossing,
        carving: &Carving<'_>,
        known: &mut BTreeMap<Key, u32>,
    ) -> Corner {
        let number = *known.entry(key).or_insert_with(|| {
            let shares = crossing.vertices.iter().zip(crossing.vertex_weights);
            self.places.push(shares.map(|(v, w)| w * carving.points[*v as usize]).sum());
            self.all.push(crossing);
            self.all.len() as u32 - 1
        });
        Corner::Crossing(number)
    }

    /// Crossings along an edge of the surface from its first end to its second, each with whether what is left begins there.
    pub(super) fn on_side(&self, edge: [u32; 2]) -> Vec<(Corner, bool)> {
        along(&self.sides, edge)
    }

    /// Crossings along an edge between nodes, each with whether the inside begins there.
    pub(super) fn on_edge(&self, edge: [u32; 2]) -> Vec<(Corner, bool)> {
        along(&self.edges, edge)
    }
}

/// Crossings along an edge in its direction, each with whether something begins there.
fn along(edges: &BTreeMap<[u32; 2], Vec<OnEdge>>, edge: [u32; 2]) -> Vec<(Corner, bool)> {
    let (key, is_turned) = sorted(edge);
    let mut list: Vec<(Corner, bool)> = edges
        .get(&key)
        .map_or(&[][..], Vec::as_slice)
        .iter()
        .map(|(_, corner, begins)| (*corner, *begins != is_turned))
        .collect();
    if is_turned {
        list.reverse();
    }
    list
}

impl Carving<'_> {
    /// Pairs of a triangle and a face that are in a common box, ascending.
    fn pairs(&self) -> Vec<[u32; 2]> {
        let boxes = |corners: [Vec3; 3]| {
            let low = corners.iter().fold(corners[0], |low, p| low.inf(p));
            let high = corners.iter().fold(corners[0], |high, p| high.sup(p));
            let index = |x: f64| (x / self.spacing).floor() as i32;
            let ranges = [0, 1, 2].map(|i| index(low[i])..=index(high[i]));
            let [x, y, z] = ranges;
            x.flat_map(move |i| {
                let z = z.clone();
                y.clone().flat_map(move |j| z.clone().map(move |k| [i, j, k]))
            })
        };
        let mut faces: Vec<([i32; 3], u32)> = Vec::new();
        for (nodes, f) in self.faces.iter().zip(0..) {
            faces.extend(boxes(nodes.map(|n| self.nodes[n as usize])).map(|index| (index, f)));
        }
        faces.sort_unstable();
        let mut pairs = Vec::new();
        for (vertices, t) in self.triangles.iter().zip(0..) {
            for index in boxes(vertices.map(|v| self.points[v as usize])) {
                let first = faces.partition_point(|(other, _)| *other < index);
                pairs.extend(faces[first..].iter().take_while(|(other, _)| *other == index).map(|(_, f)| [t, *f]));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}
