//! The soft layer between a ball and a surface: how a touch is spread, and where the ball comes to rest in it.
//!
//! A ball in a dimple of facets touches at one corner now and at another the next moment. A thin elastic layer takes that
//! away: each sample of the surface inside the ball is pushed out by `k d`, d its depth, and the massless ball stands where
//! those pushes balance the pull of the hand. Its pressure follows the shape of both bodies, so a ball on a half-space comes
//! out as Hertz (1881) has it. The layer is as stiff as the step bears: its springs add to a node's stiffness no more than
//! the fastest mode of the body already has.

use super::near::Near;
use crate::body::weigh;
use crate::step::{Block, V3, axpy, dot};
use nalgebra::{Matrix3, Vector3};

/// Samples of the surface around a ball.
#[derive(Debug, Default)]
pub struct Layer {
    samples: Vec<Sample>,
}

/// A sample of the surface.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Place among the near triangles.
    pub near: usize,
    /// Where on the triangle.
    pub bary: V3,
    /// m
    at: V3,
    /// N/m
    stiffness: f64,
}

/// What a sample does.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// The sample.
    pub sample: Sample,
    /// N, on the surface
    pub force: V3,
    /// N/m, of the force against moving the sample
    pub stiffness: Block,
    /// N, its size
    pub size: f64,
}

/// Distance, in radii, up to which a triangle may come to lie inside the ball as it sinks.
const REACH: f64 = 1.5;
/// Newton steps to balance, at most.
const STEPS: usize = 20;
/// Sub-triangles along an edge, at most.
const MOST_PARTS: usize = 16;

impl Layer {
    /// Samples the triangles that face `p` from the side of `normal`, as finely as the grid can follow: `edge` (m) apart.
    /// `stiffness` is N/m for a m^2.
    pub fn sample(&mut self, near: &[Near], p: V3, radius: f64, normal: V3, edge: f64, stiffness: f64) {
        self.samples.clear();
        for (index, n) in near.iter().enumerate() {
            if n.distance > REACH * radius {
                continue;
            }
            let [a, b, c] = n.corners.map(Vector3::from);
            let cross = (b - a).cross(&(c - a));
            // The far side of a thin part is within the ball too, and is not touched.
            let faces = |q: V3| {
                let out = axpy(p, -1.0, q);
                let sign = cross.dot(&Vector3::from(out)) * cross.dot(&Vector3::from(normal));
                sign > 0.0 && dot(out, normal) > 0.0
            };
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            let parts = ((longest / edge).ceil() as usize).clamp(1, MOST_PARTS);
            let share = 0.5 * cross.norm() * stiffness / (parts * parts) as f64;
            for bary in centres(parts) {
                let at = weigh(n.corners, bary);
                if faces(at) {
                    self.samples.push(Sample { near: index, bary, at, stiffness: share });
                }
            }
        }
    }

    /// Where a ball at `p` comes to rest between the layer and a spring of `pull` (N/m) to `hand`; along one direction only,
    /// if one is given. Gives its place and the force of the layer on it, N.
    pub fn balance(&self, p: V3, radius: f64, hand: V3, pull: f64, along: Option<V3>) -> (V3, V3) {
        let mut p = Vector3::from(p);
        let hand = Vector3::from(hand);
        let mut layer = Vector3::zeros();
        for _ in 0..STEPS {
            let mut hessian = Matrix3::from_diagonal_element(pull);
            layer = Vector3::zeros();
            for s in &self.samples {
                let Some((n, depth)) = into(s, p, radius) else { continue };
                layer -= s.stiffness * depth * n;
                hessian += s.stiffness * n * n.transpose();
            }
            let force = pull * (hand - p) + layer;
            let step = match along.map(Vector3::from) {
                Some(d) => d * (d.dot(&force) / (d.dot(&(hessian * d)))),
                None => hessian.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * force),
            };
            // A sample that is let in or out changes the slope: short moves keep to it.
            let length = step.norm();
            let most = 0.1 * radius;
            p += if length > most { step * (most / length) } else { step };
            if length <= 1e-9 * radius {
                break;
            }
        }
        (p.into(), layer.into())
    }

    /// What each sample inside a ball at `p` does.
    pub fn pushes(&self, p: V3, radius: f64) -> impl Iterator<Item = Push> + '_ {
        let p = Vector3::from(p);
        self.samples.iter().filter_map(move |s| {
            let (n, depth) = into(s, p, radius)?;
            let size = s.stiffness * depth;
            let normal: V3 = n.into();
            let stiffness = std::array::from_fn(|e| s.stiffness * normal[e / 3] * normal[e % 3]);
            Some(Push { sample: *s, force: normal.map(|c| size * c), stiffness, size })
        })
    }
}

/// Direction from the ball to a sample, and how far inside the ball it is.
fn into(s: &Sample, p: Vector3<f64>, radius: f64) -> Option<(Vector3<f64>, f64)> {
    let out = Vector3::from(s.at) - p;
    let distance = out.norm();
    (distance < radius && distance > 1e-12).then(|| (out / distance, radius - distance))
}

/// Weights of the middles of the `parts * parts` equal triangles a triangle can be cut into.
fn centres(parts: usize) -> impl Iterator<Item = V3> {
    let n = parts as f64;
    (0..parts).flat_map(move |i| {
        (0..parts - i).flat_map(move |j| {
            let (u, v) = (i as f64, j as f64);
            let point = move |du: f64, dv: f64| {
                let (u, v) = ((u + du) / n, (v + dv) / n);
                [1.0 - u - v, u, v]
            };
            let upright = Some(point(1.0 / 3.0, 1.0 / 3.0));
            let inverted = (i + j + 1 < parts).then(|| point(2.0 / 3.0, 2.0 / 3.0));
            upright.into_iter().chain(inverted)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Closest;

    #[test]
    fn the_parts_of_a_triangle_are_all_there_and_their_middles_average_to_its_own() {
        for parts in 1..6 {
            let list: Vec<V3> = centres(parts).collect();
            assert_eq!(list.len(), parts * parts);
            for c in 0..3 {
                let mean = list.iter().map(|b| b[c]).sum::<f64>() / list.len() as f64;
                assert!((mean - 1.0 / 3.0).abs() < 1e-12);
            }
        }
    }

    /// A plane at z = 0 of one large triangle pair, and a ball above it.
    fn plane(size: f64) -> Vec<Near> {
        let q = [[-size, -size, 0.0], [size, -size, 0.0], [size, size, 0.0], [-size, size, 0.0]];
        let closest = Closest { point: [0.0; 3], bary: [1.0, 0.0, 0.0] };
        [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]
            .into_iter()
            .map(|corners| Near { body: 0, triangle: 0, corners, closest, distance: 0.0 })
            .collect()
    }

    #[test]
    fn a_ball_sinks_until_the_layer_balances_the_hand() {
        let (radius, stiffness, pull) = (0.01, 1e7, 200.0);
        let mut layer = Layer::default();
        layer.sample(&plane(0.02), [0.0, 0.0, radius], radius, [0.0, 0.0, 1.0], 2e-3, stiffness);
        let hand = [0.0, 0.0, radius - 2e-3];
        let (p, force) = layer.balance([0.0, 0.0, radius], radius, hand, pull, None);
        let pulled = pull * (p[2] - hand[2]);
        assert!((force[2] - pulled).abs() < 1e-9 && force[0].abs() < 1e-9 && force[1].abs() < 1e-9);
        // Winkler's bed: F = pi k R d^2 for d much smaller than R.
        let depth = radius - p[2];
        let winkler = std::f64::consts::PI * stiffness * radius * depth * depth;
        assert!((force[2] / winkler - 1.0).abs() < 0.15, "{} {winkler}", force[2]);
        let total: f64 = layer.pushes(p, radius).map(|push| -push.force[2]).sum();
        assert!((total - force[2]).abs() < 1e-9);
    }

    #[test]
    fn a_triangle_seen_from_behind_is_not_touched() {
        let mut layer = Layer::default();
        layer.sample(&plane(0.02), [0.0, 0.0, -0.005], 0.01, [0.0, 0.0, 1.0], 2e-3, 1e7);
        assert_eq!(layer.pushes([0.0, 0.0, -0.005], 0.01).count(), 0);
    }
}
