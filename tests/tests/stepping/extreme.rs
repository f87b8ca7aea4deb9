//! Values at the ends of what is allowed: the run ends well or refuses, and no file holds a number that is not finite.

use pliant_tests::{Bench, box_scene};
use serde_json::Value;

/// Runs the small scene with settings, and gives the summary.
fn run(text: &str, sets: &[&str]) -> (Bench, Value) {
    let bench = Bench::new();
    bench.write("scene.toml", text);
    let mut args = vec!["run", "scene.toml", "-q", "--out", "out"];
    sets.iter().for_each(|set| args.extend(["--set", set]));
    bench.pliant(&args).expect(0);
    bench.is_finite("out", &sets.join(" "));
    let summary = bench.summary("out");
    assert!(summary["bodies"][0].get("frozen").is_none(), "{sets:?}: {}", summary["events"]);
    (bench, summary)
}

/// A column of the trace.
fn column(bench: &Bench, name: &str) -> Vec<f64> {
    let trace = String::from_utf8(bench.read("out/trace.csv")).expect("UTF-8");
    let at = trace.lines().next().and_then(|head| head.split(',').position(|c| c == name)).expect("a column");
    trace.lines().skip(1).map(|row| row.split(',').nth(at).and_then(|c| c.parse().ok()).expect("a number")).collect()
}

fn largest(bench: &Bench, names: [&str; 3]) -> f64 {
    let [x, y, z] = names.map(|name| column(bench, name));
    (0..x.len()).fold(0.0, |most, i| (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt().max(most))
}

const ON_HAND: [&str; 3] = ["finger.device_force_x_N", "finger.device_force_y_N", "finger.device_force_z_N"];

#[test]
fn from_the_softest_to_the_stiffest_an_implicit_step_holds_and_an_explicit_one_refuses_in_time() {
    let text = box_scene("", "", "").replace("level = 5", "level = 4");
    for young in ["1e-2", "1e0", "1e2", "1e4", "1e6", "1e8", "1e10"] {
        let set = format!("body.0.material.params={{ young = {young} }}");
        // The far side of the block is held: at the stiffest, a push reaches it in more iterations than the default allows.
        let (bench, summary) = run(&text, &[&set, "time.integrator=backward-euler", "solver.iterations=400"]);
        assert!(largest(&bench, ON_HAND) <= 3.3 + 1e-9, "{young}");
        assert!(summary["event_counts"].get("not-converged").is_none(), "{young}: {summary}");
        let refused = ["run", "scene.toml", "-q", "--out", "explicit", "--set", &set, "--set"];
        let ran = bench.pliant(&[&refused[..], &["time.integrator=symplectic-euler"]].concat());
        assert_eq!(ran.code, if ["1e8", "1e10"].contains(&young) { 2 } else { 0 }, "{young}: {}", ran.err);
        match ran.code {
            0 => bench.is_finite("explicit", young),
            _ => drop(ran.expect(2).says(&["stable up to a step of", "substeps are more than the 64 allowed"])),
        }
    }
}

#[test]
fn steps_from_a_microsecond_to_a_second_hold_and_long_ones_are_remarked_on() {
    let text = box_scene("integrator = \"backward-euler\"", "", "");
    for (dt, duration, long) in
        [("1e-6", "2e-5", 0), ("1e-4", "5e-3", 0), ("0.05", "1", 0), ("0.06", "1", 1), ("1", "10", 1)]
    {
        let (dt, duration) = (format!("time.dt={dt}"), format!("time.duration={duration}"));
        let (_, summary) = run(&text, &[&dt, &duration]);
        assert_eq!(summary["event_counts"]["long-step"].as_u64().unwrap_or(0), long, "{dt}: {}", summary["events"]);
    }
}

#[test]
fn gravity_may_be_large_and_point_anywhere() {
    let held = "[[body.fixed]]\nbox = [[-1.0, -1.0, 0.019], [1.0, 1.0, 1.0]]\n[[device]]";
    let text = box_scene("", "", "").replace("[[device]]", held);
    for gravity in ["[0, 0, -981]", "[0, 0, 9.81]", "[9.81, 0, 0]", "[0, -9.81, 0]"] {
        for integrator in ["symplectic-euler", "backward-euler"] {
            let sets = [format!("gravity={gravity}"), format!("time.integrator={integrator}")];
            let whole = "body.0.grid={ level = 4, region = \"whole\" }";
            run(&text, &[&sets[0], &sets[1], whole, "edit=[]"]);
        }
    }
}

#[test]
fn a_hand_that_jumps_is_followed_at_its_speed_and_its_force_stays_within_limits() {
    for far in ["0.1", "1e6", "-1e6", "1e300"] {
        let path =
            format!("device.0.params={{ path = [[0, 0, 0, 0.006], [0.02, 0, 0, 0.006], [0.021, 0, 0, -{far}]] }}");
        let (bench, summary) = run(&box_scene("", "", ""), &[&path.replace("--", "")]);
        assert!(summary["event_counts"]["speed-limit"].as_u64() > Some(5), "{far}: {}", summary["event_counts"]);
        let z = column(&bench, "finger.hand_z_m");
        assert!(z.windows(2).all(|z| (z[1] - z[0]).abs() <= 2e-3 + 1e-12), "{far}");
        assert!(largest(&bench, ON_HAND) <= 3.3 + 1e-9, "{far}");
    }
    let stiff = ["tool.0.stiffness=1e9", "tool.0.slew=1e9", "body.0.material.params={ young = 1e9 }"];
    let (bench, summary) = run(&box_scene("integrator = \"backward-euler\"", "", ""), &stiff);
    let most = largest(&bench, ON_HAND);
    assert!(summary["event_counts"]["force-safety"].as_u64() > Some(0) && (most - 3.3).abs() < 1e-9, "{most} N");
}

#[test]
fn a_touch_on_held_nodes_is_felt_and_moves_nothing() {
    let held = "[[body.fixed]]\nbox = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]\n[[device]]";
    for (integrator, region) in
        [("symplectic-euler", "local"), ("backward-euler", "local"), ("symplectic-euler", "whole"), ("auto", "whole")]
    {
        let sets = [format!("time.integrator={integrator}"), format!("body.0.grid.region={region}")];
        let (bench, summary) = run(&box_scene("", "", "").replace("[[device]]", held), &[&sets[0], &sets[1]]);
        let (other, _) = run(&box_scene("", "", ""), &["edit=[]"]);
        assert!(summary["largest_force"].as_f64() > Some(0.05), "{integrator}: {summary}");
        assert!(bench.read("out/final.obj") == other.read("out/final.obj"), "{integrator}: nothing moved");
    }
}

#[test]
fn what_is_held_elsewhere_does_not_change_a_touch_nor_the_step_it_needs() {
    // The step limit is found around the model's first point; holding that corner must not hide how fast the rest is.
    let corner = "[[body.fixed]]\nbox = [[-1.0, -1.0, -1.0], [1.0, 1.0, 0.0]]\n[[device]]";
    let young = "body.0.material.params={ young = 1e5 }";
    let sets = [young, "body.0.grid.radius=8 mm"];
    let (free, all) = run(&box_scene("", "", ""), &sets);
    let (held, some) = run(&box_scene("", "", "").replace("[[device]]", corner), &sets);
    assert_eq!(all["choices"]["step_limit"], some["choices"]["step_limit"]);
    assert!(all["largest_force"].as_f64() > Some(0.05), "{all}");
    assert!(free.read("out/final.obj") == held.read("out/final.obj"));
}

#[test]
fn two_tips_on_one_place_or_on_opposite_sides_are_borne() {
    let second = |frame: &str| {
        format!(
            "[[device]]\nname = \"other\"\nframe = {{ body = \"block\", {frame} }}\n\
             params = {{ path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001]] }}\n\
             [[tool]]\nname = \"thumb\"\ndevice = \"other\"\nradius = \"4 mm\"\n\
             [[edit]]\nkind = \"touch\"\ntool = \"thumb\""
        )
    };
    for frame in [
        "from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5]",
        "from = [0.45, 0.55, -2.0], toward = [0.45, 0.55, 0.5]",
    ] {
        for integrator in ["symplectic-euler", "backward-euler"] {
            let set = format!("time.integrator={integrator}");
            let (bench, _) = run(&box_scene("", "", &second(frame)), &[&set]);
            assert!(largest(&bench, ON_HAND) > 0.01, "{frame}");
        }
    }
}

#[test]
fn grids_of_one_cell_and_of_very_many_and_flat_or_tiny_models_work() {
    for sets in [
        &["body.0.grid.level=1"][..],
        &["body.0.grid.level=2"],
        &["body.0.grid.level=9", "time.duration=0.01", "body.0.grid.radius=1 mm"],
        &["body.0.shape={ kind = \"box\", cells = 8, size = [0.04, 0.04, 1e-9] }"],
        &["body.0.shape={ kind = \"box\", cells = 1, size = [0.04, 0.04, 0.04] }"],
    ] {
        run(&box_scene("", "", ""), sets);
    }
    let bench = Bench::new();
    bench.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.write("scene.toml", box_scene("", "", ""));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--mesh", "one.obj"]).expect(0);
    bench.is_finite("out", "a single triangle");
}
