//! Error message for a ray that should place a hand and hits no body: its distance from the surface and the closest point.

use pliant_mesh::Surface;
use pliant_mesh::geometry::{Vec3, closest_point};

/// A ray that should place a hand.
pub(super) struct Ray {
    /// Start of the ray, m.
    pub(super) origin: Vec3,
    /// Direction, not normalised.
    pub(super) direction: Vec3,
}

/// The closest approach of a ray to a surface.
#[derive(Clone, Copy)]
struct Miss {
    /// Distance between the ray and the surface, m.
    distance: f64,
    /// Point of the surface, m.
    point: Vec3,
}

/// Explains why `ray` does not hit `surface`. Coordinates in the message are relative to the bounding box, 0 to 1 along each axis.
pub(super) fn reason(surface: &Surface, ray: &Ray) -> String {
    let bounds = surface.bounds();
    let extent = bounds.max - bounds.min;
    let flat: Vec<&str> =
        ["x", "y", "z"].into_iter().zip(extent.iter()).filter(|(_, e)| **e == 0.0).map(|(a, _)| a).collect();
    let mut parts = Vec::new();
    if !ray.origin.iter().chain(ray.direction.iter()).all(|c| c.is_finite()) {
        parts.push("it is not finite".to_owned());
    } else if ray.direction.norm() == 0.0 {
        parts.push("it has no length".to_owned());
    } else if let Some(miss) = nearest_miss(surface, ray) {
        let at = (0..3).map(|i| if extent[i] == 0.0 { 0.0 } else { (miss.point[i] - bounds.min[i]) / extent[i] });
        let at: Vec<String> = at.map(|c| format!("{c:.3}")).collect();
        // Relative rounding error of the distance between a ray and a plane that contains it.
        if miss.distance <= 1e-9 * bounds.longest_edge() {
            parts.push(format!("it runs along the surface at [{}] of the box", at.join(", ")));
        } else {
            parts.push(format!("its nearest miss is {:.3e} m, at [{}] of the box", miss.distance, at.join(", ")));
        }
    }
    if !flat.is_empty() {
        let axes = flat.join(" and ");
        parts.push(format!(
            "the box has no thickness along {axes}, so `from` and `toward` cannot differ in {axes}; `origin` and `rotation` can stand off it"
        ));
    }
    parts.join("; ")
}

/// The closest approach of a ray that hits no triangle: at an edge of a triangle or at the origin of the ray. `None` if the ray is not finite or the
/// surface has no triangles.
fn nearest_miss(surface: &Surface, ray: &Ray) -> Option<Miss> {
    let mut nearest: Option<Miss> = None;
    let mut consider = |point: Vec3, from: Vec3| {
        let distance = (point - from).norm();
        if distance.is_finite() && nearest.is_none_or(|n| distance < n.distance) {
            nearest = Some(Miss { distance, point });
        }
    };
    for triangle in &surface.triangles {
        let corners = triangle.map(|v| surface.points[v as usize]);
        consider(closest_point(ray.origin, corners).point, ray.origin);
        for i in 0..3 {
            let (point, time) = closest_of_edge(corners[i], corners[(i + 1) % 3], ray);
            consider(point, ray.origin + time * ray.direction);
        }
    }
    nearest
}

/// The point of the segment from `a` to `b` that is closest to a ray, and the parameter of the ray's closest point (Ericson 2005, section 5.1.9, with one
/// infinite segment). The direction of the ray must not be zero.
fn closest_of_edge(a: Vec3, b: Vec3, ray: &Ray) -> (Vec3, f64) {
    let (edge, direction, between) = (b - a, ray.direction, a - ray.origin);
    let (ee, dd, ed) = (edge.dot(&edge), direction.dot(&direction), edge.dot(&direction));
    let (eb, db) = (edge.dot(&between), direction.dot(&between));
    let on_edge = |time: f64| if ee > 0.0 { ((time * ed - eb) / ee).clamp(0.0, 1.0) } else { 0.0 };
    let along = |share: f64| ((db + share * ed) / dd).max(0.0);
    let det = ee * dd - ed * ed;
    let share = if det > 0.0 { ((ed * db - dd * eb) / det).clamp(0.0, 1.0) } else { 0.0 };
    let time = along(share);
    let share = on_edge(time);
    (a + share * edge, along(share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::generate;

    #[test]
    fn no_sampled_point_of_the_surface_is_closer_to_the_ray() {
        let surface = Surface::from_document(&generate::sphere(5, 0.05).expect("a sphere"));
        let mut misses = 0;
        for i in 0..200 {
            let f = |k: f64| 0.2 * (f64::from(i) * k).sin();
            let ray = Ray { origin: Vec3::new(f(1.3), f(2.7), f(0.9)), direction: Vec3::new(f(3.1), f(0.7), f(1.9)) };
            if pliant_mesh::geometry::cast(&surface.points, &surface.triangles, ray.origin, ray.direction).is_some()
                || ray.direction.norm() == 0.0
            {
                continue;
            }
            misses += 1;
            let found = nearest_miss(&surface, &ray).expect("a finite ray");
            let to_ray = |p: Vec3| {
                let time = ((p - ray.origin).dot(&ray.direction) / ray.direction.norm_squared()).max(0.0);
                (p - ray.origin - time * ray.direction).norm()
            };
            assert!((to_ray(found.point) - found.distance).abs() < 1e-12);
            for triangle in &surface.triangles {
                let [a, b, c] = triangle.map(|v| surface.points[v as usize]);
                for (u, v) in (0..=6).flat_map(|u| (0..=6 - u).map(move |v| (f64::from(u) / 6.0, f64::from(v) / 6.0))) {
                    assert!(to_ray(a + u * (b - a) + v * (c - a)) >= found.distance - 1e-12, "ray {i}");
                }
            }
        }
        assert!(misses > 50, "{misses}");
    }
}
