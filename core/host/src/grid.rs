//! An active grid and safe calls into it.

use crate::error::HostError;
use crate::instance::{Extension, Instance, ParamSettings};
use crate::library::Library;
use crate::plugin_info::{PluginInfo, PluginKind};
use pliant_plugin_api::abi::{self, Ball, Cell, Level, Status};
use std::slice::from_raw_parts;

/// The part of a grid that is simulated: n nodes, c cells and l links, in buffers that keep their capacity from one request to the
/// next.
#[derive(Clone, Debug, Default)]
pub struct Region {
    /// (n), rising; a node has the same id in every region of a level
    pub node_id: Vec<u64>,
    /// m (n x 3), rest positions
    pub node_rest: Vec<[f64; 3]>,
    /// m^3 (n), volume of the body around the node
    pub node_measure: Vec<f64>,
    /// (n), 1 where an occupied cell outside the region touches the node, else 0
    pub node_border: Vec<u8>,
    /// (n), number of the copy where a cut has doubled the node, else 0; set by the host
    pub node_copy: Vec<u32>,
    /// (c), rising ids of the cells
    pub cell_id: Vec<u64>,
    /// (c x 8), indices of the corners in the lists of nodes
    pub cell_corners: Vec<[u32; 8]>,
    /// (c x 2), begin and end of the cell's range of [`Grid::points`]
    pub cell_points: Vec<[u32; 2]>,
    /// (c), [`abi::CELL_SURFACE`] or [`abi::CELL_INSIDE`]
    pub cell_state: Vec<u8>,
    /// (c), number of the fragment where a cut has divided the cell, else 0; set by the host
    pub cell_fragment: Vec<u8>,
    /// (l x 2), indices of the joined nodes, rising
    pub link_nodes: Vec<[u32; 2]>,
    /// (l), family of the link, as a bit of the mask of the request
    pub link_family: Vec<u32>,
    /// (l), boundary weight of the link, 1 inside the body
    pub link_measure: Vec<f64>,
}

impl Region {
    /// Empties the region; its buffers keep their capacity.
    pub fn clear(&mut self) {
        self.resize(0, 0, 0);
        self.node_copy.clear();
        self.cell_fragment.clear();
    }

    /// Gives all lists of nodes, cells and links these lengths.
    fn resize(&mut self, nodes: usize, cells: usize, links: usize) {
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

    /// The region as the plugin fills it, with the lengths of the lists as capacities.
    fn raw(&mut self) -> abi::Region {
        abi::Region {
            size: size_of::<abi::Region>(),
            node_capacity: self.node_id.len(),
            node_count: 0,
            node_id: self.node_id.as_mut_ptr(),
            node_rest: self.node_rest.as_mut_ptr().cast(),
            node_measure: self.node_measure.as_mut_ptr(),
            node_border: self.node_border.as_mut_ptr(),
            cell_capacity: self.cell_id.len(),
            cell_count: 0,
            cell_id: self.cell_id.as_mut_ptr(),
            cell_corners: self.cell_corners.as_mut_ptr().cast(),
            cell_points: self.cell_points.as_mut_ptr().cast(),
            cell_state: self.cell_state.as_mut_ptr(),
            link_capacity: self.link_family.len(),
            link_count: 0,
            link_nodes: self.link_nodes.as_mut_ptr().cast(),
            link_family: self.link_family.as_mut_ptr(),
            link_measure: self.link_measure.as_mut_ptr(),
        }
    }

    /// Checks what the plugin filled in, of a surface with so many points: the rest of the engine indexes without further checks.
    fn check(&self, points: usize) -> Result<(), String> {
        let nodes = self.node_id.len() as u32;
        if !self.node_id.is_sorted_by(|a, b| a < b) || !self.cell_id.is_sorted_by(|a, b| a < b) {
            return Err("ids of nodes or cells are not in rising order".into());
        }
        if let Some(at) = self.node_rest.iter().flatten().position(|x| !x.is_finite()) {
            return Err(format!("rest position of node {} is not finite", at / 3));
        }
        if let Some(at) = self.cell_corners.iter().flatten().position(|&n| n >= nodes) {
            return Err(format!("cell {} has a corner that is not among the {nodes} nodes", at / 8));
        }
        if let Some(at) = self.cell_points.iter().position(|&[b, e]| b > e || e as usize > points) {
            return Err(format!("cell {at} has points outside of the {points} of the surface"));
        }
        match self.link_nodes.iter().position(|&[a, b]| a >= b || b >= nodes) {
            Some(at) => Err(format!(
                "link {at} joins nodes {:?} of {nodes}; allowed are two in rising order",
                self.link_nodes[at]
            )),
            None => Ok(()),
        }
    }
}

/// An active grid.
pub struct Grid {
    instance: Instance,
    table: &'static abi::Grid,
    nonlinear: bool,
}

#[allow(unsafe_code, reason = "calls the grid's functions")]
impl Grid {
    /// Opens the grid `name` of a library for steps of up to `dt` (s); nothing is built yet.
    ///
    /// # Errors
    /// A library without that grid, a malformed table, or refused parameters.
    pub fn open(library: &'static Library, name: &str, settings: &ParamSettings, dt: f64) -> Result<Self, HostError> {
        let info = library.plugin(PluginKind::Grid, name)?;
        let instance = Instance::open(library, info, settings, dt, Extension::new::<abi::Grid>(abi::GRID))?;
        // SAFETY: opened with the grid extension.
        let table: &'static abi::Grid = unsafe { instance.table() };
        let whole = table.build.is_some()
            && table.level.is_some()
            && table.cell.is_some()
            && table.locate.is_some()
            && table.points.is_some()
            && table.region.is_some()
            && table.weights.is_some();
        if !whole {
            return Err(instance.error("extension", "the grid's table has a null in it"));
        }
        let mut grid = Self { instance, table, nonlinear: false };
        grid.nonlinear = table.pull_back.is_some() && grid.place(1, &[], &[], &mut []).is_ok();
        Ok(grid)
    }

    /// Builds all levels up to `level` around a surface of points (m) and triangles. `[worker]`
    ///
    /// # Errors
    /// What the grid says of the surface or the level.
    pub fn build(&mut self, points: &[[f64; 3]], triangles: &[[u32; 3]], level: u32) -> Result<(), HostError> {
        let surface = abi::Surface {
            size: size_of::<abi::Surface>(),
            points: points.as_ptr().cast(),
            point_count: points.len(),
            triangles: triangles.as_ptr().cast(),
            triangle_count: triangles.len(),
        };
        let build = self.table.build.expect("checked");
        // SAFETY: [worker & active], exclusive by `&mut`.
        self.instance.run_input("build", || unsafe { build(self.instance.plugin(), &surface, level) })
    }

    /// Origin, cell edge and numbers of cells and nodes of a level.
    ///
    /// # Errors
    /// A level that was not built.
    pub fn level(&self, level: u32) -> Result<Level, HostError> {
        let (size, origin) = (size_of::<Level>(), [0.0; 3]);
        let mut out =
            Level { size, level, cells_per_axis: 0, edge: 0.0, origin, surface_cells: 0, inside_cells: 0, nodes: 0 };
        let get = self.table.level.expect("checked");
        // SAFETY: [any & active]; `out` is ours.
        self.instance.run("level", || unsafe { get(self.instance.plugin(), level, &mut out) })?;
        Ok(out)
    }

    /// One cell of the octree.
    ///
    /// # Errors
    /// A level that was not built, or an id without a cell.
    pub fn cell(&self, level: u32, id: u64) -> Result<Cell, HostError> {
        let mut out = Cell {
            size: size_of::<Cell>(),
            id,
            parent: abi::NO_CELL,
            children: [abi::NO_CELL; 8],
            index: [0; 3],
            state: 0,
            reference: [0.0; 3],
            centre: [0.0; 3],
            edge: 0.0,
            point_begin: 0,
            point_end: 0,
        };
        let get = self.table.cell.expect("checked");
        // SAFETY: [any & active]; `out` is ours.
        self.instance.run("cell", || unsafe { get(self.instance.plugin(), level, id, &mut out) })?;
        Ok(out)
    }

    /// The cell of a point (m), and the local coordinates in it, 0 to 1 each.
    ///
    /// # Errors
    /// A level that was not built; a point that is not finite.
    pub fn locate(&self, level: u32, point: [f64; 3]) -> Result<(u64, [f64; 3]), HostError> {
        let (mut id, mut local) = (0, [0.0; 3]);
        let get = self.table.locate.expect("checked");
        // SAFETY: [any & active]; the outputs are ours.
        let status = self.instance.within("locate", || unsafe {
            get(self.instance.plugin(), level, point.as_ptr(), &mut id, local.as_mut_ptr())
        });
        self.instance.check("locate", status).map(|()| (id, local))
    }

    /// Indices of the surface's points, sorted by cell of `level`.
    ///
    /// # Errors
    /// A level that was not built.
    pub fn points(&self, level: u32) -> Result<&[u32], HostError> {
        let (mut list, mut count) = (std::ptr::null(), 0);
        let get = self.table.points.expect("checked");
        // SAFETY: [any & active]; the list lives until the next `build`, which needs `&mut self`.
        unsafe {
            self.instance.run("points", || get(self.instance.plugin(), level, &mut list, &mut count))?;
            Ok(if count == 0 { &[] } else { from_raw_parts(list, count) })
        }
    }

    /// Fills `out` with the cells of `level` that the balls touch and those in `cells`, their nodes, and the links of `families` (a bit
    /// mask). `[worker]`
    ///
    /// # Errors
    /// A level that was not built; a region with meaningless entries.
    pub fn region(
        &self,
        level: u32,
        families: u32,
        balls: &[Ball],
        cells: &[u64],
        out: &mut Region,
    ) -> Result<(), HostError> {
        let request = abi::RegionRequest {
            size: size_of::<abi::RegionRequest>(),
            level,
            families,
            balls: balls.as_ptr(),
            ball_count: balls.len(),
            cells: cells.as_ptr(),
            cell_count: cells.len(),
        };
        let get = self.table.region.expect("checked");
        out.resize(out.node_id.capacity(), out.cell_id.capacity(), out.link_family.capacity());
        loop {
            let mut raw = out.raw();
            // SAFETY: [worker & active]; the buffers hold what the capacities say.
            let status = self.instance.within("region", || unsafe { get(self.instance.plugin(), &request, &mut raw) });
            if status == Status::TOO_SMALL {
                // Half as much again, so that a region that grows a little does not come back for every step.
                let room = |needed: usize, had: usize| if needed > had { needed + needed / 2 } else { had };
                out.resize(
                    room(raw.node_count, raw.node_capacity),
                    room(raw.cell_count, raw.cell_capacity),
                    room(raw.link_count, raw.link_capacity),
                );
                continue;
            }
            self.instance.check("region", status)?;
            out.resize(
                raw.node_count.min(raw.node_capacity),
                raw.cell_count.min(raw.cell_capacity),
                raw.link_count.min(raw.link_capacity),
            );
            out.node_copy.clear();
            out.node_copy.resize(out.node_id.len(), 0);
            out.cell_fragment.clear();
            out.cell_fragment.resize(out.cell_id.len(), 0);
            let points = self.points(level)?.len();
            return out.check(points).map_err(|reason| self.instance.error("region", &reason));
        }
    }

    /// Cell and corner weights of each rest position (m); [`abi::NO_CELL`] and zeros for one in no cell. `[sim]`
    ///
    /// # Errors
    /// A level that was not built.
    pub fn weights(
        &self,
        level: u32,
        places: &[[f64; 3]],
        cells: &mut [u64],
        weights: &mut [[f64; 8]],
    ) -> Result<(), HostError> {
        assert!(places.len() == cells.len() && places.len() == weights.len());
        let get = self.table.weights.expect("checked");
        let (from, to) = (places.as_ptr().cast(), weights.as_mut_ptr().cast());
        // SAFETY: [sim & active]; the three lists have one length.
        let status = self.instance.within("weights", || unsafe {
            get(self.instance.plugin(), level, from, places.len(), cells.as_mut_ptr(), to)
        });
        self.instance.check("weights", status)?;
        self.check_finite("weights", places, |i| weights[i].iter().all(|w| w.is_finite()))
    }

    /// Whether the embedding is non-linear: points are then placed by [`Grid::place`] instead of by weights.
    pub fn is_nonlinear(&self) -> bool {
        self.nonlinear
    }

    /// Positions (m) of embedded points from their rest positions and the current corners of their cells. `[sim]`
    ///
    /// # Errors
    /// A grid that does not offer it, or fails.
    pub fn place(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        corners: &[[[f64; 3]; 8]],
        out: &mut [[f64; 3]],
    ) -> Result<(), HostError> {
        assert!(rest.len() == corners.len() && rest.len() == out.len());
        let Some(place) = self.table.place else { return Err(self.instance.error("place", "not offered")) };
        let (r, c, o) = (rest.as_ptr().cast(), corners.as_ptr().cast(), out.as_mut_ptr().cast());
        // SAFETY: [sim & active]; the three lists have one length.
        self.instance.run("place", || unsafe { place(self.instance.plugin(), level, r, rest.len(), c, o) })?;
        self.check_finite("place", rest, |i| out[i].iter().all(|x| x.is_finite()))
    }

    /// Adds to the corners (N) the loads (N) on the embedded points: the transpose of the derivative of [`Grid::place`]. `[sim]`
    ///
    /// # Errors
    /// A grid that does not offer it, or fails.
    pub fn pull_back(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        corners: &[[[f64; 3]; 8]],
        loads: &[[f64; 3]],
        out: &mut [[[f64; 3]; 8]],
    ) -> Result<(), HostError> {
        assert!(rest.len() == corners.len() && rest.len() == loads.len() && rest.len() == out.len());
        let Some(pull) = self.table.pull_back else { return Err(self.instance.error("pull_back", "not offered")) };
        let (r, c) = (rest.as_ptr().cast(), corners.as_ptr().cast());
        let (l, o) = (loads.as_ptr().cast(), out.as_mut_ptr().cast());
        // SAFETY: [sim & active]; the four lists have one length.
        self.instance.run("pull_back", || unsafe { pull(self.instance.plugin(), level, r, rest.len(), c, l, o) })
    }

    /// Checks that the results of `call` for the rest positions `places` are finite.
    fn check_finite(
        &self,
        call: &'static str,
        places: &[[f64; 3]],
        is_finite: impl Fn(usize) -> bool,
    ) -> Result<(), HostError> {
        match (0..places.len()).find(|&i| !is_finite(i)) {
            Some(i) => Err(self.instance.error(call, &format!("a result is not finite, for {:?} m", places[i]))),
            None => Ok(()),
        }
    }

    /// Whether the plugin panicked in a call.
    pub fn is_quarantined(&self) -> bool {
        self.instance.is_quarantined()
    }

    /// Descriptor of the plugin.
    pub fn info(&self) -> &'static PluginInfo {
        self.instance.info(PluginKind::Grid)
    }

    /// Library of the plugin.
    pub fn library(&self) -> &'static Library {
        self.instance.library()
    }
}
