//! Several cuts of a body in one step: nodes that they make go on with the state of those they are copies of.

use pliant_engine::session::Session;
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

/// A block of 40 mm without damping, heavier on one side, cut by so many knives at once, in planes that cross each other.
fn cut_block(random: &mut Random, knives: usize, level: u32, material: &str) -> Session {
    let knives: Vec<String> = (0..knives)
        .map(|number| {
            let down = (Vec3::ith(number, 1.0) + 0.3 * random.vector()).normalize();
            let along = down.cross(&random.direction()).normalize();
            let middle = 0.004 * random.vector() - 0.06 * along;
            knife(&format!("knife {number}"), along, [middle - 0.035 * down, middle + 0.035 * down])
        })
        .collect();
    open(
        &format!(
            "format = 1\n[time]\nduration = 1\n[[body]]\nshape = {{ kind = \"box\", cells = 8, size = [0.04, 0.04, 0.04] }}\n\
             material = {{ plugin = \"{material}\", params = {{ damping-time = 0 }} }}\n\
             grid = {{ level = {level}, region = \"whole\" }}\n\
             [[body.field]]\nparam = \"density\"\nbox = [[-1, -1, -1], [0.003, 1, 1]]\nfactor = 3\n{}",
            knives.concat()
        ),
        1,
    )
}

/// A body that drifts is under no force, however it is cut: it drifts on, with all nodes at the same displacement and velocity.
#[test]
fn a_drifting_body_drifts_on_however_many_cuts_a_step_has() {
    let random = &mut Random(48);
    for case in 0..6 {
        let mut session = cut_block(random, 2 + case % 2, if case < 5 { 3 } else { 4 }, "mass-spring");
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

/// Forces inside of a body add up to nothing, and a blade without toughness pulls at nothing: cuts change neither mass nor momentum, also where they leave slivers that become part
/// of what is beside them.
#[test]
fn cuts_of_a_swinging_body_keep_its_mass_and_momentum() {
    let random = &mut Random(50);
    for case in 0..12 {
        let material = ["mass-spring", "corotational", "neo-hookean"][case % 3];
        let mut session = cut_block(random, 2 + case / 3 % 2, 3, material);
        session.step();
        let nodes = &mut session.bodies[0].system.nodes;
        nodes.v.iter_mut().for_each(|v| *v = 0.2 * random.vector());
        session.changed(0);
        let all = |session: &Session| {
            let nodes = &session.bodies[0].system.nodes;
            let each = nodes.mass.iter().zip(&nodes.v);
            each.fold((Vec3::zeros(), 0.0), |(sum, size), (m, v)| (sum + *m * v, size + m * v.norm()))
        };
        let mass = |session: &Session| session.bodies[0].system.nodes.mass.iter().sum::<f64>();
        let ((before, size), whole) = (all(&session), mass(&session));
        for step in 1..=24 {
            session.step();
            let (now, _) = all(&session);
            let off = (now - before).norm() / size;
            let lost = mass(&session) / whole - 1.0;
            assert!(lost.abs() < 1e-12, "case {case}, {material}, step {step}: mass off by {lost} of it");
            assert!(off < 1e-11, "case {case}, {material}, step {step}: momentum off by {off} of the sum of all sizes");
        }
        assert!(session.cuts().advances > 10, "case {case}: {} cuts", session.cuts().advances);
    }
}
