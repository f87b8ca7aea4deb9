//! Shapes of tools: convex solids with a signed distance function.
//!
//! A shape is one file: a [`Shape`] has distance, normal, support function and size; a [`ShapeKind`] has its name and keys in scene files. A new
//! shape is added by its file and its line in [`KINDS`]; contact with solids and sheets, scenes and help use shapes through these traits alone.

mod capsule;
mod cuboid;
mod oriented;
mod plane;
mod sphere;

pub use capsule::Capsule;
pub use cuboid::Cuboid;
pub use oriented::OrientedShape;
pub use plane::Plane;
pub use sphere::Sphere;

use pliant_mesh::geometry::{Closest, Vec3, closest_point};
use std::fmt;
use std::sync::Arc;

/// Every shape kind, in the order of the help text.
pub static KINDS: &[&dyn ShapeKind] = &[&sphere::Kind, &capsule::Kind, &cuboid::Kind, &plane::Kind];

/// Largest number of Newton steps of [`Shape::first_hit`]; then the point counts as missing the shape.
const MAX_HIT_STEPS: usize = 64;
/// Number of steps of a golden section search along an edge, which reduce the interval to 4e-9 of its length.
const GOLDEN_STEPS: usize = 40;

/// A convex solid in its own axes. Points are relative to its centre, m.
pub trait Shape: fmt::Debug + Send + Sync {
    /// Signed distance of a point from the surface, m, negative inside. It must be exact outside, and a convex function.
    fn distance(&self, p: Vec3) -> f64;

    /// Gradient of the distance: the unit outward normal at the surface point closest to `p`. `None` where it is undefined, as at the centre of a
    /// sphere.
    fn normal(&self, p: Vec3) -> Option<Vec3>;

    /// Support function: the largest `direction . y` over the points y of the shape, m, for a unit vector; may be infinite.
    fn support(&self, direction: Vec3) -> f64;

    /// Axis-aligned bounding box: smallest and largest coordinates, m; may be infinite.
    fn bounds(&self) -> [Vec3; 2];

    /// Points of the shape from which the closest point in the interior of a triangle is found: corners, and centres of rounded corners.
    fn sample_points(&self) -> &[Vec3];

    /// Smallest feature that a mesh must resolve, m: a radius, or half of the smallest side; infinite for a plane.
    fn feature_size(&self) -> f64;

    /// Finite length by which displacements and tolerances are scaled, m: a tool moves by at most half of it between two proximity searches.
    fn length_scale(&self) -> f64 {
        self.feature_size()
    }

    /// Radius of the smallest ball about the centre that contains the shape, m; may be infinite.
    fn bounding_radius(&self) -> f64 {
        let [low, high] = self.bounds();
        low.abs().sup(&high.abs()).norm()
    }

    /// Whether it is invariant under rotations.
    fn is_round(&self) -> bool {
        false
    }

    /// Whether a point is inside of the shape enlarged by `margin` (m).
    fn contains(&self, p: Vec3, margin: f64) -> bool {
        self.distance(p) <= margin
    }

    /// Parameter s, 0 to 1, at which the point `start + s way` enters the shape enlarged by `margin` (all in m); 0 if it starts inside and moves
    /// inwards, `None` if it does not enter. Newton's method along the path: the distance is convex, so it never passes the first hit.
    fn first_hit(&self, start: Vec3, way: Vec3, margin: f64) -> Option<f64> {
        let tolerance = 1e-9 * self.length_scale();
        let mut s = 0.0;
        for _ in 0..MAX_HIT_STEPS {
            let p = start + s * way;
            let gap = self.distance(p) - margin;
            let slope = self.normal(p).map_or(-way.norm(), |n| n.dot(&way));
            // A convex distance that increases along the path never decreases again.
            if slope >= 0.0 {
                return None;
            }
            if gap <= tolerance {
                return Some(s);
            }
            s -= gap / slope;
            if s.is_nan() || s > 1.0 {
                return None;
            }
        }
        None
    }

    /// The point of a triangle closest to the shape; exact up to the golden section search if the triangle is outside.
    fn closest_on_triangle(&self, corners: [Vec3; 3]) -> Closest {
        let mut best: Option<(f64, Closest)> = None;
        let mut consider = |found: Closest| {
            let distance = self.distance(found.point);
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, found));
            }
        };
        for i in 0..3 {
            let mut bary = Vec3::zeros();
            bary[i] = 1.0;
            consider(Closest { point: corners[i], bary });
        }
        for sample in self.sample_points() {
            consider(closest_point(*sample, corners));
        }
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let t = golden_section(|t| self.distance(a + t * (b - a)));
            let mut bary = Vec3::zeros();
            (bary[i], bary[(i + 1) % 3]) = (1.0 - t, t);
            consider(Closest { point: a + t * (b - a), bary });
        }
        best.map_or_else(|| closest_point(Vec3::zeros(), corners), |(_, found)| found)
    }
}

/// Minimiser in [0, 1] of a convex function.
fn golden_section(f: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut a, mut b) = (1.0 - RATIO, RATIO);
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..GOLDEN_STEPS {
        if at_a <= at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - RATIO * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + RATIO * (high - low);
            at_b = f(b);
        }
    }
    0.5 * (low + high)
}

/// Dimensions of a shape in a scene file, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShapeParams {
    /// The key `radius`, of round shapes, m; `None` if it is not given.
    pub radius: Option<f64>,
    /// The key `length`, along the axis of the shape, m; `None` if it is not given.
    pub length: Option<f64>,
    /// The key `size`, along three axes, m; `None` if it is not given.
    pub size: Option<[f64; 3]>,
}

impl ShapeParams {
    /// The given dimensions with their keys.
    fn given(&self) -> impl Iterator<Item = (&'static str, Vec<f64>)> {
        let size = self.size.map(|s| s.to_vec());
        [("radius", self.radius.map(|r| vec![r])), ("length", self.length.map(|l| vec![l])), ("size", size)]
            .into_iter()
            .filter_map(|(key, value)| Some((key, value?)))
    }
}

/// A kind of shape in scene files.
pub trait ShapeKind: Sync {
    /// Name in scene files.
    fn name(&self) -> &'static str;

    /// One-sentence summary, for help and messages.
    fn summary(&self) -> &'static str;

    /// Keys of `shape` that it needs besides `kind`; it may have a `rotation` too.
    fn keys(&self) -> &'static [&'static str];

    /// Builds the shape from its keys, all of which are given, finite and above 0.
    fn build(&self, params: &ShapeParams) -> Arc<dyn Shape>;
}

/// The shape of a kind with these dimensions.
///
/// # Errors
/// Returns a message with the kind, the key and what is allowed, for an unknown kind, a missing key, a key of another kind, or a length that is not
/// finite and above 0.
pub fn build(kind: &str, params: &ShapeParams) -> Result<Arc<dyn Shape>, String> {
    let Some(found) = KINDS.iter().find(|known| known.name() == kind) else {
        let names: Vec<String> = KINDS.iter().map(|known| format!("`{}`", known.name())).collect();
        return Err(format!("shape `{kind}`; allowed is {}", names.join(", ")));
    };
    let keys = || found.keys().iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
    let needs = || if found.keys().is_empty() { "no dimension".to_owned() } else { keys() };
    for (key, value) in params.given() {
        if !found.keys().contains(&key) {
            return Err(format!("`{key}` of a `{kind}`; allowed is {}", needs()));
        }
        if let Some(wrong) = value.iter().find(|v| !(v.is_finite() && **v > 0.0)) {
            return Err(format!("`{key}` of a `{kind}` is {wrong} m; allowed is a finite length above 0"));
        }
    }
    if let Some(missing) = found.keys().iter().find(|key| !params.given().any(|(given, _)| given == **key)) {
        return Err(format!("`{kind}` without `{missing}`; it needs {}", needs()));
    }
    Ok(found.build(params))
}

#[cfg(test)]
mod tests;
