//! Seams that a scene closes from its start, and what counts as one part.

use pliant_engine::session::{Session, SessionCommand};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, NOW, open_file};

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

/// A panel of cloth of `columns` x `rows` cells of 5 mm, from `origin` on, whose lowest row of faces is the group `name`. Vertices are added to `text`,
/// which has `first` of them.
fn panel(
    text: &mut String,
    first: u32,
    name: &str,
    origin: [f64; 3],
    across: [f64; 3],
    [columns, rows]: [u32; 2],
) -> u32 {
    for row in 0..=rows {
        for column in 0..=columns {
            let p: Vec<f64> = (0..3)
                .map(|i| {
                    origin[i]
                        + if i == 0 { 0.005 * f64::from(column) } else { 0.0 }
                        + 0.005 * f64::from(row) * across[i]
                })
                .collect();
            *text += &format!("v {} {} {}\n", p[0], p[1], p[2]);
        }
    }
    let vertex = |row: u32, column: u32| first + row * (columns + 1) + column + 1;
    for row in 0..rows {
        *text += &if row == 0 { format!("g {name}\n") } else { format!("g rest-of-{name}\n") };
        for column in 0..columns {
            let [a, b, c, d] =
                [vertex(row, column), vertex(row, column + 1), vertex(row + 1, column + 1), vertex(row + 1, column)];
            *text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    first + (columns + 1) * (rows + 1)
}

/// Two panels whose seams are `gap` (m) apart, one above the other.
fn panels(columns: [u32; 2], rows: u32, gap: f64) -> String {
    let mut text = String::new();
    let first = panel(&mut text, 0, "left", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [columns[0], rows]);
    panel(&mut text, first, "right", [0.0, -gap, 0.0], [0.0, -1.0, 0.0], [columns[1], rows]);
    text
}

fn scene(bench: &Bench, model: &str, time: &str, body: &str) -> std::path::PathBuf {
    bench.write("panels.obj", model);
    let text = format!(
        "format = 1\n[time]\nduration = 3\n{time}\n[solver]\ntolerance = 1e-10\n[[body]]\nname = \"shirt\"\nmesh = \"panels.obj\"\nweld = false\nsheet = {{}}\n\
         material = {{ plugin = \"cloth\", params = {{ density = 0.2, damping-time = \"5 ms\" }} }}\n{body}\n\
         [[probe]]\nname = \"parts\"\nquantity = \"parts\"\n[output]\nparts = \"files\"\n"
    );
    bench.write("scene.toml", text)
}

/// kg, kg m/s, kg m: mass, momentum and first moment
fn sums(session: &Session) -> (f64, Vec3, Vec3) {
    let nodes = &session.bodies[0].system.nodes;
    let each = nodes.mass.iter().zip(&nodes.v).zip(&nodes.x);
    each.fold((0.0, Vec3::zeros(), Vec3::zeros()), |(mass, p, first), ((m, v), x)| {
        (mass + m, p + *m * v, first + *m * x)
    })
}

fn parts(session: &Session) -> u32 {
    session.bodies[0].parts().into_iter().max().map_or(0, |last| last + 1)
}

/// Elastic energy (J) where every node is displaced by a smooth field of its place at rest.
fn energy(session: &mut Session) -> f64 {
    let system = &mut session.bodies[0].system;
    for (x, rest) in system.nodes.x.iter_mut().zip(&system.nodes.rest) {
        let wave = Vec3::new((40.0 * rest.y).sin(), (30.0 * rest.x).cos(), (60.0 * rest.x + 20.0 * rest.y).sin());
        *x = rest + 1e-4 * wave;
    }
    system.energy(NOW).expect("finite")
}

/// Panels that lie border to border carry as the one panel that they make, whatever their size and however they are paired.
#[test]
fn panels_sewn_at_the_start_are_one_panel() {
    let mut random = Random(5);
    for case in 0..6 {
        let (columns, rows) = (3 + random.below(6) as u32, 2 + random.below(4) as u32);
        let bench = Bench::new();
        let count = (columns + 1) * (rows + 1);
        // In any order.
        let mut pairs: Vec<[u32; 2]> =
            (0..=columns).map(|i| if i % 2 == 0 { [i, count + i] } else { [count + i, i] }).collect();
        pairs.sort_by_key(|pair| u64::from(pair[0]) * 7919 % 31);
        let seam = match case % 2 {
            0 => "groups = [\"left\", \"right\"]".to_owned(),
            _ => format!("pairs = {pairs:?}"),
        };
        let time = ["integrator = \"backward-euler\"", "integrator = \"bdf2\""][case % 2];
        let path = scene(&bench, &panels([columns; 2], rows, 0.0), time, &format!("[[body.stitch]]\n{seam}"));
        let mut sewn = open_file(&path, 1, None);
        assert_eq!(parts(&sewn), 2, "before the first step");
        run(&mut sewn, 0.01);
        let mut one = String::new();
        panel(&mut one, 0, "left", [0.0, -0.005 * f64::from(rows), 0.0], [0.0, 1.0, 0.0], [columns, 2 * rows]);
        let bench = Bench::new();
        let free = "[[body.fixed]]\nbox = [[9, 9, 9], [10, 10, 10]]\npath = [[0, 0, 0, 0], [1, 1, 0, 0]]";
        let mut whole = open_file(&scene(&bench, &one, time, free), 1, None);
        run(&mut whole, 0.01);
        assert_eq!(sewn.bodies[0].system.nodes.len(), whole.bodies[0].system.nodes.len(), "{columns} x {rows}");
        assert_eq!((parts(&sewn), sewn.open_seam_pairs(0)), (1, 0), "{columns} x {rows}");
        let [a, b] = [&sewn, &whole].map(|session| sums(session).0);
        assert!((a / b - 1.0).abs() < 1e-12, "{a} kg, of one panel {b} kg");
        // The diagonals of the two lower panels are mirrored, which leaves bending along the seam and stretch.
        let [a, b] = [&mut sewn, &mut whole].map(energy);
        assert!(a > 0.0 && (a / b - 1.0).abs() < 0.2, "{columns} x {rows}: {a} J, of one panel {b} J");
    }
}

/// Panels that are apart are drawn together in the time of the seam, without a push from outside: mass, momentum and centre of mass stay.
#[test]
fn panels_that_are_apart_are_sewn_in_the_time_of_their_seam() {
    for (gap, seconds) in [(0.01, 0.2), (0.04, 0.4)] {
        for time in ["integrator = \"backward-euler\"", "integrator = \"bdf2\""] {
            let bench = Bench::new();
            let seam = format!("[[body.stitch]]\ngroups = [\"right\", \"left\"]\ntime = {seconds}");
            let mut session = open_file(&scene(&bench, &panels([6; 2], 4, gap), time, &seam), 1, None);
            session.step();
            let before = sums(&session);
            run(&mut session, 0.5 * seconds);
            assert!(parts(&session) == 2 && session.open_seam_pairs(0) == 7, "{gap} m in {time}: half way");
            run(&mut session, 0.5 * seconds + 0.05);
            let after = sums(&session);
            assert_eq!(
                (parts(&session), session.open_seam_pairs(0)),
                (1, 0),
                "{gap} m in {time}: {:?}",
                session.events.described()
            );
            assert!((after.0 / before.0 - 1.0).abs() < 1e-12, "mass");
            let fastest = session.bodies[0].system.nodes.v.iter().map(Vec3::norm).fold(0.0, f64::max);
            let scale = before.0 * gap / seconds;
            assert!(after.1.norm() < 1e-4 * scale, "{gap} m in {time}: momentum {:?}", after.1);
            assert!(
                (after.2 - before.2).norm() < 1e-4 * before.0 * gap,
                "{gap} m: centre of mass {:?}",
                after.2 - before.2
            );
            assert!(fastest < 10.0 * gap / seconds, "{gap} m in {time}: {fastest} m/s at the end");
        }
    }
}

/// A sewn sheet is one model for the program, one with an open seam two; and what cannot be sewn is told.
#[test]
fn the_program_counts_sewn_panels_as_one_part() {
    let bench = Bench::new();
    let seam = "[[body.stitch]]\ngroups = [\"left\", \"right\"]";
    let path = scene(&bench, &panels([4; 2], 3, 0.0), "dt = 0.002", seam);
    let text = std::fs::read_to_string(&path).expect("a scene").replace("duration = 3", "duration = 0.01");
    bench.write("scene.toml", text.replace("quantity = \"parts\"", "quantity = \"parts\"\nexpected = 1"));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0).says(&["one-part"]);
    bench.write(
        "scene.toml",
        text.replace(seam, "[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [1, 0.1, 0, 0]]"),
    );
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    assert!(bench.names("out").contains(&"final-part-2.obj".to_owned()), "{:?}", bench.names("out"));
    // A triangle after a vertex of no face.
    let relative = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n";
    let cases: [(String, &str, &[&str]); 9] = [
        (panels([4, 5], 3, 0.0), seam, &["5 vertices in a row", "group `right` has 6"]),
        (panels([4; 2], 3, 0.0), "[[body.stitch]]\ngroups = [\"left\", \"wrong\"]", &["no group `wrong`", "`right`"]),
        (panels([4; 2], 3, 0.0), "[[body.stitch]]\ngroups = [\"left\", \"left\"]", &["share vertex"]),
        (panels([4; 2], 3, 0.02), seam, &["are 0.0200 m apart", "a quarter of an edge", "`time`"]),
        (panels([4; 2], 3, 0.0), "[[body.stitch]]\npairs = [[0, 400]]", &["[0, 400]", "from 0 to 39"]),
        (panels([4; 2], 3, 0.0), "[[body.stitch]]\npairs = [[3, 3]]", &["[3, 3]", "different vertices"]),
        ("v 0 0 1\n".to_owned() + relative, "[[body.stitch]]\npairs = [[0, 3]]", &["vertex 0, which no face uses"]),
        (panels([4; 2], 3, 0.0), "[[body.stitch]]\ntime = 1", &["one of `groups` and `pairs`"]),
        (panels([4; 2], 3, 0.0), "[[body.stitch]]\ngroups = [\"left\", \"right\"]\ntime = -1", &["time", "-1"]),
    ];
    for (model, seam, said) in cases {
        scene(&bench, &model, "", seam);
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2);
        assert!(ran.err.starts_with("error: scene.toml:"), "{seam}: {}", ran.err);
        ran.says(said);
    }
    let solid = pliant_tests::box_scene("", seam, "");
    bench.write("scene.toml", solid);
    bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2).says(&["a solid; allowed is a body with `sheet`"]);
}

/// A layer does not hold the surface that a seam makes, so it is fixed as by a stitch.
#[test]
fn a_seam_that_closes_fixes_sculpt_layers() {
    let bench = Bench::new();
    let seam = "[[body.stitch]]\ngroups = [\"left\", \"right\"]";
    let mut session = open_file(&scene(&bench, &panels([4; 2], 3, 0.0), "", seam), 1, None);
    assert!(session.apply(SessionCommand::AddLayer { name: "early".into() }));
    run(&mut session, 0.01);
    assert_eq!(parts(&session), 1);
    let layers: Vec<_> = session.sculpt_layers().iter().map(|layer| (layer.is_fixed, layer.records)).collect();
    assert_eq!(layers, [(true, false)]);
}
