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

fn press(material: &str, friction: [f64; 2], radius: f64, stiffness: f64) -> Press {
    let text = box_scene("", "", "[output]\nenergy = true")
        .replace("plugin = \"mass-spring\"", &format!("plugin = \"{material}\""))
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
    assert!(session.bodies[0].frozen.is_none(), "{material} {friction:?} {radius} {stiffness}");
    press
}

#[test]
fn a_coupling_of_any_stiffness_presses_as_a_rigid_one_does() {
    for material in ["mass-spring", "neo-hookean", "corotational"] {
        for (friction, radius) in [([0.0, 0.0], 0.004), ([0.5, 0.4], 0.004), ([0.5, 0.4], 0.008)] {
            let (mut forces, mut energies) = (Vec::new(), Vec::new());
            for stiffness in [1e3, 1e4, 1e5, 1e6, 1e8] {
                let what = format!("{material} {friction:?} {radius} {stiffness}");
                let found = press(material, friction, radius, stiffness);
                assert!(found.in_contact.len() > 15 && found.in_contact.iter().all(|c| *c), "{what}: contact is lost");
                let end = *found.force.last().unwrap();
                // The force rises with the depth: a step is a fifteenth of the way, which dynamics can double, and a ball that begins to slide loses a fifth of its friction.
                let jump = found.force.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
                assert!(jump < 0.5 * end, "{what}: the force jumps by {jump} N of {end} N");
                // Work is summed with the forces at the ends of steps, by when the surface has given way to them: it is too small.
                assert!(found.energy < 2.0 * found.work, "{what}: {} J of {} J", found.energy, found.work);
                energies.push(found.energy);
                forces.push(end);
            }
            // Body and layer are as stiff as 0.1 to 1 kN/m, so from 1e4 N/m on the coupling's share of the way is under a tenth.
            for values in [&forces, &energies] {
                let [low, high] = [f64::min, f64::max].map(|fold| values[1..].iter().copied().reduce(fold).unwrap());
                assert!(high < 1.25 * low, "{material} {friction:?} {radius}: {values:?}");
            }
        }
    }
}
