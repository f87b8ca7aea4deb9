//! Writing of tetrahedral meshes as legacy VTK files.

use super::TetMesh;
use crate::geometry::Vec3;
use std::io::{self, Write};

impl TetMesh {
    /// Writes the mesh as a legacy VTK text file: nodes as in the file it was read from, in file units; a vector `displacement` of each node (n x 3, file units);
    /// and the numbers of nodes and elements in that file.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_vtk(&self, displacement: &[Vec3], out: &mut impl Write) -> io::Result<()> {
        let (nodes, cells) = (self.points.len(), self.tetrahedra.len());
        write!(out, "# vtk DataFile Version 3.0\nmesh and displacement by pliant\nASCII\nDATASET UNSTRUCTURED_GRID\n")?;
        writeln!(out, "POINTS {nodes} double")?;
        vectors(&self.points, out)?;
        writeln!(out, "CELLS {cells} {}", 5 * cells)?;
        for [a, b, c, d] in &self.tetrahedra {
            writeln!(out, "4 {a} {b} {c} {d}")?;
        }
        writeln!(out, "CELL_TYPES {cells}")?;
        for _ in 0..cells {
            writeln!(out, "10")?;
        }
        write!(out, "POINT_DATA {nodes}\nVECTORS displacement double\n")?;
        vectors(displacement, out)?;
        numbers("node", &self.node_number, out)?;
        writeln!(out, "CELL_DATA {cells}")?;
        numbers("element", &self.element_number, out)
    }
}

/// Writes vectors, one a line.
fn vectors(all: &[Vec3], out: &mut impl Write) -> io::Result<()> {
    all.iter().try_for_each(|v| writeln!(out, "{:?} {:?} {:?}", v.x, v.y, v.z))
}

/// Writes whole numbers, one a line.
fn numbers(name: &str, all: &[u64], out: &mut impl Write) -> io::Result<()> {
    write!(out, "SCALARS {name} long 1\nLOOKUP_TABLE default\n")?;
    all.iter().try_for_each(|number| writeln!(out, "{number}"))
}
