//! What a file holds, before it is checked: nodes and cells with the bytes they are at.

use super::data::RawData;
use super::error::TetMeshProblem;
use super::words::Located;
use crate::geometry::Vec3;
use std::collections::BTreeMap;

/// Nodes and cells of a file, in its order.
#[derive(Debug, Default)]
pub(super) struct RawMesh {
    /// Number and position of each node, file units.
    pub nodes: Vec<(u64, Vec3)>,
    /// Byte of each node.
    pub node_at: Vec<usize>,
    /// Cells of one, two, three and four nodes: points, lines, triangles and tetrahedra.
    pub points: Vec<RawCell<1>>,
    pub lines: Vec<RawCell<2>>,
    pub triangles: Vec<RawCell<3>>,
    pub tetrahedra: Vec<RawCell<4>>,
    /// Cells with nodes in the middles of their edges: lines, triangles (edges 01, 12, 20) and tetrahedra (01, 12, 02, 03, 13, 23).
    pub curved_lines: Vec<RawCell<3>>,
    pub curved_triangles: Vec<RawCell<6>>,
    pub quadratic: Vec<RawCell<10>>,
    /// Sets of physical tags that cells refer to.
    pub tag_sets: Vec<Vec<i32>>,
    /// Names of physical groups by dimension and tag.
    pub names: BTreeMap<(u32, i32), String>,
    /// Number of cells of kinds that bound no volume and are left out, by kind.
    pub left_out: BTreeMap<&'static str, usize>,
    /// Numbers at nodes and cells.
    pub data: Vec<RawData>,
    /// Sections that are not read.
    pub sections: Vec<String>,
    /// Length of the file, bytes.
    pub end: usize,
}

/// A cell of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct RawCell<const CORNERS: usize> {
    /// Numbers of its nodes in the file.
    pub nodes: [u64; CORNERS],
    /// Its number in the file.
    pub number: u64,
    /// Byte at which it is.
    pub at: usize,
    /// Index of its physical tags in [`RawMesh::tag_sets`], or [`NO_TAGS`].
    pub tags: u32,
}

impl<const CORNERS: usize> RawCell<CORNERS> {
    /// A part of the cell, with these nodes of it.
    pub(super) fn with_nodes<const OTHER: usize>(&self, nodes: [u64; OTHER]) -> RawCell<OTHER> {
        RawCell { nodes, number: self.number, at: self.at, tags: self.tags }
    }
}

/// Value of [`RawCell::tags`] for a cell in no physical group.
pub(super) const NO_TAGS: u32 = u32::MAX;

/// Where a cell is, its number and its physical tags.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellFacts {
    pub number: u64,
    pub at: usize,
    pub tags: u32,
}

/// A kind of cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellKind {
    /// Name for messages.
    pub name: &'static str,
    pub dimension: u32,
    /// Number of its nodes.
    pub corners: usize,
}

impl RawMesh {
    /// Adds a cell with these nodes.
    ///
    /// # Errors
    /// A cell with a volume that is no tetrahedron of four or ten nodes.
    pub(super) fn push(&mut self, kind: CellKind, nodes: &[u64], facts: CellFacts) -> Result<(), Located> {
        let CellFacts { number, at, tags } = facts;
        match *nodes {
            [a] if kind.dimension == 0 => self.points.push(RawCell { nodes: [a], number, at, tags }),
            [a, b] if kind.dimension == 1 => self.lines.push(RawCell { nodes: [a, b], number, at, tags }),
            [a, b, c] if kind.dimension == 2 => self.triangles.push(RawCell { nodes: [a, b, c], number, at, tags }),
            [a, b, c, d] if kind.dimension == 3 => {
                self.tetrahedra.push(RawCell { nodes: [a, b, c, d], number, at, tags });
            }
            [a, b, c] if kind.dimension == 1 => self.curved_lines.push(RawCell { nodes: [a, b, c], number, at, tags }),
            [a, b, c, ab, bc, ca] if kind.dimension == 2 => {
                self.curved_triangles.push(RawCell { nodes: [a, b, c, ab, bc, ca], number, at, tags });
            }
            _ if kind.dimension < 3 => *self.left_out.entry(kind.name).or_default() += 1,
            _ => match nodes.try_into() {
                Ok(nodes) if kind.name.starts_with("tetrahedron") => {
                    self.quadratic.push(RawCell { nodes, number, at, tags });
                }
                _ => {
                    let remedy = match kind.name.starts_with("tetrahedron") {
                        true => "export the mesh with elements of order 1 or 2 (with Gmsh: `gmsh -3 -order 2`)",
                        false => "divide the mesh into tetrahedra (with Gmsh: without `Recombine`)",
                    };
                    return Err((at, TetMeshProblem::Cell { number, kind: kind.name.into(), remedy }));
                }
            },
        }
        Ok(())
    }

    /// Counts curved lines and triangles among the cells that are left out: without quadratic tetrahedra nothing has their middle nodes.
    pub(super) fn leave_out_curved(&mut self) {
        let (lines, triangles) = (std::mem::take(&mut self.curved_lines), std::mem::take(&mut self.curved_triangles));
        for (kind, count) in [("line of 3 nodes", lines.len()), ("triangle of 6 nodes", triangles.len())] {
            if count > 0 {
                *self.left_out.entry(kind).or_default() += count;
            }
        }
    }

    /// Adds a node.
    pub(super) fn push_node(&mut self, number: u64, at: usize, point: [f64; 3]) {
        self.nodes.push((number, point.into()));
        self.node_at.push(at);
    }

    /// Index of a set of physical tags; the last one is known, for cells of one set follow each other.
    pub(super) fn tag_set(&mut self, tags: &[i32]) -> u32 {
        if tags.is_empty() {
            return NO_TAGS;
        }
        if self.tag_sets.last().is_none_or(|last| last != tags) {
            self.tag_sets.push(tags.to_vec());
        }
        self.tag_sets.len() as u32 - 1
    }
}
