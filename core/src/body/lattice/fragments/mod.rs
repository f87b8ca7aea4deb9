//! Cells that a blade has passed through, and the copies of nodes their parts need.
//!
//! The virtual node algorithm (Molino, Bao and Fedkiw 2004) on a lattice. Each cell near the cut is looked at in 4 x 4 x 4
//! voxels; two voxels are joined unless the blade passes between their middles. What hangs together within a cell is a
//! fragment, with its share of the cell's volume, mass and stiffness. Fragments of neighbouring cells that hang together
//! through their common face share the nodes of that face; any others have copies of their own. So a cut that ends inside
//! the body leaves its sides joined around its end, and one that goes through makes two bodies.
//!
//! Everything here is in the rest shape, about the whole body, and independent of which cells are active.

mod apply;
mod classes;
mod voxels;

use crate::host::{Grid, HostError, Region};
use crate::step::V3;
use pliant_plugin_api::abi;
use std::collections::{BTreeMap, HashMap};
use voxels::Voxels;

/// A node of the grid, or a copy of one: 0 is the node itself.
pub type NodeKey = (u64, u32);

/// The cut cells of a body.
#[derive(Clone, Debug, Default)]
pub struct Fragments {
    /// m
    edge: f64,
    cells: BTreeMap<u64, CutCell>,
    /// How many copies of a node there have been.
    copies: HashMap<u64, u32>,
    /// Copies made by the last advance, and what they were copied from.
    pub born: Vec<(NodeKey, NodeKey)>,
}

/// A cell near the cut.
#[derive(Clone, Debug)]
struct CutCell {
    /// m, its corner with the least coordinates
    reference: V3,
    /// Ids of its nodes.
    nodes: [u64; 8],
    /// Neighbours at -x, +x, -y, +y, -z, +z, or [`abi::NO_CELL`] where none is occupied.
    neighbours: [u64; 6],
    voxels: Voxels,
    fragments: Vec<Fragment>,
}

/// A part of a cell that hangs together.
#[derive(Clone, Debug)]
struct Fragment {
    /// Of the cell's volume.
    share: f64,
    nodes: [NodeKey; 8],
    /// Surface points that follow it.
    points: Vec<u32>,
}

impl Fragments {
    /// No cuts, in cells of `edge` (m).
    pub fn new(edge: f64) -> Self {
        Self { edge, ..Self::default() }
    }

    /// Whether a cell was cut, or is right beside a cut.
    pub fn has(&self, id: u64) -> bool {
        self.cells.contains_key(&id)
    }

    /// Ids and middles of such cells.
    pub fn middles(&self) -> impl Iterator<Item = (u64, V3)> + '_ {
        self.cells.iter().map(|(id, cell)| (*id, cell.reference.map(|c| c + 0.5 * self.edge)))
    }

    /// Takes in what a blade has swept, as triangles in the rest shape, m. Gives the ids of the cells whose fragments or
    /// nodes may have changed.
    ///
    /// # Errors
    /// What the grid says.
    pub fn cut(&mut self, grid: &Grid, level: u32, swept: &[[V3; 3]]) -> Result<Vec<u64>, HostError> {
        let mut near: Vec<u64> = Vec::new();
        for triangle in swept {
            self.list_cells(grid, level, triangle, &mut near)?;
        }
        near.sort_unstable();
        near.dedup();
        let fresh: Vec<u64> = near.iter().copied().filter(|id| !self.cells.contains_key(id)).collect();
        self.add_cells(grid, level, &fresh)?;
        for id in &near {
            if let Some(cell) = self.cells.get_mut(id) {
                for triangle in swept {
                    cell.voxels.cut(cell.reference, self.edge, triangle);
                }
                cell.voxels.label();
            }
        }
        self.born.clear();
        Ok(self.assign_nodes(&near))
    }

    /// Occupied cells that a triangle comes within half a voxel of.
    fn list_cells(&self, grid: &Grid, level: u32, triangle: &[V3; 3], out: &mut Vec<u64>) -> Result<(), HostError> {
        let margin = 0.5 * self.edge / voxels::SIDE as f64;
        let low: V3 = std::array::from_fn(|i| triangle.iter().fold(f64::INFINITY, |m, p| m.min(p[i])) - margin);
        let high: V3 = std::array::from_fn(|i| triangle.iter().fold(-f64::INFINITY, |m, p| m.max(p[i])) + margin);
        let facts = grid.level(level)?;
        let last = f64::from(facts.cells_per_axis) - 1.0;
        let place = |x: f64, i: usize| ((x - facts.origin[i]) / facts.edge).floor();
        let range: [(f64, f64); 3] = std::array::from_fn(|i| (place(low[i], i).max(0.0), place(high[i], i).min(last)));
        let mut index = range.map(|r| r.0);
        while index[2] <= range[2].1 {
            index[1] = range[1].0;
            while index[1] <= range[1].1 {
                index[0] = range[0].0;
                while index[0] <= range[0].1 {
                    let middle: V3 = std::array::from_fn(|i| facts.origin[i] + (index[i] + 0.5) * facts.edge);
                    if voxels::plane_meets_box(triangle, middle, 0.5 * self.edge + margin) {
                        let (id, _) = grid.locate(level, middle)?;
                        if grid.cell(level, id)?.state != abi::CELL_EMPTY {
                            out.push(id);
                        }
                    }
                    index[0] += 1.0;
                }
                index[1] += 1.0;
            }
            index[2] += 1.0;
        }
        Ok(())
    }

    fn add_cells(&mut self, grid: &Grid, level: u32, ids: &[u64]) -> Result<(), HostError> {
        let mut region = Region::default();
        grid.region(level, 0, &[], ids, &mut region)?;
        for (place, &id) in region.cell_id.iter().enumerate() {
            let facts = grid.cell(level, id)?;
            let nodes = region.cell_corners[place].map(|n| region.node_id[n as usize]);
            let mut neighbours = [abi::NO_CELL; 6];
            for (side, neighbour) in neighbours.iter_mut().enumerate() {
                let mut middle = facts.centre;
                middle[side / 2] += if side % 2 == 1 { facts.edge } else { -facts.edge };
                let (other, _) = grid.locate(level, middle)?;
                // A place outside of the grid is clamped back onto the cell itself.
                if other != id && grid.cell(level, other)?.state != abi::CELL_EMPTY {
                    *neighbour = other;
                }
            }
            let whole = Fragment { share: 1.0, nodes: nodes.map(|n| (n, 0)), points: Vec::new() };
            let (reference, voxels) = (facts.reference, Voxels::default());
            self.cells.insert(id, CutCell { reference, nodes, neighbours, voxels, fragments: vec![whole] });
        }
        Ok(())
    }

    /// The fragment of a cell that a place in it belongs to.
    pub fn fragment_at(&self, id: u64, place: V3) -> usize {
        self.cells.get(&id).map_or(0, |cell| cell.voxels.fragment_at(cell.reference, self.edge, place))
    }

    /// Share of a cell's volume that a fragment has.
    pub fn share(&self, id: u64, fragment: usize) -> f64 {
        self.cells.get(&id).map_or(1.0, |cell| cell.fragments[fragment].share)
    }

    /// Surface points that follow a fragment; `None` where the cell was not cut and has the grid's own list.
    pub fn points(&self, id: u64, fragment: usize) -> Option<&[u32]> {
        self.cells.get(&id).map(|cell| cell.fragments[fragment].points.as_slice())
    }

    /// Gives a cut cell's surface points to its fragments: `points` with a place on their own side of the cut, m.
    pub fn bind(&mut self, id: u64, points: impl Iterator<Item = (u32, V3)>) {
        let edge = self.edge;
        let Some(cell) = self.cells.get_mut(&id) else { return };
        cell.fragments.iter_mut().for_each(|f| f.points.clear());
        for (point, place) in points {
            let fragment = cell.voxels.fragment_at(cell.reference, edge, place);
            cell.fragments[fragment].points.push(point);
        }
    }
}
