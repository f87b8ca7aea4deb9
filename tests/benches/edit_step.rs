//! A step of each kind of edit beside one of a touch: `cargo build --release && cargo bench -p pliant-tests --bench edit_step -- WHAT...`,
//! where WHAT filters `solid grab` and the like. Each stroke is made `REPEATS` times (3), kinds by turns, and the least of each step counts, for a
//! busy machine delays other steps each time. Cuts are in `figures`.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_engine::edit::KINDS;
use pliant_tests::{Bench, open_file};

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
    let body = subject.body.replace("REGION", region);
    let keys = if kind == "touch" || kind == "pull" { String::new() } else { format!("radius = {RADIUS}") };
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
        params = {{ peak-force = "20 N", path = {path} }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = {}
        [[edit]]
        kind = "{kind}"
        tool = "finger"
        {keys}
        "#,
        RADIUS / 3.0
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

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let repeats = std::env::var("REPEATS").ok().and_then(|text| text.parse().ok()).unwrap_or(3);
    for subject in &SUBJECTS {
        let kinds = KINDS.iter().filter(|kind| !kind.cuts()).map(|kind| (kind.name(), ""));
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
}
