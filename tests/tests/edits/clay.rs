//! Clay: what is pressed into it stays without the edit keeping it, in local regions and whole bodies, and can be taken back.

use pliant_editor::SurfacePoint;
use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, models, scan};
use pliant_mesh::{Bounds, ObjDocument, Surface};
use pliant_plugin_api::abi;
use pliant_tests::{Bench, open_file, root};

/// m, the longest edge of every model
const SIZE: f64 = 0.1;
/// m, how deep the hand goes below where the surface was
const PRESS: f64 = 0.004;

/// The way of the hand: down to a place and away again, every half a second.
fn path(SurfacePoint { point: at, normal }: SurfacePoint, presses: u32) -> String {
    let row = |(time, height): (f64, f64)| {
        let p = at + height * normal;
        format!("[{time}, {}, {}, {}]", p.x, p.y, p.z)
    };
    let way = [(0.0, 0.012), (0.05, 0.01), (0.2, 0.008 - PRESS), (0.25, 0.008 - PRESS), (0.35, 0.03)];
    let ways = (0..presses).flat_map(|i| way.map(|(time, height)| (time + 0.5 * f64::from(i), height)));
    ways.map(row).collect::<Vec<_>>().join(", ")
}

/// A scene in which a ball of 8 mm presses a place along its normal from 0.05 s on, and is away again at 0.35 s.
fn scene(level: u32, region: &str, yield_strain: f64, spot: SurfacePoint) -> String {
    let at = spot.point;
    let path = path(spot, 1);
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

/// A block of 100 x 100 x 50 mm, its sides of squares, which cells of every level from 4 on fill, as OBJ.
fn block(cells: usize) -> String {
    let counts = [cells, cells, cells / 2];
    let mut number = std::collections::BTreeMap::new();
    let (mut points, mut faces) = (String::new(), String::new());
    let mut vertex = |at: [usize; 3]| {
        let next = number.len() + 1;
        *number.entry(at).or_insert_with(|| {
            let [x, y, z] = at.map(|k| 0.1 * (k as f64 / cells as f64));
            points += &format!("v {x} {y} {z}\n");
            next
        })
    };
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        for (i, j) in (0..counts[a]).flat_map(|i| (0..counts[b]).map(move |j| (i, j))) {
            let mut square = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                let mut at = [0; 3];
                (at[axis], at[a], at[b]) = (side * counts[axis], i + di, j + dj);
                vertex(at)
            });
            if side == 0 {
                square.reverse();
            }
            faces += &format!("f {} {} {} {}\n", square[0], square[1], square[2], square[3]);
        }
    }
    points + &faces
}

/// Volume (m^3) that the surface has gone inwards by: the dent without what has swelled beside it.
fn dent(session: &Session) -> f64 {
    let body = &session.bodies[0];
    let inwards = body.model.surface.triangles.iter().map(|t| {
        let [rest, now] = [&body.model.surface.points, &body.skin.x].map(|points| t.map(|v| points[v as usize]));
        let moved = (0..3).map(|i| now[i] - rest[i]).sum::<Vec3>() / 3.0;
        -0.5 * moved.dot(&(rest[1] - rest[0]).cross(&(rest[2] - rest[0])))
    });
    inwards.filter(|v| *v > 0.0).sum()
}

/// Change of the volume of the elements, m^3.
fn change_of_elements(session: &Session) -> f64 {
    let system = &session.bodies[0].system;
    let nodes = &system.nodes;
    let volume = |x: &[Vec3], t: &[u32]| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| x[t[i] as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
    };
    let sets = system.sets.iter().filter(|set| set.request().kind == abi::TETRAHEDRON);
    let tetrahedra = sets.flat_map(|set| set.nodes().chunks_exact(4));
    tetrahedra.map(|t| volume(&nodes.x, t) - volume(&nodes.rest, t)).sum()
}

/// Plastic flow keeps volume. What a body loses is elastic: by Betti's theorem (1 - 2 nu) / E times the sum of f . x over what holds it against the stresses
/// that are left, so it goes with 1 - 2 nu and does not grow with more flow.
#[test]
fn pressing_clay_again_and_again_keeps_its_volume() {
    let random = &mut Random(33);
    let scans = [0, 1].map(|genus| scan(genus, 3000, 0, random.next_u64()).text);
    for (name, text, level, smooth) in [
        ("box", &block(16), 4, false),
        ("box", &block(16), 5, false),
        ("scan", &scans[0], 5, true),
        ("scan with a handle", &scans[1], 5, true),
    ] {
        let mut lost = Vec::new();
        for poisson in [0.3, 0.45, 0.49] {
            let bench = Bench::new();
            bench.write("model.obj", text);
            // Of a block all of its upper side is highest.
            let middle = SurfacePoint { point: Vec3::new(0.0, 0.0, 0.025), normal: Vec3::z() };
            let spot = if name == "box" { middle } else { top(&bench) };
            let text = scene(level, "whole", 0.01, spot)
                .replace("poisson = 0.45", &format!("poisson = {poisson}"))
                .replace("region = ", &format!("smooth = {smooth}\nregion = "))
                .replace("duration = \"1 s\"", "duration = \"3 s\"")
                .replace(&path(spot, 1), &path(spot, 3));
            let mut session = opened(&bench, &text);
            moved(&mut session);
            let before = volume(&session);
            let mut changes = Vec::new();
            for _ in 0..3 {
                run(&mut session, 0.5);
                moved(&mut session);
                changes.push((volume(&session) - before) / dent(&session));
            }
            assert_eq!(session.events.count(EventKind::Quarantine), 0, "{:?}", session.events.described());
            let elements = change_of_elements(&session) / dent(&session);
            println!(
                "{name}, level {level}, nu {poisson}: change of volume over the dent {changes:.4?}, of elements {elements:.4}; dent {:.1} mm^3",
                1e9 * dent(&session)
            );
            let what = format!("{name}, level {level}, nu {poisson}: {changes:?} of the dent, elements {elements}");
            assert!((changes[2] - changes[0]).abs() < 0.02, "{what}: more flow, other volume");
            // The surface goes through cells, whose weights carry it.
            assert!((changes[2] - elements).abs() < 0.03, "{what}: surface and elements");
            lost.push(elements.abs());
        }
        assert!(
            lost[2] < 2.0 * (0.02 / 0.4) * lost[0] + 1e-3,
            "{name}, level {level}: elements lose {lost:?} of the dent"
        );
    }
}

/// Whatever part of the body a local region takes in, the body stays where it is: clay that hangs on a few cells would swing about them.
#[test]
fn a_local_region_of_any_size_keeps_a_body_of_clay_in_its_place() {
    let solids = models(6, 32).into_iter().filter(|m| m.closed && m.genus.is_some());
    for model in solids.take(3) {
        let bench = Bench::new();
        bench.write("model.obj", &model.text);
        let spot = top(&bench);
        for radius in [0.05, 0.065, 0.08, 0.09, 0.1, 0.11] {
            let text = scene(5, "local", 0.01, spot).replace("region = ", &format!("radius = {radius}\nregion = "));
            let mut session = opened(&bench, &text);
            run(&mut session, 0.7);
            assert_eq!(session.events.count(EventKind::Quarantine), 0, "{:?}", session.events.described());
            let (moved, cells) = (largest(&moved(&mut session)), session.frame().elements / 5);
            println!("{}, radius {radius} m: {cells} cells, moved by {:.2} mm", model.name, 1e3 * moved);
            // The hand goes no deeper.
            assert!(moved < PRESS, "{}, radius {radius} m, {cells} cells: moved by {moved} m", model.name);
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
