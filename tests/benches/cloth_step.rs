//! A step of the pressed cloth, split: `cargo build --release && cargo bench -p pliant-tests --bench cloth_step -- WHAT...`,
//! where WHAT filters `pressed 64 2-threads` and the like; without it, the cases the project's floor names. `REPEATS=5` goes
//! through each case five times and counts the least of each step, as a busy machine delays other steps each time; `PAUSE=3`
//! sleeps for 3 ms before each step.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_engine::session::{EventKind, Session};
use pliant_tests::{Bench, models, open_file};
use std::time::Duration;

/// Name, and the cloth's parameters.
const FABRICS: [(&str, &str); 5] = [
    ("generic", "density = 0.15, young-warp = 500, poisson = 0.3, bending-warp = 10e-6"),
    ("t-shirt", "fabric = \"interlock\""),
    ("denim", "fabric = \"denim\""),
    ("tablecloth", "fabric = \"tablecloth\""),
    (
        "stiff",
        "density = 0.128, young-warp = 40040, young-weft = 40550, shear = 192, poisson = 0, bending-warp = 78e-6",
    ),
];

/// Meshes: sheets of a scene, the first one without a word for it, and files of scattered vertices, row by row and in no order.
const MESHES: [&str; 4] = ["alternating", "irregular", "scattered", "shuffled"];

/// A cloth of `n` vertices a side that hangs by its top row, and a tip that presses 10 mm into its middle and then stays or
/// slides along at 5 cm/s.
fn pressed(n: u32, mesh: &str, material: &str, time: &str, slides: bool, threads: usize) -> Session {
    let cells = n - 1;
    let bench = Bench::new();
    let body = match mesh {
        "scattered" | "shuffled" => {
            bench.write("mesh.obj", models::scattered(n, 0.2, mesh == "shuffled"));
            "mesh = \"mesh.obj\"".to_owned()
        }
        _ => format!(
            r#"shape = {{ kind = "sheet", cells = {cells}, rows = {cells}, pattern = "{mesh}", size = [0.2, 0.2, 0] }}"#
        ),
    };
    let (to, until) = if slides { (0.14, 1.0) } else { (0.1, 1.0) };
    let scene = bench.write(
        "scene.toml",
        format!(
            r#"
            format = 1
            output = {{ energy = false }}
            gravity = [0, -9.81, 0]
            [time]
            duration = 2
            integrator = "backward-euler"
            {time}
            [[body]]
            {body}
            sheet = {{ warp = [1, 0, 0] }}
            material = {{ plugin = "cloth", params = {{ {material} }} }}
            [[body.fixed]]
            box = [[-1, 0.19999, -1], [1, 1, 1]]
            [[device]]
            name = "hand"
            params = {{ path = [[0, 0.1, 0.1, 0.009], [0.2, 0.1, 0.1, -0.002], [{until}, {to}, 0.1, -0.002]] }}
            [[tool]]
            name = "finger"
            device = "hand"
            radius = "8 mm"
            friction = [0.35, 0.3]
            slew = "1e9 N/s"
            [[edit]]
            kind = "touch"
            tool = "finger"
            "#
        ),
    );
    open_file(&scene, threads, None)
}

fn quantile(sorted: &[f64], q: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * q).round() as usize]
}

fn setting(name: &str) -> u64 {
    std::env::var(name).map_or(0, |text| text.parse().expect("a number"))
}

/// Goes through the first half of the press, then measures `steps`; the least of each is kept in `least`.
fn report(name: &str, session: &mut Session, least: &mut [f64]) -> String {
    (0..(0.1 / session.dt()).ceil() as usize).for_each(|_| session.step());
    let (steps, pause) = (least.len(), Duration::from_millis(setting("PAUSE")));
    let (mut work, mut iterations, mut residual) = ([0.0; 2], 0, 0.0_f64);
    let mut touching = 0;
    for least in &mut *least {
        if !pause.is_zero() {
            std::thread::sleep(pause);
        }
        session.step();
        let frame = session.frame();
        *least = least.min(frame.seconds);
        (0..2).for_each(|part| work[part] += frame.work[part]);
        iterations += frame.iterations;
        residual = residual.max(frame.residual);
        touching += usize::from(frame.tools[0].contact.is_some());
    }
    let mut seconds = least.to_vec();
    seconds.sort_by(f64::total_cmp);
    let mean = 1e3 * seconds.iter().sum::<f64>() / steps as f64;
    let [elements, solve] = work.map(|w| 1e3 * w / steps as f64);
    let bytes = session.bytes() as f64 / session.bodies[0].system.nodes.len() as f64;
    format!(
        "{name:44} {:8.3} ms, p99 {:8.3}; mean {mean:7.3}, of elements {elements:7.3}, solve {solve:7.3}; {:6.1} iterations, \
         residual {residual:.1e}, {} not converged; touched in {touching} of {steps}; {bytes:.0} bytes a vertex",
        1e3 * quantile(&seconds, 0.5),
        1e3 * quantile(&seconds, 0.99),
        iterations as f64 / steps as f64,
        session.events.count(EventKind::NotConverged),
    )
}

fn main() {
    let solver = std::env::var("SOLVER").unwrap_or_default();
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let is_wanted = |mesh: &&str| wanted.iter().flat_map(|w| w.split('|')).any(|w| w == *mesh);
    let mut meshes: Vec<&str> = MESHES.into_iter().filter(is_wanted).collect();
    if meshes.is_empty() {
        meshes.push(MESHES[0]);
    }
    for (mesh, (fabric, material)) in meshes.iter().flat_map(|mesh| FABRICS.iter().map(move |fabric| (mesh, fabric))) {
        for (motion, slides) in [("pressed", false), ("sliding", true)] {
            for (dt, time) in [("1ms", "dt = 0.001"), ("10ms", "dt = 0.01")] {
                for tolerance in ["1e-4", "1e-8"] {
                    for n in [16, 32, 64, 128, 256] {
                        for threads in [1, 2] {
                            let name = format!("{fabric} {motion} {n} {dt} {tolerance} {threads}-threads");
                            let name = if *mesh == MESHES[0] { name } else { format!("{mesh} {name}") };
                            let words: Vec<&str> = name.split(' ').chain([*mesh]).collect();
                            let usual =
                                ["generic", "pressed", "1ms", "1e-4"].iter().all(|w| words.contains(w)) && n < 256;
                            let all = wanted.iter().all(|w| w.split('|').any(|w| words.contains(&w)));
                            if if wanted.is_empty() { usual } else { all } {
                                let time =
                                    format!("{time}\n[solver]\ntolerance = {tolerance}\niterations = 20000\n{solver}");
                                let steps = if n > 64 { 100 } else { 200 };
                                let (mut least, mut text) = (vec![f64::INFINITY; steps], String::new());
                                for _ in 0..setting("REPEATS").max(1) {
                                    let mut session = pressed(n, mesh, material, &time, slides, threads);
                                    text = report(&name, &mut session, &mut least);
                                }
                                println!("{text}");
                            }
                        }
                    }
                }
            }
        }
    }
}
