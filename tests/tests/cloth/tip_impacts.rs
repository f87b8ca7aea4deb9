//! Impacts of fingertips with a mass on sheets: momentum goes from the tip to the sheet, and no energy comes from nowhere.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_tests::open;

/// m/s
const SPEED: f64 = 5.0;

/// A free square sheet of 20 mm and `sheet` kg that flies at a plate of `tip` kg at rest and meets it with all of its vertices at once. The hand of the plate
/// has no force to speak of.
fn impact(tip: f64, sheet: f64, young: f64, solver: [&str; 2]) -> Session {
    flight([tip, sheet], young, solver, 0.0115, SPEED)
}

/// The same at the `speed` (m/s), with a plate that is `gap` (m) before the sheet.
fn flight([tip, sheet]: [f64; 2], young: f64, [integrator, newton]: [&str; 2], gap: f64, speed: f64) -> Session {
    let height = 0.03 + gap;
    let scene = format!(
        r#"
        format = 1
        gravity = [0, 0, -1e-12]
        [time]
        dt = 0.001
        integrator = "{integrator}"
        [solver]
        newton = {newton}
        [[body]]
        shape = {{ kind = "sheet", cells = 4, size = [0.02, 0.02, 0] }}
        position = [-0.01, -0.01, 0]
        sheet = {{ warp = [1, 0, 0] }}
        material = {{ plugin = "cloth", params = {{ density = {density:e}, young-warp = {young:e}, bending-warp = 1e-3, damping-time = 0 }} }}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0, 0, {height}], [1, 0, 0, {height}]] }}
        [[tool]]
        name = "plate"
        device = "hand"
        shape = {{ kind = "box", size = [0.06, 0.06, 0.06] }}
        stiffness = 1e-6
        mass = {tip:e}
        sheets = "vertices"
        friction = [0, 0]
        speed = 200
        [[edit]]
        kind = "touch"
        tool = "plate"
        "#,
        density = sheet / 4e-4,
    );
    let mut session = open(&scene, 1);
    // The hand is there before the sheet moves.
    session.step();
    session.bodies[0].system.nodes.v.fill(Vec3::new(0.0, 0.0, speed));
    session
}

/// Mean velocity of the sheet along z, m/s.
fn velocity(session: &Session) -> f64 {
    let nodes = &session.bodies[0].system.nodes;
    let momentum: Vec3 = nodes.v.iter().zip(&nodes.mass).map(|(v, m)| *m * *v).sum();
    momentum[2] / nodes.mass.iter().sum::<f64>()
}

#[test]
fn a_plate_that_catches_a_free_sheet_shares_its_momentum_with_it() {
    for (tip, sheet) in [(1e-3, 1e-4), (1e-3, 1e-3), (1e-2, 1e-3), (1e-3, 1e-2)] {
        for young in [1e2, 1e6, 1e9] {
            for solver in [["backward-euler", "1"], ["bdf2", "1"], ["implicit-midpoint", "1"], ["backward-euler", "4"]]
            {
                let mut session = impact(tip, sheet, young, solver);
                for _ in 0..20 {
                    session.step();
                }
                let last = velocity(&session);
                // A perfectly inelastic impact.
                let wanted = SPEED * sheet / (tip + sheet);
                assert!(
                    (last - wanted).abs() < 0.01 * SPEED,
                    "{tip} kg on {sheet} kg, {young} N/m, {solver:?}: {last} m/s for {wanted}"
                );
            }
        }
    }
}

#[test]
fn a_sheet_flies_on_until_it_meets_a_tip_with_any_number_of_newton_iterations() {
    for newton in ["1", "2", "4"] {
        // 50 mm a step, and the plate is 130 mm away.
        let mut session = flight([1.0, 1e-3], 1e3, ["backward-euler", newton], 0.13, 50.0);
        session.step();
        session.step();
        assert!((velocity(&session) - 50.0).abs() < 1e-9, "{newton} iterations: {} m/s", velocity(&session));
        session.step();
        assert!(velocity(&session) < 40.0, "{newton} iterations: {} m/s", velocity(&session));
    }
}
