//! A minimal host: an instance made through the exported symbol. Regions can only be written through the C table, so their tests use
//! this host.
#![allow(unsafe_code, reason = "plays the host")]

use super::shapes::Mesh;
use crate::pliant_export::pliant_entry;
use pliant_plugin_api::abi::{self, Ball, KIND_GRID, Limits, Plugin, Status};
use pliant_plugin_api::{Fault, SurfaceView};
use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::ptr::null;

/// An active instance.
pub(super) struct Host {
    plugin: *const Plugin,
    table: *const abi::Grid,
    /// Boxed, because the instance keeps a pointer to it.
    host: Box<abi::Host>,
    /// Lines the instance reported.
    lines: Box<RefCell<Vec<String>>>,
}

/// The buffers of a region: see [`abi::Region`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Region {
    pub(super) node_id: Vec<u64>,
    pub(super) node_rest: Vec<[f64; 3]>,
    pub(super) node_measure: Vec<f64>,
    pub(super) node_border: Vec<u8>,
    pub(super) cell_id: Vec<u64>,
    pub(super) cell_corners: Vec<[u32; 8]>,
    pub(super) cell_points: Vec<[u32; 2]>,
    pub(super) cell_state: Vec<u8>,
    pub(super) link_nodes: Vec<[u32; 2]>,
    pub(super) link_family: Vec<u32>,
    pub(super) link_measure: Vec<f64>,
}

/// Selects the whole body.
pub(super) const WHOLE: Ball = Ball { centre: [0.0; 3], radius: f64::INFINITY };
/// All families of links.
pub(super) const ALL: u32 = abi::STRUCTURAL | abi::SHEAR | abi::FLEXION | abi::BODY_DIAGONAL;

impl Host {
    /// An active instance with default parameters, not built.
    pub(super) fn new() -> Self {
        let lines = Box::new(RefCell::new(Vec::new()));
        let host = Box::new(abi::Host {
            size: size_of::<abi::Host>(),
            abi_major: abi::ABI_MAJOR,
            abi_minor: abi::ABI_MINOR,
            data: (&raw const *lines).cast_mut().cast(),
            report: Some(report),
        });
        // SAFETY: as a host does it: descriptor, create, activate, and a table that lives as long as the library.
        unsafe {
            let library = &pliant_entry.0;
            let descriptor = &*library.descriptor.unwrap()(0);
            assert_eq!((descriptor.kind, CStr::from_ptr(descriptor.id)), (KIND_GRID, c"octree-grid"));
            assert!(library.descriptor.unwrap()(1).is_null());
            let plugin = library.create.unwrap()(&raw const *host, descriptor.id);
            let limits = Limits { size: size_of::<Limits>(), dt: 1e-3 };
            assert_eq!((*plugin).activate.unwrap()(plugin, &raw const limits), Status::OK);
            let table = (*plugin).extension.unwrap()(plugin, abi::GRID.as_ptr()).cast();
            Self { plugin, table, host, lines }
        }
    }

    /// An instance with `mesh` built to `level`.
    pub(super) fn with(mesh: &Mesh, level: u32) -> Self {
        let host = Self::new();
        host.build(&mesh.view(), level).unwrap();
        host
    }

    /// Calls `build` of the grid with a surface and a level.
    pub(super) fn build(&self, surface: &SurfaceView<'_>, level: u32) -> Result<(), Fault> {
        let raw = abi::Surface {
            size: size_of::<abi::Surface>(),
            points: surface.points.as_ptr().cast(),
            point_count: surface.points.len(),
            triangles: surface.triangles.as_ptr().cast(),
            triangle_count: surface.triangles.len(),
        };
        // SAFETY: the instance is active and the surface lives through the call.
        self.outcome(unsafe { (*self.table).build.unwrap()(self.plugin, &raw const raw, level) })
    }

    /// A region, by two calls: the first gives its size, the second its content.
    pub(super) fn region(&self, level: u32, families: u32, balls: &[Ball], cells: &[u64]) -> Result<Region, Fault> {
        let mut region = Region::default();
        match self.fill(level, families, balls, cells, &mut region) {
            (Status::TOO_SMALL, [nodes, cells_found, links]) => {
                region.resize(nodes, cells_found, links);
                let (status, counts) = self.fill(level, families, balls, cells, &mut region);
                assert_eq!(
                    counts,
                    [nodes, cells_found, links],
                    "the counts of the first call are what the second needs"
                );
                self.outcome(status).map(|()| region)
            }
            (status, _) => self.outcome(status).map(|()| region),
        }
    }

    /// One call with the buffers `region` has. Returns the status and the counts it needs: nodes, cells, links.
    pub(super) fn fill(
        &self,
        level: u32,
        families: u32,
        balls: &[Ball],
        cells: &[u64],
        region: &mut Region,
    ) -> (Status, [usize; 3]) {
        let request = abi::RegionRequest {
            size: size_of::<abi::RegionRequest>(),
            level,
            families,
            balls: if balls.is_empty() { null() } else { balls.as_ptr() },
            ball_count: balls.len(),
            cells: if cells.is_empty() { null() } else { cells.as_ptr() },
            cell_count: cells.len(),
        };
        let mut raw = abi::Region {
            size: size_of::<abi::Region>(),
            node_capacity: region.node_id.len(),
            node_count: 0,
            node_id: region.node_id.as_mut_ptr(),
            node_rest: region.node_rest.as_mut_ptr().cast(),
            node_measure: region.node_measure.as_mut_ptr(),
            node_border: region.node_border.as_mut_ptr(),
            cell_capacity: region.cell_id.len(),
            cell_count: 0,
            cell_id: region.cell_id.as_mut_ptr(),
            cell_corners: region.cell_corners.as_mut_ptr().cast(),
            cell_points: region.cell_points.as_mut_ptr().cast(),
            cell_state: region.cell_state.as_mut_ptr(),
            link_capacity: region.link_nodes.len(),
            link_count: 0,
            link_nodes: region.link_nodes.as_mut_ptr().cast(),
            link_family: region.link_family.as_mut_ptr(),
            link_measure: region.link_measure.as_mut_ptr(),
        };
        // SAFETY: the instance is active, the spans live through the call and the buffers are as long as stated.
        let status = unsafe { (*self.table).region.unwrap()(self.plugin, &raw const request, &raw mut raw) };
        (status, [raw.node_count, raw.cell_count, raw.link_count])
    }

    /// Turns a status into a fault with the last reported line.
    fn outcome(&self, status: Status) -> Result<(), Fault> {
        let reason = self.lines.borrow_mut().pop().unwrap_or_default();
        if status == Status::OK { Ok(()) } else { Err(Fault { status, reason: reason.into() }) }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: the instance is alive until here, and `host`, which it was handed, until after.
        unsafe {
            (*self.plugin).deactivate.unwrap()(self.plugin);
            (*self.plugin).destroy.unwrap()(self.plugin);
        }
        assert_eq!(self.host.abi_major, abi::ABI_MAJOR);
    }
}

impl Region {
    /// Makes buffers for these numbers of nodes, cells and links.
    pub(super) fn resize(&mut self, nodes: usize, cells: usize, links: usize) {
        self.node_id.resize(nodes, 0);
        self.node_rest.resize(nodes, [0.0; 3]);
        self.node_measure.resize(nodes, 0.0);
        self.node_border.resize(nodes, 0);
        self.cell_id.resize(cells, 0);
        self.cell_corners.resize(cells, [0; 8]);
        self.cell_points.resize(cells, [0; 2]);
        self.cell_state.resize(cells, 0);
        self.link_nodes.resize(links, [0; 2]);
        self.link_family.resize(links, 0);
        self.link_measure.resize(links, 0.0);
    }
}

/// The host's `report`: keeps every line.
unsafe extern "C" fn report(host: *const abi::Host, _severity: u32, text: *const c_char) {
    // SAFETY: `data` is the list of this host, used by one thread; the text is a C string for the call.
    unsafe {
        let lines = &*(*host).data.cast::<RefCell<Vec<String>>>();
        lines.borrow_mut().push(CStr::from_ptr(text).to_string_lossy().into_owned());
    }
}
