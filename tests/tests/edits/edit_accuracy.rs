//! Edits against closed forms, over levels of the grid: two hands that bend a bar, the volume that a grab keeps, a regularised point load, a twisted bar.

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_solver::Pool;
use pliant_tests::{Bench, NOW, open, open_file};
use std::f64::consts::PI;

/// A scene of one solid that hands grab, which damping brings to rest.
fn scene(body: &str, hands: &[String]) -> String {
    format!(
        "format = 1\n[time]\nduration = 1\ndt = 0.005\nintegrator = \"backward-euler\"\npatience = \"1000 s\"\n[solver]\ntolerance = 1e-9\n[[body]]\n{body}\n{}",
        hands.concat()
    )
}

/// A hand with a path and rotations (rotation vectors in degrees) that grabs with a radius (m) and a stiffness (N/m).
fn hand(name: &str, path: &str, rotation: &str, radius: f64, stiffness: f64) -> String {
    format!(
        "[[device]]\nname = \"{name}\"\nparams = {{ peak-force = \"1 kN\", peak-torque = 1000, path = {path}, rotation = {rotation} }}\n\
         [[tool]]\nname = \"{name}\"\ndevice = \"{name}\"\nradius = \"2 mm\"\nstiffness = {stiffness}\nslew = 1e9\nspeed = 100\n\
         [[edit]]\nkind = \"grab\"\ntool = \"{name}\"\nradius = {radius}\n"
    )
}

fn material(young: f64, poisson: f64) -> String {
    format!(
        "material = {{ plugin = \"corotational\", params = {{ young = {young}, poisson = {poisson}, damping-time = 0.005 }} }}\n"
    )
}

/// Steps until `end` (s).
fn rest(session: &mut Session, end: f64) {
    while session.time() < end {
        session.step();
    }
    assert_eq!(session.events.count(EventKind::Quarantine), 0, "{:?}", session.events.described());
}

/// Errors fall with the square of the cell: each is less than this part of the one before, which is 0.25 where they are small.
fn falls(errors: &[f64], part: f64, what: &str) {
    for pair in errors.windows(2) {
        assert!(
            pair[1] < part * pair[0],
            "{what}: errors {errors:?}; each is to be less than {part} of the one before"
        );
    }
}

/// Torque of two hands that grab the ends of a bar and turn them against each other, over the moment that bends the bar as much.
fn bending(level: u32, [length, height, width]: [f64; 3], poisson: f64, angle: f64) -> f64 {
    let young = 50e3;
    let body = format!(
        "shape = {{ kind = \"box\", cells = 24, size = [{length}, {width}, {height}] }}\n{}grid = {{ level = {level}, region = \"whole\", smooth = false }}\n",
        material(young, poisson)
    );
    let grab = |name: &str, side: f64| {
        let at = side * (0.5 * length + 0.001);
        let path = format!("[[0, {at}, 0, 0], [0.1, {at}, 0, 0]]");
        let rotation = format!("[[0, 0, 0, 0], [0.1, 0, 0, 0], [0.4, 0, {}, 0]]", side * angle);
        hand(name, &path, &rotation, 0.8 * height, 2000.0)
    };
    let mut session = open(&scene(&body, &[grab("left", -1.0), grab("right", 1.0)]), 1);
    // The slowest motion of the bar dies within a second after the hands have turned.
    rest(&mut session, 2.0);
    let torque = [0, 1].map(|tool| session.frame().tools[tool].torque.y);
    assert!((torque[0] + torque[1]).abs() < 0.01 * torque[0].abs(), "opposite torques: {torque:?}");
    // Turn of sections a height and more from what the hands grab (Saint-Venant), by the best rotation of their nodes about y.
    let nodes = &session.bodies[0].system.nodes;
    let edge = session.bodies[0].discretization.edge();
    let turn = |at: f64| {
        let section: Vec<usize> = (0..nodes.len()).filter(|i| (nodes.rest[*i].x - at).abs() < 0.25 * edge).collect();
        let mean = |x: &[Vec3]| section.iter().map(|i| x[*i]).sum::<Vec3>() / section.len() as f64;
        let (from, to) = (mean(&nodes.rest), mean(&nodes.x));
        let (mut sine, mut cosine) = (0.0, 0.0);
        for i in section {
            let (a, b) = (nodes.rest[i] - from, nodes.x[i] - to);
            sine += a.z * b.x - a.x * b.z;
            cosine += a.z * b.z + a.x * b.x;
        }
        sine.atan2(cosine)
    };
    let far = (0.2 * length / edge).round() * edge;
    let curvature = (turn(far) - turn(-far)) / (2.0 * far);
    let moment = young * width * height.powi(3) / 12.0 * curvature;
    assert!(moment.abs() > 1e-5, "nothing bends: {moment} N m");
    (torque[0] - torque[1]).abs() / 2.0 / moment.abs()
}

#[test]
fn two_hands_bend_a_bar_as_euler_and_bernoulli_say() {
    for poisson in [0.0, 0.3] {
        let size = [0.16, 0.02, 0.02];
        // By more than half a degree, and what keeps the distance of the hands would stretch the bar, of second order in the angle.
        let errors: Vec<f64> = [5, 6].map(|level| bending(level, size, poisson, 0.5) - 1.0).into();
        println!("bending, nu {poisson}: torque over E I kappa - 1: {errors:?} at 2 and 4 cells across");
        assert!(errors.iter().all(|e| *e > -0.02), "linear tetrahedra are too stiff, never too soft: {errors:?}");
        falls(&errors, 0.3, "bending");
    }
}

/// Volume inside of the surface of a body, m^3.
fn volume(session: &mut Session) -> f64 {
    session.update_surface();
    let body = &session.bodies[0];
    let each = body.model.surface.triangles.iter().map(|t| t.map(|v| body.skin.x[v as usize]));
    each.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}

/// Change of the volume of a block that a hand grabs and pulls, and that of linear elasticity under the same forces, m^3. For it Betti's theorem gives (1 - 2 nu) / E times the sum of f . x over all
/// forces, those of fixings too.
fn grabbed_volume(level: u32, poisson: f64, random: &mut Random) -> (f64, f64, f64) {
    let young = 20e3;
    let body = format!(
        "shape = {{ kind = \"box\", cells = 32, size = [0.08, 0.08, 0.08] }}\n{}grid = {{ level = {level}, region = \"whole\", smooth = false }}\n\
         fixed = [{{ box = [[-1, -1, -1], [1, 1, -0.0399]] }}]\n",
        material(young, poisson)
    );
    let (x, y) = (0.015 * random.signed(), 0.015 * random.signed());
    let to = Vec3::new(x, y, 0.041) + 2e-3 * Vec3::new(0.5 * random.signed(), 0.5 * random.signed(), 1.0);
    let path = format!("[[0, {x}, {y}, 0.041], [0.1, {x}, {y}, 0.041], [0.3, {}, {}, {}]]", to.x, to.y, to.z);
    let mut session = open(&scene(&body, &[hand("hand", &path, "[[0, 0, 0, 0]]", 0.03, 500.0)]), 1);
    let before = volume(&mut session);
    rest(&mut session, 0.8);
    let change = volume(&mut session) - before;
    // What fixings give is what the body does to nodes that are not free.
    let body = &mut session.bodies[0];
    let mut elastic = vec![Vec3::zeros(); body.system.nodes.len()];
    body.system.forces(&Pool::new(1), None, NOW, &mut elastic).expect("finite");
    let nodes = &session.bodies[0].system.nodes;
    let held = |i: usize| if nodes.constraint[i].is_free() { Vec3::zeros() } else { -elastic[i] };
    let mut forces: Vec<Vec3> = (0..nodes.len()).map(held).collect();
    session.tools[0].tool.springs(0).add_to(&mut forces, &nodes.x, None);
    // Fixings and the hand hold each other.
    let total: Vec3 = forces.iter().sum();
    let size = session.frame().tools[0].force.norm();
    assert!(total.norm() < 1e-3 * size, "{total:?} N of {size} N");
    let virial: f64 = forces.iter().zip(&nodes.rest).map(|(f, x)| f.dot(x)).sum();
    let moved = nodes.x.iter().zip(&nodes.rest).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    (change, (1.0 - 2.0 * poisson) / young * virial, moved)
}

#[test]
fn a_grab_keeps_the_volume_that_the_material_lets_it() {
    for level in [4, 5] {
        let mut changes = Vec::new();
        for poisson in [0.0, 0.3, 0.45, 0.49] {
            let (change, linear, moved) = grabbed_volume(level, poisson, &mut Random(70 + u64::from(level)));
            println!(
                "level {level}, nu {poisson}: {change:.3e} m^3, linear {linear:.3e} m^3, hand moves {:.2} mm",
                1e3 * moved
            );
            // Of second order is the square of the strain, about 2 mm in 30 mm, over the volume of the region.
            let second = (moved / 0.03).powi(2) * 0.03_f64.powi(3);
            assert!(
                (change - linear).abs() < 0.1 * linear.abs() + second,
                "nu {poisson}: {change} m^3, linear {linear} m^3"
            );
            changes.push(change.abs() / moved);
        }
        assert!(changes.windows(2).all(|pair| pair[1] < pair[0]), "for each metre that is moved: {changes:?} m^2");
        assert!(changes[3] < 0.1 * changes[1], "nearly incompressible: {changes:?} m^2");
    }
}

/// `<<1/r>>` of the smooth falloff with radius 1, over both ends: what a point load's 1/r becomes between two loads spread so.
fn mean_inverse_distance() -> f64 {
    let (n, mut inside, mut sum) = (4000, 0.0, 0.0);
    let h = 1.0 / f64::from(n);
    for i in 0..n {
        let r = (f64::from(i) + 0.5) * h;
        let shell = (1.0 - r) * (1.0 - r) * (1.0 + 2.0 * r) * r * r * h;
        inside += 0.5 * shell;
        sum += 2.0 * shell * inside / r;
        inside += 0.5 * shell;
    }
    sum / (inside * inside)
}

/// A cube of 2 `half` (m) with a speck of a cavity at its middle, for a hand to take hold of, as OBJ.
fn cube_with_a_speck(half: f64) -> String {
    let mut text = String::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(|b| half * f64::from(2 * b - 1));
        text += &format!("v {x} {y} {z}\n");
    }
    for (axis, sign) in (0..3).flat_map(|a| [(a, -1.0), (a, 1.0)]) {
        let mut p = [0.0; 3];
        p[axis] = 1e-4 * sign;
        text += &format!("v {} {} {}\n", p[0], p[1], p[2]);
    }
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        text += &format!("f {a} {b} {c} {d}\n");
    }
    for (x, y, z) in (0..8).map(|i| (i & 1, i >> 1 & 1, i >> 2)) {
        let [a, b, c] = [9 + x, 11 + y, 13 + z];
        text += &if (x + y + z) % 2 == 0 { format!("f {a} {b} {c}\n") } else { format!("f {a} {c} {b}\n") };
    }
    text
}

/// Displacement of a hand that grabs the middle of a large cube with edges of twice `half` (m), over its force, m/N.
fn point_compliance(level: u32, radius: f64, young: f64, poisson: f64, half: f64) -> f64 {
    let bench = Bench::new();
    bench.write("cube.obj", cube_with_a_speck(half));
    let wall = |axis: usize, low: bool| {
        let (mut from, mut to) = ([-1.0; 3], [1.0; 3]);
        if low {
            to[axis] = 1e-6 - half
        } else {
            from[axis] = half - 1e-6
        }
        format!("[[body.fixed]]\nbox = [{from:?}, {to:?}]\n")
    };
    let walls: String = (0..3).flat_map(|axis| [wall(axis, true), wall(axis, false)]).collect();
    let body = format!(
        "mesh = \"cube.obj\"\n{}grid = {{ level = {level}, region = \"whole\", smooth = false }}\n{walls}",
        material(young, poisson)
    );
    let hands = [hand("hand", "[[0, 0, 0, 0], [0.1, 0, 0, 0], [0.2, 0.001, 0, 0]]", "[[0, 0, 0, 0]]", radius, 500.0)];
    let mut session = open_file(&bench.write("scene.toml", scene(&body, &hands)), 1, None);
    rest(&mut session, 0.8);
    let felt = session.frame().tools[0];
    felt.depth / felt.force.norm()
}

#[test]
fn the_force_of_a_grab_tends_to_that_of_a_regularised_point_load() {
    let (young, poisson, half) = (20e3, 0.3, 0.08);
    let radii = [0.03, 0.05];
    // A fixed wall far away takes the same off both; what is left is Kelvin's solution between two spread loads.
    let shear = young / (2.0 * (1.0 + poisson));
    let a = 1.0 / (4.0 * PI * shear);
    let b = a / (4.0 * (1.0 - poisson));
    let exact = (a - b + b / 3.0) * mean_inverse_distance() * (1.0 / radii[0] - 1.0 / radii[1]);
    let found = [4, 5].map(|level| radii.map(|radius| point_compliance(level, radius, young, poisson, half)));
    let errors = found.map(|c| (c[0] - c[1]) / exact - 1.0);
    println!("difference of two radii over Kelvin's - 1: {errors:?} at 1.5 and 3 cells in the smaller radius");
    falls(&errors.map(f64::abs), 0.4, "point load");
    assert!(errors[1].abs() < 0.1, "{errors:?}");
}

/// Torque of a hand that twists a bar of square section, over Saint-Venant's at the rate of twist between two sections.
fn twisting(level: u32) -> f64 {
    let (young, poisson, side) = (30e3, 0.3, 0.03_f64);
    let body = format!(
        "shape = {{ kind = \"box\", cells = 24, size = [{side}, {side}, 0.12] }}\n{}grid = {{ level = {level}, region = \"whole\", smooth = false }}\n\
         fixed = [{{ box = [[-1, -1, -1], [1, 1, -0.0599]] }}]\n",
        material(young, poisson)
    );
    let path = "[[0, 0, 0, 0.061], [0.1, 0, 0, 0.061]]";
    let mut session =
        open(&scene(&body, &[hand("hand", path, "[[0, 0, 0, 0], [0.1, 0, 0, 0], [0.4, 0, 0, 4]]", 0.025, 5000.0)]), 1);
    rest(&mut session, 0.8);
    let nodes = &session.bodies[0].system.nodes;
    let turned = |height: f64| {
        let (mut moment, mut inertia) = (0.0, 0.0);
        for (x, rest) in nodes.x.iter().zip(&nodes.rest).filter(|(_, rest)| (rest.z - height).abs() < 1e-4) {
            moment += rest.x * x.y - rest.y * x.x;
            inertia += rest.x * x.x + rest.y * x.y;
        }
        moment.atan2(inertia)
    };
    let (low, high) = (-0.03, 0.015);
    let rate = (turned(high) - turned(low)) / (high - low);
    let exact = young / (2.0 * (1.0 + poisson)) * 0.14058 * side.powi(4) * rate;
    -session.frame().tools[0].torque.z / exact
}

#[test]
fn the_torque_of_a_grab_tends_to_saint_venants() {
    let errors = [5, 6].map(|level| twisting(level) - 1.0);
    println!("torque over Saint-Venant's - 1: {errors:?} at 4 and 8 cells across");
    falls(&errors, 0.4, "twist");
    assert!(errors[1].abs() < 0.1, "{errors:?}");
}
