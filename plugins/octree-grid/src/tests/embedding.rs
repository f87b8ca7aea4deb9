//! Weights, and the paper's rule beside them.

use super::shapes::{cuboid, new, sphere};
use crate::OctreeGrid;
use crate::vector::{Vector, add, dot, norm, scale, sub};
use pliant_plugin_api::Grid;
use pliant_plugin_api::abi::{CELL_EMPTY, NO_CELL};

/// Rest places of the corners of a cell.
fn corners(grid: &OctreeGrid, level: u32, id: u64) -> [Vector; 8] {
    let cell = grid.cell(level, id).unwrap();
    [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|c: u32| [0, 1, 2].map(|axis| cell.reference[axis] + cell.edge * f64::from(c >> axis & 1)))
}

fn weights(grid: &OctreeGrid, level: u32, place: Vector) -> (u64, [f64; 8]) {
    let (mut id, mut weights) = ([0], [[0.0; 8]]);
    grid.weights(level, &[place], &mut id, &mut weights).unwrap();
    (id[0], weights[0])
}

fn mix(weights: [f64; 8], corners: [Vector; 8]) -> Vector {
    weights.iter().zip(corners).fold([0.0; 3], |sum, (w, x)| add(sum, scale(*w, x)))
}

/// Places that are not special, from a fixed sequence.
fn scattered(count: usize) -> impl Iterator<Item = Vector> {
    (1..=count).map(|i| [0.754877666, 0.569840291, 0.362437104].map(|step: f64| (step * i as f64).fract()))
}

const TURN: [Vector; 3] = [[1.2, -0.7, 0.3], [0.5, 0.9, -0.2], [0.1, 0.4, 1.6]];

fn affine(x: Vector) -> Vector {
    add([0.3, -2.0, 1.0], TURN.map(|row| dot(row, x)))
}

#[test]
fn weights_sum_to_one_and_carry_affine_motion() {
    let grid = cuboid([1.0; 3]).grid(7);
    for place in scattered(500).chain([[0.0; 3], [1.0; 3], [0.5; 3], [1.0, 0.0, 0.5]]) {
        for level in 1..=7 {
            let (id, weights) = weights(&grid, level, place);
            assert_eq!(id, grid.locate(level, place).unwrap().cell);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            assert!(weights.iter().all(|w| *w >= 0.0));
            let corners = corners(&grid, level, id);
            assert!(norm(sub(mix(weights, corners), place)) < 1e-12, "rest is rest");
            assert!(norm(sub(mix(weights, corners.map(affine)), affine(place))) < 1e-12);
        }
    }
}

#[test]
fn weight_i_is_one_at_corner_i() {
    let grid = cuboid([1.0; 3]).grid(2);
    for (i, corner) in corners(&grid, 2, 0).into_iter().enumerate() {
        let inner = corner.map(|x| x.clamp(1e-9, 0.5 - 1e-9));
        let (id, weights) = weights(&grid, 2, inner);
        assert_eq!(id, 0);
        assert!((weights[i] - 1.0).abs() < 1e-5, "corner {i}: {weights:?}");
    }
}

#[test]
fn places_are_continuous_over_shared_faces() {
    let grid = cuboid([1.0; 3]).grid(4);
    let bent = |x: Vector| [x[0] + (7.0 * x[1]).sin(), x[1] * x[2], x[2] + (9.0 * x[0] * x[1]).cos()];
    let edge = grid.level(4).unwrap().edge;
    for (at, place) in scattered(60).enumerate() {
        let mut face = place;
        face[at % 3] = grid.level(4).unwrap().origin[at % 3] + edge * (1 + at % 7) as f64;
        let sides = [-1e-11, 1e-11].map(|step| {
            let mut place = face;
            place[at % 3] += step;
            let (id, weights) = weights(&grid, 4, place);
            (id, mix(weights, corners(&grid, 4, id).map(bent)))
        });
        assert_ne!(sides[0].0, sides[1].0);
        assert!(norm(sub(sides[0].1, sides[1].1)) < 1e-9);
    }
}

#[test]
fn places_just_outside_go_to_the_nearest_cell() {
    let grid = sphere(1.0, 4).grid(6);
    let facts = grid.level(6).unwrap();
    let occupied = |place| grid.cell(6, grid.locate(6, place).unwrap().cell).unwrap().state != CELL_EMPTY;
    let (mut carried, mut left) = (0, 0);
    for place in scattered(20000).map(|p| scale(2.3, sub(p, [0.5; 3]))) {
        if place.iter().all(|x| x.abs() <= 1.0) && occupied(place) {
            continue;
        }
        // The slow way: any occupied cell that reaches the place, and the least distance to one.
        let near = (0..27).map(|n| [n % 3, n / 3 % 3, n / 9].map(|d| f64::from(d) - 1.0));
        let near = near.filter_map(|step: Vector| {
            let cell = grid.locate(6, add(place, scale(0.2 * facts.edge, step))).unwrap().cell;
            let cell = grid.cell(6, cell).unwrap();
            let local = [0, 1, 2].map(|axis| (place[axis] - cell.reference[axis]) / cell.edge);
            let reached = local.iter().all(|p| (p - 0.5).abs() <= 0.6) && cell.state != CELL_EMPTY;
            reached.then(|| norm(local.map(|p| p - p.clamp(0.0, 1.0))))
        });
        let nearest = near.fold(f64::INFINITY, f64::min);
        let (mut id, mut found) = ([0], [[1.0; 8]]);
        grid.weights(6, &[place], &mut id, &mut found).unwrap();
        assert_eq!(id[0] != NO_CELL, nearest.is_finite(), "{place:?}");
        if id[0] != NO_CELL {
            carried += 1;
            let (cell, corners) = (grid.cell(6, id[0]).unwrap(), corners(&grid, 6, id[0]));
            let local = [0, 1, 2].map(|axis| (place[axis] - cell.reference[axis]) / cell.edge);
            assert!((norm(local.map(|p| p - p.clamp(0.0, 1.0))) - nearest).abs() < 1e-9);
            assert!(norm(sub(mix(found[0], corners.map(affine)), affine(place))) < 1e-12, "it extrapolates");
        } else {
            left += 1;
            assert_eq!(found, [[0.0; 8]]);
        }
    }
    assert!(carried > 100 && left > 100, "{carried} carried, {left} left");
}

#[test]
fn r28_the_paper_rule_loses_rotation() {
    let mut grid = new("paper-ratio");
    grid.build(&cuboid([1.0; 3]).view(), 3).unwrap();
    let edge = grid.level(3).unwrap().edge;
    let cell = grid.cell(3, 21).unwrap();
    for (degrees, error) in [(10.0_f64, 0.123256833), (30.0, 0.366025404), (90.0, 1.0)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turn = |x: Vector| [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1], x[2]];
        // About the base corner, as the reference does it.
        let about = |x: Vector| add(cell.reference, turn(sub(x, cell.reference)));
        let turned = corners(&grid, 3, 21).map(about);
        let mut place = [[0.0; 3]];
        grid.place(3, &[cell.centre], &[turned], &mut place).unwrap();
        assert!((norm(sub(place[0], about(cell.centre))) / edge - error).abs() < 1e-9);
        let (_, weights) = weights(&grid, 3, cell.centre);
        assert!(norm(sub(mix(weights, turned), about(cell.centre))) < 1e-14, "trilinear does not");
    }
    let stretched = corners(&grid, 3, 21).map(|x| [1.5 * x[0], 0.7 * x[1], 2.0 * x[2]]);
    let (mut place, rest) = ([[0.0; 3]], add(cell.centre, [0.3 * edge, -0.2 * edge, 0.1 * edge]));
    grid.place(3, &[rest], &[stretched], &mut place).unwrap();
    assert!(
        norm(sub(place[0], [1.5 * rest[0], 0.7 * rest[1], 2.0 * rest[2]])) < 1e-14,
        "stretch along the axes is exact"
    );
}

/// Virtual work: loads times the change of places is corner loads times the change of corners.
#[test]
fn loads_are_the_transpose_of_places() {
    for embedding in ["trilinear", "paper-ratio"] {
        let mut grid = new(embedding);
        grid.build(&cuboid([1.0; 3]).view(), 3).unwrap();
        let rest: Vec<Vector> = scattered(20).collect();
        let ids: Vec<u64> = rest.iter().map(|&p| weights(&grid, 3, p).0).collect();
        let wobble =
            |x: Vector, by: f64| add(affine(x), [by * (5.0 * x[1]).sin(), by * x[0] * x[2], by * (3.0 * x[0]).cos()]);
        let now: Vec<[Vector; 8]> = ids.iter().map(|&id| corners(&grid, 3, id).map(|x| wobble(x, 0.2))).collect();
        let step: Vec<[Vector; 8]> = ids.iter().map(|&id| corners(&grid, 3, id).map(|x| wobble(x, 0.9))).collect();
        let loads: Vec<Vector> = scattered(20).map(|x| sub(x, [0.4; 3])).collect();
        let at = |t: f64| {
            let mixed = |i: usize| [0, 1, 2, 3, 4, 5, 6, 7].map(|c| add(now[i][c], scale(t, step[i][c])));
            let corners: Vec<[Vector; 8]> = (0..20).map(mixed).collect();
            let mut places = vec![[0.0; 3]; 20];
            match embedding {
                "trilinear" => (0..20).for_each(|i| places[i] = mix(weights(&grid, 3, rest[i]).1, corners[i])),
                _ => grid.place(3, &rest, &corners, &mut places).unwrap(),
            }
            places
        };
        let mut corner_loads = vec![[[0.0; 3]; 8]; 20];
        match embedding {
            "trilinear" => {
                (0..20).for_each(|i| corner_loads[i] = weights(&grid, 3, rest[i]).1.map(|w| scale(w, loads[i])))
            }
            _ => grid.pull_back(3, &rest, &now, &loads, &mut corner_loads).unwrap(),
        }
        let (ahead, back) = (at(1e-5), at(-1e-5));
        for i in 0..20 {
            let work = dot(loads[i], scale(1.0 / 2e-5, sub(ahead[i], back[i])));
            let given: f64 = (0..8).map(|c| dot(corner_loads[i][c], step[i][c])).sum();
            assert!((work - given).abs() < 1e-8 * (1.0 + work.abs()), "{embedding} {i}: {work} is not {given}");
            let total = corner_loads[i].iter().fold([0.0; 3], |sum, f| add(sum, *f));
            assert!(norm(sub(total, loads[i])) < 1e-14, "momentum");
        }
        if embedding == "paper-ratio" {
            let before = corner_loads.clone();
            grid.pull_back(3, &rest, &now, &loads, &mut corner_loads).unwrap();
            assert!((corner_loads[7][0][1] - 2.0 * before[7][0][1]).abs() < 1e-14, "adds to what is there");
        }
    }
}

#[test]
fn an_edge_of_no_length_passes_no_load_on() {
    let mut grid = new("paper-ratio");
    grid.build(&cuboid([1.0; 3]).view(), 1).unwrap();
    let mut loads = [[[0.0; 3]; 8]];
    grid.pull_back(1, &[[0.5; 3]], &[[[0.25; 3]; 8]], &[[1.0, 2.0, 3.0]], &mut loads).unwrap();
    assert_eq!(loads[0][0], [1.0, 2.0, 3.0]);
    assert!(loads[0][1..].iter().all(|f| *f == [0.0; 3]));
}
