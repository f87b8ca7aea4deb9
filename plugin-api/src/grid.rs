//! The trait of a grid, and its side of the wire.

use crate::abi::{self, Ball, Cell, Level, Status};
use crate::fault::Fault;
use crate::info::Info;
use crate::instance::{Role, call, call_mut};
use crate::param::Params;
use core::ffi::{CStr, c_void};
use core::marker::PhantomData;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// The surface a grid is built around.
#[derive(Clone, Copy)]
pub struct SurfaceView<'a> {
    /// m (n x 3)
    pub points: &'a [[f64; 3]],
    /// (m x 3)
    pub triangles: &'a [[u32; 3]],
}

/// A place in a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// Id of the cell.
    pub cell: u64,
    /// Where in the cell, each within [0, 1].
    pub local: [f64; 3],
}

/// The part of a body that is asked for.
#[derive(Clone, Copy)]
pub struct RegionRequest<'a> {
    /// 1 is the root.
    pub level: u32,
    /// Families of links wanted, or 0.
    pub families: u32,
    /// Cells that these touch; an infinite radius takes the whole body.
    pub balls: &'a [Ball],
    /// Ids of cells wanted besides.
    pub cells: &'a [u64],
}

/// Which nodes carry a surface, and how the surface follows them.
pub trait Grid: Send + Sync + Sized + 'static {
    /// Facts for the descriptor.
    const INFO: Info;

    /// Takes the parameters.
    ///
    /// # Errors
    /// A combination of parameters that ranges could not exclude.
    fn new(params: &Params<'_>) -> Result<Self, Fault>;

    /// Builds all levels up to `level`, the finest. May take its time.
    ///
    /// # Errors
    /// A surface or level it cannot build; what was there before stays.
    fn build(&mut self, surface: &SurfaceView<'_>, level: u32) -> Result<(), Fault>;

    /// Facts about a level.
    ///
    /// # Errors
    /// A level that was not built.
    fn level(&self, level: u32) -> Result<Level, Fault>;

    /// One node of the tree.
    ///
    /// # Errors
    /// A level or cell there is not.
    fn cell(&self, level: u32, id: u64) -> Result<Cell, Fault>;

    /// The cell of a point, clamped onto the grid.
    ///
    /// # Errors
    /// A level that was not built; a point that is not finite.
    fn locate(&self, level: u32, point: [f64; 3]) -> Result<Location, Fault>;

    /// The surface points sorted by cell of `level`; ranges of it stand in [`Cell`] and in regions.
    ///
    /// # Errors
    /// A level that was not built.
    fn points(&self, level: u32) -> Result<&[u32], Fault>;

    /// Nodes, cells and links of a part of the body.
    ///
    /// # Errors
    /// A level that was not built.
    fn region(&self, request: &RegionRequest<'_>, out: &mut RegionSink<'_>) -> Result<(), Fault>;

    /// Cell and weights (8, sum 1) of each rest place; [`abi::NO_CELL`] and zeros for one too far outside the body to
    /// belong to a cell. *Real time*.
    ///
    /// # Errors
    /// A level that was not built.
    fn weights(
        &self,
        level: u32,
        places: &[[f64; 3]],
        cells: &mut [u64],
        weights: &mut [[f64; 8]],
    ) -> Result<(), Fault>;

    /// Places from rest places and the current corners of their cells, m. *Real time*.
    ///
    /// # Errors
    /// A level that was not built.
    fn place(
        &self,
        _level: u32,
        _rest: &[[f64; 3]],
        _corners: &[[[f64; 3]; 8]],
        _places: &mut [[f64; 3]],
    ) -> Result<(), Fault> {
        Err(Fault::unsupported("the embedding is linear: use the weights"))
    }

    /// Adds to the corners the transpose of the derivative of [`Grid::place`] times the loads, N. *Real time*.
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

    /// Whether [`Grid::place`] must be used instead of the weights.
    fn is_nonlinear(&self) -> bool {
        false
    }
}

/// Takes a region into the host's buffers. Pushing past a capacity only counts; the host then comes back with more room.
pub struct RegionSink<'a> {
    raw: &'a mut abi::Region,
}

#[allow(unsafe_code, reason = "writes into the host's buffers")]
impl RegionSink<'_> {
    /// Adds a node; its place is the number of nodes before it. Ids must rise.
    #[inline]
    pub fn node(&mut self, id: u64, rest: [f64; 3], measure: f64, border: bool) {
        let at = self.raw.node_count;
        self.raw.node_count += 1;
        if at < self.raw.node_capacity {
            // SAFETY: the host's node buffers hold `node_capacity` entries each.
            unsafe {
                *self.raw.node_id.add(at) = id;
                *self.raw.node_rest.cast::<[f64; 3]>().add(at) = rest;
                *self.raw.node_measure.add(at) = measure;
                *self.raw.node_border.add(at) = u8::from(border);
            }
        }
    }

    /// Adds a cell: places of its corners, its range of the level's points, its state. Ids must rise.
    #[inline]
    pub fn cell(&mut self, id: u64, corners: [u32; 8], points: [u32; 2], state: u32) {
        let at = self.raw.cell_count;
        self.raw.cell_count += 1;
        if at < self.raw.cell_capacity {
            // SAFETY: the host's cell buffers hold `cell_capacity` entries each.
            unsafe {
                *self.raw.cell_id.add(at) = id;
                *self.raw.cell_corners.cast::<[u32; 8]>().add(at) = corners;
                *self.raw.cell_points.cast::<[u32; 2]>().add(at) = points;
                *self.raw.cell_state.add(at) = state as u8;
            }
        }
    }

    /// Adds a link between two places, the first lower.
    #[inline]
    pub fn link(&mut self, nodes: [u32; 2], family: u32, measure: f64) {
        let at = self.raw.link_count;
        self.raw.link_count += 1;
        if at < self.raw.link_capacity {
            // SAFETY: the host's link buffers hold `link_capacity` entries each.
            unsafe {
                *self.raw.link_nodes.cast::<[u32; 2]>().add(at) = nodes;
                *self.raw.link_family.add(at) = family;
                *self.raw.link_measure.add(at) = measure;
            }
        }
    }

    fn overflowed(&self) -> bool {
        let r = &self.raw;
        r.node_count > r.node_capacity || r.cell_count > r.cell_capacity || r.link_count > r.link_capacity
    }
}

/// A [`Grid`] as [`crate::export_plugins`] hands it over.
pub struct AsGrid<T>(PhantomData<T>);

impl<T: Grid> Role for AsGrid<T> {
    type Object = T;
    const INFO: Info = T::INFO;
    const KIND: u32 = abi::KIND_GRID;
    const EXTENSION: &'static CStr = abi::GRID;

    fn table() -> *const c_void {
        (&raw const *Self::TABLE).cast()
    }

    fn open(params: &Params<'_>, _limits: &abi::Limits) -> Result<T, Fault> {
        T::new(params)
    }
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
/// # Safety
/// `ptr` holds `len` values for as long as `'a`, or `len` is 0.
unsafe fn slice<'a, T>(ptr: *const T, len: usize) -> &'a [T] {
    // SAFETY: the caller's promise.
    if len == 0 { &[] } else { unsafe { from_raw_parts(ptr, len) } }
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
/// # Safety
/// `ptr` holds `len` values that nobody else uses for as long as `'a`, or `len` is 0.
unsafe fn slice_mut<'a, T>(ptr: *mut T, len: usize) -> &'a mut [T] {
    // SAFETY: the caller's promise.
    if len == 0 { Default::default() } else { unsafe { from_raw_parts_mut(ptr, len) } }
}

type P = *const abi::Plugin;

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

    unsafe extern "C" fn build(plugin: P, surface: *const abi::Surface, level: u32) -> Status {
        // SAFETY: see above.
        unsafe {
            call_mut::<Self, _>(plugin, |grid| {
                let s = &*surface;
                let points = slice(s.points.cast(), s.point_count);
                let triangles = slice(s.triangles.cast(), s.triangle_count);
                grid.build(&SurfaceView { points, triangles }, level)
            })
        }
    }

    unsafe extern "C" fn level(plugin: P, level: u32, out: *mut Level) -> Status {
        // SAFETY: see above.
        unsafe { call::<Self, _>(plugin, |grid| grid.level(level).map(|l| *out = l)) }
    }

    unsafe extern "C" fn cell(plugin: P, level: u32, id: u64, out: *mut Cell) -> Status {
        // SAFETY: see above.
        unsafe { call::<Self, _>(plugin, |grid| grid.cell(level, id).map(|c| *out = c)) }
    }

    unsafe extern "C" fn locate(plugin: P, level: u32, point: *const f64, id: *mut u64, local: *mut f64) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                let at = grid.locate(level, *point.cast())?;
                *id = at.cell;
                *local.cast() = at.local;
                Ok(())
            })
        }
    }

    unsafe extern "C" fn points(plugin: P, level: u32, points: *mut *const u32, count: *mut usize) -> Status {
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

    unsafe extern "C" fn region(plugin: P, request: *const abi::RegionRequest, out: *mut abi::Region) -> Status {
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
        plugin: P,
        level: u32,
        places: *const f64,
        count: usize,
        cells: *mut u64,
        weights: *mut f64,
    ) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                let (cells, weights) = (slice_mut(cells, count), slice_mut(weights.cast(), count));
                grid.weights(level, slice(places.cast(), count), cells, weights)
            })
        }
    }

    unsafe extern "C" fn place(
        plugin: P,
        level: u32,
        rest: *const f64,
        count: usize,
        corners: *const f64,
        places: *mut f64,
    ) -> Status {
        // SAFETY: see above.
        unsafe {
            call::<Self, _>(plugin, |grid| {
                if !grid.is_nonlinear() {
                    return Err(Fault::unsupported(""));
                }
                let (rest, corners) = (slice(rest.cast(), count), slice(corners.cast(), count));
                grid.place(level, rest, corners, slice_mut(places.cast(), count))
            })
        }
    }

    unsafe extern "C" fn pull_back(
        plugin: P,
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
