//! What every grid promises, around a ball of triangles.

use super::super::candidate::Candidate;
use super::super::opened_grid::{OpenedGrid, Region};
use super::material::random;
use super::{Case, Verdict, judge, told};
use crate::abi::{Ball, CELL_SURFACE, NO_CELL};
use std::collections::BTreeMap;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "weights-sum-to-one",
        promise: "every surface point has a cell, and weights that sum to 1",
        run: partition,
    },
    Case {
        name: "affine-motion-is-exact",
        promise: "a point follows a stretched and turned cell exactly",
        run: affine,
    },
    Case {
        name: "pull-back-is-the-transpose",
        promise: "loads on points do the work of the loads on corners",
        run: transpose,
    },
    Case { name: "cells-are-cubes", promise: "a cell's corners are where the level says, and ids rise", run: cubes },
    Case {
        name: "region-is-part-of-the-body",
        promise: "a region around a place is a part of the whole, unchanged",
        run: region,
    },
    Case { name: "surface-can-be-touched", promise: "cells that the surface passes through say so", run: surface },
];

const LEVEL: u32 = 4;
const RADIUS: f64 = 0.05;
const WHOLE: Ball = Ball { centre: [0.0; 3], radius: f64::INFINITY };

/// A ball of 512 triangles (m), away from the origin.
fn ball() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut points: Vec<[f64; 3]> = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut p = [0.0; 3];
            p[axis] = sign;
            points.push(p);
        }
    }
    let mut triangles =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5_u32]];
    for _ in 0..3 {
        let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let (p, q) = (points[i as usize], points[j as usize]);
                    let sum = [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
                    let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
                    points.push(sum.map(|c| c / length));
                    points.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (points.iter().map(|p| [RADIUS * p[0] + 0.2, RADIUS * p[1] - 0.1, RADIUS * p[2] + 0.03]).collect(), triangles)
}

/// A grid around the ball, its whole region, and its surface points with cells and weights.
struct Built {
    grid: OpenedGrid,
    whole: Region,
    points: Vec<[f64; 3]>,
    cells: Vec<u64>,
    weights: Vec<[f64; 8]>,
}

impl Built {
    fn new(c: &Candidate) -> Result<Self, String> {
        let grid = OpenedGrid::new(c.open(&[]).map_err(told)?).map_err(told)?;
        let (points, triangles) = ball();
        grid.build(&points, &triangles, LEVEL).map_err(|fault| format!("a ball at level {LEVEL}: {}", told(fault)))?;
        let whole = grid.region(LEVEL, WHOLE).map_err(told)?;
        let nodes = whole.node_id.len() as u32;
        let sound = whole.cell_corners.iter().flatten().all(|n| *n < nodes)
            && whole.link_nodes.iter().all(|[a, b]| a < b && *b < nodes);
        judge(sound && !whole.cell_id.is_empty(), || "the whole region has corners or links there are not".into())?;
        let (cells, weights) = grid.weights(LEVEL, &points).map_err(told)?;
        Ok(Self { grid, whole, points, cells, weights })
    }

    /// Rest corners of the cell of point `i`, m.
    fn corners(&self, i: usize) -> Result<[[f64; 3]; 8], String> {
        let at = self.whole.cell_id.iter().position(|id| *id == self.cells[i]);
        let at = at.ok_or_else(|| format!("point {i} is in a cell that is not part of the body"))?;
        Ok(self.whole.cell_corners[at].map(|n| self.whole.node_rest[n as usize]))
    }
}

fn partition(c: &Candidate) -> Result<Verdict, String> {
    let built = Built::new(c)?;
    for (i, (cell, weights)) in built.cells.iter().zip(&built.weights).enumerate() {
        judge(*cell != NO_CELL, || format!("point {i} of the surface has no cell"))?;
        let sum: f64 = weights.iter().sum();
        judge((sum - 1.0).abs() <= 1e-9, || format!("the weights of point {i} sum to {sum}"))?;
    }
    Ok(Verdict::Passed)
}

fn affine(c: &Candidate) -> Result<Verdict, String> {
    let built = Built::new(c)?;
    let map =
        |p: [f64; 3]| [1.2 * p[0] - 0.7 * p[1] + 0.1, 0.8 * p[0] + 0.9 * p[1] - 0.2 * p[2], 0.3 * p[1] + 1.1 * p[2]];
    for i in 0..built.points.len() {
        let (corners, w) = (built.corners(i)?.map(map), built.weights[i]);
        let sum: f64 = w.iter().sum();
        let (wanted, mut off) = (map(built.points[i]), 0.0_f64);
        for axis in 0..3 {
            let found: f64 = (0..8).map(|k| w[k] / sum * corners[k][axis]).sum();
            off = off.max((found - wanted[axis]).abs());
        }
        judge(off <= 1e-9 * RADIUS, || format!("point {i} is {off:.3e} m from where it belongs"))?;
    }
    Ok(Verdict::Passed)
}

fn transpose(c: &Candidate) -> Result<Verdict, String> {
    let built = Built::new(c)?;
    let (mut next, step) = (random(), 1e-6 * RADIUS);
    let rest = &built.points[..32];
    let corners: Vec<[[f64; 3]; 8]> = (0..rest.len()).map(|i| built.corners(i)).collect::<Result<_, _>>()?;
    let moved = |by: &[[[f64; 3]; 8]], size: f64| -> Vec<[[f64; 3]; 8]> {
        let move_one = |(c, b): (&[[f64; 3]; 8], &[[f64; 3]; 8])| {
            std::array::from_fn(|k| [0, 1, 2].map(|i| c[k][i] + size * b[k][i]))
        };
        corners.iter().zip(by).map(move_one).collect()
    };
    let by: Vec<[[f64; 3]; 8]> = corners.iter().map(|c| c.map(|p| p.map(|_| next()))).collect();
    let loads: Vec<[f64; 3]> = rest.iter().map(|p| p.map(|_| next())).collect();
    let place = |size: f64| built.grid.place(LEVEL, rest, &moved(&by, size)).map_err(told);
    let (Some(plus), Some(minus)) = (place(step)?, place(-step)?) else {
        return Ok(Verdict::Skipped("its embedding is linear: the weights are used both ways".into()));
    };
    let pulled = built.grid.pull_back(LEVEL, rest, &corners, &loads).map_err(told)?;
    let work = |i: usize| (0..3).map(|a| loads[i][a] * (plus[i][a] - minus[i][a]) / (2.0 * step)).sum::<f64>();
    for i in 0..rest.len() {
        let theirs: f64 = pulled[i].iter().flatten().zip(by[i].iter().flatten()).map(|(f, d)| f * d).sum();
        judge((work(i) - theirs).abs() <= 1e-5, || format!("point {i}: work {:.6e} and {theirs:.6e}", work(i)))?;
    }
    Ok(Verdict::Passed)
}

fn cubes(c: &Candidate) -> Result<Verdict, String> {
    let built = Built::new(c)?;
    let level = built.grid.level(LEVEL).map_err(told)?;
    let w = &built.whole;
    let rises = |ids: &[u64]| ids.windows(2).all(|p| p[0] < p[1]);
    judge(rises(&w.node_id) && rises(&w.cell_id), || "ids of nodes or cells do not rise".into())?;
    let count = (level.surface_cells + level.inside_cells) as usize;
    judge(count == w.cell_id.len(), || format!("the level has {count} cells, its region {}", w.cell_id.len()))?;
    for (cell, corners) in w.cell_corners.iter().enumerate() {
        let least = w.node_rest[corners[0] as usize];
        for (k, n) in corners.iter().enumerate() {
            let wanted = [0, 1, 2].map(|i| least[i] + level.edge * (k >> i & 1) as f64);
            let off = (0..3).map(|i| (w.node_rest[*n as usize][i] - wanted[i]).abs()).fold(0.0, f64::max);
            judge(off <= 1e-9 * level.edge, || format!("corner {k} of cell {cell} is {off:.3e} m off"))?;
        }
    }
    let (volume, sum) = (count as f64 * level.edge.powi(3), w.node_measure.iter().sum::<f64>());
    judge((sum / volume - 1.0).abs() < 1e-6, || format!("nodes share {sum:.6e} m^3 of {volume:.6e} m^3"))?;
    judge(w.node_border.iter().all(|b| *b == 0), || "the whole body has a border to itself".into())?;
    Ok(Verdict::Passed)
}

fn surface(c: &Candidate) -> Result<Verdict, String> {
    let built = Built::new(c)?;
    let (points, triangles) = ball();
    let middle = |t: &[u32; 3]| [0, 1, 2].map(|i| t.iter().map(|v| points[*v as usize][i]).sum::<f64>() / 3.0);
    let middles: Vec<[f64; 3]> = triangles.iter().map(middle).collect();
    let (cells, _) = built.grid.weights(LEVEL, &middles).map_err(told)?;
    for (triangle, id) in cells.iter().enumerate().filter(|(_, id)| **id != NO_CELL) {
        let at = built.whole.cell_id.iter().position(|c| c == id);
        let state = at.map(|at| u32::from(built.whole.cell_state[at]));
        judge(state == Some(CELL_SURFACE), || format!("the cell under triangle {triangle} is no surface cell"))?;
    }
    Ok(Verdict::Passed)
}

fn region(c: &Candidate) -> Result<Verdict, String> {
    let built = Built::new(c)?;
    let level = built.grid.level(LEVEL).map_err(told)?;
    let centre = built.points[0];
    let part = built.grid.region(LEVEL, Ball { centre, radius: 1.5 * level.edge }).map_err(told)?;
    let whole: BTreeMap<u64, [f64; 3]> =
        built.whole.node_id.iter().copied().zip(built.whole.node_rest.iter().copied()).collect();
    judge(!part.cell_id.is_empty(), || "nothing around a point of the surface".into())?;
    for (id, rest) in part.node_id.iter().zip(&part.node_rest) {
        judge(whole.get(id) == Some(rest), || format!("node {id} at {rest:?} m is not one of the whole body"))?;
    }
    if let Some(id) = part.cell_id.iter().find(|id| !built.whole.cell_id.contains(id)) {
        return Err(format!("cell {id} is not one of the whole body"));
    }
    judge(part.cell_id.contains(&built.cells[0]), || "the cell of the place itself is missing".into())?;
    // A node is on the border if one of its cells was left out, and only then.
    let around = |r: &Region| {
        let mut count: BTreeMap<u64, u32> = BTreeMap::new();
        r.cell_corners.iter().flatten().for_each(|n| *count.entry(r.node_id[*n as usize]).or_default() += 1);
        count
    };
    let (all, here) = (around(&built.whole), around(&part));
    for (id, border) in part.node_id.iter().zip(&part.node_border) {
        let cut = here.get(id) != all.get(id);
        judge((*border != 0) == cut, || format!("node {id}: border is {border}, and cells left out: {cut}"))?;
    }
    Ok(Verdict::Passed)
}
