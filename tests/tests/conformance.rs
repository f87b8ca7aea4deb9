//! Every plugin of ours keeps every promise of the border, as a shared library, whatever its language.

use pliant_plugin_api::kit::{Kind, Verdict, cases};
use pliant_tests::library;

/// What does not hold, and what cannot be looked at.
fn judge(name: &str) -> (Vec<String>, Vec<String>) {
    let candidate = library(name).candidate(0);
    let kind = candidate.kind().expect("a kind of this version");
    let (mut failed, mut skipped) = (Vec::new(), Vec::new());
    for case in cases(kind) {
        match case.run(&candidate) {
            Verdict::Failed(why) => failed.push(format!("{name}: {}: {why}", case.name)),
            Verdict::Skipped(why) => skipped.push(format!("{name}: {}: skipped: {why}", case.name)),
            Verdict::Passed => {}
        }
    }
    (failed, skipped)
}

#[test]
fn our_plugins_conform() {
    for name in ["mass-spring", "neo-hookean", "corotational", "cloth", "octree-grid", "scripted"] {
        let (failed, skipped) = judge(name);
        skipped.iter().for_each(|line| println!("{line}"));
        assert!(failed.is_empty(), "\n{}\n", failed.join("\n"));
        // No allocator sees a library, an embedding may be linear, and `scripted` wants a path.
        assert!(name == "scripted" || skipped.len() <= 1, "{skipped:?}");
    }
}

#[test]
fn cases_have_names_of_their_own_and_a_sentence() {
    for kind in [Kind::Material, Kind::Grid, Kind::Device] {
        let cases = cases(kind);
        for (i, case) in cases.iter().enumerate() {
            assert!(cases[..i].iter().all(|c| c.name != case.name), "{}", case.name);
            assert!(case.promise.len() > 20 && !case.promise.ends_with('.'), "{}", case.name);
        }
    }
}
