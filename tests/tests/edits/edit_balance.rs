//! Energy and momentum of a body under every kind of edit: what tools and changes of the shape at rest put in is what the body has.
//!
//! Bodies are undamped and moved by the implicit midpoint rule, which takes no energy from a linear body; what is left over goes with the
//! square of the step. The work of a tool is that of its forces on the nodes, which the hand feels with the opposite sign; on sheets tools hold nodes
//! as well, and their work is that of the constraint forces.
//!
//! On sheets, whose vertices are stopped by tips, and where cuts and stitches give other nodes, energy is lost: of impacts, of what a blade parts, of what
//! becomes one. There bodies are moved by backward Euler, which adds to the losses, and whose impulse is that of the forces at the end of the
//! step: what is asserted is that a body has no more than hands and fixings have put in, and that its momentum changes by their impulses alone. How much
//! a cut takes is in `cutting_physics.rs`.

use pliant_engine::edit::KINDS;
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_solver::StepTime;
use pliant_tests::{Bench, open_file};

/// A ball that stands on its base, so that every kind finds something to change.
const BALL: &str = "shape = { kind = \"sphere\", cells = 10, size = [0.1, 0.1, 0.1] }\ngrid = { level = 4, region = \"whole\" }\n\
    material = { plugin = \"neo-hookean\", params = { young = \"20 kPa\", poisson = 0.3, damping-time = 0.0 } }\n\
    [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.035]]";
/// m, a place on it.
const PLACE: [f64; 3] = [0.011, 0.007, 0.048];

/// The path of the hand from a place on the surface: m at s. Kinds that press go in, others out and aside.
fn way(kind: &str) -> [[f64; 4]; 3] {
    match kind {
        "pull" | "grab" => [[0.0, 0.0, 0.0, 0.004], [0.03, 0.004, 0.001, 0.012], [0.06, 0.002, -0.003, 0.008]],
        "inflate" | "deflate" => [[0.0, 0.0, 0.0, 0.0], [0.03, 0.002, 0.0, 0.0], [0.06, 0.0, 0.002, 0.0]],
        _ => [[0.0, 0.0, 0.0, 0.007], [0.03, 0.004, 0.001, 0.002], [0.06, 0.002, -0.003, 0.003]],
    }
}

/// A sheet that is held along two edges.
const SHEET: &str = "shape = { kind = \"sheet\", cells = 16, size = [0.1, 0.1, 0.0] }\nsheet = {}\n\
     material = { plugin = \"cloth\", params = { density = 0.3, damping-time = 0.0 } }\n\
     [[body.fixed]]\nbox = [[-1, -1, -1], [0.001, 1, 1]]\n[[body.fixed]]\nbox = [[0.099, -1, -1], [1, 1, 1]]";
/// A place on it, m.
const PLACE_ON_SHEET: [f64; 3] = [0.051, 0.047, 0.0];

fn opened(kind: &str, dt: f64, integrator: &str, body: &str, place: [f64; 3]) -> Session {
    let row = |[t, x, y, z]: [f64; 4]| format!("[{t}, {}, {}, {}]", place[0] + x, place[1] + y, place[2] + z);
    let path = way(kind).map(row).join(", ");
    let text = format!(
        r#"
        format = 1
        [time]
        duration = "60 ms"
        dt = {dt}
        integrator = "{integrator}"
        [solver]
        tolerance = 1e-12
        newton = 30
        newton-tolerance = 1e-10
        [[body]]
        {body}
        [[device]]
        name = "hand"
        params = {{ interpolation = "smooth", peak-force = "50 N", path = [{path}], rotation = [[0, 0, 0, 0], [0.06, 5, 10, 15]] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "6 mm"
        friction = [0.35, 0.3]
        [[edit]]
        kind = "{kind}"
        tool = "finger"
        "#
    );
    let bench = Bench::new();
    open_file(&bench.write("scene.toml", text), 1, None)
}

/// What a stroke leaves unexplained.
#[derive(Debug, Default)]
struct Balance {
    /// J, work of tools and of changes of the shape at rest, each taken as positive and added up.
    exchanged: f64,
    /// J, energy of the body less all that was put in, at the end.
    energy: f64,
    /// N s, impulses of tools, each taken as positive and added up.
    impulse: f64,
    /// N s, momentum of the body less impulses of tools and supports, largest in a step.
    momentum: f64,
    /// N, largest difference of the force on the hand and the sum of the forces on nodes.
    reaction: f64,
    /// J, the greatest that the shape at rest was given.
    rest_work: f64,
}

/// Elastic energy (J) of the body where its nodes are at `x` (m).
fn elastic(session: &mut Session, x: &[Vec3]) -> f64 {
    let (start, dt) = (session.time(), session.dt());
    let system = &mut session.bodies[0].system;
    let now = std::mem::replace(&mut system.nodes.x, x.to_vec());
    let energy = system.energy(StepTime { start, dt }).expect("finite");
    session.bodies[0].system.nodes.x = now;
    energy
}

fn momentum(session: &Session) -> Vec3 {
    let nodes = &session.bodies[0].system.nodes;
    nodes.mass.iter().zip(&nodes.v).map(|(m, v)| *m * v).sum()
}

/// Steps a session to its end and closes its account in every step.
fn balance(mut session: Session, seconds: f64) -> Balance {
    let mut all = Balance::default();
    let is_euler = session.choices.integrator == "backward-euler";
    session.step();
    for _ in 1..(seconds / session.dt()).round() as usize {
        let nodes = &session.bodies[0].system.nodes;
        let (x, v, kinetic, p) = (nodes.x.clone(), nodes.v.clone(), nodes.kinetic_energy(), momentum(&session));
        let mass = nodes.mass.clone();
        let fixed_by_scene: Vec<bool> = nodes.constraint.iter().map(|c| !c.is_free()).collect();
        let before = elastic(&mut session, &x);
        let was_free: Vec<bool> = session.bodies[0].system.nodes.constraint.iter().map(|c| c.is_free()).collect();
        session.step();
        let with_new_rest = elastic(&mut session, &x);
        let now = session.bodies[0].system.nodes.x.clone();
        let after = elastic(&mut session, &now);
        let nodes = &session.bodies[0].system.nodes;
        let (mut work, mut force, mut end) = (0.0, Vec3::zeros(), Vec3::zeros());
        for slot in &session.tools {
            let springs = slot.tool.springs(0);
            let forces = |x: &[Vec3], v: &[Vec3]| {
                let mut forces = vec![Vec3::zeros(); x.len()];
                springs.add_to(&mut forces, x, Some(v));
                forces
            };
            let (first, last) = (forces(&x, &v), forces(&nodes.x, &nodes.v));
            for (i, (first, last)) in first.iter().zip(&last).enumerate() {
                let mean = if is_euler { *last } else { 0.5 * (first + last) };
                work += mean.dot(&(nodes.x[i] - x[i]));
                force += mean;
                end += last;
            }
        }
        let felt: Vec3 = session.frame().tools.iter().map(|tool| tool.force).sum();
        let mut supports = session.reactions(0).to_vec();
        let is_sheet = session.bodies[0].discretization.sheet().is_some();
        if is_sheet {
            // There they have the forces of tools at the end of the step too.
            let mut springs = vec![Vec3::zeros(); x.len()];
            session.tools.iter().for_each(|slot| slot.tool.springs(0).add_to(&mut springs, &nodes.x, Some(&nodes.v)));
            supports.iter_mut().zip(springs).for_each(|(support, spring)| *support -= spring);
        }
        work += supports.iter().zip(nodes.x.iter().zip(&x)).map(|(f, (to, from))| f.dot(&(to - from))).sum::<f64>();
        // What holds a node of a solid is a fixing or a pin; tools hold nodes of sheets alone.
        let by_tool = |fixed: &bool| is_sheet && !*fixed;
        let held: Vec3 = supports.iter().zip(&fixed_by_scene).filter(|(_, fixed)| by_tool(fixed)).map(|(f, _)| f).sum();
        let supports: Vec3 = supports.iter().sum();
        // A pin stops what it holds.
        let stopped = |i: &usize| was_free[*i] && !nodes.constraint[*i].is_free();
        let taken: f64 = (0..x.len()).filter(stopped).map(|i| 0.5 * nodes.mass[i] * v[i].norm_squared()).sum();
        work -= taken;
        let given_up: Vec3 = (0..x.len()).filter(stopped).map(|i| nodes.mass[i] * v[i]).sum();
        let dt = session.dt();
        all.exchanged += work.abs() + (with_new_rest - before).abs();
        all.rest_work = all.rest_work.max((with_new_rest - before).abs());
        all.energy += nodes.kinetic_energy() + after - kinetic - before - work - (with_new_rest - before);
        all.impulse += dt * (force + held).norm();
        // The mass of a sheet follows its area at rest, at the velocity that it has.
        let gained: Vec3 = nodes.mass.iter().zip(&mass).zip(&v).map(|((now, was), v)| (now - was) * v).sum();
        all.momentum = all.momentum.max((momentum(&session) - p - gained + given_up - dt * (force + supports)).norm());
        all.reaction = all.reaction.max((felt + end + held).norm());
    }
    all
}

#[test]
fn every_edit_puts_in_what_the_body_has() {
    for kind in KINDS.iter().filter(|kind| !kind.cuts()) {
        let [coarse, fine] =
            [1e-3, 0.5e-3].map(|dt| balance(opened(kind.name(), dt, "implicit-midpoint", BALL, PLACE), 0.06));
        println!("{}: {coarse:?} {fine:?}", kind.name());
        let name = kind.name();
        for all in [&coarse, &fine] {
            assert!(all.exchanged > 1e-5 && all.impulse > 1e-3, "{name} does nothing: {all:?}");
            let changes_energy = kind.changes_body() && !matches!(name, "pin" | "unpin" | "stitch");
            assert_eq!(all.rest_work > 1e-8, changes_energy, "{name}: {all:?}");
            // Solves go down to 1e-10 of a step's residual.
            assert!(all.momentum < 1e-9 * all.impulse, "{name}: {all:?}");
            assert!(all.reaction < 1e-12, "{name}: the hand feels another force than it gives: {all:?}");
        }
        assert!(coarse.energy.abs() < 1e-4 * coarse.exchanged, "{name}: {coarse:?}");
        // Second order: a quarter at half the step, with room for what meets surface points in other places.
        assert!(fine.energy.abs() < 0.5 * coarse.energy.abs(), "{name}: {coarse:?} {fine:?}");
    }
}

#[test]
fn every_edit_of_a_sheet_gives_it_no_more_than_the_work_of_the_hand() {
    for kind in KINDS.iter().filter(|kind| !kind.cuts()) {
        let all = balance(opened(kind.name(), 1e-3, "backward-euler", SHEET, PLACE_ON_SHEET), 0.06);
        let name = kind.name();
        assert!(all.impulse > 1e-4, "{name} does nothing: {all:?}");
        assert!(all.energy <= 1e-9 * all.exchanged, "{name}: {all:?}");
        assert!(all.momentum < 1e-9 * all.impulse, "{name}: {all:?}");
        assert!(all.reaction < 1e-12, "{name}: the hand feels another force than it gives: {all:?}");
    }
}

/// Elastic and kinetic energy (J) and momentum (N s).
fn totals(session: &mut Session) -> (f64, Vec3) {
    let x = session.bodies[0].system.nodes.x.clone();
    let elastic = elastic(session, &x);
    (session.bodies[0].system.nodes.kinetic_energy() + elastic, momentum(session))
}

/// What a stroke that changes nodes leaves unexplained.
#[derive(Debug, Default)]
struct Bound {
    /// J, work of hands and fixings, each step taken as positive and added up.
    exchanged: f64,
    /// J, energy of the body less the work of hands and fixings, its greatest value.
    gained: f64,
    /// J, the same at the end.
    left: f64,
    /// N s, impulses taken as positive and added up.
    impulse: f64,
    /// N s, largest change of the momentum in a step that is no impulse.
    momentum: f64,
    /// Steps in which nodes were made or became one.
    changes: usize,
}

/// Steps a session whose nodes change by backward Euler, and sums what its hands and fixings do.
fn bound(mut session: Session, seconds: f64) -> Bound {
    let mut all = Bound::default();
    session.step();
    let (start, mut p) = totals(&mut session);
    let (mut work, mut count) = (0.0, session.bodies[0].system.nodes.len());
    for _ in 1..(seconds / session.dt()).round() as usize {
        session.step();
        let (nodes, dt) = (&session.bodies[0].system.nodes, session.dt());
        all.changes += usize::from(nodes.len() != count);
        count = nodes.len();
        let mut forces = vec![Vec3::zeros(); count];
        // On sheets the constraint forces have those of tools among them.
        if session.bodies[0].discretization.sheet().is_none() {
            session.tools.iter().for_each(|slot| slot.tool.springs(0).add_to(&mut forces, &nodes.x, Some(&nodes.v)));
        }
        let (mut step_work, mut force) = (0.0, Vec3::zeros());
        for (i, of_tools) in forces.iter().enumerate() {
            let all = of_tools + session.reactions(0)[i];
            // The step has moved the node by its velocity at the end.
            step_work += dt * all.dot(&nodes.v[i]);
            force += all;
        }
        work += step_work;
        all.exchanged += step_work.abs();
        all.impulse += dt * force.norm();
        let (energy, now) = totals(&mut session);
        all.left = energy - start - work;
        all.gained = all.gained.max(all.left);
        all.momentum = all.momentum.max((now - p - dt * force).norm());
        p = now;
    }
    all
}

/// A scene whose hand goes along a path with a knife and then with a needle.
fn seam(body: &str, path: &str, rest: &str) -> Session {
    let text = format!(
        "format = 1\n[time]\nduration = 1\nintegrator = \"backward-euler\"\n[solver]\ntolerance = 1e-12\nnewton = 30\n\
         newton-tolerance = 1e-10\n[[body]]\n{body}\n[[device]]\nname = \"hand\"\nparams = {{ peak-force = \"50 N\", path = [{path}] }}\n\
         [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"6 mm\"\nstiffness = \"500 N/m\"\n\
         blade = {{ length = \"120 mm\", direction = [0, 0, 1] }}\n{rest}"
    );
    let bench = Bench::new();
    open_file(&bench.write("scene.toml", text), 1, None)
}

#[test]
fn cuts_and_stitches_give_a_body_no_more_than_the_work_of_the_hand() {
    let block = "shape = { kind = \"box\", cells = 10, size = [0.06, 0.06, 0.03] }\ngrid = { level = 4, region = \"whole\" }\n\
        material = { plugin = \"neo-hookean\", params = { young = \"20 kPa\", poisson = 0.3, damping-time = 0.0 } }\n\
        [[body.fixed]]\nbox = [[-1, -1, -1], [-0.029, 1, 1]]\n[[body.fixed]]\nbox = [[0.029, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [0.05, 0.002, 0, 0]]";
    let sheet = "shape = { kind = \"sheet\", cells = 10, size = [0.06, 0.06, 0.0] }\nposition = [-0.03, -0.03, 0]\nsheet = {}\n\
        material = { plugin = \"cloth\", params = { density = 0.3, damping-time = 0.0 } }\n\
        [[body.fixed]]\nbox = [[-1, -1, -1], [-0.029, 1, 1]]\n[[body.fixed]]\nbox = [[0.029, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [0.05, 0.001, 0, 0]]";
    for (name, body) in [("block", block), ("sheet", sheet)] {
        let cut = "[[edit]]\nkind = \"cut\"\ntool = \"finger\"\nstart = 0.05\nend = 0.2\n";
        let top = if name == "block" { 0.02 } else { 0.005 };
        let path = format!(
            "[0, 0.002, -0.05, -0.06], [0.05, 0.002, -0.05, -0.06], [0.2, 0.002, 0.02, -0.06], [0.21, 0.002, 0.02, -0.06], \
             [0.22, 0.002, -0.02, {top}], [0.3, 0.002, 0.02, {top}]"
        );
        let stitch = "[[edit]]\nkind = \"stitch\"\ntool = \"finger\"\nradius = \"15 mm\"\nstart = 0.225\nend = 0.3\n";
        for (what, edits, seconds) in [("cut", cut.to_owned(), 0.2), ("cut and stitch", format!("{cut}{stitch}"), 0.3)]
        {
            let all = bound(seam(body, &path, &edits), seconds);
            let what = format!("{name}, {what}: {all:?}");
            assert!(all.changes > 4 && all.exchanged > 1e-4 && all.impulse > 1e-4, "{what}");
            assert!(all.gained <= 1e-9 * all.exchanged && all.left < 0.0, "{what}");
            assert!(all.momentum < 1e-9 * all.impulse, "{what}");
        }
    }
}

/// Voxels of a slanted cut are joined in another order from cell to cell, and some copies of nodes belong to small fragments only.
#[test]
fn stitches_of_slanted_cuts_keep_momentum() {
    let random = &mut Random(11);
    let block = "shape = { kind = \"box\", cells = 10, size = [0.06, 0.06, 0.03] }\ngrid = { level = 4, region = \"whole\" }\n\
        material = { plugin = \"corotational\", params = { young = \"20 kPa\", poisson = 0.3, damping-time = 0.0 } }\n\
        [[body.fixed]]\nbox = [[-1, -1, -1], [-0.029, 1, 1]]\n[[body.fixed]]\nbox = [[0.029, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [0.05, 0.002, 0, 0]]";
    for case in 0..3 {
        let [from, to] = [0.0; 2].map(|_: f64| 0.024 * random.unit() - 0.012);
        let path = format!(
            "[0, {from}, -0.05, -0.06], [0.05, {from}, -0.05, -0.06], [0.2, {to}, 0.02, -0.06], [0.21, {to}, 0.02, -0.06], \
             [0.22, {from}, -0.02, 0.02], [0.3, {to}, 0.02, 0.02]"
        );
        let cut = "[[edit]]\nkind = \"cut\"\ntool = \"finger\"\nstart = 0.05\nend = 0.2\n";
        let stitch = "[[edit]]\nkind = \"stitch\"\ntool = \"finger\"\nradius = \"15 mm\"\nstart = 0.225\nend = 0.3\n";
        let mut session = seam(block, &path, &format!("{cut}{stitch}"));
        // The cut is made. Slivers that a cut leaves go to other nodes with their mass alone, which is not what is looked at here.
        (0..215).for_each(|_| session.step());
        let all = bound(session, 0.085);
        assert!(all.changes > 0 && all.impulse > 1e-4, "{case}: {all:?}");
        assert!(all.momentum < 1e-9 * all.impulse, "{case}, from {from} to {to}: {all:?}");
    }
}
