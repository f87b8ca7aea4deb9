//! The shipped plugins pass the conformance suite as shared libraries, whatever their language.

use pliant_plugin_api::kit::{Kind, Verdict, cases};
use pliant_tests::{Bench, library};

/// Cases about what a material may have, by what that is.
const SHEETS: &[&str] = &["curved-rest-is-force-free"];
const MEASURES: &[&str] = &["measure-scales-contributions"];
const SINGLE: &[&str] = &["single-precision-stiffness-matches"];
const ISOTROPY: &[&str] = &["axes-turn-with-the-shape-at-rest"];
const HISTORY: &[&str] = &["advance-dissipates", "advance-is-objective"];
const FAILURE: &[&str] = &["failure-follows-from-history"];
const DIRECTIONS: &[&str] =
    &["directions-turn-with-the-shape-at-rest", "directions-have-no-sign", "derivatives-hold-with-any-direction"];
const COUPLED: &[&str] = &["coupled-strain-gradient", "coupled-strain-is-objective", "compliance-is-positive-definite"];
const NORMALS: &[&str] = &[
    "normals-force-is-energy-gradient",
    "normals-derivative-is-energy-gradient",
    "normals-energy-is-objective",
    "normals-rest-is-force-free",
    "tilt-is-an-upper-bound",
];
/// Allocations of a library are not counted from outside.
const COUNTED: &[&str] = &["no-allocation-in-a-step"];
/// No material that is shipped wants whole lists, and memory is protected in a process of its own alone.
const MATERIALS: &[&str] = &["whole-lists-are-taken", PAGES];
const PAGES: &str = "pages-around-arrays-are-left-alone";
/// The grid's embedding is linear.
const EMBEDDING: &[&str] = &["pull-back-is-the-transpose"];
/// Cases of a device that is open: `scripted` needs a path, and `pen` a tablet.
const OPENED: &[&str] = &[
    "arrays-are-kept-to",
    "opens-with-defaults",
    "opens-many-times",
    "limits-are-valid",
    "poses-are-valid",
    "force-stays-within-limits",
    "stop-is-immediate",
    "stale-force-expires",
    "reopened-device-is-silent",
];

/// The shipped libraries, and the cases that are skipped for their plugins.
const SHIPPED: &[(&str, &[&[&str]])] = &[
    ("mass-spring", &[SHEETS, HISTORY, FAILURE, DIRECTIONS, COUPLED, NORMALS, COUNTED]),
    ("neo-hookean", &[SHEETS, FAILURE, DIRECTIONS, COUPLED, NORMALS, COUNTED]),
    ("fibre-reinforced", &[SHEETS, ISOTROPY, HISTORY, FAILURE, COUPLED, NORMALS, COUNTED]),
    ("corotational", &[SHEETS, SINGLE, HISTORY, FAILURE, DIRECTIONS, COUPLED, NORMALS, COUNTED]),
    ("cloth", &[MEASURES, FAILURE, DIRECTIONS, NORMALS, COUNTED]),
    ("tearing", &[MEASURES, SINGLE, DIRECTIONS, COUPLED, NORMALS, COUNTED]),
    ("quasi-brittle", &[SHEETS, DIRECTIONS, COUPLED, NORMALS, COUNTED]),
    ("contact-laws", &[COUNTED]),
    ("octree-grid", &[EMBEDDING]),
    ("scripted", &[OPENED]),
    ("pen", &[OPENED]),
];

#[test]
fn the_shipped_plugins_pass_the_conformance_suite() {
    for (name, about) in SHIPPED {
        for index in 0..library(name).plugins().len() {
            let candidate = library(name).candidate(index);
            let (mut failed, mut skipped) = (Vec::new(), Vec::new());
            for case in cases(candidate.kind().expect("a known kind")) {
                match case.run(&candidate) {
                    Verdict::Failed(why) => failed.push(format!("{name}: {}: {why}", case.name)),
                    Verdict::Skipped(_) => skipped.push(case.name),
                    Verdict::Passed => {}
                }
            }
            assert!(failed.is_empty(), "\n{}\n", failed.join("\n"));
            // What a library allocates is counted where a test links it.
            let mut expected = about.concat();
            expected.push("memory-is-given-back");
            if candidate.kind() == Some(Kind::Material) {
                expected.extend(MATERIALS);
            }
            skipped.sort_unstable();
            expected.sort_unstable();
            assert_eq!(skipped, expected, "{name}: skipped");
        }
    }
}

#[test]
#[cfg_attr(not(unix), ignore = "memory is protected on Unix alone")]
fn no_shipped_material_touches_memory_around_its_arrays() {
    let bench = Bench::new();
    let is_material = |name: &&str| library(name).candidate(0).kind() == Some(Kind::Material);
    for name in SHIPPED.iter().map(|(name, _)| *name).filter(is_material) {
        let ran = bench.pliant(&["plugin", "check", name, "--case", PAGES, "--json"]).expect(0).json();
        assert_eq!((&ran["ok"], &ran["skipped"]), (&1.into(), &0.into()), "{name}: {ran}");
    }
}

#[test]
fn cases_have_unique_names_and_a_sentence_each() {
    for kind in [Kind::Material, Kind::Grid, Kind::Device, Kind::ContactLaw] {
        let cases = cases(kind);
        for (i, case) in cases.iter().enumerate() {
            assert!(cases[..i].iter().all(|c| c.name != case.name), "{}", case.name);
            assert!(case.promise.len() > 20 && !case.promise.ends_with('.'), "{}", case.name);
        }
    }
}
