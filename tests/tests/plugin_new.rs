//! What `pliant plugin new` writes builds without a warning, keeps every promise and presses a shape as it is, in every
//! language.

use pliant_tests::{Bench, program};
use std::path::Path;
use std::process::Command;

const KINDS: [&str; 3] = ["material", "grid", "device"];

/// Runs a command in a project to a good end.
fn done(command: &mut Command, folder: &Path) {
    let told = command.current_dir(folder).env("PLIANT", program()).output().expect("it starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(told.status.success(), "{}\n{}\n{}", folder.display(), text(&told.stdout), text(&told.stderr));
}

/// The scene has pressed the block in.
fn is_pressed(bench: &Bench, name: &str) {
    let summary = bench.summary(&format!("{name}/out/scene"));
    let force = summary["probes"][0]["value"].as_f64().expect("a force");
    assert!(force > 1e-3 && force < 10.0, "{name}: {force} N");
}

#[test]
#[cfg_attr(not(unix), ignore = "needs make and a C compiler with the options of GNU and Clang")]
fn c_and_cpp_projects_build_conform_and_run() {
    let bench = Bench::new();
    for lang in ["c", "cpp"] {
        for kind in KINDS {
            let name = format!("own-{kind}-{lang}");
            bench.pliant(&["plugin", "new", &name, "--kind", kind, "--lang", lang]).expect(0);
            done(Command::new("make").arg("test"), &bench.path(&name));
            done(Command::new("make").arg("run"), &bench.path(&name));
            is_pressed(&bench, &name);
        }
    }
}

#[test]
fn rust_projects_build_conform_and_run() {
    let bench = Bench::new();
    let target = bench.path("target");
    for kind in KINDS {
        let name = format!("own-{kind}");
        bench.pliant(&["plugin", "new", &name, "--kind", kind]).expect(0);
        let cargo = |verb: &str| {
            let mut cargo = Command::new(env!("CARGO"));
            cargo.args([verb, "--offline"]).env("CARGO_TARGET_DIR", &target).env("RUSTFLAGS", "-D warnings");
            cargo
        };
        done(&mut cargo("test"), &bench.path(&name));
        done(&mut cargo("build"), &bench.path(&name));
        let (scene, out) = (format!("{name}/scene.toml"), format!("{name}/out/scene"));
        bench.pliant(&["run", &scene, "--plugin-path", "target/debug", "--out", &out]).expect(0);
        is_pressed(&bench, &name);
    }
}

#[test]
fn names_and_places_that_cannot_be_are_refused() {
    let bench = Bench::new();
    for name in ["Upper", "two words", "9lives", "-dash", "a--b", "../out", ""] {
        bench.pliant(&["plugin", "new", "--kind", "grid", "--", name]).expect(2);
    }
    bench.write("taken/file", "");
    bench.pliant(&["plugin", "new", "taken", "--kind", "grid"]).expect(2).says(&["taken", "--out"]);
    let nowhere = ["plugin", "new", "fine", "--kind", "grid", "--pliant", "nowhere"];
    bench.pliant(&nowhere).expect(2).says(&["no plugin-api in nowhere", "--pliant DIR"]);
    assert_eq!(bench.names("fine"), [""; 0], "nothing is left of a refusal");
}
