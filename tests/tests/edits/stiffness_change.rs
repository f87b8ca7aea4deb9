//! The stiffness changes while a hand holds a body: the force goes to that of a body that was opened with the new stiffness, without a jump.

use pliant_engine::session::{Event, EventKind, Session, SessionCommand};
use pliant_tests::{box_scene, open};

/// Largest rate of change of the force on the hand in the scene, N/s.
const SLEW: f64 = 20.0;
/// Steps after which a press has come to rest.
const SETTLED: usize = 300;

/// A box, or a sheet, into which a finger is pressed and stays.
fn pressed(integrator: &str, material: &str) -> String {
    let text = box_scene(&format!("integrator = \"{integrator}\""), "", "")
        .replace("duration = 0.05", "duration = 4")
        .replace("level = 5", "level = 4")
        .replace("plugin = \"mass-spring\"", material)
        .replace(
            "[0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]",
            "[0.03, 0.0, 0.0, 0.002], [0.05, 0.0, 0.0, 0.002]",
        )
        .replace("radius = \"4 mm\"", &format!("radius = \"4 mm\"\nslew = {SLEW}"));
    assert!(text.contains("slew") && text.contains(material));
    text
}

/// Steps a session; returns the force (N) at the end and its largest change in a step (N).
fn settle(session: &mut Session, steps: usize) -> (f64, f64) {
    // Before the first step there is no frame.
    let force = |session: &Session| session.frame().tools.first().map(|tool| tool.force).unwrap_or_default();
    let (mut last, mut jump) = (force(session), 0.0_f64);
    for _ in 0..steps {
        session.step();
        jump = jump.max((force(session) - last).norm());
        last = force(session);
    }
    (last.norm(), jump)
}

#[test]
fn the_force_goes_without_a_jump_to_that_of_the_new_stiffness() {
    for (integrator, plugin) in
        [("symplectic-euler", "mass-spring"), ("backward-euler", "mass-spring"), ("backward-euler", "neo-hookean")]
    {
        for factor in [4.0, 0.25] {
            // An explicit integrator needs a substep for each decay time of the fastest mode.
            let damping = if integrator == "symplectic-euler" { 3e-4 } else { 2e-3 };
            let young =
                |young: f64| format!("plugin = \"{plugin}\", params = {{ young = {young}, damping-time = {damping} }}");
            let mut session = open(&pressed(integrator, &young(2e4)), 1);
            settle(&mut session, SETTLED);
            let (held, quiet) = settle(&mut session, 20);
            assert!(held > 0.02, "{plugin}: it is pressed with {held} N");
            assert!(session.apply(SessionCommand::SetStiffness { factor }));
            let (reached, jump) = settle(&mut session, SETTLED);
            let allowed = SLEW * session.dt() + quiet;
            assert!(
                jump <= allowed,
                "{integrator}, {plugin}, {factor}: a step changes the force by {jump} N, allowed {allowed} N"
            );
            assert!(jump > quiet, "it changes");
            let state = session.stiffness();
            assert!(state.now == factor && !state.is_limited, "{state:?}");
            let mut opened = open(&pressed(integrator, &young(2e4 * factor)), 1);
            let (expected, _) = settle(&mut opened, 2 * SETTLED);
            // Friction holds the finger a little elsewhere.
            let error = (reached / expected - 1.0).abs();
            assert!(error < 0.03, "{integrator}, {plugin}, {factor}: {reached} N, opened so {expected} N");
            assert!((expected / held).max(held / expected) > 1.3, "{held} N becomes {expected} N");
        }
    }
}

/// A force near the limit of the hand slows the change down; without a hand it takes 50 ms an octave.
#[test]
fn the_slew_of_the_hand_slows_the_change_down() {
    let material = "plugin = \"mass-spring\", params = { young = 4e4, damping-time = 2e-3 }";
    let slow = pressed("backward-euler", material).replace(&format!("slew = {SLEW}"), "slew = 1");
    let mut session = open(&slow, 1);
    settle(&mut session, SETTLED);
    session.apply(SessionCommand::SetStiffness { factor: 4.0 });
    session.step();
    assert!(session.stiffness().is_limited, "{:?}", session.stiffness());
    let steps = |session: &mut Session| {
        let before = session.steps();
        while session.stiffness().now != session.stiffness().wanted {
            session.step();
        }
        session.steps() - before
    };
    let held = steps(&mut session);
    let mut free = open(&slow.replace("kind = \"touch\"", "kind = \"touch\"\nstart = 3"), 1);
    free.apply(SessionCommand::SetStiffness { factor: 4.0 });
    let free = steps(&mut free);
    assert!((100..=101).contains(&free), "two octaves in {free} steps");
    assert!(held > 150, "{held} steps");
}

/// Elements that a region lists later, and those of a state that an undo brings back, have the new stiffness too.
#[test]
fn elements_that_come_later_have_the_new_stiffness() {
    let young = |young: f64| format!("plugin = \"mass-spring\", params = {{ young = {young}, damping-time = 2e-3 }}");
    let mut session = open(&pressed("backward-euler", &young(2e4)), 1);
    session.apply(SessionCommand::SetStiffness { factor: 3.0 });
    let (changed, _) = settle(&mut session, SETTLED);
    let (expected, _) = settle(&mut open(&pressed("backward-euler", &young(6e4)), 1), SETTLED);
    assert!((changed / expected - 1.0).abs() < 1e-3, "{changed} N, opened so {expected} N");
}

#[test]
fn a_sheet_becomes_stiffer_as_a_whole() {
    let text = pressed("backward-euler", "plugin = \"cloth\"")
        .replace("shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }", "shape = { kind = \"sheet\", cells = 12, rows = 12, size = [0.04, 0.04, 0] }")
        .replace("grid = { level = 4 }", "sheet = {}\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 0.0001, 1]]\n[[body.fixed]]\nbox = [[-1, 0.0399, -1], [1, 1, 1]]")
        .replace("frame = { body = \"block\", from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5] }", "frame = { origin = [0.02, 0.02, 0] }");
    let mut session = open(&text, 1);
    settle(&mut session, 300);
    let (held, quiet) = settle(&mut session, 20);
    session.apply(SessionCommand::SetStiffness { factor: 2.0 });
    let (reached, jump) = settle(&mut session, 300);
    assert!(jump <= SLEW * session.dt() + quiet, "{jump} N in a step");
    // The tip holds the sheet where it is, so twice the stiffness is twice the force.
    assert!((reached / held - 2.0).abs() < 0.05, "{held} N becomes {reached} N");
}

#[test]
fn an_explicit_integrator_gets_no_stiffness_that_its_substeps_do_not_follow() {
    let text = pressed("symplectic-euler", "plugin = \"mass-spring\", params = { young = 2e4, damping-time = 0 }")
        .replace("[time]", "[time]\nmost-substeps = 8");
    let mut session = open(&text, 1);
    session.apply(SessionCommand::SetStiffness { factor: 1000.0 });
    let wanted = session.stiffness().wanted;
    assert!(wanted > 1.0 && wanted < 900.0, "{wanted}");
    let allowed = format!("{wanted:.3}");
    let told = |(kind, event): &(EventKind, Event)| *kind == EventKind::Message && event.text.contains(&allowed);
    assert!(session.events.described().iter().any(told), "and the factor is said: {:?}", session.events.described());
    settle(&mut session, SETTLED);
    assert!(session.bodies.iter().all(|body| body.frozen.is_none()));
}
