//! A step that would take for ever is ended by a signal, by the scene's patience and by a token, in every loop that has many rounds; it is
//! taken back.

#![cfg(unix)]

use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{CancelToken, Options, Session};
use pliant_host::SearchPath;
use pliant_solver::{
    Constraint, ContactConstraints, Integrator, Interrupts, Loads, Pool, Scheme, StepError, StepTime, System,
    TrialStep, Vec3,
};
use pliant_tests::{Bench, box_scene, deps};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Schemes whose step takes for ever, in substeps.
const SCHEMES: [&str; 2] = ["symplectic-euler", "backward-euler"];

/// A scene whose body is simulated as a whole from the first step on.
fn whole(time: &str) -> String {
    let fixed = "fixed = [{ box = [[-1.0, -1.0, -1.0], [1.0, -0.015, 1.0]] }]";
    let grid = format!("grid = {{ level = 3, region = \"whole\" }}\n{fixed}");
    let text = box_scene(time, "", "").replace("format = 1", "format = 1\ngravity = [0.0, -9.81, 0.0]");
    text.replace("grid = { level = 5 }", &grid)
}

/// The same with steps that never end.
fn endless(case: usize, more: &str) -> String {
    let substeps = "substeps = 4000000000\nmost-substeps = 4294967295";
    whole(&format!("integrator = \"{}\"\n{substeps}\n{more}", SCHEMES[case]))
}

fn opened(bench: &Bench, text: &str) -> Session {
    let path = bench.write("scene.toml", text);
    let (scene, source) = scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
    let plan = Plan::new(&scene, &source).unwrap_or_else(|e| panic!("{e}"));
    let options = Options::new(SearchPath::new(&[deps()]), 1);
    Session::open(&scene, &source, plan, &options).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_token_ends_the_step_and_the_body_is_where_it_was() {
    for case in 0..SCHEMES.len() {
        let bench = Bench::new();
        let mut session = opened(&bench, &endless(case, ""));
        let token = CancelToken::default();
        session.cancel_when(token.clone());
        let canceller = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(150));
            token.cancel();
            Instant::now()
        });
        session.step();
        let ended = Instant::now();
        println!("case {case}: ended {:?} after it was cancelled", ended - canceller.join().expect("cancelled"));
        let nodes = &session.bodies[0].system.nodes;
        assert!(session.is_cancelled() && session.steps() == 0 && session.bodies[0].frozen.is_none(), "case {case}");
        // Gravity has pulled in thousands of substeps.
        assert!(nodes.len() > 100 && nodes.x == nodes.rest, "case {case}: the step was taken back");
        assert!(nodes.v.iter().all(|v| *v == Vec3::zeros()), "case {case}: and the velocities with it");
    }
}

/// Two bodies that fall onto their fixings, and a finger that slides over the first and paints it.
fn two_bodies(scheme: &str) -> String {
    let text = whole(&format!("integrator = \"{scheme}\""));
    let text = text.replace("0.001]", "0.0035]").replace("kind = \"touch\"", "kind = \"paint\"\nradius = \"8 mm\"");
    let from = text.find("[[body]]").expect("a body");
    let to = text.find("[[device]]").expect("a device");
    let second = text[from..to].replace("name = \"block\"", "name = \"other\"\nposition = [0.1, 0, 0]");
    format!("{}{second}{}", &text[..to], &text[to..])
}

/// Everything that a step changes and a viewer sees, to the bit.
fn state(session: &Session) -> Vec<u64> {
    let bodies = session.bodies.iter().flat_map(|body| {
        let nodes = &body.system.nodes;
        nodes
            .x
            .iter()
            .chain(&nodes.v)
            .flat_map(|v| [v.x, v.y, v.z])
            .chain(nodes.mass.iter().copied())
            .collect::<Vec<_>>()
    });
    let frame = session.frame();
    let felt =
        frame.tools.iter().flat_map(|tool| [tool.force, tool.proxy, tool.device_force]).flat_map(|v| [v.x, v.y, v.z]);
    let counts = [frame.nodes as f64, frame.elements as f64, session.time()];
    bodies.chain(felt.collect::<Vec<_>>()).chain(counts).map(f64::to_bits).collect()
}

/// A step that is cancelled and taken again is the step that was never cancelled, to the bit: tools have not moved twice, nor have bodies before the one
/// under way.
#[test]
fn a_cancelled_step_that_goes_on_is_the_step_that_was_never_cancelled() {
    for scheme in SCHEMES {
        let bench = Bench::new();
        let text = two_bodies(scheme);
        let (mut cancelled, mut undisturbed) = (opened(&bench, &text), opened(&bench, &text));
        let mut count = 0;
        for step in 0..60 {
            if step % 3 == 2 {
                let token = CancelToken::default();
                cancelled.cancel_when(token.clone());
                // Before the first body moves; or, where a step leaves no trace in the solver, anywhere in it.
                let canceller = (scheme == "symplectic-euler" && step % 2 == 0).then(|| {
                    let token = token.clone();
                    std::thread::spawn(move || token.cancel())
                });
                if canceller.is_none() {
                    token.cancel();
                }
                cancelled.step();
                count += u64::from(cancelled.is_cancelled());
                let is_taken = u64::from(!cancelled.is_cancelled());
                assert_eq!(cancelled.steps(), step + is_taken, "{scheme}");
                if let Some(thread) = canceller {
                    thread.join().expect("cancelled");
                }
                cancelled.cancel_when(CancelToken::default());
            }
            if cancelled.steps() == step {
                cancelled.step();
            }
            undisturbed.step();
            assert!(!cancelled.is_cancelled() && cancelled.steps() == step + 1, "{scheme}: step {step}");
            assert!(state(&cancelled) == state(&undisturbed), "{scheme}: step {step}");
        }
        let force = undisturbed.frame().tools[0].force.norm();
        assert!(count >= 10 && force > 0.0, "{scheme}: {count} steps were cancelled, {force} N");
    }
}

/// Between a cancelled step and the next one the session may be changed: then the step begins anew.
#[test]
fn an_undo_after_a_cancelled_step_is_of_what_was_before_it() {
    let bench = Bench::new();
    let text = two_bodies("symplectic-euler").replace("radius = \"8 mm\"", "radius = \"8 mm\"\nend = 0.03");
    let (mut cancelled, mut undisturbed) = (opened(&bench, &text), opened(&bench, &text));
    [&mut cancelled, &mut undisturbed].into_iter().for_each(Session::keep_history);
    for _ in 0..40 {
        cancelled.step();
        undisturbed.step();
    }
    let token = CancelToken::default();
    token.cancel();
    cancelled.cancel_when(token);
    cancelled.step();
    assert!(cancelled.is_cancelled());
    cancelled.cancel_when(CancelToken::default());
    assert!(cancelled.undo() && undisturbed.undo(), "a stroke has ended");
    for step in 0..5 {
        cancelled.step();
        undisturbed.step();
        assert!(state(&cancelled) == state(&undisturbed), "step {step} after the undo");
    }
}

/// Where in a step its token is cancelled.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Moment {
    Begin,
    InSolve,
    AfterSolve,
}

/// Contacts that hold one node and cancel the step they are asked in.
struct Cancelling {
    token: CancelToken,
    at: Moment,
    /// A node that is free between steps.
    node: usize,
    /// Number of substeps after which a step is cancelled instead, or 0.
    whole: usize,
}

impl Cancelling {
    fn cancel(&self, now: Moment) {
        if self.at == now && self.whole == 0 {
            self.token.cancel();
        }
    }
}

impl ContactConstraints for Cancelling {
    fn begin(&mut self, system: &mut System, _: f64) {
        system.nodes.constraint[self.node] = Constraint::Fixed;
        self.cancel(Moment::Begin);
    }

    fn add_forces(&self, _: &mut [Vec3]) {}

    fn update_active_set(&mut self, _: &mut System, _: &TrialStep<'_>) -> bool {
        self.cancel(Moment::AfterSolve);
        false
    }

    fn can_stop_early(&self, _: &System, _: &TrialStep<'_>) -> bool {
        self.cancel(Moment::InSolve);
        false
    }

    fn has_candidates(&self) -> bool {
        true
    }

    fn is_active(&self) -> bool {
        false
    }

    fn keep_start(&mut self) {}

    fn take_back(&mut self, system: &mut System) {
        system.nodes.release(self.node as u32);
    }

    fn end(&mut self, system: &mut System, _: &mut [Vec3]) {
        assert!(self.whole > 0, "a cancelled step has no end");
        self.whole -= 1;
        if self.whole == 0 {
            self.token.cancel();
        }
        system.nodes.release(self.node as u32);
    }
}

#[test]
fn substeps_newton_and_solver_iterations_look_for_a_stop() {
    let cases = [
        (Scheme::BackwardEuler, Moment::Begin, 1, 1),
        (Scheme::BackwardEuler, Moment::InSolve, 1, 1),
        (Scheme::BackwardEuler, Moment::InSolve, 3, 1),
        (Scheme::BackwardEuler, Moment::AfterSolve, 1, 5),
        (Scheme::QuasiStatic, Moment::Begin, 1, 5),
    ];
    for (scheme, at, substeps, newton) in cases {
        let bench = Bench::new();
        let mut session = opened(&bench, &whole("integrator = \"backward-euler\""));
        session.step();
        let system = &mut session.bodies[0].system;
        let n = system.nodes.len();
        let free: Vec<usize> = (0..n).filter(|i| system.nodes.constraint[*i].is_free()).collect();
        free.iter().for_each(|i| system.nodes.v[*i] = Vec3::new(0.1, -0.2, 0.01 * *i as f64));
        free.iter().step_by(3).for_each(|i| system.nodes.x[*i].y += 1e-4);
        let (pool, time) = (Pool::new(1), StepTime { start: 0.0, dt: 1e-3 });
        let mut integrator = Integrator::new(scheme, 1e-9, 1000);
        (integrator.max_newton, integrator.newton_tolerance) = (newton, 0.0);
        integrator.resize(n);
        let before = (system.nodes.x.clone(), system.nodes.v.clone(), system.nodes.constraint.clone());
        let mut contacts = Cancelling { token: integrator.interrupts.cancel.clone(), at, node: free[0], whole: 0 };
        let loads = Loads::default();
        let ended = integrator.step_with_contacts(&pool, system, &loads, &mut contacts, time, substeps);
        assert!(matches!(ended, Err(StepError::Cancelled)), "{scheme:?}, {at:?}: {ended:?}");
        assert!(before.0 == system.nodes.x && before.1 == system.nodes.v, "{scheme:?}, {at:?}: taken back");
        assert!(before.2 == system.nodes.constraint, "{scheme:?}, {at:?}: what contacts held is free again");
        integrator.interrupts = Interrupts { deadline: Some(Instant::now()), ..Interrupts::default() };
        let ended = integrator.step(&pool, system, &loads, time, substeps);
        assert!(matches!(ended, Err(StepError::TimedOut)), "{scheme:?}, {at:?}: {ended:?}");
        integrator.interrupts = Interrupts::default();
        integrator.step(&pool, system, &loads, time, substeps).unwrap_or_else(|e| panic!("{scheme:?}: {e}"));
        assert!(before.0 != system.nodes.x, "{scheme:?}: the next step is taken");
    }
}

#[test]
fn a_stopped_step_leaves_the_history_of_elements_as_it_was() {
    let clay = "{ plugin = \"neo-hookean\", params = { young = 5e4, poisson = 0.3, yield-strain = 0.002, flow-time = 0.002 } }";
    for scheme in [Scheme::SymplecticEuler, Scheme::BackwardEuler] {
        let bench = Bench::new();
        let text = whole("integrator = \"backward-euler\"").replace("{ plugin = \"mass-spring\" }", clay);
        let mut session = opened(&bench, &text);
        session.step();
        let system = &mut session.bodies[0].system;
        let n = system.nodes.len();
        let free: Vec<usize> = (0..n).filter(|i| system.nodes.constraint[*i].is_free()).collect();
        free.iter().step_by(3).for_each(|i| system.nodes.x[*i].y += 3e-4);
        let history =
            |system: &System| -> Vec<f64> { system.sets.iter().flat_map(|set| set.history().to_vec()).collect() };
        let (pool, time) = (Pool::new(1), StepTime { start: 0.0, dt: 1e-4 });
        let mut integrator = Integrator::new(scheme, 1e-9, 1000);
        integrator.guarded_speed = 1e9;
        integrator.resize(n);
        let token = integrator.interrupts.cancel.clone();
        let mut contacts = Cancelling { token, at: Moment::Begin, node: free[0], whole: 3 };
        let before = history(system);
        let loads = Loads::default();
        let ended = integrator.step_with_contacts(&pool, system, &loads, &mut contacts, time, 5);
        assert!(matches!(ended, Err(StepError::Cancelled)) && contacts.whole == 0, "{scheme:?}: {ended:?}");
        assert!(!before.is_empty() && before == history(system), "{scheme:?}: taken back");
        integrator.interrupts = Interrupts::default();
        integrator.step(&pool, system, &loads, time, 5).unwrap_or_else(|e| panic!("{scheme:?}: {e}"));
        assert!(before != history(system), "{scheme:?}: clay flows in this step");
    }
}

#[test]
fn a_signal_ends_a_run_in_good_order() {
    for case in 0..SCHEMES.len() {
        for (signal, extra) in [("INT", &[][..]), ("TERM", &["--isolate"][..]), ("TERM", &["--live"][..])] {
            let bench = Bench::new();
            bench.write("scene.toml", endless(case, ""));
            let args = [&["run", "scene.toml", "--out", "out", "--record", "hand.rec"], extra].concat();
            let mut child = bench.command(&args).stderr(Stdio::piped()).spawn().expect("starts");
            while bench.stages().is_empty() {
                assert!(child.try_wait().expect("asked").is_none(), "case {case} {extra:?}: it ended");
                std::thread::sleep(Duration::from_millis(5));
            }
            // Into the first step.
            std::thread::sleep(Duration::from_millis(200));
            assert!(child.try_wait().expect("asked").is_none(), "case {case} {extra:?}: it does not end by itself");
            let sent = Instant::now();
            let id = child.id().to_string();
            assert!(Command::new("kill").args([&format!("-{signal}"), &id]).status().expect("kill").success());
            let told = child.wait_with_output().expect("ends");
            println!("case {case} {extra:?}: ended {:?} after the signal", sent.elapsed());
            let text = String::from_utf8_lossy(&told.stderr).into_owned();
            assert_eq!(told.status.code(), Some(130), "case {case} {extra:?}: {text}");
            let summary = bench.summary("out/interrupted");
            assert!(summary["interrupted"] == true && summary["steps"] == 0, "case {case} {extra:?}: {summary}");
            assert!(bench.path("hand.rec").is_file() && bench.stages().is_empty());
        }
    }
}

#[test]
fn patience_ends_a_step_and_a_replay_gives_the_same_bits() {
    for case in 0..SCHEMES.len() {
        let bench = Bench::new();
        bench.write("scene.toml", endless(case, "patience = \"300 ms\""));
        let args = ["run", "scene.toml", "-q", "--out", "out", "--record", "hand.rec"];
        bench.pliant(&args).expect(3);
        let summary = bench.summary("out");
        assert!(summary["bodies"][0]["frozen"].is_string() && summary["event_counts"]["quarantine"] == 1, "{summary}");
        assert!(summary["steps"] == 50, "the rest goes on: {}", summary["steps"]);
        let again = bench.pliant(&["replay", "hand.rec", "--verify", "--out", "again"]).expect(3);
        again.says(&["the same state, to the bit"]);
        assert_eq!(bench.read("out/nodes.csv"), bench.read("again/nodes.csv"), "case {case}");
    }
}

#[test]
fn a_signal_ends_the_step_of_a_report_and_its_run_does_not_count() {
    let bench = Bench::new();
    bench.write("scene.toml", endless(0, ""));
    let report = ["report", "accuracy", "--scene", "scene.toml", "--quick", "--out", "report"];
    let mut command = bench.command(&report);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("started");
    // Its folder is made before the first run; a signal in between is noticed too.
    while !bench.path("report").exists() {
        assert!(child.try_wait().expect("asked").is_none(), "it ended before its first run");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("`kill` starts");
    assert!(sent.success());
    let ended = child.wait_with_output().expect("ended");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{said}");
    assert!(said.contains("stopped; results so far are in"), "{said}");
}
