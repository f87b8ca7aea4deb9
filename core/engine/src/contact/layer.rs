//! The soft layer between a tool and a surface: how a touch is spread, and where the tool comes to rest in it.
//!
//! A hard ball in a dimple touches at one point now and at another the next moment. A thin elastic layer takes that away:
//! each sample of the surface inside the shape is pushed out by `k d`, d its depth, and the massless tool stands where those
//! pushes balance the pull of the hand. Its pressure follows the shape of both bodies, so a ball on a half-space comes out
//! as Hertz (1881) has it. The layer is as stiff as the step bears: it adds to a node's stiffness about what the fastest
//! mode of the body already has.

use super::near::Near;
use crate::shape::OrientedShape;
use nalgebra::Matrix3;
use pliant_solver::{Block, Vec3};

/// A tool in the layer over a few samples.
pub struct Layer<'a> {
    /// Shape of the tool.
    pub shape: &'a OrientedShape,
    /// Stiffness of the spring to the hand, N/m.
    pub pull: f64,
    /// Stiffness of the layer per area, N/m^3.
    pub stiffness: f64,
}

/// The push of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// Rest place of the sample, m.
    pub rest: Vec3,
    /// Where the sample is, m.
    pub point: Vec3,
    /// Force on the surface, N.
    pub force: Vec3,
    /// Stiffness of the force against moving the sample, N/m.
    pub stiffness: Block,
    /// Size of the force, N.
    pub size: f64,
}

/// Most Newton steps to balance.
const STEPS: usize = 20;

impl Layer<'_> {
    /// Where a tool at `p` comes to rest between the samples and a spring to `hand`; along one direction only, if one is given. Returns its
    /// place, m, and the force of the layer on it, N.
    pub fn balance(&self, samples: &[Near], mut p: Vec3, hand: Vec3, along: Option<Vec3>) -> (Vec3, Vec3) {
        let mut layer = Vec3::zeros();
        let scale = self.shape.shape().length_scale();
        for _ in 0..STEPS {
            let mut hessian = Matrix3::from_diagonal_element(self.pull);
            layer = Vec3::zeros();
            for s in samples {
                let Some((n, depth)) = self.into(s, p) else { continue };
                let k = self.stiffness * s.area;
                layer -= k * depth * n;
                hessian += k * n * n.transpose();
            }
            let force = self.pull * (hand - p) + layer;
            let step = match along {
                Some(d) => d * (d.dot(&force) / d.dot(&(hessian * d))),
                None => hessian.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * force),
            };
            // A sample that is let in or out changes the slope: short moves keep to it.
            let (length, most) = (step.norm(), 0.1 * scale);
            p += if length > most { step * (most / length) } else { step };
            if length <= 1e-9 * scale {
                break;
            }
        }
        (p, layer)
    }

    /// The push of each sample inside a tool at `p`.
    pub fn pushes<'a>(&'a self, samples: &'a [Near], p: Vec3) -> impl Iterator<Item = Push> + 'a {
        samples.iter().filter_map(move |s| {
            let (normal, depth) = self.into(s, p)?;
            let k = self.stiffness * s.area;
            let stiffness = std::array::from_fn(|e| k * normal[e / 3] * normal[e % 3]);
            let size = k * depth;
            Some(Push { rest: s.rest, point: s.point, force: size * normal, stiffness, size })
        })
    }

    /// Unit normal out of a tool at `p` at a sample inside of it, and the depth of the sample, m.
    fn into(&self, s: &Near, p: Vec3) -> Option<(Vec3, f64)> {
        let offset = s.point - p;
        let distance = self.shape.distance(offset);
        if distance < 0.0 { self.shape.normal(offset).map(|normal| (normal, -distance)) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Capsule, Cuboid, Plane, Shape, Sphere};
    use nalgebra::UnitQuaternion;
    use std::sync::Arc;

    const RADIUS: f64 = 0.01;

    /// Samples of the plane z = 0, `spacing` apart.
    fn plane(spacing: f64, count: i32) -> Vec<Near> {
        let mut samples = Vec::new();
        for i in -count..count {
            for j in -count..count {
                let point = Vec3::new((f64::from(i) + 0.5) * spacing, (f64::from(j) + 0.5) * spacing, 0.0);
                samples.push(Near {
                    body: 0,
                    point,
                    rest: point,
                    normal: Vec3::zeros(),
                    distance: 0.0,
                    area: spacing * spacing,
                    on: None,
                });
            }
        }
        samples
    }

    #[test]
    fn a_ball_sinks_until_the_layer_balances_the_hand() {
        let ball = OrientedShape::sphere(RADIUS);
        let layer = Layer { shape: &ball, pull: 200.0, stiffness: 1e7 };
        let samples = plane(5e-4, 20);
        let hand = Vec3::new(0.0, 0.0, RADIUS - 2e-3);
        let (p, force) = layer.balance(&samples, Vec3::new(0.0, 0.0, RADIUS), hand, None);
        let pulled = layer.pull * (p[2] - hand[2]);
        assert!((force[2] - pulled).abs() < 1e-9 && force[0].abs() < 1e-9 && force[1].abs() < 1e-9);
        // Winkler's bed, pushes along the radius: F = pi k (R - d) d^2.
        let depth = RADIUS - p[2];
        let winkler = std::f64::consts::PI * layer.stiffness * (RADIUS - depth) * depth * depth;
        assert!((force[2] / winkler - 1.0).abs() < 0.01, "{} {winkler}", force[2]);
        let total: f64 = layer.pushes(&samples, p).map(|push| -push.force[2]).sum();
        assert!((total - force[2]).abs() < 1e-9);
    }

    /// Winkler's bed under each shape at depth d, with pushes along the normals: F = k times the integral of the depth times the normal's z.
    #[test]
    fn each_shape_is_pushed_as_a_winkler_bed_pushes_it() {
        let (k, d, spacing, count) = (1e7, 2e-4, 5e-5, 100);
        let samples = plane(spacing, count);
        let lying = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), std::f64::consts::FRAC_PI_2);
        let upside_down = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
        let (r, length) = (2e-3, 3e-3);
        let h = r - d;
        let a = f64::sqrt(r * r - h * h);
        let cylinder = length * h * (2.0 * r * (a / h).asinh() - 2.0 * a);
        let ball = std::f64::consts::PI * h * d * d;
        let face = (2.0 * f64::from(count) * spacing).powi(2);
        // Within d of a side of the box that side is nearer, and its pushes cancel those of the opposite one.
        let sides = (8e-3 - 2.0 * d) * (6e-3 - 2.0 * d);
        let none = UnitQuaternion::identity();
        let case = |shape: Arc<dyn Shape>, turn, height, integral| {
            let mut shape = OrientedShape::new(shape);
            shape.set_rotation(turn);
            let layer = Layer { shape: &shape, pull: 200.0, stiffness: k };
            let p = Vec3::new(0.0, 0.0, height - d);
            let force: Vec3 = layer.pushes(&samples, p).map(|push| push.force).sum();
            let size: f64 = layer.pushes(&samples, p).map(|push| push.size).sum();
            // The midpoint rule misses the rim of a contact by half a sample all around.
            let rim = 2.0 * spacing / a;
            let off: f64 = -force[2] / (k * integral) - 1.0;
            assert!(off.abs() < rim && force.xy().norm() < 1e-9 * size, "{shape:?}: off by {off}, {force:?}");
        };
        case(Arc::new(Sphere { radius: r }), none, r, ball);
        case(Arc::new(Capsule::new(r, length)), lying, r, cylinder + ball);
        case(Arc::new(Cuboid::new(Vec3::new(8e-3, 6e-3, 6e-3))), none, 3e-3, sides * d);
        case(Arc::new(Plane), upside_down, 0.0, face * d);
    }

    #[test]
    fn along_a_direction_it_leaves_the_others_alone() {
        let ball = OrientedShape::sphere(RADIUS);
        let layer = Layer { shape: &ball, pull: 200.0, stiffness: 1e7 };
        let hand = Vec3::new(0.003, 0.0, RADIUS - 2e-3);
        let (p, _) = layer.balance(&plane(5e-4, 20), Vec3::new(0.001, 0.0, RADIUS), hand, Some(Vec3::z()));
        assert!(p[0] == 0.001 && p[1] == 0.0 && p[2] < RADIUS);
    }
}
