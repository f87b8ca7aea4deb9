//! How long things take; run with `cargo test --release -p pliant-octree-grid -- --ignored --nocapture speed`.

use super::host::{ALL, Host};
use super::shapes::{model, new, sheet, sphere};
use pliant_plugin_api::Grid;
use pliant_plugin_api::abi::{Ball, SHEAR, STRUCTURAL};
use std::time::Instant;

#[test]
#[ignore = "measures and proves nothing"]
fn build() {
    let wave = sheet(128, |x, y| 0.1 * (7.0 * x).sin() * (9.0 * y).cos());
    let tube = sphere(1.0, 6).without(|p| p[2].abs() > 0.7);
    let models = ["stanford-bunny.obj", "teapot.obj", "spot.obj", "suzanne.obj"].map(|name| (name, model(name)));
    let models = models.into_iter().chain([("wavy sheet", Some(wave)), ("sphere open above and below", Some(tube))]);
    for (name, mesh) in models.filter_map(|(name, mesh)| Some((name, mesh?))) {
        for level in 6..=9 {
            let mut grid = new("trilinear");
            let mut times: Vec<f64> = (0..5)
                .map(|_| {
                    let start = Instant::now();
                    grid.build(&mesh.view(), level).unwrap();
                    start.elapsed().as_secs_f64() * 1e3
                })
                .collect();
            times.sort_by(f64::total_cmp);
            let facts = grid.level(level).unwrap();
            let counts = (facts.surface_cells, facts.inside_cells, facts.nodes);
            println!("{name} level {level}: {:.1} ms (best {:.1}), {counts:?}", times[2], times[0]);
        }
    }
}

#[test]
#[ignore = "measures and proves nothing"]
fn region() {
    let Some(mesh) = model("stanford-bunny.obj") else { return };
    for level in 6..=8 {
        let host = Host::with(&mesh, level);
        let cell = 0.1557 / f64::from(1 << (level - 1));
        for (cells_across, families) in [(8.0, STRUCTURAL | SHEAR), (8.0, ALL), (15.0, STRUCTURAL | SHEAR)] {
            let ball = Ball { centre: mesh.points[1000], radius: cells_across * cell };
            let mut region = host.region(level, families, &[ball], &[]).unwrap();
            let mut times: Vec<f64> = (0..200)
                .map(|_| {
                    let start = Instant::now();
                    host.fill(level, families, &[ball], &[], &mut region);
                    start.elapsed().as_secs_f64() * 1e3
                })
                .collect();
            times.sort_by(f64::total_cmp);
            let (cells, links) = (region.cell_id.len(), region.link_nodes.len());
            println!(
                "level {level}: {cells} cells, {links} links of {families:#x}: {:.3} ms (worst {:.3})",
                times[100], times[199]
            );
        }
    }
}
