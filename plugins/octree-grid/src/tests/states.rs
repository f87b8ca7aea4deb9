//! Inside and outside, against shapes whose answer is known.

use super::shapes::{Mesh, cuboid, model, sphere};
use crate::vector::{Vector, dot, norm, sub};
use pliant_plugin_api::Grid;
use pliant_plugin_api::abi::{CELL_EMPTY, CELL_INSIDE, CELL_SURFACE};

/// Every cell that no triangle touches is inside just where `inside` says so, but for those that `open` leaves open.
fn check_but(mesh: &Mesh, inside: impl Fn(Vector) -> bool, open: impl Fn(Vector) -> bool) {
    let grid = mesh.grid(6);
    let (mut within, mut without) = (0, 0);
    for level in 2..=6 {
        let m = u64::from(grid.level(level).unwrap().cells_per_axis);
        for cell in (0..m * m * m).map(|id| grid.cell(level, id).unwrap()).filter(|c| !open(c.centre)) {
            if cell.state != CELL_SURFACE {
                assert_eq!(cell.state == CELL_INSIDE, inside(cell.centre), "{:?} of level {level}", cell.index);
                within += usize::from(cell.state == CELL_INSIDE);
                without += usize::from(cell.state == CELL_EMPTY);
            }
        }
    }
    assert!(within > 100 && without > 100, "{within} inside and {without} outside are not enough to tell");
}

fn check(mesh: &Mesh, inside: impl Fn(Vector) -> bool) {
    check_but(mesh, inside, |_| false);
}

const APART: Vector = [0.9, 0.3, -0.2]; // m

#[test]
fn closed_shapes() {
    check(&sphere(1.0, 4), |p| norm(p) < 1.0);
    check(&sphere(1.0, 4).inverted(), |p| norm(p) < 1.0);
    let slab = |p: Vector| p[0] > 0.0 && p[0] < 1.0 && p[1] > 0.0 && p[1] < 0.5 && p[2] > 0.0 && p[2] < 0.25;
    check(&cuboid([1.0, 0.5, 0.25]), slab);
    check(&cuboid([1.0; 3]).and(cuboid([0.5; 3]).inverted().moved([0.25; 3])), |p| {
        p.iter().any(|x| (x - 0.5).abs() > 0.25) && p.iter().all(|x| (x - 0.5).abs() < 0.5)
    });
}

#[test]
fn overlapping_shells_have_no_void() {
    let both = sphere(1.0, 4).and(sphere(0.8, 4).moved(APART));
    check(&both, |p| norm(p) < 1.0 || norm(sub(p, APART)) < 0.8);
    check(&both.inverted(), |p| norm(p) < 1.0 || norm(sub(p, APART)) < 0.8);
}

#[test]
fn nested_shells() {
    check(&sphere(1.0, 4).and(sphere(0.5, 4)), |p| norm(p) < 1.0);
    check(&sphere(1.0, 4).and(sphere(0.5, 4).inverted()), |p| norm(p) < 1.0 && norm(p) > 0.5);
}

#[test]
fn holes_are_closed_by_a_lid() {
    for axis in [[0.0, 0.0, 1.0], [0.3, -0.5, 0.8]] {
        let up = move |p: Vector| dot(p, axis) / norm(axis);
        let open = sphere(1.0, 5).without(move |p| up(p) > 0.8);
        // Where exactly the lid is, within two cells of level 6 but one or none of coarser levels, is left open.
        check_but(&open, |p| norm(p) < 1.0 && up(p) < 0.8, |p| (up(p) - 0.8).abs() < 2.0 / 16.0);
        check_but(&open.inverted(), |p| norm(p) < 1.0 && up(p) < 0.8, |p| (up(p) - 0.8).abs() < 2.0 / 16.0);
    }
}

#[test]
fn models_of_the_shared_folder() {
    // From a first run, after `winding.rs` agreed: only there to notice a change.
    for (name, surface, inside) in [
        ("stanford-bunny.obj", 3445, 4944),
        ("teapot.obj", 1776, 2332),
        ("spot.obj", 2776, 3367),
        ("suzanne.obj", 2355, 2389),
    ] {
        if let Some(mesh) = model(name) {
            let facts = mesh.grid(6).level(6).unwrap();
            assert_eq!((facts.surface_cells, facts.inside_cells), (surface, inside), "{name}");
        }
    }
}
