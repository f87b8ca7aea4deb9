//! Libraries whose manifest says that cargo builds no tests or runs no examples of them have none: they would never be run.

use crate::crate_graph::{manifest, members, sources};
use pliant_tests::root;
use std::path::Path;
use toml::Table;

/// The sources of a crate, joined.
fn joined_sources(folder: &Path) -> String {
    let mut all = Vec::new();
    sources(folder, &mut all);
    all.iter().map(|source| std::fs::read_to_string(root().join(source)).expect("a source") + "\n").collect()
}

/// Whether documentation has an example that cargo would run: a block that opens with no language, or with Rust.
fn has_example(source: &str) -> bool {
    let documentation = source.lines().filter_map(|line| {
        let line = line.trim_start();
        line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))
    });
    let fences = documentation.filter_map(|line| line.trim_start().strip_prefix("```"));
    fences.step_by(2).any(|language| ["", "rust", "should_panic", "no_run", "compile_fail"].contains(&language.trim()))
}

/// What a library has that its manifest leaves out.
fn left_out(manifest: &Table, source: &str) -> Vec<&'static str> {
    let off = |key: &str| {
        let library = manifest.get("lib").and_then(|library| library.get(key));
        library.and_then(|value| value.as_bool()) == Some(false)
    };
    let tests = (off("test") && source.contains("#[test]")).then_some("tests, and `test = false`");
    let examples = (off("doctest") && has_example(source)).then_some("examples, and `doctest = false`");
    tests.into_iter().chain(examples).collect()
}

#[test]
fn what_cargo_does_not_build_has_no_tests_and_no_examples() {
    for (package, folder) in members() {
        let folder = root().join(folder);
        assert_eq!(left_out(&manifest(&folder), &joined_sources(&folder.join("src"))), [""; 0], "{package}");
    }
    let off: Table = "lib = { test = false, doctest = false }".parse().expect("TOML");
    let [test, example] = ["#[test]\nfn a() {}", "/// A number:\n/// ```\n/// let a = 1;\n/// ```\nfn a() {}"];
    assert_eq!(left_out(&off, test), ["tests, and `test = false`"]);
    assert_eq!(left_out(&off, example), ["examples, and `doctest = false`"]);
    assert_eq!(left_out(&off, "/// ```toml\n/// a = 1\n/// ```\nfn a() {}"), [""; 0]);
    assert_eq!(left_out(&Table::new(), &format!("{test}\n{example}")), [""; 0]);
}
