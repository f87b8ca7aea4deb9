//! Tests of shapes against closed forms and brute force.

use super::*;
use nalgebra::UnitQuaternion;

/// Quasi-random points in [-1, 1]^3 (Weyl sequences of square roots).
fn point(k: u32) -> Vec3 {
    Vec3::from_fn(|i, _| 2.0 * ((f64::from(k) * [2.0_f64, 3.0, 5.0][i].sqrt()).fract() - 0.5))
}

fn shapes() -> Vec<Arc<dyn Shape>> {
    vec![
        Arc::new(Sphere { radius: 0.3 }),
        Arc::new(Capsule::new(0.2, 0.7)),
        Arc::new(Cuboid::new(Vec3::new(0.4, 0.6, 0.9))),
        Arc::new(Plane),
    ]
}

#[test]
fn distances_are_closed_forms() {
    let capsule = Capsule::new(0.2, 0.6);
    assert!((capsule.distance(Vec3::new(0.5, 0.0, 0.1)) - 0.3).abs() < 1e-15, "beside the cylinder: x - r");
    assert!((capsule.distance(Vec3::new(0.3, 0.0, 0.7)) - 0.3).abs() < 1e-15, "beyond an end: 3-4-5");
    assert!((capsule.distance(Vec3::zeros()) + 0.2).abs() < 1e-15, "on the axis: -r");
    let cuboid = Cuboid::new(Vec3::new(0.2, 0.4, 0.6));
    assert!((cuboid.distance(Vec3::new(0.4, 0.2, 0.1)) - 0.3).abs() < 1e-15, "face");
    assert!((cuboid.distance(Vec3::new(0.4, 0.6, 0.0)) - 0.5).abs() < 1e-15, "edge: 3-4-5");
    assert!((cuboid.distance(Vec3::new(0.2, 0.4, 0.5)) - 0.3).abs() < 1e-15, "corner: 1-2-2");
    assert!((cuboid.distance(Vec3::new(0.05, 0.0, 0.0)) + 0.05).abs() < 1e-15, "inside: the nearest face");
    assert_eq!(Plane.distance(Vec3::new(3.0, -2.0, -0.25)), -0.25);
    assert!((Sphere { radius: 0.3 }.distance(Vec3::new(0.3, 0.0, 0.4)) - 0.2).abs() < 1e-15);
}

/// `p - d n` lies on the surface of a shape, n is the gradient, and no step of any length changes the distance by more than that length.
#[test]
fn normals_are_gradients_and_lead_to_the_surface() {
    const H: f64 = 1e-6;
    for shape in shapes() {
        for k in 0..400 {
            let p = point(k);
            let (distance, Some(normal)) = (shape.distance(p), shape.normal(p)) else { panic!("{shape:?} at {p:?}") };
            assert!((normal.norm() - 1.0).abs() < 1e-12);
            let at = |step: Vec3| shape.distance(p + step);
            let slope = Vec3::from_fn(|i, _| {
                let step = Vec3::from_fn(|j, _| if i == j { H } else { 0.0 });
                (at(step) - at(-step)) / (2.0 * H)
            });
            // Second differences of a distance are at most H over its value; beside a medial surface of a box the slope jumps.
            let is_smooth = (slope.norm() - 1.0).abs() < 1e-6;
            assert!(!is_smooth || (slope - normal).norm() < 1e-5, "{shape:?} at {p:?}: {slope:?} {normal:?}");
            if distance > 0.0 {
                assert!(is_smooth && shape.distance(p - distance * normal).abs() < 1e-12, "{shape:?} at {p:?}");
            }
            assert!((shape.distance(p + point(k + 7)) - distance).abs() <= point(k + 7).norm() + 1e-12, "1-Lipschitz");
        }
    }
}

#[test]
fn supports_and_bounds_are_those_of_points_inside() {
    for shape in shapes() {
        let inside: Vec<Vec3> = (0..20_000).map(point).filter(|p| shape.distance(*p) <= 0.0).collect();
        let [low, high] = shape.bounds();
        for p in &inside {
            assert!((0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]) && p.norm() <= shape.bounding_radius() + 1e-12);
        }
        for k in 0..60 {
            let Some(direction) = point(k).try_normalize(0.1) else { continue };
            let support = shape.support(direction);
            let most = inside.iter().map(|p| p.dot(&direction)).fold(f64::NEG_INFINITY, f64::max);
            assert!(most <= support + 1e-12, "{shape:?}: {support} {most}");
        }
        // It is attained: by the tangent plane at the nearest point of the surface, h(n) = n . (p - d n).
        for p in (0..100).map(point).filter(|p| shape.distance(*p) > 0.0) {
            let normal = shape.normal(p).unwrap();
            let tangent = normal.dot(&p) - shape.distance(p);
            assert!((shape.support(normal) - tangent).abs() < 1e-12, "{shape:?}");
        }
    }
}

#[test]
fn no_sampled_point_of_a_triangle_is_closer() {
    for shape in shapes() {
        for k in 0..60 {
            let triangle =
                [point(3 * k), point(3 * k + 1), point(3 * k + 2)].map(|p| 0.6 * p + Vec3::new(0.5, 0.4, 0.9));
            let found = shape.closest_on_triangle(triangle);
            let from_bary: Vec3 = (0..3).map(|i| found.bary[i] * triangle[i]).sum();
            assert!((from_bary - found.point).norm() < 1e-12 && (found.bary.sum() - 1.0).abs() < 1e-12);
            let mut least = f64::INFINITY;
            for u in 0..=80 {
                for v in 0..=80 - u {
                    let (v, w) = (f64::from(u) / 80.0, f64::from(v) / 80.0);
                    let at = (1.0 - v - w) * triangle[0] + v * triangle[1] + w * triangle[2];
                    least = least.min(shape.distance(at));
                }
            }
            // The result inside of a box is not exact, but it must be inside.
            let distance = shape.distance(found.point);
            assert!(
                if least > 0.0 { distance <= least + 1e-9 } else { distance <= 1e-9 },
                "{shape:?}: {distance} {least}"
            );
        }
    }
}

#[test]
fn first_hit_is_where_the_distance_is_the_margin() {
    for shape in shapes() {
        let mut hits = 0;
        for k in 0..300 {
            let (start, way, margin) = (1.5 * point(k), 2.0 * point(31 * k + 500), 0.05);
            if shape.distance(start) <= margin {
                continue;
            }
            let sampled = (0..=4000).map(|i| f64::from(i) / 4000.0).find(|s| shape.distance(start + *s * way) < margin);
            match (shape.first_hit(start, way, margin), sampled) {
                (Some(s), Some(first)) => {
                    hits += 1;
                    assert!((shape.distance(start + s * way) - margin).abs() < 1e-8 && s <= first, "{shape:?}");
                }
                // A point may enter and leave the shape between two samples.
                (Some(s), None) => assert!((shape.distance(start + s * way) - margin).abs() < 1e-8),
                (None, Some(_)) => panic!("{shape:?} is missed from {start:?} along {way:?}"),
                (None, None) => {}
            }
        }
        assert!(hits > 5, "{shape:?}: {hits}");
        let inward = -0.01 * Vec3::z();
        let inside = Vec3::new(0.0, 0.0, shape.bounds()[1].z - 0.001);
        assert_eq!(shape.first_hit(inside, inward, 0.0), Some(0.0), "{shape:?}");
        assert_eq!(shape.first_hit(inside, -inward, 0.0), None, "{shape:?}: what leaves does not hit");
    }
}

#[test]
fn an_oriented_shape_is_the_shape_in_rotated_axes() {
    let turn = UnitQuaternion::from_scaled_axis(Vec3::new(0.3, -0.8, 0.5));
    for shape in shapes() {
        let mut turned = OrientedShape::new(Arc::clone(&shape));
        turned.set_rotation(turn);
        for p in (0..50).map(point) {
            let own = turn.inverse() * p;
            assert!((turned.distance(p) - shape.distance(own)).abs() < 1e-12, "{shape:?}");
            let (a, b) = (turned.normal(p).unwrap(), turn * shape.normal(own).unwrap());
            assert!((a - b).norm() < 1e-9, "{shape:?}");
        }
        assert_eq!(turned.rotation() == UnitQuaternion::identity(), shape.is_round());
    }
}

#[test]
fn shape_parameters_are_checked() {
    let some = ShapeParams { radius: Some(0.01), length: Some(0.04), size: None };
    assert!(build("capsule", &some).is_ok() && build("plane", &ShapeParams::default()).is_ok());
    let refused = |kind: &str, params: &ShapeParams| build(kind, params).unwrap_err();
    assert_eq!(refused("cone", &some), "shape `cone`; allowed is `sphere`, `capsule`, `box`, `plane`");
    assert_eq!(refused("sphere", &some), "`length` of a `sphere`; allowed is `radius`");
    assert_eq!(refused("plane", &some), "`radius` of a `plane`; allowed is no dimension");
    assert_eq!(refused("box", &ShapeParams::default()), "`box` without `size`; it needs `size`");
    let flat = ShapeParams { size: Some([0.1, 0.0, 0.1]), ..ShapeParams::default() };
    assert_eq!(refused("box", &flat), "`size` of a `box` is 0 m; allowed is a finite length above 0");
}
