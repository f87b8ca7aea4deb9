//! Contact does not depend on how stiff the coupling between hand and tool is: from a spring of a device to one that is rigid next to the body.

use pliant_tests::{box_scene, open};

/// Frames of a ball that is pressed 5 mm into a block within 30 ms and dragged along it by 2 mm.
struct Press {
    /// Whether the tool was in contact, in each step from the first contact on.
    in_contact: Vec<bool>,
    /// Magnitude of the force on the hand in each of these steps, N.
    force: Vec<f64>,
    /// Largest energy of the block, and work that the hand has done by the end, J.
    energy: f64,
    work: f64,
}

/// A ball on a block of cells of 2.5 mm.
#[derive(Debug)]
struct Ball {
    friction: [f64; 2],
    /// m
    radius: f64,
    /// Number of triangles' edges along an edge of the block, 40 mm.
    cells: u32,
}

/// Larger than a cell, where the elastic layer carries them; smaller, on triangles smaller and larger than a cell.
const BALLS: [Ball; 8] = [
    Ball { friction: [0.0, 0.0], radius: 4e-3, cells: 12 },
    Ball { friction: [0.5, 0.4], radius: 4e-3, cells: 12 },
    Ball { friction: [0.5, 0.4], radius: 8e-3, cells: 12 },
    Ball { friction: [0.0, 0.0], radius: 2e-3, cells: 32 },
    Ball { friction: [0.5, 0.4], radius: 2e-3, cells: 32 },
    Ball { friction: [0.5, 0.4], radius: 5e-4, cells: 32 },
    Ball { friction: [0.5, 0.4], radius: 2e-3, cells: 12 },
    Ball { friction: [0.5, 0.4], radius: 5e-4, cells: 6 },
];

/// Of the coupling, N/m.
const STIFFNESSES: [f64; 5] = [1e3, 1e4, 1e5, 1e6, 1e8];

fn press(material: &str, ball: &Ball, stiffness: f64) -> Press {
    let Ball { friction, radius, cells } = ball;
    let (above, below) = (radius + 2e-3, radius - 3e-3);
    let text = box_scene("", "", "[output]\nenergy = true")
        .replace("plugin = \"mass-spring\"", &format!("plugin = \"{material}\""))
        .replace("cells = 12", &format!("cells = {cells}"))
        .replace("0.0, 0.0, 0.0, 0.006", &format!("0, 0, 0, {above:?}"))
        .replace("0.0, 0.0, 0.001", &format!("0, 0, {below:?}"))
        .replace("0.002, 0.0, 0.001", &format!("0.002, 0, {below:?}"))
        .replace(
            "radius = \"4 mm\"",
            &format!("radius = {radius:?}\nstiffness = {stiffness:?}\nfriction = {friction:?}"),
        );
    let mut session = open(&text, 1);
    let mut press = Press { in_contact: vec![], force: vec![], energy: 0.0, work: 0.0 };
    session.step();
    let mut last = session.frame().tools[0];
    for _ in 1..50 {
        session.step();
        let frame = session.frame();
        let tool = frame.tools[0];
        press.energy = press.energy.max(frame.kinetic_energy + frame.elastic_energy);
        press.work -= 0.5 * (tool.force + last.force).dot(&(tool.hand - last.hand));
        if tool.contact.is_some() || !press.in_contact.is_empty() {
            press.in_contact.push(tool.contact.is_some());
            press.force.push(tool.force.norm());
        }
        last = tool;
    }
    assert!(session.bodies[0].frozen.is_none(), "{material} {ball:?} {stiffness}");
    press
}

#[test]
fn a_coupling_of_any_stiffness_presses_as_a_rigid_one_does() {
    for material in ["mass-spring", "neo-hookean", "corotational"] {
        for ball in &BALLS {
            let (mut forces, mut energies) = (Vec::new(), Vec::new());
            for stiffness in STIFFNESSES {
                let what = format!("{material} {ball:?} {stiffness}");
                let found = press(material, ball, stiffness);
                let end = *found.force.last().unwrap();
                assert!(found.in_contact.len() > 15 && found.in_contact.iter().all(|c| *c), "{what}: contact is lost");
                // The force rises with the depth: a step is a fifteenth of the way, which dynamics can double, and a ball that begins to slide loses a fifth of its friction.
                let jump = found.force.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
                assert!(jump < 0.5 * end, "{what}: the force jumps by {jump} N of {end} N");
                // Work is summed with the forces at the ends of steps, by when the surface has given way to them: it is too small, the more so the
                // stiffer the coupling is. What stiffer ones give is compared with this one below.
                if stiffness == STIFFNESSES[0] {
                    assert!(found.energy < 2.0 * found.work, "{what}: {} J of {} J", found.energy, found.work);
                }
                energies.push(found.energy);
                forces.push(end);
            }
            // Body and layer are as stiff as 0.1 to 1 kN/m, so from 1e4 N/m on the coupling's share of the way is under a tenth.
            for values in [&forces, &energies] {
                let [low, high] = [f64::min, f64::max].map(|fold| values[1..].iter().copied().reduce(fold).unwrap());
                assert!(high < 1.25 * low, "{material} {ball:?}: {values:?}");
            }
        }
    }
}

/// Forces of a hand that takes hold of the top of the block and draws it out by 3 mm, in each step from the first hold on, N.
fn draw_out(material: &str, kind: &str, radius: f64, stiffness: f64) -> Vec<f64> {
    let text = box_scene("", "", "")
        .replace("plugin = \"mass-spring\"", &format!("plugin = \"{material}\""))
        .replace("path = [", "interpolation = \"smooth\", path = [")
        .replace("0.0, 0.0, 0.0, 0.006", "0, 0, 0, 0")
        .replace("0.0, 0.0, 0.001", "0, 0, 0.003")
        .replace("0.002, 0.0, 0.001", "0, 0, 0.003")
        .replace("radius = \"4 mm\"", &format!("radius = {radius:?}\nstiffness = {stiffness:?}"))
        .replace("kind = \"touch\"", &format!("kind = \"{kind}\""));
    let mut session = open(&text, 1);
    let mut force = Vec::new();
    for _ in 0..50 {
        session.step();
        let tool = session.frame().tools[0];
        if tool.grips || !force.is_empty() {
            assert!(tool.grips, "{material} {kind} {radius} {stiffness}: it lets go");
            force.push(tool.force.norm());
        }
    }
    assert!(session.bodies[0].frozen.is_none(), "{material} {kind} {radius} {stiffness}");
    force
}

#[test]
fn a_coupling_of_any_stiffness_draws_out_as_a_rigid_one_does() {
    for material in ["mass-spring", "neo-hookean", "corotational"] {
        for (kind, radius) in [("pull", 2e-3), ("pull", 8e-3), ("grab", 8e-3)] {
            let mut ends = Vec::new();
            for stiffness in STIFFNESSES {
                let force = draw_out(material, kind, radius, stiffness);
                let what = format!("{material} {kind} {radius} {stiffness}");
                let end = force.last().copied().unwrap();
                assert!(force.len() > 40, "{what}: held in {} steps", force.len());
                // A region of a gram on an undamped spring vibrates within a step from 10 kN/m on, so a grab's force may jump.
                let jump = force.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
                assert!(kind == "grab" || jump < 0.5 * end, "{what}: the force jumps by {jump} N of {end} N");
                ends.push(end);
            }
            let [low, high] = [f64::min, f64::max].map(|fold| ends[1..].iter().copied().reduce(fold).unwrap());
            assert!(high < 1.25 * low, "{material} {kind} {radius}: {ends:?}");
        }
    }
}
