//! What the border costs, and a touch with each material: `cargo build --release && cargo bench -p pliant-tests --bench border`.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session};
use pliant_host::SearchPath;
use pliant_neo_hookean::NeoHookean;
use pliant_plugin_api::kit::{self, Body, MaterialUnderTest};
use pliant_plugin_api::{TangentScale, abi};
use pliant_tests::models::bunny;
use pliant_tests::{Bench, library, root};
use std::hint::black_box;
use std::time::Instant;

fn main() {
    border();
    touch();
}

/// The least of several runs of `run`, s.
fn least(runs: u32, mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..runs).map(time).fold(f64::INFINITY, f64::min)
}

/// A block in a state that is not rest.
fn body(material: &(impl MaterialUnderTest + ?Sized), cells: [u32; 3]) -> Body {
    let families = abi::STRUCTURAL | abi::SHEAR;
    let block = kit::block(cells, 0.01, families);
    let mut body = Body::new(material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
    for (i, x) in body.x.iter_mut().enumerate() {
        *x = [1.1 * x[0] + 1e-3 * (i as f64).sin(), x[1] + 1e-3 * (2.0 * i as f64).cos(), 0.95 * x[2]];
    }
    body
}

/// s: one call for a single tetrahedron; forces and matrix of many elements.
fn costs(material: &(impl MaterialUnderTest + ?Sized), cells: [u32; 3]) -> [f64; 3] {
    const CALLS: usize = 100_000;
    let (small, large) = (body(material, [1, 1, 1]), body(material, cells));
    let mut force = vec![[0.0; 3]; large.x.len()];
    let call = least(20, || {
        for _ in 0..CALLS {
            // Five tetrahedra or so in calls of one: the same work on either side of the border.
            black_box(black_box(&small).energy(material).unwrap());
        }
    });
    let forces = least(50, || large.add_forces(material, black_box(&mut force)).unwrap());
    let scale = TangentScale { stiffness: 1.0, damping: 1.0 };
    let tangent = least(10, || drop(black_box(large.blocks(material, scale, usize::MAX).unwrap())));
    [call / CALLS as f64, forces, tangent]
}

fn border() {
    let cells = [20, 20, 15];
    let direct: NeoHookean = kit::material(&[]).unwrap();
    let through = library("neo-hookean").candidate(0).open(&[]).unwrap();
    let (a, b) = (costs(&direct, cells), costs(&through, cells));
    println!(
        "a call about 5 tetrahedra: direct {:.0} ns, through the border {:.0} ns: {:.0} ns more",
        1e9 * a[0],
        1e9 * b[0],
        1e9 * (b[0] - a[0])
    );
    println!(
        "30,000 tetrahedra: forces {:.3} ms direct, {:.3} ms through the border; matrix {:.2} and {:.2} ms",
        1e3 * a[1],
        1e3 * b[1],
        1e3 * a[2],
        1e3 * b[2]
    );
    for name in ["neo-hookean", "corotational", "mass-spring"] {
        let material = library(name).candidate(0).open(&[]).unwrap();
        let count: usize = body(&material, cells)
            .element_counts()
            .filter(|(r, _)| r.flags & abi::HAS_FORCES != 0)
            .map(|(_, count)| count)
            .sum();
        let [_, forces, tangent] = costs(&material, cells);
        let each = |s: f64| 1e9 * s / count as f64;
        println!(
            "{name}: {count} elements, forces {:.1} ns an element, matrix {:.1} ns an element",
            each(forces),
            each(tangent)
        );
    }
}

/// The finger of `scenes/touch.toml` on a scan.
fn touch() {
    let bench = Bench::new();
    let (scan, mesh) = bunny(&bench);
    for integrator in ["auto", "backward-euler"] {
        for name in ["mass-spring", "corotational", "neo-hookean"] {
            let set = |path: &str, value: &str| (path.to_owned(), value.to_owned());
            let sets = [set("body.0.material.plugin", name), set("time.integrator", integrator)];
            let (scene, source) = scene::load(&root().join("scenes/touch.toml"), &sets).unwrap();
            let plan = Plan::new(&scene, &source).unwrap();
            let options = Options { mesh: Some(mesh.clone()), ..Options::new(SearchPath::new(&[]), 1) };
            let mut session = Session::open(&scene, &source, plan, &options).unwrap();
            let (mut seconds, mut force, mut iterations) = (Vec::new(), 0.0_f64, 0);
            for _ in 0..600 {
                session.step();
                let frame = session.frame();
                if frame.tools[0].contact.is_some() {
                    seconds.push(frame.seconds);
                    iterations += frame.iterations;
                    force = force.max(frame.tools[0].force.iter().map(|f| f * f).sum::<f64>().sqrt());
                }
            }
            seconds.sort_by(f64::total_cmp);
            let (frame, steps) = (session.frame(), seconds.len().max(1));
            println!(
                "touch on {scan}, {name}, {} with {} substeps: {:.2} ms a step in contact (median of {steps}), {} nodes, \
                 {} elements, {} iterations a step, largest force {force:.3} N",
                session.choices.integrator,
                frame.substeps,
                1e3 * seconds.get(steps / 2).copied().unwrap_or(0.0),
                frame.nodes,
                frame.elements,
                iterations / steps
            );
        }
    }
}
