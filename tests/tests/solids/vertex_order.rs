//! A sheet from a file whose vertices and faces come in no order: it is worked on in another order, and nothing else shows.

use pliant_engine::body::Body;
use pliant_engine::session::{EventKind, HistoryCounts, Session};
use pliant_record::write_model;
use pliant_solver::{Pool, Vec3};
use pliant_tests::{Bench, NOW, open_file};
use std::fmt::Write;

/// Vertices a side, and in all.
const SIDE: usize = 17;
const COUNT: usize = SIDE * SIDE;

/// The vertex at a place of the grid; with a file in order, the place.
fn vertex(place: usize, shuffled: bool) -> usize {
    if shuffled { place * 106 % COUNT } else { place }
}

/// A square of 100 mm, its cells cut along either diagonal by turns, and a vertex that nothing uses.
fn mesh(shuffled: bool) -> String {
    let mut rows = vec![String::new(); COUNT];
    for place in 0..COUNT {
        let [x, y] = [place % SIDE, place / SIDE].map(|k| 0.1 * k as f64 / (SIDE - 1) as f64);
        rows[vertex(place, shuffled)] = format!("v {x} {y} 0\n");
    }
    let mut text = rows.concat() + "v 9 9 9\n";
    let cells = (SIDE - 1) * (SIDE - 1);
    for cell in (0..cells).map(|c| if shuffled { c * 75 % cells } else { c }) {
        let (i, j) = (cell % (SIDE - 1), cell / (SIDE - 1));
        let at = |right: usize, up: usize| vertex(SIDE * (j + up) + i + right, shuffled) + 1;
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
        _ = match (i + j) % 2 {
            0 => write!(text, "f {a} {b} {c}\nf {a} {c} {d}\n"),
            _ => write!(text, "f {a} {b} {d}\nf {b} {c} {d}\n"),
        };
    }
    text
}

fn session(shuffled: bool, rest: &str) -> Session {
    let bench = Bench::new();
    bench.write("mesh.obj", mesh(shuffled));
    let text = format!(
        r#"
        format = 1
        gravity = [0, -2, -9.81]
        [time]
        duration = "2 s"
        integrator = "backward-euler"
        [solver]
        tolerance = 1e-10
        [[body]]
        mesh = "mesh.obj"
        sheet = {{ warp = [1, 0.3, 0] }}
        material = {{ plugin = "cloth", params = {{ density = 0.2, young-warp = 400, young-weft = 300, poisson = 0.2, bending-warp = 1e-5, bending-hysteresis = 2e-3, damping-time = "1 ms" }} }}
        {rest}
        [[device]]
        name = "hand"
        params = {{ path = [[0.0, -0.02, 0.053, 0.02], [0.3, 0.13, 0.048, 0.02]] }}
        [[tool]]
        name = "knife"
        device = "hand"
        radius = "1 mm"
        stiffness = "200 N/m"
        blade = {{ length = "40 mm", direction = [0, 0, -1], tear = 0 }}
        [[edit]]
        kind = "cut"
        tool = "knife"
        "#
    );
    open_file(&bench.write("scene.toml", text), 1, None)
}

const CLAMPED: &str = "[[body.fixed]]\nbox = [[-1, 0.093, -1], [1, 0.101, 1]]\nclamp = true\n";

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
    assert_eq!(session.events.count(EventKind::Quarantine) + session.events.count(EventKind::CutRefused), 0);
}

/// The largest difference of the numbers of two neighbours.
fn width(body: &Body) -> u32 {
    let of = |t: &[u32; 3]| t.iter().max().unwrap() - t.iter().min().unwrap();
    let triangles = 0..body.model.surface.triangles.len() as u32;
    let sheet = body.discretization.sheet().expect("a sheet");
    triangles.map(|t| of(&sheet.nodes_of(&body.model, t))).max().unwrap()
}

fn away(a: Vec3, b: Vec3) -> f64 {
    (a - b).norm()
}

#[test]
fn a_sheet_moves_the_same_and_keeps_the_vertices_of_its_file() {
    let mut both = [false, true].map(|shuffled| session(shuffled, CLAMPED));
    both.iter_mut().for_each(|session| run(session, 0.02));
    assert!(width(&both[1].bodies[0]) <= 3 * SIDE as u32, "{}", width(&both[1].bodies[0]));
    both.iter_mut().for_each(Session::update_surface);
    let [plain, shuffled] = both.each_ref().map(|session| &session.bodies[0].skin.x);
    let mut moved = 0.0_f64;
    for place in 0..COUNT {
        let (a, b) = (plain[place], shuffled[vertex(place, true)]);
        assert!(away(a, b) < 1e-8, "{place}: {a:?} {b:?}");
        moved = moved.max(a[2].abs());
    }
    assert!(moved > 1e-3, "{moved} m");
    let bench = Bench::new();
    write_model(&both[1].bodies[0], "all", &bench.path("out.obj")).unwrap();
    let text = String::from_utf8(bench.read("out.obj")).unwrap();
    let faces = |text: &str| text.lines().filter(|l| l.starts_with("f ")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(faces(&text), faces(&mesh(true)));
    let first: Vec<f64> = text.lines().find(|l| l.starts_with("v ")).unwrap()[2..]
        .split_whitespace()
        .map(|v| v.parse().unwrap())
        .collect();
    assert!((0..3).all(|c| (first[c] - shuffled[0][c]).abs() < 1e-6), "{first:?} {:?}", shuffled[0]);
}

#[test]
fn a_blade_cuts_the_same_pieces_and_history_goes_with_them() {
    let mut both = [false, true].map(|shuffled| session(shuffled, CLAMPED));
    both.iter_mut().for_each(Session::step);
    let bodies = both.each_mut().map(|session| &mut session.bodies[0]);
    let history = |body: &Body| {
        let set = body.system.sets.iter().find(|set| !set.history().is_empty()).expect("hinges that slip");
        set.history().iter().map(|h| h.abs()).sum::<f64>()
    };
    let cut = bodies.map(|body| {
        for i in 0..body.system.nodes.len() {
            let [x, y, _] = body.system.nodes.rest[i].into();
            body.system.nodes.x[i] = Vec3::new(1.05 * (50.0 * x).sin() / 50.0, y, (1.0 - (50.0 * x).cos()) / 50.0);
            body.system.nodes.v[i] = Vec3::new(0.4 - 3.0 * y, 0.2 + 3.0 * x, 0.5);
        }
        body.system.advance(&Pool::new(1), NOW).unwrap();
        let was = history(body);
        let blade = |x: f64| pliant_cut::Blade { tip: Vec3::new(x, 0.0481, -0.01), heel: Vec3::new(x, 0.0502, 0.01) };
        let mut stroke = pliant_cut::Stroke::begin(blade(-0.01)).unwrap();
        for x in (0..60).map(|i| 0.002 * f64::from(i)) {
            let advance = body.cut.as_mut().unwrap().advance(&mut stroke, blade(x));
            if let Some(advance) = advance.ok().filter(|advance| advance.has_cut()) {
                body.take_cut(&advance).unwrap();
            }
        }
        let surface = &body.model.surface;
        let parts = surface.shells().into_iter().max().unwrap() + 1;
        let [elastic, kinetic] = [body.system.energy(NOW).unwrap(), body.system.nodes.kinetic_energy()];
        ([surface.triangles.len(), body.system.nodes.len(), parts as usize], [was, history(body), elastic, kinetic])
    });
    let [(sizes, plain), (others, shuffled)] = cut;
    assert_eq!(sizes, others);
    assert!(sizes[2] == 2 && sizes[0] > 512 + 60, "{sizes:?}");
    let close = |a: f64, b: f64| a > 0.0 && (a - b).abs() < 1e-9 * a;
    assert!((0..4).all(|k| close(plain[k], shuffled[k])), "{plain:?} {shuffled:?}");
    assert!(plain[1] > 0.9 * plain[0]);
}

#[test]
fn taken_back_and_made_again_to_the_bit() {
    let mut session = session(true, CLAMPED);
    session.keep_history();
    let bits = |session: &mut Session| {
        session.update_surface();
        let body = &mut session.bodies[0];
        let mut force = vec![Vec3::zeros(); body.system.nodes.len()];
        body.system.forces(&Pool::new(1), None, NOW, &mut force).unwrap();
        let nodes = &body.system.nodes;
        let rows = [&nodes.rest, &nodes.x, &nodes.v, &force, &body.skin.x].into_iter().flatten().flatten();
        rows.chain(&nodes.mass).map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    run(&mut session, 0.02);
    let before = bits(&mut session);
    run(&mut session, 0.33);
    let (after, history) = (bits(&mut session), session.history());
    assert_eq!(history, HistoryCounts { done: 1, undone: 0 });
    for _ in 0..2 {
        assert!(session.undo() && session.redo() && bits(&mut session) == after);
    }
    assert!(session.undo() && bits(&mut session).len() < after.len() && before.len() < after.len());
    run(&mut session, 0.02);
}
