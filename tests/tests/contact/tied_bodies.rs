//! Two bodies that are stitched together: their points stay together, momentum stays, energy does not grow, and they carry as one body does.

use pliant_engine::session::{EventKind, HistoryCounts, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, open, open_file};

/// Below any motion that is looked at, and enough to have bodies move.
const TINY: [f64; 3] = [0.0, 0.0, -1e-30];
const SCHEMES: [&str; 3] = ["backward-euler", "bdf2", "implicit-midpoint"];

fn run(session: &mut Session, seconds: f64) {
    while session.time() < seconds - 1e-9 {
        session.step();
    }
}

fn solid(name: &str, shape: &str, at: [f64; 3], level: u32, young: f64, more: &str) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\nshape = {shape}\nposition = {at:?}\n\
         material = {{ plugin = \"corotational\", params = {{ young = {young:?}, poisson = 0.3, density = 1000, damping-time = 0.002 }} }}\n\
         grid = {{ level = {level}, region = \"whole\" }}\n{more}\n"
    )
}

fn sheet(name: &str, cells: u32, size: f64, at: [f64; 3], more: &str) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\nshape = {{ kind = \"sheet\", cells = {cells}, size = [{size:?}, {size:?}, 0] }}\nposition = {at:?}\nsheet = {{}}\n\
         material = {{ plugin = \"cloth\", params = {{ fabric = \"interlock\", damping-time = 0.02 }} }}\n{more}\n"
    )
}

fn scene(gravity: [f64; 3], time: &str, rest: &str) -> String {
    format!("format = 1\ngravity = {gravity:?}\n[time]\n{time}\n[solver]\ntolerance = 1e-10\n{rest}")
}

/// Mass (kg), momentum (N s) and angular momentum (N m s) of all bodies.
fn momenta(session: &Session) -> (f64, Vec3, Vec3) {
    let start = (0.0, Vec3::zeros(), Vec3::zeros());
    session.bodies.iter().fold(start, |sum, body| {
        let nodes = &body.system.nodes;
        (0..nodes.len()).fold(sum, |(mass, linear, angular), i| {
            let p = nodes.mass[i] * nodes.v[i];
            (mass + nodes.mass[i], linear + p, angular + nodes.x[i].cross(&p))
        })
    })
}

/// Kinetic and elastic energy of all bodies, J.
fn energy(session: &mut Session) -> f64 {
    let now = pliant_solver::StepTime { start: session.time(), dt: session.dt() };
    session
        .bodies
        .iter_mut()
        .map(|body| body.system.nodes.kinetic_energy() + body.system.energy(now).expect("finite"))
        .sum()
}

/// Largest distance of tied points, in edges of the finer body.
fn widest_gap(session: &mut Session) -> f64 {
    let edge = session.bodies.iter().map(|body| body.discretization.edge()).fold(f64::INFINITY, f64::min);
    session.tie_gaps().into_iter().fold(0.0, f64::max) / edge
}

/// Gives every node of a body a velocity and a spin about its middle.
fn throw(session: &mut Session, body: usize, v: Vec3, spin: Vec3) {
    let nodes = &mut session.bodies[body].system.nodes;
    let centre = nodes.x.iter().sum::<Vec3>() / nodes.len() as f64;
    nodes.v = nodes.x.iter().map(|x| v + spin.cross(&(x - centre))).collect();
}

/// Two bodies of random kinds side by side, with the plane z = 0.02 m between them.
fn random_pair(random: &mut Random) -> String {
    let kind = random.below(3);
    let young = 1e4 * 100f64.powf(random.unit());
    let cells = 4 + random.below(4);
    let block = format!("{{ kind = \"box\", cells = {cells}, size = [0.04, 0.04, 0.02] }}");
    let level = 2 + random.below(3) as u32;
    let other = 2 + random.below(3) as u32;
    let below = match kind {
        2 => sheet("a", cells as u32, 0.04, [-0.02, -0.02, 0.02], ""),
        _ => solid("a", &block, [0.0, 0.0, 0.01], level, young, ""),
    };
    let above = match kind {
        0 => solid("b", &block, [0.003, 0.002, 0.03], other, 3e4, ""),
        _ => sheet("b", 5, 0.03, [-0.015, -0.015, 0.02], ""),
    };
    below + &above
}

#[test]
fn tied_points_stay_together_with_the_momentum_they_have_and_no_more_energy() {
    let (mut widest, mut drift, mut turn, mut gain) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for case in 0..12 {
        let mut random = Random(40 + case);
        let bodies = random_pair(&mut random);
        let scheme = SCHEMES[case as usize % 3];
        let dt = 0.0005 * 8f64.powf(random.unit());
        let stitch = "[[stitch]]\nbodies = [\"a\", \"b\"]\ndistance = \"0.1 mm\"";
        let mut session = open(&scene(TINY, &format!("dt = {dt}\nintegrator = \"{scheme}\""), &(bodies + stitch)), 1);
        let ties = session.tie_count();
        assert!(ties >= 4, "case {case}: {ties} ties");
        for body in 0..2 {
            throw(&mut session, body, 0.3 * random.vector(), 5.0 * random.vector());
        }
        let (mass, before, angular) = momenta(&session);
        let first = energy(&mut session);
        let (mut least, mut most, mut iterations) = (first, 0.0_f64, 0);
        for _ in 0..80 {
            session.step();
            let report = session.collision_report();
            assert!(report.has_converged, "case {case}: {report:?}");
            iterations += report.iterations;
            widest = widest.max(widest_gap(&mut session));
            let now = energy(&mut session);
            most = most.max((now - least) / first);
            least = least.min(now);
        }
        let (_, after, turned) = momenta(&session);
        let scale = (mass * first).sqrt();
        println!(
            "case {case}: {scheme} dt {dt:.5}, {ties} ties, {:.1} iterations, gap {widest:.1e} edges, gain {most:.1e}, momentum {:.1e}, angular {:.1e}",
            f64::from(iterations as u32) / 80.0,
            (after - before).norm() / scale,
            (turned - angular).norm() / scale / 0.02
        );
        drift = drift.max((after - before).norm() / scale);
        turn = turn.max((turned - angular).norm() / scale / 0.02);
        gain = gain.max(most);
    }
    println!("gap {widest:.2e} edges, momentum {drift:.2e}, angular {turn:.2e}, energy {gain:.2e}");
    assert!(widest < 1e-3, "{widest} edges");
    assert!(drift < 1e-9, "{drift}");
    assert!(gain < 1e-3, "{gain}");
}

/// A bar of 0.2 x 0.02 x 0.02 m that is held at one end and bends under its weight: whole, or in two halves that are stitched together.
fn bar(is_whole: bool, level: u32, scheme: &str, threads: usize) -> Session {
    let fixed = "[[body.fixed]]\nbox = [[-1, -1, -1], [-0.0999, 1, 1]]";
    let part = |name: &str, length: f64, at: f64, level: u32, more: &str| {
        let shape = format!("{{ kind = \"box\", cells = 20, size = [{length}, 0.02, 0.02] }}");
        solid(name, &shape, [at, 0.0, 0.0], level, 2e6, more)
    };
    let rest = if is_whole {
        part("bar", 0.2, 0.0, level, fixed)
    } else {
        // A half has cells of the same size one level below.
        part("near", 0.1, -0.05, level - 1, fixed)
            + &part("far", 0.1, 0.05, level - 1, "")
            + "[[stitch]]\nbodies = [\"near\", \"far\"]\ndistance = \"0.1 mm\""
    };
    open(&scene([0.0, 0.0, -9.81], &format!("dt = 0.004\nintegrator = \"{scheme}\""), &rest), threads)
}

/// Mean height of the nodes at the free end of a bar, m.
fn tip(session: &Session) -> f64 {
    let nodes = &session.bodies[session.bodies.len() - 1].system.nodes;
    let end: Vec<usize> = (0..nodes.len()).filter(|i| nodes.rest[*i].x > 0.0999).collect();
    end.iter().map(|i| nodes.x[*i].z - nodes.rest[*i].z).sum::<f64>() / end.len() as f64
}

#[test]
fn two_halves_of_a_bar_bend_as_one_bar() {
    let mut whole = Vec::new();
    for level in [5, 6] {
        let [one, two] = [true, false].map(|is_whole| {
            let mut session = bar(is_whole, level, "backward-euler", 1);
            run(&mut session, 1.6);
            session
        });
        let (one, two) = (tip(&one), tip(&two));
        println!("level {level}: tip {:.4} mm, of two halves {:.4} mm, {:.2e}", 1e3 * one, 1e3 * two, two / one - 1.0);
        whole.push((one, two));
    }
    let between = (whole[0].0 / whole[1].0 - 1.0).abs();
    for (one, two) in whole {
        assert!(
            one < -1e-4 && (two / one - 1.0).abs() < between,
            "{two} m, of one bar {one} m; between levels {between}"
        );
    }
}

#[test]
fn the_force_of_a_seam_is_that_of_what_hangs_on_it() {
    let mut session = bar(false, 5, "bdf2", 1);
    run(&mut session, 1.6);
    let weight = 9.81 * session.bodies[1].system.nodes.mass.iter().sum::<f64>();
    let force = session.contact_force(1);
    assert!((force - Vec3::new(0.0, 0.0, weight)).norm() < 1e-2 * weight, "{force:?} N, weight {weight} N");
    assert!((session.contact_force(0) + force).norm() < 1e-9 * weight, "the other half has the opposite");
}

#[test]
fn ties_give_the_same_bytes_with_any_number_of_threads_and_after_a_snapshot() {
    let x = |session: &Session| -> Vec<Vec3> {
        session.bodies.iter().flat_map(|body| body.system.nodes.x.clone()).collect()
    };
    let ends: Vec<Vec<Vec3>> = [1, 2, 4]
        .map(|threads| {
            let mut session = bar(false, 5, "backward-euler", threads);
            run(&mut session, 0.1);
            x(&session)
        })
        .into();
    assert!(ends.iter().all(|end| *end == ends[0]), "with 1, 2 and 4 threads");
    let mut session = bar(false, 5, "bdf2", 1);
    run(&mut session, 0.02);
    let snapshot = session.snapshot();
    let mut again = || {
        session.restore(&snapshot).expect("its own snapshot");
        run(&mut session, 0.1);
        x(&session)
    };
    assert_eq!(again(), again());
}

#[test]
fn bodies_that_are_stitched_are_not_warned_of() {
    let shape = "{ kind = \"box\", cells = 4, size = [0.04, 0.04, 0.02] }";
    let bodies = solid("a", shape, [0.0; 3], 3, 5e4, "") + &solid("b", shape, [0.0, 0.0, 0.02], 3, 5e4, "");
    let run = |stitch: &str, gravity: [f64; 3]| {
        let time = "duration = 0.2\ndt = 2e-3\nintegrator = \"backward-euler\"";
        let held = bodies.replacen(
            "region = \"whole\" }\n",
            "region = \"whole\" }\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.009]]\n",
            1,
        );
        let mut session = open(&scene(gravity, time, &(held + stitch)), 1);
        run(&mut session, 0.2);
        let codes = session.warnings().iter().map(|warning| warning.code.name()).collect::<Vec<_>>();
        (session.tie_count(), codes)
    };
    // The weight presses the boxes into each other.
    let (ties, codes) = run("[[stitch]]\nbodies = [\"a\", \"b\"]\ndistance = \"1 mm\"\n", [0.0, 0.0, -9.81]);
    assert!(ties > 4 && codes.is_empty(), "{ties} ties: {codes:?}");
    assert_eq!(run("", [0.0, 0.0, -9.81]), (0, vec!["bodies-meet"]));
}

/// Two blocks with a gap of this height (m) between them, the lower one held below, and a needle that presses the upper one from above.
fn blocks(gap: f64, time: &str, keys: &str, duration: f64) -> String {
    let shape = "{ kind = \"box\", cells = 8, size = [0.04, 0.04, 0.02] }";
    let held = "[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1e-4]]";
    let bodies = solid("below", shape, [0.0, 0.0, 0.01], 4, 5e4, held)
        + &solid("above", shape, [0.0, 0.0, 0.03 + gap], 4, 5e4, "");
    let top = 0.04 + gap;
    format!(
        "format = 1\n[time]\nduration = {duration}\n{time}\n{bodies}[[device]]\nname = \"hand\"\n\
         params = {{ path = [[0, 0, 0, {}], [0.05, 0, 0, {}], [0.3, 0, 0, {}], [0.35, 0, 0, {}]] }}\n\
         [[tool]]\nname = \"needle\"\ndevice = \"hand\"\nradius = \"4 mm\"\nstiffness = \"500 N/m\"\n\
         [[edit]]\nkind = \"stitch\"\ntool = \"needle\"\nradius = \"25 mm\"\nend = 0.4\n{keys}",
        top + 0.01,
        top + 0.0035,
        top + 0.0035,
        top + 0.02
    )
}

#[test]
fn a_needle_ties_two_bodies_for_good_and_an_undo_frees_them() {
    for gap in [0.0, 0.003] {
        let mut session = open(&blocks(gap, "integrator = \"backward-euler\"", "", 2.0), 1);
        session.keep_history();
        let mut widest = 0.0_f64;
        run(&mut session, 0.3);
        let ties = session.tie_count();
        assert!(ties >= 9, "gap {gap}: {ties} ties, {:?}", session.events.described());
        run(&mut session, 1.0);
        assert!(session.tie_count() >= 9, "gap {gap}: {} of {ties} ties are left", session.tie_count());
        for _ in 0..100 {
            session.step();
            widest = widest.max(widest_gap(&mut session));
        }
        println!("gap {gap}: {ties} ties, {widest:.1e} edges apart, history {:?}", session.history());
        assert!(widest < 1e-3, "gap {gap}: {widest} edges");
        assert_eq!(session.history(), HistoryCounts { done: 1, undone: 0 });
        // Lifted, the one takes the other along.
        let kept = session.tie_count();
        assert!(session.undo());
        assert_eq!(session.tie_count(), 0);
        assert!(session.redo());
        assert_eq!(session.tie_count(), kept);
    }
}

#[test]
fn points_that_a_stroke_has_not_brought_together_are_let_go() {
    // A gap that the force of the needle does not close: both blocks are held.
    let text = blocks(0.006, "integrator = \"backward-euler\"", "", 1.0)
        .replacen("name = \"above\"", "fixed = [{ box = [[-1, -1, 0.045], [1, 1, 1]] }]\nname = \"above\"", 1)
        .replace("stiffness = \"500 N/m\"", "stiffness = \"500 N/m\"\n");
    let mut session = open(&text, 1);
    session.keep_history();
    run(&mut session, 0.2);
    let drawn = session.tie_count();
    assert!(drawn > 0, "{:?}", session.events.described());
    run(&mut session, 0.6);
    println!("{drawn} drawn, {} left", session.tie_count());
    assert_eq!(session.tie_count(), 0, "of {drawn}");
    assert_eq!(session.history(), HistoryCounts { done: 0, undone: 0 }, "nothing was tied");
}

#[test]
fn a_stitch_of_two_bodies_is_replayed_to_the_bit() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        blocks(0.002, "integrator = \"backward-euler\"", "[[edit]]\nkind = \"undo\"\nstart = 0.5\n", 0.6),
    );
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "a.rec"]).expect(0);
    bench.pliant(&["replay", "a.rec", "--verify", "-q"]).expect(0);
}

#[test]
fn an_explicit_integrator_and_a_local_region_tie_nothing_and_say_so() {
    for (time, from, to, says) in [
        ("integrator = \"symplectic-euler\"\ndt = 0.0002\nmost-substeps = 500", "", "", "`symplectic-euler`"),
        ("integrator = \"backward-euler\"", "region = \"whole\"", "region = \"local\"", "region = \"whole\""),
    ] {
        let text = blocks(0.0, time, "", 0.2);
        let text = if from.is_empty() { text } else { text.replace(from, to) };
        let mut session = open(&text, 1);
        run(&mut session, 0.15);
        assert_eq!(session.tie_count(), 0);
        assert_eq!(session.events.count(EventKind::StitchRefused), 1, "{:?}", session.events.described());
        let told = session.events.described().iter().find(|(kind, _)| *kind == EventKind::StitchRefused);
        assert!(told.is_some_and(|(_, event)| event.text.contains(says)), "{told:?}");
    }
}

#[test]
fn a_scene_that_cannot_be_stitched_is_refused_with_the_place() {
    let bench = Bench::new();
    let shape = "{ kind = \"box\", cells = 4, size = [0.04, 0.04, 0.02] }";
    let bodies = solid("a", shape, [0.0; 3], 3, 5e4, "") + &solid("b", shape, [0.0, 0.0, 0.025], 3, 5e4, "");
    let local = bodies.replace("region = \"whole\"", "region = \"local\"");
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nposition = [0, 0, -0.1]\n";
    let implicit = "integrator = \"backward-euler\"";
    for (bodies, time, stitch, parts) in [
        (
            &bodies,
            implicit,
            "bodies = [\"a\", \"c\"]\ndistance = \"1 mm\"",
            vec!["no body `c`", "`a`, `b`", "scene.toml:"],
        ),
        (
            &bodies,
            implicit,
            "bodies = [\"floor\", \"a\"]\ndistance = \"1 mm\"",
            vec!["`floor` is an obstacle", "body.fixed"],
        ),
        (&bodies, implicit, "bodies = [\"a\", \"a\"]\ndistance = \"1 mm\"", vec!["with itself", "two bodies"]),
        (
            &bodies,
            implicit,
            "bodies = [\"a\", \"b\"]\ndistance = \"1 mm\"",
            vec!["ties nothing", "at least 0.0050 m apart"],
        ),
        (
            &bodies,
            implicit,
            "bodies = [\"a\", \"b\"]\ndistance = \"6 mm\"",
            vec!["0.0050 m apart", "a quarter of an edge", "`time`"],
        ),
        (
            &bodies,
            implicit,
            "bodies = [\"a\", \"b\"]\npairs = [[0, 9999]]",
            vec!["vertex 9999 of body `b`", "from 0 to"],
        ),
        (&bodies, implicit, "bodies = [\"a\", \"b\"]\npairs = []", vec!["`pairs` is empty"]),
        (&bodies, implicit, "bodies = [\"a\", \"b\"]", vec!["one of `pairs` and `distance`"]),
        (&bodies, implicit, "bodies = [\"a\", \"b\"]\ndistance = -1", vec!["distance of a stitch is -1 m", "above 0"]),
        (&bodies, implicit, "bodies = [\"a\", \"b\"]\ndistance = 0.006\ntime = -1", vec!["time of a stitch is -1 s"]),
        (&local, implicit, "bodies = [\"a\", \"b\"]\ndistance = 0.006", vec!["only cells around tools move", "whole"]),
        (
            &bodies,
            "integrator = \"symplectic-euler\"",
            "bodies = [\"a\", \"b\"]\ndistance = 0.006",
            vec!["`symplectic-euler`", "implicit"],
        ),
        (
            &bodies,
            "integrator = \"quasi-static\"",
            "bodies = [\"a\", \"b\"]\ndistance = 0.006",
            vec!["`quasi-static`", "inertia"],
        ),
    ] {
        let text = format!("format = 1\n[time]\nduration = 0.01\n{time}\n{bodies}{floor}[[stitch]]\n{stitch}\n");
        bench.write("scene.toml", text);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2).says(&parts);
    }
    // Drawn together in time, the same bodies meet.
    let text = format!(
        "format = 1\n[time]\nduration = 1\n{implicit}\n{bodies}[[stitch]]\nbodies = [\"a\", \"b\"]\ndistance = \"6 mm\"\ntime = \"0.3 s\"\n"
    );
    let mut session = open_file(&bench.write("drawn.toml", text), 1, None);
    run(&mut session, 0.4);
    assert!(session.tie_count() >= 4 && widest_gap(&mut session) < 1e-3, "{}", widest_gap(&mut session));
}
