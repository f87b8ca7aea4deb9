//! Classification by crossings against the winding number by solid angles.

use super::shapes::{Mesh, sheet, sphere};
use pliant_mesh::ObjDocument;
use pliant_mesh::testing::{models, shared_models};
use pliant_plugin_api::Grid;
use pliant_plugin_api::abi::{CELL_INSIDE, CELL_SURFACE};
use pliant_plugin_api::lanes::Vec3;
use std::f64::consts::PI;

/// The generalised winding number around a point, by solid angles (van Oosterom and Strackee 1983).
fn winding_number(mesh: &Mesh, point: Vec3) -> f64 {
    let sum = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|p| Vec3(mesh.points[p as usize]) - point);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        2.0 * a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
    });
    sum.sum::<f64>() / (4.0 * PI)
}

/// Checks every `stride`-th cell of level 6 that no triangle touches: where its state differs from |w| >= 1/2, the winding number w is
/// within `margin` of 1/2.
fn check(name: &str, mesh: &Mesh, stride: usize, margin: f64) {
    let grid = mesh.grid(6);
    let cells = (0..32_u64.pow(3)).step_by(stride).map(|id| grid.cell(6, id).unwrap());
    let free: Vec<_> = cells.filter(|cell| cell.state != CELL_SURFACE).collect();
    let mut differ = 0;
    for cell in &free {
        let w = winding_number(mesh, Vec3(cell.centre)).abs();
        if (w >= 0.5) != (cell.state == CELL_INSIDE) {
            differ += 1;
            assert!((w - 0.5).abs() <= margin, "{name}: cell {} has winding number {w}", cell.id);
        }
    }
    println!("{name}: {differ} of {} cells differ", free.len());
    assert!(differ * 50 < free.len(), "{name}: {differ} of {} cells differ", free.len());
}

#[test]
fn open_shapes_close_where_the_solid_angle_closes_them() {
    let axis = [0.3, 0.5, 0.8];
    let up = move |p: Vec3| p.dot(Vec3(axis)) / Vec3(axis).norm();
    check("small hole", &sphere(1.0, 4).without(move |p| up(p) > 0.8), 7, 0.1);
    check("hole on an axis", &sphere(1.0, 4).without(|p| p[0] > 0.8), 7, 0.1);
    check("bowl", &sphere(1.0, 4).without(move |p| up(p) > 0.1), 7, 0.1);
    check("dish", &sphere(1.0, 4).without(move |p| up(p) > -0.5), 7, 0.1);
    check("tube", &sphere(1.0, 4).without(move |p| up(p).abs() > 0.7), 7, 0.12);
    check("flat sheet", &sheet(20, |x, y| 0.3 * x + 0.4 * y), 7, 0.0);
    check("sheet at 45 degrees", &sheet(20, |x, _| x), 7, 0.0);
    check("wavy sheet", &sheet(30, |x, y| 0.1 * (7.0 * x).sin() * (9.0 * y).cos()), 7, 0.1);
}

#[test]
fn models_close_where_the_solid_angle_closes_them() {
    for model in models(6, 1) {
        check(&model.name, &Mesh::of(&model.document()), 23, 0.05);
    }
}

#[test]
#[ignore = "needs ../shared/meshes"]
fn real_models_close_where_the_solid_angle_closes_them() {
    for path in shared_models() {
        let mesh = Mesh::of(&ObjDocument::read(&path).unwrap());
        // So many cells that each model takes about as long.
        let stride = (mesh.triangles.len() / 200).max(1) | 1;
        check(&path.display().to_string(), &mesh, stride, 0.05);
    }
}
