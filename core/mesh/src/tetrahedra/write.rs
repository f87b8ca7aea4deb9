//! Writing of tetrahedral meshes as legacy VTK files.

use super::TetMesh;
use crate::geometry::Vec3;
use std::fmt::Display;
use std::io::{self, Write};

impl TetMesh {
    /// Writes the mesh as a legacy VTK text file: nodes and elements, linear or quadratic, as in the file it was read from, in file units; a vector `displacement` of each node (n x 3, file units);
    /// and the numbers of nodes and elements in that file; with `failed` (m) also which elements have failed, 1, or else 0.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_vtk(&self, displacement: &[Vec3], failed: Option<&[u8]>, out: &mut impl Write) -> io::Result<()> {
        let (nodes, cells) = (self.points.len(), self.elements());
        write!(out, "# vtk DataFile Version 3.0\nmesh and displacement by pliant\nASCII\nDATASET UNSTRUCTURED_GRID\n")?;
        writeln!(out, "POINTS {nodes} double")?;
        vectors(&self.points, out)?;
        let kind = match self.quadratic.is_empty() {
            true => list_cells(&self.tetrahedra, out)?,
            false => list_cells(&self.quadratic, out)?,
        };
        writeln!(out, "CELL_TYPES {cells}")?;
        for _ in 0..cells {
            writeln!(out, "{kind}")?;
        }
        write!(out, "POINT_DATA {nodes}\nVECTORS displacement double\n")?;
        vectors(displacement, out)?;
        numbers("node", &self.node_number, out)?;
        writeln!(out, "CELL_DATA {cells}")?;
        numbers("element", &self.element_number, out)?;
        failed.map_or(Ok(()), |failed| numbers("failed", failed, out))
    }
}

/// Writes the nodes of tetrahedra, one a line. Returns the type of the cells.
fn list_cells<const NODES: usize>(all: &[[u32; NODES]], out: &mut impl Write) -> io::Result<u32> {
    writeln!(out, "CELLS {} {}", all.len(), (NODES + 1) * all.len())?;
    for nodes in all {
        write!(out, "{NODES}")?;
        nodes.iter().try_for_each(|node| write!(out, " {node}"))?;
        writeln!(out)?;
    }
    Ok(if NODES == 4 { 10 } else { 24 })
}

/// Writes vectors, one a line.
fn vectors(all: &[Vec3], out: &mut impl Write) -> io::Result<()> {
    all.iter().try_for_each(|v| writeln!(out, "{:?} {:?} {:?}", v.x, v.y, v.z))
}

/// Writes whole numbers, one a line.
fn numbers<T: Display>(name: &str, all: &[T], out: &mut impl Write) -> io::Result<()> {
    write!(out, "SCALARS {name} long 1\nLOOKUP_TABLE default\n")?;
    all.iter().try_for_each(|number| writeln!(out, "{number}"))
}
