//! Pairs of features that may collide, a vertex with a triangle or an edge with an edge: their distance, and how the four vertices move them apart.
//!
//! Where the closest points are inside of triangle or edges, the derivative of the relative velocity takes the turning of the common normal
//! into account. It vanishes for every rigid motion of the four vertices, so an impulse along any direction conserves linear and angular momentum,
//! though the two points on which it acts are a gap apart.

use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// Kind of a pair of features.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The first vertex and the triangle of the other three.
    VertexTriangle,
    /// The edge of the first two and that of the last two.
    EdgeEdge,
}

/// The closest points of two features.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    /// Their distance, m.
    pub distance: f64,
    /// Unit vector along which they part: towards the vertex, or from the first edge to the second. Zero if they touch in a point without a normal.
    pub normal: Vec3,
    /// Weights of the four vertices in the vector from the one closest point to the other; they add up to 0.
    pub weights: [f64; 4],
    /// For a turn of the normal: coefficient of each vertex's velocity along the normal, 1/m; zero where a closest point is on a border.
    pub turn: [Vec3; 4],
    /// Whether both closest points are inside of triangle or edges, and edges are not parallel.
    pub is_inside: bool,
}

/// Least squared sine of the angle of two edges that are not parallel.
const PARALLEL: f64 = 1e-4;
/// Barycentric coordinate from which on a point is inside.
const INSIDE: f64 = 1e-9;

/// The closest points of two features with vertices at `x` (m).
pub(super) fn gap(kind: Kind, x: &[Vec3; 4]) -> Gap {
    match kind {
        Kind::VertexTriangle => of_vertex(x),
        Kind::EdgeEdge => of_edges(x),
    }
}

fn of_vertex(&[p, a, b, c]: &[Vec3; 4]) -> Gap {
    let closest = closest_point(p, [a, b, c]);
    let bary = closest.bary;
    let apart = p - closest.point;
    let weights = [1.0, -bary[0], -bary[1], -bary[2]];
    let area = (b - a).cross(&(c - a));
    let squared = area.norm_squared();
    if bary.min() > INSIDE && squared > 0.0 {
        let side = if area.dot(&apart) < 0.0 { -1.0 } else { 1.0 };
        let normal = side / squared.sqrt() * area;
        // Gradients of the barycentric coordinates in the plane.
        let gradient = |from: Vec3, to: Vec3| area.cross(&(to - from)) / squared;
        let turn = [Vec3::zeros(), gradient(b, c), gradient(c, a), gradient(a, b)];
        return Gap { distance: apart.dot(&normal).abs(), normal, weights, turn, is_inside: true };
    }
    on_border(apart, weights)
}

fn of_edges(&[a, b, c, d]: &[Vec3; 4]) -> Gap {
    let (u, v) = (b - a, d - c);
    let (s, t) = closest_on_segments(a, u, c, v);
    let apart = (c + t * v) - (a + s * u);
    let weights = [s - 1.0, -s, 1.0 - t, t];
    let cross = u.cross(&v);
    let squared = cross.norm_squared();
    let inside = |f: f64| f > INSIDE && f < 1.0 - INSIDE;
    if inside(s) && inside(t) && squared > PARALLEL * u.norm_squared() * v.norm_squared() {
        let side = if cross.dot(&apart) < 0.0 { -1.0 } else { 1.0 };
        let normal = side / squared.sqrt() * cross;
        // The vectors in the common plane that are dual to the two edges.
        let (of_u, of_v) = (v.cross(&cross) / squared, cross.cross(&u) / squared);
        return Gap {
            distance: apart.dot(&normal).abs(),
            normal,
            weights,
            turn: [-of_u, of_u, -of_v, of_v],
            is_inside: true,
        };
    }
    on_border(apart, weights)
}

fn on_border(apart: Vec3, weights: [f64; 4]) -> Gap {
    let distance = apart.norm();
    let normal = if distance > 0.0 { apart / distance } else { Vec3::zeros() };
    Gap { distance, normal, weights, turn: [Vec3::zeros(); 4], is_inside: false }
}

/// Parameters, 0 to 1, of the closest points of the segments `a + s u` and `c + t v`.
fn closest_on_segments(a: Vec3, u: Vec3, c: Vec3, v: Vec3) -> (f64, f64) {
    let w = c - a;
    let (uu, uv, vv, uw, vw) = (u.norm_squared(), u.dot(&v), v.norm_squared(), u.dot(&w), v.dot(&w));
    let unit = |f: f64| if f.is_finite() { f.clamp(0.0, 1.0) } else { 0.0 };
    let determinant = uu * vv - uv * uv;
    let s = if determinant > 1e-14 * uu * vv { unit((uw * vv - vw * uv) / determinant) } else { 0.0 };
    let t = (s * uv - vw) / vv;
    if (0.0..=1.0).contains(&t) {
        return (s, t);
    }
    let t = unit(t);
    (unit((t * uv + uw) / uu), t)
}

/// Fraction of a step at which features that move in straight lines from `from` to `to` (m) come as close as `least` (m), or as half of their distance at
/// the start if that is less; `None` if they do not. It is not later than that moment (additive continuous collision detection: Li, Kaufman and Jiang
/// 2021), so features that stop there have not touched.
pub(super) fn time_of_impact(kind: Kind, from: &[Vec3; 4], to: &[Vec3; 4], least: f64) -> Option<f64> {
    let mean = (0..4).map(|i| to[i] - from[i]).sum::<Vec3>() / 4.0;
    let motion: [f64; 4] = std::array::from_fn(|i| (to[i] - from[i] - mean).norm());
    let fastest = match kind {
        Kind::VertexTriangle => motion[0] + motion[1].max(motion[2]).max(motion[3]),
        Kind::EdgeEdge => motion[0].max(motion[1]) + motion[2].max(motion[3]),
    };
    let start = gap(kind, from).distance;
    let least = least.min(0.5 * start);
    if start - fastest > least {
        return None;
    }
    let (mut time, mut distance) = (0.0, start);
    for _ in 0..MAX_ADVANCES {
        time += (distance - least) / fastest;
        if time.is_nan() || time >= 1.0 {
            return None;
        }
        let x = std::array::from_fn(|i| from[i] + time * (to[i] - from[i]));
        distance = gap(kind, &x).distance;
        if distance <= (1.0 + CLOSE) * least {
            return Some(time);
        }
    }
    Some(time)
}

/// Most advances towards an impact; where there are more, features graze each other and count as meeting.
const MAX_ADVANCES: usize = 100;
/// How close to the least distance counts as there, relative to it.
const CLOSE: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::testing::Random;

    fn four(random: &mut Random) -> [Vec3; 4] {
        std::array::from_fn(|_| random.vector())
    }

    #[test]
    fn distances_are_those_of_sampled_points() {
        let mut random = Random(5);
        for _ in 0..300 {
            let x = four(&mut random);
            for kind in [Kind::VertexTriangle, Kind::EdgeEdge] {
                let found = gap(kind, &x);
                let apart = (0..4).map(|i| found.weights[i] * x[i]).sum::<Vec3>();
                assert!((apart - found.distance * found.normal).norm() < 1e-9, "{kind:?} {found:?}");
                let mut least = f64::INFINITY;
                for i in 0..=40 {
                    for j in 0..=40 {
                        let (s, t) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                        let apart = match kind {
                            Kind::VertexTriangle if s + t <= 1.0 => {
                                x[0] - (x[1] + s * (x[2] - x[1]) + t * (x[3] - x[1]))
                            }
                            Kind::VertexTriangle => continue,
                            Kind::EdgeEdge => x[2] + t * (x[3] - x[2]) - x[0] - s * (x[1] - x[0]),
                        };
                        least = least.min(apart.norm());
                    }
                }
                assert!(found.distance <= least + 1e-12 && found.distance > least - 0.1, "{kind:?} {found:?} {least}");
            }
        }
    }

    #[test]
    fn a_rigid_motion_moves_nothing_apart() {
        let mut random = Random(6);
        let mut inside = [0; 2];
        for _ in 0..400 {
            let x = four(&mut random);
            let (linear, angular) = (random.vector(), random.vector());
            for (kind, inside) in [Kind::VertexTriangle, Kind::EdgeEdge].into_iter().zip(&mut inside) {
                let found = gap(kind, &x);
                if !found.is_inside {
                    continue;
                }
                *inside += 1;
                let v = x.map(|x| linear + angular.cross(&x));
                let turn: Vec3 = (0..4).map(|i| found.normal.dot(&v[i]) * found.turn[i]).sum();
                let relative = (0..4).map(|i| found.weights[i] * v[i]).sum::<Vec3>() + found.distance * turn;
                assert!(relative.norm() < 1e-9 * (1.0 + turn.norm()), "{kind:?} {relative:?}");
            }
        }
        assert!(inside[0] > 20 && inside[1] > 20, "{inside:?}");
    }

    #[test]
    fn an_impact_is_found_before_it_happens_and_no_other() {
        let mut random = Random(7);
        let mut met = 0;
        for _ in 0..2000 {
            let (from, kind) = (four(&mut random), random.pick(&[Kind::VertexTriangle, Kind::EdgeEdge]));
            let to = from.map(|x| x + 0.7 * random.vector());
            let at = |t: f64| -> [Vec3; 4] { std::array::from_fn(|i| from[i] + t * (to[i] - from[i])) };
            let start = gap(kind, &from).distance;
            let least = 0.05_f64.min(0.5 * start);
            let until = time_of_impact(kind, &from, &to, 0.05);
            met += u32::from(until.is_some());
            let end = until.unwrap_or(1.0);
            for i in 0..=200 {
                let distance = gap(kind, &at(end * f64::from(i) / 200.0)).distance;
                assert!(distance >= least * (1.0 - 1e-9), "{kind:?}: {distance} below {least} at {i} of {end}");
            }
            // Of features that graze each other the last advance may be one away from there.
            if until.is_some() && start > 0.1 {
                assert!(gap(kind, &at(end)).distance <= 3.0 * least, "{kind:?}: stopped for nothing");
            }
        }
        assert!(met > 100, "{met}");
    }
}
