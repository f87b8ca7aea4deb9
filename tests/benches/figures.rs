//! The figures the project promises of models and cuts, measured: `cargo build --release && cargo bench -p pliant-tests --bench
//! figures`. Those of steps are in the other benches.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session};
use pliant_host::{Grid, SearchPath};
use pliant_mesh::{ObjDocument, Placement, Surface, generate};
use pliant_tests::models::bunny;
use pliant_tests::{Bench, library, root};
use std::path::Path;
use std::time::Instant;

fn main() {
    println!("the scan is {}", bunny(&Bench::new()).0);
    loading();
    hierarchy();
    growth_with_the_mesh();
    first_step();
    cut();
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// The scan with every triangle divided into four, so many times.
fn divided(times: u32) -> Vec<u8> {
    let document = ObjDocument::read(&bunny(&Bench::new()).1).unwrap();
    let mut surface = Surface::from_document(&document);
    for _ in 0..times {
        surface = generate::subdivide(&surface);
    }
    generate::to_obj(&surface)
}

/// Loading a million triangles.
fn loading() {
    let bytes = divided(2);
    let (megabytes, mut triangles) = (bytes.len() as f64 / 1e6, 0);
    let seconds = (0..5)
        .map(|_| {
            let copy = bytes.clone();
            let start = Instant::now();
            let document = ObjDocument::parse(copy, Path::new("scan.obj")).unwrap();
            let seconds = start.elapsed().as_secs_f64();
            triangles = document.face_count();
            seconds
        })
        .collect();
    println!("OBJ of {triangles} triangles, {megabytes:.0} MB: loaded in {:.3} s", median(seconds));
}

/// The scan's hierarchy with classification and binding.
fn hierarchy() {
    let document = ObjDocument::read(&bunny(&Bench::new()).1).unwrap();
    let surface = Surface::from_document(&document);
    let surface = surface.placed(&Placement::fit(&surface.bounds(), 0.1).unwrap());
    let points: Vec<[f64; 3]> = surface.points.iter().map(|p| (*p).into()).collect();
    for level in [6, 7, 8] {
        let mut cells = 0;
        let seconds = (0..7)
            .map(|_| {
                let mut grid = Grid::open(library("octree-grid"), "octree-grid", &Vec::new(), 1e-3).unwrap();
                let start = Instant::now();
                grid.build(&points, &surface.triangles, level).unwrap();
                let (mut at, mut weights) = (vec![0; surface.points.len()], vec![[0.0; 8]; surface.points.len()]);
                grid.weights(level, &points, &mut at, &mut weights).unwrap();
                let seconds = start.elapsed().as_secs_f64();
                let facts = grid.level(level).unwrap();
                cells = facts.surface_cells + facts.inside_cells;
                seconds
            })
            .collect();
        println!("scan, level {level}: {cells} cells classified and bound in {:.1} ms", 1e3 * median(seconds));
    }
}

/// The same touch on the scan and on it subdivided 4 and 16 times.
fn growth_with_the_mesh() {
    let mut first = None;
    for times in 0..3 {
        let bench = Bench::new();
        let mesh = bench.write("scan.obj", divided(times));
        let (scene, source) = scene::load(&root().join("scenes/touch.toml"), &[]).unwrap();
        let plan = Plan::new(&scene, &source).unwrap();
        let options = Options { mesh: Some(mesh), ..Options::new(SearchPath::new(&[]), 1) };
        let start = Instant::now();
        let mut session = Session::open(&scene, &source, plan, &options).unwrap();
        let open = start.elapsed().as_secs_f64();
        let (mut touching, mut parts) = (Vec::new(), [0.0; 3]);
        for _ in 0..600 {
            session.step();
            let frame = session.frame();
            if frame.tools[0].contact.is_some() {
                touching.push(frame.seconds);
                (0..3).for_each(|p| parts[p] += frame.parts[p]);
            }
        }
        let steps = touching.len();
        let median = median(touching);
        let ratio = median / *first.get_or_insert(median);
        let parts = parts.map(|p| 1e6 * p / steps as f64);
        println!(
            "touch on {} triangles: {:.1} us a step in contact ({ratio:.2}x), mean us of regions {:.1}, contact {:.1}, \
             integration {:.1}; {} nodes, {} elements; opened in {:.0} ms",
            session.bodies[0].model.surface.triangles.len(),
            1e6 * median,
            parts[0],
            parts[1],
            parts[2],
            session.frame().nodes,
            session.frame().elements,
            1e3 * open
        );
    }
}

/// A blade through the back of the scan, in a local region: what an advance costs, and the step that takes it over.
fn cut() {
    let bench = Bench::new();
    let scan = bunny(&bench).1;
    for level in [6, 7] {
        let text = format!(
            "format = 1\n[time]\nduration = 1\n[[body]]\nmesh = {scan:?}\nsize = \"100 mm\"\nmaterial = {{ plugin = \
             \"mass-spring\", params = {{ young = \"100 kPa\", density = 1000 }} }}\ngrid = {{ level = {level} }}\n[[device]]\n\
             name = \"hand\"\nparams = {{ path = [[0, 0.01, 0.06, -0.05], [0.3, 0.01, -0.01, -0.05]] }}\n[[tool]]\n\
             name = \"knife\"\ndevice = \"hand\"\nradius = \"1 mm\"\nblade = {{ length = \"100 mm\", toughness = 2 }}\n\
             [[edit]]\nkind = \"cut\"\ntool = \"knife\"\n"
        );
        let mut session = pliant_tests::open_file(&bench.write("cut.toml", &text), 1, None);
        let (mut cutting, mut regions) = (Vec::new(), Vec::new());
        for _ in 0..300 {
            let before = session.cuts().advances;
            session.step();
            if session.cuts().advances > before {
                cutting.push(session.frame().seconds);
                regions.push(session.frame().parts[0]);
            }
        }
        let cuts = session.cuts();
        let most = cuts.seconds.iter().fold(0.0, |most: f64, s| most.max(*s));
        println!(
            "cut of the scan at level {level}: {} advances, {:.3e} m^2; an advance {:.2} ms (most {:.2}), with the exchange of \
             the region {:.2} ms, the whole step {:.2} ms with {} nodes",
            cuts.advances,
            cuts.area,
            1e3 * median(cuts.seconds.clone()),
            1e3 * most,
            1e3 * median(regions),
            1e3 * median(cutting),
            session.frame().nodes
        );
    }
}

/// From the start of the process to the end of its first step.
fn first_step() {
    let bench = Bench::new();
    let scene = root().join("scenes/touch.toml");
    let seconds = (0..9)
        .map(|_| {
            let start = Instant::now();
            let args = ["run", scene.to_str().unwrap(), "--set", "time.duration=0.001", "--json", "--out", "out"];
            bench.pliant(&args).expect(0);
            start.elapsed().as_secs_f64()
        })
        .collect();
    println!(
        "scenes/touch.toml, one step, the whole process with its results written: {:.1} ms",
        1e3 * median(seconds)
    );
}
