//! The part of a body around a contact: its nodes, cells and links.
//!
//! It is made anew whenever the hand moves on, so its work goes with the region and not with the body: everything
//! happens in a window, the box of cells that can be meant and one layer around it, by direct index. Two balls far
//! apart share one window, at six bytes for each node between them.

use crate::cells::Cells;
use crate::links::{ALL_FAMILIES, links};
use crate::states::EMPTY;
use crate::tree::Tree;
use crate::vector::Vector;
use pliant_plugin_api::{Fault, RegionRequest, RegionSink};

/// Set in [`Nodes::around`] where an occupied cell outside of the region touches the node.
pub(crate) const BORDER: u16 = 1 << 8;

/// The nodes of a window.
pub(crate) struct Nodes {
    /// Per node of the window, bit q: its cell towards (q & 1, q >> 1 & 1, q >> 2) is in the region. And [`BORDER`].
    pub(crate) around: Vec<u16>,
    /// Per node of the window, its place among those of the region.
    pub(crate) place: Vec<u32>,
    /// The nodes of the region, rising.
    pub(crate) list: Vec<u32>,
    /// Of the window, x first.
    pub(crate) strides: [usize; 3],
}

pub(crate) fn region(
    tree: &Tree,
    cells: &Cells,
    request: &RegionRequest<'_>,
    out: &mut RegionSink<'_>,
) -> Result<(), Fault> {
    let wanted = Wanted::new(cells, request)?;
    let Some([low, high]) = wanted.bounds else { return Ok(()) };
    let size = [0, 1, 2].map(|axis| (high[axis] - low[axis]) as usize + 4);
    let (strides, len) = ([1, size[0], size[0] * size[1]], size.iter().product());
    let mut nodes = Nodes { around: vec![0; len], place: vec![0; len], list: Vec::new(), strides };
    let at = |index: [u32; 3]| (0..3).map(|axis| strides[axis] * (index[axis] + 1 - low[axis]) as usize).sum::<usize>();
    let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|c: usize| (c & 1) + strides[1] * (c >> 1 & 1) + strides[2] * (c >> 2));

    let lattice = &cells.lattice;
    let reach = |axis: usize| low[axis].saturating_sub(1)..(high[axis] + 2).min(lattice.cells);
    let mut kept = Vec::new();
    let mut listed = wanted.listed.iter().peekable();
    for (j, k) in reach(2).flat_map(|k| reach(1).map(move |j| (j, k))) {
        for (i, state) in cells.row(j, k, reach(0)) {
            let (index, id) = ([i, j, k], lattice.id([i, j, k]));
            let named = listed.next_if(|&&l| l == id).is_some();
            let inside = named || wanted.balls.iter().any(|ball| ball.touches(index));
            let node = at(index);
            for (c, corner) in corners.iter().enumerate() {
                nodes.around[node + corner] |= if inside { 1 << (7 - c) } else { BORDER };
            }
            if inside {
                kept.push((index, node, state));
            }
        }
    }

    let share = lattice.edge.powi(3) / 8.0;
    for (j, k) in (low[2]..high[2] + 2).flat_map(|k| (low[1]..high[1] + 2).map(move |j| (j, k))) {
        for i in low[0]..high[0] + 2 {
            let node = at([i, j, k]);
            let around = nodes.around[node];
            let count = (around & !BORDER).count_ones();
            if count > 0 {
                nodes.place[node] = nodes.list.len() as u32;
                nodes.list.push(node as u32);
                let (id, rest) = (lattice.node_id([i, j, k]), lattice.corner([i, j, k]));
                out.node(id, rest, f64::from(count) * share, around & BORDER != 0);
            }
        }
    }
    for (index, node, state) in kept {
        let points = tree.points.range(lattice.level, index);
        let corners = corners.map(|corner| nodes.place[node + corner]);
        out.cell(lattice.id(index), corners, [points.start as u32, points.end as u32], u32::from(state));
    }
    links(&nodes, request.families, out);
    Ok(())
}

/// What a request means on a level.
struct Wanted {
    balls: Vec<Ball>,
    /// Ids of occupied cells, rising.
    listed: Vec<u64>,
    /// Least and greatest index of what can be in the region.
    bounds: Option<[[u32; 3]; 2]>,
}

impl Wanted {
    fn new(cells: &Cells, request: &RegionRequest<'_>) -> Result<Self, Fault> {
        let lattice = &cells.lattice;
        if request.families & !ALL_FAMILIES != 0 {
            let families = request.families;
            return Err(Fault::bad_argument(format!(
                "families of links {families:#x}: allowed are bits of {ALL_FAMILIES:#x}"
            )));
        }
        if let Some(at) =
            request.balls.iter().position(|b| !(b.radius >= 0.0 && b.centre.iter().all(|x| x.is_finite())))
        {
            let (ball, allowed) = (&request.balls[at], "a finite centre and a radius of 0 or more are allowed");
            return Err(Fault::bad_argument(format!("ball {at} is {ball:?}: {allowed}")));
        }
        let balls = request.balls.iter();
        let balls: Vec<_> =
            balls.map(|b| Ball { centre: lattice.in_cells(b.centre), radius: b.radius / lattice.edge }).collect();
        let occupied = |&id: &u64| id < lattice.count() && cells.state(lattice.index(id)) != EMPTY;
        let mut listed: Vec<u64> = request.cells.iter().copied().filter(occupied).collect();
        listed.sort_unstable();
        listed.dedup();

        let single = listed.iter().map(|&id| [lattice.index(id); 2]);
        let bounds = balls.iter().map(|ball| ball.bounds(cells)).chain(single).reduce(|a, b| {
            let axes = [0, 1, 2];
            [axes.map(|axis| a[0][axis].min(b[0][axis])), axes.map(|axis| a[1][axis].max(b[1][axis]))]
        });
        Ok(Self { balls, listed, bounds })
    }
}

/// Counted in cells.
struct Ball {
    centre: Vector,
    radius: f64,
}

impl Ball {
    fn touches(&self, index: [u32; 3]) -> bool {
        let gap = |axis: usize| {
            let (low, centre) = (f64::from(index[axis]), self.centre[axis]);
            (low - centre).max(centre - low - 1.0).max(0.0)
        };
        gap(0).powi(2) + gap(1).powi(2) + gap(2).powi(2) <= self.radius.powi(2)
    }

    /// A box of cells that holds all that it touches, among the occupied ones.
    fn bounds(&self, cells: &Cells) -> [[u32; 3]; 2] {
        let within = |axis: usize, x: f64| (x as u32).clamp(cells.bounds[0][axis], cells.bounds[1][axis]);
        let (centre, radius) = (self.centre, self.radius);
        let bound = |beyond: f64| [0, 1, 2].map(|axis| within(axis, centre[axis] + beyond));
        [bound(-radius - 1.0), bound(radius)]
    }
}
