//! Pins and parameters painted by strokes: against fields of a scene, over materials, levels and integrators, with undo, cuts and replay.

use pliant_editor::SurfacePoint;
use pliant_engine::session::{Event, EventKind, HistoryCounts, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::models;
use pliant_tests::bar::{MATERIALS, STRAIN, energy};
use pliant_tests::{Bench, box_scene, open, open_file};

/// The painted factor of a bar's half.
const FACTOR: f64 = 4.0;

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

/// A bar of 32 cells along x about the origin, held as a whole, whose left end a finger presses. The half in reach of `edit` has x < 0.
fn bar(bench: &Bench, material: &str, params: &str, body: &str, edit: &str) -> Session {
    let (shape, path) = if material == "cloth" {
        let shape = "shape = { kind = \"sheet\", cells = 32, size = [0.16, 0.02, 0.0] }\nposition = [-0.08, -0.01, 0]\nsheet = {}";
        (shape, "[[0, -0.08, 0, 0.006], [0.02, -0.08, 0, 0.003]]")
    } else {
        let shape = "shape = { kind = \"box\", cells = 4, size = [0.16, 0.02, 0.02] }\ngrid = { level = 6, region = \"whole\" }";
        (shape, "[[0, -0.087, 0, 0], [0.02, -0.083, 0, 0]]")
    };
    let text = format!(
        "format = 1\n[time]\nduration = 1\nintegrator = \"backward-euler\"\n[[body]]\n{shape}\n[body.material]\nplugin = \"{material}\"\n\
         params = {{ {params} }}\n{body}\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]\n[[device]]\nname = \"hand\"\nparams = {{ path = {path} }}\n\
         [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\n[[edit]]\ntool = \"finger\"\nradius = 0.0804\n{edit}\n"
    );
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    session.keep_history();
    run(&mut session, 0.2);
    session
}

/// Masses, forces and energies are those of a field of the scene with the same factor, to the bit.
#[test]
fn a_painted_half_of_a_bar_is_the_half_of_a_box_field() {
    let densities = [("mass-spring", "", "density"), ("corotational", "", "density")];
    for (material, params, param) in MATERIALS.into_iter().chain(densities) {
        let bench = Bench::new();
        let field = format!("[[body.field]]\nparam = \"{param}\"\nbox = [[-1, -1, -1], [0, 1, 1]]\nfactor = {FACTOR}");
        let mut given = bar(&bench, material, params, &field, "kind = \"grab\"");
        let paint = format!("kind = \"paint\"\nparam = \"{param}\"\nstrength = {FACTOR}\nfalloff = \"constant\"");
        let mut painted = bar(&bench, material, params, "", &paint);
        let mut plain = bar(&bench, material, params, "", "kind = \"grab\"");
        let what = format!("{material} {params} {param}");
        let mass = |session: &Session| session.bodies[0].system.nodes.mass.clone();
        assert!(mass(&painted) == mass(&given), "{what}: masses");
        let fields = |session: &Session| -> Vec<f64> {
            session.bodies[0].system.sets.iter().flat_map(|set| set.fields().to_vec()).collect()
        };
        assert!(!fields(&painted).is_empty(), "{what}");
        assert!(fields(&painted) == fields(&given), "{what}: factors of elements");
        for strains in [[STRAIN, 0.0], [0.0, STRAIN], [STRAIN, -STRAIN]] {
            let [a, b, c] = [&mut painted, &mut given, &mut plain].map(|session| energy(session, strains));
            assert_eq!(a, b, "{what}: energy at {strains:?}");
            if strains[1] == 0.0 && param != "density" {
                assert!((a / c / FACTOR - 1.0).abs() < 1e-3, "{what}: {a} J painted, {c} J plain");
            }
        }
    }
}

/// A stroke over a model of 0.1 m: the hand stands over a place, presses it for the `first` edit, then does a `second` one beside it.
fn strokes(
    body: &str,
    time: &str,
    SurfacePoint { point: at, normal }: SurfacePoint,
    first: &str,
    second: &str,
) -> String {
    let beside = normal.cross(&Vec3::new(0.3, 0.5, 0.8)).normalize() * 0.02;
    let rows = [(0.0, 0.006, 0.0), (0.04, 0.0035, 0.0), (0.1, 0.0035, 0.0), (0.12, 0.006, 0.5), (0.2, 0.0, 1.0)];
    let path = rows.map(|(time, height, share)| {
        let p = at + height * normal + share * beside;
        format!("[{time}, {}, {}, {}]", p.x, p.y, p.z)
    });
    format!(
        "format = 1\n[time]\nduration = 1\n{time}\n[[body]]\n{body}\n[[device]]\nname = \"hand\"\nparams = {{ peak-force = \"50 N\", path = [{}] }}\n\
         [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"5 mm\"\nstiffness = \"500 N/m\"\n[[edit]]\ntool = \"finger\"\nend = 0.1\n{first}\n\
         [[edit]]\ntool = \"finger\"\nstart = 0.105\n{second}\n",
        path.join(", ")
    )
}

/// A place on the surface of a model scaled to 0.1 m about the origin, and its normal.
fn place(surface: &pliant_mesh::Surface, triangle: usize) -> SurfacePoint {
    let bounds = surface.bounds();
    let scale = 0.1 / bounds.longest_edge();
    let corners = surface.triangles[triangle % surface.triangles.len()]
        .map(|v| scale * (surface.points[v as usize] - bounds.centre()));
    SurfacePoint {
        point: corners.iter().sum::<Vec3>() / 3.0,
        normal: (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize(),
    }
}

fn surface(session: &mut Session) -> Vec<Vec3> {
    session.update_surface();
    session.bodies[0].skin.x.clone()
}

fn pinned(session: &Session) -> Vec<usize> {
    let body = &session.bodies[0];
    (0..body.model.surface.points.len()).filter(|v| body.is_pinned(*v as u32)).collect()
}

/// What is pinned while it is pressed stays there to the bit, whatever is done beside it; the rest moves.
#[test]
fn pinned_vertices_do_not_move_in_any_material_at_any_level_with_any_integrator() {
    let seconds = ["touch", "smooth", "grab", "grow", "touch\"\nrelease = \"keep"];
    let cases = [
        ("mass-spring", "integrator = \"symplectic-euler\"", 5, "local"),
        ("neo-hookean", "integrator = \"backward-euler\"", 5, "local"),
        ("corotational", "integrator = \"bdf2\"", 4, "whole"),
        (
            "neo-hookean\", params = { yield-strain = 0.02 }, name = \"",
            "integrator = \"implicit-midpoint\"",
            4,
            "local",
        ),
        ("mass-spring", "integrator = \"symplectic-euler\"\ngravity", 5, "whole"),
    ];
    let (mut moved, mut others) = (0, 0);
    for (i, model) in models(11, 12).iter().filter(|m| m.closed && m.genus.is_some()).take(3).enumerate() {
        for (k, (material, time, level, region)) in cases.into_iter().enumerate() {
            let bench = Bench::new();
            bench.write("model.obj", &model.text);
            let material = material.replace(", name = \"", "");
            let material = if material.contains("params") { material } else { format!("{material}\"") };
            let (time, gravity) = match time.strip_suffix("\ngravity") {
                Some(time) => (time, "gravity = [0, 0, -9.81]"),
                None => (time, ""),
            };
            let body = format!(
                "mesh = \"model.obj\"\nsize = 0.1\nmaterial = {{ plugin = \"{material} }}\ngrid = {{ level = {level}, region = \"{region}\" }}"
            );
            let spot = place(&pliant_mesh::Surface::from_document(&model.document()), 31 + 57 * i + 7 * k);
            let second = format!("kind = \"{}\"", seconds[(i + k) % seconds.len()]);
            let text = strokes(&body, time, spot, "kind = \"pin\"\nradius = \"15 mm\"", &second);
            let text = text.replace("format = 1", &format!("format = 1\n{gravity}"));
            let mut session = open_file(&bench.write("scene.toml", text), 1, None);
            let before = surface(&mut session);
            run(&mut session, 0.102);
            let what = format!("{material} {time} level {level} {region}, then {second}, on {}", model.name);
            let (held, then) = (pinned(&session), surface(&mut session));
            assert!(held.len() > 3, "{what}: {} vertices are pinned", held.len());
            moved += held.iter().filter(|v| (then[**v] - before[**v]).norm() > 1e-4).count();
            for _ in 0..20 {
                run(&mut session, 0.01);
                let now = surface(&mut session);
                let away = held.iter().find(|v| now[**v] != then[**v]);
                assert!(away.is_none(), "{what}: {:?}", away.map(|v| (v, then[*v], now[*v] - then[*v])));
            }
            assert_eq!(session.events.count(EventKind::Quarantine), 0, "{what}: {:?}", session.events.described());
            let now = surface(&mut session);
            others += usize::from((0..now.len()).any(|v| (now[v] - then[v]).norm() > 2e-6));
            assert_eq!(pinned(&session), held, "{what}");
        }
    }
    assert!(others > 12, "something else moves in {others} of 15 cases");
    assert!(moved > 10, "pins hold {moved} vertices away from where they rest");
}

/// A cantilever that bends under its weight, as a solid and as a sheet, with a hand that reaches its tip.
fn cantilever(sheet: bool, edits: &str) -> String {
    let body = if sheet {
        "shape = { kind = \"sheet\", cells = 12, size = [0.06, 0.02, 0.0] }\nposition = [-0.03, -0.01, 0]\nsheet = {}\n\
         material = { plugin = \"cloth\", params = { density = 0.3, damping-time = \"2 ms\" } }"
    } else {
        "shape = { kind = \"box\", cells = 12, size = [0.06, 0.02, 0.02] }\ngrid = { level = 4, region = \"whole\" }\n\
         material = { plugin = \"corotational\", params = { young = \"40 kPa\", damping-time = \"20 ms\" } }"
    };
    let top = if sheet { 0.0 } else { 0.01 };
    format!(
        "format = 1\ngravity = [0, 0, -9.81]\n[time]\nduration = 4\nintegrator = \"backward-euler\"\n[[body]]\n{body}\n[[body.fixed]]\n\
         box = [[-1, -1, -1], [-0.0249, 1, 1]]\n[[device]]\nname = \"hand\"\n[device.params]\n\
         path = [[0, 0.026, 0, {}], [0.02, 0.026, 0, {}], [0.04, 0.026, 0, {}], [0.2, 0.026, 0, {}], [0.22, 0.026, 0, {}], [0.24, 0.026, 0, 0.03]]\n\
         [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\nstiffness = \"100 N/m\"\n{edits}\n",
        top + if sheet { 0.004 } else { 0.0035 },
        top + if sheet { 0.004 } else { 0.0035 },
        top + 0.0045,
        top + 0.0045,
        top + 0.0035
    )
}

/// Height of the free end, m.
fn tip(session: &Session) -> f64 {
    let nodes = &session.bodies[0].system.nodes;
    let end = nodes.rest.iter().zip(&nodes.x).filter(|(rest, _)| rest.x > 0.0299);
    let (count, sum) = end.fold((0.0, 0.0), |(count, sum), (rest, x)| (count + 1.0, sum + x.z - rest.z));
    sum / count
}

#[test]
fn an_end_that_was_pinned_and_freed_sags_as_if_it_had_never_been_held() {
    for sheet in [false, true] {
        let edit = |kind: &str, start: f64, end: f64| {
            format!(
                "[[edit]]\nkind = \"{kind}\"\ntool = \"finger\"\nradius = \"12 mm\"\nstart = {start}\nend = {end}\n"
            )
        };
        let both = edit("pin", 0.0, 0.1) + &edit("unpin", 0.18, 0.26);
        let [mut plain, mut held, mut freed] =
            ["[[edit]]\nkind = \"touch\"\ntool = \"finger\"\nend = 0.05", &edit("pin", 0.0, 0.1), &both]
                .map(|edits| open(&cantilever(sheet, edits), 1));
        run(&mut freed, 0.17);
        run(&mut held, 0.17);
        assert!(
            tip(&freed) > -0.002 && freed.bodies[0].system.nodes.v.iter().all(|v| v.norm() < 0.02),
            "sheet {sheet}: {} m, {} m/s",
            tip(&freed),
            freed.bodies[0].system.nodes.v.iter().map(Vec3::norm).fold(0.0, f64::max)
        );
        // The first steps after it is free have the speed of a fall, not of a blow.
        let mut time = 0.17;
        while freed.bodies[0].system.nodes.constraint.iter().filter(|c| !c.is_free()).count()
            == held.bodies[0].system.nodes.constraint.iter().filter(|c| !c.is_free()).count()
        {
            run(&mut freed, 0.001);
            run(&mut held, 0.001);
            time += 0.001;
            assert!(time < 0.3, "sheet {sheet}: it is never freed");
        }
        run(&mut freed, 0.002);
        let fastest = freed.bodies[0].system.nodes.v.iter().map(Vec3::norm).fold(0.0, f64::max);
        assert!(fastest < 0.1, "sheet {sheet}: {fastest} m/s right after it was freed");
        [&mut plain, &mut held, &mut freed].into_iter().for_each(|session| run(session, 1.5));
        let [plain, held, freed] = [&plain, &held, &freed].map(tip);
        assert!(plain < -0.004, "sheet {sheet}: it sags by {plain} m");
        assert!(held > 0.3 * plain, "sheet {sheet}: pinned it sags by {held} m, free by {plain} m");
        assert!(
            (freed / plain - 1.0).abs() < 0.02,
            "sheet {sheet}: freed it sags by {freed} m, never held by {plain} m"
        );
    }
}

/// Everything that painting may change.
fn state(session: &mut Session) -> impl PartialEq + use<> {
    let x = surface(session);
    let body = &session.bodies[0];
    let fields: Vec<f64> = body.system.sets.iter().flat_map(|set| set.fields().to_vec()).collect();
    let nodes = &body.system.nodes;
    let held: Vec<bool> = nodes.constraint.iter().map(|c| c.is_free()).collect();
    (x, fields, nodes.mass.clone(), nodes.x.clone(), nodes.v.clone(), held, pinned(session))
}

#[test]
fn a_stroke_is_one_undo_and_comes_back_to_the_bit() {
    let solid = "shape = { kind = \"sphere\", cells = 24, size = [0.1, 0.1, 0.1] }\ngrid = { level = 5 }\n\
        material = { plugin = \"neo-hookean\", params = { young = \"10 kPa\" } }";
    let sheet = "shape = { kind = \"sheet\", cells = 20, size = [0.1, 0.1, 0.0] }\nposition = [-0.05, -0.05, 0.05]\nsheet = {}\n\
        material = { plugin = \"cloth\" }\n[[body.fixed]]\nbox = [[-1, -1, -1], [-0.049, 1, 1]]";
    let kinds = [
        "start = 0.01\nkind = \"pin\"",
        "start = 0.01\nkind = \"paint\"",
        "start = 0.01\nkind = \"paint\"\nparam = \"density\"\nstrength = 0.2",
    ];
    for body in [solid, sheet] {
        for kind in kinds {
            let kind = if body == sheet { kind.replace("density", "thickness") } else { kind.to_owned() };
            let spot = SurfacePoint { point: Vec3::new(0.0, 0.0, 0.05), normal: Vec3::z() };
            let text = strokes(body, "integrator = \"backward-euler\"", spot, &kind, "kind = \"unpin\"");
            let mut session = open(&text, 1);
            session.keep_history();
            run(&mut session, 0.01);
            let before = state(&mut session);
            run(&mut session, 0.091);
            assert_eq!(session.history(), HistoryCounts { done: 1, undone: 0 }, "{kind}");
            let after = state(&mut session);
            assert!(after != before);
            assert!(session.undo());
            assert!(state(&mut session) == before, "{kind}: taken back to the bit: {body}");
            assert!(session.redo());
            assert!(state(&mut session) == after, "{kind}: made again to the bit: {body}");
            run(&mut session, 0.1);
            assert!(pinned(&session).is_empty() || kind.contains("pin"));
        }
    }
}

#[test]
fn the_hand_feels_a_touch_while_the_body_is_painted_and_pinned() {
    let felt = |edit: &str| -> Vec<Vec3> {
        let text = box_scene("", "", "")
            .replace("duration = 0.05", "duration = 1")
            .replace("[0.05, 0.002, 0.0, 0.001]", "[0.05, 0.0, 0.0, 0.001]");
        let mut session = open(&text.replace("kind = \"touch\"", edit), 1);
        let mut forces = Vec::new();
        for _ in 0..200 {
            session.step();
            forces.push(session.frame().tools[0].force);
        }
        forces
    };
    let jump = |forces: &[Vec3]| forces.windows(2).map(|f| (f[1] - f[0]).norm()).fold(0.0, f64::max);
    let touch = felt("kind = \"touch\"");
    let stiffness = open(&box_scene("", "", ""), 1).tools[0].tool.coupling.stiffness;
    let (most, quiet) = (touch.iter().map(Vec3::norm).fold(0.0, f64::max), jump(&touch));
    for edit in ["kind = \"paint\"", "kind = \"paint\"\nstrength = 0.2", "kind = \"pin\"", "kind = \"unpin\""] {
        let forces = felt(edit);
        // What is held does not give way, so the coupling alone says how fast the force follows the hand: 5 mm in 30 ms.
        let rigid = if edit.contains("\"pin\"") { stiffness * 0.005 / 30.0 } else { 0.0 };
        // A hand in free air starts a contact with such steps, and a press of 3 mm may do so too.
        assert!(
            jump(&forces) < (1.5 * quiet + 0.01 * most).max(rigid),
            "{edit}: {} N in a step, a touch {quiet} N",
            jump(&forces)
        );
    }
    assert!(felt("kind = \"paint\"").last().unwrap().norm() > 1.02 * touch.last().unwrap().norm(), "stiffer");
}

#[test]
fn pieces_of_a_cut_body_inherit_what_was_painted() {
    for sheet in [false, true] {
        let body = if sheet {
            "shape = { kind = \"sheet\", cells = 20, size = [0.04, 0.04, 0.0] }\nposition = [-0.02, -0.02, 0.02]\nsheet = {}\n\
             material = { plugin = \"cloth\" }\n[[body.fixed]]\nbox = [[-1, -1, -1], [-0.019, 1, 1]]"
        } else {
            "shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }\ngrid = { level = 5, region = \"whole\" }\n\
             material = { plugin = \"corotational\" }\n[[body.fixed]]\nbox = [[-1, -1, -1], [-0.019, 1, 1]]"
        };
        let heavier = if sheet { "thickness" } else { "density" };
        let text = format!(
            "format = 1\n[time]\nduration = 1\nintegrator = \"backward-euler\"\n[[body]]\n{body}\n[[device]]\nname = \"hand\"\n\
             params = {{ path = [[0, 0, 0, 0.026], [0.02, 0, 0, 0.0235], [0.1, 0, 0, 0.0235], [0.12, 0, -0.04, 0.026], [0.13, 0, -0.04, 0.01], [0.4, 0, 0.04, 0.01]] }}\n\
             [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\nblade = {{ length = \"30 mm\", direction = [0, 0, 1], tear = 0 }}\n\
             [[edit]]\nkind = \"paint\"\nparam = \"{heavier}\"\nstrength = 10\ntool = \"finger\"\nend = 0.06\n\
             [[edit]]\nkind = \"pin\"\ntool = \"finger\"\nstart = 0.06\nend = 0.1\n[[edit]]\nkind = \"cut\"\ntool = \"finger\"\nstart = 0.13\n"
        );
        let mut session = open(&text, 1);
        session.keep_history();
        let mass = |session: &Session| session.bodies[0].system.nodes.mass.iter().sum::<f64>();
        session.step();
        let plain = mass(&session);
        run(&mut session, 0.115);
        let (painted, held) = (mass(&session), pinned(&session));
        assert!(painted > 1.003 * plain && held.len() > 3, "sheet {sheet}: {plain} kg, {painted} kg, {held:?}");
        let then = surface(&mut session);
        run(&mut session, 0.4);
        assert!(session.cuts().area > 0.0 || session.cuts().length > 0.0, "{:?}", session.events.described());
        assert!(
            (mass(&session) / painted - 1.0).abs() < 1e-9,
            "sheet {sheet}: {} kg, before the cut {painted} kg",
            mass(&session)
        );
        let (now, after) = (surface(&mut session), pinned(&session));
        assert!(
            after.len() >= held.len(),
            "sheet {sheet}: {} pinned vertices, before the cut {}",
            after.len(),
            held.len()
        );
        if sheet {
            assert!(held.iter().all(|v| now[*v] == then[*v]), "sheet {sheet}: pins hold through a cut");
        } else {
            // A cut changes how the surface follows the nodes, not where these are.
            assert!(held.iter().all(|v| (now[*v] - then[*v]).norm() < 1e-4), "sheet {sheet}: pins hold through a cut");
        }
        while session.undo() {}
        assert!((mass(&session) / plain - 1.0).abs() < 1e-12, "sheet {sheet}: {} kg of {plain}", mass(&session));
    }
}

#[test]
fn mirrored_hands_pin_mirrored_vertices() {
    let body = "shape = { kind = \"sphere\", cells = 24, size = [0.1, 0.1, 0.1] }\ngrid = { level = 5 }\nmaterial = { plugin = \"mass-spring\" }";
    let at = Vec3::new(0.3, 0.2, 0.4).normalize();
    let pin = "kind = \"pin\"\nradius = \"12 mm\"\nsymmetry = \"x\"";
    let place = SurfacePoint { point: 0.05 * at, normal: at };
    let mut session = open(&strokes(body, "", place, pin, "kind = \"touch\""), 1);
    run(&mut session, 0.1);
    let held = pinned(&session);
    let points = &session.bodies[0].model.surface.points;
    let mirrored = |v: &usize| {
        let image = Vec3::new(-points[*v].x, points[*v].y, points[*v].z);
        held.iter().any(|w| (points[*w] - image).norm() < 1e-9)
    };
    assert!(held.len() > 6 && held.iter().all(mirrored) && held.iter().any(|v| points[*v].x < -0.01), "{}", held.len());
}

#[test]
fn a_recorded_stroke_comes_back_to_the_bit() {
    let bench = Bench::new();
    let edits = "end = 0.04\n[[edit]]\nkind = \"pin\"\ntool = \"finger\"\nstart = 0.04\nend = 0.06\n[[edit]]\nkind = \"undo\"\nstart = 0.065";
    let text = box_scene("", "", edits).replace("duration = 0.05", "duration = 0.07");
    bench.write("scene.toml", text.replace("kind = \"touch\"", "kind = \"paint\""));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "first", "--record", "hand.rec"]).expect(0);
    bench.pliant(&["replay", "hand.rec", "--verify", "--out", "again", "--threads", "1"]).expect(0);
    assert_eq!(bench.read("first/nodes.csv"), bench.read("again/nodes.csv"));
}

#[test]
fn what_cannot_be_painted_is_refused_by_name() {
    let cases: [(&str, &[&str]); 6] = [
        (
            "kind = \"paint\"\nparam = \"poisson\"",
            &["material `mass-spring` of body `block`", "`poisson` cannot vary", "young, density"],
        ),
        ("kind = \"paint\"\nstrength = 11", &["strength of a `paint` is 11", "0.1 to 10"]),
        ("kind = \"paint\"\nstrength = \"2 Hz\"", &["`2 Hz` is not a number"]),
        ("kind = \"pin\"\nstrength = 2", &["`pin` does not read `strength`", "it reads `radius`"]),
        ("kind = \"pin\"\nfalloff = \"linear\"", &["`pin` does not read `falloff`"]),
        ("kind = \"touch\"\nparam = \"young\"", &["`touch` does not read `param`"]),
    ];
    for (edit, said) in cases {
        let bench = Bench::new();
        bench.write("scene.toml", box_scene("", "", "").replace("kind = \"touch\"", edit));
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2);
        assert!(ran.err.starts_with("error: scene.toml:"), "{edit}: {}", ran.err);
        ran.says(said);
    }
    let bench = Bench::new();
    let range = "params = { young = \"5e11 Pa\" } }";
    let text = box_scene("", "", "")
        .replace("kind = \"touch\"", "kind = \"paint\"")
        .replace("\"mass-spring\" }", &format!("\"mass-spring\", {range}"));
    bench.write("scene.toml", text);
    bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2).says(&["paint of `young`", "4 times"]);
}

/// An explicit integrator is not led beyond the steps it may divide: it paints as far as it can follow and says so.
#[test]
fn painting_stays_within_what_the_integrator_follows() {
    let time = "integrator = \"symplectic-euler\"\nmost-substeps = 14";
    let text = box_scene(time, "", "end = 0.3").replace("duration = 0.05", "duration = 0.4");
    let text = text
        .replace("kind = \"touch\"", "kind = \"paint\"\nstrength = 10\nradius = \"20 mm\"")
        .replace("[0.05, 0.002", "[0.35, 0.002");
    let mut session = open(&text.replace("\"mass-spring\" }", "\"mass-spring\", params = { young = \"60 kPa\" } }"), 1);
    run(&mut session, 0.35);
    let most = session.bodies[0].painted_stiffening();
    assert!(most > 1.0 && most <= session.bodies[0].most_stiffening && most < 10.0, "{most}");
    let told =
        |(kind, event): &(EventKind, Event)| *kind == EventKind::Message && event.text.contains("symplectic-euler");
    assert!(session.events.described().iter().any(told), "the integrator that sets the limit is named");
    assert_eq!(
        session.events.count(EventKind::Quarantine) + session.events.count(EventKind::Unstable),
        0,
        "{:?}",
        session.events.described()
    );
}

/// A local region keeps what pins hold away from rest, with free nodes around in equilibrium, when the hand is elsewhere, and after an undo.
#[test]
fn pins_away_from_rest_hold_a_shape_after_the_hand_has_left() {
    let text = "format = 1\n[time]\nduration = 2\nintegrator = \"backward-euler\"\n[[body]]\n\
        shape = { kind = \"sphere\", cells = 24, size = [0.1, 0.1, 0.1] }\ngrid = { level = 6, radius = 0.015 }\n\
        material = { plugin = \"neo-hookean\", params = { young = \"10 kPa\", damping-time = \"5 ms\" } }\n[[device]]\nname = \"hand\"\n\
        params = { path = [[0, 0, 0, 0.056], [0.03, 0, 0, 0.05], [0.1, 0, 0, 0.05], [0.12, 0, 0, 0.07], [0.15, 0.1, 0, 0], [0.2, 0.051, 0, 0]] }\n\
        [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\n[[edit]]\nkind = \"pin\"\ntool = \"finger\"\nradius = \"5 mm\"\n\
        start = 0.06\nend = 0.1\n[[edit]]\nkind = \"paint\"\ntool = \"finger\"\nstart = 0.8\nend = 0.9\n\
        [[edit]]\nkind = \"touch\"\ntool = \"finger\"\nend = 0.05\n";
    let mut session = open(text, 1);
    session.keep_history();
    run(&mut session, 0.1);
    let (held, then) = (pinned(&session), surface(&mut session));
    run(&mut session, 0.7);
    let before = state(&mut session);
    let check = |session: &mut Session| {
        let now = surface(session);
        assert!(held.len() > 3 && held.iter().all(|v| now[*v] == then[*v]));
        let rest = &session.bodies[0].model.surface.points;
        let away = held.iter().map(|v| (now[*v] - rest[*v]).norm()).fold(0.0, f64::max);
        assert!(away > 5e-4, "pins hold a dent of {away} m");
        let nodes = &session.bodies[0].system.nodes;
        let near = |i: &usize| nodes.constraint[*i].is_free() && nodes.rest[*i].z > 0.03;
        let free: Vec<usize> = (0..nodes.x.len()).filter(near).collect();
        let bent = free.iter().map(|i| (nodes.x[*i] - nodes.rest[*i]).norm()).fold(0.0, f64::max);
        let fastest = free.iter().map(|i| nodes.v[*i].norm()).fold(0.0, f64::max);
        assert!(bent > 0.05 * away, "{} free nodes around the dent give way by {bent} m", free.len());
        assert!(fastest < 1e-4, "they rest: {fastest} m/s");
    };
    check(&mut session);
    run(&mut session, 0.11);
    assert!(state(&mut session) != before);
    assert!(session.undo());
    assert!(state(&mut session) == before, "taken back to the bit");
    run(&mut session, 0.05);
    check(&mut session);
}
