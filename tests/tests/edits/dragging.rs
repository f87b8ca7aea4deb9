//! Dragging cloth: a `grab` on a sheet takes along what is within its radius, smoothly, and the hand feels what holds the cloth.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::open;

/// A cloth of 0.2 m that is held along two borders and dragged at a place inside.
struct Drag {
    session: Session,
    /// Where the hand takes hold, and its way, m.
    at: Vec3,
    way: Vec3,
    /// Radius of the grab, m.
    radius: f64,
}

impl Drag {
    fn new(random: &mut Random, pattern: &str, cells: u32, falloff: &str) -> Self {
        let at = Vec3::new(0.03 * random.signed(), 0.02 + 0.02 * random.signed(), 0.0);
        let radius = 0.02 + 0.02 * random.unit();
        // Mostly off the plane, which leaves no cloth slack.
        let way = Vec3::new(0.003 * random.signed(), 0.003 * random.signed(), 0.01 + 0.004 * random.unit());
        let young = 20.0 * 10f64.powf(random.unit());
        let text = format!(
            r#"
            format = 1
            [time]
            duration = 3
            dt = "4 ms"
            integrator = "backward-euler"
            [[body]]
            shape = {{ kind = "sheet", pattern = "{pattern}", cells = {cells}, size = [0.2, 0.2, 0] }}
            position = [-0.1, -0.1, 0]
            sheet = {{}}
            material = {{ plugin = "cloth", params = {{ density = 0.2, young-warp = {young}, young-weft = {young}, poisson = 0.2, bending-warp = 1e-5, bending-weft = 1e-5, damping-time = "20 ms" }} }}
            [[body.fixed]]
            box = [[-1, -1, -1], [1, -0.0999, 1]]
            [[body.fixed]]
            box = [[-1, 0.0999, -1], [1, 1, 1]]
            [[device]]
            name = "hand"
            params = {{ interpolation = "smooth", peak-force = "100 N", path = [[0, {}, {}, 0.001], [0.05, {}, {}, 0.001], [0.5, {}, {}, {}]] }}
            [[tool]]
            name = "hand"
            device = "hand"
            radius = "5 mm"
            stiffness = "2000 N/m"
            [[edit]]
            kind = "grab"
            tool = "hand"
            radius = {radius}
            falloff = "{falloff}"
            "#,
            at.x,
            at.y,
            at.x,
            at.y,
            at.x + way.x,
            at.y + way.y,
            0.001 + way.z,
        );
        Self { session: open(&text, 1), at, way, radius }
    }

    /// Displacements of the vertices, m.
    fn displacements(&mut self) -> (Vec<Vec3>, Vec<Vec3>) {
        self.session.update_surface();
        let body = &self.session.bodies[0];
        let rest = body.model.surface.points.clone();
        let moved = body.skin.x.iter().zip(&rest).map(|(x, p)| x - p).collect();
        (rest, moved)
    }
}

#[test]
fn a_grab_drags_cloth_along_smoothly_and_gives_what_holds_it() {
    let mut random = Random(31);
    for (pattern, cells, falloff) in [
        ("alternating", 32, "smooth"),
        ("equilateral", 32, "smooth"),
        ("irregular", 40, "smooth"),
        ("alternating", 48, "linear"),
        ("regular", 40, "sphere"),
    ] {
        let mut drag = Drag::new(&mut random, pattern, cells, falloff);
        while drag.session.time() < 2.5 {
            drag.session.step();
        }
        let (rest, moved) = drag.displacements();
        let weight = |p: &Vec3| {
            let r = (p - drag.at).norm() / drag.radius;
            match falloff {
                _ if r >= 1.0 => 0.0,
                "linear" => 1.0 - r,
                "sphere" => (1.0 - r * r).sqrt(),
                _ => (1.0 - r).powi(2) * (1.0 + 2.0 * r),
            }
        };
        let sum: f64 = rest.iter().map(weight).sum();
        let mean = rest.iter().zip(&moved).map(|(p, u)| weight(p) * u).sum::<Vec3>() / sum;
        let follows = mean.dot(&drag.way) / drag.way.norm_squared();
        // No vertex within the radius runs ahead of the hand by more than the cloth strains, and none jumps over its ring: the strain of a load spread over the radius is about u / R, and ends of edges of irregular triangles differ by as much again.
        let size = drag.way.norm();
        let inside = rest.iter().zip(&moved).filter(|(p, _)| (*p - drag.at).norm() < drag.radius);
        let most = inside.map(|(_, u)| u.norm()).fold(0.0, f64::max);
        let mut steepest = 0.0_f64;
        let triangles = &drag.session.bodies[0].model.surface.triangles;
        for t in triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].map(|(a, b)| (a as usize, b as usize)) {
                steepest = steepest.max((moved[a] - moved[b]).norm() / (rest[a] - rest[b]).norm() * drag.radius / size);
            }
        }
        let flipped = triangles
            .iter()
            .filter(|t| {
                let normal = |x: &dyn Fn(u32) -> Vec3| (x(t[1]) - x(t[0])).cross(&(x(t[2]) - x(t[0])));
                let before = normal(&|v| rest[v as usize]);
                before.dot(&normal(&|v| rest[v as usize] + moved[v as usize])) < 0.0
            })
            .count();
        let nodes = &drag.session.bodies[0].system.nodes;
        let reactions = drag.session.reactions(0).iter().zip(&nodes.constraint);
        let held: Vec3 = reactions.filter(|(_, constraint)| !constraint.is_free()).map(|(force, _)| force).sum();
        let force = drag.session.frame().tools[0].force;
        println!(
            "{pattern} {cells} {falloff}: radius {:.1} mm, the region follows {follows:.3} of {:.1} mm, most {:.3}, steepest {steepest:.2}, {force:.3?} N, held by {held:.3?} N",
            1e3 * drag.radius,
            1e3 * size,
            most / size
        );
        assert!((0.95..1.02).contains(&follows), "{pattern}: the region follows {follows} of the hand");
        assert!(most < 1.25 * size, "{pattern}: {most} m, the hand {size} m");
        assert!(steepest < 2.0, "{pattern}: {steepest}");
        assert_eq!(flipped, 0, "{pattern}");
        // At rest the hand feels the opposite of what it does, which the border holds.
        assert!(force.norm() > 1e-3, "{pattern}: {force:?} N");
        assert!((force - held).norm() < 0.02 * force.norm(), "{pattern}: {force:?} N, the border holds {held:?} N");
    }
}
