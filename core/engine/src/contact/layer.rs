//! The elastic layer (Winkler bed) between a tool and a solid: distribution of the contact force, and the equilibrium of the tool.
//!
//! A rigid ball in a dimple touches at one point, which jumps from step to step. With a thin elastic layer, each sample of the surface inside
//! the shape is pushed out with the pressure `k d`, d its depth, and the massless tool is where these forces balance the coupling to the hand.
//! The pressure follows from the shapes of both bodies, so a ball on a half-space gives the solution of Hertz (1881). The layer is as stiff as
//! the time step allows: it adds to a node about the stiffness of the body's fastest mode.

use super::near::SurfacePoint;
use crate::shape::OrientedShape;
use nalgebra::Matrix3;
use pliant_solver::Vec3;

/// A tool in contact with the layer.
pub struct Layer<'a> {
    /// Shape of the tool.
    pub shape: &'a OrientedShape,
    /// Stiffness of the coupling to the hand, N/m.
    pub coupling: f64,
    /// Stiffness of the layer per area, N/m^3, times the factor of each sample.
    pub stiffness: f64,
}

/// Contact force of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// Rest position of the sample, m.
    pub rest: Vec3,
    /// Current position of the sample, m.
    pub point: Vec3,
    /// Force on the surface, N.
    pub force: Vec3,
    /// Unit outward normal of the tool at the sample.
    pub normal: Vec3,
    /// Stiffness of the layer at the sample, N/m.
    pub stiffness: f64,
    /// Magnitude of the force, N.
    pub magnitude: f64,
}

/// Largest number of Newton steps to equilibrium.
const MAX_STEPS: usize = 20;
/// Largest depth of a sample, relative to the length scale of the tool: one that came past the tool's centre would be pushed to the other side.
const MAX_DEPTH: f64 = 0.5;
/// Largest number of moves out of the layer to that depth.
const MAX_RETREATS: usize = 8;

impl Layer<'_> {
    /// Newton's method for the equilibrium of the tool between the layer and the spring to `hand` (m), from the position `p` (m); moves along
    /// the unit vector `along` only, if one is given. A tool that is pulled in too deep stays where the layer is half as thick as the tool, however hard
    /// the spring pulls. Returns the position of the tool, m, and the force of the layer on it, N.
    pub fn balance(&self, samples: &[SurfacePoint], mut p: Vec3, hand: Vec3, along: Option<Vec3>) -> (Vec3, Vec3) {
        let (scale, mut out) = (self.shape.shape().length_scale(), along);
        for _ in 0..MAX_STEPS {
            let mut hessian = Matrix3::from_diagonal_element(self.coupling);
            let (mut layer, mut deepest) = (Vec3::zeros(), 0.0_f64);
            for s in samples {
                let Some((n, depth)) = self.penetration(s, p) else { continue };
                let k = self.stiffness_at(s);
                layer -= k * depth * n;
                hessian += k * n * n.transpose();
                deepest = deepest.max(depth);
            }
            out = out.or_else(|| layer.try_normalize(0.0));
            if let Some(out) = out.filter(|_| deepest > MAX_DEPTH * scale) {
                p += (deepest - MAX_DEPTH * scale) * out;
                continue;
            }
            out = along.or_else(|| layer.try_normalize(0.0)).or(out);
            let force = self.coupling * (hand - p) + layer;
            let step = match along {
                Some(d) => d * (d.dot(&force) / d.dot(&(hessian * d))),
                None => hessian.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * force),
            };
            // The Hessian jumps where samples enter or leave the shape; short steps keep it valid.
            let (length, max_length) = (step.norm(), 0.1 * scale);
            p += if length > max_length { step * (max_length / length) } else { step };
            if length <= 1e-9 * scale {
                return (p, layer);
            }
        }
        for _ in 0..MAX_RETREATS {
            let depths = samples.iter().filter_map(|s| self.penetration(s, p));
            let excess = depths.fold(0.0, |deepest: f64, (_, depth)| deepest.max(depth)) - MAX_DEPTH * scale;
            let Some(out) = out.filter(|_| excess > 0.0) else { break };
            p += excess * out;
        }
        (p, self.force(samples, p))
    }

    /// Force of the layer on a tool at `p` (m), N.
    fn force(&self, samples: &[SurfacePoint], p: Vec3) -> Vec3 {
        -self.pushes(samples, p).map(|push| push.force).sum::<Vec3>()
    }

    /// The contact force of each sample inside a tool at `p` (m).
    pub fn pushes<'a>(&'a self, samples: &'a [SurfacePoint], p: Vec3) -> impl Iterator<Item = Push> + 'a {
        samples.iter().filter_map(move |s| {
            let (normal, depth) = self.penetration(s, p)?;
            let k = self.stiffness_at(s);
            let magnitude = k * depth;
            Some(Push { rest: s.rest, point: s.point, force: magnitude * normal, normal, stiffness: k, magnitude })
        })
    }

    /// Sum of the stiffnesses of the samples inside a tool at `p` (m), N/m.
    pub fn total_stiffness(&self, samples: &[SurfacePoint], p: Vec3) -> f64 {
        let inside = samples.iter().filter(|s| self.penetration(s, p).is_some());
        inside.map(|s| self.stiffness_at(s)).sum()
    }

    /// Stiffness of the layer at a sample, N/m.
    fn stiffness_at(&self, s: &SurfacePoint) -> f64 {
        self.stiffness * s.layer_factor * s.area
    }

    /// Unit outward normal of a tool at `p` at a sample inside of it, and the depth of the sample, m; `None` outside.
    fn penetration(&self, s: &SurfacePoint, p: Vec3) -> Option<(Vec3, f64)> {
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
    fn plane(spacing: f64, count: i32) -> Vec<SurfacePoint> {
        let mut samples = Vec::new();
        for i in -count..count {
            for j in -count..count {
                let point = Vec3::new((f64::from(i) + 0.5) * spacing, (f64::from(j) + 0.5) * spacing, 0.0);
                samples.push(SurfacePoint {
                    body: 0,
                    point,
                    rest: point,
                    normal: Vec3::zeros(),
                    distance: 0.0,
                    area: spacing * spacing,
                    layer_factor: 1.0,
                    triangle: None,
                    sample: 0,
                });
            }
        }
        samples
    }

    #[test]
    fn layer_and_coupling_are_in_equilibrium() {
        let ball = OrientedShape::sphere(RADIUS);
        let layer = Layer { shape: &ball, coupling: 200.0, stiffness: 1e7 };
        let samples = plane(5e-4, 20);
        let hand = Vec3::new(0.0, 0.0, RADIUS - 2e-3);
        let (p, force) = layer.balance(&samples, Vec3::new(0.0, 0.0, RADIUS), hand, None);
        let pulled = layer.coupling * (p[2] - hand[2]);
        assert!((force[2] - pulled).abs() < 1e-9 && force[0].abs() < 1e-9 && force[1].abs() < 1e-9);
        // Winkler bed with forces along the radius: F = pi k (R - d) d^2.
        let depth = RADIUS - p[2];
        let winkler = std::f64::consts::PI * layer.stiffness * (RADIUS - depth) * depth * depth;
        assert!((force[2] / winkler - 1.0).abs() < 0.01, "{} {winkler}", force[2]);
        let total: f64 = layer.pushes(&samples, p).map(|push| -push.force[2]).sum();
        assert!((total - force[2]).abs() < 1e-9);
    }

    /// Winkler bed under each shape at depth d, with forces along the normals: F = k times the integral of the depth times the z of the normal.
    #[test]
    fn force_on_each_shape_is_that_of_a_winkler_bed() {
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
        // Within d of a side of the box that side is closer, and its forces cancel those of the opposite side.
        let sides = (8e-3 - 2.0 * d) * (6e-3 - 2.0 * d);
        let none = UnitQuaternion::identity();
        let case = |shape: Arc<dyn Shape>, turn, height, integral| {
            let mut shape = OrientedShape::new(shape);
            shape.set_rotation(turn);
            let layer = Layer { shape: &shape, coupling: 200.0, stiffness: k };
            let p = Vec3::new(0.0, 0.0, height - d);
            let force: Vec3 = layer.pushes(&samples, p).map(|push| push.force).sum();
            let size: f64 = layer.pushes(&samples, p).map(|push| push.magnitude).sum();
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

    /// However hard and from wherever behind the surface the hand pulls, no sample is deeper than half of the tool's length scale.
    #[test]
    fn a_tool_sinks_at_most_half_of_its_size_into_the_layer() {
        let spacing = 5e-4;
        let samples = plane(spacing, 40);
        let shapes: [Arc<dyn Shape>; 3] = [
            Arc::new(Sphere { radius: RADIUS }),
            Arc::new(Capsule::new(RADIUS, RADIUS)),
            Arc::new(Cuboid::new(Vec3::new(0.012, 0.02, 0.016))),
        ];
        for shape in shapes {
            let shape = OrientedShape::new(shape);
            let scale = shape.shape().length_scale();
            for coupling in [1e2, 1e4, 1e6, 1e8] {
                for deep in [1e-4, 5e-3, 0.02, 0.05] {
                    let layer = Layer { shape: &shape, coupling, stiffness: 1e6 };
                    let hand = Vec3::new(1e-3, -2e-3, -deep);
                    for along in [None, Some(Vec3::z())] {
                        let (p, force) = layer.balance(&samples, Vec3::new(0.0, 0.0, scale), hand, along);
                        let depths = samples.iter().filter_map(|s| layer.penetration(s, p)).map(|(_, depth)| depth);
                        let deepest = depths.fold(0.0, f64::max);
                        assert!(deepest <= (MAX_DEPTH + 1e-9) * scale, "{shape:?} {coupling} {deep}: {deepest}");
                        let again = layer.force(&samples, p);
                        assert!(
                            (again - force).norm() <= 1e-9 * force.norm(),
                            "{shape:?}: {force:?} is not that at {p:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn balance_along_a_direction_moves_along_it_only() {
        let ball = OrientedShape::sphere(RADIUS);
        let layer = Layer { shape: &ball, coupling: 200.0, stiffness: 1e7 };
        let hand = Vec3::new(0.003, 0.0, RADIUS - 2e-3);
        let (p, _) = layer.balance(&plane(5e-4, 20), Vec3::new(0.001, 0.0, RADIUS), hand, Some(Vec3::z()));
        assert!(p[0] == 0.001 && p[1] == 0.0 && p[2] < RADIUS);
    }
}
