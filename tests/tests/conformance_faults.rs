//! For each case of the conformance suite there is a plugin with a fault that fails this case and no other.

use pliant_plugin_api::kit::{Candidate, CountingAllocator, Verdict, cases};
use pliant_tests::library;

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

/// Id of a faulty plugin, and the case it fails.
const FAULTS: &[(&str, &str)] = &[
    ("mass-below-zero", "mass-is-positive"),
    ("measure-ignored", "measure-scales-contributions"),
    ("pulls-at-rest", "rest-is-force-free"),
    ("keeps-rest-axes", "axes-turn-with-the-shape-at-rest"),
    ("hinge-flat-at-rest", "curved-rest-is-force-free"),
    ("energy-off", "force-is-energy-gradient"),
    ("stiffness-off", "stiffness-is-force-gradient"),
    ("weak-when-stretched", "force-is-energy-gradient-far-from-rest"),
    ("energy-off-with-parameter", "force-is-energy-gradient-with-any-parameter"),
    ("tangent-not-linear", "tangent-is-linear-in-its-factors"),
    ("static-scratch", "threads-do-not-interfere"),
    ("cuts-long-lists", "whole-lists-are-taken"),
    ("reads-past-nodes", "arrays-are-kept-to"),
    ("writes-past-nodes", "arrays-are-kept-to"),
    ("writes-past-planes", "planes-are-kept-to"),
    ("touches-other-nodes", "writes-stay-at-own-elements"),
    ("single-off", "single-precision-stiffness-matches"),
    ("damping-gains", "damping-dissipates"),
    ("damping-gains-when-fast", "damping-is-linear-in-velocity"),
    ("damps-turning", "rigid-motion-is-not-damped"),
    ("panics-in-advance", "no-call-panics"),
    ("depends-on-position", "translation-invariance"),
    ("not-objective", "rotation-invariance"),
    ("depends-on-order", "element-order-invariance"),
    ("depends-on-range", "ranges-are-bit-identical"),
    ("keeps-state", "results-are-deterministic"),
    ("shares-state", "instances-are-independent"),
    ("divides-by-zero", "finite-at-extremes"),
    ("swallows-nan", "nan-is-reported"),
    ("flow-gains", "advance-dissipates"),
    ("flow-not-objective", "advance-is-objective"),
    ("fails-by-position", "failure-follows-from-history"),
    ("field-ignored", "fields-scale-their-parameters"),
    ("field-of-neighbour", "fields-scale-their-parameters"),
    ("fibres-keep-axes", "directions-turn-with-the-shape-at-rest"),
    ("fibres-have-sign", "directions-have-no-sign"),
    ("fibres-ignored", "directions-have-no-sign"),
    ("oblique-fibres-off", "derivatives-hold-with-any-direction"),
    ("hinge-gradient-off", "coupled-strain-gradient"),
    ("hinge-not-objective", "coupled-strain-is-objective"),
    ("compliance-indefinite", "compliance-is-positive-definite"),
    ("normals-force-off", "normals-force-is-energy-gradient"),
    ("normals-derivative-off", "normals-derivative-is-energy-gradient"),
    ("normals-not-objective", "normals-energy-is-objective"),
    ("normals-pull-at-rest", "normals-rest-is-force-free"),
    ("tilt-too-soft", "tilt-is-an-upper-bound"),
    ("weights-too-large", "weights-sum-to-one"),
    ("weights-swapped", "affine-motion-is-exact"),
    ("pulls-back-more", "pull-back-is-the-transpose"),
    ("cells-distorted", "cells-are-cubes"),
    ("region-outside", "region-is-part-of-the-body"),
    ("hides-surface", "surface-cells-are-marked"),
    ("limits-reversed", "limits-are-valid"),
    ("leaves-workspace", "poses-are-valid"),
    ("over-peak", "force-stays-within-limits"),
    ("ignores-stop", "stop-is-immediate"),
    ("never-expires", "stale-force-expires"),
    ("keeps-force-when-reopened", "reopened-device-is-silent"),
    ("law-derivative-off", "derivatives-are-those-of-the-tractions"),
    ("law-acts-apart", "apart-there-is-no-traction"),
    ("law-attracts", "contact-does-not-attract"),
    ("law-friction-pushes", "friction-opposes-slip"),
    ("law-gains", "cycles-dissipate"),
    ("law-axes-differ", "tangent-axes-are-arbitrary"),
    ("law-depends-on-range", "ranges-are-bit-identical"),
    ("law-keeps-state", "results-are-deterministic"),
    ("law-static-scratch", "threads-do-not-interfere"),
    ("law-divides-by-zero", "finite-at-extremes"),
    ("law-hides-nan", "nan-is-reported"),
    ("law-writes-past", "arrays-are-kept-to"),
    ("weights-past", "arrays-are-kept-to"),
    ("pose-past", "arrays-are-kept-to"),
];

/// Names of the failed cases.
fn failed(candidate: &Candidate) -> Vec<&'static str> {
    let kind = candidate.kind().expect("a known kind");
    let fails = |case: &&pliant_plugin_api::kit::Case| matches!(case.run(candidate), Verdict::Failed(_));
    cases(kind).iter().filter(fails).map(|case| case.name).collect()
}

fn candidate(id: &str) -> Candidate {
    let library = library("faulty-plugins");
    let index = library.plugins().iter().position(|p| p.id == id).unwrap_or_else(|| panic!("no plugin `{id}`"));
    library.candidate(index)
}

#[test]
fn each_faulty_plugin_fails_its_case_and_no_other() {
    let wrong: Vec<String> = FAULTS
        .iter()
        .map(|(id, case)| (id, case, failed(&candidate(id))))
        .filter(|(_, case, found)| found[..] != [**case])
        .map(|(id, case, found)| format!("{id}: {found:?} instead of [{case:?}]"))
        .collect();
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

#[test]
fn sound_plugins_fail_no_case() {
    for id in [
        "sound-springs",
        "sound-clay",
        "sound-thread",
        "sound-fields",
        "sound-lists",
        "sound-net",
        "sound-fibres",
        "sound-listed-fibres",
        "sound-brick",
        "sound-finger",
        "sound-layer",
    ] {
        assert_eq!(failed(&candidate(id)), [""; 0], "{id}");
    }
}

/// Cases that are skipped for `sound-springs`, which has links, damping, and nothing else they are about.
const SKIPPED_FOR_SPRINGS: &[&str] = &[
    "memory-is-given-back",
    "curved-rest-is-force-free",
    "single-precision-stiffness-matches",
    "advance-dissipates",
    "advance-is-objective",
    "failure-follows-from-history",
    "fields-scale-their-parameters",
    "directions-turn-with-the-shape-at-rest",
    "directions-have-no-sign",
    "derivatives-hold-with-any-direction",
    "coupled-strain-gradient",
    "coupled-strain-is-objective",
    "compliance-is-positive-definite",
    "normals-force-is-energy-gradient",
    "normals-derivative-is-energy-gradient",
    "normals-energy-is-objective",
    "normals-rest-is-force-free",
    "tilt-is-an-upper-bound",
    "whole-lists-are-taken",
    "pages-around-arrays-are-left-alone",
    "no-allocation-in-a-step",
];

/// Cases that are skipped for `sound-net`, a sheet without damping, history and measures.
const SKIPPED_FOR_NET: &[&str] = &[
    "memory-is-given-back",
    "measure-scales-contributions",
    "single-precision-stiffness-matches",
    "damping-dissipates",
    "damping-is-linear-in-velocity",
    "rigid-motion-is-not-damped",
    "advance-dissipates",
    "advance-is-objective",
    "failure-follows-from-history",
    "fields-scale-their-parameters",
    "directions-turn-with-the-shape-at-rest",
    "directions-have-no-sign",
    "derivatives-hold-with-any-direction",
    "whole-lists-are-taken",
    "pages-around-arrays-are-left-alone",
    "no-allocation-in-a-step",
];

/// Names of the skipped cases.
fn skipped(candidate: &Candidate) -> Vec<&'static str> {
    let kind = candidate.kind().expect("a known kind");
    let skips = |case: &&pliant_plugin_api::kit::Case| matches!(case.run(candidate), Verdict::Skipped(_));
    cases(kind).iter().filter(skips).map(|case| case.name).collect()
}

#[test]
fn a_case_about_what_a_plugin_does_not_have_is_skipped() {
    assert_eq!(skipped(&candidate("sound-springs")), SKIPPED_FOR_SPRINGS);
    assert_eq!(skipped(&candidate("sound-net")), SKIPPED_FOR_NET);
}

/// Allocations can only be counted in a plugin that is linked into the program with the counting allocator.
#[test]
fn allocations_of_a_linked_plugin_are_found() {
    use faulty_plugins::{SpringMaterial, SpringSheet, StickingLayer, fault};
    use pliant_plugin_api::{AsContactLaw, AsMaterial};
    assert_eq!(
        failed(&Candidate::of::<AsMaterial<SpringMaterial<{ fault::ALLOCATES }>>>()),
        ["no-allocation-in-a-step"]
    );
    assert_eq!(failed(&Candidate::of::<AsMaterial<SpringSheet<{ fault::ALLOCATES }>>>()), ["no-allocation-in-a-step"]);
    assert_eq!(
        failed(&Candidate::of::<AsContactLaw<StickingLayer<{ fault::ALLOCATES }>>>()),
        ["no-allocation-in-a-step"]
    );
    assert_eq!(failed(&Candidate::of::<AsMaterial<SpringMaterial<{ fault::LEAKS }>>>()), ["memory-is-given-back"]);
    assert_eq!(failed(&Candidate::of::<AsContactLaw<StickingLayer<{ fault::NONE }>>>()), [""; 0]);
    assert_eq!(failed(&Candidate::of::<AsMaterial<SpringMaterial<{ fault::NONE }>>>()), [""; 0]);
    assert_eq!(failed(&Candidate::of::<AsMaterial<SpringSheet<{ fault::NONE }>>>()), [""; 0]);
}
