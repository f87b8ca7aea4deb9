//! Cases for every grid, around a triangulated ball.

use super::super::candidate::Candidate;
use super::super::grid::{Region, TestGrid};
use super::super::random::Random;
use super::{Case, CaseResult, describe_fault, ensure, skipped};
use crate::abi::{Ball, CELL_SURFACE, NO_CELL};
use std::collections::BTreeMap;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "weights-sum-to-one",
        promise: "every surface point has a cell, and weights that sum to 1",
        run: weights_sum_to_one,
    },
    Case {
        name: "affine-motion-is-exact",
        promise: "a surface point follows an affine motion of its cell exactly",
        run: affine_motion_is_exact,
    },
    Case {
        name: "pull-back-is-the-transpose",
        promise: "loads pulled back to the corners do the same work as the loads on the points",
        run: pull_back_is_the_transpose,
    },
    Case {
        name: "cells-are-cubes",
        promise: "corners lie where the level says, ids ascend, and the nodes share the volume",
        run: cells_are_cubes,
    },
    Case {
        name: "region-is-part-of-the-body",
        promise: "the nodes and cells of a region are those of the whole body",
        run: region_is_part_of_the_body,
    },
    Case {
        name: "surface-cells-are-marked",
        promise: "cells that the surface passes through have the state PLIANT_CELL_SURFACE",
        run: surface_cells_are_marked,
    },
    Case {
        name: "arrays-are-kept-to",
        promise: "calls read nothing around their arrays, and write nothing into inputs or around outputs",
        run: arrays_are_kept_to,
    },
];

/// The finest level built.
const LEVEL: u32 = 4;
/// Radius of the ball, m.
const RADIUS: f64 = 0.05;
/// Selects the whole body.
const WHOLE: Ball = Ball { centre: [0.0; 3], radius: f64::INFINITY };

/// Vertices (m) and triangles of a ball away from the origin: an octahedron subdivided three times, 512 triangles.
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

/// A grid around the ball, the region of the whole body, and the surface points with their cells and weights.
struct Built {
    grid: TestGrid,
    whole: Region,
    points: Vec<[f64; 3]>,
    cells: Vec<u64>,
    weights: Vec<[f64; 8]>,
}

impl Built {
    fn new(c: &Candidate) -> Result<Self, String> {
        let grid = TestGrid::new(c.open(&[]).map_err(describe_fault)?).map_err(describe_fault)?;
        let (points, triangles) = ball();
        grid.build(&points, &triangles, LEVEL)
            .map_err(|fault| format!("a ball at level {LEVEL}: {}", describe_fault(fault)))?;
        let whole = grid.region(LEVEL, WHOLE).map_err(describe_fault)?;
        let nodes = whole.node_id.len() as u32;
        let valid = whole.cell_corners.iter().flatten().all(|n| *n < nodes)
            && whole.link_nodes.iter().all(|[a, b]| a < b && *b < nodes);
        ensure(valid && !whole.cell_id.is_empty(), || {
            "a corner or link of the whole body is not one of its nodes".into()
        })?;
        let (cells, weights) = grid.weights(LEVEL, &points).map_err(describe_fault)?;
        Ok(Self { grid, whole, points, cells, weights })
    }

    /// Rest positions of the corners of the cell of point `i`, m.
    fn corners(&self, i: usize) -> Result<[[f64; 3]; 8], String> {
        let cell = self.whole.cell_id.iter().position(|id| *id == self.cells[i]);
        let cell = cell.ok_or_else(|| format!("the cell of point {i} is not part of the body"))?;
        Ok(self.whole.cell_corners[cell].map(|n| self.whole.node_rest[n as usize]))
    }
}

/// Bits of a region, of weights, and of positions and loads of the grid's own embedding.
fn result_bits(grid: &TestGrid) -> Result<Vec<u64>, String> {
    let (points, triangles) = ball();
    grid.build(&points, &triangles, LEVEL).map_err(describe_fault)?;
    let region = grid.region(LEVEL, WHOLE).map_err(describe_fault)?;
    let (cells, weights) = grid.weights(LEVEL, &points).map_err(describe_fault)?;
    let corners = vec![[[0.01, 0.02, 0.03]; 8]; points.len()];
    let place = grid.place(LEVEL, &points, &corners).map_err(describe_fault)?;
    let floats = region.node_rest.iter().flatten().chain(&region.node_measure).chain(weights.iter().flatten());
    let mut bits: Vec<u64> =
        floats.map(|v| v.to_bits()).chain(cells).chain(region.cell_id).chain(region.node_id).collect();
    bits.extend(region.cell_corners.iter().flatten().chain(region.link_nodes.iter().flatten()).map(|n| u64::from(*n)));
    if let Some(place) = place {
        let loads = grid.pull_back(LEVEL, &points, &corners, &points).map_err(describe_fault)?;
        bits.extend(place.iter().flatten().chain(loads.iter().flatten().flatten()).map(|v| v.to_bits()));
    }
    Ok(bits)
}

/// The case of this name, with another grid for each array whose guards change.
fn arrays_are_kept_to(c: &Candidate) -> CaseResult {
    let open = || TestGrid::new(c.open(&[]).map_err(describe_fault)?).map_err(describe_fault);
    let grid = open()?;
    let plain = result_bits(&grid)?;
    if let Some(write) = grid.guards.first_write() {
        return Err(write.into());
    }
    if result_bits(&open()?)? != plain {
        return Err(skipped("results differ from instance to instance"));
    }
    // Numbers around triangles are vertices of the ball.
    for (array, number) in
        [("points", f64::NAN), ("triangles", 1.0), ("rest", f64::NAN), ("corners", f64::NAN), ("loads", f64::NAN)]
    {
        let mut grid = open()?;
        grid.guards.change(array, number);
        ensure(result_bits(&grid)? == plain, || format!("results depend on what lies around `{array}`"))?;
    }
    Ok(())
}

fn weights_sum_to_one(c: &Candidate) -> CaseResult {
    let built = Built::new(c)?;
    for (i, (cell, weights)) in built.cells.iter().zip(&built.weights).enumerate() {
        ensure(*cell != NO_CELL, || format!("point {i} of the surface has no cell"))?;
        let sum: f64 = weights.iter().sum();
        ensure((sum - 1.0).abs() <= 1e-9, || format!("the weights of point {i} sum to {sum}"))?;
    }
    Ok(())
}

fn affine_motion_is_exact(c: &Candidate) -> CaseResult {
    let built = Built::new(c)?;
    let map =
        |p: [f64; 3]| [1.2 * p[0] - 0.7 * p[1] + 0.1, 0.8 * p[0] + 0.9 * p[1] - 0.2 * p[2], 0.3 * p[1] + 1.1 * p[2]];
    for i in 0..built.points.len() {
        let (corners, w) = (built.corners(i)?.map(map), built.weights[i]);
        let sum: f64 = w.iter().sum();
        let (expected, mut error) = (map(built.points[i]), 0.0_f64);
        for axis in 0..3 {
            let found: f64 = (0..8).map(|k| w[k] / sum * corners[k][axis]).sum();
            error = error.max((found - expected[axis]).abs());
        }
        ensure(error <= 1e-9 * RADIUS, || format!("point {i} is off by {error:.3e} m"))?;
    }
    Ok(())
}

fn pull_back_is_the_transpose(c: &Candidate) -> CaseResult {
    let built = Built::new(c)?;
    let (mut random, step) = (Random(1), 1e-6 * RADIUS);
    let rest = &built.points[..32];
    let corners: Vec<[[f64; 3]; 8]> = (0..rest.len()).map(|i| built.corners(i)).collect::<Result<_, _>>()?;
    let direction: Vec<[[f64; 3]; 8]> = corners.iter().map(|c| c.map(|p| p.map(|_| random.signed()))).collect();
    let loads: Vec<[f64; 3]> = rest.iter().map(|p| p.map(|_| random.signed())).collect();
    let positions_at = |step: f64| {
        let move_cell = |(cell, direction): (&[[f64; 3]; 8], &[[f64; 3]; 8])| {
            std::array::from_fn(|k| [0, 1, 2].map(|i| cell[k][i] + step * direction[k][i]))
        };
        let moved: Vec<[[f64; 3]; 8]> = corners.iter().zip(&direction).map(move_cell).collect();
        built.grid.place(LEVEL, rest, &moved).map_err(describe_fault)
    };
    let (Some(plus), Some(minus)) = (positions_at(step)?, positions_at(-step)?) else {
        return Err(skipped("its embedding is linear: the host uses the weights for positions and loads"));
    };
    let corner_loads = built.grid.pull_back(LEVEL, rest, &corners, &loads).map_err(describe_fault)?;
    for i in 0..rest.len() {
        let on_points: f64 = (0..3).map(|a| loads[i][a] * (plus[i][a] - minus[i][a]) / (2.0 * step)).sum();
        let terms = corner_loads[i].iter().flatten().zip(direction[i].iter().flatten());
        let on_corners: f64 = terms.map(|(f, d)| f * d).sum();
        ensure((on_points - on_corners).abs() <= 1e-5, || {
            format!("point {i}: the loads do a work of {on_points:.6e} on the point, {on_corners:.6e} on the corners")
        })?;
    }
    Ok(())
}

fn cells_are_cubes(c: &Candidate) -> CaseResult {
    let built = Built::new(c)?;
    let level = built.grid.level(LEVEL).map_err(describe_fault)?;
    let w = &built.whole;
    let ascends = |ids: &[u64]| ids.windows(2).all(|p| p[0] < p[1]);
    ensure(ascends(&w.node_id) && ascends(&w.cell_id), || "ids of nodes or cells do not ascend".into())?;
    let count = (level.surface_cells + level.inside_cells) as usize;
    ensure(count == w.cell_id.len(), || format!("the level has {count} cells, the whole region {}", w.cell_id.len()))?;
    for (cell, corners) in w.cell_corners.iter().enumerate() {
        let least = w.node_rest[corners[0] as usize];
        for (k, n) in corners.iter().enumerate() {
            let expected = [0, 1, 2].map(|i| least[i] + level.edge * (k >> i & 1) as f64);
            let error = (0..3).map(|i| (w.node_rest[*n as usize][i] - expected[i]).abs()).fold(0.0, f64::max);
            ensure(error <= 1e-9 * level.edge, || format!("corner {k} of cell {cell} is off by {error:.3e} m"))?;
        }
    }
    let (volume, sum) = (count as f64 * level.edge.powi(3), w.node_measure.iter().sum::<f64>());
    ensure((sum / volume - 1.0).abs() < 1e-6, || {
        format!("the measures of the nodes sum to {sum:.6e} m^3; the cells have {volume:.6e} m^3")
    })?;
    ensure(w.node_border.iter().all(|b| *b == 0), || {
        "a node of the whole body is marked as bordering on cells outside the region".into()
    })?;
    Ok(())
}

fn surface_cells_are_marked(c: &Candidate) -> CaseResult {
    let built = Built::new(c)?;
    let (points, triangles) = ball();
    let centroid = |t: &[u32; 3]| [0, 1, 2].map(|i| t.iter().map(|v| points[*v as usize][i]).sum::<f64>() / 3.0);
    let centroids: Vec<[f64; 3]> = triangles.iter().map(centroid).collect();
    let (cells, _) = built.grid.weights(LEVEL, &centroids).map_err(describe_fault)?;
    for (triangle, id) in cells.iter().enumerate().filter(|(_, id)| **id != NO_CELL) {
        let cell = built.whole.cell_id.iter().position(|c| c == id);
        let state = cell.map(|cell| u32::from(built.whole.cell_state[cell]));
        ensure(state == Some(CELL_SURFACE), || {
            format!("the cell of the centroid of triangle {triangle} is not marked as a surface cell")
        })?;
    }
    Ok(())
}

fn region_is_part_of_the_body(c: &Candidate) -> CaseResult {
    let built = Built::new(c)?;
    let level = built.grid.level(LEVEL).map_err(describe_fault)?;
    let centre = built.points[0];
    let part = built.grid.region(LEVEL, Ball { centre, radius: 1.5 * level.edge }).map_err(describe_fault)?;
    let whole: BTreeMap<u64, [f64; 3]> =
        built.whole.node_id.iter().copied().zip(built.whole.node_rest.iter().copied()).collect();
    ensure(!part.cell_id.is_empty(), || "the region around a surface point has no cells".into())?;
    for (id, rest) in part.node_id.iter().zip(&part.node_rest) {
        ensure(whole.get(id) == Some(rest), || format!("node {id} at {rest:?} m is not one of the whole body"))?;
    }
    if let Some(id) = part.cell_id.iter().find(|id| !built.whole.cell_id.contains(id)) {
        return Err(format!("cell {id} is not one of the whole body").into());
    }
    ensure(part.cell_id.contains(&built.cells[0]), || "the cell of the ball's centre is missing".into())?;
    // A node is on the border if and only if one of its cells is outside the region.
    let cells_per_node = |r: &Region| {
        let mut count: BTreeMap<u64, u32> = BTreeMap::new();
        r.cell_corners.iter().flatten().for_each(|n| *count.entry(r.node_id[*n as usize]).or_default() += 1);
        count
    };
    let (in_body, in_region) = (cells_per_node(&built.whole), cells_per_node(&part));
    for (id, border) in part.node_id.iter().zip(&part.node_border) {
        let on_border = in_region.get(id) != in_body.get(id);
        ensure((*border != 0) == on_border, || {
            format!("node {id}: border is {border}; some of its cells are outside the region: {on_border}")
        })?;
    }
    Ok(())
}
