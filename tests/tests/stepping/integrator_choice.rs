//! Explicit steps are chosen where they cost less than an implicit one.

use pliant_engine::session::{Choices, EventKind};
use pliant_tests::{box_scene, open};

const FINGER: &str = r#"
[[device]]
name = "hand"
params = { path = [[0, 0.1, 0.1, 0.2]] }
[[tool]]
name = "finger"
device = "hand"
radius = "8 mm"
[[edit]]
kind = "touch"
tool = "finger"
"#;

fn chosen(body: &str) -> Choices {
    let scene = format!("format = 1\n[time]\nduration = 0.1\ndt = \"1 ms\"\n[[body]]\n{body}\n{FINGER}");
    open(&scene, 1).choices.clone()
}

fn sheet(young: f64) -> Choices {
    chosen(&format!(
        "shape = {{ kind = \"sheet\", cells = 15, rows = 15, size = [0.2, 0.2, 0] }}\nsheet = {{ warp = [1, 0, 0] }}\n\
         material = {{ plugin = \"cloth\", params = {{ density = 0.15, young-warp = {young}, bending-warp = 1e-6 }} }}"
    ))
}

fn solid(plugin: &str, level: u32, young: f64) -> Choices {
    chosen(&format!(
        "shape = {{ kind = \"box\", size = [0.1, 0.1, 0.1] }}\ngrid = {{ plugin = \"octree-grid\", level = {level} }}\n\
         material = {{ plugin = \"{plugin}\", params = {{ young = {young}, density = 1000 }} }}"
    ))
}

#[test]
fn up_to_as_many_substeps_as_what_a_body_is_of_asks_for() {
    for (choices, span, few) in [
        (sheet(20.0), 2..=4, 4),
        (sheet(200.0), 5..=15, 4),
        (solid("corotational", 4, 1e5), 2..=4, 4),
        (solid("corotational", 4, 6e5), 5..=15, 4),
        (solid("neo-hookean", 4, 3e5), 5..=12, 12),
        (solid("neo-hookean", 4, 1e6), 13..=60, 12),
        (solid("mass-spring", 4, 1e6), 5..=12, 12),
        (solid("mass-spring", 5, 2e6), 17..=40, 12),
    ] {
        let numbers: Vec<usize> = choices.why.split(' ').filter_map(|word| word.parse().ok()).collect();
        let [up_to, substeps] = numbers[..] else { panic!("{}", choices.why) };
        assert!(up_to == few && span.contains(&substeps), "{}", choices.why);
        let is_explicit = substeps <= few;
        assert_eq!(choices.integrator, if is_explicit { "symplectic-euler" } else { "backward-euler" });
        assert_eq!(choices.substeps, if is_explicit { substeps } else { 1 });
    }
}

/// A contact that asks for more substeps than are allowed is reported: the step is over its limit.
#[test]
fn too_few_substeps_for_a_contact_are_told() {
    for (damping, is_told) in [(0.0, false), (50.0, true)] {
        let text = box_scene("integrator = \"symplectic-euler\"\nmost-substeps = 16", "", "")
            .replace("radius = \"4 mm\"", &format!("radius = \"4 mm\"\ndamping = {damping:?}"));
        let mut session = open(&text, 1);
        let mut touched = false;
        for _ in 0..30 {
            session.step();
            touched |= session.frame().tools[0].contact.is_some();
        }
        assert!(touched);
        let told = session.events.described().iter().find(|(kind, _)| *kind == EventKind::Unstable);
        assert_eq!(told.is_some(), is_told, "{damping} N s/m: {:?}", session.events.described());
        assert!(told.is_none_or(|(_, event)| event.text.contains("`block`") && event.text.contains("allowed is 16")));
    }
}
