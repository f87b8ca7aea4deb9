//! Impacts of fingertips with a mass on sheets: momentum goes from the tip to the sheet, and no energy comes from nowhere.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_tests::open;

/// m/s
const SPEED: f64 = 5.0;

/// A free square sheet of 20 mm and `sheet` kg that flies at a plate of `tip` kg at rest and meets it with all of its vertices at once. The hand of the plate
/// has no force to speak of.
fn impact(tip: f64, sheet: f64, young: f64, integrator: &str) -> Session {
    let scene = format!(
        r#"
        format = 1
        gravity = [0, 0, -1e-12]
        [time]
        dt = 0.001
        integrator = "{integrator}"
        [[body]]
        shape = {{ kind = "sheet", cells = 4, size = [0.02, 0.02, 0] }}
        position = [-0.01, -0.01, 0]
        sheet = {{ warp = [1, 0, 0] }}
        material = {{ plugin = "cloth", params = {{ density = {density:e}, young-warp = {young:e}, bending-warp = 1e-3, damping-time = 0 }} }}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0, 0, 0.0415], [1, 0, 0, 0.0415]] }}
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
    session.bodies[0].system.nodes.v.fill(Vec3::new(0.0, 0.0, SPEED));
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
            for integrator in ["backward-euler", "bdf2", "implicit-midpoint"] {
                let mut session = impact(tip, sheet, young, integrator);
                for _ in 0..20 {
                    session.step();
                }
                let last = velocity(&session);
                // A perfectly inelastic impact.
                let wanted = SPEED * sheet / (tip + sheet);
                assert!(
                    (last - wanted).abs() < 0.01 * SPEED,
                    "{tip} kg on {sheet} kg, {young} N/m, {integrator}: {last} m/s for {wanted}"
                );
            }
        }
    }
}
