//! A hand that gives way, in a closed loop with a simulation: what it feels, and that it is safe whatever the simulation does.

use pliant_engine::session::{Session, SessionCommand};
use pliant_engine::tool::Cause;
use pliant_live::HandSamples;
use pliant_solver::Vec3;
use pliant_tests::arm::ArmModel;
use pliant_tests::bout::Bout;
use pliant_tests::{box_scene, open};

/// A cube of 40 mm held at its bottom, whole, under a finger of 4 mm in its middle.
fn block(material: &str, tool: &str) -> Session {
    let scene = format!(
        r#"
        format = 1
        [time]
        duration = 100
        integrator = "backward-euler"
        [solver]
        tolerance = 1e-9
        [[body]]
        name = "block"
        shape = {{ kind = "box", cells = 8, size = [0.04, 0.04, 0.04] }}
        material = {{ plugin = {material} }}
        grid = {{ level = 4, region = "whole" }}
        fixed = [{{ box = [[-1, -1, -1], [1, 1, -0.019]] }}]
        [[device]]
        name = "hand"
        frame = {{ body = "block", from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5] }}
        params = {{ path = [[0, 0, 0, 0.01]] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "4 mm"
        {tool}
        [[edit]]
        kind = "touch"
        tool = "finger"
        "#
    );
    open(&scene, 1)
}

const SOFT: &str = r#""mass-spring", params = { young = "20 kPa", damping-time = "5 ms" }"#;

/// Down to `depth` (m) below where a finger of 4 mm touches, within a second, and there.
fn press(depth: f64) -> ArmModel {
    ArmModel::desktop(move |t| Vec3::new(0.0, 0.0, 0.01 - (0.006 + depth) * t.min(1.0)))
}

/// N, what holds the fixed nodes of the first body: by the balance of all forces, what is felt.
fn held(session: &Session) -> Vec3 {
    session.reactions(0).iter().sum()
}

#[test]
fn the_device_gives_what_the_body_is_held_with() {
    for every in [1, 4] {
        let mut bout = Bout::new(block(SOFT, ""), vec![press(4e-3)]);
        bout.run(4000, every);
        let (given, held) = (bout.arm(0).force, held(&bout.session));
        assert!(given.norm() > 0.1, "{given:?} N");
        let off = (given - held).norm() / held.norm();
        assert!(off < 0.01, "a step in {every} ticks: {given:?} N given, {held:?} N held: {off}");
        bout.forces_are_safe(0, 500.0);
    }
}

/// A sheet held at its border, with edges shorter than half of the tips, and tools.
fn sheet(tools: &str) -> Session {
    let sides = "[[-1, -1, -1], [1e-6, 1, 1]] }, { box = [[0.199999, -1, -1], [1, 1, 1]]";
    let scene = format!(
        r#"
        format = 1
        [time]
        duration = 100
        integrator = "backward-euler"
        [solver]
        tolerance = 1e-8
        [[body]]
        name = "cloth"
        shape = {{ kind = "sheet", cells = 30, size = [0.2, 0.2, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        material = {{ plugin = "cloth", params = {{ fabric = "denim" }} }}
        fixed = [{{ box = {sides} }}]
        {tools}
        "#
    );
    open(&scene, 1)
}

fn finger(name: &str, height: &str) -> String {
    format!(
        r#"
        [[device]]
        name = "{name}"
        params = {{ path = [[0, 0.1, 0.1, {height}]] }}
        [[tool]]
        name = "{name} tip"
        device = "{name}"
        radius = "15 mm"
        [[edit]]
        kind = "touch"
        tool = "{name} tip"
        "#
    )
}

#[test]
fn a_press_on_a_sheet_is_felt_as_what_its_border_holds() {
    for every in [1, 4] {
        let down = ArmModel::desktop(|t| Vec3::new(0.1, 0.1, 0.02 - 0.035 * t.min(1.0)));
        let mut bout = Bout::new(sheet(&finger("index", "0.02")), vec![down]);
        bout.run(2000, every);
        // Undamped denim still swings a little sideways: the mean over half a second.
        let (mut given, mut held, steps) = (Vec3::zeros(), Vec3::zeros(), 600 / every);
        for _ in 0..steps {
            bout.run(every, every);
            given += 1.0 / steps as f64 * bout.arm(0).force;
            // Of all reactions those of the border alone: the tip's are the others, and in balance with them.
            let rest = &bout.session.bodies[0].system.nodes.rest;
            let border = |x: Vec3| x[0] < 1e-6 || x[0] > 0.199999;
            let of_border = bout.session.reactions(0).iter().zip(rest).filter(|(_, x)| border(**x));
            held = of_border.fold(held, |sum, (f, _)| sum + 1.0 / steps as f64 * *f);
        }
        assert!(given.norm() > 0.1, "{given:?} N");
        let off = (given - held).norm() / held.norm();
        assert!(off < 0.02, "a step in {every} ticks: {given:?} N given, {held:?} N held: {off}");
        bout.forces_are_safe(0, 500.0);
    }
}

#[test]
fn a_pinch_is_felt_by_both_fingers_against_each_other() {
    let squeeze = |side: f64| ArmModel::desktop(move |t| Vec3::new(0.1, 0.1, side * (0.025 - 0.018 * t.min(1.0))));
    let tools = finger("index", "0.025") + &finger("thumb", "-0.025");
    let mut bout = Bout::new(sheet(&tools), vec![squeeze(1.0), squeeze(-1.0)]);
    bout.run(4000, 4);
    let (index, thumb) = (bout.arm(0).force, bout.arm(1).force);
    assert!(index[2] > 0.3 && thumb[2] < -0.3, "{index:?} {thumb:?}");
    assert!((index + thumb).norm() < 0.02 * index.norm(), "{index:?} {thumb:?}");
    bout.forces_are_safe(0, 500.0);
    bout.forces_are_safe(1, 500.0);
}

/// How often a cause changed the force of the first tool.
fn count(bout: &mut Bout, cause: Cause) -> u64 {
    bout.servo.safety().next().and_then(|s| s.counts().find(|(c, _)| *c == cause)).map_or(0, |(_, count)| count)
}

#[test]
fn a_simulation_that_stands_still_fades_away() {
    let mut bout = Bout::new(block(SOFT, ""), vec![press(4e-3)]);
    bout.run(2000, 1);
    assert!(bout.arm(0).force.norm() > 0.1 && count(&mut bout, Cause::Stale) == 0);
    bout.run(49, 0);
    assert!(bout.arm(0).force.norm() > 0.1, "what is young enough stands");
    bout.run(102, 0);
    assert_eq!(bout.arm(0).force, Vec3::zeros());
    assert!(count(&mut bout, Cause::Stale) > 90);
    bout.run(500, 1);
    assert!(bout.arm(0).force.norm() > 0.1, "it comes back with the simulation");
    bout.forces_are_safe(0, 500.0);
}

#[test]
fn a_haptic_thread_that_stood_still_begins_again_from_zero() {
    let mut bout = Bout::new(block(SOFT, "slew = 50"), vec![press(4e-3)]);
    bout.run(2000, 1);
    let before = bout.arm(0).force;
    // 80 ms during which nobody ticks: the arm is at zero by itself, as its force has expired.
    bout.skip(80);
    bout.run(1, 1);
    let after = bout.arm(0).force;
    assert!(before.norm() > 0.2 && after.norm() > 0.0 && after.norm() <= 0.05 + 1e-9, "{before:?} {after:?}");
}

#[test]
fn a_material_that_gives_nonsense_is_not_felt() {
    let faulty = r#""faulty-plugins#forces-not-a-number", params = { after = 1.5 }"#;
    let mut bout = Bout::new(block(faulty, ""), vec![press(4e-3)]);
    bout.run(3000, 1);
    assert!(bout.session.bodies[0].frozen.is_some(), "it went wrong");
    bout.forces_are_safe(0, 500.0);
}

#[test]
fn a_sensor_that_jumps_by_100_mm_moves_the_force_within_its_limits() {
    let model = press(4e-3);
    let glitch = std::sync::Arc::clone(&model.glitch);
    let mut bout = Bout::new(block(SOFT, ""), vec![model]);
    bout.run(2000, 1);
    for aside in [[0.0, 0.0, -0.1], [0.1, 0.0, 0.0], [0.0, 0.0, 1e6], [f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]] {
        *glitch.lock().unwrap() = Some(aside.into());
        bout.run(100, 1);
        let state = bout.arm(0);
        assert!(state.position.iter().all(|c| c.abs() < 0.02), "{aside:?}: the hand is at {:?}", state.position);
    }
    bout.forces_are_safe(0, 500.0);
    assert!(bout.session.bodies[0].frozen.is_none());
}

/// J, that the hand of a finger on a material was given in two seconds, with the controller or without; and how often it acted.
fn given_by(material: &str, controls: bool) -> (f64, u64) {
    // A light and loose hand, which the body may shake.
    let mut model = press(2e-3);
    (model.grip_stiffness, model.grip_damping) = (60.0, 0.3);
    let mut bout = Bout::new(block(material, ""), vec![model]);
    bout.servo.safety().for_each(|safety| safety.control(controls));
    bout.run(1500, 1);
    let before = bout.arm(0).given;
    bout.run(2000, 1);
    bout.forces_are_safe(0, 500.0);
    (bout.arm(0).given - before, count(&mut bout, Cause::Passivity))
}

#[test]
fn a_material_that_makes_energy_gives_the_hand_little_of_it() {
    let active = r#""faulty-plugins#makes-energy", params = { after = 1.0 }"#;
    let (wild, _) = given_by(active, false);
    let (tame, acted) = given_by(active, true);
    assert!(wild > 3e-3, "without the controller: {wild} J");
    assert!(acted > 0 && tame < 0.4 * wild, "with it: {tame} J of {wild} J, acted {acted} times");
    let (calm, acted) = given_by(SOFT, true);
    assert!(calm.abs() < 1e-5 && acted < 35, "a passive one, 3500 ticks: {calm} J, acted {acted} times");
}

#[test]
fn a_live_session_is_replayed_by_its_samples_alone() {
    let mut bout = Bout::new(open(&box_scene("", "", ""), 1), vec![press(2e-3)]);
    let mut stream = Vec::new();
    for _ in 0..1200 {
        bout.run(1, 0);
        let samples = bout.port.step(&mut bout.session, |_| {});
        stream.push((samples.poses.clone(), pliant_record::state_digest(&bout.session)));
    }
    assert!(bout.arm(0).force.norm() > 0.05, "{:?}", bout.arm(0).force);
    let mut again = open(&box_scene("", "", ""), 1);
    again.drive_tips();
    for (poses, digest) in stream {
        again.step_with(&poses);
        assert_eq!(pliant_record::state_digest(&again), digest, "at {} s", again.time());
    }
}

/// What a program asks for before it has the hand move is there in the step with that motion, for it is done after the poses are read.
#[test]
fn what_is_prepared_is_done_after_the_poses_are_read_and_before_the_step() {
    let mut bout = Bout::new(block(SOFT, ""), vec![press(2e-3)]);
    bout.run(100, 1);
    let Bout { session, servo, port, .. } = &mut bout;
    let place = |samples: &HandSamples| samples.poses[0][0].position;
    let (newest, steps, radius) = (place(port.latest()), session.steps(), 3e-3);
    let samples = port.step(session, |session| {
        // The hand goes on meanwhile.
        (0..100).for_each(|tick| servo.tick((101 + tick) * 1_000_000));
        assert_eq!(session.steps(), steps);
        assert!(session.apply(SessionCommand::ResizeTools { radius, coupling: 500.0 }));
    });
    assert_eq!(place(samples), newest, "the step has the poses from before");
    assert_eq!((session.steps(), session.tools[0].tool.proxy.radius()), (steps + 1, radius));
    assert_ne!(place(port.latest()), newest);
}
