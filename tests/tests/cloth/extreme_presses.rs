//! Presses of random tips on random sheets, far beyond what a hand does: no sheet gets more energy than the hand can give it.

#![allow(clippy::print_stdout, reason = "what failed, and the count")]

use pliant_mesh::testing::Random;
use pliant_tests::{asked_cases, open};

const INTEGRATORS: [&str; 4] = ["backward-euler", "bdf2", "implicit-midpoint", "damped-midpoint"];
const METHODS: [&str; 3] = ["triangles", "vertices", "penalty"];

/// One press: everything about it is drawn from its number.
#[derive(Debug)]
struct Press {
    cells: u32,
    /// Side of the sheet, m.
    side: f64,
    /// N/m, of the sheet.
    young: f64,
    damping_time: f64,
    dt: f64,
    /// m
    radius: f64,
    /// How far the hand goes beyond the sheet, m.
    depth: f64,
    /// m/s
    speed: f64,
    /// N/m, of the coupling.
    coupling: f64,
    /// Of the tip, kg; `None` for a tip that goes where the hand goes.
    mass: Option<f64>,
    friction: [f64; 2],
    integrator: &'static str,
    method: &'static str,
    gravity: [f64; 3],
    /// Whether the hand leaves again or stays.
    leaves: bool,
    /// Where it meets the sheet, in shares of its side.
    at: [f64; 2],
}

/// kg/m^2
const DENSITY: f64 = 0.15;
/// Steps after the hand has come to its end.
const STEPS_AFTER: usize = 40;

impl Press {
    fn new(number: u64) -> Self {
        let random = &mut Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let side = random.pick(&[0.05, 0.2, 1.0]);
        let dt = random.pick(&[1e-4, 1e-3, 1e-2, 3e-2]);
        Self {
            cells: random.pick(&[6, 10, 16, 24]),
            side,
            young: 0.5 * 10_f64.powf(9.0 * random.unit()),
            damping_time: random.pick(&[0.0, 2e-3]),
            dt,
            // A wider ball would press on the held edges, which cannot give way.
            radius: 5e-4 * (0.3 * side / 5e-4).powf(random.unit()),
            depth: side * random.pick(&[0.02, 0.1, 0.3]),
            // At least as fast as takes thirty steps, at most as fast as the engine follows.
            speed: f64::min(random.pick(&[0.05, 0.5, 5.0, 100.0]), 100.0).max(0.3 * side / (30.0 * dt)).min(100.0),
            coupling: 200.0 * 10_f64.powf(4.0 * random.unit()),
            mass: None,
            friction: random.pick(&[[0.0, 0.0], [0.5, 0.4]]),
            integrator: random.pick(&INTEGRATORS),
            method: random.pick(&METHODS),
            gravity: random.pick(&[[0.0; 3], [0.0, -9.81, 0.0], [0.0, 0.0, -9.81]]),
            leaves: random.unit() < 0.5,
            at: [0.4 + 0.2 * random.unit(), 0.4 + 0.2 * random.unit()],
        }
    }

    /// The press with this number by a tip of 1 to 10 g on a stiff sheet.
    fn with_mass(number: u64) -> Self {
        let random = &mut Random(number.wrapping_mul(0xd134_2543_de82_ef95));
        let mass = Some(1e-3 * 10_f64.powf(random.unit()));
        Self { mass, young: 5e6 * 10_f64.powf(2.0 * random.unit()), ..Self::new(number) }
    }

    /// Twice the most energy that a hand that moves a tip by its coupling, the tip and gravity can give: the coupling's spring and damper over the way
    /// of the hand beyond the sheet, and the tip at twice the speed of the hand. A step that is linearised once does not see that edges which move across
    /// themselves become longer, so it may give the energy of that beside.
    fn bound_of_tip(&self, mass: f64) -> f64 {
        let Self { cells, side, young, dt, depth, radius, speed, coupling, gravity, .. } = self;
        let gravity = gravity.iter().map(|g| g.abs()).sum::<f64>();
        let way = depth + 0.02 * side + speed * dt;
        let damping = 2.0 * (mass * coupling).sqrt();
        let hand = 0.5 * coupling * way * way + damping * speed * way + 2.0 * mass * speed * speed;
        let weight = DENSITY * side * side * gravity * (2.0 * side + radius + gravity * dt * dt);
        let (across, edge) = ((speed + gravity * dt) * dt, side / f64::from(*cells));
        2.0 * (hand + weight + young * across.powi(4) / (4.0 * edge * edge))
    }

    /// Twice the most energy that a hand and gravity can give: strain of a patch that goes as far as the hand, and as a fall goes in a step, while its
    /// neighbours do not, with the stiffness of a row of triangles; speed of everything after an elastic impact; and weight.
    fn bound(&self) -> f64 {
        if let Some(mass) = self.mass {
            return self.bound_of_tip(mass);
        }
        let Self { side, young, dt, depth, radius, speed, gravity, .. } = self;
        let (mass, gravity) = (DENSITY * side * side, gravity.iter().map(|g| g.abs()).sum::<f64>());
        let strain = 2.0 * young * (depth + 0.02 * side + gravity * dt * dt).powi(2);
        2.0 * (strain + 0.5 * mass * (2.0 * speed).powi(2) + mass * gravity * (2.0 * side + radius))
    }

    /// Runs it. Returns the largest energy of the sheet, J.
    fn run(&self) -> f64 {
        let Self { cells, side, young, damping_time, dt, radius, speed, coupling, friction, .. } = self;
        let Self { integrator, method, gravity, .. } = self;
        let [x, y] = self.at.map(|share| share * side);
        let (begin, high, low) = (2.0 * dt, radius + 0.02 * side, radius - self.depth);
        let there = begin + (high - low) / speed;
        let mut end = there + STEPS_AFTER as f64 * dt;
        let mut path = format!("[0, {x}, {y}, {high}], [{begin}, {x}, {y}, {high}], [{there}, {x}, {y}, {low}]");
        if self.leaves {
            let (leave, gone) = (there + 10.0 * dt, there + 10.0 * dt + (high - low) / speed);
            path += &format!(", [{leave}, {x}, {y}, {low}], [{gone}, {x}, {y}, {high}]");
            end = gone + STEPS_AFTER as f64 * dt;
        }
        let scene = format!(
            r#"
            format = 1
            gravity = {gravity:?}
            [time]
            duration = {end}
            dt = {dt:?}
            integrator = "{integrator}"
            [[body]]
            name = "sheet"
            shape = {{ kind = "sheet", cells = {cells}, size = [{side}, {side}, 0] }}
            sheet = {{ warp = [1, 0, 0] }}
            material = {{ plugin = "cloth", params = {{ density = {DENSITY}, young-warp = {young:e}, poisson = 0.3, bending-warp = {bending:e}, damping-time = {damping_time:?} }} }}
            [[body.fixed]]
            box = [[-1, {edge}, -1], [2, 2, 1]]
            [[device]]
            name = "hand"
            params = {{ path = [{path}], peak-force = 10000 }}
            [[tool]]
            name = "tip"
            device = "hand"
            radius = {radius}
            stiffness = {coupling}
            friction = {friction:?}
            {mass}
            sheets = "{method}"
            speed = 200
            [[edit]]
            kind = "touch"
            tool = "tip"
            [output]
            energy = true
            "#,
            mass = self.mass.map_or(String::new(), |mass| format!("mass = {mass:e}")),
            bending = 2e-8 * young,
            edge = side * (1.0 - 1e-6),
        );
        let mut session = open(&scene, 1);
        let mut most = 0.0_f64;
        while session.time() < end {
            session.step();
            let frame = session.frame();
            let energy = frame.kinetic_energy + frame.elastic_energy;
            most = if energy.is_finite() { most.max(energy) } else { f64::INFINITY };
        }
        assert!(session.bodies[0].frozen.is_none(), "{self:?}");
        most
    }
}

/// Runs these presses and asserts that none gives its sheet more than it may.
fn check(presses: impl Iterator<Item = (u64, Press)>) {
    let (mut failed, mut count) = (0, 0);
    for (number, press) in presses {
        let (most, bound) = (press.run(), press.bound());
        count += 1;
        if most > bound {
            failed += 1;
            println!("{number}: {most:.2e} J, more than {bound:.2e} J: {press:?}");
        }
    }
    println!("{failed} of {count} presses failed");
    assert_eq!(failed, 0);
}

#[test]
fn a_sheet_gets_no_more_energy_than_the_hand_can_give() {
    check(asked_cases("PRESSES").unwrap_or(0..120).map(|number| (number, Press::new(number))));
}

#[test]
fn a_stiff_sheet_gets_no_more_energy_than_a_light_tip_and_its_hand_can_give() {
    check(asked_cases("PRESSES").unwrap_or(0..120).map(|number| (number, Press::with_mass(number))));
}
