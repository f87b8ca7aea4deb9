//! The files a run leaves: which, what stands in them, and what of the model stays as it was.

use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::models::{elephant, moved_lines};
use pliant_tests::{Bench, box_scene};
use serde_json::Value;

/// An elephant whose flank is touched, or whose ear is pulled, for 0.1 s.
fn scene(edit: &str, path: &str, rest: &str) -> String {
    format!(
        r#"format = 1
title = "elephant"
[time]
duration = 0.1
[[body]]
name = "elephant"
mesh = "elephant.obj"
size = "100 mm"
material = {{ plugin = "mass-spring", params = {{ damping-time = "2 ms" }} }}
grid = {{ level = 5 }}
[[device]]
name = "hand"
frame = {{ body = "elephant", from = [1.5, 0.55, 0.45], toward = [0.5, 0.55, 0.45] }}
params = {{ interpolation = "smooth", path = {path} }}
[[tool]]
name = "finger"
device = "hand"
radius = "6 mm"
[[edit]]
tool = "finger"
{edit}
{rest}"#
    )
}

const TOUCH: &str = "[[0.0, 0.0, 0.0, 0.01], [0.04, 0.0, 0.0, 0.0], [0.08, 0.0, 0.0, 0.06]]";
const PULL: &str = "[[0.0, 0.0, 0.0, 0.005], [0.08, 0.0, 0.005, 0.02]]";

fn bench(scene: &str) -> Bench {
    let bench = Bench::new();
    bench.write("elephant.obj", elephant());
    bench.write("scene.toml", scene);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    bench
}

#[test]
fn an_edit_that_is_kept_changes_lines_of_vertices_and_normals_only() {
    let bench = bench(&scene("kind = \"pull\"\nrelease = \"keep\"", PULL, ""));
    let moved = moved_lines(elephant().as_bytes(), &bench.read("out/final.obj"));
    assert!(moved > 20, "{moved} lines");

    let windows = elephant().replace('\n', "\r\n");
    bench.write("elephant.obj", &windows);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "windows"]).expect(0);
    let after = String::from_utf8(bench.read("windows/final.obj")).expect("UTF-8");
    assert_eq!(moved_lines(windows.as_bytes(), after.as_bytes()), moved);
    assert!(after.replace("\r\n", "\n").as_bytes() == bench.read("out/final.obj"), "line ends change nothing else");
}

#[test]
fn a_touch_that_springs_back_leaves_the_model_byte_for_byte() {
    let text = scene("kind = \"touch\"\nend = 0.08", TOUCH, "").replace("duration = 0.1", "duration = 0.6");
    let bench = bench(&text);
    let summary = bench.summary("out");
    assert!(summary["contact_steps"].as_u64() > Some(10) && summary["largest_force"].as_f64() > Some(0.1), "{summary}");
    assert!(bench.read("out/final.obj") == elephant().as_bytes(), "it came back");

    let soon = ["run", "scene.toml", "-q", "--out", "soon", "--set", "time.duration=0.05"];
    bench.pliant(&soon).expect(0);
    assert!(moved_lines(elephant().as_bytes(), &bench.read("soon/final.obj")) > 20, "it was pressed");
}

#[test]
fn a_scene_without_an_edit_gives_the_model_back_byte_for_byte() {
    let text = scene("kind = \"touch\"", TOUCH, "").replace("[[edit]]\ntool = \"finger\"\nkind = \"touch\"\n", "");
    let bench = bench(&text);
    assert!(bench.read("out/final.obj") == elephant().as_bytes());
    assert_eq!(bench.summary("out")["loaded"], Value::Array(Vec::new()), "and nothing was opened for it");
}

const COLUMNS: &str = "time_s,finger.hand_x_m,finger.hand_y_m,finger.hand_z_m,finger.proxy_x_m,finger.proxy_y_m,\
    finger.proxy_z_m,finger.contact,finger.depth_m,finger.force_x_N,finger.force_y_N,finger.force_z_N,\
    finger.device_force_x_N,finger.device_force_y_N,finger.device_force_z_N,nodes,elements,kinetic_energy_J,\
    elastic_energy_J,substeps,iterations,residual,step_seconds";

#[test]
fn the_trace_has_a_row_a_step_and_the_nodes_a_row_a_node() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("integrator = \"backward-euler\"", "", ""));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    assert_eq!(bench.names("out"), ["final.obj", "nodes.csv", "summary.json", "trace.csv"]);
    let trace = String::from_utf8(bench.read("out/trace.csv")).expect("UTF-8");
    let (head, rows) = trace.split_once('\n').expect("rows");
    assert_eq!(head, COLUMNS);
    let contact = head.split(',').position(|c| c == "finger.contact").expect("there");
    for (i, row) in rows.lines().enumerate() {
        let cells: Vec<&str> = row.split(',').collect();
        assert_eq!(cells.len(), head.split(',').count(), "{row}");
        assert!(["", "touch"].contains(&cells[contact]), "{row}");
        let finite = |(at, cell): (usize, &&str)| at == contact || cell.parse::<f64>().is_ok_and(f64::is_finite);
        assert!(cells.iter().enumerate().all(finite), "{row}");
        assert!((cells[0].parse::<f64>().expect("a time") - 1e-3 * (i + 1) as f64).abs() < 1e-12);
    }
    let (steps, touched) = (rows.lines().count(), rows.lines().filter(|r| r.contains(",touch,")).count());
    let summary = bench.summary("out");
    assert_eq!((steps, Some(touched as u64)), (50, summary["contact_steps"].as_u64()));
    let nodes = String::from_utf8(bench.read("out/nodes.csv")).expect("UTF-8");
    let last = rows.lines().last().expect("a row").split(',').nth(15).expect("nodes");
    assert_eq!(nodes.lines().count() - 1, last.parse::<usize>().expect("a number"));
    assert!(
        nodes.starts_with("body,node,rest_x_m,rest_y_m,rest_z_m,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,mass_kg,constraint")
    );
}

#[test]
fn what_is_not_asked_for_is_not_written() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", "[output]\ntrace = false\nnodes = false\nframes = 100"));
    for (rate, frames) in [("100", 6), ("40", 3)] {
        let set = format!("output.frames={rate}");
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--set", &set]).expect(0);
        assert_eq!(bench.names("out"), ["final.obj", "frames", "summary.json"]);
        let names = bench.names("out/frames");
        assert_eq!(
            names,
            (0..frames).map(|i| format!("frame-{i:05}.obj")).collect::<Vec<_>>(),
            "and none of the run before"
        );
        assert_ne!(bench.read("out/frames/frame-00000.obj"), bench.read("out/frames/frame-00002.obj"));
    }
}

#[test]
fn every_summary_says_what_was_measured_where_and_with_what() {
    let bench = Bench::new();
    let probes = "[[probe]]\nname = \"most\"\nquantity = \"force\"\ngreatest = true\nexpected = 1.0\ntolerance = 0.9\n\
        source = \"a guess\"\n[[probe]]\nname = \"lift\"\nquantity = \"displacement\"\nat = [0.0, 0.0, 0.02]\ntime = 0.02";
    bench.write("scene.toml", box_scene("", "", probes));
    bench
        .pliant(&["run", "scene.toml", "-q", "--out", "out", "--set", "tool.0.radius=5 mm", "--threads", "1"])
        .expect(0);
    let summary = bench.summary("out");
    let text =
        |path: &str| summary.pointer(path).and_then(Value::as_str).unwrap_or_else(|| panic!("{path}: {summary}"));
    assert_eq!(text("/program"), concat!("pliant ", env!("CARGO_PKG_VERSION")));
    assert_eq!((text("/scene"), text("/settings/tool/0/radius")), ("scene.toml", "5 mm"));
    assert!(!text("/machine/cpu").is_empty() && text("/machine/system").contains(std::env::consts::ARCH));
    assert_eq!(summary["choices"]["threads"], 1);
    let [most, lift] = summary["probes"].as_array().expect("probes").as_slice() else { panic!("{summary}") };
    assert_eq!(
        (most["name"].as_str(), most["source"].as_str(), most["passed"].as_bool()),
        (Some("most"), Some("a guess"), Some(true))
    );
    assert_eq!(most["value"], summary["largest_force"]);
    assert!(lift["passed"].is_null() && (lift["time"].as_f64().expect("a time") - 0.02).abs() < 1e-9);
    bench.pliant(&["run", "scene.toml", "--out", "off", "--set", "probe.0.expected=100.0"]).expect(1);
    assert_eq!(bench.summary("off")["probes"][0]["passed"], false);
    let quiet = ["run", "scene.toml", "-q", "--out", "off", "--set", "probe.0.expected=100.0"];
    let quiet = bench.pliant(&quiet).expect(1).says(&["probe most", "FAILED"]);
    assert_eq!(quiet.err.lines().count(), 1, "the check that failed and nothing else: {}", quiet.err);
    assert_eq!(bench.summary("off")["probes"][0]["passed"], false);
}

/// Along three axes at right angles, in random orientations, the squares of the components add up to that of the length; the opposite direction has the opposite sign.
#[test]
fn probes_measure_components_along_a_direction() {
    let bench = Bench::new();
    let random = &mut Random(5);
    for _ in 0..6 {
        let (first, other) = (random.direction(), random.direction());
        let second = first.cross(&other).normalize();
        let third = first.cross(&second);
        let directions = [first, second, third, -third].map(|axis| axis * (0.1 + 5.0 * random.unit()));
        let mut probes = String::new();
        for quantity in ["force", "displacement"] {
            for direction in [None].into_iter().chain(directions.iter().map(Some)) {
                let along = direction.map_or(String::new(), |d| format!("direction = [{}, {}, {}]", d.x, d.y, d.z));
                probes +=
                    &format!("[[probe]]\nname = \"p\"\nquantity = \"{quantity}\"\nat = [0.0, 0.0, 0.02]\n{along}\n");
            }
        }
        bench.write("scene.toml", box_scene("", "", &probes));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
        let summary = bench.summary("out");
        let values: Vec<f64> = summary["probes"]
            .as_array()
            .expect("probes")
            .iter()
            .map(|p| p["value"].as_f64().expect("a value"))
            .collect();
        for of in values.chunks(5) {
            let &[length, a, b, c, opposite] = of else { panic!("{values:?}") };
            assert!(length > 0.0, "{values:?}");
            assert!((Vec3::new(a, b, c).norm() - length).abs() < 1e-12 * length, "{values:?}");
            assert!((c + opposite).abs() < 1e-12 * length, "{values:?}");
        }
    }
}
