//! A step that fails leaves the body where it was before, and contacts hold none of its nodes.

use pliant_engine::session::EventKind;
use pliant_solver::{
    Constraint, ContactConstraints, Integrator, Loads, Pool, Scheme, StepError, StepTime, System, TrialStep, Vec3,
};
use pliant_tests::open;

/// A sheet that is held at two sides, with a finger that presses it from the third step on.
fn scene(time: &str, yields: &str) -> String {
    format!(
        r#"
        format = 1
        [time]
        {time}
        [[body]]
        shape = {{ kind = "sheet", cells = 12, size = [0.1, 0.1, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        fixed = [{{ box = [[-1, -1, -1], [0.0001, 1, 1]] }}, {{ box = [[0.0999, -1, -1], [1, 1, 1]] }}]
        [body.material]
        plugin = "cloth"
        params = {{ young-warp = 500 }}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0.05, 0.05, 0.011], [0.004, 0.05, 0.05, 0.009], [1, 0.05, 0.05, 0.009]] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "10 mm"
        {yields}
        [[edit]]
        kind = "touch"
        tool = "finger"
        "#
    )
}

/// Contacts that hold one node and push another with a force that is not finite, from one substep on.
struct Poisoning {
    held: usize,
    poisoned: usize,
    /// Number of substeps before the force that is not finite.
    sound: usize,
}

impl ContactConstraints for Poisoning {
    fn begin(&mut self, system: &mut System, _: f64) {
        system.nodes.constraint[self.held] = Constraint::Fixed;
    }

    fn add_forces(&self, force: &mut [Vec3]) {
        if self.sound == 0 {
            force[self.poisoned].x = f64::NAN;
        }
    }

    fn update_active_set(&mut self, _: &mut System, _: &TrialStep<'_>) -> bool {
        false
    }

    fn has_candidates(&self) -> bool {
        true
    }

    fn is_active(&self) -> bool {
        true
    }

    fn keep_start(&mut self) {}

    fn take_back(&mut self, system: &mut System) {
        system.nodes.release(self.held as u32);
    }

    fn end(&mut self, system: &mut System, _: &mut [Vec3]) {
        self.sound -= 1;
        system.nodes.release(self.held as u32);
    }
}

#[test]
fn a_step_that_diverges_is_taken_back_by_every_scheme_with_inertia() {
    let explicit = [Scheme::ExplicitEuler, Scheme::SymplecticEuler];
    let implicit = [Scheme::BackwardEuler, Scheme::Bdf2, Scheme::ImplicitMidpoint, Scheme::DampedMidpoint];
    let schemes = explicit.into_iter().chain(implicit);
    for (scheme, substeps, sound) in schemes.flat_map(|scheme| [(scheme, 1, 0), (scheme, 3, 0), (scheme, 3, 2)]) {
        for guarded_speed in [f64::INFINITY, 0.0] {
            let case = format!("{scheme:?}, {substeps} substeps, {sound} sound, guarded from {guarded_speed} m/s");
            let mut session = open(&scene("integrator = \"backward-euler\"", ""), 1);
            let system = &mut session.bodies[0].system;
            let n = system.nodes.len();
            let free: Vec<usize> = (0..n).filter(|i| system.nodes.constraint[*i].is_free()).collect();
            free.iter().for_each(|i| system.nodes.x[*i].z += 1e-4 * (*i as f64).sin());
            free.iter().for_each(|i| system.nodes.v[*i] = Vec3::new(0.01, -0.02, 1e-3 * *i as f64));
            let (pool, time) = (Pool::new(1), StepTime { start: 0.0, dt: 1e-5 });
            let mut integrator = Integrator::new(scheme, 1e-6, 1000);
            integrator.guarded_speed = guarded_speed;
            integrator.resize(n);
            let before = (system.nodes.x.clone(), system.nodes.constraint.clone());
            let mut contacts = Poisoning { held: free[3], poisoned: free[40], sound };
            let loads = Loads::default();
            let ended = integrator.step_with_contacts(&pool, system, &loads, &mut contacts, time, substeps);
            assert!(matches!(ended, Err(StepError::Diverged { .. } | StepError::Force(_))), "{case}: {ended:?}");
            let apart = system.nodes.x.iter().zip(&before.0).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            let rounding = if scheme == Scheme::ExplicitEuler { 1e-17 } else { 0.0 };
            assert!(apart <= rounding, "{case}: {apart} m from where it was");
            assert!(before.1 == system.nodes.constraint, "{case}: what contacts held is free again");
            assert!(system.nodes.v.iter().all(|v| *v == Vec3::zeros()), "{case}: at rest");
            integrator.step(&pool, system, &loads, time, substeps).unwrap_or_else(|e| panic!("{case}: {e}"));
            assert!(system.nodes.x.iter().all(|x| x.iter().all(|c| c.is_finite())), "{case}: the next step is taken");
        }
    }
}

#[test]
fn a_tip_lets_go_of_a_sheet_that_stands_still() {
    for (time, more) in [
        ("integrator = \"backward-euler\"", ""),
        ("integrator = \"backward-euler\"\nsubsteps = 3", ""),
        ("integrator = \"symplectic-euler\"", ""),
        ("integrator = \"backward-euler\"", "sheets = \"triangles\""),
        ("integrator = \"backward-euler\"", "mass = 0.005"),
    ] {
        let mut session = open(&scene(time, more), 1);
        let before = session.bodies[0].system.nodes.constraint.clone();
        let corner = session.bodies[0].system.nodes.x.iter().position(|x| x.y == 0.0 && (x.x - 0.05).abs() < 0.01);
        while session.frame().tools.first().is_none_or(|tool| tool.force.norm() == 0.0) {
            assert!(session.steps() < 100, "{time}, {more}: the tip touches");
            session.step();
        }
        assert!(session.bodies[0].frozen.is_none(), "{time}, {more}");
        session.bodies[0].system.nodes.v[corner.expect("a node at a free border")].x = f64::NAN;
        session.step();
        let body = &session.bodies[0];
        assert!(body.frozen.is_some() && session.events.count(EventKind::Quarantine) == 1, "{time}, {more}");
        assert!(body.system.nodes.constraint == before, "{time}, {more}: a node is held");
    }
}
