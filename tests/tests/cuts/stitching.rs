//! What was cut, or lies border to border, is stitched: it carries as if it had always been one, with the momentum it had, and can be undone.

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, NOW, open, open_file};

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
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

/// kg, kg m/s, kg m: mass, momentum and first moment
fn sums(session: &Session) -> (f64, Vec3, Vec3) {
    let nodes = &session.bodies[0].system.nodes;
    let each = nodes.mass.iter().zip(&nodes.v).zip(&nodes.x);
    each.fold((0.0, Vec3::zeros(), Vec3::zeros()), |(mass, p, first), ((m, v), x)| {
        (mass + m, p + *m * v, first + *m * x)
    })
}

/// Two strips of cloth that lie border to border at y = 0, 60 mm long and 20 mm wide, or the strip that they make together.
fn strips(apart: bool) -> String {
    let (columns, rows) = (12, 8);
    let row_of = |row: i32| if apart && row > rows / 2 { row + 1 } else { row };
    let mut text = String::new();
    let mut rows_listed: Vec<i32> = (0..=rows).collect();
    if apart {
        rows_listed.insert(rows as usize / 2, rows / 2);
    }
    for row in rows_listed {
        for column in 0..=columns {
            text += &format!("v {} {} 0\n", 0.005 * f64::from(column), 0.005 * f64::from(row - rows / 2));
        }
    }
    let vertex = |row: i32, column: i32| row * (columns + 1) + column + 1;
    for row in 0..rows {
        // The upper strip has a row of vertices of its own at the seam.
        let (low, high) =
            if apart && row >= rows / 2 { (row + 1, row + 2) } else { (row, row_of(row + 1).min(row + 1)) };
        for column in 0..columns {
            let [a, b, c, d] =
                [vertex(low, column), vertex(low, column + 1), vertex(high, column + 1), vertex(high, column)];
            text += &if (row + column) % 2 == 0 {
                format!("f {a} {b} {c}\nf {a} {c} {d}\n")
            } else {
                format!("f {a} {b} {d}\nf {b} {c} {d}\n")
            };
        }
    }
    text
}

/// The strips with a finger that goes along the seam with an edit.
fn strip_scene(bench: &Bench, apart: bool, body: &str, edit: &str) -> Session {
    strip_scene_of(bench, &strips(apart), body, edit)
}

fn strip_scene_of(bench: &Bench, model: &str, body: &str, edit: &str) -> Session {
    bench.write("strip.obj", model);
    let text = format!(
        "format = 1\n[time]\nduration = 3\nintegrator = \"backward-euler\"\n[solver]\ntolerance = 1e-10\n[[body]]\nmesh = \"strip.obj\"\nweld = false\nsheet = {{}}\n\
         material = {{ plugin = \"cloth\", params = {{ density = 0.2, damping-time = \"5 ms\" }} }}\n{body}\n[[device]]\nname = \"hand\"\n\
         params = {{ path = [[0, 0.005, 0, 0.0038], [0.3, 0.055, 0, 0.0038], [0.32, 0.055, 0, 0.05]] }}\n\
         [[tool]]\nname = \"needle\"\ndevice = \"hand\"\nradius = \"4 mm\"\nstiffness = \"2000 N/m\"\n[[edit]]\nkind = \"{edit}\"\ntool = \"needle\"\nend = 0.31\n"
    );
    open_file(&bench.write("scene.toml", text), 1, None)
}

#[test]
fn strips_stitched_along_their_borders_carry_as_one_strip_does() {
    let bench = Bench::new();
    let ends =
        "[[body.fixed]]\nbox = [[-1, -1, -1], [1e-6, 1, 1]]\n[[body.fixed]]\nbox = [[0.0599, -1, -1], [1, 1, 1]]";
    let mut one = strip_scene(&bench, false, ends, "touch");
    let mut stitched = strip_scene(&bench, true, ends, "stitch\"\nradius = \"12 mm");
    let mut loose = strip_scene(&bench, true, ends, "touch");
    [&mut one, &mut stitched, &mut loose].into_iter().for_each(|session| run(session, 0.35));
    let count = |session: &Session| session.bodies[0].system.nodes.len();
    // The ends of the seam are fixed on both sides, and stay two each.
    assert_eq!([count(&stitched), count(&loose)], [count(&one) + 2, count(&one) + 13]);
    let [a, b, c] = [&mut one, &mut stitched, &mut loose].map(energy);
    // At its fixed ends the seam does not bend, for both sides are fixed there.
    assert!((b / a - 1.0).abs() < 1e-7, "{b} J, of one strip {a} J");
    assert!(a - c > 20.0 * (a - b).abs(), "loose strips do not bend together: {c} J, one strip {a} J");
    let [(a, ..), (b, ..)] = [&one, &stitched].map(sums);
    assert!((b / a - 1.0).abs() < 1e-12, "{b} kg, of one strip {a} kg");
    // Under a load across the seam as well.
    let pull = "[[body.fixed]]\nbox = [[-1, -1, -1], [1, -0.0199, 1]]\n[[body.fixed]]\nbox = [[-1, 0.0199, -1], [1, 1, 1]]\n\
        path = [[0.35, 0, 0, 0], [0.6, 0, 0.002, 0]]";
    let mut one = strip_scene(&bench, false, pull, "touch");
    let mut stitched = strip_scene(&bench, true, pull, "stitch\"\nradius = \"12 mm");
    [&mut one, &mut stitched].into_iter().for_each(|session| run(session, 1.0));
    let load = |session: &Session| -> f64 {
        let nodes = &session.bodies[0].system.nodes;
        let top = (0..nodes.len()).filter(|i| nodes.rest[*i].y > 0.0199);
        top.map(|i| session.reactions(0)[i].y).sum()
    };
    assert_eq!(count(&stitched), count(&one));
    let (a, b) = (load(&one), load(&stitched));
    assert!(a.abs() > 0.01 && (b / a - 1.0).abs() < 1e-6, "{b} N, of one strip {a} N");
    let [a, b] = [&mut one, &mut stitched].map(energy);
    assert!((b / a - 1.0).abs() < 1e-12, "{b} J, of one strip {a} J");
}

#[test]
fn a_join_keeps_mass_momentum_and_centre_of_mass() {
    let bench = Bench::new();
    let mut stitched = strip_scene(&bench, true, "", "stitch\"\nradius = \"12 mm");
    stitched.step();
    let mut random = Random(5);
    let nodes = &mut stitched.bodies[0].system.nodes;
    for i in 0..nodes.len() {
        nodes.v[i] = 0.01 * Vec3::new(random.unit(), random.unit(), random.unit());
        nodes.x[i].y += if nodes.rest[i].y > 1e-9 || i > 65 { 0.001 } else { 0.0 };
    }
    let before = (sums(&stitched), stitched.bodies[0].system.nodes.len());
    let seam = stitched.bodies[0].stitch(Vec3::new(0.03, 0.0, 0.0), 0.01).expect("a sheet");
    let after = (sums(&stitched), stitched.bodies[0].system.nodes.len());
    assert!(seam.has_joined && after.1 < before.1, "{seam:?}");
    let ((mass, p, first), (now_mass, now_p, now_first)) = (before.0, after.0);
    assert!((now_mass / mass - 1.0).abs() < 1e-12 && (now_p - p).norm() < 1e-12 * mass, "{p:?} {now_p:?}");
    assert!((now_first - first).norm() < 1e-12 * mass, "{first:?} {now_first:?}");
}

/// A hanging cloth is slit from its hem, and a wide needle goes along the slit and over the hem.
#[test]
fn a_wide_stitch_joins_the_sides_of_a_slit_and_leaves_the_hem() {
    let cases =
        [("alternating", 12, 0.02), ("regular", 20, 0.025), ("equilateral", 12, 0.02), ("irregular", 20, 0.025)];
    for (pattern, cells, radius) in cases {
        let text = format!(
            r#"
            format = 1
            gravity = [0, -9.81, 0]
            [time]
            dt = 0.002
            integrator = "backward-euler"
            [[body]]
            shape = {{ kind = "sheet", cells = {cells}, size = [0.2, 0.2, 0], pattern = "{pattern}" }}
            sheet = {{ warp = [1, 0, 0] }}
            material = {{ plugin = "cloth", params = {{ fabric = "interlock", damping-time = "20 ms" }} }}
            [[body.fixed]]
            box = [[-1, 0.1999, -1], [1, 1, 1]]
            [[device]]
            name = "knife"
            params = {{ path = [[0, 0.1, -0.02, -0.01], [0.25, 0.1, 0.15, -0.01], [0.3, 0.1, 0.15, -0.2]] }}
            [[device]]
            name = "hand"
            params = {{ path = [[0, 0.1, 0.14, 0.05], [0.35, 0.1, 0.14, 0.05], [0.4, 0.1, 0.14, 0.0045], [1, 0.1, 0.005, 0.0045], [1.05, 0.1, 0.005, 0.05]], peak-force = 50 }}
            [[tool]]
            name = "blade"
            device = "knife"
            radius = "1 mm"
            blade = {{ length = "30 mm", direction = [0, 0, 1] }}
            [[tool]]
            name = "needle"
            device = "hand"
            radius = "5 mm"
            stiffness = "2000 N/m"
            friction = [0, 0]
            [[edit]]
            kind = "cut"
            tool = "blade"
            end = 0.3
            [[edit]]
            kind = "stitch"
            tool = "needle"
            start = 0.35
            radius = {radius}
            "#
        );
        let mut session = open(&text, 1);
        run(&mut session, 1.1);
        let what = format!("{pattern} {cells} {radius}");
        let body = &session.bodies[0];
        let points = &body.model.surface.points;
        let welds = body.discretization.sheet().expect("a sheet").welds();
        assert!(welds.len() >= 8, "{what}: {} joins", welds.len());
        let apart = |(a, b): (&u32, &u32)| (points[*a as usize] - points[*b as usize]).norm();
        let widest = welds.iter().map(apart).fold(0.0, f64::max);
        // A blade that is close to a vertex may leave two on one side where the other has one.
        assert!(widest < 0.02 / f64::from(cells), "{what}: vertices {widest} m apart in the cloth have been joined");
    }
}

/// The free corners of a square of two triangles are laid on each other: joined, they would lie on the fold.
#[test]
fn a_join_that_the_material_refuses_leaves_the_sheet_as_it_was() {
    for (pattern, edge) in [("regular", 0.02), ("alternating", 0.1)] {
        let text = format!(
            r#"
            format = 1
            [time]
            dt = 0.002
            [[body]]
            shape = {{ kind = "sheet", cells = 1, size = [{edge}, {edge}, 0], pattern = "{pattern}" }}
            sheet = {{ warp = [1, 0, 0] }}
            material = {{ plugin = "cloth", params = {{ fabric = "interlock" }} }}
            [[device]]
            name = "hand"
            params = {{ path = [[0, 0, 0, 1]] }}
            [[tool]]
            name = "needle"
            device = "hand"
            radius = "5 mm"
            [[edit]]
            kind = "stitch"
            tool = "needle"
            "#
        );
        let mut session = open(&text, 1);
        let body = &mut session.bodies[0];
        let triangles = &body.model.surface.triangles;
        let free = |t: usize| triangles[t].into_iter().find(|n| !triangles[1 - t].contains(n)).expect("a free corner");
        let (a, b) = (free(0), free(1));
        let place = body.model.surface.points[a as usize];
        let near = body.system.nodes.x[a as usize] + Vec3::new(0.0, 0.0, 0.1 * edge);
        body.system.nodes.x[b as usize] = near;
        let before = body.system.nodes.x.clone();
        let refused = body.stitch(place, 0.5 * edge).expect_err("a side without area");
        assert!(refused.to_string().contains("area"), "{refused}");
        assert_eq!(body.system.nodes.x, before, "{pattern}");
        assert!(body.discretization.sheet().expect("a sheet").welds().is_empty(), "{pattern}");
        for _ in 0..10 {
            session.step();
        }
        let body = &session.bodies[0];
        assert!(body.frozen.is_none() && body.system.nodes.x.iter().all(|x| x.norm() < 10.0), "{:?}", body.frozen);
    }
}

#[test]
fn a_slit_in_hanging_cloth_that_is_stitched_hangs_as_if_it_had_not_been_cut() {
    let scene = |edits: &str| {
        format!(
            "format = 1\ngravity = [0, -9.81, 0]\n[time]\nduration = 4\nintegrator = \"backward-euler\"\n[[body]]\n\
             shape = {{ kind = \"sheet\", cells = 16, pattern = \"alternating\", size = [0.1, 0.1, 0] }}\nsheet = {{ warp = [1, 0, 0] }}\n\
             material = {{ plugin = \"cloth\", params = {{ density = 0.2, young-warp = 40, young-weft = 30, poisson = 0.2, damping-time = \"5 ms\" }} }}\n\
             [[body.fixed]]\nbox = [[-1, 0.0999, -1], [1, 1, 1]]\n[[device]]\nname = \"hand\"\n\
             params = {{ path = [[0, 0.021, 0.053, 0.02], [0.1, 0.079, 0.053, 0.02], [0.12, 0.079, 0.053, 0.05], [0.3, 0.018, 0.052, 0.05], [0.34, 0.018, 0.052, 0.0049], [0.9, 0.082, 0.052, 0.0049], [0.95, 0.05, 0.05, 0.08]] }}\n\
             [[tool]]\nname = \"hand\"\ndevice = \"hand\"\nradius = \"5 mm\"\nstiffness = \"60 N/m\"\n\
             blade = {{ length = \"40 mm\", direction = [0, 0, -1], tear = 0 }}\n{edits}"
        )
    };
    let edit = |kind: &str, start: f64, end: f64| {
        format!("[[edit]]\nkind = \"{kind}\"\ntool = \"hand\"\nstart = {start}\nend = {end}\n")
    };
    let cut = edit("cut", 0.0, 0.11);
    let stitch = cut.clone() + &edit("stitch", 0.3, 0.92);
    let [mut whole, mut slit, mut stitched] =
        ["".to_owned() + &edit("touch", 3.9, 3.95), cut, stitch].map(|edits| open(&scene(&edits), 1));
    stitched.keep_history();
    let counts: Vec<usize> = [0.2, 1.4]
        .map(|time| {
            run(&mut stitched, time);
            stitched.bodies[0].system.nodes.len()
        })
        .to_vec();
    [&mut whole, &mut slit].into_iter().for_each(|session| run(session, 1.6));
    assert!(counts[1] < counts[0], "nodes before and after the stitch: {counts:?}");
    let lowest = |session: &mut Session| {
        session.update_surface();
        session.bodies[0].skin.x.iter().map(|x| x.y).fold(f64::INFINITY, f64::min)
    };
    let [a, b, c] = [&mut whole, &mut slit, &mut stitched].map(lowest);
    assert_eq!(stitched.events.count(EventKind::Quarantine), 0);
    assert!(a - b > 2e-4, "a slit lets the cloth hang lower: {b} m, whole {a} m");
    assert!((c - a).abs() < 0.1 * (a - b), "stitched it hangs to {c} m, whole to {a} m, slit to {b} m");
    // The seam holds: its two sides are at one place.
    let body = &stitched.bodies[0];
    let sheet = body.discretization.sheet().expect("a sheet");
    assert!(
        sheet.welds().len() > 8
            && sheet.welds().iter().all(|(v, of)| body.skin.x[*v as usize] == body.skin.x[*of as usize])
    );
    // Undo opens it again, redo closes it.
    assert!(stitched.undo());
    assert_eq!(stitched.bodies[0].system.nodes.len(), counts[0]);
    assert!(stitched.redo());
    assert_eq!(stitched.bodies[0].system.nodes.len(), counts[1]);
    run(&mut stitched, 0.2);
}

#[test]
fn a_bar_that_is_cut_and_stitched_carries_as_before() {
    for (material, params) in [("mass-spring", ""), ("corotational", "poisson = 0.3"), ("neo-hookean", "")] {
        let text = format!(
            "format = 1\n[time]\nduration = 2\nintegrator = \"backward-euler\"\n[[body]]\nshape = {{ kind = \"box\", cells = 12, size = [0.08, 0.02, 0.02] }}\n\
             grid = {{ level = 5, region = \"whole\" }}\n[body.material]\nplugin = \"{material}\"\nparams = {{ {params} }}\n\
             [[body.fixed]]\nbox = [[-1, -1, -1], [-0.0399, 1, 1]]\n[[body.fixed]]\nbox = [[0.0399, -1, -1], [1, 1, 1]]\n\
             [[device]]\nname = \"hand\"\nparams = {{ path = [[0, 0.001, -0.02, 0.015], [0.1, 0.001, 0.02, 0.015], [0.12, 0.001, 0.02, 0.03], [0.14, 0.001, 0, 0.03], [0.16, 0.001, 0, 0.0135], [0.4, 0.001, 0, 0.0135]] }}\n\
             [[tool]]\nname = \"hand\"\ndevice = \"hand\"\nradius = \"4 mm\"\nblade = {{ length = \"40 mm\", direction = [0, 0, -1], tear = 0 }}\n\
             [[edit]]\nkind = \"cut\"\ntool = \"hand\"\nend = 0.11\n[[edit]]\nkind = \"stitch\"\ntool = \"hand\"\nradius = \"30 mm\"\nstart = 0.13\nend = 0.35\n"
        );
        let text = text.replace("direction = [0, 0, -1]", "direction = [0, 0, 1]").replace("0.015]", "-0.015]");
        let mut session = open(&text, 1);
        session.keep_history();
        let mut whole = open(&text, 1);
        whole.step();
        run(&mut session, 0.12);
        let (parts, nodes) = (
            session.bodies[0].discretization.lattice().expect("a solid").parts(),
            session.bodies[0].system.nodes.len(),
        );
        assert_eq!(
            parts.iter().max(),
            Some(&1),
            "{material}: the bar is in two parts: {:?}",
            session.events.described()
        );
        let count = |session: &Session| session.bodies[0].parts().into_iter().max();
        assert_eq!(count(&session), Some(1), "{material}: its surface too");
        let before = sums(&session);
        run(&mut session, 0.25);
        let parts = session.bodies[0].discretization.lattice().expect("a solid").parts();
        assert_eq!(parts.iter().max(), Some(&0), "{material}: the bar is one part again");
        assert_eq!(count(&session), Some(0), "{material}: its surface, which has both faces of the cut, counts as one");
        assert!((sums(&session).0 / before.0 - 1.0).abs() < 1e-12);
        let [a, b] = [&mut whole, &mut session].map(energy);
        assert_eq!(whole.bodies[0].system.nodes.len(), session.bodies[0].system.nodes.len(), "{material}");
        assert!((b / a - 1.0).abs() < 1e-9, "{material}: {b} J, never cut {a} J");
        assert!(session.undo(), "{material}");
        assert_eq!(session.bodies[0].system.nodes.len(), nodes, "{material}: undo opens the cut again");
        assert_eq!(count(&session), Some(1), "{material}: with two parts");
        assert!(session.redo());
        run(&mut session, 0.05);
        assert_eq!(session.events.count(EventKind::Quarantine), 0, "{material}: {:?}", session.events.described());
    }
}

/// Borders 2 mm apart, more than a quarter of an edge, are drawn together by springs until they join.
#[test]
fn borders_that_are_apart_are_drawn_together() {
    let bench = Bench::new();
    let held =
        "[[body.fixed]]\nbox = [[-1, -1, -1], [1, -0.0199, 1]]\n[[body.fixed]]\nbox = [[-1, 0.0219, -1], [1, 1, 1]]";
    let moved = |text: &str| -> String {
        let apart = |(row, line): (usize, &str)| match line.strip_prefix("v ") {
            Some(place) if row >= 65 => {
                let at: Vec<f64> = place.split(' ').map(|c| c.parse().expect("a number")).collect();
                format!("v {} {} {}\n", at[0], at[1] + 0.002, at[2])
            }
            _ => format!("{line}\n"),
        };
        text.lines().enumerate().map(apart).collect()
    };
    let mut session = strip_scene_of(&bench, &moved(&strips(true)), held, "stitch\"\nradius = \"12 mm");
    let seam = |session: &Session| session.bodies[0].discretization.sheet().expect("a sheet").welds().len();
    run(&mut session, 0.005);
    assert_eq!(seam(&session), 0, "too far apart");
    assert_eq!(session.bodies[0].parts().into_iter().max(), Some(1));
    run(&mut session, 0.35);
    // The hand passes over 10 of 13 pairs; those at the free ends may slip away from it.
    assert!(seam(&session) >= 10, "{} pairs are joined: {:?}", seam(&session), session.events.described());
    assert_eq!(session.bodies[0].parts().into_iter().max(), Some(0), "a sewn sheet is one part");
    assert_eq!(session.events.count(EventKind::Quarantine), 0);
}

#[test]
fn a_stitch_of_what_is_whole_is_warned_of() {
    let bench = Bench::new();
    bench.write("scene.toml", pliant_tests::box_scene("", "", "").replace("kind = \"touch\"", "kind = \"stitch\""));
    bench
        .pliant(&["run", "scene.toml", "--out", "out"])
        .expect(0)
        .says(&["changes-nothing", "stitch of tool `finger`"]);
}
