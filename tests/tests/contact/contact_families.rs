//! Presses of random closed bodies by random balls: the proxy never gets inside, and a hand that goes in is felt all the while.

#![allow(clippy::print_stdout, reason = "what failed, and the count")]

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::{Vec3, closest_point};
use pliant_mesh::testing::{Random, TestModel, scan};
use pliant_tests::{Bench, asked_cases, open_file};

const SOLIDS: [&str; 3] = ["mass-spring", "neo-hookean", "corotational"];
const INTEGRATORS: [&str; 4] = ["auto", "backward-euler", "bdf2", "implicit-midpoint"];

/// One press: everything about it is drawn from its number.
struct Press {
    model: TestModel,
    level: u32,
    solid: &'static str,
    integrator: &'static str,
    /// m
    radius: f64,
    /// How far the ball would go in, m.
    depth: f64,
    /// s, from 12 mm above the surface to the depth
    takes: f64,
    young: f64,
    /// A ray onto the model, in shares of its box.
    from: [f64; 3],
    toward: [f64; 3],
}

impl Press {
    fn new(number: u64, levels: std::ops::RangeInclusive<u32>) -> Self {
        let random = &mut Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let genus = u32::from(random.unit() < 0.3);
        let model = scan(genus, 1500, 0, number);
        let level = levels.start() + random.below(u64::from(levels.end() - levels.start() + 1)) as u32;
        let cell = 0.1 / f64::from(1_u32 << level);
        // A tenth of a cell to twenty cells, but no ball that is wider than the body.
        let most = f64::min(20.0 * cell, 0.015);
        let radius = 0.1 * cell * (most / (0.1 * cell)).powf(random.unit());
        let toward = vertex(&model, random);
        Self {
            model,
            level,
            solid: random.pick(&SOLIDS),
            integrator: random.pick(&INTEGRATORS),
            radius,
            depth: 0.001 + 0.009 * random.unit(),
            takes: 0.02 + 0.15 * random.unit(),
            young: 5e3 * 20_f64.powf(random.unit()),
            from: (toward + 2.0 * random.direction()).into(),
            toward: toward.into(),
        }
    }

    fn open(&self, bench: &Bench) -> Session {
        bench.write("model.obj", &self.model.text);
        let (end, low, young) = (self.takes + 0.05, self.radius - self.depth, self.young);
        let Self { level, solid, integrator, radius, takes, from, toward, .. } = self;
        let scene = format!(
            r#"
            format = 1
            [time]
            duration = {end}
            dt = 0.001
            integrator = "{integrator}"
            [[body]]
            name = "model"
            mesh = "model.obj"
            size = "100 mm"
            material = {{ plugin = "{solid}", params = {{ young = {young}, density = 1000, damping-time = 0.002 }} }}
            grid = {{ level = {level} }}
            [[device]]
            name = "hand"
            frame = {{ body = "model", from = {from:?}, toward = {toward:?} }}
            params = {{ interpolation = "smooth", path = [[0, 0, 0, {high}], [{takes}, 0, 0, {low}], [{end}, 0, 0, {low}]] }}
            [[tool]]
            name = "ball"
            device = "hand"
            radius = {radius}
            stiffness = "200 N/m"
            friction = [0, 0]
            [[edit]]
            kind = "touch"
            tool = "ball"
            "#,
            high = 0.012 + radius,
        );
        open_file(&bench.write("scene.toml", scene), 1, None)
    }

    /// Runs it, and says what went wrong.
    fn run(&self, bench: &Bench) -> Vec<String> {
        let mut session = self.open(bench);
        let mut wrong = Vec::new();
        let steps = ((self.takes + 0.05) * 1e3) as usize;
        let mut before: Option<f64> = None;
        for step in 0..steps {
            session.step();
            let tool = session.frame().tools[0];
            let time = session.time();
            if session.events.count(EventKind::Quarantine) > 0 {
                wrong.push(format!("{time:.3} s: taken out of the simulation"));
                break;
            }
            let force = tool.force.norm();
            let held = time > self.takes;
            if held
                && let Some(before) = before
                && (force - before).abs() > 0.25 * before + 0.02
            {
                wrong.push(format!("{time:.3} s: the force jumps from {before:.3} to {force:.3} N"));
            }
            before = held.then_some(force);
            if step % 5 == 0 || held {
                session.update_surface();
                let body = &session.bodies[0];
                let (x, triangles) = (&body.skin.x, &body.model.surface.triangles);
                let inside = |p: Vec3| winding(p, x, triangles).abs() > 0.5;
                if inside(tool.proxy) {
                    wrong.push(format!("{time:.3} s: the proxy is inside"));
                }
                // A frictionless ball may slide off a thin part, so the hand need not stay in the body.
                let gap = distance(tool.hand, x, triangles);
                let deep = gap < 0.9 * self.radius || inside(tool.hand);
                if deep && (tool.contact.is_none() || force == 0.0) {
                    wrong.push(format!("{time:.3} s: no contact, the hand {:.2} mm from the surface", 1e3 * gap));
                }
            }
            if wrong.len() > 3 {
                break;
            }
        }
        wrong
    }
}

/// A random vertex of a model, in shares of its box.
fn vertex(model: &TestModel, random: &mut Random) -> Vec3 {
    let document = model.document();
    let points = document.positions();
    let low = points.iter().copied().reduce(|a, b| a.inf(&b)).expect("vertices");
    let high = points.iter().copied().reduce(|a, b| a.sup(&b)).expect("vertices");
    (points[random.below(points.len() as u64) as usize] - low).component_div(&(high - low))
}

/// How often a closed surface winds around a point (van Oosterom and Strackee 1983): 1 inside, 0 outside.
fn winding(p: Vec3, x: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| x[v as usize] - p);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Distance of a point from the nearest triangle, m.
fn distance(p: Vec3, x: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let to = |t: &[u32; 3]| (closest_point(p, t.map(|v| x[v as usize])).point - p).norm();
    triangles.iter().map(to).fold(f64::INFINITY, f64::min)
}

fn run_all(numbers: impl Iterator<Item = u64>, levels: std::ops::RangeInclusive<u32>) {
    let bench = Bench::new();
    let (mut runs, mut failed) = (0, 0);
    for number in numbers {
        let press = Press::new(number, levels.clone());
        let wrong = press.run(&bench);
        runs += 1;
        if !wrong.is_empty() {
            failed += 1;
            let Press { level, solid, integrator, radius, depth, takes, young, .. } = &press;
            println!(
                "{number}: {} level {level} {solid} {integrator}, radius {:.2} mm, depth {:.1} mm in {takes:.2} s, {young:.0} Pa: {}",
                press.model.name,
                1e3 * radius,
                1e3 * depth,
                wrong.join("; ")
            );
        }
    }
    println!("{failed} of {runs} presses failed");
    assert_eq!(failed, 0);
}

/// 60 presses at levels 3 to 5; at levels 3 to 8 those of `PRESSES`, as `0..2000`, which takes hours.
#[test]
fn no_ball_gets_into_a_closed_body_nor_does_its_force_jump() {
    match asked_cases("PRESSES") {
        Some(asked) => run_all(asked, 3..=8),
        None => run_all(0..60, 3..=5),
    }
}
