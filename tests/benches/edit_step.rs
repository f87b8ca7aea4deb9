//! A step of each kind of edit beside one of a touch: `cargo build --release && cargo bench -p pliant-tests --bench edit_step -- WHAT...`,
//! where WHAT filters `solid grab` and the like. Each stroke is made `REPEATS` times (3), kinds by turns, and the least of each step counts, for a
//! busy machine delays other steps each time. A `cut` draws a blade of 16 mm through the surface; `split` is the time of a split of what a blade has cut in two, beside the
//! median of the steps before it.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_engine::body::Division;
use pliant_engine::edit::KINDS;
use pliant_tests::{Bench, open_file};
use std::time::Instant;

/// Radius of every edit, m: three of its tool's.
const RADIUS: f64 = 0.015;
/// Steps of a stroke that count, from when the hand has pressed or pulled.
const COUNTED: std::ops::Range<usize> = 100..400;

/// What is edited: its name, its `[[body]]` and a place on it, m.
struct Subject {
    name: &'static str,
    body: &'static str,
    place: [f64; 3],
    /// `[body.grid] radius` of a touch that simulates as many cells as an edit does; nothing of bodies without a region.
    same_region: &'static str,
}

const SUBJECTS: [Subject; 3] = [
    Subject {
        name: "solid 6",
        body: "shape = { kind = \"sphere\", cells = 48, size = [0.1, 0.1, 0.1] }\ngrid = { level = 6REGION }\n\
               material = { plugin = \"neo-hookean\", params = { young = \"20 kPa\" } }",
        place: [0.0, 0.0, 0.05],
        same_region: ", radius = 0.04625",
    },
    Subject {
        name: "solid 7",
        body: "shape = { kind = \"sphere\", cells = 96, size = [0.1, 0.1, 0.1] }\ngrid = { level = 7REGION }\n\
               material = { plugin = \"neo-hookean\", params = { young = \"20 kPa\" } }",
        place: [0.0, 0.0, 0.05],
        same_region: ", radius = 0.035",
    },
    Subject {
        name: "sheet 64",
        body: "shape = { kind = \"sheet\", cells = 63, rows = 63, size = [0.2, 0.2, 0] }\nposition = [-0.1, -0.1, 0]\nsheet = {}\n\
               material = { plugin = \"cloth\" }\n[[body.fixed]]\nbox = [[-1, 0.0999, -1], [1, 1, 1]]",
        place: [0.0, 0.0, 0.0],
        same_region: "",
    },
];

/// Wall-clock times of the counted steps of a stroke, s, and the nodes that are active.
struct Stroke {
    seconds: Vec<f64>,
    nodes: usize,
}

fn stroke(subject: &Subject, kind: &str, region: &str) -> Stroke {
    if kind == "cut" {
        return run(subject, kind, region, &blade(subject));
    }
    let height = match kind {
        "pull" | "grab" => 0.004,
        "inflate" | "deflate" => 0.0,
        // A tip of 5 mm, 2 mm deep.
        _ => 0.003,
    };
    let [x, y, z] = subject.place;
    let path = format!(
        "[[0, {x}, {y}, {}], [0.02, {x}, {y}, {z}], [0.1, {x}, {y}, {}], [0.4, {}, {y}, {}]]",
        z + 0.006,
        z + height,
        x + 0.004,
        z + height
    );
    let tool = format!("path = {path}\nradius = {}", RADIUS / 3.0);
    run(subject, kind, region, &tool)
}

/// Path and tool of a blade that goes through the surface of a subject.
fn blade(subject: &Subject) -> String {
    let [x, y, z] = subject.place;
    let row = |time: f64, along: f64, height: f64| format!("[{time}, {}, {y}, {}]", x + along, z + height);
    let rows = [row(0.0, -0.008, 0.012), row(0.02, -0.008, 0.004), row(0.1, -0.006, 0.0), row(0.4, 0.008, 0.0)];
    format!("path = [{}]\nradius = 0.001\nblade = {{ length = \"16 mm\", direction = [0, 0, 1] }}", rows.join(", "))
}

/// A stroke with a tool, given by the path of its hand and its keys.
fn run(subject: &Subject, kind: &str, region: &str, tool: &str) -> Stroke {
    let (path, tool) = tool.split_once('\n').unwrap_or((tool, ""));
    let body = subject.body.replace("REGION", region);
    let keys = if matches!(kind, "touch" | "pull" | "cut") { String::new() } else { format!("radius = {RADIUS}") };
    let text = format!(
        r#"
        format = 1
        output = {{ energy = false }}
        [time]
        duration = 0.4
        [[body]]
        {body}
        [[device]]
        name = "hand"
        params = {{ peak-force = "20 N", {path} }}
        [[tool]]
        name = "finger"
        device = "hand"
        {tool}
        [[edit]]
        kind = "{kind}"
        tool = "finger"
        {keys}
        "#
    );
    let bench = Bench::new();
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    let (mut seconds, mut nodes) = (Vec::new(), 0);
    for step in 0..COUNTED.end {
        session.step();
        if COUNTED.contains(&step) {
            seconds.push(session.frame().seconds);
            nodes = nodes.max(session.frame().nodes);
        }
    }
    Stroke { seconds, nodes }
}

/// Time of a split of a ball that a blade has cut in two, and the median time of a step before it, s.
fn split() -> [f64; 2] {
    let text = r#"
        format = 1
        output = { energy = false }
        [time]
        duration = 0.4
        [[body]]
        shape = { kind = "sphere", cells = 48, size = [0.1, 0.1, 0.1] }
        grid = { level = 5, region = "whole" }
        material = { plugin = "neo-hookean", params = { young = "200 kPa" } }
        [[body.fixed]]
        ball = [0, 0, 0]
        radius = 0.01
        [[device]]
        name = "hand"
        params = { path = [[0, -0.06, 0.02, 0], [0.3, 0.06, 0.02, 0]] }
        [[tool]]
        name = "knife"
        device = "hand"
        radius = 0.001
        blade = { length = "120 mm", direction = [0, 0, 1] }
        [[edit]]
        kind = "cut"
        tool = "knife"
        end = 0.32
        "#;
    let bench = Bench::new();
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    let mut seconds: Vec<f64> = (0..350)
        .map(|_| {
            session.step();
            session.frame().seconds
        })
        .collect();
    seconds.drain(..320);
    seconds.sort_by(f64::total_cmp);
    let began = Instant::now();
    let parts = session.split(0, Division::EachPart).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(parts.len(), 2, "{:?}", session.events.described());
    [began.elapsed().as_secs_f64(), seconds[seconds.len() / 2]]
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let repeats = std::env::var("REPEATS").ok().and_then(|text| text.parse().ok()).unwrap_or(3);
    for subject in &SUBJECTS {
        let kinds = KINDS.iter().map(|kind| (kind.name(), ""));
        let same = Some(("touch", subject.same_region)).filter(|(_, region)| !region.is_empty());
        let cases: Vec<(&str, &str)> = same.into_iter().chain(kinds).collect();
        let is_asked = |kind: &str| words.iter().all(|word| format!("{} {kind}", subject.name).contains(word));
        let mut least: Vec<Option<Stroke>> = cases.iter().map(|_| None).collect();
        for _ in 0..repeats {
            for ((kind, region), least) in cases.iter().zip(&mut least).filter(|((kind, _), _)| is_asked(kind)) {
                let again = stroke(subject, kind, region);
                match least {
                    None => *least = Some(again),
                    Some(known) => {
                        for (known, again) in known.seconds.iter_mut().zip(again.seconds) {
                            *known = known.min(again);
                        }
                    }
                }
            }
        }
        for ((kind, region), stroke) in cases.iter().zip(least) {
            let Some(Stroke { mut seconds, nodes }) = stroke else { continue };
            let mean = 1e3 * seconds.iter().sum::<f64>() / seconds.len() as f64;
            seconds.sort_by(f64::total_cmp);
            let at = |share: f64| 1e3 * seconds[((seconds.len() - 1) as f64 * share) as usize];
            let name = format!("{} {kind}{}", subject.name, if region.is_empty() { "" } else { ", region of an edit" });
            println!("{name:40} {nodes:6} nodes; median {:.3}, mean {mean:.3}, 99th {:.3} ms", at(0.5), at(0.99));
        }
    }
    if words.iter().all(|word| "split".contains(word)) {
        let least = (0..repeats).map(|_| split()).fold([f64::INFINITY; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])]);
        println!("split of a ball at level 5: {:.2} ms; a step of it {:.2} ms", 1e3 * least[0], 1e3 * least[1]);
    }
}
