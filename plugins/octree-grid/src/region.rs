//! The region of a body around a contact: its nodes, cells and links.
//!
//! A region is rebuilt whenever the hand moves on, so the work must depend on the region and not on the body. Everything happens in a window
//! by direct index: the bounding box of the requested cells and one layer around it. Two balls far apart share one window, which costs
//! six bytes for each node between them.

use crate::cells::Cells;
use crate::links::{ALL_FAMILIES, list_links};
use crate::states::EMPTY;
use crate::tree::Tree;
use pliant_plugin_api::{Fault, RegionRequest, RegionSink};

/// Bit of [`Nodes::around`]: an occupied cell outside the region has the node as a corner.
pub(crate) const BORDER: u16 = 1 << 8;

/// The nodes of a window.
pub(crate) struct Nodes {
    /// For each node of the window, bit q is set if its cell towards (q & 1, q >> 1 & 1, q >> 2) is in the region; and [`BORDER`].
    pub(crate) around: Vec<u16>,
    /// For each node of the window, its index among those of the region.
    pub(crate) index: Vec<u32>,
    /// The nodes of the region, as indices into the window, ascending.
    pub(crate) list: Vec<u32>,
    /// Distance in the window of neighbours along x, y, z.
    pub(crate) strides: [usize; 3],
}

/// Lists the nodes, cells and links of the region a request names.
///
/// # Errors
/// Unknown families of links, or a ball that is not finite.
pub(crate) fn list_region(
    tree: &Tree,
    cells: &Cells,
    request: &RegionRequest<'_>,
    out: &mut RegionSink<'_>,
) -> Result<(), Fault> {
    let selection = Selection::new(cells, request)?;
    let Some([low, high]) = selection.bounds else { return Ok(()) };
    let size = [0, 1, 2].map(|axis| (high[axis] - low[axis]) as usize + 4);
    let (strides, len) = ([1, size[0], size[0] * size[1]], size.iter().product());
    let mut nodes = Nodes { around: vec![0; len], index: vec![0; len], list: Vec::new(), strides };
    let in_window =
        |index: [u32; 3]| (0..3).map(|axis| strides[axis] * (index[axis] + 1 - low[axis]) as usize).sum::<usize>();
    let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|c: usize| (c & 1) + strides[1] * (c >> 1 & 1) + strides[2] * (c >> 2));

    let lattice = &cells.lattice;
    let reach = |axis: usize| low[axis].saturating_sub(1)..(high[axis] + 2).min(lattice.cells);
    let mut selected = Vec::new();
    let mut listed = selection.listed.iter().peekable();
    for (j, k) in reach(2).flat_map(|k| reach(1).map(move |j| (j, k))) {
        for (i, state) in cells.row(j, k, reach(0)) {
            let (index, id) = ([i, j, k], lattice.id([i, j, k]));
            let is_listed = listed.next_if(|&&l| l == id).is_some();
            let is_selected = is_listed || selection.balls.iter().any(|ball| ball.touches(index));
            let node = in_window(index);
            for (c, corner) in corners.iter().enumerate() {
                nodes.around[node + corner] |= if is_selected { 1 << (7 - c) } else { BORDER };
            }
            if is_selected {
                selected.push((index, node, state));
            }
        }
    }

    let share = lattice.edge.powi(3) / 8.0;
    for (j, k) in (low[2]..high[2] + 2).flat_map(|k| (low[1]..high[1] + 2).map(move |j| (j, k))) {
        for i in low[0]..high[0] + 2 {
            let node = in_window([i, j, k]);
            let around = nodes.around[node];
            let count = (around & !BORDER).count_ones();
            if count > 0 {
                nodes.index[node] = nodes.list.len() as u32;
                nodes.list.push(node as u32);
                let (id, rest) = (lattice.node_id([i, j, k]), lattice.corner([i, j, k]));
                out.node(id, rest, f64::from(count) * share, around & BORDER != 0);
            }
        }
    }
    for (index, node, state) in selected {
        let points = tree.points.range(lattice.level, index);
        let corners = corners.map(|corner| nodes.index[node + corner]);
        out.cell(lattice.id(index), corners, [points.start as u32, points.end as u32], u32::from(state));
    }
    list_links(&nodes, request.families, out);
    Ok(())
}

/// The cells a request selects on a level.
struct Selection {
    balls: Vec<Ball>,
    /// Ids of the occupied cells the request lists, ascending.
    listed: Vec<u64>,
    /// Bounding box of the cells: least and greatest index along each axis. `None` for an empty request.
    bounds: Option<[[u32; 3]; 2]>,
}

impl Selection {
    fn new(cells: &Cells, request: &RegionRequest<'_>) -> Result<Self, Fault> {
        let lattice = &cells.lattice;
        if request.families & !ALL_FAMILIES != 0 {
            let families = request.families;
            return Err(Fault::bad_argument(format!(
                "families of links {families:#x}: allowed are bits of {ALL_FAMILIES:#x}"
            )));
        }
        if let Some(number) =
            request.balls.iter().position(|b| !(b.radius >= 0.0 && b.centre.iter().all(|x| x.is_finite())))
        {
            let (ball, allowed) = (&request.balls[number], "allowed are a finite centre and a radius of 0 or more");
            return Err(Fault::bad_argument(format!("ball {number} is {ball:?}: {allowed}")));
        }
        let balls = request.balls.iter();
        let balls: Vec<_> =
            balls.map(|b| Ball { centre: lattice.in_cells(b.centre), radius: b.radius / lattice.edge }).collect();
        let occupied = |&id: &u64| id < lattice.count() && cells.state(lattice.index(id)) != EMPTY;
        let mut listed: Vec<u64> = request.cells.iter().copied().filter(occupied).collect();
        listed.sort_unstable();
        listed.dedup();

        let boxes = listed.iter().map(|&id| [lattice.index(id); 2]);
        let bounds = balls.iter().map(|ball| ball.bounds(cells)).chain(boxes).reduce(|a, b| {
            let axes = [0, 1, 2];
            [axes.map(|axis| a[0][axis].min(b[0][axis])), axes.map(|axis| a[1][axis].max(b[1][axis]))]
        });
        Ok(Self { balls, listed, bounds })
    }
}

/// A ball in units of cells.
struct Ball {
    centre: [f64; 3],
    radius: f64,
}

impl Ball {
    /// Whether it touches the closed cube of a cell.
    fn touches(&self, index: [u32; 3]) -> bool {
        let gap = |axis: usize| {
            let (low, centre) = (f64::from(index[axis]), self.centre[axis]);
            (low - centre).max(centre - low - 1.0).max(0.0)
        };
        gap(0).powi(2) + gap(1).powi(2) + gap(2).powi(2) <= self.radius.powi(2)
    }

    /// A box that contains all occupied cells the ball touches: least and greatest index.
    fn bounds(&self, cells: &Cells) -> [[u32; 3]; 2] {
        let within = |axis: usize, x: f64| (x as u32).clamp(cells.bounds[0][axis], cells.bounds[1][axis]);
        let (centre, radius) = (self.centre, self.radius);
        let bound = |offset: f64| [0, 1, 2].map(|axis| within(axis, centre[axis] + offset));
        [bound(-radius - 1.0), bound(radius)]
    }
}
