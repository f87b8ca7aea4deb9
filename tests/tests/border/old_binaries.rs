//! Plugins built for earlier minor versions of the interface load, conform and run: one binary is kept for each version.
//!
//! `tests/old/material-1.0.so` is the C material of `pliant plugin new` as of interface 1.0, `material-1.1.so` that as of 1.1, each built with
//! its own Makefile and stripped. A new minor version adds a binary and removes none.

use pliant_host::Library;
use pliant_plugin_api::kit::{Verdict, cases};
use pliant_tests::{Bench, root};

#[test]
#[cfg_attr(
    not(all(target_os = "linux", target_arch = "x86_64")),
    ignore = "the old binaries are built for Linux on x86-64"
)]
fn old_binaries_load_conform_and_run() {
    for file in ["material-1.0.so", "material-1.1.so"] {
        let path = root().join("tests/old").join(file).canonicalize().unwrap_or_else(|e| panic!("{file}: {e}"));
        let library = Library::open(&path).unwrap_or_else(|e| panic!("{e}"));
        let candidate = library.candidate(0);
        for case in cases(candidate.kind().expect("a known kind")) {
            let verdict = case.run(&candidate);
            assert!(!matches!(verdict, Verdict::Failed(_)), "{file}: {}: {verdict:?}", case.name);
        }
        let bench = Bench::new();
        bench.write("scene.toml", pliant_tests::box_scene("", "", ""));
        let material = format!("body.0.material.plugin={}", path.display());
        let allowed = root().join("tests/old").display().to_string();
        let args = ["run", "scene.toml", "-q", "--out", "out", "--set", &material, "--allow-plugins", &allowed];
        bench.pliant(&args).expect(0);
        assert!(bench.summary("out")["largest_force"].as_f64() > Some(0.01), "{file}");
    }
}
