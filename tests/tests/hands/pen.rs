//! Strokes of a pen in a scene, from a recording of a tablet's events: they press by the pen's pressure, record and replay to the bit.

use pliant_tests::{Bench, box_scene};

/// The bytes of an event of the kernel at a time (ms).
fn event(milliseconds: usize, kind: u16, code: u16, value: i32) -> Vec<u8> {
    let time = [1000 + milliseconds / 1000, 1000 * (milliseconds % 1000)];
    let words = time.iter().flat_map(|word| word.to_ne_bytes());
    words.chain(kind.to_ne_bytes()).chain(code.to_ne_bytes()).chain(value.to_ne_bytes()).collect()
}

/// A pen that touches the middle of a tablet, presses harder up to `pressure` of 1000 within 60 ms, and goes away.
fn stroke(pressure: i32) -> Vec<u8> {
    let mut bytes = Vec::new();
    // The pen is near, at the middle.
    for (kind, code, value) in [(1, 0x140, 1), (3, 0, 500), (3, 1, 500), (0, 0, 0)] {
        bytes.extend(event(0, kind, code, value));
    }
    for step in 0..=12 {
        let touch = (1, 0x14a, 1);
        for (kind, code, value) in [touch, (3, 0x18, pressure * step / 12), (0, 0, 0)] {
            bytes.extend(event(20 + 5 * step as usize, kind, code, value));
        }
    }
    for (kind, code, value) in [(1, 0x14a, 0), (1, 0x140, 0), (0, 0, 0)] {
        bytes.extend(event(100, kind, code, value));
    }
    bytes
}

#[test]
fn a_pen_presses_by_its_pressure_and_its_stroke_replays() {
    let bench = Bench::new();
    let params = "params = { path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]] }";
    let pen = "plugin = \"pen\"\nparams = { device = \"pen.events\", x-max = 1000, y-max = 1000, pressure-max = 1000, depth = \"6 mm\" }";
    let scene = box_scene("", "", "button = 0").replace(params, pen).replace("duration = 0.05", "duration = 0.15");
    assert!(scene.contains("pen.events"));
    // The tablet lies on the upper face.
    let scene = scene.replace("from = [0.45, 0.55, 2.0]", "from = [0.45, 0.55, 1.1]");
    bench.write("scene.toml", scene);
    let force = |pressure: i32| {
        bench.write("pen.events", stroke(pressure));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "pen.rec"]).expect(0);
        bench.pliant(&["replay", "pen.rec", "--verify", "-q"]).expect(0);
        let summary = bench.summary("out");
        assert_eq!(summary["devices"]["hand"]["frames dropped"], 0, "{}", summary["devices"]);
        summary["largest_force"].as_f64().unwrap_or_else(|| panic!("{summary}"))
    };
    let [light, firm] = [300, 900].map(force);
    assert!(light > 0.01 && firm > 2.0 * light, "{light} N, {firm} N");
}
