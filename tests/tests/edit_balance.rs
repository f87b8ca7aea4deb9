//! Energy and momentum of a body under every kind of edit: what tools and changes of the shape at rest put in is what the body has.
//!
//! Bodies are undamped and moved by the implicit midpoint rule, which takes no energy from a linear body; what is left over goes with the
//! square of the step. The work of a tool is that of its forces on the nodes, which the hand feels with the opposite sign. Cuts, whose work is
//! partly that of new surface, have their account in `cutting_physics.rs`.

use pliant_engine::edit::KINDS;
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
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

fn opened(kind: &str, dt: f64) -> Session {
    let row = |[t, x, y, z]: [f64; 4]| format!("[{t}, {}, {}, {}]", PLACE[0] + x, PLACE[1] + y, PLACE[2] + z);
    let path = way(kind).map(row).join(", ");
    let text = format!(
        r#"
        format = 1
        [time]
        duration = "60 ms"
        dt = {dt}
        integrator = "implicit-midpoint"
        [solver]
        tolerance = 1e-12
        newton = 30
        newton-tolerance = 1e-10
        [[body]]
        {BALL}
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
    session.step();
    for _ in 1..(seconds / session.dt()).round() as usize {
        let nodes = &session.bodies[0].system.nodes;
        let (x, v, kinetic, p) = (nodes.x.clone(), nodes.v.clone(), nodes.kinetic_energy(), momentum(&session));
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
                let mean = 0.5 * (first + last);
                work += mean.dot(&(nodes.x[i] - x[i]));
                force += mean;
                end += last;
            }
        }
        let felt: Vec3 = session.frame().tools.iter().map(|tool| tool.force).sum();
        let supports: Vec3 = session.reactions(0).iter().sum();
        work += session
            .reactions(0)
            .iter()
            .zip(nodes.x.iter().zip(&x))
            .map(|(f, (to, from))| f.dot(&(to - from)))
            .sum::<f64>();
        // A pin stops what it holds.
        let stopped = |i: &usize| was_free[*i] && !nodes.constraint[*i].is_free();
        let taken: f64 = (0..x.len()).filter(stopped).map(|i| 0.5 * nodes.mass[i] * v[i].norm_squared()).sum();
        work -= taken;
        let given_up: Vec3 = (0..x.len()).filter(stopped).map(|i| nodes.mass[i] * v[i]).sum();
        let dt = session.dt();
        all.exchanged += work.abs() + (with_new_rest - before).abs();
        all.rest_work = all.rest_work.max((with_new_rest - before).abs());
        all.energy += nodes.kinetic_energy() + after - kinetic - before - work - (with_new_rest - before);
        all.impulse += dt * force.norm();
        all.momentum = all.momentum.max((momentum(&session) - p + given_up - dt * (force + supports)).norm());
        all.reaction = all.reaction.max((felt + end).norm());
    }
    all
}

#[test]
fn every_edit_puts_in_what_the_body_has() {
    for kind in KINDS.iter().filter(|kind| !kind.cuts()) {
        let [coarse, fine] = [1e-3, 0.5e-3].map(|dt| balance(opened(kind.name(), dt), 0.06));
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
