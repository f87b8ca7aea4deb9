//! Sculpt layers: strokes that are recorded in a layer can be weakened, hidden, merged and deleted, exactly and in any order, and taken back.

use pliant_engine::session::{EventKind, HistoryCounts, Session, SessionCommand};
use pliant_host::{POSE_VALID, Pose};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, NOW, open, open_file};

/// Half the edge of the box and of the sheet, m.
const HALF: f64 = 0.02;
// Buttons that press and keep the shape, that cut and that smooth.
const PRESS: u32 = 1;
const CUT: u32 = 2;
const SMOOTH: u32 = 4;

/// A scene of one body with a hand that presses, cuts and smooths.
fn scene(body: &str) -> String {
    let edits: String = [("touch", "release = \"keep\""), ("cut", ""), ("smooth", "strength = \"200 Hz\"")]
        .iter()
        .enumerate()
        .map(|(button, (kind, rest))| {
            format!("[[edit]]\nkind = \"{kind}\"\ntool = \"finger\"\nbutton = {button}\n{rest}\n")
        })
        .collect();
    format!(
        "format = 1\n[time]\nduration = 100\nintegrator = \"backward-euler\"\n[[body]]\nname = \"block\"\n{body}\n\
         [[device]]\nname = \"hand\"\nparams = {{ path = [[0, 0, 0, 1]] }}\n\
         [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\nstiffness = \"400 N/m\"\nblade = {{ length = \"60 mm\" }}\n{edits}"
    )
}

/// A whole lattice, a local region of one, and a sheet.
fn bodies() -> [Session; 3] {
    let solid = |rest: &str| {
        format!(
            "shape = {{ kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }}\nmaterial = {{ plugin = \"neo-hookean\" }}\ngrid = {{ level = 4{rest} }}\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.0199]]"
        )
    };
    let mut text = String::new();
    for (i, j) in (0..17).flat_map(|j| (0..17).map(move |i| (i, j))) {
        text += &format!("v {} {} {HALF}\n", f64::from(i) * 0.0025 - HALF, f64::from(j) * 0.0025 - HALF);
    }
    for (i, j) in (0..16).flat_map(|j| (0..16).map(move |i| (i, j))) {
        let [a, b, c, d] = [1 + i + 17 * j, 2 + i + 17 * j, 19 + i + 17 * j, 18 + i + 17 * j];
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    let bench = Bench::new();
    bench.write("sheet.obj", text);
    let sheet = "mesh = \"sheet.obj\"\nsheet = {}\nmaterial = { plugin = \"cloth\" }\n\
        [[body.fixed]]\nbox = [[-1, -1, -1], [-0.0199, 1, 1]]\n[[body.fixed]]\nbox = [[0.0199, -1, -1], [1, 1, 1]]";
    let sheet = open_file(&bench.write("scene.toml", scene(sheet)), 1, None);
    let mut all = [open(&scene(&solid("")), 1), open(&scene(&solid(", radius = \"8 mm\"")), 1), sheet];
    all.iter_mut().for_each(Session::keep_history);
    all
}

fn pose(position: [f64; 3], buttons: u32) -> Pose {
    Pose { flags: POSE_VALID, buttons, position, orientation: [0.0, 0.0, 0.0, 1.0], ..Pose::default() }
}

/// Presses `depth` (m) into the upper face with an edit's buttons and lifts the hand; then nothing moves.
fn press(session: &mut Session, [x, y]: [f64; 2], depth: f64, buttons: u32) {
    for step in 0..30 {
        session.step_with(&[[pose([x, y, HALF + 0.006 - (0.006 + depth) * f64::from(step) / 29.0], buttons)]]);
    }
    session.step_with(&[[pose([x, y, HALF + 0.006], 0)]]);
    (0..200).for_each(|_| session.step_with(&[[Pose::default()]]));
}

/// Positions of all vertices and nodes at rest, as bits.
fn shape(session: &Session) -> Vec<u64> {
    let body = &session.bodies[0];
    // Nodes of a local region come and go; the surface at rest does not.
    let nodes = Some(&body.system.nodes.rest).filter(|_| body.discretization.is_whole());
    let rows = body.skin.settled.iter().chain(nodes.into_iter().flatten());
    rows.flat_map(|point| point.iter().map(|c| c.to_bits()).collect::<Vec<_>>()).collect()
}

fn settled(session: &Session) -> Vec<Vec3> {
    session.bodies[0].skin.settled.to_vec()
}

/// Largest distance (m) between two surfaces.
fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn add(session: &mut Session, name: &str) {
    assert!(session.apply(SessionCommand::AddLayer { name: name.into() }));
}

fn blend(session: &mut Session, layer: u32, strength: f64) -> bool {
    session.apply(SessionCommand::SetLayerStrength { layer, strength })
}

/// The description of the last event of a kind.
fn told(session: &Session, kind: EventKind) -> String {
    let mut of_kind = session.events.described().iter().filter(|(of, _)| *of == kind);
    of_kind.next_back().map(|(_, event)| event.text.clone()).unwrap_or_default()
}

#[test]
fn a_layer_is_hidden_to_the_bit_and_weakened_in_proportion() {
    for mut session in bodies() {
        session.step_with(&[[Pose::default()]]);
        press(&mut session, [-0.008, 0.004], 0.002, PRESS);
        let below = (shape(&session), settled(&session));
        add(&mut session, "wrinkles");
        press(&mut session, [0.006, -0.002], 0.003, PRESS);
        press(&mut session, [0.004, 0.006], 0.001, SMOOTH);
        let full = settled(&session);
        let depth = distance(&full, &below.1);
        assert!(depth > 5e-4, "the strokes moved the surface by {depth} m");
        for strength in [0.5, 0.25, 0.8] {
            assert!(blend(&mut session, 0, strength), "{}", told(&session, EventKind::LayerRefused));
            let expected: Vec<_> = below.1.iter().zip(&full).map(|(a, b)| a + strength * (b - a)).collect();
            let off = distance(&settled(&session), &expected);
            assert!(off < 1e-15, "at {strength}: {off} m");
        }
        assert!(blend(&mut session, 0, 0.0));
        assert_eq!(shape(&session), below.0);
        assert!(blend(&mut session, 0, 1.0));
        assert!(distance(&settled(&session), &full) < 1e-15);
        // The body is at rest in the new shape: nothing pulls it anywhere.
        let body = &mut session.bodies[0];
        let mut force = vec![Vec3::zeros(); body.system.nodes.len()];
        body.system.nodes.x.clone_from(&body.system.nodes.rest);
        body.system.nodes.v.fill(Vec3::zeros());
        body.system.forces(&pliant_solver::Pool::new(1), None, NOW, &mut force).unwrap();
        let largest = force.iter().map(|force| force.norm()).fold(0.0, f64::max);
        assert!(largest < 1e-9, "{largest} N");
    }
}

#[test]
fn strokes_below_a_layer_stay_when_it_is_hidden() {
    for mut session in bodies() {
        session.step_with(&[[Pose::default()]]);
        let file = settled(&session);
        add(&mut session, "above");
        press(&mut session, [0.006, -0.002], 0.003, PRESS);
        let above = settled(&session);
        assert!(session.apply(SessionCommand::RecordLayer { layer: None }));
        press(&mut session, [0.003, 0.0], 0.002, PRESS);
        let both = settled(&session);
        assert!(distance(&above, &both) > 1e-4);
        assert!(blend(&mut session, 0, 0.0));
        let expected: Vec<_> =
            file.iter().zip(&above).zip(&both).map(|((file, above), both)| file + (both - above)).collect();
        let off = distance(&settled(&session), &expected);
        assert!(off < 1e-15, "{off} m");
    }
}

/// What a user sees of the layers, without counts.
fn stack(session: &Session) -> Vec<(String, f64, bool, bool)> {
    let layers = session.sculpt_layers().into_iter();
    layers.map(|layer| (layer.name.to_string(), layer.strength, layer.records, layer.is_fixed)).collect()
}

#[test]
fn strokes_and_layers_are_taken_back_and_made_again_in_any_order() {
    for (case, mut session) in bodies().into_iter().enumerate() {
        let mut random = Random(case as u64);
        session.step_with(&[[Pose::default()]]);
        let mut states = vec![(shape(&session), stack(&session))];
        for number in 0..14 {
            let (count, before) = (session.sculpt_layers().len() as u64, session.history().done);
            let layer = random.below(count.max(1)) as u32;
            let place = [0.01 * random.unit(), 0.01 * random.unit()];
            let command = match random.below(9) {
                0 | 1 => Some(SessionCommand::AddLayer { name: format!("layer {number}") }),
                2 => Some(SessionCommand::RecordLayer { layer: Some(layer).filter(|_| random.below(2) == 0) }),
                3 | 4 => Some(SessionCommand::SetLayerStrength { layer, strength: random.unit().abs() }),
                5 => Some(SessionCommand::MergeLayer { layer }),
                6 => Some(SessionCommand::DeleteLayer { layer }),
                _ => None,
            };
            match command {
                Some(command) => _ = session.apply(command),
                None => press(&mut session, place, 0.001, PRESS),
            }
            // Strengths of one layer right after each other are one entry.
            match session.history().done - before {
                0 => *states.last_mut().unwrap() = (shape(&session), stack(&session)),
                _ => states.push((shape(&session), stack(&session))),
            }
        }
        assert_eq!(session.history().done + 1, states.len());
        for state in states.iter().rev().skip(1) {
            assert!(session.undo());
            assert!((shape(&session), stack(&session)) == *state, "case {case}: undo");
        }
        for state in &states[1..] {
            assert!(session.redo());
            assert!((shape(&session), stack(&session)) == *state, "case {case}: redo");
        }
    }
}

#[test]
fn merging_changes_no_shape_and_deleting_takes_the_strokes_away() {
    for mut session in bodies() {
        session.step_with(&[[Pose::default()]]);
        let file = settled(&session);
        for (name, place) in [("one", [0.006, -0.002]), ("two", [-0.006, 0.003])] {
            add(&mut session, name);
            press(&mut session, place, 0.002, PRESS);
        }
        assert!(blend(&mut session, 0, 0.5));
        let blended = settled(&session);
        assert!(session.apply(SessionCommand::MergeLayer { layer: 0 }));
        assert_eq!(stack(&session), [("two".into(), 1.0, true, false)]);
        assert!(distance(&settled(&session), &blended) == 0.0);
        assert!(session.apply(SessionCommand::DeleteLayer { layer: 0 }));
        assert_eq!(stack(&session), []);
        let left = distance(&settled(&session), &file);
        assert!(left > 1e-4 && left < distance(&blended, &file) + 1e-15, "half of the first layer: {left} m");
    }
}

#[test]
fn a_cut_fixes_the_layers_from_before_it_until_it_is_taken_back() {
    for mut session in bodies() {
        session.step_with(&[[Pose::default()]]);
        add(&mut session, "before");
        press(&mut session, [0.006, -0.002], 0.002, PRESS);
        let whole = shape(&session);
        for step in 0..60 {
            session.step_with(&[[pose([-0.03 + 1e-3 * f64::from(step), 0.0012, 0.0], CUT)]]);
        }
        session.step_with(&[[pose([0.03, 0.0012, 0.0], 0)]]);
        session.step_with(&[[Pose::default()]]);
        assert!(session.cuts().advances > 0);
        assert_eq!(stack(&session), [("before".into(), 1.0, false, true)]);
        assert!(told(&session, EventKind::LayerFixed).contains("`before`"));
        let cut = settled(&session);
        for command in [
            SessionCommand::SetLayerStrength { layer: 0, strength: 0.5 },
            SessionCommand::DeleteLayer { layer: 0 },
            SessionCommand::RecordLayer { layer: Some(0) },
        ] {
            assert!(!session.apply(command));
            assert!(told(&session, EventKind::LayerRefused).contains("`before`"));
            assert!(settled(&session) == cut);
        }
        // Layers work on the cut surface too, on what the cut has made as well.
        add(&mut session, "after");
        press(&mut session, [-0.006, 0.004], 0.002, PRESS);
        assert!(distance(&settled(&session), &cut) > 1e-4);
        assert!(blend(&mut session, 1, 0.0), "{}", told(&session, EventKind::LayerRefused));
        assert!(settled(&session) == cut);
        assert!(session.apply(SessionCommand::MergeLayer { layer: 0 }));
        assert!(settled(&session) == cut);
        while session.history().done > 2 {
            session.undo();
        }
        assert!(shape(&session) == whole);
        assert_eq!(stack(&session), [("before".into(), 1.0, true, false)]);
        assert!(blend(&mut session, 0, 0.5));
    }
}

#[test]
fn what_is_not_allowed_is_refused_with_a_reason() {
    let [mut session, ..] = bodies();
    session.step_with(&[[Pose::default()]]);
    let refused = |session: &mut Session, command: SessionCommand, why: &str| {
        let (before, history) = ((shape(session), stack(session)), session.history());
        assert!(!session.apply(command.clone()), "{command:?}");
        assert!(told(session, EventKind::LayerRefused).contains(why), "{:?}", session.events.described().last());
        assert!((shape(session), stack(session)) == before && session.history() == history);
    };
    refused(&mut session, SessionCommand::MergeLayer { layer: 0 }, "layer 0: there is none");
    add(&mut session, "one");
    let command = SessionCommand::RenameLayer { layer: 3, name: "x".into() };
    refused(&mut session, command, "layer 3: there is none; allowed is 0 to 0");
    for strength in [1.5, -0.1, f64::NAN] {
        refused(&mut session, SessionCommand::SetLayerStrength { layer: 0, strength }, "allowed is 0 to 1");
    }
    // Each of two layers presses the same place flat, as far as a material bears it; both together are too much.
    press(&mut session, [0.0, 0.0], 0.012, PRESS);
    assert!(blend(&mut session, 0, 0.0));
    add(&mut session, "two");
    press(&mut session, [0.0, 0.0], 0.012, PRESS);
    let command = SessionCommand::SetLayerStrength { layer: 0, strength: 1.0 };
    refused(&mut session, command, "layer `one` at strength 1.00: body `block`: ");
    assert!(told(&session, EventKind::LayerRefused).contains("cells near ["));
}

#[test]
fn every_refusal_is_told() {
    let [mut session, ..] = bodies();
    for layer in 0..20 {
        assert!(!session.apply(SessionCommand::MergeLayer { layer }));
        assert!(told(&session, EventKind::LayerRefused).contains(&format!("layer {layer}: there is none")));
    }
}

/// A full history keeps its length, so its counts do not tell that something was done.
#[test]
fn the_oldest_of_more_than_a_hundred_edits_is_forgotten_and_counted() {
    let [mut session, ..] = bodies();
    for done in 1..=103 {
        add(&mut session, "layer");
        let counts = HistoryCounts { done: done.min(100), undone: 0 };
        assert_eq!((session.history(), session.edits_forgotten()), (counts, done.saturating_sub(100) as u64));
    }
    while session.undo() {}
    assert_eq!(session.sculpt_layers().len(), 3, "those whose edits are forgotten stay");
    assert_eq!(session.edits_forgotten(), 3);
}

/// What is refused or changes nothing ends no stroke, adds nothing to the history and leaves what can be redone.
#[test]
fn what_changes_nothing_does_nothing() {
    let commands = [
        SessionCommand::SetLayerStrength { layer: 0, strength: 1.0 },
        SessionCommand::RecordLayer { layer: Some(0) },
        SessionCommand::RenameLayer { layer: 0, name: "one".into() },
        SessionCommand::SetLayerStrength { layer: 0, strength: 2.0 },
        SessionCommand::DeleteLayer { layer: 7 },
    ];
    let [mut disturbed, ..] = bodies();
    let [mut left, ..] = bodies();
    for (session, commands) in [(&mut disturbed, &commands[..]), (&mut left, &[])] {
        session.step_with(&[[Pose::default()]]);
        add(session, "one");
        press(session, [0.0, 0.0], 0.002, PRESS);
        assert!(session.undo());
        for command in commands {
            assert!(!session.apply(command.clone()), "{command:?}");
        }
        assert_eq!(session.history(), HistoryCounts { done: 1, undone: 1 });
        for step in 0..30 {
            session.step_with(&[[pose([0.004, 0.0, HALF + 0.006 - 3e-4 * f64::from(step)], PRESS)]]);
            commands.iter().for_each(|command| assert!(!session.apply(command.clone()), "{command:?}"));
        }
        session.step_with(&[[pose([0.004, 0.0, HALF + 0.006], 0)]]);
        (0..100).for_each(|_| session.step_with(&[[Pose::default()]]));
    }
    assert!(shape(&disturbed) == shape(&left));
}

#[test]
fn a_snapshot_amid_a_cut_has_its_layers_fixed() {
    for mut session in bodies() {
        session.step_with(&[[Pose::default()]]);
        add(&mut session, "before");
        press(&mut session, [0.006, -0.002], 0.002, PRESS);
        for step in 0..30 {
            session.step_with(&[[pose([-0.03 + 1e-3 * f64::from(step), 0.0012, 0.0], CUT)]]);
        }
        assert!(session.cuts().advances > 0);
        let snapshot = session.snapshot();
        session.restore(&snapshot).expect("a snapshot of the session");
        assert_eq!(stack(&session), [("before".into(), 1.0, false, true)]);
        assert!(!blend(&mut session, 0, 0.5));
        // The next cut has another stamp.
        add(&mut session, "after");
        for step in 0..60 {
            session.step_with(&[[pose([-0.03 + 1e-3 * f64::from(step), -0.0088, 0.0], CUT)]]);
        }
        session.step_with(&[[pose([0.03, -0.0088, 0.0], 0)]]);
        assert_eq!(stack(&session)[1], ("after".into(), 1.0, false, true));
    }
}

/// A layer that has something of one of two bodies leaves the other as it is.
#[test]
fn a_layer_moves_only_the_bodies_that_are_in_it() {
    let shape = "shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }\nmaterial = { plugin = \"neo-hookean\" }\n\
        grid = { level = 4, radius = \"8 mm\" }\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.0199]]\n";
    let mut session = open(&scene(&format!("{shape}[[body]]\nname = \"other\"\nposition = [0.2, 0, 0]\n{shape}")), 1);
    session.step_with(&[[Pose::default()]]);
    let rest = |session: &Session, body: usize| session.bodies[body].skin.settled.to_vec();
    let (before, other) = (rest(&session, 0), rest(&session, 1));
    add(&mut session, "one");
    press(&mut session, [0.0, 0.0], 0.003, PRESS);
    let pressed = rest(&session, 0);
    assert!(distance(&pressed, &before) > 1e-4);
    assert!(blend(&mut session, 0, 0.0), "{}", told(&session, EventKind::LayerRefused));
    assert!(rest(&session, 0) == before && rest(&session, 1) == other);
    assert!(blend(&mut session, 0, 1.0), "{}", told(&session, EventKind::LayerRefused));
    assert!(rest(&session, 0) == pressed && rest(&session, 1) == other);
}
