//! Cells that a blade has passed through, and the copies of nodes their parts need.
//!
//! The virtual node algorithm (Molino, Bao and Fedkiw 2004) on a lattice. Each cell near the cut is looked at in 4 x 4 x 4
//! voxels; two voxels are joined unless the blade passes between their middles. What hangs together within a cell is a
//! fragment, with its share of the cell's volume, mass and stiffness. Fragments of neighbouring cells that hang together
//! through their common face share the nodes of that face; any others have copies of their own. So a cut that ends inside
//! the body leaves its sides joined around its end, and one that goes through makes two bodies. Voxels the body is not in join
//! nothing: what only shares a cell is not held together by it.
//!
//! Everything here is in the rest shape, about the whole body, and independent of which cells are active.

mod anchor;
mod apply;
mod classes;
mod crossing;
mod places;
mod slivers;
mod voxels;

pub use anchor::Anchor;
use places::Places;
use pliant_host::{Grid, HostError, Region};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::{BTreeMap, HashMap};
use voxels::Voxels;

/// How far from a cell, in voxels, its links may go: to the middle of the next cell's first voxel, and from there on to the
/// place in it that is inside of the body.
const MARGIN: f64 = 1.5;

/// A node of the grid, or a copy of one: 0 is the node itself.
pub type NodeKey = (u64, u32);

/// Where a body is, in its rest shape.
pub trait Inner {
    /// Its triangles whose boxes meet the box around `centre` of half-size `reach`, m.
    fn near(&self, centre: Vec3, reach: f64) -> Vec<[Vec3; 3]>;
    /// Whether it encloses a place.
    fn has(&self, place: Vec3) -> bool;
}

/// The cut cells of a body.
#[derive(Clone, Debug, Default)]
pub struct Fragments {
    /// m
    edge: f64,
    cells: BTreeMap<u64, CutCell>,
    /// Those on each node.
    standing: HashMap<u64, Vec<u64>>,
    /// How many copies of a node there have been.
    copies: HashMap<u64, u32>,
    /// Copies made by the last advance, and what they were copied from.
    pub born: Vec<(NodeKey, NodeKey)>,
}

/// A cell near the cut.
#[derive(Clone, Debug)]
struct CutCell {
    /// m, its corner with the least coordinates
    reference: Vec3,
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

    /// Ids of such cells, rising.
    pub fn ids(&self) -> impl Iterator<Item = u64> + '_ {
        self.cells.keys().copied()
    }

    /// Ids and middles of such cells.
    pub fn middles(&self) -> impl Iterator<Item = (u64, Vec3)> + '_ {
        self.cells.iter().map(|(id, cell)| (*id, cell.reference.map(|c| c + 0.5 * self.edge)))
    }

    /// Takes in what a blade has swept, as triangles in the rest shape, m, of a body that `inner` knows. Gives the ids of the cells whose fragments or
    /// nodes may have changed.
    ///
    /// # Errors
    /// What the grid says.
    pub fn cut(
        &mut self,
        grid: &Grid,
        level: u32,
        swept: &[[Vec3; 3]],
        inner: &impl Inner,
    ) -> Result<Vec<u64>, HostError> {
        let mut met = Vec::new(); // cells a triangle may part, with the triangle
        for (number, triangle) in swept.iter().enumerate() {
            let mut cells = Vec::new();
            self.list_near(grid, level, triangle, MARGIN / voxels::SIDE as f64 * self.edge, &mut cells)?;
            met.extend(cells.into_iter().map(|id| (id, number)));
        }
        met.sort_unstable();
        // What is beside the cut is looked at too: there the two sides may meet in a cell outside of the body.
        let mut fresh = self.list_cells(grid, level, swept, 1.0)?;
        fresh.retain(|id| !self.cells.contains_key(id));
        self.add_cells(grid, level, &fresh, inner)?;
        let mut near = Vec::new();
        for of_cell in met.chunk_by(|a, b| a.0 == b.0) {
            near.push(of_cell[0].0);
            if let Some(cell) = self.cells.get_mut(&of_cell[0].0) {
                of_cell.iter().for_each(|(_, triangle)| cell.voxels.cut(&swept[*triangle]));
                cell.voxels.label();
            }
        }
        self.born.clear();
        for id in &fresh {
            if let Some(cell) = self.cells.get_mut(id) {
                cell.voxels.label();
            }
        }
        near.append(&mut fresh);
        near.append(&mut self.merge_slivers(&near));
        Ok(self.assign_nodes(&near))
    }

    /// Occupied cells that some triangle comes within `margin` edges of, rising.
    fn list_cells(&self, grid: &Grid, level: u32, swept: &[[Vec3; 3]], margin: f64) -> Result<Vec<u64>, HostError> {
        let mut out = Vec::new();
        for triangle in swept {
            self.list_near(grid, level, triangle, margin * self.edge, &mut out)?;
        }
        out.sort_unstable();
        out.dedup();
        Ok(out)
    }

    fn list_near(
        &self,
        grid: &Grid,
        level: u32,
        triangle: &[Vec3; 3],
        margin: f64,
        out: &mut Vec<u64>,
    ) -> Result<(), HostError> {
        let low = triangle[0].inf(&triangle[1]).inf(&triangle[2]).add_scalar(-margin);
        let high = triangle[0].sup(&triangle[1]).sup(&triangle[2]).add_scalar(margin);
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
                    let middle = Vec3::from(facts.origin) + facts.edge * Vec3::from(index).add_scalar(0.5);
                    if crossing::plane_meets_box(triangle, middle, 0.5 * self.edge + margin) {
                        let (id, _) = grid.locate(level, middle.into())?;
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

    fn add_cells(&mut self, grid: &Grid, level: u32, ids: &[u64], inner: &impl Inner) -> Result<(), HostError> {
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
            let reference = Vec3::from(facts.reference);
            let mut places = Places::middles(reference, facts.edge);
            let solid = match facts.state {
                abi::CELL_SURFACE => places.fit(facts.centre.into(), facts.edge, inner),
                _ => u64::MAX,
            };
            nodes.iter().for_each(|node| self.standing.entry(*node).or_default().push(id));
            let voxels = Voxels::new(solid, places);
            self.cells.insert(id, CutCell { reference, nodes, neighbours, voxels, fragments: vec![whole] });
        }
        Ok(())
    }

    /// The fragment of a cell that a place in it belongs to.
    pub fn fragment_at(&self, id: u64, place: Vec3) -> usize {
        self.cells.get(&id).map_or(0, |cell| cell.voxels.fragment_at(self.edge, place))
    }

    /// Share of a cell's volume that a fragment has.
    pub fn share(&self, id: u64, fragment: usize) -> f64 {
        self.cells.get(&id).map_or(1.0, |cell| cell.fragments[fragment].share)
    }

    /// Surface points that follow a fragment, none of one that is no more; `None` where the cell was not cut and has the grid's
    /// own list.
    pub fn points(&self, id: u64, fragment: usize) -> Option<&[u32]> {
        self.cells.get(&id).map(|cell| cell.fragments.get(fragment).map_or(&[][..], |f| f.points.as_slice()))
    }

    /// Takes all surface points from a cut cell.
    pub fn release(&mut self, id: u64) {
        if let Some(cell) = self.cells.get_mut(&id) {
            cell.fragments.iter_mut().for_each(|f| f.points.clear());
        }
    }

    /// Takes one surface point from a cut cell.
    pub fn release_point(&mut self, id: u64, point: u32) {
        if let Some(cell) = self.cells.get_mut(&id) {
            cell.fragments.iter_mut().for_each(|f| f.points.retain(|other| *other != point));
        }
    }

    /// Gives a surface point to the fragment it is anchored in.
    pub fn bind(&mut self, anchor: &Anchor, point: u32) {
        if let Some(cell) = self.cells.get_mut(&anchor.cell) {
            cell.fragments[anchor.fragment].points.push(point);
        }
    }
}
