//! The palette of edits: what each does to solids and sheets, what it leaves alone, and how it is taken back.

use pliant_editor::SurfacePoint;
use pliant_engine::edit::Falloff;
use pliant_engine::session::{EventKind, HistoryCounts, Session, SessionCommand};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::models;
use pliant_mesh::{Bounds, ObjDocument, Surface};
use pliant_tests::table::Table;
use pliant_tests::{Bench, box_scene, open_file, root};

/// m, the longest edge of every model
const SIZE: f64 = 0.1;
/// m, edge of a cell of level 5 around it
const CELL: f64 = SIZE / 16.0;
/// Every kind that acts on a soft region, with its keys.
const KINDS: [(&str, &str); 10] = [
    ("grab", ""),
    ("inflate", "strength = \"1 kPa\"\nrelease = \"keep\""),
    ("deflate", "strength = \"1 kPa\"\nrelease = \"keep\""),
    ("smooth", ""),
    ("flatten", ""),
    ("pinch", ""),
    ("relax", ""),
    ("grow", ""),
    ("shrink", ""),
    ("paint", "strength = 0.3"),
];

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

/// A place on a model and the normal there, m, with the model as large as a scene makes it.
fn place(document: &ObjDocument, vertex: usize) -> SurfacePoint {
    let surface = Surface::from_document(document);
    let Bounds { min, max } = surface.bounds();
    let (scale, centre) = (SIZE / (max - min).max(), min.lerp(&max, 0.5));
    let at = surface.triangles[vertex % surface.triangles.len()].map(|v| scale * (surface.points[v as usize] - centre));
    SurfacePoint { point: at.iter().sum::<Vec3>() / 3.0, normal: (at[1] - at[0]).cross(&(at[2] - at[0])).normalize() }
}

/// A scene in which a hand of radius 5 mm stands over a place, goes through `way` (s, m along the normal) and lets go at 0.25 s.
fn scene(
    body: &str,
    SurfacePoint { point: at, normal }: SurfacePoint,
    way: &[(f64, f64)],
    kind: &str,
    keys: &str,
) -> String {
    let row = |&(time, height): &(f64, f64)| {
        let p = at + height * normal;
        format!("[{time}, {}, {}, {}]", p.x, p.y, p.z)
    };
    let path = way.iter().map(row).collect::<Vec<_>>().join(", ");
    format!(
        r#"
        format = 1
        [time]
        duration = "1 s"
        [[body]]
        {body}
        [[device]]
        name = "hand"
        params = {{ interpolation = "smooth", peak-force = "50 N", path = [{path}] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "5 mm"
        stiffness = "500 N/m"
        [[edit]]
        kind = "{kind}"
        tool = "finger"
        radius = "15 mm"
        end = "0.25 s"
        {keys}
        "#
    )
}

/// A place on the flank of the elephant in `model.obj`: the triangle of large x near the middle.
fn flank(bench: &Bench) -> SurfacePoint {
    let model = ObjDocument::parse(bench.read("model.obj"), &bench.path("model.obj")).expect("an OBJ");
    let surface = Surface::from_document(&model);
    let Bounds { min, max } = surface.bounds();
    let middle = |t: &[u32; 3]| t.iter().map(|v| surface.points[*v as usize]).sum::<Vec3>() / 3.0;
    let away = |t: &usize| {
        let share = (middle(&surface.triangles[*t]) - min).component_div(&(max - min));
        (share.y - 0.55).abs() + (share.z - 0.45).abs() - 0.5 * share.x
    };
    let at = (0..surface.triangles.len()).min_by(|a, b| away(a).total_cmp(&away(b))).expect("triangles");
    place(&model, at)
}

const SOLID: &str = r#"mesh = "model.obj"
size = "100 mm"
material = { plugin = "mass-spring", params = { young = "10 kPa", damping-time = "0.5 ms" } }
grid = { level = 5 }"#;

/// How a hand goes in an edit: away from the surface where it takes hold, into it where it touches.
fn way(kind: &str) -> [(f64, f64); 3] {
    match kind {
        "grab" => [(0.0, 0.001), (0.02, 0.001), (0.2, 0.006)],
        "inflate" | "deflate" => [(0.0, 0.002), (0.1, 0.002), (0.2, 0.002)],
        _ => [(0.0, 0.006), (0.05, 0.0035), (0.2, 0.0035)],
    }
}

fn opened(bench: &Bench, text: &str) -> Session {
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    session.keep_history();
    session
}

/// Where the surface was handed in, and where it is, m.
fn surfaces(session: &mut Session) -> (Vec<Vec3>, Vec<Vec3>) {
    session.update_surface();
    let body = &session.bodies[0];
    (body.model.surface.points.clone(), body.skin.x.clone())
}

/// Triangles whose normals have turned by more than a right angle.
fn inverted(session: &Session, before: &[Vec3], after: &[Vec3]) -> usize {
    let triangles = &session.bodies[0].model.surface.triangles;
    let normal = |points: &[Vec3], t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| points[v as usize]);
        (b - a).cross(&(c - a))
    };
    triangles.iter().filter(|t| normal(before, t).dot(&normal(after, t)) < 0.0).count()
}

#[test]
fn every_edit_on_generated_solids_leaves_the_rest_alone_turns_no_triangle_and_is_one_undo() {
    for (i, model) in models(6, 20).iter().filter(|m| m.closed && m.genus.is_some()).take(3).enumerate() {
        let bench = Bench::new();
        bench.write("model.obj", &model.text);
        for (k, (kind, keys)) in KINDS.into_iter().enumerate() {
            let spot = place(&model.document(), 37 + 101 * i + 13 * k);
            let mut session = opened(&bench, &scene(SOLID, spot, &way(kind), kind, keys));
            run(&mut session, 0.24);
            let what = format!("{kind} on {} at {:?}", model.name, spot.point);
            assert_eq!(session.events.count(EventKind::Quarantine), 0, "{what}: {:?}", session.events.described());
            let (before, after) = surfaces(&mut session);
            let most = before.iter().zip(&after).map(|(a, b)| (b - a).norm()).fold(0.0, f64::max);
            assert!(most > 1e-5, "{what} moved nothing: {most} m");
            assert_eq!(inverted(&session, &before, &after), 0, "{what}");
            // The region: ten cells around the contact, and the radius of the edit; two cells for its border.
            let reach = 12.0 * CELL + 0.015 + 0.012;
            for (a, b) in before.iter().zip(&after).filter(|(a, _)| (*a - spot.point).norm() > reach) {
                assert!(a == b, "{what}: {a:?} is {} m away and moved to {b:?}", (a - spot.point).norm());
            }
            run(&mut session, 0.03);
            let kept = surfaces(&mut session).1;
            let stays = !matches!(kind, "grab");
            assert_eq!(session.history(), HistoryCounts { done: usize::from(stays), undone: 0 }, "{what}");
            if stays {
                assert!(session.undo(), "{what}");
                assert!(surfaces(&mut session).1 == before, "{what}: taken back to the bit");
                assert!(session.redo(), "{what}");
                assert!(surfaces(&mut session).1 == kept, "{what}: made again to the bit");
            }
        }
    }
}

#[test]
fn a_grab_moves_the_surface_smoothly_at_every_level() {
    let shape = |level: u32| {
        format!(
            "shape = {{ kind = \"sphere\", cells = 40, size = [0.1, 0.1, 0.1] }}\ngrid = {{ level = {level} }}\n\
             material = {{ plugin = \"mass-spring\", params = {{ young = \"10 kPa\", damping-time = \"0.5 ms\" }} }}"
        )
    };
    let spot = SurfacePoint { point: Vec3::new(0.0, 0.0, 0.05), normal: Vec3::z() };
    let mut reached = Vec::new();
    for level in [5, 6, 7] {
        let bench = Bench::new();
        let mut session = opened(&bench, &scene(&shape(level), spot, &way("grab"), "grab", ""));
        run(&mut session, 0.24);
        let (before, after) = surfaces(&mut session);
        let moved: Vec<Vec3> = before.iter().zip(&after).map(|(a, b)| b - a).collect();
        let most = moved.iter().map(Vec3::norm).fold(0.0, f64::max);
        reached.push(most);
        // The strain of a Kelvinlet of the same load is at most u / eps, eps = 2 R / 3; cells make it uneven by as much again.
        let steepest = 2.0 * most / (2.0 / 3.0 * 0.015);
        for t in &session.bodies[0].model.surface.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].map(|(a, b)| (a as usize, b as usize)) {
                let (jump, length) = ((moved[a] - moved[b]).norm(), (before[a] - before[b]).norm());
                assert!(jump <= steepest * length, "level {level}: {jump} m over {length} m; u is {most} m");
            }
        }
    }
    // The load is a density, not a patch of cells: the level changes the answer, not the shape.
    assert!(reached.iter().all(|u| (u / reached[1] - 1.0).abs() < 0.5), "{reached:?} m");
}

#[test]
fn a_trace_has_the_torque_of_a_grab_about_the_axis_that_it_turns() {
    let bench = Bench::new();
    let text = r#"
        format = 1
        [time]
        duration = "0.4 s"
        dt = "2 ms"
        integrator = "backward-euler"
        [[body]]
        shape = { kind = "box", cells = 12, size = [0.03, 0.03, 0.12] }
        material = { plugin = "corotational", params = { young = 30e3, poisson = 0.3, damping-time = "5 ms" } }
        grid = { level = 4, region = "whole" }
        [[body.fixed]]
        box = [[-1, -1, -1], [1, 1, -0.0599]]
        [[device]]
        name = "hand"
        [device.params]
        interpolation = "smooth"
        peak-force = "100 N"
        path = [[0, 0, 0, 0.061]]
        rotation = [[0.05, 0, 0, 0], [0.3, 0, 0, 15]]
        [[tool]]
        name = "wrench"
        device = "hand"
        radius = "2 mm"
        stiffness = "5000 N/m"
        [[edit]]
        kind = "grab"
        tool = "wrench"
        radius = "25 mm"
        "#;
    bench.write("scene.toml", text);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let trace = Table::read(&bench, "out/trace.csv");
    let last = trace.rows.len() - 1;
    let number = |name: &str| trace.number(last, &format!("wrench.{name}"));
    let torque = -number("torque_z_Nm");
    let across = number("torque_x_Nm").hypot(number("torque_y_Nm"));
    assert!(
        torque > 0.0 && across < 0.01 * torque,
        "{across} N m about axes that nothing turns about, {torque} N m about the bar's"
    );
    // This device drives three axes.
    assert_eq!(number("device_torque_z_Nm"), 0.0);
}

#[test]
fn traces_of_tools_that_turn_nothing_have_no_torque() {
    let bench = Bench::new();
    for (kind, has_torque) in [("touch", false), ("pull", false), ("grab", true)] {
        bench.write("scene.toml", box_scene("", "", "").replace("\"touch\"", &format!("\"{kind}\"")));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
        let trace = Table::read(&bench, "out/trace.csv");
        assert_eq!(trace.names.iter().any(|name| name.contains("torque")), has_torque, "{kind}: {:?}", trace.names);
        assert!(trace.rows.iter().all(|row| row.len() == trace.names.len()), "{kind}");
    }
}

#[test]
fn inflating_a_thin_sphere_stretches_it_as_laplace_says() {
    let (pressure, radius, young, poisson) = (100.0, 0.05, 500.0, 0.2);
    let body = format!(
        "shape = {{ kind = \"sphere\", cells = 24, size = [0.1, 0.1, 0.1] }}\nsheet = {{}}\nmaterial = {{ plugin = \"cloth\", params = \
         {{ young-warp = {young}, young-weft = {young}, poisson = {poisson}, damping-time = \"5 ms\" }} }}"
    );
    let spot = SurfacePoint { point: Vec3::new(0.0, 0.0, radius), normal: Vec3::z() };
    let keys = format!("strength = {pressure}\nfalloff = \"constant\"");
    let text = scene(&body, spot, &[(0.0, 0.0), (1.0, 0.0)], "inflate", &keys).replace("15 mm", "1 m");
    let text = text
        .replace("end = \"0.25 s\"", "")
        .replace("duration = \"1 s\"", "duration = \"1 s\"\nintegrator = \"backward-euler\"");
    let bench = Bench::new();
    let mut session = opened(&bench, &text);
    run(&mut session, 0.3);
    let (before, after) = surfaces(&mut session);
    let mean = |points: &[Vec3]| {
        let centre = points.iter().sum::<Vec3>() / points.len() as f64;
        points.iter().map(|p| (p - centre).norm()).sum::<f64>() / points.len() as f64
    };
    let strain = mean(&after) / mean(&before) - 1.0;
    let exact = pressure * radius * (1.0 - poisson) / (2.0 * young);
    assert!((strain / exact - 1.0).abs() < 0.05, "{strain}; T = p R / 2 gives {exact}");
    let force = session.frame().tools[0].force.norm();
    assert!(
        force < 1e-3 * pressure * std::f64::consts::PI * radius * radius,
        "a closed surface gives no reaction: {force} N"
    );
}

#[test]
fn mirrored_hands_keep_a_symmetric_model_symmetric_to_the_bit() {
    let bench = Bench::new();
    std::fs::copy(root().join("scenes/elephant.obj"), bench.path("model.obj")).expect("copied");
    let spot = flank(&bench);
    for (kind, keys) in [("grab", "release = \"keep\""), ("grow", ""), ("inflate", "release = \"keep\"")] {
        let text = scene(SOLID, spot, &way(kind), kind, &format!("{keys}\nsymmetry = \"x\""));
        let mut session = opened(&bench, &text);
        let told = session.events.described().to_vec();
        assert_eq!(session.events.count(EventKind::Model), 0, "{told:?}");
        assert_eq!(session.tools[1].tool.name, "finger mirrored in x");
        run(&mut session, 0.3);
        let (before, after) = surfaces(&mut session);
        // Zero has two signs.
        let key = |p: &Vec3| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
        let all: std::collections::HashSet<_> = after.iter().map(key).collect();
        let moved = before.iter().zip(&after).filter(|(a, b)| a != b);
        assert!(moved.clone().count() > 50, "{kind} moved little");
        for (a, b) in moved {
            let image = Vec3::new(-b.x, b.y, b.z);
            assert!(all.contains(&key(&image)), "{kind}: {a:?} went to {b:?}, and nothing to its mirror image");
        }
        let stays = session.history();
        assert_eq!(stays, HistoryCounts { done: 1, undone: 0 }, "{kind}: both hands make one stroke");
    }
}

#[test]
fn edits_do_what_they_are_called() {
    let bench = Bench::new();
    std::fs::copy(root().join("scenes/elephant.obj"), bench.path("model.obj")).expect("copied");
    let spot = flank(&bench);
    let volume = |session: &Session, points: &[Vec3]| {
        let each = session.bodies[0].model.surface.triangles.iter().map(|t| t.map(|v| points[v as usize]));
        each.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum::<f64>()
    };
    let mut grown = std::collections::BTreeMap::new();
    for (kind, keys) in KINDS {
        let keys = if kind == "flatten" { "strength = \"40 Hz\"" } else { keys };
        let mut session = opened(&bench, &scene(SOLID, spot, &way(kind), kind, keys));
        run(&mut session, 0.6);
        let (before, after) = surfaces(&mut session);
        grown.insert(kind, volume(&session, &after) - volume(&session, &before));
        let height = |p: &Vec3| (p - spot.point).dot(&spot.normal);
        let near: Vec<usize> = (0..before.len()).filter(|v| (before[*v] - spot.point).norm() < 0.008).collect();
        let spread = |points: &[Vec3]| {
            let mean = near.iter().map(|v| height(&points[*v])).sum::<f64>() / near.len() as f64;
            near.iter().map(|v| (height(&points[*v]) - mean).powi(2)).sum::<f64>().sqrt()
        };
        match kind {
            "grab" => assert!(before.iter().zip(&after).all(|(a, b)| (a - b).norm() < 1e-4), "it springs back"),
            "flatten" => assert!(spread(&after) < 0.9 * spread(&before), "{} {}", spread(&after), spread(&before)),
            "relax" => assert!(
                near.iter().map(|v| height(&after[*v]) - height(&before[*v])).sum::<f64>() < 0.0,
                "a dent stays"
            ),
            _ => {}
        }
    }
    for (more, less) in [("inflate", "deflate"), ("grow", "shrink")] {
        assert!(grown[more] > 1e-9 && grown[less] < -1e-9, "m^3: {grown:?}");
    }
}

#[test]
fn a_hand_that_asks_for_more_force_than_its_device_gives_is_told() {
    let bench = Bench::new();
    let body = "shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }\nmaterial = { plugin = \"mass-spring\" }\ngrid = { level = 5 }";
    let spot = SurfacePoint { point: Vec3::new(0.0, 0.0, 0.02), normal: Vec3::z() };
    let text = scene(body, spot, &way("grab"), "grab", "").replace("50 N\"", "0.1 N\"");
    bench.write("scene.toml", text);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let summary = bench.summary("out");
    assert!(summary["event_counts"]["force-limit"].as_u64().is_some_and(|n| n > 10), "{summary}");
    let text = summary["events"].to_string();
    assert!(text.contains("`hand`") && text.contains("0.1 N") && text.contains("peak-force"), "{text}");
}

#[test]
fn an_edit_is_recorded_and_replayed_to_the_bit() {
    let bench = Bench::new();
    for (kind, keys) in [("grab", "symmetry = \"x\""), ("smooth", "symmetry = \"xy\""), ("inflate", "")] {
        let body = "shape = { kind = \"sphere\", cells = 16, size = [0.04, 0.04, 0.04] }\nmaterial = { plugin = \"mass-spring\" }\ngrid = { level = 5 }";
        let spot = SurfacePoint { point: Vec3::new(0.0120, 0.0, 0.0160), normal: Vec3::new(0.6, 0.0, 0.8) };
        let text = scene(body, spot, &way(kind), kind, keys).replace("\"1 s\"", "\"0.3 s\"");
        bench.write("scene.toml", text);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "a.rec"]).expect(0);
        bench.pliant(&["replay", "a.rec", "--verify", "-q"]).expect(0);
    }
}

#[test]
fn keys_that_a_kind_does_not_read_and_odd_values_are_refused() {
    let bench = Bench::new();
    let body =
        "shape = { kind = \"box\", cells = 4, size = [0.04, 0.04, 0.04] }\nmaterial = { plugin = \"mass-spring\" }";
    let spot = SurfacePoint { point: Vec3::new(0.0, 0.0, 0.02), normal: Vec3::z() };
    for (kind, keys, parts) in [
        ("touch", "", ["edit kind `touch` does not read `radius`", "none of these keys"]),
        ("grab", "strength = 3", ["edit kind `grab` does not read `strength`", "`radius`, `falloff`, `limit`"]),
        ("inflate", "strength = \"3 mm\"", ["strength of a `inflate`", "a pressure"]),
        ("smooth", "strength = -1", ["strength is -1 Hz", "a number above 0"]),
        ("smooth", "symmetry = \"xx\"", ["symmetry \"xx\"", "one or more of x, y and z"]),
        ("smooth", "falloff = \"soft\"", ["soft", "constant"]),
    ] {
        bench.write("scene.toml", scene(body, spot, &way(kind), kind, keys));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2).says(&parts);
    }
}

#[test]
fn edits_work_on_sheets() {
    let bench = Bench::new();
    let body = "shape = { kind = \"sheet\", cells = 32, rows = 32, size = [0.1, 0.1, 0] }\nsheet = {}\nmaterial = { plugin = \"cloth\", params = { \
                young-warp = 300, young-weft = 300, poisson = 0.2, damping-time = \"5 ms\" } }\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, -0.049, 1]]\n\
                [[body.fixed]]\nbox = [[-1, 0.049, -1], [1, 1, 1]]";
    for (kind, keys) in KINDS {
        let spot = SurfacePoint { point: Vec3::zeros(), normal: Vec3::z() };
        let text = scene(body, spot, &way(kind), kind, &keys.replace("1 kPa", "20 Pa"));
        let text = text.replace("duration = \"1 s\"", "duration = \"1 s\"\nintegrator = \"backward-euler\"");
        let mut session = opened(&bench, &text.replace("500 N/m", "100 N/m"));
        run(&mut session, 0.24);
        assert_eq!(session.events.count(EventKind::Quarantine), 0, "{kind}: {:?}", session.events.described());
        let (before, after) = surfaces(&mut session);
        let most = before.iter().zip(&after).map(|(a, b)| (b - a).norm()).fold(0.0, f64::max);
        assert!(most > 1e-6 && most < 0.05, "{kind}: {most} m");
        run(&mut session, 0.05);
        if !matches!(kind, "grab") {
            assert!(session.undo(), "{kind}");
            assert!(surfaces(&mut session).1 == before, "{kind}: taken back to the bit");
        }
    }
}

/// A user interface makes an edit stronger without another scene.
#[test]
fn a_brush_that_is_set_later_is_the_brush_of_a_scene() {
    let bench = Bench::new();
    bench.pliant(&["sample", "elephant", "-o", "model.obj"]).expect(0);
    let place = flank(&bench);
    for (kind, strength) in [
        ("inflate", "Pa"),
        ("deflate", "Pa"),
        ("smooth", "Hz"),
        ("flatten", "Hz"),
        ("pinch", "Hz"),
        ("relax", "Hz"),
        ("grow", "Hz"),
        ("shrink", "Hz"),
    ] {
        let number = if strength == "Pa" { 400.0 } else { 3.0 };
        let after = |factor: f64, falloff: &str, command: Option<SessionCommand>| {
            let keys = format!("strength = \"{} {strength}\"\nfalloff = \"{falloff}\"", factor * number);
            let mut session = opened(&bench, &scene(SOLID, place, &way(kind), kind, &keys));
            if let Some(command) = command {
                assert!(session.apply(command));
            }
            run(&mut session, 0.2);
            surfaces(&mut session).1
        };
        let set = SessionCommand::SetBrush { strength: 2.0, falloff: Falloff::Linear };
        let later = after(1.0, "smooth", Some(set));
        assert!(later == after(2.0, "linear", None), "{kind}");
        assert!(later != after(1.0, "linear", None) && later != after(2.0, "smooth", None), "{kind}");
    }
}
