//! Taking back and making again: what a sheet was, and what becomes of an edit that is still under way.

use pliant_engine::body::Body;
use pliant_engine::session::{EventKind, HistoryCounts, Session};
use pliant_mesh::geometry::Vec3;
use pliant_tests::{Bench, NOW, open, open_file};

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

/// Nine by nine vertices over 80 mm, a little bent, with texture coordinates turned by 30 degrees.
fn cloth() -> String {
    let mut text = String::new();
    for (i, j) in (0..9).flat_map(|j| (0..9).map(move |i| (i, j))) {
        let [x, y] = [i, j].map(|k| f64::from(k) * 0.01);
        text += &format!("v {x} {y} {}\nvt {} {}\n", 4.0 * x * x, 0.87 * x - 0.5 * y, 0.5 * x + 0.87 * y);
    }
    for (i, j) in (0..8).flat_map(|j| (0..8).map(move |i| (i, j))) {
        let [a, b, c, d] = [1 + i + 9 * j, 2 + i + 9 * j, 11 + i + 9 * j, 10 + i + 9 * j];
        text += &format!("f {a}/{a} {b}/{b} {c}/{c}\nf {a}/{a} {c}/{c} {d}/{d}\n");
    }
    text
}

/// The cloth, clamped along one side and pulled at its middle until 0.1 s.
fn pulled(sheet: &str) -> Session {
    let bench = Bench::new();
    bench.write("cloth.obj", cloth());
    let scene = format!(
        r#"
        format = 1
        [time]
        duration = "1 s"
        integrator = "backward-euler"
        [[body]]
        mesh = "cloth.obj"
        sheet = {sheet}
        material = {{ plugin = "cloth", params = {{ young-warp = 500, young-weft = 200, poisson = 0.2, damping-time = "5 ms" }} }}
        [[body.fixed]]
        box = [["-1 m", "-1 m", "-1 m"], ["1 m", "1 mm", "1 m"]]
        clamp = true
        [[device]]
        name = "hand"
        params = {{ path = [[0.0, 0.04, 0.05, 0.006], [0.02, 0.04, 0.05, 0.006], [0.08, 0.04, 0.06, 0.02]] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "2 mm"
        stiffness = "50 N/m"
        [[edit]]
        kind = "pull"
        tool = "finger"
        release = "keep"
        end = "0.1 s"
        "#
    );
    let mut session = open_file(&bench.write("scene.toml", scene), 1, None);
    session.keep_history();
    session
}

/// Everything that moves a body, as bits: places, velocities, masses and the force of its elements.
fn state(session: &mut Session) -> Vec<u64> {
    let (body, pool) = (&mut session.bodies[0], pliant_solver::Pool::new(1));
    let Body { system, skin, .. } = body;
    let mut force = vec![Vec3::zeros(); system.nodes.len()];
    system.forces(&pool, None, NOW, &mut force).unwrap();
    let nodes = &system.nodes;
    let rows = [&nodes.rest, &nodes.x, &nodes.v, &force, &*skin.settled].into_iter().flatten().flatten();
    rows.chain(&nodes.mass).map(|value| value.to_bits()).collect()
}

#[test]
fn a_kept_pull_on_a_sheet_is_taken_back_and_made_again_to_the_bit() {
    for sheet in ["{ warp = \"texture\" }", "{}"] {
        let mut session = pulled(sheet);
        let before = state(&mut session);
        run(&mut session, 0.08);
        let energy = session.bodies[0].system.energy(NOW).unwrap();
        assert!(energy > 1e-5, "{energy} J");
        run(&mut session, 0.03);
        assert_eq!(session.history(), HistoryCounts { done: 1, undone: 0 });
        let kept = session.bodies[0].system.energy(NOW).unwrap();
        assert!(kept < 1e-12 * energy, "{sheet}: the shape kept is at rest: {kept} J of {energy} J");
        let after = state(&mut session);
        assert_ne!(before, after);
        for _ in 0..2 {
            assert!(session.undo());
            assert!(state(&mut session) == before, "{sheet}: as it was");
            assert!(session.redo());
            assert!(state(&mut session) == after, "{sheet}: and again");
        }
        assert!(session.undo());
        run(&mut session, 0.05);
        assert_eq!(session.events.count(EventKind::Quarantine), 0);
        let still = session.bodies[0].system.energy(NOW).unwrap();
        assert!(still < 1e-9 * energy, "{sheet}: it rests where it was handed in: {still} J");
    }
}

/// A block under a blade that comes down in half a second, held by a hand that lets go of button 0 for 20 ms.
fn block(button: &str, edits: &str) -> Session {
    block_cut_by("[[0.0, 1], [0.3, 0], [0.32, 1]]", button, edits)
}

/// The same, with a table of the hand's buttons: times (s) and masks.
fn block_cut_by(buttons: &str, button: &str, edits: &str) -> Session {
    let mut session = open(
        &format!(
            r#"
            format = 1
            [time]
            duration = "2 s"
            [[body]]
            shape = {{ kind = "box", cells = 8, size = ["40 mm", "40 mm", "40 mm"] }}
            material = {{ plugin = "mass-spring", params = {{ young = "500 kPa", damping-time = "2 ms" }} }}
            grid = {{ level = 3, region = "whole" }}
            [[body.fixed]]
            box = [["-1 m", "-1 m", "-1 m"], ["1 m", "1 m", "-19 mm"]]
            [[device]]
            name = "hand"
            params = {{ path = [[0, 0.003, -0.05, 0.03], [0.5, 0.003, -0.05, -0.01]], buttons = {buttons} }}
            [[tool]]
            name = "knife"
            device = "hand"
            radius = "1 mm"
            stiffness = "1000 N/m"
            blade = {{ length = "100 mm", direction = [0, 1, 0], toughness = 5 }}
            [[edit]]
            kind = "cut"
            tool = "knife"
            end = "0.6 s"
            {button}
            {edits}
            "#
        ),
        1,
    );
    session.keep_history();
    session
}

fn depth(session: &Session) -> usize {
    session.bodies[0].cut.as_ref().unwrap().depth()
}

#[test]
fn an_edit_taken_back_does_not_begin_again_in_its_own_span() {
    let mut session = block("", "[[edit]]\nkind = \"undo\"\nstart = \"0.25 s\"\n");
    run(&mut session, 0.24);
    let half = depth(&session);
    assert!(half > 2, "{half} advances");
    run(&mut session, 0.41);
    assert_eq!(
        (depth(&session), session.history()),
        (0, HistoryCounts { done: 0, undone: 1 }),
        "the blade went on down and cut nothing"
    );
    assert!(session.redo());
    assert!(depth(&session) >= half);
    run(&mut session, 0.1);
    assert_eq!(
        session.history(),
        HistoryCounts { done: 1, undone: 0 },
        "what was made again does not begin a new edit"
    );
}

#[test]
fn its_button_pressed_anew_begins_it_again() {
    let mut session = block("button = 0", "[[edit]]\nkind = \"undo\"\nstart = \"0.25 s\"\n");
    run(&mut session, 0.315);
    assert_eq!(depth(&session), 0, "taken back, and the button let go since");
    run(&mut session, 0.2);
    assert!(depth(&session) > 2, "pressed again at 0.32 s, it cuts");
    assert_eq!(session.history(), HistoryCounts { done: 1, undone: 0 });
}

#[test]
fn undo_and_redo_by_button_happen_each_time_it_is_pressed_and_only_then() {
    let edits = "[[edit]]\nkind = \"undo\"\nbutton = 1\n[[edit]]\nkind = \"redo\"\nbutton = 2\nend = \"0.9 s\"\n";
    let buttons =
        "[[0.0, 1], [0.3, 0], [0.7, 2], [0.75, 0], [0.8, 4], [0.85, 0], [0.9, 2], [0.95, 0], [1.0, 4], [1.05, 2]]";
    let mut session = block_cut_by(buttons, "button = 0", edits);
    run(&mut session, 0.69);
    let cut = depth(&session);
    assert!(cut > 2, "nothing was undone before its button was pressed: {cut} advances");
    run(&mut session, 0.03);
    assert_eq!(
        (depth(&session), session.history()),
        (0, HistoryCounts { done: 0, undone: 1 }),
        "undone once, though the button is held for 50 steps"
    );
    run(&mut session, 0.1);
    assert_eq!(
        (depth(&session), session.history()),
        (cut, HistoryCounts { done: 1, undone: 0 }),
        "the other button makes it again"
    );
    run(&mut session, 0.1);
    assert_eq!(depth(&session), 0, "pressed anew, it undoes again");
    run(&mut session, 0.1);
    assert_eq!(depth(&session), 0, "a redo that has ended does nothing");
    let events = session.events.count(EventKind::History);
    run(&mut session, 0.1);
    assert_eq!(session.events.count(EventKind::History), events + 1, "nothing left to undo is an event");
}
