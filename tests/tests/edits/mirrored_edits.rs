//! Edits with `symmetry`: a model that is symmetric stays so, to the bit in planes normal to axes and to rounding in others, whatever the edit.

use nalgebra::{Rotation3, Unit};
use pliant_editor::SurfacePoint;
use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, open_file};
use std::f64::consts::PI;

/// Every kind that has a hand and no blade, with its keys and how deep the hand goes, m; away from the surface where it is negative.
const KINDS: [(&str, &str, f64); 15] = [
    ("touch", "release = \"keep\"", 0.002),
    ("pull", "release = \"keep\"", -0.004),
    ("grab", "radius = \"15 mm\"\nrelease = \"keep\"", -0.004),
    ("inflate", "radius = \"15 mm\"\nrelease = \"keep\"", -0.001),
    ("deflate", "radius = \"15 mm\"\nrelease = \"keep\"", -0.001),
    ("smooth", "radius = \"15 mm\"", 0.0015),
    ("flatten", "radius = \"15 mm\"", 0.0015),
    ("pinch", "radius = \"15 mm\"", 0.0015),
    ("relax", "radius = \"15 mm\"", 0.0015),
    ("grow", "radius = \"15 mm\"", 0.0015),
    ("shrink", "radius = \"15 mm\"", 0.0015),
    ("pin", "radius = \"15 mm\"", 0.0015),
    ("unpin", "radius = \"15 mm\"", 0.0015),
    ("paint", "radius = \"15 mm\"\nstrength = 0.3", 0.0015),
    ("stitch", "radius = \"15 mm\"", 0.0015),
];
/// m
const RADIUS: f64 = 0.005;

/// An uneven ball of about 0.05 m radius whose vertices and triangles are mirrored in x to the bit, as OBJ.
fn ball(random: &mut Random) -> (Vec<Vec3>, String) {
    let (rows, columns) = (16_usize, 28_usize);
    let bumps: Vec<(Vec3, f64)> = (0..4).map(|_| (random.direction(), 0.25 * random.signed())).collect();
    let at = |row: usize, column: usize| -> Vec3 {
        let (polar, around) = (PI * row as f64 / rows as f64, 2.0 * PI * column as f64 / columns as f64);
        let way = Vec3::new(polar.sin() * around.sin(), polar.sin() * around.cos(), polar.cos());
        let seen = Vec3::new(way.x.abs(), way.y, way.z);
        let bump: f64 = bumps.iter().map(|(to, size)| size * (3.0 * (seen.dot(to) - 1.0)).exp()).sum();
        let p = 0.05 * (1.0 + bump) * way;
        // Sines of half a turn are not 0.
        if column == 0 || 2 * column == columns { Vec3::new(0.0, p.y, p.z) } else { p }
    };
    let mut points = vec![at(0, 0)];
    for row in 1..rows {
        for column in 0..columns {
            let is_image = 2 * column > columns;
            let p = at(row, if is_image { columns - column } else { column });
            points.push(if is_image { Vec3::new(-p.x, p.y, p.z) } else { p });
        }
    }
    points.push(at(rows, 0));
    let number = |row: usize, column: usize| match row {
        0 => 1,
        row if row == rows => points.len(),
        row => 2 + (row - 1) * columns + column % columns,
    };
    let mut text = String::new();
    points.iter().for_each(|p| text += &format!("v {} {} {}\n", p.x, p.y, p.z));
    for row in 0..rows {
        for column in 0..columns {
            let [a, b, c, d] =
                [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)].map(|(r, k)| number(r, k));
            let triangles = if 2 * column < columns { [[a, c, b], [a, d, c]] } else { [[a, d, b], [b, d, c]] };
            for t in triangles.iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
                text += &format!("f {} {} {}\n", t[0], t[2], t[1]);
            }
        }
    }
    (points, text)
}

/// A cloth whose vertices and triangles are mirrored in x to the bit, fixed along two borders.
fn cloth() -> (Vec<Vec3>, String) {
    let n = 16_i32;
    let place = |i: i32| 0.00625 * f64::from(i - n / 2);
    let points: Vec<Vec3> =
        (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| Vec3::new(place(i), place(j), 0.0)).collect();
    let mut text = String::new();
    points.iter().for_each(|p| text += &format!("v {} {} {}\n", p.x, p.y, p.z));
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let number = |i: i32, j: i32| j * (n + 1) + i + 1;
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        let rising = (2 * i < n) == ((i.min(n - 1 - i) + j) % 2 == 0);
        text +=
            &if rising { format!("f {a} {b} {c}\nf {a} {c} {d}\n") } else { format!("f {a} {b} {d}\nf {b} {c} {d}\n") };
    }
    (points, text)
}

/// A body, where it is, and the plane that it is symmetric in.
struct Placed {
    rotation: Rotation3<f64>,
    position: Vec3,
    keys: String,
}

impl Placed {
    fn new(random: Option<&mut Random>) -> Self {
        let Some(random) = random else {
            return Self { rotation: Rotation3::identity(), position: Vec3::zeros(), keys: String::new() };
        };
        let (axis, angle, position) = (random.direction(), 40.0 + 100.0 * random.unit(), 0.1 * random.vector());
        let keys = format!(
            "rotation = {{ axis = [{}, {}, {}], angle = \"{angle} deg\" }}\nposition = [{}, {}, {}]\n",
            axis.x, axis.y, axis.z, position.x, position.y, position.z
        );
        Self { rotation: Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle.to_radians()), position, keys }
    }

    fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.position
    }

    /// The mirror image of a vector in the plane x = 0 of the model.
    fn image(&self, v: Vec3) -> Vec3 {
        let normal = self.rotation * Vec3::x();
        v - 2.0 * normal.dot(&v) * normal
    }
}

fn scene(
    body: &str,
    SurfacePoint { point: at, normal }: SurfacePoint,
    kind: &str,
    keys: &str,
    depth: f64,
    symmetry: &str,
) -> String {
    let row = |time: f64, height: f64| {
        let p = at + height * normal;
        format!("[{time}, {}, {}, {}]", p.x, p.y, p.z)
    };
    // What grips takes hold near the surface and goes away from it.
    let path = match depth < -0.0015 {
        true => [row(0.0, 0.001), row(0.02, 0.001), row(0.08, 0.001 - depth)],
        false => [row(0.0, RADIUS + 0.001), row(0.03, RADIUS - depth), row(0.08, RADIUS - depth)],
    };
    format!(
        "format = 1\n[time]\nduration = 1\ndt = \"1 ms\"\nintegrator = \"backward-euler\"\n[[body]]\n{body}\n[[device]]\nname = \"hand\"\n\
         params = {{ peak-force = \"50 N\", path = [{}] }}\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = {RADIUS}\nstiffness = \"300 N/m\"\n\
         [[edit]]\nkind = \"{kind}\"\ntool = \"finger\"\nend = 0.07\n{keys}\nsymmetry = {symmetry}\n",
        path.join(", ")
    )
}

/// Runs a scene, and returns the largest distance (m) of a vertex from the mirror image of its partner, the largest displacement and the largest force on the first hand and difference from
/// that on the mirrored one (N).
fn asymmetry(session: &mut Session, points: &[Vec3], placed: &Placed) -> [f64; 4] {
    let (mut force, mut differs) = (0.0_f64, 0.0_f64);
    for _ in 0..90 {
        session.step();
        let [a, b] = [0, 1].map(|tool| session.frame().tools[tool].force);
        force = force.max(a.norm());
        differs = differs.max((placed.image(a) - b).norm());
        let [a, b] = [0, 1].map(|tool| session.tools[tool].hand.position);
        let mirrored = placed.position + placed.image(a - placed.position);
        assert!((b - mirrored).norm() < 1e-12, "{b:?} {mirrored:?}");
    }
    session.update_surface();
    let x = &session.bodies[0].skin.x;
    let mut partner = std::collections::HashMap::new();
    let key = |p: &Vec3| [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits);
    partner.extend(points.iter().enumerate().map(|(v, p)| (key(p), v)));
    let (mut apart, mut most) = (0.0_f64, 0.0_f64);
    for (v, p) in points.iter().enumerate() {
        let other = partner[&key(&Vec3::new(-p.x, p.y, p.z))];
        let image = placed.position + placed.image(x[v] - placed.position);
        apart = apart.max((x[other] - image).norm());
        most = most.max((x[v] - session.bodies[0].model.surface.points[v]).norm());
    }
    [apart, most, force, differs]
}

const SOLID: &str = "mesh = \"model.obj\"\nmaterial = { plugin = \"corotational\", params = { young = \"10 kPa\", poisson = 0.3, damping-time = \"2 ms\" } }\n\
    grid = { level = 4, region = \"whole\" }";
const SHEET: &str = "mesh = \"model.obj\"\nsheet = {}\nmaterial = { plugin = \"cloth\", params = { young-warp = 300, young-weft = 300, poisson = 0.2, \
    damping-time = \"5 ms\" } }";

#[test]
fn every_edit_keeps_a_symmetric_model_symmetric_in_its_own_plane() {
    let (mut worst, mut uneven) = (0.0_f64, 0.0_f64);
    for case in 0..2 * KINDS.len() {
        let mut random = Random(900 + case as u64);
        let (kind, keys, depth) = KINDS[case / 2];
        let is_sheet = case % 2 == 1;
        let (points, text) = if is_sheet { cloth() } else { ball(&mut random) };
        let spot = if is_sheet { 0x70 } else { 1 + 28 * (3 + random.below(9) as usize) + 4 + random.below(5) as usize };
        let normal = if is_sheet { Vec3::z() } else { points[spot].normalize() };
        for way in ["axis", "own", "plane"] {
            // Along an axis the exact one, elsewhere a model that is turned at random.
            let placed = Placed::new(if way == "axis" { None } else { Some(&mut random) });
            let bench = Bench::new();
            bench.write("model.obj", &text);
            let (point, axis) = (placed.point(Vec3::new(0.0, 0.03, -0.02)), placed.rotation * Vec3::x());
            let symmetry = match way {
                "axis" => "\"x\"".to_owned(),
                "own" => "{ own = \"x\" }".to_owned(),
                _ => format!(
                    "{{ point = [{}, {}, {}], normal = [{}, {}, {}] }}",
                    point.x,
                    point.y,
                    point.z,
                    3.0 * axis.x,
                    3.0 * axis.y,
                    3.0 * axis.z
                ),
            };
            let held = |p: Vec3| {
                let p = placed.point(p);
                format!("[[body.fixed]]\nball = [{}, {}, {}]\nradius = 0.004\n", p.x, p.y, p.z)
            };
            let fixed = if is_sheet {
                [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
                    .map(|(x, y)| held(Vec3::new(0.05 * x, 0.05 * y, 0.0)))
                    .concat()
            } else {
                String::new()
            };
            let body = format!("{}\n{}{fixed}", if is_sheet { SHEET } else { SOLID }, placed.keys);
            let hand = SurfacePoint { point: placed.point(points[spot]), normal: placed.rotation * normal };
            let mut session =
                open_file(&bench.write("scene.toml", scene(&body, hand, kind, keys, depth, &symmetry)), 1, None);
            let what = format!("{kind} of a {} in {way}", if is_sheet { "sheet" } else { "solid" });
            assert_eq!(session.events.count(EventKind::Model), 0, "{what}: {:?}", session.events.described());
            let [apart, most, force, differs] = asymmetry(&mut session, &points, &placed);
            assert!(force > 1e-4 || most > 1e-6, "{what}: nothing happened");
            if way == "axis" {
                assert_eq!(apart, 0.0, "{what}: to the bit");
            }
            worst = worst.max(apart);
            uneven = uneven.max(differs / force);
            println!("{what}: {apart:.1e} m of {most:.1e} m; force {force:.2e} N, uneven {differs:.1e} N");
            // Positions of about 0.2 m are mirrored with a few roundings.
            assert!(apart < 1e-15, "{what}: {apart} m");
        }
    }
    println!("{worst:.1e} m at most, forces differ by {uneven:.1e} of them");
}

#[test]
fn planes_that_are_none_are_refused() {
    let bench = Bench::new();
    bench.write("model.obj", cloth().1);
    for (symmetry, parts) in [
        ("{ point = [0, 0, 0], normal = [0, 0, 0] }", ["normal [0.0, 0.0, 0.0]", "not zero"]),
        ("{ own = \"xy\" }", ["plane \"xy\" of the model", "one of"]),
        ("{ point = [0, 0, 0] }", ["{ own = \"x\" }", "normal = [1, 0, 0]"]),
        ("3", ["{ own = \"x\" }", "axes such as"]),
    ] {
        let (kind, keys, depth) = KINDS[0];
        let place = SurfacePoint { point: Vec3::zeros(), normal: Vec3::z() };
        bench.write("scene.toml", scene(SHEET, place, kind, keys, depth, symmetry));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2).says(&parts);
    }
}
