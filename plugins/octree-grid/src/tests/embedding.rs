//! Trilinear weights, and the paper's rule.

use super::shapes::{cuboid, new, sphere};
use crate::OctreeGrid;
use pliant_plugin_api::Grid;
use pliant_plugin_api::abi::{CELL_EMPTY, NO_CELL};
use pliant_plugin_api::lanes::Vec3;

/// Rest positions of the corners of a cell.
fn corners(grid: &OctreeGrid, level: u32, id: u64) -> [Vec3; 8] {
    let cell = grid.cell(level, id).unwrap();
    [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|c: u32| Vec3([0, 1, 2].map(|axis| cell.reference[axis] + cell.edge * f64::from(c >> axis & 1))))
}

/// Cell and weights of a rest position.
fn weights(grid: &OctreeGrid, level: u32, position: Vec3) -> (u64, [f64; 8]) {
    let (mut id, mut weights) = ([0], [[0.0; 8]]);
    grid.weights(level, &[position.0], &mut id, &mut weights).unwrap();
    (id[0], weights[0])
}

/// The weighted sum of the corners.
fn interpolate(weights: [f64; 8], corners: [Vec3; 8]) -> Vec3 {
    weights.iter().zip(corners).fold(Vec3::default(), |sum, (w, x)| sum + x * *w)
}

/// Points in the unit cube from a low-discrepancy sequence.
fn scattered(count: usize) -> impl Iterator<Item = Vec3> {
    (1..=count).map(|i| Vec3([0.754877666, 0.569840291, 0.362437104].map(|step: f64| (step * i as f64).fract())))
}

/// An affine map with rotation, stretch and shear.
fn affine(x: Vec3) -> Vec3 {
    let rows = [Vec3([1.2, -0.7, 0.3]), Vec3([0.5, 0.9, -0.2]), Vec3([0.1, 0.4, 1.6])];
    Vec3([0.3, -2.0, 1.0]) + Vec3(rows.map(|row| row.dot(x)))
}

#[test]
fn weights_sum_to_one_and_carry_affine_motion() {
    let grid = cuboid([1.0; 3]).grid(7);
    let special = [[0.0; 3], [1.0; 3], [0.5; 3], [1.0, 0.0, 0.5]].map(Vec3);
    for position in scattered(500).chain(special) {
        for level in 1..=7 {
            let (id, weights) = weights(&grid, level, position);
            assert_eq!(id, grid.locate(level, position.0).unwrap().cell);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            assert!(weights.iter().all(|w| *w >= 0.0));
            let corners = corners(&grid, level, id);
            assert!((interpolate(weights, corners) - position).norm() < 1e-12, "the rest position");
            assert!((interpolate(weights, corners.map(affine)) - affine(position)).norm() < 1e-12);
        }
    }
}

#[test]
fn weight_i_is_one_at_corner_i() {
    let grid = cuboid([1.0; 3]).grid(2);
    for (i, corner) in corners(&grid, 2, 0).into_iter().enumerate() {
        let inner = Vec3(corner.0.map(|x| x.clamp(1e-9, 0.5 - 1e-9)));
        let (id, weights) = weights(&grid, 2, inner);
        assert_eq!(id, 0);
        assert!((weights[i] - 1.0).abs() < 1e-5, "corner {i}: {weights:?}");
    }
}

#[test]
fn positions_are_continuous_across_shared_faces() {
    let grid = cuboid([1.0; 3]).grid(4);
    let bent = |x: Vec3| Vec3([x[0] + (7.0 * x[1]).sin(), x[1] * x[2], x[2] + (9.0 * x[0] * x[1]).cos()]);
    let edge = grid.level(4).unwrap().edge;
    for (i, mut face) in scattered(60).enumerate() {
        let axis = i % 3;
        face[axis] = grid.level(4).unwrap().origin[axis] + edge * (1 + i % 7) as f64;
        let sides = [-1e-11, 1e-11].map(|step| {
            let mut position = face;
            position[axis] += step;
            let (id, weights) = weights(&grid, 4, position);
            (id, interpolate(weights, corners(&grid, 4, id).map(bent)))
        });
        assert_ne!(sides[0].0, sides[1].0);
        assert!((sides[0].1 - sides[1].1).norm() < 1e-9);
    }
}

#[test]
fn positions_just_outside_are_embedded_in_the_nearest_cell() {
    let grid = sphere(1.0, 4).grid(6);
    let level = grid.level(6).unwrap();
    let is_occupied = |x: Vec3| grid.cell(6, grid.locate(6, x.0).unwrap().cell).unwrap().state != CELL_EMPTY;
    let distance = |local: [f64; 3]| Vec3(local.map(|p| p - p.clamp(0.0, 1.0))).norm();
    let (mut embedded, mut refused) = (0, 0);
    for position in scattered(20000).map(|p| (p - Vec3([0.5; 3])) * 2.3) {
        if position.0.iter().all(|x| x.abs() <= 1.0) && is_occupied(position) {
            continue;
        }
        // Brute force: all occupied cells within reach of the position, and the least distance to one.
        let near = (0..27).map(|n| Vec3([n % 3, n / 3 % 3, n / 9].map(|d| f64::from(d) - 1.0)));
        let near = near.filter_map(|step| {
            let cell = grid.locate(6, (position + step * (0.2 * level.edge)).0).unwrap().cell;
            let cell = grid.cell(6, cell).unwrap();
            let local = [0, 1, 2].map(|axis| (position[axis] - cell.reference[axis]) / cell.edge);
            let within_reach = local.iter().all(|p| (p - 0.5).abs() <= 0.6) && cell.state != CELL_EMPTY;
            within_reach.then(|| distance(local))
        });
        let nearest = near.fold(f64::INFINITY, f64::min);
        let (mut id, mut found) = ([0], [[1.0; 8]]);
        grid.weights(6, &[position.0], &mut id, &mut found).unwrap();
        assert_eq!(id[0] != NO_CELL, nearest.is_finite(), "{position:?}");
        if id[0] != NO_CELL {
            embedded += 1;
            let (cell, corners) = (grid.cell(6, id[0]).unwrap(), corners(&grid, 6, id[0]));
            let local = [0, 1, 2].map(|axis| (position[axis] - cell.reference[axis]) / cell.edge);
            assert!((distance(local) - nearest).abs() < 1e-9);
            let extrapolated = interpolate(found[0], corners.map(affine));
            assert!((extrapolated - affine(position)).norm() < 1e-12, "affine motion is exact outside the cell too");
        } else {
            refused += 1;
            assert_eq!(found, [[0.0; 8]]);
        }
    }
    assert!(embedded > 100 && refused > 100, "{embedded} embedded, {refused} refused");
}

#[test]
fn the_paper_rule_is_not_exact_under_rotation() {
    let mut grid = new("paper-ratio");
    grid.build(&cuboid([1.0; 3]).view(), 3).unwrap();
    let edge = grid.level(3).unwrap().edge;
    let cell = grid.cell(3, 21).unwrap();
    let (base, centre) = (Vec3(cell.reference), Vec3(cell.centre));
    let place = |rest: Vec3, corners: [Vec3; 8]| {
        let mut position = [[0.0; 3]];
        grid.place(3, &[rest.0], &[corners.map(|c| c.0)], &mut position).unwrap();
        Vec3(position[0])
    };
    for (degrees, error) in [(10.0_f64, 0.123256833), (30.0, 0.366025404), (90.0, 1.0)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        // Rotation about z through the base corner.
        let rotate = |x: Vec3| {
            let d = x - base;
            base + Vec3([cos * d[0] - sin * d[1], sin * d[0] + cos * d[1], d[2]])
        };
        let rotated = corners(&grid, 3, 21).map(rotate);
        assert!(((place(centre, rotated) - rotate(centre)).norm() / edge - error).abs() < 1e-9);
        let (_, weights) = weights(&grid, 3, centre);
        assert!((interpolate(weights, rotated) - rotate(centre)).norm() < 1e-14, "the trilinear weights are exact");
    }
    let stretch = |x: Vec3| Vec3([1.5 * x[0], 0.7 * x[1], 2.0 * x[2]]);
    let rest = centre + Vec3([0.3, -0.2, 0.1]) * edge;
    let stretched = place(rest, corners(&grid, 3, 21).map(stretch));
    assert!((stretched - stretch(rest)).norm() < 1e-14, "stretch along the axes is exact");
}

/// Virtual work: the loads on points do the same work as the loads on corners, for a displacement of the corners.
#[test]
fn corner_loads_are_the_transpose_of_the_positions() {
    const COUNT: usize = 20;
    for embedding in ["trilinear", "paper-ratio"] {
        let mut grid = new(embedding);
        grid.build(&cuboid([1.0; 3]).view(), 3).unwrap();
        let rest: Vec<Vec3> = scattered(COUNT).collect();
        let trilinear: Vec<(u64, [f64; 8])> = rest.iter().map(|&p| weights(&grid, 3, p)).collect();
        let raw_rest: Vec<[f64; 3]> = rest.iter().map(|p| p.0).collect();
        let raw = |cells: &[[Vec3; 8]]| cells.iter().map(|c| c.map(|x| x.0)).collect::<Vec<_>>();
        let field = |x: Vec3, size: f64| affine(x) + Vec3([(5.0 * x[1]).sin(), x[0] * x[2], (3.0 * x[0]).cos()]) * size;
        let cells = |size: f64| -> Vec<[Vec3; 8]> {
            trilinear.iter().map(|(id, _)| corners(&grid, 3, *id).map(|x| field(x, size))).collect()
        };
        let (current, displacement) = (cells(0.2), cells(0.9));
        let loads: Vec<Vec3> = scattered(COUNT).map(|x| x - Vec3([0.4; 3])).collect();
        let raw_loads: Vec<[f64; 3]> = loads.iter().map(|f| f.0).collect();
        let positions_at = |t: f64| -> Vec<Vec3> {
            let moved = |i: usize| [0, 1, 2, 3, 4, 5, 6, 7].map(|c| current[i][c] + displacement[i][c] * t);
            let moved: Vec<[Vec3; 8]> = (0..COUNT).map(moved).collect();
            if embedding == "trilinear" {
                return (0..COUNT).map(|i| interpolate(trilinear[i].1, moved[i])).collect();
            }
            let mut positions = vec![[0.0; 3]; COUNT];
            grid.place(3, &raw_rest, &raw(&moved), &mut positions).unwrap();
            positions.into_iter().map(Vec3).collect()
        };
        let mut corner_loads = vec![[[0.0; 3]; 8]; COUNT];
        if embedding == "trilinear" {
            (0..COUNT).for_each(|i| corner_loads[i] = trilinear[i].1.map(|w| (loads[i] * w).0));
        } else {
            grid.pull_back(3, &raw_rest, &raw(&current), &raw_loads, &mut corner_loads).unwrap();
        }
        let (ahead, back) = (positions_at(1e-5), positions_at(-1e-5));
        for i in 0..COUNT {
            let on_points = loads[i].dot((ahead[i] - back[i]) * (1.0 / 2e-5));
            let on_corners: f64 = (0..8).map(|c| Vec3(corner_loads[i][c]).dot(displacement[i][c])).sum();
            let difference = (on_points - on_corners).abs();
            assert!(difference < 1e-8 * (1.0 + on_points.abs()), "{embedding} {i}: {on_points} {on_corners}");
            let total = corner_loads[i].iter().fold(Vec3::default(), |sum, f| sum + Vec3(*f));
            assert!((total - loads[i]).norm() < 1e-14, "the loads on the corners sum to the load on the point");
        }
        if embedding == "paper-ratio" {
            let before = corner_loads.clone();
            grid.pull_back(3, &raw_rest, &raw(&current), &raw_loads, &mut corner_loads).unwrap();
            assert!((corner_loads[7][0][1] - 2.0 * before[7][0][1]).abs() < 1e-14, "a second call adds to the first");
        }
    }
}

#[test]
fn an_edge_without_length_transmits_no_load() {
    let mut grid = new("paper-ratio");
    grid.build(&cuboid([1.0; 3]).view(), 1).unwrap();
    let mut loads = [[[0.0; 3]; 8]];
    grid.pull_back(1, &[[0.5; 3]], &[[[0.25; 3]; 8]], &[[1.0, 2.0, 3.0]], &mut loads).unwrap();
    assert_eq!(loads[0][0], [1.0, 2.0, 3.0]);
    assert!(loads[0][1..].iter().all(|f| *f == [0.0; 3]));
}
