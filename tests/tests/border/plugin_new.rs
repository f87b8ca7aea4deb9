//! The projects that `pliant plugin new` writes build without warnings, pass the conformance suite and run their scene, in all languages.

use pliant_tests::{Bench, program};
use std::path::Path;
use std::process::Command;

const KINDS: [&str; 4] = ["material", "grid", "device", "contact-law"];

/// Runs a command in a project and asserts that it succeeds.
fn run_in(folder: &Path, command: &mut Command) {
    let output = command.current_dir(folder).env("PLIANT", program()).output().expect("it starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}\n{}\n{}", folder.display(), text(&output.stdout), text(&output.stderr));
}

/// Asserts that the finger of the scene pressed into the block.
fn assert_pressed(bench: &Bench, name: &str) {
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
            run_in(&bench.path(&name), Command::new("make").arg("test"));
            run_in(&bench.path(&name), Command::new("make").arg("run"));
            assert_pressed(&bench, &name);
        }
    }
}

/// Parameters a user adds to the C material: a choice and a table, and what the scene must have set of them.
const MORE_PARAMS: [(&str, &str); 3] = [
    ("DAMPING_TIME, PARAMS", "DAMPING_TIME, MODEL, CURVE, PARAMS"),
    (
        "@NULL@, 0},\n};",
        r#"@NULL@, 0},
    {PLIANT_PARAM_CHOICE, "model", "1", "law of the springs", 0.0, 0.0, 0.0, "linear|tabled", 0},
    {PLIANT_PARAM_TABLE, "curve", "1", "points of the law", 0.0, 0.0, 0.0, "strain|stress", 0},
};"#,
    ),
    (
        "  (void)material;\n  return PLIANT_OK;",
        r#"  const table_rows *curve = &material->tables[CURVE];
  if (material->values[MODEL] == 0.0) return PLIANT_OK;
  if (curve->rows != 2 || curve->columns != 2 || curve->values[3] != 7.0)
    return fail(&material->plugin, PLIANT_BAD_ARGUMENT, "the curve has not come");
  return PLIANT_OK;"#,
    ),
];

#[test]
#[cfg_attr(not(unix), ignore = "needs make and a C compiler with the options of GNU and Clang")]
fn a_choice_and_a_table_can_be_added_to_a_c_project() {
    let bench = Bench::new();
    for (lang, null) in [("c", "NULL"), ("cpp", "nullptr")] {
        let name = format!("more-params-{lang}");
        bench.pliant(&["plugin", "new", &name, "--kind", "material", "--lang", lang]).expect(0);
        let source = bench.path(&format!("{name}/src/more_params_{lang}.{lang}"));
        let mut text = std::fs::read_to_string(&source).expect("the source");
        for (from, to) in MORE_PARAMS.map(|(from, to)| (from.replace("@NULL@", null), to.replace("@NULL@", null))) {
            assert_eq!(text.matches(&from).count(), 1, "{from}");
            text = text.replace(&from, &to);
        }
        std::fs::write(&source, text).expect("written");
        run_in(&bench.path(&name), Command::new("make").arg("test"));
        let with = |curve: &str| {
            let (scene, out) = (format!("{name}/scene.toml"), format!("{name}/out/scene"));
            let params = format!("body.0.material.params={{ model = \"tabled\", curve = {curve} }}");
            bench.pliant(&["run", &scene, "--plugin-path", &name, "--set", &params, "--out", &out])
        };
        with("[[0.0, 0.0], [1.0, 7.0]]").expect(0);
        assert_pressed(&bench, &name);
        with("[[0.0, 0.0], [1.0, 6.0]]").says(&["the curve has not come"]);
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
        run_in(&bench.path(&name), &mut cargo("test"));
        run_in(&bench.path(&name), &mut cargo("build"));
        let (scene, out) = (format!("{name}/scene.toml"), format!("{name}/out/scene"));
        bench.pliant(&["run", &scene, "--plugin-path", "target/debug", "--out", &out]).expect(0);
        assert_pressed(&bench, &name);
    }
}

#[test]
fn invalid_names_and_folders_are_refused() {
    let bench = Bench::new();
    for name in ["Upper", "two words", "9lives", "-dash", "a--b", "../out", ""] {
        bench.pliant(&["plugin", "new", "--kind", "grid", "--", name]).expect(2);
    }
    bench.write("taken/file", "");
    bench.pliant(&["plugin", "new", "taken", "--kind", "grid"]).expect(2).says(&["taken", "--out"]);
    let nowhere = ["plugin", "new", "fine", "--kind", "grid", "--pliant", "nowhere"];
    bench.pliant(&nowhere).expect(2).says(&["no plugin-api in nowhere", "--pliant DIR"]);
    assert_eq!(bench.names("fine"), [""; 0], "a refused project leaves no files");
}
