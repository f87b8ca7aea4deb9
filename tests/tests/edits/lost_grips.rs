//! A hand that pulls with more than the limit lets go once, holds nothing for the rest of the stroke, and takes hold again in the next. What it has moved springs back, and
//! of what it holds no shape is kept that is turned inside out. `GRIPS=0..60` asks for more cases.

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::testing::Random;
use pliant_solver::Vec3;
use pliant_tests::{Bench, case_count, open_file};

#[test]
fn a_grip_over_its_limit_is_lost_until_the_next_stroke() {
    let mut random = Random(5);
    for case in 0..case_count("GRIPS", 4) {
        let kind = ["pull", "grab"][case % 2];
        let plugin = ["mass-spring", "neo-hookean"][case / 2 % 2];
        // Tools below and above the edge of a cell pull a point and a region.
        let (tool, level) = (0.002 + 0.006 * random.unit(), 4 + (random.unit() * 3.0) as usize);
        let what = format!("case {case}: {kind} of {plugin}, tool of {tool:.4} m, level {level}");
        let edit = |keys: &str| format!("[[edit]]\nkind = \"{kind}\"\ntool = \"finger\"\n{keys}\n");
        let text = format!(
            "format = 1\n[time]\nduration = 0.3\ndt = \"2 ms\"\n[[body]]\nshape = {{ kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }}\n\
             grid = {{ level = {level} }}\nmaterial = {{ plugin = \"{plugin}\", params = {{ young = 2e4, damping-time = \"2 ms\" }} }}\n\
             [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.01]]\n[[device]]\nname = \"hand\"\n\
             params = {{ peak-force = \"50 N\", path = [[0, 0, 0, 0.02], [0.1, 0.001, 0, 0.03], [0.14, 0, 0, 0.02], [0.2, 0, 0, 0.02], [0.3, 0, 0, 0.022]] }}\n\
             [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = {tool}\n{}{}",
            edit("end = 0.18\nlimit = 0.1"),
            edit("start = 0.2\nlimit = 50"),
        );
        let bench = Bench::new();
        let mut session: Session = open_file(&bench.write("scene.toml", text), 1, None);
        let held: Vec<bool> = (0..150)
            .map(|_| {
                session.step();
                session.tools[0].tool.contact().is_some()
            })
            .collect();
        let lost = held.iter().position(|held| !held).unwrap_or_else(|| panic!("{what}: it never lets go"));
        assert!((1..60).contains(&lost), "{what}: it lets go in step {lost}");
        assert!(held[lost..90].iter().all(|held| !held), "{what}: it takes hold again in the same stroke");
        assert!(held[101..].iter().all(|held| *held), "{what}: it takes hold in the next");
        assert_eq!(session.events.count(EventKind::GripLost), 1, "{what}");
    }
}

/// A block that is held at its bottom, and a hand that grabs it and goes far away with what it holds.
fn drawn_far(random: &mut Random, plugin: &str, limit: &str) -> (String, Session) {
    let (tool, level) = (0.003 + 0.003 * random.unit(), 4 + random.below(2));
    let [x, y, z]: [f64; 3] = (0.03 * (1.0 + 2.0 * random.unit()) * random.direction()).into();
    let text = format!(
        "format = 1\n[time]\nduration = 1\n[[body]]\nshape = {{ kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }}\n\
         grid = {{ level = {level} }}\nmaterial = {{ plugin = \"{plugin}\", params = {{ young = 2e4, damping-time = \"1 ms\" }} }}\n\
         [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.01]]\n[[device]]\nname = \"hand\"\n\
         params = {{ peak-force = \"50 N\", path = [[0, 0, 0, 0.02], [0.1, {x}, {y}, {}], [1, {x}, {y}, {}]] }}\n\
         [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = {tool}\nstiffness = 500\n\
         [[edit]]\nkind = \"grab\"\ntool = \"finger\"\nend = 0.15\nrelease = \"keep\"\n{limit}",
        0.02 + z,
        0.02 + z
    );
    let mut session = open_file(&Bench::new().write("scene.toml", text), 1, None);
    session.keep_history();
    (format!("{plugin}, tool of {tool:.4} m, level {level}, to {x:.3}, {y:.3}, {z:.3}"), session)
}

/// Whether the shape of the first body at rest is another one than in its file.
fn is_changed(session: &Session) -> bool {
    let body = &session.bodies[0];
    body.skin.settled[..] != body.model.surface.points[..]
}

#[test]
fn nothing_is_kept_of_a_stroke_whose_grip_was_lost() {
    let mut random = Random(7);
    for case in 0..4 {
        let (what, mut session) = drawn_far(&mut random, ["mass-spring", "neo-hookean"][case % 2], "limit = 1");
        (0..145).for_each(|_| session.step());
        assert_eq!(session.events.count(EventKind::GripLost), 1, "{what}");
        (0..300).for_each(|_| session.step());
        assert_eq!(session.events.count(EventKind::NotKept), 1, "{what}");
        assert!(!is_changed(&session), "{what}: it has another shape at rest");
        session.update_surface();
        let body = &session.bodies[0];
        let away = body.skin.x.iter().zip(&*body.skin.settled).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(away < 1e-3, "{what}: it is {away} m away from its shape at rest");
        assert!(!session.undo(), "{what}: there is nothing to take back");
    }
}

#[test]
fn a_shape_that_was_turned_inside_out_is_kept_as_the_hand_gave_it_or_not_at_all() {
    let (mut random, mut left_out) = (Random(11), 0);
    for case in 0..case_count("GRIPS", 6) {
        let plugin = ["mass-spring", "neo-hookean", "corotational"][case % 3];
        let (what, mut session) = drawn_far(&mut random, plugin, "");
        (0..149).for_each(|_| session.step());
        session.update_surface();
        let body = &session.bodies[0];
        let (held, cell) = (body.skin.x.clone(), body.discretization.edge());
        (0..3).for_each(|_| session.step());
        let said = format!("{what}: {:?}", session.events.described());
        if !is_changed(&session) {
            assert_eq!(session.events.count(EventKind::NotKept), 1, "{said}");
            left_out += 1;
            continue;
        }
        let moved = held.iter().zip(&*session.bodies[0].skin.settled).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{what}: the kept shape is {:.2} cells from the one in the hand", moved / cell);
        assert!(moved < 5.0 * cell, "{said}: the kept shape is {moved} m from the one in the hand");
    }
    println!("{left_out} shapes were not kept");
}

/// A sheet has nothing that it springs back to in space: what a hand has drawn along before it let go stays there, and an undo takes it back.
#[test]
fn a_sheet_that_was_drawn_away_before_the_grip_was_lost_is_taken_back() {
    let mut random = Random(11);
    for case in 0..case_count("GRIPS", 4) {
        // Slowly, and then away.
        let [slow, fast] = [0.02, 0.5].map(|way| Vec3::new(0.05, 0.05, 0.0) + way * random.direction());
        let path = [(0.0, Vec3::new(0.05, 0.05, 0.0)), (0.15, slow), (0.2, fast)].map(|(t, p)| [t, p.x, p.y, p.z]);
        let text = format!(
            "format = 1\n[time]\nduration = 1\ndt = \"2 ms\"\nintegrator = \"backward-euler\"\n[[body]]\n\
             shape = {{ kind = \"sheet\", cells = 10, size = [0.1, 0.1, 0] }}\nsheet = {{ warp = [1, 0, 0] }}\n\
             material = {{ plugin = \"cloth\", params = {{ density = 0.2, young-warp = 500, bending-warp = 1e-5 }} }}\n\
             [[device]]\nname = \"hand\"\nparams = {{ path = {path:?} }}\n\
             [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = 0.01\nstiffness = 200\n\
             [[edit]]\nkind = \"grab\"\ntool = \"finger\"\nend = 0.25\nrelease = \"keep\"\nlimit = {}\n",
            0.2 + 0.2 * random.unit()
        );
        let bench = Bench::new();
        let mut session = open_file(&bench.write("scene.toml", text), 1, None);
        session.keep_history();
        let before = session.bodies[0].system.nodes.x.clone();
        (0..140).for_each(|_| session.step());
        assert_eq!(session.events.count(EventKind::NotKept), 1, "{case}: it lets go");
        let moved = |(a, b): (&Vec3, &Vec3)| (a - b).norm();
        let moved = session.bodies[0].system.nodes.x.iter().zip(&before).map(moved).fold(0.0, f64::max);
        assert!(moved > 1e-3, "{case}: it was drawn along by {moved} m");
        assert_eq!(session.history().done, 1, "{case}");
        assert!(session.undo(), "{case}");
        assert!(session.bodies[0].system.nodes.x == before, "{case}: an undo takes it back");
    }
}
