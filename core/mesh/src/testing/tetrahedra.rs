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
        let mut made = Self { size, parts, points: Vec::new(), tetrahedra: Vec::new() };
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
        random.shuffle(&mut tetrahedra);
        tetrahedra.iter_mut().for_each(|t| t[1..].rotate_left(random.below(3) as usize));
        Self { points, tetrahedra, ..self.clone() }
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

    /// Corners of the boundary's faces with this x.
    fn faces_at(&self, x: f64) -> Vec<[u32; 3]> {
        let mut count: HashMap<[u32; 3], ([u32; 3], u32)> = HashMap::new();
        for [a, b, c, d] in &self.tetrahedra {
            for face in [[*b, *c, *d], [*a, *d, *c], [*a, *b, *d], [*a, *c, *b]] {
                let mut key = face;
                key.sort_unstable();
                count.entry(key).or_insert((face, 0)).1 += 1;
            }
        }
        let is_there = |face: &[u32; 3]| face.iter().all(|node| self.points[*node as usize].x == x);
        let mut faces: Vec<[u32; 3]> = count.into_values().filter(|(_, n)| *n == 1).map(|(face, _)| face).collect();
        faces.retain(is_there);
        faces.sort_unstable();
        faces
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
        for (tag, faces) in [1, 2].into_iter().zip(&ends) {
            block(2, tag, &mut faces.iter().map(|face| face.map(|n| n as i32 + 1).to_vec()), out)?;
        }
        block(4, 7, &mut self.tetrahedra.iter().map(|t| t.map(|n| n as i32 + 1).to_vec()), out)?;
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
        for (tag, faces) in [11, 12].into_iter().zip(&ends) {
            block([2, tag, 2], faces.iter().map(|face| face.map(|n| u64::from(n) + 1).to_vec()).collect(), out)?;
        }
        block([3, 1, 4], self.tetrahedra.iter().map(|t| t.map(|n| u64::from(n) + 1).to_vec()).collect(), out)?;
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
        if is_new {
            write!(out, "CELLS {} {}\nOFFSETS vtktypeint64\n", cells + 1, 4 * cells)?;
            words.sizes(&(0..=cells as u64).map(|cell| 4 * cell).collect::<Vec<_>>(), out)?;
            write!(out, "\nCONNECTIVITY vtktypeint64\n")?;
            words.sizes(&self.tetrahedra.iter().flatten().map(|n| u64::from(*n)).collect::<Vec<_>>(), out)?;
        } else {
            writeln!(out, "CELLS {cells} {}", 5 * cells)?;
            for t in &self.tetrahedra {
                words.ints(&[4], out)?;
                words.ints(&t.map(|n| n as i32), out)?;
                words.end(out)?;
            }
        }
        write!(out, "\nCELL_TYPES {cells}\n")?;
        words.ints(&vec![10; cells], out)?;
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
