//! Tetrahedral boxes, and the files that mesh generators would write of them.

use super::Random;
use crate::geometry::Vec3;
use std::collections::HashMap;
use std::io::Write;

/// A box of tetrahedra, or several boxes side by side along y that share no node. Its low end is the faces at x = 0, its high end those at the other end.
#[derive(Clone, Debug)]
pub struct TetBox {
    /// Edges of a box, file units.
    pub size: [f64; 3],
    /// Number of boxes.
    pub parts: u32,
    /// Nodes, file units (n x 3).
    pub points: Vec<Vec3>,
    /// Nodes of each tetrahedron, with a positive volume (m x 4).
    pub tetrahedra: Vec<[u32; 4]>,
    /// Nodes of each quadratic tetrahedron: corners, then middles of edges 01, 12, 02, 03, 13 and 23 (m x 10); empty for linear ones.
    pub quadratic: Vec<[u32; 10]>,
}

/// A form of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TetFormat {
    /// Gmsh 2.2, text.
    Msh2,
    /// Gmsh 2.2, binary.
    Msh2Binary,
    /// Gmsh 4.1, text.
    Msh4,
    /// Gmsh 4.1, binary.
    Msh4Binary,
    /// Legacy VTK 3.0, text.
    Vtk,
    /// Legacy VTK 3.0, binary.
    VtkBinary,
    /// Legacy VTK 5.1, text, with offsets and connectivity.
    Vtk5,
}

/// Corners of the six tetrahedra of a cube around its diagonal (Kuhn 1960), as bits x, y, z.
const KUHN: [[u32; 4]; 6] = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// Ends of the edges of a tetrahedron whose middles are nodes 4 to 9 of a quadratic one.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// The edges of a tetrahedron by their ends.
fn edges(corners: &[u32; 4]) -> [[u32; 2]; 6] {
    EDGES.map(|ends| ends.map(|corner| corners[corner]))
}

/// The nodes of a quadratic tetrahedron.
fn ten([a, b, c, d]: &[u32; 4], [ab, bc, ac, ad, bd, cd]: [u32; 6]) -> [u32; 10] {
    [*a, *b, *c, *d, ab, bc, ac, ad, bd, cd]
}

impl TetBox {
    /// A box from the origin of this `size` with `cells` cubes along its edges, each cut into six. Nodes are moved at random by up to `jitter` of a cell in each
    /// direction: those on a side within it, those on an edge of the box along it. Up to a jitter of 0.15 all volumes are positive.
    ///
    /// # Panics
    /// If a tetrahedron is inverted.
    pub fn new(cells: [u32; 3], size: [f64; 3], jitter: f64, seed: u64) -> Self {
        Self::beside(cells, size, jitter, 1, &mut Random(seed))
    }

    /// Boxes of random sizes, cells, parts and jitter.
    pub fn random(seed: u64) -> Self {
        let mut random = Random(seed);
        let cells = [0; 3].map(|_| 1 + random.below(4) as u32);
        let size = [0; 3].map(|_| 0.1 + random.unit());
        let (jitter, parts) = (0.15 * random.unit(), 1 + random.below(3) as u32);
        Self::beside(cells, size, jitter, parts, &mut random)
    }

    fn beside(cells: [u32; 3], size: [f64; 3], jitter: f64, parts: u32, random: &mut Random) -> Self {
        let mut made = Self { size, parts, points: Vec::new(), tetrahedra: Vec::new(), quadratic: Vec::new() };
        for part in 0..parts {
            let first = made.points.len() as u32;
            let node = |at: [u32; 3]| first + at[0] + (cells[0] + 1) * (at[1] + (cells[1] + 1) * at[2]);
            let moved = |axis: usize, index: u32, random: &mut Random| {
                let is_outer = index == 0 || index == cells[axis];
                let shift = if is_outer { 0.0 } else { jitter * random.signed() };
                // The far side is exactly at the size.
                if index == cells[axis] {
                    size[axis]
                } else {
                    (f64::from(index) + shift) / f64::from(cells[axis]) * size[axis]
                }
            };
            for k in 0..=cells[2] {
                for j in 0..=cells[1] {
                    for i in 0..=cells[0] {
                        let [x, y, z] = [(0, i), (1, j), (2, k)].map(|(axis, index)| moved(axis, index, random));
                        made.points.push(Vec3::new(x, y + 2.0 * f64::from(part) * size[1], z));
                    }
                }
            }
            for k in 0..cells[2] {
                for j in 0..cells[1] {
                    for i in 0..cells[0] {
                        made.tetrahedra
                            .extend(KUHN.map(|t| t.map(|c| node([i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)]))));
                    }
                }
            }
        }
        for nodes in &made.tetrahedra {
            assert!(crate::TetMesh::six_volumes(&made.points, *nodes) > 0.0, "too much jitter");
        }
        made
    }

    /// The same mesh of quadratic tetrahedra: with a node in the middle of each edge.
    #[must_use]
    pub fn quadratic(&self) -> Self {
        let mut made = self.clone();
        let mut middle_of: HashMap<[u32; 2], u32> = HashMap::new();
        for corners in &self.tetrahedra {
            let middles = edges(corners).map(|[a, b]| {
                *middle_of.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    made.points.push(0.5 * (self.points[a as usize] + self.points[b as usize]));
                    made.points.len() as u32 - 1
                })
            });
            made.quadratic.push(ten(corners, middles));
        }
        made
    }

    /// The same mesh with the middles of edges moved at random by up to `share` of the box in each direction: those on a side within it, those on an edge of the box
    /// along it.
    #[must_use]
    pub fn curved(&self, share: f64, seed: u64) -> Self {
        let (mut made, mut random) = (self.clone(), Random(seed));
        let mut is_moved = vec![false; self.points.len()];
        let is_side = |x: f64, axis: usize| {
            let width = if axis == 1 { 2.0 * self.size[1] } else { f64::INFINITY };
            let near = |side: f64| (x % width - side).abs() < 1e-9 * self.size[axis];
            near(0.0) || near(self.size[axis]) || near(width)
        };
        for nodes in &self.quadratic {
            let corners = [nodes[0], nodes[1], nodes[2], nodes[3]];
            for ([a, b], &middle) in edges(&corners).into_iter().zip(&nodes[4..]) {
                if std::mem::replace(&mut is_moved[middle as usize], true) {
                    continue;
                }
                for axis in 0..3 {
                    let [a, b] = [a, b].map(|node| is_side(self.points[node as usize][axis], axis));
                    let is_within = a && b && is_side(self.points[middle as usize][axis], axis);
                    let shift = share * self.size[axis] * random.signed();
                    made.points[middle as usize][axis] += if is_within { 0.0 } else { shift };
                }
            }
        }
        made
    }

    /// The same mesh with nodes and tetrahedra in a random order, and the nodes of each tetrahedron rotated.
    #[must_use]
    pub fn shuffled(&self, seed: u64) -> Self {
        let mut random = Random(seed);
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        random.shuffle(&mut order);
        let mut number = vec![0; order.len()];
        order.iter().zip(0_u32..).for_each(|(old, new)| number[*old] = new);
        let points = order.iter().map(|old| self.points[*old]).collect();
        let mut tetrahedra: Vec<[u32; 4]> = self.tetrahedra.iter().map(|t| t.map(|n| number[n as usize])).collect();
        let mut middle_of: HashMap<[u32; 2], u32> = HashMap::new();
        for nodes in &self.quadratic {
            let nodes = nodes.map(|n| number[n as usize]);
            let corners = [nodes[0], nodes[1], nodes[2], nodes[3]];
            middle_of.extend(edges(&corners).map(|[a, b]| [a.min(b), a.max(b)]).into_iter().zip(nodes[4..].to_vec()));
        }
        random.shuffle(&mut tetrahedra);
        tetrahedra.iter_mut().for_each(|t| t[1..].rotate_left(random.below(3) as usize));
        let middles = |t: &[u32; 4]| edges(t).map(|[a, b]| middle_of[&[a.min(b), a.max(b)]]);
        let quadratic = match self.quadratic.is_empty() {
            true => Vec::new(),
            false => tetrahedra.iter().map(|t| ten(t, middles(t))).collect(),
        };
        Self { points, tetrahedra, quadratic, ..self.clone() }
    }

    /// Nodes of each element in the order of Gmsh: four, or ten with the middles of edges 23 and 13 exchanged.
    fn gmsh_elements(&self) -> Vec<Vec<u32>> {
        if self.quadratic.is_empty() {
            return self.tetrahedra.iter().map(|t| t.to_vec()).collect();
        }
        let turned = |nodes: &[u32; 10]| {
            let mut nodes = nodes.to_vec();
            nodes.swap(8, 9);
            nodes
        };
        self.quadratic.iter().map(turned).collect()
    }

    /// The bytes of a file of the mesh. Numbers of Gmsh files begin at 1; the groups `low end`, `high end` (faces) and `body` (tetrahedra) are in these alone.
    pub fn bytes(&self, format: TetFormat) -> Vec<u8> {
        let mut out = Vec::new();
        // A Vec takes everything.
        _ = match format {
            TetFormat::Msh2 | TetFormat::Msh2Binary => self.write_msh2(format == TetFormat::Msh2Binary, &mut out),
            TetFormat::Msh4 | TetFormat::Msh4Binary => self.write_msh4(format == TetFormat::Msh4Binary, &mut out),
            TetFormat::Vtk | TetFormat::VtkBinary | TetFormat::Vtk5 => self.write_vtk(format, &mut out),
        };
        out
    }

    /// Nodes of the boundary's faces with this x: their corners, and of quadratic tetrahedra the middles of edges 01, 12 and 20.
    fn faces_at(&self, x: f64) -> Vec<Vec<u32>> {
        let mut count: HashMap<[u32; 3], (Vec<u32>, u32)> = HashMap::new();
        for (element, corners) in self.tetrahedra.iter().enumerate() {
            for face in [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]] {
                let mut key = face.map(|corner| corners[corner]);
                let mut nodes = key.to_vec();
                key.sort_unstable();
                if let Some(all) = self.quadratic.get(element) {
                    let middle = |a: usize, b: usize| {
                        let at = EDGES.iter().position(|edge| *edge == [a.min(b), a.max(b)]);
                        all[4 + at.unwrap_or_default()]
                    };
                    nodes.extend([middle(face[0], face[1]), middle(face[1], face[2]), middle(face[2], face[0])]);
                }
                count.entry(key).or_insert((nodes, 0)).1 += 1;
            }
        }
        let is_there = |face: &[u32]| face.iter().all(|node| self.points[*node as usize].x == x);
        let mut faces: Vec<Vec<u32>> = count.into_values().filter(|(_, n)| *n == 1).map(|(face, _)| face).collect();
        faces.retain(|face| is_there(face));
        faces.sort_unstable();
        faces
    }

    /// Types of triangles and tetrahedra in Gmsh.
    fn gmsh_kinds(&self) -> [i32; 2] {
        if self.quadratic.is_empty() { [2, 4] } else { [9, 11] }
    }

    const NAMES: &str = "$PhysicalNames\n3\n2 1 \"low end\"\n2 2 \"high end\"\n3 7 \"body\"\n$EndPhysicalNames\n";

    fn write_msh2(&self, is_binary: bool, out: &mut Vec<u8>) -> std::io::Result<()> {
        let words = Numbers { is_binary, is_big_endian: false };
        writeln!(out, "$MeshFormat\n2.2 {} 8", u8::from(is_binary))?;
        words.order(out)?;
        write!(out, "$EndMeshFormat\n{}$Nodes\n{}\n", Self::NAMES, self.points.len())?;
        for (point, number) in self.points.iter().zip(1..) {
            words.ints(&[number], out)?;
            words.reals(point.as_slice(), out)?;
            words.end(out)?;
        }
        let ends = [self.faces_at(0.0), self.faces_at(self.size[0])];
        let count = ends[0].len() + ends[1].len() + self.tetrahedra.len();
        write!(out, "\n$EndNodes\n$Elements\n{count}\n")?;
        let mut number = 0;
        let mut block = |kind: i32, tag: i32, cells: &mut dyn Iterator<Item = Vec<i32>>, out: &mut Vec<u8>| {
            let cells: Vec<Vec<i32>> = cells.collect();
            if is_binary {
                words.ints(&[kind, cells.len() as i32, 2], out)?;
            }
            for nodes in cells {
                number += 1;
                words.ints(&[number, kind, 2][..if is_binary { 1 } else { 3 }], out)?;
                words.ints(&[tag, tag], out)?;
                words.ints(&nodes, out)?;
                words.end(out)?;
            }
            std::io::Result::Ok(())
        };
        let [triangle, tetrahedron] = self.gmsh_kinds();
        let numbers = |nodes: &Vec<u32>| nodes.iter().map(|n| *n as i32 + 1).collect();
        for (tag, faces) in [1, 2].into_iter().zip(&ends) {
            block(triangle, tag, &mut faces.iter().map(numbers), out)?;
        }
        block(tetrahedron, 7, &mut self.gmsh_elements().iter().map(numbers), out)?;
        write!(out, "\n$EndElements\n")
    }

    fn write_msh4(&self, is_binary: bool, out: &mut Vec<u8>) -> std::io::Result<()> {
        let words = Numbers { is_binary, is_big_endian: false };
        writeln!(out, "$MeshFormat\n4.1 {} 8", u8::from(is_binary))?;
        words.order(out)?;
        write!(out, "$EndMeshFormat\n{}$Entities\n", Self::NAMES)?;
        words.sizes(&[0, 0, 2, 1], out)?;
        words.end(out)?;
        for (tag, physical, bounding) in [(11, 1, 0), (12, 2, 0), (1, 7, 2)] {
            words.ints(&[tag], out)?;
            words.reals(&[0.0, 0.0, 0.0, self.size[0], self.size[1], self.size[2]], out)?;
            words.sizes(&[1], out)?;
            words.ints(&[physical], out)?;
            words.sizes(&[bounding], out)?;
            words.ints(&[11, 12][..bounding as usize], out)?;
            words.end(out)?;
        }
        write!(out, "\n$EndEntities\n$Nodes\n")?;
        let nodes = self.points.len() as u64;
        // Two blocks, the second one with parameters.
        let half = self.points.len() / 2;
        words.sizes(&[2, nodes, 1, nodes], out)?;
        words.end(out)?;
        for (first, points, parameters) in [(0, &self.points[..half], 0), (half, &self.points[half..], 2)] {
            words.ints(&[2, 11, i32::from(parameters > 0)], out)?;
            words.sizes(&[points.len() as u64], out)?;
            words.end(out)?;
            for number in first..first + points.len() {
                words.sizes(&[number as u64 + 1], out)?;
                words.end(out)?;
            }
            for point in points {
                words.reals(point.as_slice(), out)?;
                words.reals(&[0.5, 0.25][..parameters], out)?;
                words.end(out)?;
            }
        }
        write!(out, "\n$EndNodes\n$Elements\n")?;
        let ends = [self.faces_at(0.0), self.faces_at(self.size[0])];
        let count = (ends[0].len() + ends[1].len() + self.tetrahedra.len()) as u64;
        words.sizes(&[3, count, 1, count], out)?;
        words.end(out)?;
        let mut number = 0;
        let mut block = |head: [i32; 3], cells: Vec<Vec<u64>>, out: &mut Vec<u8>| {
            words.ints(&head, out)?;
            words.sizes(&[cells.len() as u64], out)?;
            words.end(out)?;
            for nodes in cells {
                number += 1;
                words.sizes(&[number], out)?;
                words.sizes(&nodes, out)?;
                words.end(out)?;
            }
            std::io::Result::Ok(())
        };
        let [triangle, tetrahedron] = self.gmsh_kinds();
        let numbers = |nodes: &Vec<u32>| nodes.iter().map(|n| u64::from(*n) + 1).collect();
        for (tag, faces) in [11, 12].into_iter().zip(&ends) {
            block([2, tag, triangle], faces.iter().map(numbers).collect(), out)?;
        }
        block([3, 1, tetrahedron], self.gmsh_elements().iter().map(numbers).collect(), out)?;
        write!(out, "\n$EndElements\n")
    }

    fn write_vtk(&self, format: TetFormat, out: &mut Vec<u8>) -> std::io::Result<()> {
        let (is_binary, is_new) = (format == TetFormat::VtkBinary, format == TetFormat::Vtk5);
        let words = Numbers { is_binary, is_big_endian: true };
        let (version, kind) = (if is_new { "5.1" } else { "3.0" }, if is_binary { "BINARY" } else { "ASCII" });
        let (nodes, cells) = (self.points.len(), self.tetrahedra.len());
        write!(
            out,
            "# vtk DataFile Version {version}\nbox\n{kind}\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\ntime 1 1 double\n"
        )?;
        words.reals(&[0.5], out)?;
        writeln!(out, "\nPOINTS {nodes} double")?;
        for point in &self.points {
            words.reals(point.as_slice(), out)?;
            words.end(out)?;
        }
        write!(out, "\nMETADATA\nINFORMATION 0\n\n")?;
        let (each, kind) = if self.quadratic.is_empty() { (4, 10) } else { (10, 24) };
        let elements: Vec<Vec<u32>> = match self.quadratic.is_empty() {
            true => self.tetrahedra.iter().map(|t| t.to_vec()).collect(),
            false => self.quadratic.iter().map(|t| t.to_vec()).collect(),
        };
        if is_new {
            write!(out, "CELLS {} {}\nOFFSETS vtktypeint64\n", cells + 1, each * cells)?;
            words.sizes(&(0..=cells).map(|cell| (each * cell) as u64).collect::<Vec<_>>(), out)?;
            write!(out, "\nCONNECTIVITY vtktypeint64\n")?;
            words.sizes(&elements.iter().flatten().map(|n| u64::from(*n)).collect::<Vec<_>>(), out)?;
        } else {
            writeln!(out, "CELLS {cells} {}", (each + 1) * cells)?;
            for t in &elements {
                words.ints(&[each as i32], out)?;
                words.ints(&t.iter().map(|n| *n as i32).collect::<Vec<_>>(), out)?;
                words.end(out)?;
            }
        }
        write!(out, "\nCELL_TYPES {cells}\n")?;
        words.ints(&vec![kind; cells], out)?;
        writeln!(out, "\nPOINT_DATA {nodes}")
    }
}

/// Writes numbers as text or binary.
#[derive(Clone, Copy)]
struct Numbers {
    is_binary: bool,
    is_big_endian: bool,
}

impl Numbers {
    /// The number 1 after the format line of a binary Gmsh file.
    fn order(self, out: &mut Vec<u8>) -> std::io::Result<()> {
        if self.is_binary {
            self.ints(&[1], out)?;
            writeln!(out)?;
        }
        Ok(())
    }

    /// Ends a line of a text.
    fn end(self, out: &mut Vec<u8>) -> std::io::Result<()> {
        if self.is_binary { Ok(()) } else { writeln!(out) }
    }

    fn ints(self, numbers: &[i32], out: &mut Vec<u8>) -> std::io::Result<()> {
        numbers.iter().try_for_each(|n| match (self.is_binary, self.is_big_endian) {
            (false, _) => write!(out, "{n} "),
            (true, true) => out.write_all(&n.to_be_bytes()),
            (true, false) => out.write_all(&n.to_le_bytes()),
        })
    }

    fn sizes(self, numbers: &[u64], out: &mut Vec<u8>) -> std::io::Result<()> {
        numbers.iter().try_for_each(|n| match (self.is_binary, self.is_big_endian) {
            (false, _) => write!(out, "{n} "),
            (true, true) => out.write_all(&n.to_be_bytes()),
            (true, false) => out.write_all(&n.to_le_bytes()),
        })
    }

    fn reals(self, numbers: &[f64], out: &mut Vec<u8>) -> std::io::Result<()> {
        numbers.iter().try_for_each(|n| match (self.is_binary, self.is_big_endian) {
            (false, _) => write!(out, "{n:?} "),
            (true, true) => out.write_all(&n.to_be_bytes()),
            (true, false) => out.write_all(&n.to_le_bytes()),
        })
    }
}
