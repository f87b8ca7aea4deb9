//! What may be typed, what comes out where, and with which exit code.

use pliant_tests::{Bench, box_scene};
use serde_json::Value;
use std::process::Stdio;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    bench
}

#[test]
fn help_and_version_go_to_standard_output() {
    let bench = Bench::new();
    let help = bench.pliant(&["--help"]).expect(0);
    for verb in ["run", "edit", "doctor", "plan", "plugin", "schema", "completions", "sample"] {
        assert!(help.out.contains(verb), "{}", help.out);
        let of_verb = bench.pliant(&[verb, "--help"]).expect(0);
        assert!(of_verb.out.contains("Usage: pliant") && of_verb.err.is_empty(), "{verb}");
    }
    assert_eq!(bench.pliant(&["--version"]).expect(0).out, concat!("pliant ", env!("CARGO_PKG_VERSION"), "\n"));
}

#[test]
fn wrong_usage_is_code_2_and_says_what_is_allowed() {
    let bench = bench();
    for (args, said) in [
        (&[][..], "Usage"),
        (&["walk"], "unrecognized subcommand"),
        (&["run"], "<SCENE>"),
        (&["run", "scene.toml", "--threads", "many"], "--threads"),
        (&["run", "scene.toml", "--set", "time.dt"], "allowed is PATH=VALUE"),
        (&["run", "scene.toml", "--speed", "3"], "--speed"),
        (&["completions", "tcsh"], "possible values: bash"),
        (&["sample", "dodo"], "possible values: elephant"),
        (&["sample", "--detail", "9"], "allowed: 1 to 5"),
        (&["plan", "nowhere.toml"], "nowhere.toml: cannot be read"),
        (&["plugin"], "Usage"),
    ] {
        let ran = bench.pliant(args).expect(2).says(&[said]);
        assert_eq!(ran.out, "", "{args:?}");
    }
    assert_eq!(bench.names("."), ["scene.toml"], "nothing was written");
}

#[test]
fn with_json_standard_output_is_one_document_and_nothing_else() {
    let bench = bench();
    let failing = box_scene("", "", "[[probe]]\nname = \"p\"\nquantity = \"force\"\nexpected = 1e6");
    bench.write("failing.toml", failing);
    for (args, code, key) in [
        (&["run", "scene.toml"][..], 0, "step_seconds"),
        (&["run", "failing.toml"], 1, "probes"),
        (&["plan", "scene.toml"], 0, "left_out"),
        (&["plugin", "list"], 0, "plugins"),
        (&["plugin", "info", "mass-spring"], 0, "plugins"),
        (&["schema"], 0, "properties"),
        (&["completions", "bash"], 0, "script"),
        (&["sample", "-o", "model.obj"], 0, "model"),
        (&["run", "nowhere.toml"], 2, "error"),
        (&["run"], 2, "error"),
        (&["plugin", "info", "nothing"], 3, "error"),
    ] {
        let ran = bench.pliant(&[args, &["--json"]].concat()).expect(code);
        let document = ran.json();
        assert!(document.get(key).is_some_and(|v| !v.is_null()), "{args:?}: no `{key}` in {document}");
        assert_eq!(document["exit_code"].as_i64().is_some_and(|c| c == i64::from(code)), code > 1, "{args:?}");
    }
}

#[test]
fn results_for_people_are_not_mixed_with_those_for_machines() {
    let bench = bench();
    let ran = bench.pliant(&["run", "scene.toml"]).expect(0).says(&["50 steps", "results are in out/scene"]);
    assert_eq!(ran.out, "");
    let quiet = bench.pliant(&["run", "scene.toml", "-q", "--out", "quiet"]).expect(0);
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
    assert_eq!(bench.names("quiet"), ["final.obj", "nodes.csv", "summary.json", "trace.csv"]);
    let plan = bench.pliant(&["plan", "scene.toml"]).expect(0);
    assert!(!plan.out.is_empty() && plan.err.is_empty());
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let bench = bench();
    for args in [
        &["schema"][..],
        &["completions", "zsh"],
        &["plugin", "list"],
        &["plan", "scene.toml"],
        &["run", "scene.toml", "--json"],
        &["--help"],
    ] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let told = bench.command(args).stdout(writer).stderr(Stdio::piped()).output().expect("starts");
        let err = String::from_utf8_lossy(&told.stderr).into_owned();
        assert!(told.status.code() == Some(0) && err.is_empty(), "{args:?}: {:?} {err}", told.status);
    }
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let told = bench.command(&["run", "scene.toml"]).stderr(writer).output().expect("starts");
    assert_eq!(told.status.code(), Some(0), "with nobody to read what is said for people");
}

#[test]
fn settings_take_the_place_of_what_the_scene_says() {
    let bench = bench();
    for (set, place, value) in [
        ("time.duration=20 ms", "/steps", Value::from(20)),
        ("time.dt=2ms", "/dt", Value::from(0.002)),
        ("time.integrator=backward-euler", "/choices/integrator", Value::from("backward-euler")),
        ("body.0.grid.level=4", "/bodies/0/level", Value::from(4)),
        ("body.0.name=\"stone\"", "/bodies/0/name", Value::from("stone")),
    ] {
        let args = ["plan", "scene.toml", "--json", "--set", set, "--set", "device.0.frame.body=block"];
        let args = if set.contains("name") {
            [&args[..5], &["--set", "device.0.frame.body=stone"]].concat()
        } else {
            args.to_vec()
        };
        assert_eq!(bench.pliant(&args).expect(0).json().pointer(place), Some(&value), "{set}");
    }
    for (set, said) in [
        ("body.7.name=x", "`body` has 1 entries, from 0: there is no 7"),
        ("body.name=x", "must be a number"),
        ("format.x=1", "has no `x`"),
        ("time.speed=1", "unknown field `speed`, expected one of `duration`"),
        ("time.dt=fast", "`fast` has no number before its unit; allowed is a time"),
        ("time.dt=-1", "dt is -1 s; allowed is a number above 0"),
        ("body.0.material.params.young=5 mm", "`5 mm` is a length; allowed is a pressure"),
    ] {
        bench.pliant(&["run", "scene.toml", "--set", set]).expect(2).says(&["scene.toml", "--set", said]);
    }
    assert_eq!(bench.names("."), ["scene.toml"], "nothing was written");
}

/// `pliant` beside a program of the window that does what a script says.
#[cfg(unix)]
fn doctor(bench: &Bench, script: Option<&str>, args: &[&str]) -> std::process::Output {
    let own = bench.path("pliant");
    install(&pliant_tests::program(), &own);
    if let Some(script) = script {
        install(&bench.write("window.sh", format!("#!/bin/sh\n{script}\n")), &bench.path("pliant-window"));
    }
    std::process::Command::new(own).arg("doctor").args(args).env("PATH", "/usr/bin:/bin").output().expect("it starts")
}

/// Copies a program, in a process of its own: a file this process had open for writing may be held open by a child
/// that another test's thread started meanwhile, and a program that is open for writing does not start (`ETXTBSY`).
#[cfg(unix)]
fn install(from: &std::path::Path, to: &std::path::Path) {
    let status = std::process::Command::new("install").args(["-m", "755"]).arg(from).arg(to).status();
    assert!(status.expect("`install` starts").success(), "{} was not copied", from.display());
}

#[test]
#[cfg(unix)]
fn doctor_says_what_the_window_draws_with_or_why_there_is_none() {
    let asked = "test \"$1\" = --renderer || exit 9";
    let no_display = format!("{asked}; echo 'error: there is no display: set DISPLAY' >&2; exit 2");
    for (script, code, said) in [
        (
            Some(format!("{asked}; echo 'llvmpipe (LLVM 19), OpenGL 4.5'")),
            0,
            "it draws with llvmpipe (LLVM 19), OpenGL 4.5",
        ),
        (Some(no_display), 1, "missing  window: there is no display: set DISPLAY"),
        (Some("exit 3".to_owned()), 1, "ended with code 3"),
        (Some("kill -9 $$".to_owned()), 1, "ended by"),
        (None, 1, "neither beside `pliant` nor on the path"),
    ] {
        let bench = Bench::new();
        let ran = doctor(&bench, script.as_deref(), &[]);
        let out = String::from_utf8(ran.stdout).expect("text");
        assert!(ran.status.code() == Some(code) && out.contains(said), "{script:?}: {} {out}", ran.status);
        assert!(out.contains("pliant device doctor"), "{out}");
        let json = doctor(&bench, script.as_deref(), &["--json"]);
        let json: Value = serde_json::from_slice(&json.stdout).expect("one document");
        let (key, text) = if code == 0 { ("renderer", "llvmpipe (LLVM 19), OpenGL 4.5") } else { ("missing", said) };
        let text = text.trim_start_matches("missing  window: ");
        assert!(json["window"][key].as_str().is_some_and(|found| found.contains(text)), "{script:?}: {json}");
    }
}
