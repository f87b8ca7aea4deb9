//! Several cuts of a body in one step: nodes that they make go on with the state of those they are copies of.

use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::open;

/// A table of a hand that goes from a place to another (m) in 20 ms, and of its knife with an edge in the direction `along`.
fn knife(name: &str, along: Vec3, [from, to]: [Vec3; 2]) -> String {
    let row = |p: Vec3| format!("{}, {}, {}", p.x, p.y, p.z);
    format!(
        "[[device]]\nname = \"{name}\"\nparams = {{ path = [[0, {}], [0.02, {}]] }}\n\
         [[tool]]\nname = \"{name}\"\ndevice = \"{name}\"\nradius = 0.001\nspeed = 10\n\
         blade = {{ length = 0.12, direction = [{}], toughness = 0 }}\n[[edit]]\nkind = \"cut\"\ntool = \"{name}\"\n",
        row(from),
        row(to),
        row(along)
    )
}

/// A body that drifts is under no force, however it is cut: it drifts on, with all nodes at the same displacement and velocity.
#[test]
fn a_drifting_body_drifts_on_however_many_cuts_a_step_has() {
    let random = &mut Random(48);
    for case in 0..6 {
        // Two knives or three, in planes that cross each other.
        let knives: Vec<String> = (0..2 + case % 2)
            .map(|number| {
                let down = (Vec3::ith(number, 1.0) + 0.3 * random.vector()).normalize();
                let along = down.cross(&random.direction()).normalize();
                let middle = 0.004 * random.vector() - 0.06 * along;
                knife(&format!("knife {number}"), along, [middle - 0.035 * down, middle + 0.035 * down])
            })
            .collect();
        let level = if case < 5 { 3 } else { 4 };
        let mut session = open(
            &format!(
                "format = 1\n[time]\nduration = 1\n[[body]]\nshape = {{ kind = \"box\", cells = 8, size = [0.04, 0.04, 0.04] }}\n\
                 material = {{ plugin = \"mass-spring\", params = {{ damping-time = 0 }} }}\n\
                 grid = {{ level = {level}, region = \"whole\" }}\n{}",
                knives.concat()
            ),
            1,
        );
        session.step();
        let (displacement, velocity) = (0.002 * random.vector(), 0.5 * random.vector());
        let nodes = &mut session.bodies[0].system.nodes;
        nodes.x.iter_mut().for_each(|x| *x += displacement);
        nodes.v.fill(velocity);
        session.changed(0);
        let (count, mut cuts) = (session.bodies[0].system.nodes.len(), Vec::new());
        for step in 1..=24 {
            session.step();
            cuts.push(session.cuts().advances);
            let nodes = &session.bodies[0].system.nodes;
            let off = |all: &[Vec3], right: Vec3| all.iter().map(|v| (v - right).norm()).fold(0.0, f64::max);
            let moved: Vec<Vec3> = nodes.x.iter().zip(&nodes.rest).map(|(x, rest)| x - rest).collect();
            let displaced = off(&moved, displacement + f64::from(step) * session.dt() * velocity);
            let faster = off(&nodes.v, velocity);
            assert!(displaced < 1e-12 && faster < 1e-9, "case {case}, step {step}: {displaced} m, {faster} m/s");
        }
        assert!(session.bodies[0].system.nodes.len() > count, "case {case}: nodes were parted");
        assert!(cuts.windows(2).any(|two| two[1] > two[0] + 1), "case {case}: no step has two cuts: {cuts:?}");
    }
}
