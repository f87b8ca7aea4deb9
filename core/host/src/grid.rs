//! An active grid and safe calls into it.

use crate::error::HostError;
use crate::instance::{Extension, Instance, ParamSettings};
use crate::library::Library;
use crate::plugin_info::{PluginInfo, PluginKind};
use pliant_plugin_api::abi::{self, Ball, Cell, Level, Status};
use std::slice::from_raw_parts;

/// The simulated part of a grid: n nodes, c cells and l links. Requests reuse the buffers.
#[derive(Clone, Debug, Default)]
pub struct Region {
    /// Ids of the nodes (n), ascending; a node has the same id in every region of a level.
    pub node_id: Vec<u64>,
    /// Rest positions of the nodes, m (n x 3).
    pub node_rest: Vec<[f64; 3]>,
    /// Volume of the body around each node, m^3 (n).
    pub node_measure: Vec<f64>,
    /// 1 for a node that an occupied cell outside of the region touches, else 0 (n).
    pub node_border: Vec<u8>,
    /// Number of the copy of each node that a cut has doubled, else 0 (n); set by the host.
    pub node_copy: Vec<u32>,
    /// Ids of the cells (c), ascending.
    pub cell_id: Vec<u64>,
    /// Indices of the corners of each cell in the lists of nodes (c x 8).
    pub cell_corners: Vec<[u32; 8]>,
    /// Begin and end of each cell's range of [`Grid::points`] (c x 2).
    pub cell_points: Vec<[u32; 2]>,
    /// State of each cell, [`abi::CELL_SURFACE`] or [`abi::CELL_INSIDE`] (c).
    pub cell_state: Vec<u8>,
    /// Number of the fragment of each cell that a cut has divided, else 0 (c); set by the host.
    pub cell_fragment: Vec<u8>,
    /// Indices of the two nodes of each link, ascending (l x 2).
    pub link_nodes: Vec<[u32; 2]>,
    /// Family of each link, as a bit of the mask of the request (l).
    pub link_family: Vec<u32>,
    /// Boundary weight of each link, 1 inside of the body (l).
    pub link_measure: Vec<f64>,
}

impl Region {
    /// Empties the region; keeps the buffers.
    pub fn clear(&mut self) {
        self.resize(0, 0, 0);
        self.node_copy.clear();
        self.cell_fragment.clear();
    }

    /// Keeps the cells (by index) for which `is_kept` holds, the nodes at their corners and the links between these, in their order. Returns the new
    /// index of each node, `u32::MAX` for one that is gone.
    pub fn retain_cells(&mut self, mut is_kept: impl FnMut(usize) -> bool) -> Vec<u32> {
        let kept: Vec<bool> = (0..self.cell_id.len()).map(&mut is_kept).collect();
        let mut index = vec![u32::MAX; self.node_id.len()];
        let corners = self.cell_corners.iter().zip(&kept).filter(|(_, kept)| **kept);
        corners.flat_map(|(corners, _)| corners).for_each(|node| index[*node as usize] = 0);
        let used: Vec<bool> = index.iter().map(|index| *index == 0).collect();
        index.iter_mut().filter(|index| **index == 0).zip(0..).for_each(|(index, new)| *index = new);
        let links: Vec<bool> =
            self.link_nodes.iter().map(|ends| ends.iter().all(|node| used[*node as usize])).collect();
        retain(&mut self.node_id, &used);
        retain(&mut self.node_rest, &used);
        retain(&mut self.node_measure, &used);
        retain(&mut self.node_border, &used);
        retain(&mut self.node_copy, &used);
        retain(&mut self.cell_id, &kept);
        retain(&mut self.cell_corners, &kept);
        retain(&mut self.cell_points, &kept);
        retain(&mut self.cell_state, &kept);
        retain(&mut self.cell_fragment, &kept);
        retain(&mut self.link_nodes, &links);
        retain(&mut self.link_family, &links);
        retain(&mut self.link_measure, &links);
        self.cell_corners.iter_mut().flatten().for_each(|node| *node = index[*node as usize]);
        self.link_nodes.iter_mut().flatten().for_each(|node| *node = index[*node as usize]);
        index
    }

    /// Sets the lengths of the lists of nodes, cells and links.
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

    /// The region for the plugin to fill; the lengths of the lists are the capacities.
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

    /// Checks a region that the plugin has filled, of a surface with `points` points: the engine indexes with its entries.
    ///
    /// # Errors
    /// Returns a message with the first invalid entry.
    fn check(&self, points: usize) -> Result<(), String> {
        let nodes = self.node_id.len() as u32;
        if !self.node_id.is_sorted_by(|a, b| a < b) || !self.cell_id.is_sorted_by(|a, b| a < b) {
            return Err("ids of nodes or cells are not in ascending order".into());
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
                "link {at} joins nodes {:?} of {nodes}; allowed are two in ascending order",
                self.link_nodes[at]
            )),
            None => Ok(()),
        }
    }
}

/// Keeps the entries of a list whose flag in `kept` is set; a list that the host has not filled yet stays empty.
fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    list.retain(|_| kept.next().copied().unwrap_or(false));
}

/// A point in a cell of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocatedPoint {
    /// Id of the cell; [`abi::NO_CELL`] outside of all cells.
    pub cell: u64,
    /// Coordinates in the cell, 0 to 1 each.
    pub local: [f64; 3],
}

/// An active grid.
pub struct Grid {
    /// The plugin instance.
    instance: Instance,
    /// Function table of the grid.
    table: &'static abi::Grid,
    /// Whether the embedding is non-linear.
    nonlinear: bool,
    /// Parameters that it was opened with.
    settings: ParamSettings,
    /// Largest step that it was opened for, s.
    dt: f64,
}

#[allow(unsafe_code, reason = "calls the grid's functions")]
impl Grid {
    /// Opens the grid `name` of a library for steps of up to `dt` (s); nothing is built yet.
    ///
    /// # Errors
    /// Fails for a library without that grid, a malformed table and refused parameters.
    pub fn open(library: &'static Library, name: &str, settings: &ParamSettings, dt: f64) -> Result<Self, HostError> {
        let info = library.plugin(PluginKind::Grid, name)?;
        let instance = Instance::open(library, info, settings, dt, Extension::new::<abi::Grid>(abi::GRID))?;
        // SAFETY: opened with the grid extension.
        let table: &'static abi::Grid = unsafe { instance.table() };
        let is_complete = table.build.is_some()
            && table.level.is_some()
            && table.cell.is_some()
            && table.locate.is_some()
            && table.points.is_some()
            && table.region.is_some()
            && table.weights.is_some();
        if !is_complete {
            return Err(instance.error("extension", "the grid's table has a null in it"));
        }
        let mut grid = Self { instance, table, nonlinear: false, settings: settings.clone(), dt };
        grid.nonlinear = table.pull_back.is_some() && grid.place(1, &[], &[], &mut []).is_ok();
        Ok(grid)
    }

    /// Another grid of the same plugin with the same parameters; nothing is built yet.
    ///
    /// # Errors
    /// Those of [`Grid::open`].
    pub fn reopen(&self) -> Result<Self, HostError> {
        Self::open(self.library(), &self.info().id, &self.settings, self.dt)
    }

    /// Builds all levels up to `level` around a surface of points (m) and triangles. `[worker]`
    ///
    /// # Errors
    /// Returns the grid's error for an unsuitable surface or level.
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
    /// Fails for a level that was not built.
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
    /// Fails for a level that was not built and for an id without a cell.
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

    /// Finds the cell of a level that contains a point (m).
    ///
    /// # Errors
    /// Fails for a level that was not built and for a point that is not finite.
    pub fn locate(&self, level: u32, point: [f64; 3]) -> Result<LocatedPoint, HostError> {
        let (mut cell, mut local) = (0, [0.0; 3]);
        let get = self.table.locate.expect("checked");
        // SAFETY: [any & active]; the outputs are ours.
        let status = self.instance.within("locate", || unsafe {
            get(self.instance.plugin(), level, point.as_ptr(), &mut cell, local.as_mut_ptr())
        });
        self.instance.check("locate", status).map(|()| LocatedPoint { cell, local })
    }

    /// Indices of the surface's points, sorted by their cells of `level`.
    ///
    /// # Errors
    /// Fails for a level that was not built.
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
    /// Fails for a level that was not built and for a region with invalid entries.
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
                // Half as much again, so that a region that grows slowly does not need this in every step.
                let grown =
                    |needed: usize, capacity: usize| if needed > capacity { needed + needed / 2 } else { capacity };
                out.resize(
                    grown(raw.node_count, raw.node_capacity),
                    grown(raw.cell_count, raw.cell_capacity),
                    grown(raw.link_count, raw.link_capacity),
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

    /// Cell and trilinear weights of its corners for each rest position (m); [`abi::NO_CELL`] and zeros outside of all cells. `[sim]`
    ///
    /// # Errors
    /// Fails for a level that was not built and for weights that are not finite.
    pub fn weights(
        &self,
        level: u32,
        positions: &[[f64; 3]],
        cells: &mut [u64],
        weights: &mut [[f64; 8]],
    ) -> Result<(), HostError> {
        assert!(positions.len() == cells.len() && positions.len() == weights.len());
        let get = self.table.weights.expect("checked");
        let (from, to) = (positions.as_ptr().cast(), weights.as_mut_ptr().cast());
        // SAFETY: [sim & active]; the three lists have one length.
        let status = self.instance.within("weights", || unsafe {
            get(self.instance.plugin(), level, from, positions.len(), cells.as_mut_ptr(), to)
        });
        self.instance.check("weights", status)?;
        self.check_finite("weights", positions, |i| weights[i].iter().all(|w| w.is_finite()))
    }

    /// Whether the embedding is non-linear: [`Grid::place`] then replaces weights.
    pub fn is_nonlinear(&self) -> bool {
        self.nonlinear
    }

    /// Positions (m) of embedded points from their rest positions and the current corners of their cells. `[sim]`
    ///
    /// # Errors
    /// Fails if the grid does not offer it, and with the grid's error.
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

    /// Adds to `out`, the loads on the corners (N), those of `loads` on the embedded points (N): the transpose of the derivative of
    /// [`Grid::place`]. `[sim]`
    ///
    /// # Errors
    /// Fails if the grid does not offer it, and with the grid's error.
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

    /// Checks that the results of `call` for the rest positions are finite.
    fn check_finite(
        &self,
        call: &'static str,
        positions: &[[f64; 3]],
        is_finite: impl Fn(usize) -> bool,
    ) -> Result<(), HostError> {
        match (0..positions.len()).find(|&i| !is_finite(i)) {
            Some(i) => Err(self.instance.error(call, &format!("a result is not finite, for {:?} m", positions[i]))),
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
