//! Lines around axes, along curves and between points.

use super::*;
use pliant_mesh::testing::Random;

fn vector(random: &mut Random) -> Vec3 {
    Vec3::from_fn(|_, _| 2.0 * random.unit() - 1.0)
}

#[test]
fn helices_keep_their_angle_to_the_axis_and_turn_right_handed() {
    let mut random = Random(1);
    for _ in 0..200 {
        let axis = vector(&mut random).normalize();
        let (origin, point, alpha) = (vector(&mut random), vector(&mut random), 3.0 * random.unit() - 1.5);
        let lines = FibreLines::Around { axis, point: origin, angle: [libm::cos(alpha), libm::sin(alpha)] };
        let direction = lines.at(point);
        let radius = (point - origin) - axis * (point - origin).dot(&axis);
        assert!((direction.norm() - 1.0).abs() < 1e-12 && direction.dot(&radius).abs() < 1e-12);
        assert!((direction.dot(&axis) - libm::sin(alpha)).abs() < 1e-12);
        // Counter-clockwise seen from the tip of the axis.
        assert!(axis.dot(&radius.cross(&direction)) > 0.0 || alpha.abs() > 1.57);
    }
    let circles = FibreLines::Around { axis: Vec3::z(), point: Vec3::zeros(), angle: [1.0, 0.0] };
    assert_eq!(circles.at(Vec3::z()), Vec3::zeros(), "on the axis no circle has a direction");
}

#[test]
fn a_curve_gives_its_tangent_at_the_nearest_place() {
    let arc = |t: f64| Vec3::new(libm::cos(t), libm::sin(t), 0.0);
    let curve = Curve::new((0..=100).map(|i| arc(0.02 * f64::from(i))).collect()).expect("a curve");
    let mut random = Random(2);
    for _ in 0..100 {
        let (t, radius) = (0.1 + 1.8 * random.unit(), 0.5 + random.unit());
        let exact = Vec3::new(-libm::sin(t), libm::cos(t), 0.0);
        // Chords of 0.02 rad: on the curve of second order; beside it a chord is reached over an angle that is wider or narrower by the distance.
        let off = (curve.at(radius * arc(t)) - exact).norm();
        assert!(off < 0.01 * (radius - 1.0).abs() + 2e-4, "{t} {radius}: {off}");
    }
    assert_eq!(Curve::new(vec![Vec3::x(), Vec3::x(), Vec3::y()]), Err(1));
    assert_eq!(Curve::new(vec![Vec3::x(), Vec3::y(), Vec3::x()]), Err(1), "it turns back");
}

#[test]
fn nearest_points_of_a_cloud_are_those_of_a_search_through_all() {
    let mut random = Random(3);
    for count in [1, 3, 4, 5, 40, 300] {
        let samples: Vec<(Vec3, Vec3)> =
            (0..count).map(|_| (vector(&mut random), vector(&mut random).normalize())).collect();
        let cloud = DirectionCloud::new(samples);
        for _ in 0..50 {
            let point = 1.5 * vector(&mut random);
            let all = cloud.samples.iter().enumerate();
            let mut all: Vec<(f64, usize)> = all.map(|(i, (at, _))| ((at - point).norm_squared(), i)).collect();
            all.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            all.truncate(NEIGHBOURS);
            assert_eq!(cloud.nearest(point), all);
        }
    }
}

#[test]
fn a_cloud_of_a_smooth_field_gives_it_between_its_points_whatever_their_signs() {
    let field = |p: Vec3| Vec3::new(1.0, 0.3 * p.x, 0.3 * p.y).normalize();
    let mut random = Random(4);
    let samples = (0..4000).map(|_| {
        let at = vector(&mut random);
        (at, if random.unit() < 0.5 { field(at) } else { -field(at) })
    });
    let cloud = DirectionCloud::new(samples.collect());
    for _ in 0..200 {
        let point = vector(&mut random);
        let along = cloud.at(point).dot(&field(point)).abs();
        assert!(along > 0.999, "{along}");
        let (at, direction) = cloud.samples[(random.next_u64() % 4000) as usize];
        assert_eq!(cloud.at(at), direction);
    }
}
