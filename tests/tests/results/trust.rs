//! A scene or a recording runs no code that the user has not allowed: a library that it names by path is not opened.
//!
//! The library that is named leaves a mark when it is opened. Each route is tried without permission, and with it: there the mark shows that
//! the route leads to the library at all.

#![cfg(unix)]

use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session};
use pliant_host::{AllowedFolders, SearchPath};
use pliant_tests::batch::{small_scene, small_sweep};
use pliant_tests::native::file_name;
use pliant_tests::{Bench, Ran, box_scene, built, deps, root};
use std::path::{Path, PathBuf};

/// A library whose constructor creates the file `$PLIANT_TEST_MARK`.
const MARKING: &str = r#"
#include <stdio.h>
#include <stdlib.h>
__attribute__((constructor)) static void mark(void) {
  const char *path = getenv("PLIANT_TEST_MARK");
  FILE *file = path ? fopen(path, "w") : NULL;
  if (file) fclose(file);
}
"#;

/// A folder with the marking library in `theirs`.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.compile("theirs", "evil", MARKING);
    bench
}

fn evil() -> String {
    format!("./theirs/{}", file_name("evil"))
}

/// Runs `pliant` and gives whether the library was opened as well.
fn run(bench: &Bench, args: &[&str]) -> (Ran, bool) {
    let mark = bench.path("mark");
    let ran = bench.pliant_with(args, &[("PLIANT_TEST_MARK", mark.to_str().expect("UTF-8"))]);
    (ran, std::fs::remove_file(mark).is_ok())
}

/// Tries a route without permission, with that for another folder, and with that for the library's.
fn check_route(bench: &Bench, args: &[&str]) {
    let refusal = |args: &[&str]| {
        let (ran, opened) = run(bench, args);
        assert!(!opened && ran.code != 0, "{args:?} opened the library, or passed: {}\n{}", ran.code, ran.err);
        ran
    };
    let ran = refusal(args);
    let told = format!("{}{}", ran.out, ran.err);
    assert!(told.contains("evil") && told.contains("--allow-plugins"), "{args:?}:\n{told}");
    std::fs::create_dir_all(bench.path("elsewhere")).expect("a folder");
    refusal(&[args, &["--allow-plugins", "elsewhere"]].concat());
    let (ran, opened) = run(bench, &[args, &["--allow-plugins", "elsewhere", "--allow-plugins", "theirs"]].concat());
    assert!(opened, "{args:?}: with permission it is opened\n{}", ran.err);
}

/// The scene of [`box_scene`] with `old` replaced.
fn altered(old: &str, new: &str) -> String {
    let text = box_scene("", "", "");
    assert!(text.contains(old), "{old} in {text}");
    text.replacen(old, new, 1)
}

/// Scenes that name the library as a material, a grid and a device.
fn scenes() -> [String; 3] {
    [
        altered("\"mass-spring\"", &format!("\"{}\"", evil())),
        altered("grid = {", &format!("grid = {{ plugin = \"{}#x\",", evil())),
        altered("name = \"hand\"", &format!("name = \"hand\"\nplugin = \"{}\"", evil())),
    ]
}

#[test]
fn no_verb_opens_a_library_that_a_scene_names_by_path() {
    let bench = bench();
    for text in scenes() {
        bench.write("scene.toml", text);
        check_route(&bench, &["plan", "scene.toml"]);
        check_route(&bench, &["run", "scene.toml", "-q", "--out", "out"]);
    }
    check_route(&bench, &["run", "scene.toml", "-q", "--out", "out", "--isolate"]);
    check_route(&bench, &["run", "scene.toml", "-q", "--out", "out", "--live"]);
    let report = ["report", "accuracy", "--scene", "scene.toml", "-q", "--quick", "--out", "report"];
    check_route(&bench, &report);
}

#[test]
fn the_refusal_names_file_and_line() {
    let bench = bench();
    let [text, ..] = scenes();
    let line = 1 + text.lines().position(|line| line.contains("evil")).expect("there");
    bench.write("scene.toml", text);
    let (ran, _) = run(&bench, &["plan", "scene.toml"]);
    ran.expect(2).says(&[&format!("scene.toml:{line}:"), "evil", "--allow-plugins"]);
    let (ran, _) = run(&bench, &["plan", "scene.toml", "--allow-plugins", "nowhere"]);
    ran.expect(2).says(&["nowhere", "--allow-plugins"]);
}

#[test]
fn a_link_does_not_lead_out_of_an_allowed_folder() {
    let bench = bench();
    std::fs::create_dir(bench.path("mine")).expect("a folder");
    let link = bench.path("mine").join(file_name("evil"));
    std::os::unix::fs::symlink(bench.path("theirs").join(file_name("evil")), link).expect("a link");
    let [text, ..] = scenes();
    bench.write("scene.toml", text.replace("./theirs", "./mine"));
    for folder in ["mine", "mine/../mine"] {
        let (ran, opened) = run(&bench, &["plan", "scene.toml", "--allow-plugins", folder]);
        assert!(!opened, "{}", ran.expect(2).err);
    }
}

#[test]
fn an_edit_of_a_batch_fails_and_opens_nothing() {
    let bench = bench();
    bench.write("sweep.toml", small_sweep(1, ""));
    bench.write("scene.toml", small_scene().replacen("\"mass-spring\"", &format!("\"{}\"", evil()), 1));
    for (extra, out) in [(&[][..], "a"), (&["--isolate"][..], "b")] {
        let args = [&["batch", "sweep.toml", "-q", "--out", out], extra].concat();
        let (_, opened) = run(&bench, &args);
        assert!(!opened, "{args:?}");
        let allowed = [&args[..], &["--resume", "--retry-failed", "--allow-plugins", "theirs"]].concat();
        let (ran, opened) = run(&bench, &allowed);
        assert!(opened, "{allowed:?}: {}", ran.err);
    }
}

#[test]
fn a_recording_opens_no_library_by_path() {
    let bench = bench();
    let plugin = format!("./theirs/{}", file_name("pliant_mass_spring"));
    std::fs::copy(built(&file_name("pliant_mass_spring")), bench.path(&plugin)).expect("copied");
    bench.write("scene.toml", altered("\"mass-spring\"", &format!("\"{plugin}\"")));
    let record = ["run", "scene.toml", "-q", "--out", "out", "--record", "hand.rec"];
    bench.pliant(&[&record[..], &["--allow-plugins", "theirs"]].concat()).expect(0);
    // What was a plugin when it was recorded is another library now.
    std::fs::rename(bench.path(&evil()), bench.path(&plugin)).expect("replaced");
    let (ran, opened) = run(&bench, &["replay", "hand.rec", "-q"]);
    assert!(!opened, "{}", ran.err);
    ran.expect(2).says(&["--allow-plugins"]);
    assert!(run(&bench, &["replay", "hand.rec", "-q", "--allow-plugins", "theirs"]).1);
}

#[test]
fn a_parameter_hands_no_library_to_a_plugin() {
    let bench = bench();
    let text = std::fs::read_to_string(root().join("scenes/phantom-touch.toml")).expect("read");
    let text = text.replace("elephant.obj", root().join("scenes/elephant.obj").to_str().expect("UTF-8"));
    // A library is known by its bytes: its name means nothing to the linker.
    std::fs::copy(bench.path(&evil()), bench.path("theirs/evil.csv")).expect("copied");
    for file in [evil(), "./theirs/evil.csv".to_owned()] {
        let set = format!("device.0.params.library=\"{file}\"");
        bench.write("scene.toml", &text);
        let (ran, opened) = run(&bench, &["plan", "scene.toml", "--set", &set]);
        assert!(!opened, "{}", ran.err);
        ran.expect(2).says(&["evil", "--allow-plugins"]);
        assert!(run(&bench, &["plan", "scene.toml", "--set", &set, "--allow-plugins", "theirs"]).1);
    }
}

#[test]
fn a_caller_of_the_engine_allows_nothing_unless_it_says_so() {
    let bench = bench();
    let [text, ..] = scenes();
    let path = bench.write("scene.toml", text);
    let open = |search: SearchPath| {
        let (scene, source) = scene::load(&path, &[]).expect("read");
        let plan = Plan::new(&scene, &source).expect("planned");
        let options = Options::new(search, 1);
        Session::open(&scene, &source, plan, &options).err().expect("it is no plugin").to_string()
    };
    let search = SearchPath::new(&[deps()]);
    assert!(open(search.clone()).contains("--allow-plugins"));
    let allowed = AllowedFolders::new(&[bench.path("theirs")]).expect("a folder");
    assert!(open(search.allow(allowed)).contains("pliant_entry"), "it was opened");
}

#[test]
fn what_the_command_line_names_is_opened() {
    let bench = bench();
    for args in [["plugin", "info"], ["plugin", "check"]] {
        assert!(run(&bench, &[&args[..], &[&evil()]].concat()).1, "{args:?}");
    }
    let plugin = built(&file_name("pliant_mass_spring"));
    bench.pliant(&["plugin", "info", plugin.to_str().expect("UTF-8"), "--json"]).expect(0);
}

/// Whether `plugin list` opens the library of this folder of the environment.
fn is_listed(bench: &Bench, folder: &Path) -> (bool, String) {
    let mark = bench.path("mark");
    let environment = [("PLIANT_TEST_MARK", mark.as_path()), ("PLIANT_PLUGIN_PATH", folder)];
    let environment = environment.map(|(key, path)| (key, path.to_str().expect("UTF-8")));
    let ran = bench.pliant_with(&["plugin", "list"], &environment);
    let opened = std::fs::remove_file(&mark).is_ok();
    let by_name = bench.pliant_with(&["plugin", "info", "evil"], &environment);
    assert_eq!(std::fs::remove_file(&mark).is_ok(), opened, "list and info agree: {}", by_name.err);
    (opened, ran.err)
}

fn set_mode(path: &Path, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).expect("rights are set");
}

#[test]
fn folders_of_the_environment_that_others_can_write_are_not_searched() {
    let bench = bench();
    let folder = bench.path("theirs");
    let (opened, told) = is_listed(&bench, &folder);
    assert!(opened, "a folder of the user's own is searched: {told}");
    for relative in [".", "theirs", "./theirs"] {
        let (opened, told) = is_listed(&bench, Path::new(relative));
        assert!(!opened && told.contains("relative") && told.contains("PLIANT_PLUGIN_PATH"), "{relative}: {told}");
    }
    // In a folder that others can write to, and below one.
    for mode in [0o777, 0o1777, 0o722] {
        set_mode(&folder, mode);
        let (opened, told) = is_listed(&bench, &folder);
        assert!(!opened && told.contains("other users"), "{mode:o}: {told}");
    }
    set_mode(&folder, 0o755);
    std::fs::create_dir_all(bench.path("open/below")).expect("a folder");
    std::fs::copy(bench.path(&evil()), bench.path("open/below").join(file_name("evil"))).expect("copied");
    set_mode(&bench.path("open"), 0o777);
    assert!(!is_listed(&bench, &bench.path("open/below")).0);
    // A library that others can write to, in a folder that they cannot.
    set_mode(&bench.path(&evil()), 0o766);
    assert!(!is_listed(&bench, &folder).0);
}

#[test]
fn the_users_own_folder_needs_no_option_unless_others_can_write_to_it() {
    let bench = bench();
    let own: PathBuf = bench.path("nobody/pliant/plugins");
    std::fs::create_dir_all(&own).expect("a folder");
    std::fs::copy(bench.path(&evil()), own.join(file_name("evil"))).expect("copied");
    bench.write("scene.toml", box_scene("", "", ""));
    let args = ["plan", "scene.toml", "--set", "body.0.material.plugin=evil"];
    assert!(run(&bench, &args).1);
    set_mode(&own, 0o777);
    let (ran, opened) = run(&bench, &args);
    assert!(!opened && ran.err.contains("other users"), "{}", ran.err);
}
