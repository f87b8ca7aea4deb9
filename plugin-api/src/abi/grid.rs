//! `pliant.grid/1`.

use super::{Plugin, Status};
use core::ffi::CStr;

/// Extension id of [`Grid`].
pub const GRID: &CStr = c"pliant.grid/1";

/// State of a cell that does not belong to the body.
pub const CELL_EMPTY: u32 = 0;
/// State of a cell the surface passes through; only such cells can be touched.
pub const CELL_SURFACE: u32 = 1;
/// State of a cell inside the body.
pub const CELL_INSIDE: u32 = 2;
/// In the place of a cell id: there is no such cell.
pub const NO_CELL: u64 = u64::MAX;
/// Corners of a cell.
pub const CELL_CORNERS: usize = 8;

/// The surface `build` makes the cells for.
#[repr(C)]
pub struct Surface {
    /// `size_of` this struct.
    pub size: usize,
    /// (n x 3) m.
    pub points: *const f64,
    /// Number of points, n.
    pub point_count: usize,
    /// (m x 3) indices of points.
    pub triangles: *const u32,
    /// Number of triangles, m.
    pub triangle_count: usize,
}

/// One level of the octree.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// `size_of` this struct.
    pub size: usize,
    /// 1 is the root, one cell.
    pub level: u32,
    /// Cells along each axis.
    pub cells_per_axis: u32,
    /// m, the length of a cell's edge.
    pub edge: f64,
    /// m, the corner of cell 0 with the least coordinates.
    pub origin: [f64; 3],
    /// Number of cells the surface passes through.
    pub surface_cells: u64,
    /// Number of cells inside the body.
    pub inside_cells: u64,
    /// Number of corners of occupied cells.
    pub nodes: u64,
}

/// One cell of the octree.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// `size_of` this struct.
    pub size: usize,
    /// Id on its level.
    pub id: u64,
    /// Id on the next coarser level, or [`NO_CELL`].
    pub parent: u64,
    /// Ids on the next finer level, or [`NO_CELL`].
    pub children: [u64; 8],
    /// Index along each axis.
    pub index: [u32; 3],
    /// [`CELL_EMPTY`], [`CELL_SURFACE`] or [`CELL_INSIDE`].
    pub state: u32,
    /// m, the corner with the least coordinates.
    pub reference: [f64; 3],
    /// Centre of the cell, m.
    pub centre: [f64; 3],
    /// m, the length of its edge.
    pub edge: f64,
    /// Begin of its surface points in the list of [`Grid::points`].
    pub point_begin: usize,
    /// End of its surface points in the list of [`Grid::points`].
    pub point_end: usize,
}

/// A ball that selects the cells of a region.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Position of the centre, m.
    pub centre: [f64; 3],
    /// Radius, m; infinite to select the whole body.
    pub radius: f64,
}

/// The part of a body `region` is to list.
#[repr(C)]
pub struct RegionRequest {
    /// `size_of` this struct.
    pub size: usize,
    /// The level of the octree.
    pub level: u32,
    /// Families of links wanted, or 0.
    pub families: u32,
    /// Occupied cells that touch a ball belong to the region.
    pub balls: *const Ball,
    /// Number of balls.
    pub ball_count: usize,
    /// Ids of further cells of the region.
    pub cells: *const u64,
    /// Number of these cells.
    pub cell_count: usize,
}

/// The nodes, cells and links of a region, in buffers of the host. The counts say what is needed even where that exceeds a capacity.
#[repr(C)]
pub struct Region {
    /// `size_of` this struct.
    pub size: usize,
    /// Nodes the buffers hold.
    pub node_capacity: usize,
    /// Nodes of the region, n.
    pub node_count: usize,
    /// (n), ascending: the same node has the same id in every region of a level.
    pub node_id: *mut u64,
    /// (n x 3) m, rest positions.
    pub node_rest: *mut f64,
    /// (n) m^3, the volume of the body around the node.
    pub node_measure: *mut f64,
    /// (n) 1 where an occupied cell outside the region has this node as a corner.
    pub node_border: *mut u8,
    /// Cells the buffers hold.
    pub cell_capacity: usize,
    /// Cells of the region, c.
    pub cell_count: usize,
    /// (c) ids of the cells, ascending.
    pub cell_id: *mut u64,
    /// (c x 8) indices into the nodes; corner i at bits (x, y, z) = (i & 1, i >> 1 & 1, i >> 2).
    pub cell_corners: *mut u32,
    /// (c x 2) begin and end of the cell's surface points in the list of [`Grid::points`].
    pub cell_points: *mut u32,
    /// (c) [`CELL_SURFACE`] or [`CELL_INSIDE`].
    pub cell_state: *mut u8,
    /// Links the buffers hold.
    pub link_capacity: usize,
    /// Links of the region, l.
    pub link_count: usize,
    /// (l x 2) indices into the nodes, the lower one first.
    pub link_nodes: *mut u32,
    /// (l) [`super::STRUCTURAL`], [`super::SHEAR`], ...
    pub link_family: *mut u32,
    /// (l) boundary weight: 1 inside, 1/2 on a face, 1/4 on an edge of the body.
    pub link_measure: *mut f64,
}

/// Function table of [`GRID`].
#[repr(C)]
pub struct Grid {
    /// `size_of` this struct.
    pub size: usize,
    /// Builds all levels up to `level`, the finest, and binds the surface's points to it.
    pub build: Option<unsafe extern "C" fn(*const Plugin, *const Surface, level: u32) -> Status>,
    /// Describes a level.
    pub level: Option<unsafe extern "C" fn(*const Plugin, level: u32, *mut Level) -> Status>,
    /// Describes a cell; takes any id of the level.
    pub cell: Option<unsafe extern "C" fn(*const Plugin, level: u32, id: u64, *mut Cell) -> Status>,
    /// The cell that contains a point (m), which is clamped to the grid first, and the point in that cell, in `[0, 1]^3`.
    pub locate: Option<
        unsafe extern "C" fn(*const Plugin, level: u32, point: *const f64, id: *mut u64, local: *mut f64) -> Status,
    >,
    /// Indices of the surface points, sorted by cell of a level; lives until the next `build`.
    pub points:
        Option<unsafe extern "C" fn(*const Plugin, level: u32, points: *mut *const u32, count: *mut usize) -> Status>,
    /// Lists the nodes, cells and links of a region.
    pub region: Option<unsafe extern "C" fn(*const Plugin, *const RegionRequest, *mut Region) -> Status>,
    /// Cell and interpolation weights (count x 8, sum 1) of rest positions (count x 3, m); [`NO_CELL`] and zeros far outside.
    pub weights: Option<
        unsafe extern "C" fn(
            *const Plugin,
            level: u32,
            positions: *const f64,
            count: usize,
            cells: *mut u64,
            weights: *mut f64,
        ) -> Status,
    >,
    /// A nonlinear embedding: current positions (count x 3, m) from rest positions and the current corners of their cells
    /// (count x 8 x 3, m).
    pub place: Option<
        unsafe extern "C" fn(
            *const Plugin,
            level: u32,
            rest: *const f64,
            count: usize,
            corners: *const f64,
            positions: *mut f64,
        ) -> Status,
    >,
    /// The transpose of the derivative of `place`: adds loads (count x 3, N) to the corners (count x 8 x 3, N).
    pub pull_back: Option<
        unsafe extern "C" fn(
            *const Plugin,
            level: u32,
            rest: *const f64,
            count: usize,
            corners: *const f64,
            loads: *const f64,
            corner_loads: *mut f64,
        ) -> Status,
    >,
}
