//! Fibres of solids: a rod that they twist, what scenes may say of them and what is refused, edits of the shape at rest, and bytes.

use pliant_engine::body::RestChange;
use pliant_engine::session::Session;
use pliant_mesh::testing::Random;
use pliant_plugin_api::abi;
use pliant_solver::{Pool, Vec3};
use pliant_tests::bar::{FACTORS, STRAIN, energy, halves, open_bar};
use pliant_tests::{Bench, NOW, box_scene, open, root};

/// A bar along x about the origin, level 5: 16 cells along x.
const BAR: &str =
    "shape = { kind = \"box\", cells = 8, size = [0.08, 0.04, 0.04] }\ngrid = { level = 5, region = \"whole\" }";
const MATERIAL: &str = "fibre-reinforced";

/// The bar with entries of fibres, after a step.
fn bar(body: &str, params: &str, fibres: &str) -> Session {
    open_bar(&Bench::new(), body, MATERIAL, params, fibres)
}

/// The middle at rest (m) and the direction of each tetrahedron of the first body.
fn directions(session: &Session) -> Vec<(Vec3, Vec3)> {
    let system = &session.bodies[0].system;
    let set = system.sets.iter().find(|set| set.has(abi::WANTS_DIRECTIONS)).expect("tetrahedra");
    let middle = |nodes: &[u32]| nodes.iter().map(|n| system.nodes.rest[*n as usize]).sum::<Vec3>() / 4.0;
    let directions = set.directions();
    assert_eq!(directions.len(), set.count());
    set.nodes().chunks(4).map(middle).zip(directions.iter().map(|d| Vec3::from(*d))).collect()
}

/// Rotation (rad) about z of the rim of the scene's rod between 50 mm below and 10 mm above its middle, where its ends do not matter.
fn twist(level: u32, helix_angle: f64) -> f64 {
    let text = std::fs::read_to_string(root().join("scenes/fibre-twist.toml")).expect("the scene");
    // A tenth of the weight, so that strains are small.
    let text = text.replace("level = 6", &format!("level = {level}")).replace("-9.81", "-0.981");
    let mut session = open(&text.replace("\"60 deg\"", &format!("\"{helix_angle} deg\"")), 1);
    session.step();
    session.update_surface();
    let body = &session.bodies[0];
    let at = |height: f64| {
        let pairs = body.model.surface.points.iter().zip(body.skin.x.iter());
        let rim = pairs.filter(|(r, _)| (r.z - height).abs() < 1e-6 && r.xy().norm() > 0.0199);
        let turns: Vec<f64> = rim.map(|(r, x)| (r.x * x.y - r.y * x.x).atan2(r.x * x.x + r.y * x.y)).collect();
        assert!(turns.len() > 30, "{} vertices", turns.len());
        turns.iter().sum::<f64>() / turns.len() as f64
    };
    at(-0.05) - at(0.01)
}

/// The same by the linear theory of docs/numerics.md.
fn theory(helix_angle: f64) -> f64 {
    let (young, nu, k, radius, length) = (2e4, 0.45, 2e4, 0.02, 0.16);
    let (s, c) = helix_angle.to_radians().sin_cos();
    let (shear, along, both) = (young / (2.0 * (1.0 + nu)), s * s - nu * c * c, s * c);
    let rate = -along * 4.0 / 3.0 * k * both / (shear + k * both * both) / radius;
    let modulus = young + k * along * along * (1.0 - 8.0 / 9.0 * k * both * both / (shear + k * both * both));
    // The strain at a height is the weight below it over the modulus.
    let weight = |z: f64| 1000.0 * 0.981 * (z + 0.5 * length).powi(2) / 2.0 / modulus;
    -rate * (weight(0.01) - weight(-0.05))
}

#[test]
fn a_hanging_rod_is_twisted_by_helices_as_theory_says() {
    for angle in [60.0, 45.0] {
        let exact = theory(angle);
        let [coarse, fine] = [5, 6].map(|level| twist(level, angle));
        let [a, b] = [coarse, fine].map(|found| 1.0 - found / exact);
        println!("{angle} deg: {coarse:.4}, {fine:.4} rad of {exact:.4}");
        assert!(exact > 0.0 && b > 0.0 && b < 0.16, "{angle} deg: {fine} of {exact} rad");
        // An order of about one, and with it the extrapolated value.
        assert!((0.7..1.6).contains(&(a / b).log2()), "{angle} deg: {a} {b}");
        assert!((2.0 * fine - coarse - exact).abs() < 0.05 * exact, "{angle} deg: {fine} {coarse} of {exact}");
    }
}

#[test]
fn the_other_hand_of_helices_turns_the_other_way_and_lines_along_the_axis_do_not() {
    let [right, left, straight] = [60.0, -60.0, 90.0].map(|angle| twist(5, angle));
    assert!(right > 0.002 && (right + left).abs() < 0.02 * right, "{right} {left}");
    assert!(straight.abs() < 0.01 * right, "{straight} of {right}");
}

/// In each cell the last entry that applies counts, at the middle of the cell; a level or a region changes nothing of it.
#[test]
fn entries_give_each_cell_the_direction_at_its_middle() {
    let bench = Bench::new();
    bench.write("lines.csv", "# x y z dx dy dz\n-0.03, 0, 0, 1, 0, 0\n0.03, 0, 0, 0, -2, 0\n");
    let fibres = "[[body.fibre]]\ndirection = [0, 0, 3]\n\
         [[body.fibre]]\nbox = [[-1, -1, -1], [0, 1, 1]]\naround = { axis = [2, 0, 0], point = [0, 0, 0] }\n\
         [[body.fibre]]\nball = [0.04, 0, 0]\nradius = 0.015\nalong = [[0, -1, 0], [0, 1, 0]]\n";
    for (level, region) in [(4, "whole"), (5, "whole"), (5, "local")] {
        let grid = BAR.replace("level = 5, region = \"whole\"", &format!("level = {level}, region = \"{region}\""));
        let text = format!(
            "format = 1\n[time]\nduration = 0.01\n[[body]]\nname = \"block\"\n{grid}\nmaterial = {{ plugin = \"{MATERIAL}\" }}\n{fibres}\n{}",
            box_scene("", "", "")
                .split_once("[[device]]")
                .map(|(_, rest)| format!("[[device]]{rest}"))
                .expect("a device")
        );
        let mut session = open(&text.replace("[0.45, 0.55, 2.0]", "[0.45, 0.55, 3.0]"), 1);
        (0..25).for_each(|_| session.step());
        let all = directions(&session);
        assert!(all.len() > 50, "level {level}, {region}: {} elements", all.len());
        let edge = session.bodies[0].discretization.edge();
        let mut seen = [0; 3];
        for cell in all.chunks(5) {
            let middle = cell.iter().map(|(middle, _)| middle).sum::<Vec3>() / 5.0;
            // The five middles of a cell have their mean in its middle.
            let expected = if (middle - Vec3::new(0.04, 0.0, 0.0)).norm() <= 0.015 {
                seen[2] += 1;
                Vec3::y()
            } else if middle.x <= 0.0 {
                seen[1] += 1;
                Vec3::x().cross(&middle).normalize()
            } else {
                seen[0] += 1;
                Vec3::z()
            };
            for (_, direction) in cell {
                assert!(
                    (direction - expected).norm() < 1e-9,
                    "level {level}, {middle:?} of edge {edge}: {direction:?}"
                );
            }
        }
        assert!(region == "local" || seen.iter().all(|count| *count > 0), "{seen:?}");
    }
    // Between two points of a file: the line turned from x to y, whatever the sign of either.
    let fibres = format!("[[body.fibre]]\ncsv = {:?}", bench.path("lines.csv"));
    for (middle, direction) in directions(&bar(BAR, "", &fibres)) {
        assert!((direction.norm() - 1.0).abs() < 1e-12 && direction.z == 0.0, "{middle:?}: {direction:?}");
        let nearer_to_x = middle.x < 0.0;
        assert_eq!(direction.x.abs() > direction.y.abs(), nearer_to_x, "{middle:?}: {direction:?}");
    }
}

/// Turns of a body, as a scene says them, and as a matrix.
fn quarter_turn(axis: usize) -> (String, [Vec3; 3]) {
    let mut along = [0; 3];
    along[axis] = 1;
    let unit = |i: usize| Vec3::from_fn(|j, _| if i == j { 1.0 } else { 0.0 });
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut columns = [Vec3::zeros(); 3];
    (columns[axis], columns[next], columns[last]) = (unit(axis), unit(last), -unit(next));
    (format!("rotation = {{ axis = {along:?}, angle = \"90 deg\" }}"), columns)
}

fn random_vector(random: &mut Random) -> Vec3 {
    Vec3::from_fn(|_, _| 2.0 * random.unit() - 1.0)
}

/// Energy (J) where each node goes from its place at rest p to `map(p)`.
fn energy_at(session: &mut Session, map: impl Fn(Vec3) -> Vec3) -> f64 {
    let system = &mut session.bodies[0].system;
    for (x, rest) in system.nodes.x.iter_mut().zip(&system.nodes.rest) {
        *x = map(*rest);
    }
    system.energy(NOW).expect("finite")
}

/// A quarter turn of the model with `axes = "model"` is the turned body: every state has the energy of the same state before the turn.
#[test]
fn a_body_that_is_turned_with_its_fibres_is_the_same_body() {
    let mut random = Random(7);
    for trial in 0..6 {
        let (turn, columns) = quarter_turn(trial % 3);
        let (line, level) = (random_vector(&mut random), 3 + trial % 2);
        let body = BAR.replace("level = 5", &format!("level = {level}"));
        let fibres =
            format!("[[body.fibre]]\naxes = \"model\"\ndirection = [{:?}, {:?}, {:?}]", line.x, line.y, line.z);
        let params = "fibre-stiffness = 3e4, fibre-stiffening = 0.5";
        let mut before = bar(&body, params, &fibres);
        let mut after = bar(&format!("{turn}\n{body}"), params, &fibres);
        let turned = |p: Vec3| columns[0] * p.x + columns[1] * p.y + columns[2] * p.z;
        let exact = turned(line.normalize());
        assert!(directions(&after).iter().all(|(_, d)| (d - exact).norm() < 1e-12), "{turn}");
        let (stretch, rows) = (1.2, [(); 3].map(|()| 0.2 * random_vector(&mut random)));
        let map = |p: Vec3| stretch * p + Vec3::new(rows[0].dot(&p), rows[1].dot(&p), rows[2].dot(&p));
        let back = |p: Vec3| Vec3::new(columns[0].dot(&p), columns[1].dot(&p), columns[2].dot(&p));
        let [a, b] = [energy_at(&mut before, map), energy_at(&mut after, |p| turned(map(back(p))))];
        assert!(a > 0.0 && (a / b - 1.0).abs() < 1e-9, "{turn}, level {level}: {a} J, {b} J");
        // Without the turn of the fibres it is another one.
        let mut other = bar(&format!("{turn}\n{body}"), params, &fibres.replace("model", "scene"));
        let c = energy_at(&mut other, |p| turned(map(back(p))));
        assert!((a / c - 1.0).abs() > 1e-4, "{turn}: {a} J, {c} J");
    }
}

/// A field of the fibres makes them stiffer in parts and leaves the matrix, and one of `young` the other way round.
#[test]
fn fields_of_matrix_and_fibres_go_together() {
    let (along, params) = ("[[body.fibre]]\ndirection = [1, 0, 0]\n", "fibre-stiffness = 5e3");
    let of = |params: &str, fields: &str| energy(&mut bar(BAR, params, &format!("{along}{fields}")), [STRAIN, STRAIN]);
    let (both, matrix) = (of(params, ""), of("fibre-stiffness = 0", ""));
    let mean = 0.5 * (FACTORS[0] + FACTORS[1]);
    let (fibres, soft) = (halves("fibre-stiffness", 1), halves("young", 0));
    for (fields, exact) in [
        (fibres.clone(), matrix + mean * (both - matrix)),
        (soft.clone(), mean * matrix + (both - matrix)),
        (fibres + &soft, mean * both),
    ] {
        let found = of(params, &fields);
        assert!((found / exact - 1.0).abs() < 1e-6, "{fields}: {found} J of {exact} J");
    }
}

/// Lines of the material go with an edit of the shape at rest, keep unit length, and come back to the bit with the shape.
#[test]
fn directions_follow_the_shape_at_rest_and_come_back() {
    let mut random = Random(11);
    for _ in 0..5 {
        let line = random_vector(&mut random).normalize();
        let fibres = format!("[[body.fibre]]\ndirection = [{:?}, {:?}, {:?}]", line.x, line.y, line.z);
        let mut session = bar(&BAR.replace("level = 5", "level = 4"), "", &fibres);
        let (before, rows) = (directions(&session), [(); 3].map(|()| 0.1 * random_vector(&mut random)));
        let map = |p: Vec3| p + Vec3::new(rows[0].dot(&p), rows[1].dot(&p), rows[2].dot(&p));
        let body = &mut session.bodies[0];
        let saved = body.save();
        let nodes = body.system.nodes.rest.iter().map(|r| map(*r) - r).collect();
        body.reshape(&mut RestChange { nodes, points: Vec::new() }).expect("taken");
        let exact = map(line).normalize();
        assert!((exact - line).norm() > 1e-3, "{rows:?}");
        assert!(directions(&session).iter().all(|(_, d)| (d - exact).norm() < 1e-9), "{exact:?}");
        // A state in which the lines have their new length is without stress.
        let least = energy_at(&mut session, |p| p);
        assert!(least < 1e-15, "{least} J");
        session.bodies[0].restore(&saved).expect("restored");
        assert_eq!(directions(&session), before);
    }
}

/// Everything that moves the first body, as bits: places, velocities, rest places, masses and the force of its elements.
fn state(session: &mut Session) -> Vec<u64> {
    let body = &mut session.bodies[0];
    let mut force = vec![Vec3::zeros(); body.system.nodes.len()];
    body.system.forces(&Pool::new(1), None, NOW, &mut force).expect("finite");
    let nodes = &body.system.nodes;
    let rows = [&nodes.rest, &nodes.x, &nodes.v, &force, &*body.skin.settled].into_iter().flatten().flatten();
    rows.chain(&nodes.mass).map(|value| value.to_bits()).collect()
}

/// A block whose fibres are circles around z, with a hand on a path and an edit.
fn edited(path: &str, tool: &str, edit: &str) -> Session {
    let mut session = open(
        &format!(
            r#"
            format = 1
            [time]
            duration = "1 s"
            integrator = "backward-euler"
            [[body]]
            shape = {{ kind = "box", cells = 8, size = [0.04, 0.04, 0.04] }}
            material = {{ plugin = "{MATERIAL}", params = {{ fibre-stiffness = 2e4, damping-time = "5 ms" }} }}
            grid = {{ level = 4, region = "whole" }}
            [[body.fibre]]
            around = {{ axis = [0, 0, 1], point = [1e-3, 2e-3, 0] }}
            [[body.fixed]]
            box = [[-1, -1, -1], [1, 1, -0.019]]
            [[device]]
            name = "hand"
            params = {{ path = {path} }}
            [[tool]]
            name = "tool"
            device = "hand"
            {tool}
            [[edit]]
            tool = "tool"
            {edit}
            "#
        ),
        1,
    );
    session.keep_history();
    session
}

/// Requires that each cell of an undeformed body has the circle at its middle.
fn assert_circles(session: &Session) {
    for cell in directions(session).chunks(5) {
        let middle = cell.iter().map(|(middle, _)| middle).sum::<Vec3>() / 5.0;
        let circle = Vec3::z().cross(&(middle - Vec3::new(1e-3, 2e-3, 0.0))).normalize();
        assert!(cell.iter().all(|(_, d)| (d - circle).norm() < 1e-9), "{middle:?}: {cell:?} instead of {circle:?}");
    }
}

#[test]
fn parts_of_cut_cells_have_the_fibres_of_their_cell_and_an_undo_is_exact() {
    let mut session = edited(
        "[[0.0, 0.0012, -0.03, 0.0], [0.05, 0.0012, 0.03, 0.0]]",
        "radius = \"1 mm\"\nblade = { length = \"60 mm\", direction = [0, 0, 1] }",
        "kind = \"cut\"\nend = \"0.06 s\"",
    );
    session.step();
    let (before, elements) = (state(&mut session), directions(&session).len());
    assert_circles(&session);
    (0..80).for_each(|_| session.step());
    assert!(directions(&session).len() > elements, "cells were cut");
    assert_circles(&session);
    let (cut, lines) = (state(&mut session), directions(&session));
    assert!(session.undo());
    assert_circles(&session);
    assert_eq!(directions(&session).len(), elements);
    assert!(before.len() < cut.len());
    assert!(session.redo());
    assert_eq!(directions(&session), lines);
}

#[test]
fn a_dent_that_is_kept_takes_its_fibres_along_and_an_undo_is_exact() {
    let mut session = edited(
        "[[0.0, 0.004, 0.006, 0.026], [0.03, 0.004, 0.006, 0.016], [0.06, 0.004, 0.006, 0.016]]",
        "radius = \"6 mm\"",
        "kind = \"touch\"\nrelease = \"keep\"\nend = \"0.05 s\"",
    );
    let before = {
        session.step();
        directions(&session)
    };
    (0..48).for_each(|_| session.step());
    let pressed = session.bodies[0].system.energy(NOW).expect("finite");
    (0..4).for_each(|_| session.step());
    let kept = session.bodies[0].system.energy(NOW).expect("finite");
    assert!(pressed > 1e-6 && kept < 1e-9 * pressed, "{pressed} J, then {kept} J");
    let after = directions(&session);
    let turned = before.iter().zip(&after).map(|((_, a), (_, b))| (a - b).norm()).fold(0.0, f64::max);
    assert!(turned > 0.05 && after.iter().all(|(_, d)| (d.norm() - 1.0).abs() < 1e-12), "{turned}");
    let state_kept = state(&mut session);
    assert!(session.undo());
    assert_eq!(directions(&session), before);
    assert!(session.redo());
    assert_eq!(directions(&session), after);
    assert!(state(&mut session) == state_kept, "made again to the bit");
}

/// Substeps of an explicit integrator follow from frequencies at one place, which may be one without fibres.
#[test]
fn a_local_region_is_planned_for_fibres_wherever_they_are() {
    let substeps = |fibres: &str, stiffness: f64| {
        let material = format!("\"{MATERIAL}\", params = {{ fibre-stiffness = {stiffness} }}");
        let text = box_scene("integrator = \"symplectic-euler\"", "", "").replace("\"mass-spring\"", &material);
        open(
            &text.replacen("[[device]]", &format!("[[body.fibre]]\ndirection = [0, 0, 1]\n{fibres}\n[[device]]"), 1),
            1,
        )
        .choices
        .substeps
    };
    let (whole, bare) = (substeps("", 1e5), substeps("", 0.0));
    let ball = substeps("ball = [0, 0, 0.02]\nradius = 0.005", 1e5);
    assert!(whole > bare && ball == whole, "{bare} without, {whole} with, {ball} with some");
}

/// A press of a body with fibres that keeps its dent: threads and a replay give the same bytes, and the fibres matter.
#[test]
fn threads_and_replays_give_the_same_bytes() {
    let scene = |fibres: &str| {
        let fibres = format!("{fibres}\n[[device]]");
        let text = box_scene("integrator = \"backward-euler\"", "", "release = \"keep\"\n");
        text.replacen("[[device]]", &fibres, 1).replace("mass-spring", MATERIAL)
    };
    let fibres = "[[body.fibre]]\naround = { axis = [0, 0, 1], point = [0, 0, 0], helix-angle = \"20 deg\" }";
    let bench = Bench::new();
    bench.write("scene.toml", scene(fibres));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "one", "--threads", "1", "--record", "hand.rec"]).expect(0);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "four", "--threads", "4", "--oversubscribe"]).expect(0);
    bench.pliant(&["replay", "hand.rec", "--verify", "-q", "--out", "again"]).expect(0);
    let bytes = |out: &str| bench.read(&format!("{out}/final.obj"));
    assert!(bytes("one") == bytes("four") && bytes("one") == bytes("again"));
    bench.write("scene.toml", scene("[[body.fibre]]\ndirection = [0, 0, 1]"));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "other"]).expect(0);
    assert!(bytes("one") != bytes("other"));
}

#[test]
fn what_fibres_cannot_be_is_refused() {
    let cases: [(&str, &[&str]); 17] = [
        ("", &["`fibre` has no direction", "`direction`, `around`, `along` and `csv`"]),
        ("direction = [0, 0, 0]", &["direction [0.0, 0.0, 0.0]", "not all 0"]),
        ("direction = [nan, 0, 1]", &["direction [NaN, 0.0, 1.0]", "three finite numbers"]),
        ("direction = [1, 0]", &["scene.toml:7"]),
        ("direction = [1, 0, 0]\ncsv = \"a.csv\"", &["`direction` and `csv`", "allowed is one of"]),
        ("direction = [1, 0, 0]\nball = [0, 0, 0]", &["`fibre` has `ball`", "`ball` and `radius`"]),
        ("direction = [1, 0, 0]\nball = [1, 0, 0]\nradius = 0.1", &["meets no part of the body", "0.02"]),
        ("direction = [1, 0, 0]\ngroup = \"muscle\"", &["no group `muscle`"]),
        ("around = { axis = [0, 0, 0], point = [0, 0, 0] }", &["axis [0.0, 0.0, 0.0]"]),
        (
            "axes = \"model\"\nalong = [[0, 0, 0], [\"5 mm\", 0, 0]]",
            &["a point with a unit", "units of the model's file"],
        ),
        (
            "axes = \"model\"\naround = { axis = [0, 0, 1], point = [0, \"5 mm\", 0], helix-angle = \"9 deg\" }",
            &["a point with a unit", "units of the model's file"],
        ),
        ("along = [[0, 0, 0]]", &["`along` has 1 points", "2 or more"]),
        ("along = [[0, 0, 0], [0, 0, 0]]", &["no direction at point 2"]),
        ("csv = \"none.csv\"", &["none.csv"]),
        ("csv = \"short.csv\"", &["short.csv: line 2: 0, 0, 0, 1", "six finite numbers"]),
        ("csv = \"zero.csv\"", &["zero.csv: line 1: direction [0.0, 0.0, 0.0]"]),
        (
            "direction = [1, 0, 0]\n[[body.fibre]]\ndirection = [0, 1, 0]",
            &["which they replace", "without a place first"],
        ),
    ];
    let scene = |material: &str, fibre: &str| {
        format!(
            "format = 1\n[[body]]\nshape = {{ kind = \"box\", cells = 2, size = [0.04, 0.04, 0.04] }}\n\
             material = {{ plugin = \"{material}\" }}\ngrid = {{ level = 3, region = \"whole\" }}\n[[body.fibre]]\n{fibre}\n\
             [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [1, 1e-9, 0, 0]]\n"
        )
    };
    let bench = Bench::new();
    bench.write("short.csv", "0, 0, 0, 1, 0, 0\n0, 0, 0, 1\n");
    bench.write("zero.csv", "0, 0, 0, 0, 0, 0\n");
    let refused = |text: String, said: &[&str]| {
        bench.write("scene.toml", text);
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]);
        assert_eq!(ran.code, 2, "{said:?}: {}", ran.err);
        assert!(ran.err.starts_with("error: scene.toml:"), "{said:?}: {}", ran.err);
        ran.says(said);
    };
    for (fibre, said) in cases {
        refused(scene(MATERIAL, fibre), said);
    }
    refused(
        scene("neo-hookean", "direction = [1, 0, 0]"),
        &["`neo-hookean` takes no fibre directions", "`fibre-reinforced`"],
    );
    let sheet =
        scene("cloth", "direction = [1, 0, 0]").replace("grid = { level = 3, region = \"whole\" }", "sheet = {}");
    refused(sheet, &["fibres of a sheet", "warp"]);
    // A material without directions is a body without fibres, and that is told.
    bench.write("scene.toml", scene(MATERIAL, "").replace("[[body.fibre]]\n", ""));
    let ran = bench.pliant(&["plan", "scene.toml"]).expect(0);
    ran.says(&["warning [no-fibres]", "`fibre-reinforced`", "`[[body.fibre]]`"]);
}
