//! What a plugin does wrong stops its own body, by name, and nothing else.

use pliant_tests::{Bench, box_scene};

/// Two blocks that fall and are touched by nothing, the first of a faulty material.
fn scene(material: &str) -> String {
    let body = |name: &str, material: &str| {
        format!(
            r#"[[body]]
name = "{name}"
shape = {{ kind = "box", cells = 4, size = [0.04, 0.04, 0.04] }}
material = {{ plugin = "{material}" }}
grid = {{ level = 3, region = "whole" }}
"#
        )
    };
    format!(
        "format = 1\ngravity = [0, -9.81, 0]\n[time]\nduration = 0.05\npatience = \"1 s\"\n{}{}",
        body("faulty", material),
        body("sound", "mass-spring")
    )
}

#[test]
fn a_step_that_takes_too_long_stops_its_body_by_name_and_the_rest_goes_on() {
    let bench = Bench::new();
    bench.write("scene.toml", scene("faulty-plugins#takes-long"));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(3).says(&["takes-long", "patience"]);
    let summary = bench.summary("out");
    assert_eq!(summary["steps"], 50);
    let frozen = |i: usize| summary["bodies"][i]["frozen"].as_str().unwrap_or_default().to_owned();
    for said in ["takes-long", "patience", "allowed is 1 s"] {
        assert!(frozen(0).contains(said), "{}", frozen(0));
    }
    assert!(frozen(1).is_empty(), "{}", frozen(1));
    // The second has fallen as far as anything falls in n steps of a scheme that moves with the new speed: g dt^2 n (n + 1) / 2.
    let fall = 9.81 * 1e-6 * 0.5 * 50.0 * 51.0;
    let nodes = String::from_utf8(bench.read("out/nodes.csv")).expect("text");
    let rows: Vec<Vec<&str>> = nodes.lines().map(|row| row.split(',').collect()).collect();
    let fallen = |row: &Vec<&str>| row[3].parse::<f64>().expect("m") - row[6].parse::<f64>().expect("m");
    let sound: Vec<f64> = rows.iter().filter(|row| row[0] == "sound").map(fallen).collect();
    assert!(sound.len() == 125 && sound.iter().all(|d| (d / fall - 1.0).abs() < 1e-9), "{sound:?}");
    // As long as it is in time, nothing is wrong with it.
    let in_time = "body.0.material.params.after=1e3";
    bench.pliant(&["run", "scene.toml", "-q", "--out", "well", "--set", in_time]).expect(0);
}

#[test]
fn wild_parameters_are_refused_or_stop_their_body() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    for material in ["neo-hookean", "corotational"] {
        let run = |params: &str| {
            let plugin = format!("body.0.material={{ plugin = \"{material}\", params = {{ {params} }} }}");
            let time = ["--set", "time.duration=0.01", "--set", "time.integrator=backward-euler"];
            bench.pliant(&[&["run", "scene.toml", "-q", "--out", "out", "--set", &plugin][..], &time].concat())
        };
        for params in ["young = 1e-6", "young = 1e12", "poisson = 0.499", "density = 1e6", "damping-time = 10.0"] {
            run(params).expect(0);
            let csv = String::from_utf8(bench.read("out/trace.csv")).expect("text");
            assert!(!csv.contains("NaN") && !csv.contains("inf"), "{material}, {params}");
        }
        run("poisson = 0.5").expect(2).says(&["poisson", "0.499"]);
        run("young = -1.0").expect(2).says(&["young", "1e12"]);
    }
    let wild = "body.0.material={ plugin = \"faulty-plugins#divides-by-zero\", params = { after = 1e3 } }";
    let ran = bench.pliant(&["run", "scene.toml", "-q", "--out", "wild", "--set", wild, "--set", "time.duration=0.02"]);
    assert!([2, 3].contains(&ran.code), "{}: {}", ran.code, ran.err);
}
