//! Explicit steps of bodies that are deformed far beyond the frequencies their substeps were chosen by: they stay finite and gain no energy.

use pliant_engine::session::EventKind;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_solver::StepTime;
use pliant_tests::{asked_cases, open};

/// Energy that steps may gain, relative to that of the start: symplectic Euler swings about the true energy by terms of first order in the step, and
/// substeps are nine tenths of its limit.
const ALLOWANCE: f64 = 0.1;

/// A block of 60 mm whose nodes fly apart, together or askew at up to three times the speed of sound in it. Returns how often a step was taken again.
///
/// # Errors
/// What went wrong.
fn fling(number: u64) -> Result<u64, String> {
    let random = &mut Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let solid = random.pick(&["mass-spring", "neo-hookean", "corotational"]);
    let damping = random.pick(&["0 s", "0.5 ms", "2 ms"]);
    let speed = 15.0 * random.unit();
    // A body on which nothing acts is not simulated, hence the gravity.
    let scene = format!(
        r#"
        format = 1
        gravity = [0, 0, -1e-12]
        [time]
        dt = 0.001
        integrator = "symplectic-euler"
        most-substeps = 64
        [[body]]
        shape = {{ kind = "box", cells = 6, size = [0.06, 0.06, 0.06] }}
        material = {{ plugin = "{solid}", params = {{ young = 2e4, density = 1000, damping-time = "{damping}" }} }}
        grid = {{ level = 4, region = "whole" }}
        "#
    );
    let what = format!("{number}: {solid}, damping time {damping}, {speed:.1} m/s");
    let mut session = open(&scene, 1);
    let rows: [Vec3; 3] = std::array::from_fn(|_| random.direction() / 0.03);
    let nodes = &mut session.bodies[0].system.nodes;
    let centre = nodes.x.iter().sum::<Vec3>() / nodes.len() as f64;
    for (v, x) in nodes.v.iter_mut().zip(&nodes.x) {
        *v = speed * Vec3::new(rows[0].dot(&(x - centre)), rows[1].dot(&(x - centre)), rows[2].dot(&(x - centre)));
    }
    let start = nodes.kinetic_energy();
    let momentum: Vec3 = nodes.v.iter().zip(&nodes.mass).map(|(v, m)| *m * *v).sum();
    for _ in 0..60 {
        session.step();
        if let Some(why) = &session.bodies[0].frozen {
            return Err(format!("{what}: {why}"));
        }
        let now = StepTime { start: session.time(), dt: session.dt() };
        let system = &mut session.bodies[0].system;
        let energy = system.nodes.kinetic_energy() + system.energy(now).expect("an energy");
        if energy > (1.0 + ALLOWANCE) * start {
            return Err(format!("{what}: {start} J grew to {energy} J"));
        }
    }
    let nodes = &session.bodies[0].system.nodes;
    let after: Vec3 = nodes.v.iter().zip(&nodes.mass).map(|(v, m)| *m * *v).sum();
    let scale: f64 = nodes.v.iter().zip(&nodes.mass).map(|(v, m)| m * v.norm()).sum();
    if (after - momentum).norm() > 1e-9 * scale {
        return Err(format!("{what}: momentum {momentum:?} became {after:?}"));
    }
    Ok(session.events.count(EventKind::RepeatedStep))
}

/// 40 blocks; those of `FLINGS`, as `0..1000`, if it is set.
#[test]
fn explicit_steps_of_bodies_that_fly_apart_gain_no_energy() {
    let flings: Vec<Result<u64, String>> = asked_cases("FLINGS").unwrap_or(0..40).map(fling).collect();
    let failed: Vec<&String> = flings.iter().filter_map(|fling| fling.as_ref().err()).collect();
    assert!(failed.is_empty(), "{} of {}: {failed:#?}", failed.len(), flings.len());
    assert!(flings.iter().flatten().sum::<u64>() > 0, "no step had to be taken again");
}
