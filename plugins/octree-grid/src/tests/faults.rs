//! Invalid input is refused, and the reason names the value and what is allowed.

use super::host::{ALL, Host};
use super::shapes::{Mesh, cuboid, new, sphere};
use crate::OctreeGrid;
use pliant_plugin_api::abi::{Ball, Status};
use pliant_plugin_api::{Fault, Grid, Params, param};

/// Building `mesh` to `level` fails with a reason that contains `words`.
fn refused(mesh: &Mesh, level: u32, words: &[&str]) {
    let fault = new("trilinear").build(&mesh.view(), level).expect_err("is refused");
    assert_names(&fault, words);
}

/// The fault is a bad argument whose reason contains all `words`.
fn assert_names(fault: &Fault, words: &[&str]) {
    assert_eq!(fault.status, Status::BAD_ARGUMENT);
    assert!(words.iter().all(|word| fault.reason.contains(word)), "`{}` lacks one of {words:?}", fault.reason);
}

#[test]
fn invalid_surfaces_are_refused() {
    let cube = || cuboid([1.0; 3]);
    let with = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = cube();
        change(&mut mesh);
        mesh
    };
    refused(&Mesh::default(), 3, &["0 points", "no triangles"]);
    refused(&with(&|m| m.triangles.clear()), 3, &["8 points", "no triangles"]);
    refused(&with(&|m| m.points[4][2] = f64::NAN), 3, &["point 4", "NaN"]);
    refused(&with(&|m| m.points[0][0] = f64::NEG_INFINITY), 3, &["point 0", "-inf"]);
    refused(&with(&|m| m.triangles[7][1] = 8), 3, &["triangle 7", "point 8 of 8"]);
    refused(&with(&|m| m.triangles[0][2] = u32::MAX), 3, &["triangle 0", "4294967295"]);
    refused(&with(&|m| m.points.clear()), 3, &["triangle 0", "of 0 points"]);
    refused(&with(&|m| m.points.fill([1.0, 2.0, 3.0])), 3, &["0 m across"]);
    refused(&with(&|m| m.points.fill([0.0; 3])), 3, &["0 m across"]);
    refused(&cube().moved([1e10, 0.0, 0.0]), 3, &["1 m across", "10000000001 m from 0"]);
    refused(&cuboid([1e200; 3]), 3, &["m across", "1e90"]);
    refused(&cuboid([1e-200; 3]), 3, &["m across", "1e-90"]);
    assert!(new("trilinear").build(&cube().moved([1e8, 0.0, 0.0]).view(), 5).is_ok());
}

#[test]
fn levels_that_are_too_fine_or_not_built_are_refused() {
    refused(&cuboid([1.0; 3]), 0, &["level 0", "1 to 10"]);
    refused(&cuboid([1.0; 3]), 11, &["level 11", "1073741824 cells", "5.0 GiB", "1 to 10"]);
    refused(&cuboid([1.0; 3]), 14, &["level 14", "549755813888 cells", "2560.0 GiB"]);
    refused(&cuboid([1.0; 3]), u32::MAX, &["level 4294967295", "or more", "1 to 10"]);
    let not_built = new("trilinear");
    let grid = cuboid([1.0; 3]).grid(3);
    for (grid, level, words) in [
        (&not_built, 1, ["no surface", "built"]),
        (&grid, 0, ["level 0", "1 to 3"]),
        (&grid, 4, ["level 4", "1 to 3"]),
        (&grid, u32::MAX, ["level 4294967295", "1 to 3"]),
    ] {
        assert_names(&grid.level(level).unwrap_err(), &words);
        assert_names(&grid.points(level).unwrap_err(), &words);
        assert_names(&grid.cell(level, 0).unwrap_err(), &words);
        assert_names(&grid.locate(level, [0.5; 3]).unwrap_err(), &words);
        assert_names(&grid.weights(level, &[[0.5; 3]], &mut [0], &mut [[0.0; 8]]).unwrap_err(), &["not built"]);
    }
    assert_names(&Host::new().region(1, ALL, &[], &[]).unwrap_err(), &["no surface"]);
    assert_names(&Host::with(&cuboid([1.0; 3]), 3).region(4, ALL, &[], &[]).unwrap_err(), &["level 4"]);
}

#[test]
fn invalid_cells_points_and_requests_are_refused() {
    let grid = sphere(1.0, 3).grid(5);
    assert_names(&grid.cell(5, 4096).unwrap_err(), &["cell 4096 of level 5", "0 to 4095"]);
    assert_names(&grid.cell(1, u64::MAX).unwrap_err(), &["18446744073709551615", "0 to 0"]);
    assert_names(&grid.locate(5, [0.0, f64::NAN, 0.0]).unwrap_err(), &["not finite", "NaN"]);
    let weights = |position| grid.weights(5, &[position], &mut [0], &mut [[0.0; 8]]).unwrap_err();
    assert_names(&weights([f64::INFINITY, 0.0, 0.0]), &["not finite"]);
    assert_names(&weights([0.0, 0.0, f64::NAN]), &["not finite"]);
    let host = Host::with(&sphere(1.0, 3), 5);
    let region =
        |centre, radius| host.region(5, ALL, &[Ball { centre: [0.0; 3], radius: 1.0 }, Ball { centre, radius }], &[]);
    assert_names(&region([0.0; 3], -1.0).unwrap_err(), &["ball 1", "-1.0", "0 or more"]);
    assert_names(&region([0.0; 3], f64::NAN).unwrap_err(), &["ball 1", "NaN"]);
    assert_names(&region([f64::INFINITY; 3], 1.0).unwrap_err(), &["ball 1", "inf"]);
    assert_names(&host.region(5, 17, &[], &[]).unwrap_err(), &["0x11", "0xf"]);
}

#[test]
fn embeddings_offer_their_own_functions_only() {
    let out_of_range = [param::Value::Number(2.0)];
    let fault = OctreeGrid::new(&Params::new(OctreeGrid::INFO.params, &out_of_range)).err().expect("is refused");
    assert_names(&fault, &["trilinear", "paper-ratio"]);
    let grid = cuboid([1.0; 3]).grid(2);
    assert!(!grid.is_nonlinear());
    let corners = [[[0.0; 3]; 8]];
    assert_eq!(grid.place(2, &[[0.5; 3]], &corners, &mut [[0.0; 3]]).unwrap_err().status, Status::UNSUPPORTED);
    let mut loads = corners;
    assert_eq!(
        grid.pull_back(2, &[[0.5; 3]], &corners, &[[1.0; 3]], &mut loads).unwrap_err().status,
        Status::UNSUPPORTED
    );
    let mut paper = new("paper-ratio");
    assert!(paper.is_nonlinear());
    assert_names(&paper.place(2, &[[0.5; 3]], &corners, &mut [[0.0; 3]]).unwrap_err(), &["not built"]);
    paper.build(&sphere(1.0, 3).view(), 5).unwrap();
    for far in [[0.95; 3], [1e30, 0.0, 0.0]] {
        assert_names(&paper.place(5, &[far], &corners, &mut [[0.0; 3]]).unwrap_err(), &["tenth of a cell"]);
        assert_names(&paper.pull_back(5, &[far], &corners, &[[1.0; 3]], &mut loads).unwrap_err(), &["tenth of a cell"]);
    }
}
