//! Safe calls into a grid under test.
#![allow(unsafe_code, reason = "plays the host")]

use super::guarded::Guards;
use super::instance::TestInstance;
use crate::abi::{self, Ball, Level, Status};
use crate::fault::Fault;

/// An active grid and its table.
pub(super) struct TestGrid {
    instance: TestInstance,
    table: &'static abi::Grid,
    pub(super) guards: Guards,
}

/// A region of a grid: see [`abi::Region`] for each field.
#[derive(Clone, Debug, Default)]
pub(super) struct Region {
    pub(super) node_id: Vec<u64>,
    pub(super) node_rest: Vec<[f64; 3]>,
    pub(super) node_measure: Vec<f64>,
    pub(super) node_border: Vec<u8>,
    pub(super) cell_id: Vec<u64>,
    pub(super) cell_state: Vec<u8>,
    pub(super) cell_corners: Vec<[u32; 8]>,
    pub(super) link_nodes: Vec<[u32; 2]>,
}

// SAFETY of every call below: the thread class of the header on one thread, with buffers of the stated lengths.
impl TestGrid {
    /// Looks up the table.
    pub(super) fn new(instance: TestInstance) -> Result<Self, Fault> {
        let missing = || Fault::bad_argument("`pliant.grid/1` is not offered or has a null in it");
        let table: &'static abi::Grid = instance.extension(abi::GRID)?.ok_or_else(missing)?;
        let complete =
            table.build.is_some() && table.level.is_some() && table.region.is_some() && table.weights.is_some();
        if complete { Ok(Self { instance, table, guards: Guards::default() }) } else { Err(missing()) }
    }

    /// Builds the levels up to `level` around a surface.
    pub(super) fn build(&self, points: &[[f64; 3]], triangles: &[[u32; 3]], level: u32) -> Result<(), Fault> {
        let (points, triangles) = (self.guards.around("points", points), self.guards.around("triangles", triangles));
        let surface = abi::Surface {
            size: size_of::<abi::Surface>(),
            points: points.as_ptr().cast(),
            point_count: points.len(),
            triangles: triangles.as_ptr().cast(),
            triangle_count: triangles.len(),
        };
        let build = self.table.build.expect("checked");
        // SAFETY: see above.
        let status = unsafe { build(self.instance.raw(), &surface, level) };
        self.guards.look_at_input("build", "points", &points);
        self.guards.look_at_input("build", "triangles", &triangles);
        self.instance.check(status)
    }

    /// Describes a level.
    pub(super) fn level(&self, level: u32) -> Result<Level, Fault> {
        // SAFETY: a struct of numbers, to be filled.
        let mut out: Level = unsafe { core::mem::zeroed() };
        out.size = size_of::<Level>();
        let get = self.table.level.expect("checked");
        // SAFETY: see above.
        self.instance.check(unsafe { get(self.instance.raw(), level, &mut out) })?;
        Ok(out)
    }

    /// Nodes, cells and links of the cells that touch a ball, with buffers that grow until they fit.
    pub(super) fn region(&self, level: u32, ball: Ball) -> Result<Region, Fault> {
        let (mut nodes, mut cells, mut links) = (64, 64, 64);
        loop {
            let guards = &self.guards;
            let (mut node_id, mut cell_id) =
                (guards.around("node_id", &vec![0_u64; nodes]), guards.around("cell_id", &vec![0_u64; cells]));
            let mut node_rest = guards.around("node_rest", &vec![[0.0_f64; 3]; nodes]);
            let mut node_measure = guards.around("node_measure", &vec![0.0_f64; nodes]);
            let mut node_border = guards.around("node_border", &vec![0_u8; nodes]);
            let mut cell_state = guards.around("cell_state", &vec![0_u8; cells]);
            let mut cell_corners = guards.around("cell_corners", &vec![[0_u32; 8]; cells]);
            let mut cell_points = guards.around("cell_points", &vec![[0_u32; 2]; cells]);
            let mut link_nodes = guards.around("link_nodes", &vec![[0_u32; 2]; links]);
            let mut link_family = guards.around("link_family", &vec![0_u32; links]);
            let mut link_measure = guards.around("link_measure", &vec![0.0_f64; links]);
            let mut raw = abi::Region {
                size: size_of::<abi::Region>(),
                node_capacity: nodes,
                node_count: 0,
                node_id: node_id.as_mut_ptr(),
                node_rest: node_rest.as_mut_ptr().cast(),
                node_measure: node_measure.as_mut_ptr(),
                node_border: node_border.as_mut_ptr(),
                cell_capacity: cells,
                cell_count: 0,
                cell_id: cell_id.as_mut_ptr(),
                cell_corners: cell_corners.as_mut_ptr().cast(),
                cell_points: cell_points.as_mut_ptr().cast(),
                cell_state: cell_state.as_mut_ptr(),
                link_capacity: links,
                link_count: 0,
                link_nodes: link_nodes.as_mut_ptr().cast(),
                link_family: link_family.as_mut_ptr(),
                link_measure: link_measure.as_mut_ptr(),
            };
            let request = abi::RegionRequest {
                size: size_of::<abi::RegionRequest>(),
                level,
                families: abi::STRUCTURAL | abi::SHEAR,
                balls: &ball,
                ball_count: 1,
                cells: core::ptr::null(),
                cell_count: 0,
            };
            let region = self.table.region.expect("checked");
            // SAFETY: see above.
            let status = unsafe { region(self.instance.raw(), &request, &mut raw) };
            guards.look_at_output("region", "node_id", &node_id);
            guards.look_at_output("region", "node_rest", &node_rest);
            guards.look_at_output("region", "node_measure", &node_measure);
            guards.look_at_output("region", "node_border", &node_border);
            guards.look_at_output("region", "cell_id", &cell_id);
            guards.look_at_output("region", "cell_state", &cell_state);
            guards.look_at_output("region", "cell_corners", &cell_corners);
            guards.look_at_output("region", "cell_points", &cell_points);
            guards.look_at_output("region", "link_nodes", &link_nodes);
            guards.look_at_output("region", "link_family", &link_family);
            guards.look_at_output("region", "link_measure", &link_measure);
            let counts = (raw.node_count, raw.cell_count, raw.link_count);
            let fits = counts.0 <= nodes && counts.1 <= cells && counts.2 <= links;
            if status == Status::TOO_SMALL && !fits && counts.0.max(counts.1).max(counts.2) < 1 << 24 {
                (nodes, cells, links) = counts;
                continue;
            }
            self.instance.check(status)?;
            if !fits {
                return Err(Fault::bad_argument(
                    "`region` counted more than its buffers hold and did not return TOO_SMALL",
                ));
            }
            return Ok(Region {
                node_id: node_id.array()[..counts.0].to_vec(),
                node_rest: node_rest.array()[..counts.0].to_vec(),
                node_measure: node_measure.array()[..counts.0].to_vec(),
                node_border: node_border.array()[..counts.0].to_vec(),
                cell_id: cell_id.array()[..counts.1].to_vec(),
                cell_state: cell_state.array()[..counts.1].to_vec(),
                cell_corners: cell_corners.array()[..counts.1].to_vec(),
                link_nodes: link_nodes.array()[..counts.2].to_vec(),
            });
        }
    }

    /// Cell and interpolation weights of each rest position (m).
    pub(super) fn weights(&self, level: u32, positions: &[[f64; 3]]) -> Result<(Vec<u64>, Vec<[f64; 8]>), Fault> {
        let positions = self.guards.around("rest", positions);
        let mut cells = self.guards.around("cell", &vec![abi::NO_CELL; positions.len()]);
        let mut weights = self.guards.around("weights", &vec![[0.0_f64; 8]; positions.len()]);
        let get = self.table.weights.expect("checked");
        let (rest, count) = (positions.as_ptr().cast(), positions.len());
        // SAFETY: see above.
        let status =
            unsafe { get(self.instance.raw(), level, rest, count, cells.as_mut_ptr(), weights.as_mut_ptr().cast()) };
        self.guards.look_at_input("weights", "rest", &positions);
        self.guards.look_at_output("weights", "cell", &cells);
        self.guards.look_at_output("weights", "weights", &weights);
        self.instance.check(status).map(|()| (cells.array().to_vec(), weights.array().to_vec()))
    }

    /// Positions (m) by the grid's nonlinear embedding; `None` where it uses the weights.
    pub(super) fn place(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        corners: &[[[f64; 3]; 8]],
    ) -> Result<Option<Vec<[f64; 3]>>, Fault> {
        let Some(place) = self.table.place else { return Ok(None) };
        let (rest, corners) = (self.guards.around("rest", rest), self.guards.around("corners", corners));
        let mut out = self.guards.around("out", &vec![[0.0_f64; 3]; rest.len()]);
        let (points, count) = (rest.as_ptr().cast(), rest.len());
        // SAFETY: see above.
        let status = unsafe {
            place(self.instance.raw(), level, points, count, corners.as_ptr().cast(), out.as_mut_ptr().cast())
        };
        self.guards.look_at_input("place", "rest", &rest);
        self.guards.look_at_input("place", "corners", &corners);
        self.guards.look_at_output("place", "out", &out);
        match status {
            Status::UNSUPPORTED => Ok(None),
            status => self.instance.check(status).map(|()| Some(out.array().to_vec())),
        }
    }

    /// Loads on the corners (N) from loads on embedded points (N).
    pub(super) fn pull_back(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        corners: &[[[f64; 3]; 8]],
        loads: &[[f64; 3]],
    ) -> Result<Vec<[[f64; 3]; 8]>, Fault> {
        let (rest, corners) = (self.guards.around("rest", rest), self.guards.around("corners", corners));
        let (loads, mut out) =
            (self.guards.around("loads", loads), self.guards.around("out", &vec![[[0.0_f64; 3]; 8]; rest.len()]));
        let Some(pull_back) = self.table.pull_back else {
            return Err(Fault::bad_argument("`place` without `pull_back`"));
        };
        let (points, count, at) = (rest.as_ptr().cast(), rest.len(), corners.as_ptr().cast());
        let (of, to) = (loads.as_ptr().cast(), out.as_mut_ptr().cast());
        // SAFETY: see above.
        let status = unsafe { pull_back(self.instance.raw(), level, points, count, at, of, to) };
        self.guards.look_at_input("pull_back", "rest", &rest);
        self.guards.look_at_input("pull_back", "corners", &corners);
        self.guards.look_at_input("pull_back", "loads", &loads);
        self.guards.look_at_output("pull_back", "out", &out);
        self.instance.check(status).map(|()| out.array().to_vec())
    }
}
