//! Clay: what is pressed into it stays without the edit keeping it, in local regions and whole bodies, and can be taken back.

use pliant_editor::SurfacePoint;
use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::models;
use pliant_mesh::{Bounds, ObjDocument, Surface};
use pliant_tests::{Bench, open_file, root};

/// m, the longest edge of every model
const SIZE: f64 = 0.1;
/// m, how deep the hand goes below where the surface was
const PRESS: f64 = 0.004;

/// A scene in which a ball of 8 mm presses a place along its normal from 0.05 s on, and is away again at 0.35 s.
fn scene(level: u32, region: &str, yield_strain: f64, SurfacePoint { point: at, normal }: SurfacePoint) -> String {
    let row = |(time, height): (f64, f64)| {
        let p = at + height * normal;
        format!("[{time}, {}, {}, {}]", p.x, p.y, p.z)
    };
    let way = [(0.0, 0.012), (0.05, 0.01), (0.2, 0.008 - PRESS), (0.25, 0.008 - PRESS), (0.35, 0.03)];
    let path = way.map(row).join(", ");
    // The model's middle is in the origin: what is held is the lowest quarter of its height.
    let held = format!("[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, {}]]", -0.5 * at.z);
    let fixed = if region == "whole" { held.as_str() } else { "" };
    format!(
        r#"
        format = 1
        [time]
        duration = "1 s"
        dt = "4 ms"
        integrator = "backward-euler"
        [[body]]
        mesh = "model.obj"
        size = "100 mm"
        [body.material]
        plugin = "neo-hookean"
        params = {{ young = "50 kPa", poisson = 0.45, density = 1800, damping-time = "5 ms", yield-strain = {yield_strain}, flow-time = "2 ms" }}
        [body.grid]
        level = {level}
        region = "{region}"
        {fixed}
        [[device]]
        name = "hand"
        params = {{ interpolation = "smooth", peak-force = "50 N", path = [{path}] }}
        [[tool]]
        name = "thumb"
        device = "hand"
        radius = "8 mm"
        stiffness = "2000 N/m"
        [[edit]]
        kind = "touch"
        tool = "thumb"
        "#
    )
}

/// The place of a model that is highest, and the normal there, m, with the model as large as the scene makes it.
fn top(bench: &Bench) -> SurfacePoint {
    let document = ObjDocument::parse(bench.read("model.obj"), &bench.path("model.obj")).expect("an OBJ");
    let surface = Surface::from_document(&document);
    let Bounds { min, max } = surface.bounds();
    let (scale, centre) = (SIZE / (max - min).max(), min.lerp(&max, 0.5));
    let highest = surface.points.iter().max_by(|a, b| a.z.total_cmp(&b.z)).expect("a vertex");
    SurfacePoint { point: scale * (highest - centre), normal: Vec3::z() }
}

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

/// How far every vertex is from where it was handed in, m.
fn moved(session: &mut Session) -> Vec<Vec3> {
    session.update_surface();
    let body = &session.bodies[0];
    body.model.surface.points.iter().zip(&body.skin.x).map(|(a, b)| b - a).collect()
}

fn largest(moved: &[Vec3]) -> f64 {
    moved.iter().map(Vec3::norm).fold(0.0, f64::max)
}

/// Volume of the surface, m^3.
fn volume(session: &Session) -> f64 {
    let body = &session.bodies[0];
    let corners = body.model.surface.triangles.iter().map(|t| t.map(|v| body.skin.x[v as usize]));
    corners.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}

fn opened(bench: &Bench, text: &str) -> Session {
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    session.keep_history();
    session
}

#[test]
fn a_dent_in_clay_stays_where_one_in_an_elastic_body_goes_back() {
    let solids = models(6, 31).into_iter().filter(|m| m.closed && m.genus.is_some());
    for (i, model) in solids.take(2).enumerate() {
        let bench = Bench::new();
        bench.write("model.obj", &model.text);
        let spot = top(&bench);
        for (level, region) in [[(4, "local"), (4, "whole")], [(4, "local"), (5, "local")]][i] {
            let what = format!("{} level {level} {region}", model.name);
            let mut left = Vec::new();
            for yield_strain in [0.002, 0.0] {
                let mut session = opened(&bench, &scene(level, region, yield_strain, spot));
                moved(&mut session);
                let before = volume(&session);
                run(&mut session, 0.25);
                let pressed = largest(&moved(&mut session));
                assert!(pressed > 0.5 * PRESS, "{what}: pressed by {pressed} m");
                run(&mut session, 0.5);
                assert_eq!(session.events.count(EventKind::Quarantine), 0, "{what}: {:?}", session.events.described());
                let share = largest(&moved(&mut session)) / pressed;
                // Flow keeps the volume; what an elastic part takes off is a share of the strain at yield.
                let change = (volume(&session) / before - 1.0).abs();
                assert!(change < 0.01, "{what} yield {yield_strain}: volume changed by {change}");
                left.push(share);
            }
            assert!(left[0] > 0.6 && left[1] < 0.15, "{what}: {left:?} of the dent are left");
        }
    }
}

#[test]
fn a_dent_is_taken_back_and_made_again_to_the_bit() {
    let bench = Bench::new();
    bench.write("model.obj", pliant_mesh::sample::sample("elephant", 1).expect("a sample"));
    let mut session = opened(&bench, &scene(5, "local", 0.002, top(&bench)));
    run(&mut session, 0.3);
    let dent = moved(&mut session);
    assert!(session.undo());
    assert!(largest(&moved(&mut session)) == 0.0, "taken back to the bit");
    assert!(session.redo());
    assert!(moved(&mut session) == dent, "made again to the bit");
}

#[test]
fn a_session_of_clay_is_replayed_to_the_bit_and_keeping_its_shape_forgets_the_flow() {
    let bench = Bench::new();
    bench.write("model.obj", pliant_mesh::sample::sample("elephant", 1).expect("a sample"));
    let text = scene(4, "local", 0.002, top(&bench)).replace("duration = \"1 s\"", "duration = \"0.5 s\"");
    bench.write("scene.toml", &text);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "a.rec"]).expect(0);
    bench.pliant(&["replay", "a.rec", "-q", "--out", "again"]).expect(0);
    assert_eq!(bench.read("out/final.obj"), bench.read("again/final.obj"));
    let kept = text.replace("kind = \"touch\"", "kind = \"touch\"\nrelease = \"keep\"\nend = \"0.25 s\"");
    let mut session = opened(&bench, &kept);
    run(&mut session, 0.5);
    assert!(largest(&moved(&mut session)) > 0.5 * PRESS);
    let system = &session.bodies[0].system;
    assert!(system.sets.iter().flat_map(|set| set.history()).all(|value| *value == 0.0));
}

#[test]
fn the_shipped_scene_leaves_a_dent() {
    let bench = Bench::new();
    let scene = root().join("scenes/clay-press.toml");
    let scene = scene.to_str().expect("a path");
    for (yield_strain, is_clay) in [("0.02", true), ("0", false)] {
        let set = format!("body.0.material.params.yield-strain={yield_strain}");
        bench.pliant(&["run", scene, "-q", "--out", "out", "--set", &set, "--set", "time.duration=\"1 s\""]).expect(0);
        let summary = bench.summary("out");
        let probe = |name: &str| {
            let all = summary["probes"].as_array().expect("probes");
            let found = all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("{name} in {all:?}"));
            found["value"].as_f64().expect("a number")
        };
        let left = probe("dent that stays") / probe("largest depth");
        assert!(if is_clay { left > 0.6 } else { left < 0.1 }, "{yield_strain}: {left}");
    }
}
