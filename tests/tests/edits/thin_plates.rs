//! Flatten takes the side that is touched: a plate thinner than the tool becomes flat there, lies as it did, and keeps its thickness.

#![allow(clippy::print_stdout, reason = "what was seen of each case")]

use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_mesh::{Surface, generate};
use pliant_tests::{Bench, open_file};

/// m: sides of the plate.
const SIDE: f64 = 0.1;
/// m: radius of the soft region.
const RADIUS: f64 = 0.02;

/// A plate of a `thickness` (m) with noise of a `height` (m) on both sides.
fn plate(random: &mut Random, thickness: f64, height: f64) -> String {
    let document = generate::cuboid(24, [SIDE, SIDE, thickness]).unwrap();
    let text = String::from_utf8_lossy(document.bytes()).into_owned();
    let line = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["v", x, y, z] => {
            let z: f64 = z.parse().unwrap();
            let noise = if z.abs() > 0.49 * thickness { height * (2.0 * random.unit() - 1.0) } else { 0.0 };
            format!("v {x} {y} {}\n", z + noise)
        }
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

/// Root mean square distance of points from the plane that fits their heights (m), and the slope of that plane.
fn roughness(points: &[Vec3]) -> [f64; 2] {
    let mean: Vec3 = points.iter().sum::<Vec3>() / points.len() as f64;
    let (mut normal, mut right) = (nalgebra::Matrix2::zeros(), nalgebra::Vector2::zeros());
    for p in points.iter().map(|p| p - mean) {
        normal += p.xy() * p.xy().transpose();
        right += p.z * p.xy();
    }
    let slope = normal.try_inverse().unwrap() * right;
    let off = |p: &Vec3| (p.z - mean.z - slope.dot(&(p - mean).xy())).powi(2);
    [(points.iter().map(off).sum::<f64>() / points.len() as f64).sqrt(), slope.norm()]
}

#[test]
fn a_plate_is_flattened_where_it_is_touched_and_keeps_its_thickness() {
    let mut random = Random(21);
    for case in 0..9 {
        let thickness = 0.002 + 0.008 * random.unit();
        let height = 0.1 * thickness;
        let plugin = ["mass-spring", "neo-hookean", "corotational"][case % 3];
        let level = 4 + random.below(2);
        let bench = Bench::new();
        let text = plate(&mut random, thickness, height);
        bench.write("model.obj", &text);
        let press = 0.5 * thickness + 0.0095;
        let scene = format!(
            "format = 1\n[time]\nduration = 3\ndt = \"4 ms\"\n[[body]]\nmesh = \"model.obj\"\nsize = {SIDE}\ngrid = {{ level = {level} }}\n\
             material = {{ plugin = \"{plugin}\", params = {{ young = 20000, damping-time = \"2 ms\" }} }}\n\
             [[body.fixed]]\nbox = [[-1, -1, -1], [-0.04, 1, 1]]\n[[body.fixed]]\nbox = [[0.04, -1, -1], [1, 1, 1]]\n[[device]]\nname = \"hand\"\n\
             params = {{ path = [[0, 0, 0, {press}]] }}\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\n\
             radius = 0.01\nstiffness = 500\n[[edit]]\nkind = \"flatten\"\ntool = \"finger\"\nradius = {RADIUS}\nend = 2\n"
        );
        let mut session = open_file(&bench.write("scene.toml", scene), 1, None);
        (0..520).for_each(|_| session.step());
        let body = &session.bodies[0];
        let surface = &body.model.surface;
        let before: &[Vec3] = &surface.points;
        let normals = Surface::vertex_normals(surface);
        let side = |up: f64, points: &[Vec3]| -> Vec<Vec3> {
            let is_on = |v: &usize| before[*v].xy().norm() < 0.5 * RADIUS && up * normals[*v].z > 0.0;
            (0..before.len()).filter(is_on).map(|v| points[v]).collect()
        };
        let [[was, _], [is, slope]] = [before, &body.skin.settled[..]].map(|points| roughness(&side(1.0, points)));
        let mean = |points: Vec<Vec3>| points.iter().map(|p| p.z).sum::<f64>() / points.len() as f64;
        let thick = |points: &[Vec3]| mean(side(1.0, points)) - mean(side(-1.0, points));
        let ratio = thick(&body.skin.settled) / thick(before);
        let what = format!(
            "case {case}: {thickness:.4} m of {plugin}, level {level}: roughness {was:.2e} to {is:.2e} m, slope {slope:.3}, thickness times {ratio:.3}"
        );
        println!("{what}");
        assert!(is < 0.25 * was, "{what}");
        // The plane that fits noise of a tenth of the thickness over the region is sloped by no more than the noise is.
        assert!(slope < height / (0.5 * RADIUS), "{what}");
        assert!((ratio - 1.0).abs() < 0.2, "{what}");
    }
}
