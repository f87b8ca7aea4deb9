//! Fragments of cut cells, and the copies of nodes that they need.
//!
//! The virtual node algorithm (Molino, Bao and Fedkiw 2004) on a lattice. Each cell near a cut is divided into 4 x 4 x 4 voxels; neighbouring
//! voxels are linked unless the blade passes between their points. A connected set of voxels is a fragment: it has the corners of the cell
//! and its share of the cell's volume, mass and stiffness. Fragments of neighbouring cells that are linked through the common face share the
//! nodes of that face; all others get copies. So a cut that ends inside the body leaves the material connected around its end, and a cut
//! that passes through makes two bodies. Voxels outside of the body connect nothing, so parts that merely lie in one cell are not joined.
//!
//! All positions are in the rest shape of the file, and nothing depends on which cells are active.

mod anchor;
mod apply;
mod crossing;
mod heal;
mod node_assignment;
mod part;
mod part_by_surface;
mod slivers;
mod voxel_points;
mod voxels;

pub use anchor::Anchor;
pub use part_by_surface::VoxelParts;
use pliant_host::{Grid, HostError, Region};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use voxel_points::VoxelPoints;
use voxels::Voxels;

/// Distance from a cell, in voxels, that its links reach: half a voxel to the centre of the next cell's first voxel, and one more to its point
/// inside of the body.
const LINK_REACH: f64 = 1.5;

/// A node of the grid, or a copy of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeKey {
    /// Id of the grid's node.
    pub node: u64,
    /// Number of the copy; 0 for the node itself.
    pub copy: u32,
}

/// A copy that a cut has made.
#[derive(Clone, Copy, Debug)]
pub struct NewCopy {
    pub key: NodeKey,
    /// The node that it starts as a copy of.
    pub original: NodeKey,
}

/// A fragment of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellFragment {
    /// Id of the cell.
    pub cell: u64,
    /// Number of the fragment within the cell; 0 for an uncut cell.
    pub fragment: usize,
}

/// The interior of a body in its rest shape.
pub trait BodyInterior {
    /// Triangles (m) of the surface whose bounding boxes meet a cube around `centre` with half-edge `half_size` (m).
    fn triangles_near(&self, centre: Vec3, half_size: f64) -> Vec<[Vec3; 3]>;
    /// Whether a point (m) is inside of the body.
    fn contains(&self, point: Vec3) -> bool;
}

/// The cut cells of a body.
#[derive(Clone, Debug, Default)]
pub struct Fragments {
    /// Edge of a cell, m.
    edge: f64,
    cells: BTreeMap<u64, CutCell>,
    /// Cut cells at each grid node.
    cells_of_node: HashMap<u64, Vec<u64>>,
    /// Number of copies made of each grid node so far.
    copies: HashMap<u64, u32>,
    /// Copies that cuts have made since the region was last replaced, in the order in which they were made.
    pub new_copies: Vec<NewCopy>,
    /// Nodes that the last change has made one with another, and that other.
    pub merged: Vec<(NodeKey, NodeKey)>,
    /// Cells that no blade has cut and that are in other bodies, since the body is a part of one that was split; `None` for a body that is whole.
    absent: Option<Arc<HashSet<u64>>>,
}

/// A cell that was cut or is next to a cut.
#[derive(Clone, Debug)]
struct CutCell {
    /// Corner with the least coordinates, m.
    reference: Vec3,
    /// Ids of the grid nodes at its corners.
    nodes: [u64; 8],
    /// Neighbours at -x, +x, -y, +y, -z, +z, or [`abi::NO_CELL`] where none is occupied.
    neighbours: [u64; 6],
    voxels: Voxels,
    fragments: Vec<Fragment>,
    /// Whether parts of it have been joined again since it was first cut.
    is_healed: bool,
}

/// A connected part of a cut cell.
#[derive(Clone, Debug)]
struct Fragment {
    /// Share of the cell's volume, 0 to 1.
    share: f64,
    nodes: [NodeKey; 8],
    /// Surface points embedded in it.
    points: Vec<u32>,
}

impl Fragments {
    /// No cuts, in cells of `edge` (m).
    pub fn new(edge: f64) -> Self {
        Self { edge, ..Self::default() }
    }

    /// Whether a cell was cut or is next to a cut.
    pub fn contains(&self, id: u64) -> bool {
        self.cells.contains_key(&id)
    }

    /// Ids of these cells, ascending.
    pub fn cell_ids(&self) -> impl Iterator<Item = u64> + '_ {
        self.cells.keys().copied()
    }

    /// Ids and centres (m) of these cells.
    pub fn centres(&self) -> impl Iterator<Item = (u64, Vec3)> + '_ {
        self.cells.iter().map(|(id, cell)| (*id, cell.reference.map(|c| c + 0.5 * self.edge)))
    }

    /// Cuts cells by the triangles (m, in the rest shape) that a blade has swept. Returns the ids of the cells whose fragments or nodes may
    /// have changed.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn cut(
        &mut self,
        grid: &Grid,
        level: u32,
        swept: &[[Vec3; 3]],
        interior: &impl BodyInterior,
    ) -> Result<Vec<u64>, HostError> {
        // Cells whose links a triangle may cross, with the index of the triangle.
        let mut hits = Vec::new();
        for (index, triangle) in swept.iter().enumerate() {
            let mut cells = Vec::new();
            self.list_near(grid, level, triangle, LINK_REACH / voxels::SIDE as f64 * self.edge, &mut cells)?;
            hits.extend(cells.into_iter().map(|id| (id, index)));
        }
        hits.sort_unstable();
        // Cells next to the cut as well: two sides of it may share such a cell outside of the body.
        let mut fresh = self.list_cells(grid, level, swept, 1.0)?;
        fresh.retain(|id| !self.cells.contains_key(id));
        self.add_cells(grid, level, &fresh, interior)?;
        let mut near = Vec::new();
        for hits in hits.chunk_by(|a, b| a.0 == b.0) {
            near.push(hits[0].0);
            if let Some(cell) = self.cells.get_mut(&hits[0].0) {
                hits.iter().for_each(|(_, triangle)| cell.voxels.cut(&swept[*triangle]));
                cell.voxels.label();
            }
        }
        for id in &fresh {
            if let Some(cell) = self.cells.get_mut(id) {
                cell.voxels.label();
            }
        }
        near.append(&mut fresh);
        near.append(&mut self.merge_slivers(&near));
        Ok(self.assign_nodes(&near))
    }

    /// Ids, ascending, of the occupied cells within `margin` edges of a triangle.
    fn list_cells(&self, grid: &Grid, level: u32, swept: &[[Vec3; 3]], margin: f64) -> Result<Vec<u64>, HostError> {
        let mut out = Vec::new();
        for triangle in swept {
            self.list_near(grid, level, triangle, margin * self.edge, &mut out)?;
        }
        out.sort_unstable();
        out.dedup();
        Ok(out)
    }

    /// Appends the ids of the occupied cells that may lie within `margin` (m) of a triangle.
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
        let cell_index = |x: f64, i: usize| ((x - facts.origin[i]) / facts.edge).floor();
        let range: [[f64; 2]; 3] =
            std::array::from_fn(|i| [cell_index(low[i], i).max(0.0), cell_index(high[i], i).min(last)]);
        let mut index = range.map(|r| r[0]);
        while index[2] <= range[2][1] {
            index[1] = range[1][0];
            while index[1] <= range[1][1] {
                index[0] = range[0][0];
                while index[0] <= range[0][1] {
                    let centre = Vec3::from(facts.origin) + facts.edge * Vec3::from(index).add_scalar(0.5);
                    if crossing::plane_meets_box(triangle, centre, 0.5 * self.edge + margin) {
                        let id = grid.locate(level, centre.into())?.cell;
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

    /// Adds cells as cut cells with a single fragment.
    fn add_cells(
        &mut self,
        grid: &Grid,
        level: u32,
        ids: &[u64],
        interior: &impl BodyInterior,
    ) -> Result<(), HostError> {
        let mut region = Region::default();
        grid.region(level, 0, &[], ids, &mut region)?;
        for (corners, &id) in region.cell_corners.iter().zip(&region.cell_id) {
            let facts = grid.cell(level, id)?;
            let nodes = corners.map(|n| region.node_id[n as usize]);
            let mut neighbours = [abi::NO_CELL; 6];
            for (side, neighbour) in neighbours.iter_mut().enumerate() {
                let mut centre = facts.centre;
                centre[side / 2] += if side % 2 == 1 { facts.edge } else { -facts.edge };
                let other = grid.locate(level, centre)?.cell;
                // The grid clamps a point outside of it to its outermost cell, which is then this one.
                if other != id && grid.cell(level, other)?.state != abi::CELL_EMPTY {
                    *neighbour = other;
                }
            }
            let whole = Fragment { share: 1.0, nodes: nodes.map(|node| NodeKey { node, copy: 0 }), points: Vec::new() };
            let reference = Vec3::from(facts.reference);
            let mut points = VoxelPoints::centres(reference, facts.edge);
            let solid = match facts.state {
                abi::CELL_SURFACE => points.move_inside(facts.centre.into(), facts.edge, interior),
                _ => u64::MAX,
            };
            nodes.iter().for_each(|node| self.cells_of_node.entry(*node).or_default().push(id));
            let (voxels, fragments) = match self.is_absent(id) {
                true => (Voxels::absent(points), Vec::new()),
                false => (Voxels::new(solid, points), vec![whole]),
            };
            self.cells.insert(id, CutCell { reference, nodes, neighbours, voxels, fragments, is_healed: false });
        }
        Ok(())
    }

    /// Number of the fragment of a cell that contains a rest position (m) in it.
    pub fn fragment_at(&self, id: u64, point: Vec3) -> usize {
        self.cells.get(&id).map_or(0, |cell| cell.voxels.fragment_at(self.edge, point))
    }

    /// A rest position (m) in a fragment; `None` in an uncut cell.
    pub fn place(&self, fragment: CellFragment) -> Option<Vec3> {
        let voxels = &self.cells.get(&fragment.cell)?.voxels;
        Some(voxels.points()[voxels.first(fragment.fragment)])
    }

    /// Share of its cell's volume that a fragment has, 0 to 1.
    pub fn share(&self, fragment: CellFragment) -> f64 {
        self.cells.get(&fragment.cell).map_or(1.0, |cell| cell.fragments[fragment.fragment].share)
    }

    /// Surface points embedded in a fragment, none for one that no longer exists; `None` for an uncut cell, whose points the grid lists.
    pub fn points(&self, fragment: CellFragment) -> Option<&[u32]> {
        let cell = self.cells.get(&fragment.cell)?;
        Some(cell.fragments.get(fragment.fragment).map_or(&[][..], |f| f.points.as_slice()))
    }

    /// Surface points of a fragment; `None` if there is no such fragment.
    pub fn part(&self, fragment: CellFragment) -> Option<&[u32]> {
        let part = self.cells.get(&fragment.cell)?.fragments.get(fragment.fragment)?;
        Some(&part.points)
    }

    /// Removes all surface points from the fragments of a cell.
    pub fn release(&mut self, id: u64) {
        if let Some(cell) = self.cells.get_mut(&id) {
            cell.fragments.iter_mut().for_each(|f| f.points.clear());
        }
    }

    /// Removes a surface point from the fragments of a cell.
    pub fn release_point(&mut self, id: u64, point: u32) {
        if let Some(cell) = self.cells.get_mut(&id) {
            cell.fragments.iter_mut().for_each(|f| f.points.retain(|other| *other != point));
        }
    }

    /// Adds a surface point to the fragment of its anchor.
    pub fn bind(&mut self, anchor: &Anchor, point: u32) {
        let cell = self.cells.get_mut(&anchor.fragment.cell);
        if let Some(fragment) = cell.and_then(|cell| cell.fragments.get_mut(anchor.fragment.fragment)) {
            fragment.points.push(point);
        }
    }
}
