//! Every case of the conformance suite catches the plugin that was made to fail it, and that plugin fails no other.

use pliant_plugin_api::kit::{Candidate, CountingAllocator, Verdict, cases};
use pliant_tests::library;

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

/// (plugin, the one case it fails)
const TABLE: &[(&str, &str)] = &[
    ("mass-below-zero", "mass-is-positive"),
    ("pulls-at-rest", "rest-is-force-free"),
    ("energy-off", "force-is-energy-slope"),
    ("stiffness-off", "stiffness-is-force-slope"),
    ("single-off", "single-stiffness-is-the-stiffness"),
    ("damping-gains", "damping-dissipates"),
    ("knows-where", "translation-changes-nothing"),
    ("does-not-turn", "rotation-turns-the-force"),
    ("knows-order", "order-changes-nothing"),
    ("knows-range", "ranges-give-the-same-bytes"),
    ("remembers", "same-state-same-bytes"),
    ("shares", "instances-do-not-share"),
    ("divides-by-zero", "finite-at-extremes"),
    ("swallows-nan", "nan-is-reported"),
    ("hinge-slope-off", "coupled-strain-has-its-slope"),
    ("hinge-does-not-turn", "coupled-strain-turns"),
    ("compliance-indefinite", "compliance-is-definite"),
    ("normals-force-off", "normals-force-has-its-slope"),
    ("normals-slope-off", "normals-slope-has-its-slope"),
    ("normals-do-not-turn", "normals-turn"),
    ("normals-pull-at-rest", "normals-rest-is-force-free"),
    ("tilt-too-soft", "tilt-is-stiff-enough"),
    ("weights-too-large", "weights-sum-to-one"),
    ("weights-swapped", "affine-motion-is-exact"),
    ("pulls-back-more", "pull-back-is-the-transpose"),
    ("cells-askew", "cells-are-cubes"),
    ("region-outside", "region-is-part-of-the-body"),
    ("hides-surface", "surface-can-be-touched"),
    ("limits-upside-down", "limits-make-sense"),
    ("leaves-workspace", "poses-are-sound"),
    ("over-peak", "force-stays-in-limits"),
    ("ignores-stop", "stop-is-at-once"),
    ("never-expires", "stale-force-expires"),
    ("outlives-itself", "unplugged-is-silent"),
];

fn failed(candidate: &Candidate) -> Vec<&'static str> {
    let kind = candidate.kind().expect("a kind of this version");
    let fails = |case: &&pliant_plugin_api::kit::Case| matches!(case.run(candidate), Verdict::Failed(_));
    cases(kind).iter().filter(fails).map(|case| case.name).collect()
}

fn candidate(id: &str) -> Candidate {
    let library = library("faulty-plugins");
    let place = library.plugins().iter().position(|p| p.id == id).unwrap_or_else(|| panic!("no plugin `{id}`"));
    library.candidate(place)
}

#[test]
fn each_faulty_plugin_fails_its_case_and_no_other() {
    let wrong: Vec<String> = TABLE
        .iter()
        .map(|(id, case)| (id, case, failed(&candidate(id))))
        .filter(|(_, case, found)| found[..] != [**case])
        .map(|(id, case, found)| format!("{id}: {found:?} instead of [{case:?}]"))
        .collect();
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

#[test]
fn sound_plugins_fail_none() {
    for id in ["sound-springs", "sound-net", "sound-brick", "sound-finger"] {
        assert_eq!(failed(&candidate(id)), [""; 0], "{id}");
    }
}

/// Allocations are seen of a plugin that is linked in, by the counter of this program.
#[test]
fn allocation_is_seen_in_a_linked_plugin() {
    use faulty_plugins::{Net, Springs, fault};
    use pliant_plugin_api::AsMaterial;
    assert_eq!(failed(&Candidate::of::<AsMaterial<Springs<{ fault::ALLOCATES }>>>()), ["no-allocation-in-a-step"]);
    assert_eq!(failed(&Candidate::of::<AsMaterial<Net<{ fault::ALLOCATES }>>>()), ["no-allocation-in-a-step"]);
    assert_eq!(failed(&Candidate::of::<AsMaterial<Springs<{ fault::NONE }>>>()), [""; 0]);
    assert_eq!(failed(&Candidate::of::<AsMaterial<Net<{ fault::NONE }>>>()), [""; 0]);
}
