//! The area that a blade cuts is that of the section of the rest shape above the deepest place of its edge.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_mesh::{ObjDocument, generate};
use pliant_tests::{Bench, open, open_file, root};

/// A plane that a straight edge is drawn down in.
struct CutPlane {
    /// A point of it, m.
    origin: Vec3,
    /// Unit vector along the edge.
    along: Vec3,
    /// Unit vector of the way of the edge.
    down: Vec3,
}

impl CutPlane {
    /// Area of the section of closed triangles, m^2, up to `depth` (m) ahead of the origin, by Green's theorem.
    fn area(&self, triangles: &[[Vec3; 3]], depth: f64) -> f64 {
        let normal = self.along.cross(&self.down);
        let mut sum = 0.0;
        for triangle in triangles {
            let height = triangle.map(|p| (p - self.origin).dot(&normal));
            let crossed = (0..3).filter(|i| (height[*i] > 0.0) != (height[(i + 1) % 3] > 0.0)).map(|i| {
                let (a, b) = (i, (i + 1) % 3);
                let p = triangle[a].lerp(&triangle[b], height[a] / (height[a] - height[b])) - self.origin;
                (height[a] > 0.0, [p.dot(&self.along), depth - p.dot(&self.down)])
            });
            let mut ends: Vec<_> = crossed.collect();
            ends.sort_by_key(|(is_above, _)| *is_above);
            let [(_, [x0, y0]), (_, [x1, y1])] = ends[..] else { continue };
            // Integral of the positive part of a linear function.
            let share = match [y0 > 0.0, y1 > 0.0] {
                [true, true] => 0.5 * (y0 + y1),
                [false, false] => 0.0,
                _ => 0.5 * y0.max(y1).powi(2) / (y1 - y0).abs(),
            };
            sum += (x1 - x0) * share;
        }
        sum.abs()
    }

    /// Depth (m) that an edge comes to before the spring of its hand, which goes to `depth`, pulls with less than the resistance of a rigid body: the fracture
    /// energy (J/m^2) times the width of the section there (Griffith 1920). The spring has `stiffness`, N/m.
    fn reached(&self, triangles: &[[Vec3; 3]], depth: f64, toughness: f64, stiffness: f64) -> f64 {
        let (mut low, mut high) = (0.0, depth);
        for _ in 0..40 {
            let (at, step) = (0.5 * (low + high), 1e-5);
            let width = (self.area(triangles, at + step) - self.area(triangles, at - step)) / (2.0 * step);
            if stiffness * (depth - at) > toughness * width { low = at } else { high = at }
        }
        low
    }
}

/// Triangles of a body at rest, m.
fn triangles(session: &Session) -> Vec<[Vec3; 3]> {
    let surface = &session.bodies[0].model.surface;
    surface.triangles.iter().map(|t| t.map(|v| surface.points[v as usize])).collect()
}

/// A blade without resistance moves no material, so it cuts the section of what it is drawn through, at any angle and depth: also where what is in the body is
/// shorter than the distance of the points that tell where the blade is.
#[test]
fn a_blade_without_resistance_cuts_the_section_it_sweeps() {
    let random = &mut Random(3);
    for case in 0..12 {
        let bench = Bench::new();
        let document: ObjDocument = match case % 3 {
            0 => generate::sphere(12, 0.05).expect("a ball"),
            1 => generate::cuboid(8, [0.1, 0.06, 0.08]).expect("a box"),
            _ => ObjDocument::read(&root().join("scenes/elephant.obj")).expect("a model"),
        };
        bench.write("model.obj", document.bytes());
        let along = random.direction();
        let aside = along.cross(&random.direction()).normalize();
        let plane = CutPlane { origin: 0.02 * random.vector(), along, down: along.cross(&aside) };
        let heel = plane.origin - 0.15 * plane.along - 0.1 * plane.down;
        // From the top of the section, by a share of it that is small in every second case.
        let depth = |depth: f64| heel + (0.1 + depth) * plane.down;
        let scene = |to: f64| {
            let [from, to] = [heel, depth(to)].map(|p| format!("{}, {}, {}", p.x, p.y, p.z));
            format!(
                "format = 1\n[time]\nduration = 1\n[[body]]\nmesh = \"model.obj\"\nsize = 0.1\nmaterial = {{ plugin = \"mass-spring\" }}\n\
                 grid = {{ level = {}, region = \"whole\" }}\n[[device]]\nname = \"hand\"\nparams = {{ path = [[0, {from}], [0.1, {to}]] }}\n\
                 [[tool]]\nname = \"knife\"\ndevice = \"hand\"\nradius = 0.001\n\
                 blade = {{ length = 0.3, direction = [{}, {}, {}], toughness = 0 }}\n[[edit]]\nkind = \"cut\"\ntool = \"knife\"\nend = 0.105\n",
                3 + case % 2,
                along.x,
                along.y,
                along.z
            )
        };
        let whole = triangles(&open_file(&bench.write("scene.toml", scene(0.0)), 1, None));
        let top =
            (0..1000).map(|i| 1e-4 * f64::from(i) - 0.08).find(|d| plane.area(&whole, *d) > 0.0).expect("a section");
        let deep = top + if case % 2 == 0 { 3e-4 + 1e-3 * random.unit() } else { 0.01 + 0.04 * random.unit() };
        let mut session = open_file(&bench.write("scene.toml", scene(deep)), 1, None);
        (0..110).for_each(|_| session.step());
        let (cut, expected) = (session.cuts().area, plane.area(&whole, deep));
        // Vertices within 2e-3 of an edge of the plane count as on it.
        let rounding = 2e-3 * expected + 1e-8;
        assert!(
            (cut - expected).abs() < rounding,
            "{case}: {cut} m^2 are cut of {expected} m^2, {} mm deep",
            1e3 * (deep - top)
        );
    }
}

/// The blades of the star come as deep as their springs and the toughness of the body allow.
#[test]
fn the_star_in_the_back_is_as_large_as_griffith_says() {
    let mut session = open_file(&root().join("scenes/cut-star.toml"), 1, None);
    let whole = triangles(&session);
    (0..900).for_each(|_| session.step());
    let (oblique, toughness) = (0.866_025, 2.0);
    let blades =
        [([-0.06, -0.015], [1.0, 0.0]), ([-0.03, -0.066962], [0.5, oblique]), ([0.031, -0.066962], [-0.5, oblique])];
    let expected: f64 = blades
        .iter()
        .enumerate()
        .map(|(i, ([x, z], [along_x, along_z]))| {
            let plane = CutPlane {
                origin: Vec3::new(*x, 0.03, *z),
                along: Vec3::new(*along_x, 0.0, *along_z),
                down: -Vec3::y(),
            };
            let stiffness = session.tools[i].tool.coupling.stiffness;
            plane.area(&whole, plane.reached(&whole, 0.0105, toughness, stiffness))
        })
        .sum();
    let cut = session.cuts().area;
    // The resistance is that of the last advance, which is up to 0.4 mm behind, where the section is narrower, and the body gives way a little.
    assert!((cut / expected - 1.0).abs() < 0.04, "{cut} m^2 are cut; of a rigid body {expected} m^2");
}

/// A hand that pauses and starts again on its straight way cuts the section all the same: what is cut springs to and fro beside the blade, whose ends are
/// outside, and carries it along.
#[test]
fn a_hand_that_pauses_cuts_a_plane() {
    let random = &mut Random(5);
    for case in 0..16 {
        let (mut step, mut path) = (0, Vec::new());
        let mut stay = |place: f64, steps: usize| {
            let ends = [step as f64 + 0.75, (step + steps) as f64 + 0.25];
            path.extend(ends.map(|at| format!("[{}, {place}, 0.013, -0.2]", 1e-3 * at)));
            step += steps;
        };
        for i in 0..31 {
            let pause = if random.unit() < 0.15 { 30.0 + 270.0 * random.unit() } else { 5.0 * random.unit() };
            stay(-0.15 + 0.01 * f64::from(i), 34 + pause as usize);
        }
        let (path, end) = (path.join(", "), step);
        let scene = format!(
            "format = 1\n[time]\nduration = 10\n[[body]]\nshape = {{ kind = \"box\", size = [0.2, 0.2, 0.2], cells = 7 }}\n\
             material = {{ plugin = \"mass-spring\", params = {{ young = 20000, density = 1060, damping-time = 5e-4 }} }}\n\
             grid = {{ level = 4, radius = 0.07 }}\n[[device]]\nname = \"hand\"\nparams = {{ path = [{path}] }}\n\
             [[tool]]\nname = \"knife\"\ndevice = \"hand\"\nradius = 0.02\nstiffness = 1920\nspeed = 4\nslew = 4e4\n\
             blade = {{ length = 0.8, toughness = 57.6 }}\n[[edit]]\nkind = \"cut\"\ntool = \"knife\"\nend = {}\n",
            1e-3 * end as f64
        );
        let mut session = open(&scene, 1);
        (0..end + 10).for_each(|_| session.step());
        let area = session.cuts().area;
        // The blade bends what it goes through: a path on a wave with slopes of up to 30 degrees is 8 % longer than a straight one.
        assert!((area / 0.04 - 1.0).abs() < 0.08, "{case}: {area} m^2 are cut of 0.04 m^2");
    }
}
