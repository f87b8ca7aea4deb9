//! Update of the surface that a window draws, most of which are normals: `cargo bench -p pliant-editor --bench view_normals`.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_editor::surface::ViewSurface;
use pliant_engine::body::Model;
use pliant_live::{BodyTopology, BodyView};
use pliant_mesh::{Placement, generate};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// Updates of which the least time counts.
const RUNS: u64 = 9;

fn main() {
    // A ball of a million triangles.
    let model = Model::new(generate::sphere(289, 0.1).unwrap(), Placement::default());
    let origin = model.surface.bounds().centre();
    let looks = (0..model.surface.triangles.len() as u32).map(|t| model.look(t, None)).collect();
    let positions: Vec<[f32; 3]> = model.surface.points.iter().map(|p| (p - origin).map(|c| c as f32).into()).collect();
    let topology = BodyTopology {
        name: "ball".into(),
        triangles: Arc::new(looks),
        origin,
        positions: positions.clone(),
        moves: true,
    };
    let began = Instant::now();
    let mut surface = ViewSurface::new(&topology);
    println!(
        "{} triangles, {} vertices, new: {:.0} ms",
        topology.triangles.len(),
        positions.len(),
        1e3 * began.elapsed().as_secs_f64()
    );
    let mut number = 0;
    // Share of the ball's diameter that moves, from the top.
    for share in [1.0, 0.1, 0.01] {
        let mut least = f64::INFINITY;
        let mut moved = 0;
        for run in 0..RUNS {
            number += 1;
            let bump = 1e-4 * (1 + run % 2) as f32;
            let shape = positions
                .iter()
                .map(|p| if p[1] > (0.1 - 0.2 * share) as f32 { p.map(|c| c * (1.0 + bump)) } else { *p });
            let view = BodyView::of_positions(origin, shape.collect(), number);
            let began = Instant::now();
            let changes = black_box(surface.update(number, &view, &[]));
            least = least.min(began.elapsed().as_secs_f64());
            moved = changes.moved.len();
        }
        println!("{moved:>7} vertices moved: {:.2} ms, {:.0} ns for each", 1e3 * least, 1e9 * least / moved as f64);
    }
    let sum: f64 = surface.normals().iter().flatten().map(|c| f64::from(*c)).sum();
    println!("sum of normals {sum:.9}");
}
