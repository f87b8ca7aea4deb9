//! Two hands that hold one body: what is between them stretches, contracts and bends as the material says, each hand feels the opposite of the
//! other, and one that lets go does not push the other.

use pliant_engine::session::{EventKind, HistoryCounts, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, scan};
use pliant_tests::{Bench, open, open_file};

/// Relative error allowed at one width and more from a load. Saint-Venant's end effects in a bar decay as exp(-4.2 z / width) (Horgan and Knowles 1983), so
/// 1.5 % is left there, and the strains of these tests change moduli by less than 0.5 %.
const SAINT_VENANT: f64 = 0.02;

/// A hand that grabs where it is, and moves and turns.
struct Hand {
    at: Vec3,
    way: Vec3,
    /// Rotation vector, degrees.
    turn: Vec3,
    /// Radius of its grab, m.
    radius: f64,
    /// Stiffness of its tool, N/m.
    stiffness: f64,
    /// More keys of its edit.
    keys: &'static str,
}

impl Hand {
    fn text(&self, name: &str) -> String {
        let Self { at, way, turn, radius, stiffness, keys } = self;
        let to = at + way;
        format!(
            "[[device]]\nname = \"{name}\"\n[device.params]\npeak-force = \"10 kN\"\npeak-torque = 1000\n\
             path = [[0, {}, {}, {}], [0.05, {}, {}, {}], [0.25, {}, {}, {}]]\n\
             rotation = [[0, 0, 0, 0], [0.05, 0, 0, 0], [0.25, {}, {}, {}]]\n\
             [[tool]]\nname = \"{name}\"\ndevice = \"{name}\"\nradius = \"2 mm\"\nstiffness = {stiffness}\nslew = 1e9\nspeed = 100\n\
             [[edit]]\nkind = \"grab\"\ntool = \"{name}\"\nradius = {radius}\n{keys}\n",
            at.x, at.y, at.z, at.x, at.y, at.z, to.x, to.y, to.z, turn.x, turn.y, turn.z
        )
    }
}

/// A scene of a body with two hands, which damping brings to rest.
fn scene(body: &str, hands: &[Hand]) -> String {
    let names = ["left", "right"];
    let hands: String = hands.iter().zip(names).map(|(hand, name)| hand.text(name)).collect();
    format!(
        "format = 1\n[time]\nduration = 9\ndt = 0.005\nintegrator = \"backward-euler\"\npatience = \"1000 s\"\n[solver]\ntolerance = 1e-9\n\
         [[body]]\n{body}\n{hands}"
    )
}

fn rest(session: &mut Session, end: f64) {
    while session.time() < end - 1e-9 {
        session.step();
    }
    assert_eq!(session.events.count(EventKind::Quarantine), 0, "{:?}", session.events.described());
}

/// A bar along x that fills its cells.
struct Bar {
    /// Cells along it, and across.
    along: u32,
    across: [u32; 2],
    edge: f64,
    /// Name, Young's modulus (Pa) and Poisson's ratio of its material.
    material: &'static str,
    young: f64,
    poisson: f64,
    region: &'static str,
}

impl Bar {
    fn random(random: &mut Random, material: &'static str, region: &'static str) -> Self {
        // Even numbers, for the grid stands on the middle of the bar.
        let across = [random.pick(&[2, 4]), random.pick(&[2, 4])];
        let edge = 0.004 + 0.006 * random.unit();
        let young = 2e4 * 10f64.powf(random.unit());
        // Central forces make the mass-spring lattice one of Cauchy's materials, with 1/4.
        let poisson = if material == "mass-spring" { 0.25 } else { 0.45 * random.unit() };
        Self { along: 16, across, edge, material, young, poisson, region }
    }

    fn size(&self) -> Vec3 {
        self.edge * Vec3::new(f64::from(self.along), f64::from(self.across[0]), f64::from(self.across[1]))
    }

    fn text(&self) -> String {
        let Self { material, young, poisson, region, .. } = self;
        let size = self.size();
        let poisson = if *material == "mass-spring" { String::new() } else { format!("poisson = {poisson}, ") };
        let level = self.along.ilog2() + 1;
        // The radius of a local region takes in the whole bar.
        format!(
            "shape = {{ kind = \"box\", cells = 24, size = [{}, {}, {}] }}\n\
             material = {{ plugin = \"{material}\", params = {{ young = {young}, {poisson}damping-time = 0.02 }} }}\n\
             grid = {{ level = {level}, region = \"{region}\", {}smooth = false }}\n",
            size.x,
            size.y,
            size.z,
            if *region == "local" { format!("radius = {}, ", 0.6 * size.x) } else { String::new() },
        )
    }

    /// Both hands at its ends, which move apart by `way` (m) each and turn about y by `turn` (degrees) against each other.
    fn held(&self, way: f64, turn: f64) -> [Hand; 2] {
        let stiffness = 4.0 * self.young * self.size().y * self.size().z / self.size().x;
        [-1.0, 1.0].map(|side| Hand {
            at: Vec3::new(side * (0.5 * self.size().x + 0.001), 0.0, 0.0),
            way: Vec3::new(side * way, 0.0, 0.0),
            turn: Vec3::new(0.0, side * turn, 0.0),
            radius: 2.0 * self.edge,
            stiffness,
            keys: "",
        })
    }

    /// Half of the length in which no load is nearer than the larger width, m.
    fn free_half(&self) -> f64 {
        let widest = self.across[0].max(self.across[1]);
        self.edge * f64::from(self.along / 2 - 2 - widest)
    }

    fn describe(&self) -> String {
        let Self { across, material, poisson, region, .. } = self;
        format!("{material}, nu {poisson:.3}, {across:?} cells across, {region}")
    }
}

/// Slope of `values` over `at` by least squares.
fn slope(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (x, y) = pairs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = pairs.iter().fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x).powi(2)));
    xy / xx
}

fn forces(session: &Session) -> [Vec3; 2] {
    [0, 1].map(|tool| session.frame().tools[tool].force)
}

const SOLIDS: [(&str, &str); 5] = [
    ("mass-spring", "whole"),
    ("neo-hookean", "local"),
    ("corotational", "whole"),
    ("mass-spring", "local"),
    ("corotational", "local"),
];

#[test]
fn a_bar_that_two_hands_stretch_is_longer_and_thinner_as_its_material_says() {
    let random = &mut Random(61);
    for (material, region) in SOLIDS {
        let bar = Bar::random(random, material, region);
        let mut session = open(&scene(&bar.text(), &bar.held(0.002 * bar.size().x, 0.0)), 1);
        rest(&mut session, 2.5);
        let nodes = &session.bodies[0].system.nodes;
        let free: Vec<usize> = (0..nodes.len()).filter(|i| nodes.rest[*i].x.abs() < bar.free_half() + 1e-6).collect();
        let strain = |axis: usize| {
            slope(
                &free
                    .iter()
                    .map(|i| (nodes.rest[*i][axis], nodes.x[*i][axis] - nodes.rest[*i][axis]))
                    .collect::<Vec<_>>(),
            )
        };
        let axial = strain(0);
        let thinner = [1, 2].map(|axis| -strain(axis) / axial);
        let [left, right] = forces(&session);
        let stress = 0.5 * (left - right).x / (bar.size().y * bar.size().z);
        let modulus = stress / axial / bar.young;
        // Strain of each layer of cells.
        let layer = |x: f64| {
            let at: Vec<usize> =
                free.iter().copied().filter(|i| (nodes.rest[*i].x - x).abs() < 0.1 * bar.edge).collect();
            at.iter().map(|i| nodes.x[*i].x - nodes.rest[*i].x).sum::<f64>() / at.len() as f64
        };
        let layers = (bar.free_half() / bar.edge).round() as i32;
        let strains = (-layers..layers)
            .map(|i| (layer(f64::from(i + 1) * bar.edge) - layer(f64::from(i) * bar.edge)) / bar.edge / axial - 1.0);
        let uneven = strains.fold(0.0, |most: f64, e| most.max(e.abs()));
        let what = bar.describe();
        println!(
            "{what}: strain {axial:.2e}, E {modulus:.4} of the material's, contraction {thinner:.4?}, layers differ by {uneven:.1e}"
        );
        assert!((1e-3..5e-3).contains(&axial), "{what}: {axial}");
        assert!((modulus - 1.0).abs() < SAINT_VENANT, "{what}: E is {modulus} of the material's");
        for nu in thinner {
            assert!((nu - bar.poisson).abs() < SAINT_VENANT, "{what}: contraction {nu}");
        }
        assert!(uneven < SAINT_VENANT, "{what}: the strain of a layer differs by {uneven}");
        assert!((left + right).norm() < 1e-3 * left.norm(), "{what}: {left:?} N and {right:?} N");
    }
}

#[test]
fn hands_that_turn_against_each_other_bend_a_bar_to_an_arc() {
    let random = &mut Random(62);
    for (material, region) in SOLIDS {
        let bar = Bar::random(random, material, region);
        let mut session = open(&scene(&bar.text(), &bar.held(0.0, 1.0)), 1);
        rest(&mut session, 4.0);
        let nodes = &session.bodies[0].system.nodes;
        let section = |x: f64| {
            let at: Vec<usize> = (0..nodes.len()).filter(|i| (nodes.rest[*i].x - x).abs() < 0.1 * bar.edge).collect();
            slope(&at.iter().map(|i| (nodes.rest[*i].z, nodes.x[*i].x - nodes.rest[*i].x)).collect::<Vec<_>>())
        };
        let layers = (bar.free_half() / bar.edge).round() as i32;
        let turn = |i: i32| section(f64::from(i) * bar.edge);
        let curvature = (turn(layers) - turn(-layers)) / (2.0 * f64::from(layers) * bar.edge);
        // Every other layer, because the five tetrahedra of cells alternate.
        let uneven = (-layers..=layers - 2)
            .map(|i| ((turn(i + 2) - turn(i)) / (2.0 * bar.edge) / curvature - 1.0).abs())
            .fold(0.0, f64::max);
        let tools = &session.frame().tools;
        let torque = [tools[0].torque.y, tools[1].torque.y];
        let (width, height) = (bar.size().y, bar.size().z);
        let moment = bar.young * width * height.powi(3) / 12.0 * curvature;
        let ratio = (torque[0] - torque[1]).abs() / 2.0 / moment.abs();
        // Mirror images in x.
        let reach = nodes.x.iter().zip(&nodes.rest).map(|(x, r)| (x - r).norm()).fold(0.0, f64::max);
        let image = |i: usize| {
            let r = nodes.rest[i];
            (0..nodes.len()).find(|j| (nodes.rest[*j] - Vec3::new(-r.x, r.y, r.z)).norm() < 0.1 * bar.edge)
        };
        let skew = (0..nodes.len())
            .filter_map(|i| {
                let (a, b) = (nodes.x[i] - nodes.rest[i], nodes.x[image(i)?] - nodes.rest[image(i)?]);
                Some((a - Vec3::new(-b.x, b.y, b.z)).norm() / reach)
            })
            .fold(0.0, f64::max);
        let what = bar.describe();
        println!(
            "{what}: curvature {curvature:.3} /m, layers differ by {uneven:.1e}, torque {ratio:.3} of E I kappa, skew {skew:.1e}"
        );
        assert!((torque[0] + torque[1]).abs() < 1e-3 * torque[0].abs(), "{what}: {torque:?} N m");
        assert!(uneven < SAINT_VENANT, "{what}: the curvature of layers differs by {uneven}");
        // Linear tetrahedra with a few of them across are too stiff, by a part of the order of the square of a cell over the height; never too soft.
        let order = f64::from(bar.across[1]).powi(-2);
        assert!((1.0 - SAINT_VENANT..1.0 + 4.0 * order).contains(&ratio), "{what}: torque {ratio} of E I kappa");
        assert!(skew < 1e-6, "{what}: {skew}");
    }
}

/// Two places of a surface that are farther apart than `least` (m).
fn two_places(points: &[Vec3], least: f64, random: &mut Random) -> [Vec3; 2] {
    loop {
        let [a, b] = [0, 1].map(|_| points[random.below(points.len() as u64) as usize]);
        if (a - b).norm() > least {
            return [a, b];
        }
    }
}

/// A hand that stays in the origin.
fn still() -> Hand {
    Hand { at: Vec3::zeros(), way: Vec3::zeros(), turn: Vec3::zeros(), radius: 0.02, stiffness: 500.0, keys: "" }
}

/// Two hands of a radius (m) that go and turn somewhere.
fn moving(places: [Vec3; 2], radius: f64, way: f64, turn: f64, stiffness: f64, random: &mut Random) -> [Hand; 2] {
    places.map(|at| Hand {
        at,
        way: way * random.direction(),
        turn: turn * random.direction(),
        radius,
        stiffness,
        keys: "",
    })
}

/// Sum of the forces on both hands, and of their moments about the origin, over their magnitudes, which it gives too (N, N m).
fn balance(session: &Session) -> ([f64; 2], [f64; 2]) {
    let tools = &session.frame().tools;
    let (mut force, mut moment, mut sizes) = (Vec3::zeros(), Vec3::zeros(), [0.0; 2]);
    for tool in tools {
        force += tool.force;
        moment += tool.torque + tool.hand.cross(&tool.force);
        sizes[0] += tool.force.norm();
        sizes[1] += tool.torque.norm() + tool.hand.cross(&tool.force).norm();
    }
    ([force.norm() / sizes[0], moment.norm() / sizes[1]], sizes)
}

/// Largest change of the displacement along an edge over its length, and the number of triangles whose normals turned by more than a right angle
/// against the mean turn of the hands.
fn steepest(session: &mut Session) -> (f64, usize) {
    session.update_surface();
    let body = &session.bodies[0];
    let (rest, x) = (&body.skin.settled, &body.skin.x);
    let (mut most, mut flipped) = (0.0_f64, 0);
    for t in &body.model.surface.triangles {
        let t = t.map(|v| v as usize);
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let length = (rest[a] - rest[b]).norm();
            most = most.max(((x[a] - rest[a]) - (x[b] - rest[b])).norm() / length);
        }
        let normal = |p: &[Vec3]| (p[t[1]] - p[t[0]]).cross(&(p[t[2]] - p[t[0]]));
        flipped += usize::from(normal(rest).dot(&normal(x)) <= 0.0);
    }
    (most, flipped)
}

#[test]
fn what_two_hands_do_to_a_free_body_adds_up_to_nothing_and_is_smooth() {
    let random = &mut Random(63);
    let materials = [
        "\"mass-spring\", params = { young = 2e4, density = 50, damping-time = 0.01 }",
        "\"neo-hookean\", params = { young = 2e4, poisson = 0.45, density = 50, damping-time = 0.01 }",
        "\"corotational\", params = { young = 2e4, poisson = 0.3, density = 50, damping-time = 0.01 }",
    ];
    for (i, material) in (0..6).zip(materials.iter().cycle()) {
        let bench = Bench::new();
        let model = scan(i % 3, 1500, 0, random.next_u64());
        bench.write("model.obj", &model.text);
        let body = format!(
            "mesh = \"model.obj\"\nsize = 0.1\nmaterial = {{ plugin = {material} }}\ngrid = {{ level = 5, region = \"whole\" }}"
        );
        // A hand that is far away takes hold of nothing.
        let far = [Hand { at: Vec3::repeat(1.0), ..still() }];
        let points = open_file(&bench.write("bare.toml", scene(&body, &far)), 1, None).bodies[0].skin.settled.to_vec();
        // Every other pair of regions overlaps.
        let (radius, least) = if i % 2 == 0 { (0.02, 0.06) } else { (0.04, 0.02) };
        let places = two_places(&points, least, random);
        let (way, turn) = (0.004, 15.0);
        let hands = moving(places, radius, way, turn, 500.0, random);
        let mut session = open_file(&bench.write("scene.toml", scene(&body, &hands)), 1, None);
        rest(&mut session, 2.5);
        let (sums, sizes) = balance(&session);
        let (most, flipped) = steepest(&mut session);
        let what = format!(
            "{}, {material}, {:.0} mm apart, radius {:.0} mm",
            model.name,
            1e3 * (places[0] - places[1]).norm(),
            1e3 * radius
        );
        println!("{what}: {sizes:.4?} N and N m, sums {sums:.6?}, steepest {most:.2}");
        assert!(sizes[0] > 0.05, "{what}: {sizes:?}");
        assert!(sums.iter().all(|s| *s < 1e-3), "{what}: sums {sums:?}");
        // A load spread over a radius strains by about u / R around it (de Goes and James 2017); two hands, each with its way and its turn.
        let order = 2.0 * (way / radius + turn.to_radians());
        assert!(most < order, "{what}: steepest {most}, of the order of {order}");
        assert_eq!(flipped, 0, "{what}");
    }
}

#[test]
fn a_local_region_around_two_hands_answers_as_the_whole_body_does() {
    let random = &mut Random(64);
    for (material, way, turn) in [("mass-spring", 0.01, 0.0), ("corotational", 0.0, 5.0), ("neo-hookean", -0.005, 3.0)]
    {
        let mut bar = Bar::random(random, material, "whole");
        let found = ["whole", "local"].map(|region| {
            bar.region = region;
            let mut session = open(&scene(&bar.text(), &bar.held(way * bar.size().x, turn)), 1);
            rest(&mut session, 2.5);
            let nodes = &session.bodies[0].system.nodes;
            let moved: Vec<Vec3> = nodes.x.iter().zip(&nodes.rest).map(|(x, r)| x - r).collect();
            (moved, forces(&session))
        });
        let size = found[0].0.iter().map(Vec3::norm).fold(0.0, f64::max);
        let apart = found[0].0.iter().zip(&found[1].0).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{}: {:.2} mm, apart by {apart:.1e} m", bar.describe(), 1e3 * size);
        assert_eq!(found[0].0.len(), found[1].0.len(), "all cells are simulated");
        assert!(apart < 1e-6 * size, "{}: {apart} m of {size} m", bar.describe());
    }
}

/// Regions of two hands that do not meet leave what is between them at rest, and that is told once; regions that meet, and whole bodies, are not told of.
#[test]
fn hands_whose_regions_do_not_meet_are_told() {
    let random = &mut Random(66);
    for (material, share, told) in [
        ("mass-spring", 0.2, true),
        ("corotational", 0.15, true),
        ("neo-hookean", 0.25, true),
        ("neo-hookean", 0.45, false),
        ("mass-spring", 0.6, false),
    ] {
        let bar = Bar::random(random, material, "local");
        let [from, to] = [0.6, share].map(|share| format!("radius = {}", share * bar.size().x));
        let text = scene(&bar.text().replace(&from, &to), &bar.held(0.005 * bar.size().x, 0.0));
        let mut session = open(&text, 1);
        rest(&mut session, 0.5);
        let what = format!("{}, radius {share}: {:?}", bar.describe(), session.events.described());
        assert_eq!(session.events.count(EventKind::GripsApart), u64::from(told), "{what}");
        let nodes = &session.bodies[0].system.nodes;
        assert!(nodes.x.iter().zip(&nodes.rest).any(|(x, rest)| (x - rest).norm() > 1e-4 * bar.size().x), "{what}");
    }
}

#[test]
fn a_sheet_that_two_hands_stretch_carries_as_its_material_says() {
    let random = &mut Random(65);
    for pattern in ["alternating", "equilateral", "irregular"] {
        let (young, poisson) = (50.0 * 10f64.powf(random.unit()), 0.3 * random.unit());
        let [length, width] = [0.2, 0.03 + 0.01 * random.unit()];
        let body = format!(
            "shape = {{ kind = \"sheet\", pattern = \"{pattern}\", cells = 60, size = [{length}, {width}, 0] }}\nposition = [{}, {}, 0]\nsheet = {{}}\n\
             material = {{ plugin = \"cloth\", params = {{ density = 0.2, young-warp = {young}, young-weft = {young}, poisson = {poisson}, \
             bending-warp = 1e-5, bending-weft = 1e-5, damping-time = \"20 ms\" }} }}",
            -0.5 * length,
            -0.5 * width
        );
        let (radius, strain) = (0.6 * width, 0.004);
        let hands = [-1.0, 1.0].map(|side| Hand {
            at: Vec3::new(side * (0.5 * length - 0.005), 0.0, 0.0005),
            way: Vec3::new(side * 0.5 * strain * length, 0.0, 0.0),
            turn: Vec3::zeros(),
            radius,
            stiffness: 20.0 * young * width / length,
            keys: "",
        });
        let mut session = open(&scene(&body, &hands), 1);
        rest(&mut session, 3.0);
        let nodes = &session.bodies[0].system.nodes;
        let half = 0.5 * length - 0.005 - radius - width;
        let free: Vec<usize> = (0..nodes.len()).filter(|i| nodes.rest[*i].x.abs() < half).collect();
        let strain = |axis: usize| {
            slope(
                &free
                    .iter()
                    .map(|i| (nodes.rest[*i][axis], nodes.x[*i][axis] - nodes.rest[*i][axis]))
                    .collect::<Vec<_>>(),
            )
        };
        let (axial, thinner) = (strain(0), -strain(1) / strain(0));
        let [left, right] = forces(&session);
        let modulus = 0.5 * (left - right).x / width / axial / young;
        println!(
            "{pattern}: strain {axial:.2e}, E {modulus:.4} of the material's, contraction {thinner:.4}, nu {poisson:.4}, {left:.4?} N"
        );
        assert!((1e-3..5e-3).contains(&axial), "{pattern}: {axial}");
        assert!((modulus - 1.0).abs() < SAINT_VENANT, "{pattern}: E is {modulus} of the material's");
        assert!((thinner - poisson).abs() < SAINT_VENANT, "{pattern}: contraction {thinner}, nu {poisson}");
        assert!((left + right).norm() < 1e-2 * left.norm(), "{pattern}: {left:?} N and {right:?} N");
    }
}

/// A bar that two hands stretch and bend; each keeps the shape, the left one at 1 s and the right one at `end`.
fn kept_by_both(bar: &Bar, end: &'static str) -> Session {
    let mut hands = bar.held(0.05 * bar.size().x, 10.0);
    hands[0].keys = "release = \"keep\"\nend = 1";
    hands[1].keys = end;
    let mut session = open(&scene(&bar.text(), &hands), 1);
    session.keep_history();
    session
}

#[test]
fn a_hand_that_keeps_the_shape_does_not_push_the_other() {
    let random = &mut Random(66);
    for (material, region) in SOLIDS {
        let bar = Bar::random(random, material, region);
        let mut session = kept_by_both(&bar, "release = \"keep\"");
        rest(&mut session, 1.0);
        let before = session.frame().tools[1];
        // The force on the right hand is what is left of it: the shape that was kept is without stress, so the body goes on to the hand.
        let (mut force, mut torque) = (0.0_f64, 0.0_f64);
        while session.time() < 1.5 {
            session.step();
            let now = session.frame().tools[1];
            (force, torque) = (force.max(now.force.norm()), torque.max(now.torque.norm()));
        }
        let what = bar.describe();
        let [force, torque] = [force / before.force.norm(), torque / before.torque.norm()];
        println!("{what}: largest force {force:.3} of that before, torque {torque:.3}");
        assert!(before.force.norm() > 1e-3 && before.torque.norm() > 1e-6, "{what}");
        assert!(force < 1.0 && torque < 1.0, "{what}: force {force} and torque {torque} of what they were");
    }
}

/// The shape at rest of the surface, as bits.
fn shape(session: &Session) -> Vec<u64> {
    let body = &session.bodies[0];
    body.skin.settled.iter().chain(&body.system.nodes.rest).flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn strokes_of_two_hands_are_taken_back_one_by_one() {
    let bar = Bar::random(&mut Random(67), "corotational", "whole");
    let mut session = kept_by_both(&bar, "release = \"keep\"\nend = 1.5");
    let first = shape(&session);
    rest(&mut session, 1.25);
    let second = shape(&session);
    assert_eq!(session.history(), HistoryCounts { done: 2, undone: 0 }, "the left one, and the right one that goes on");
    rest(&mut session, 1.75);
    let third = shape(&session);
    assert!(first != second && second != third, "both left something");
    for _ in 0..2 {
        assert!(session.undo());
        assert!(shape(&session) == second, "the right stroke is taken back, and the left one stays");
        let soon = session.time() + 0.05;
        rest(&mut session, soon);
        assert!(session.undo());
        assert!(shape(&session) == first, "and the left one");
        assert!(!session.undo());
        assert!(session.redo());
        assert!(shape(&session) == second);
        assert!(session.redo());
        assert!(shape(&session) == third);
    }
}

#[test]
fn strokes_that_end_together_are_taken_back_together() {
    let bar = Bar::random(&mut Random(68), "mass-spring", "whole");
    let mut session = kept_by_both(&bar, "release = \"keep\"\nend = 1");
    let first = shape(&session);
    rest(&mut session, 1.25);
    let second = shape(&session);
    assert!(first != second);
    assert_eq!(session.history(), HistoryCounts { done: 1, undone: 0 }, "the first to end has kept what both did");
    assert!(session.undo());
    assert!(shape(&session) == first);
    assert!(session.redo());
    assert!(shape(&session) == second);
}
