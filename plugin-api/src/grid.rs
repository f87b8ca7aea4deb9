//! The trait of a grid, and the C functions behind its table.

use crate::abi::{self, Ball, Cell, Level, Status};
use crate::fault::Fault;
use crate::info::Info;
use crate::instance::{Role, call, call_mut};
use crate::param::Params;
use core::ffi::{CStr, c_void};
use core::marker::PhantomData;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// The triangulated surface a grid is built around.
#[derive(Clone, Copy)]
pub struct SurfaceView<'a> {
    /// Vertices, m (n x 3).
    pub points: &'a [[f64; 3]],
    /// Indices of vertices (m x 3).
    pub triangles: &'a [[u32; 3]],
}

/// A point, as a cell of a level and coordinates in that cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// Id of the cell.
    pub cell: u64,
    /// Coordinates in the cell, each in [0, 1].
    pub local: [f64; 3],
}

/// The part of a body that [`Grid::region`] is to list.
#[derive(Clone, Copy)]
pub struct RegionRequest<'a> {
    /// Level of the octree; 1 is the root.
    pub level: u32,
    /// Families of links wanted, or 0.
    pub families: u32,
    /// Occupied cells that touch one of these belong to the region; an infinite radius takes the whole body.
    pub balls: &'a [Ball],
    /// Ids of further cells of the region.
    pub cells: &'a [u64],
}

/// A grid of cubic cells around a surface: it generates the nodes, cells and links a body is simulated with, and embeds the surface
/// in them.
///
/// Methods marked *Real time* run inside a step and must not allocate, lock or do I/O.
pub trait Grid: Send + Sync + Sized + 'static {
    /// The plugin's descriptor.
    const INFO: Info;

    /// A grid with these parameters, not built yet.
    ///
    /// # Errors
    /// A combination of parameters that their ranges cannot exclude.
    fn new(params: &Params<'_>) -> Result<Self, Fault>;

    /// Builds all levels up to `level`, the finest. May take seconds.
    ///
    /// # Errors
    /// A surface or level it cannot build; what was built before stays.
    fn build(&mut self, surface: &SurfaceView<'_>, level: u32) -> Result<(), Fault>;

    /// Describes a level.
    ///
    /// # Errors
    /// A level that was not built.
    fn level(&self, level: u32) -> Result<Level, Fault>;

    /// Describes one cell of the octree, occupied or not.
    ///
    /// # Errors
    /// A level that was not built, or an id that lies outside the level.
    fn cell(&self, level: u32, id: u64) -> Result<Cell, Fault>;

    /// The cell that contains a `point`, m, which is clamped to the grid first.
    ///
    /// # Errors
    /// A level that was not built; a point that is not finite.
    fn locate(&self, level: u32, point: [f64; 3]) -> Result<Location, Fault>;

    /// Indices of the surface points, sorted by cell of `level`. [`Cell`] and regions refer to ranges of this list.
    ///
    /// # Errors
    /// A level that was not built.
    fn points(&self, level: u32) -> Result<&[u32], Fault>;

    /// Writes the nodes, cells and links of a part of the body to `out`.
    ///
    /// # Errors
    /// A level that was not built.
    fn region(&self, request: &RegionRequest<'_>, out: &mut RegionSink<'_>) -> Result<(), Fault>;

    /// For each rest position (m): its cell and the interpolation weights over the cell's corners (8, sum 1). A position too far
    /// outside the body to belong to a cell gets [`abi::NO_CELL`] and zeros. *Real time*.
    ///
    /// # Errors
    /// A level that was not built.
    fn weights(
        &self,
        level: u32,
        positions: &[[f64; 3]],
        cells: &mut [u64],
        weights: &mut [[f64; 8]],
    ) -> Result<(), Fault>;

    /// Nonlinear embedding: current positions from rest positions and the current corners of their cells, m. *Real time*.
    ///
    /// # Errors
    /// A level that was not built.
    fn place(
        &self,
        _level: u32,
        _rest: &[[f64; 3]],
        _corners: &[[[f64; 3]; 8]],
        _positions: &mut [[f64; 3]],
    ) -> Result<(), Fault> {
        Err(Fault::unsupported("the embedding is linear: use the weights"))
    }

    /// Adds the loads on embedded points to the corners of their cells: the transpose of the derivative of [`Grid::place`] times
    /// the loads, N. *Real time*.
    ///
    /// # Errors
    /// A level that was not built.
    fn pull_back(
        &self,
        _level: u32,
        _rest: &[[f64; 3]],
        _corners: &[[[f64; 3]; 8]],
        _loads: &[[f64; 3]],
        _corner_loads: &mut [[[f64; 3]; 8]],
    ) -> Result<(), Fault> {
        Err(Fault::unsupported("the embedding is linear: use the weights"))
    }

    /// Whether the host must use [`Grid::place`] and [`Grid::pull_back`] in the place of the weights.
    fn is_nonlinear(&self) -> bool {
        false
    }
}

/// Writes a region to the host's buffers. Past the capacity of a buffer it only counts; the host then calls again with larger ones.
pub struct RegionSink<'a> {
    raw: &'a mut abi::Region,
}

#[allow(unsafe_code, reason = "writes into the host's buffers")]
impl RegionSink<'_> {
    /// Appends a node: its id, rest position (m), share of the body's volume (m^3), and whether an occupied cell outside the region
    /// has it as a corner. Ids must ascend. Cells and links refer to it by the number of nodes before it.
    #[inline]
    pub fn node(&mut self, id: u64, rest: [f64; 3], measure: f64, border: bool) {
        let index = self.raw.node_count;
        self.raw.node_count += 1;
        if index < self.raw.node_capacity {
            // SAFETY: the host's node buffers hold `node_capacity` entries each.
            unsafe {
                *self.raw.node_id.add(index) = id;
                *self.raw.node_rest.cast::<[f64; 3]>().add(index) = rest;
                *self.raw.node_measure.add(index) = measure;
                *self.raw.node_border.add(index) = u8::from(border);
            }
        }
    }

    /// Appends a cell: its id, indices of its corners, range of [`Grid::points`], and state ([`abi::CELL_SURFACE`] or
    /// [`abi::CELL_INSIDE`]). Ids must ascend.
    #[inline]
    pub fn cell(&mut self, id: u64, corners: [u32; 8], points: [u32; 2], state: u32) {
        let index = self.raw.cell_count;
        self.raw.cell_count += 1;
        if index < self.raw.cell_capacity {
            // SAFETY: the host's cell buffers hold `cell_capacity` entries each.
            unsafe {
                *self.raw.cell_id.add(index) = id;
                *self.raw.cell_corners.cast::<[u32; 8]>().add(index) = corners;
                *self.raw.cell_points.cast::<[u32; 2]>().add(index) = points;
                *self.raw.cell_state.add(index) = state as u8;
            }
        }
    }

    /// Appends a link between two nodes, given by their indices, the lower first; `measure` is its boundary weight.
    #[inline]
    pub fn link(&mut self, nodes: [u32; 2], family: u32, measure: f64) {
        let index = self.raw.link_count;
        self.raw.link_count += 1;
        if index < self.raw.link_capacity {
            // SAFETY: the host's link buffers hold `link_capacity` entries each.
            unsafe {
                *self.raw.link_nodes.cast::<[u32; 2]>().add(index) = nodes;
                *self.raw.link_family.add(index) = family;
                *self.raw.link_measure.add(index) = measure;
            }
        }
    }

    /// Whether a buffer was too small.
    fn overflowed(&self) -> bool {
        let r = &self.raw;
        r.node_count > r.node_capacity || r.cell_count > r.cell_capacity || r.link_count > r.link_capacity
    }
}

/// Adapter: a [`Grid`] as a plugin, for [`crate::export_plugins`].
pub struct AsGrid<T>(PhantomData<T>);

impl<T: Grid> Role for AsGrid<T> {
    type Object = T;
    const INFO: Info = T::INFO;
    const KIND: u32 = abi::KIND_GRID;
    const EXTENSION: &'static CStr = abi::GRID;

    fn table() -> *const c_void {
        (&raw const *Self::TABLE).cast()
    }

    fn activate(params: &Params<'_>) -> Result<T, Fault> {
        T::new(params)
    }
}

/// A span of the host as a slice.
///
/// # Safety
/// `ptr` holds `len` values for as long as `'a`, or `len` is 0.
#[allow(unsafe_code, reason = "turns the host's spans into slices")]
unsafe fn slice<'a, T>(ptr: *const T, len: usize) -> &'a [T] {
    // SAFETY: the caller's promise.
    if len == 0 { &[] } else { unsafe { from_raw_parts(ptr, len) } }
}

/// A span of the host as a mutable slice.
///
/// # Safety
/// `ptr` holds `len` values that nothing else uses for as long as `'a`, or `len` is 0.
#[allow(unsafe_code, reason = "turns the host's spans into slices")]
unsafe fn slice_mut<'a, T>(ptr: *mut T, len: usize) -> &'a mut [T] {
    // SAFETY: the caller's promise.
    if len == 0 { Default::default() } else { unsafe { from_raw_parts_mut(ptr, len) } }
}

type PluginPtr = *const abi::Plugin;

#[allow(unsafe_code, reason = "the functions behind the table")]
impl<T: Grid> AsGrid<T> {
    const TABLE: &'static abi::Grid = &abi::Grid {
        size: size_of::<abi::Grid>(),
        build: Some(Self::build),
        level: Some(Self::level),
        cell: Some(Self::cell),
        locate: Some(Self::locate),
        points: Some(Self::points),
        region: Some(Self::region),
        weights: Some(Self::weights),
        place: Some(Self::place),
        pull_back: Some(Self::pull_back),
    };

    // SAFETY of every body below: the host calls with a live, active instance of this role, spans borrowed for the call of
    // the lengths it states, and output it alone owns; `build` is exclusive.

    unsafe extern "C" fn build(plugin: PluginPtr, surface: *const abi::Surface, level: u32) -> Status {
        // SAFETY: see above.
        unsafe {
            call_mut::<Self, _>(plugin, |grid| {
                let raw = &*surface;
                let points = slice(raw.points.cast(), raw.point_count);
                let triangles = slice(raw.triangles.cast(), raw.triangle_count);
                grid.build(&SurfaceView { points, triangles }, level)
            })
        }
    }

    unsafe extern "C" fn level(plugin: PluginPtr, level: u32, out: *mut Level) -> Status {
        // SAFETY: see above.
        unsafe { call::<Self, _>(plugin, |grid| grid.level(level).map(|l| *out = l)) }
    }

    unsafe extern "C" fn cell(plugin: PluginPtr, level: u32, id: u64, out: *mut Cell) -> Status {
        // SAFETY: see above.
        unsafe { call::<Self, _>(plugin, |grid| grid.cell(level, id).map(|c| *out = c)) }
    }

    unsafe extern "C" fn locate(
        plugin: PluginPtr,
        level: u32,
        point: *const f64,
        id: *mut u64,
        local: *mut f64,
    ) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                let found = grid.locate(level, *point.cast())?;
                *id = found.cell;
                *local.cast() = found.local;
                Ok(())
            })
        }
    }

    unsafe extern "C" fn points(plugin: PluginPtr, level: u32, points: *mut *const u32, count: *mut usize) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                let list = grid.points(level)?;
                *points = list.as_ptr();
                *count = list.len();
                Ok(())
            })
        }
    }

    unsafe extern "C" fn region(
        plugin: PluginPtr,
        request: *const abi::RegionRequest,
        out: *mut abi::Region,
    ) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                let r = &*request;
                let (balls, cells) = (slice(r.balls, r.ball_count), slice(r.cells, r.cell_count));
                let mut sink = RegionSink { raw: &mut *out };
                grid.region(&RegionRequest { level: r.level, families: r.families, balls, cells }, &mut sink)?;
                if sink.overflowed() { Err(Fault { status: Status::TOO_SMALL, reason: "".into() }) } else { Ok(()) }
            })
        }
    }

    unsafe extern "C" fn weights(
        plugin: PluginPtr,
        level: u32,
        positions: *const f64,
        count: usize,
        cells: *mut u64,
        weights: *mut f64,
    ) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                let (cells, weights) = (slice_mut(cells, count), slice_mut(weights.cast(), count));
                grid.weights(level, slice(positions.cast(), count), cells, weights)
            })
        }
    }

    unsafe extern "C" fn place(
        plugin: PluginPtr,
        level: u32,
        rest: *const f64,
        count: usize,
        corners: *const f64,
        positions: *mut f64,
    ) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                if !grid.is_nonlinear() {
                    return Err(Fault::unsupported(""));
                }
                let (rest, corners) = (slice(rest.cast(), count), slice(corners.cast(), count));
                grid.place(level, rest, corners, slice_mut(positions.cast(), count))
            })
        }
    }

    unsafe extern "C" fn pull_back(
        plugin: PluginPtr,
        level: u32,
        rest: *const f64,
        count: usize,
        corners: *const f64,
        loads: *const f64,
        corner_loads: *mut f64,
    ) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                if !grid.is_nonlinear() {
                    return Err(Fault::unsupported(""));
                }
                let (rest, corners) = (slice(rest.cast(), count), slice(corners.cast(), count));
                grid.pull_back(level, rest, corners, slice(loads.cast(), count), slice_mut(corner_loads.cast(), count))
            })
        }
    }
}
