//! `pliant.grid/1`.

use super::{Plugin, Status};
use core::ffi::CStr;

/// Extension id of a grid.
pub const GRID: &CStr = c"pliant.grid/1";

pub const CELL_EMPTY: u32 = 0;
pub const CELL_SURFACE: u32 = 1;
pub const CELL_INSIDE: u32 = 2;
/// No parent or child.
pub const NO_CELL: u64 = u64::MAX;
/// Corners of a cell.
pub const CELL_CORNERS: usize = 8;

#[repr(C)]
pub struct Surface {
    pub size: usize,
    pub points: *const f64,
    pub point_count: usize,
    pub triangles: *const u32,
    pub triangle_count: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    pub size: usize,
    pub level: u32,
    pub cells_per_axis: u32,
    pub edge: f64,
    pub origin: [f64; 3],
    pub surface_cells: u64,
    pub inside_cells: u64,
    pub nodes: u64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    pub size: usize,
    pub id: u64,
    pub parent: u64,
    pub children: [u64; 8],
    pub index: [u32; 3],
    pub state: u32,
    pub reference: [f64; 3],
    pub centre: [f64; 3],
    pub edge: f64,
    pub point_begin: usize,
    pub point_end: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    pub centre: [f64; 3],
    pub radius: f64,
}

#[repr(C)]
pub struct RegionRequest {
    pub size: usize,
    pub level: u32,
    pub families: u32,
    pub balls: *const Ball,
    pub ball_count: usize,
    pub cells: *const u64,
    pub cell_count: usize,
}

#[repr(C)]
pub struct Region {
    pub size: usize,
    pub node_capacity: usize,
    pub node_count: usize,
    pub node_id: *mut u64,
    pub node_rest: *mut f64,
    pub node_measure: *mut f64,
    pub node_border: *mut u8,
    pub cell_capacity: usize,
    pub cell_count: usize,
    pub cell_id: *mut u64,
    pub cell_corners: *mut u32,
    pub cell_points: *mut u32,
    pub cell_state: *mut u8,
    pub link_capacity: usize,
    pub link_count: usize,
    pub link_nodes: *mut u32,
    pub link_family: *mut u32,
    pub link_measure: *mut f64,
}

#[repr(C)]
pub struct Grid {
    pub size: usize,
    pub build: Option<unsafe extern "C" fn(*const Plugin, *const Surface, level: u32) -> Status>,
    pub level: Option<unsafe extern "C" fn(*const Plugin, level: u32, *mut Level) -> Status>,
    pub cell: Option<unsafe extern "C" fn(*const Plugin, level: u32, id: u64, *mut Cell) -> Status>,
    pub locate: Option<
        unsafe extern "C" fn(*const Plugin, level: u32, point: *const f64, id: *mut u64, local: *mut f64) -> Status,
    >,
    pub points:
        Option<unsafe extern "C" fn(*const Plugin, level: u32, points: *mut *const u32, count: *mut usize) -> Status>,
    pub region: Option<unsafe extern "C" fn(*const Plugin, *const RegionRequest, *mut Region) -> Status>,
    pub weights: Option<
        unsafe extern "C" fn(
            *const Plugin,
            level: u32,
            places: *const f64,
            count: usize,
            cells: *mut u64,
            weights: *mut f64,
        ) -> Status,
    >,
    pub place: Option<
        unsafe extern "C" fn(
            *const Plugin,
            level: u32,
            rest: *const f64,
            count: usize,
            corners: *const f64,
            places: *mut f64,
        ) -> Status,
    >,
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
