//! A cube that turns with the view: a click on a face looks at the scene from there.

use eframe::egui::{Vec2, vec2};
use nalgebra::Vector3;

/// A face of the cube that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeFace {
    /// Axis of its normal: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Whether its normal is against the axis.
    pub is_negative: bool,
    /// Cosine of the angle between its normal and the direction towards the viewer, above 0.
    pub facing: f32,
    /// Its corners from the middle of the cube, points of the screen, around it.
    pub corners: [Vec2; 4],
}

/// The faces of a cube that are seen, without perspective, where the camera has these axes (right, up, towards the viewer). `half`: half an edge, points.
pub fn visible_faces([right, up, back]: [Vector3<f64>; 3], half: f32) -> Vec<CubeFace> {
    let on_screen = |p: Vector3<f64>| half * vec2(p.dot(&right) as f32, -p.dot(&up) as f32);
    let face = |(axis, is_negative): (usize, bool)| {
        let mut normal = Vector3::zeros();
        normal[axis] = if is_negative { -1.0 } else { 1.0 };
        let facing = normal.dot(&back) as f32;
        let mut along = [Vector3::zeros(); 2];
        (along[0][(axis + 1) % 3], along[1][(axis + 2) % 3]) = (1.0, 1.0);
        let corner = |u: f64, v: f64| on_screen(normal + u * along[0] + v * along[1]);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        (facing > EDGE_ON).then_some(CubeFace { axis, is_negative, facing, corners })
    };
    (0..3).flat_map(|axis| [(axis, false), (axis, true)]).filter_map(face).collect()
}

/// Cosine below which a face is a line.
const EDGE_ON: f32 = 0.02;

impl CubeFace {
    /// Whether a place (points from the middle of the cube) is on the face.
    pub fn contains(&self, at: Vec2) -> bool {
        let side = |i: usize| {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % 4]);
            (b - a).rot90().dot(at - a)
        };
        let sides = [0, 1, 2, 3].map(side);
        sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
    }

    /// The normal in axes of the scene.
    pub fn normal(&self) -> Vector3<f64> {
        let mut normal = Vector3::zeros();
        normal[self.axis] = if self.is_negative { -1.0 } else { 1.0 };
        normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    #[test]
    fn the_face_under_a_place_is_the_one_that_a_ray_there_meets_first() {
        let mut camera = Camera::default();
        for turn in 0..40 {
            camera.orbit(0.37 + 0.01 * f64::from(turn), 0.11);
            let axes = camera.axes();
            let faces = visible_faces(axes, 20.0);
            assert!((1..=3).contains(&faces.len()), "{faces:?}");
            for (x, y) in (-6..=6).flat_map(|x| (-6..=6).map(move |y| (5.0 * x as f32, 5.0 * y as f32))) {
                let under: Vec<_> = faces.iter().filter(|face| face.contains(vec2(x, y))).collect();
                // A ray towards the cube from far in front of the picture, in units of half an edge.
                let origin = f64::from(x) / 20.0 * axes[0] - f64::from(y) / 20.0 * axes[1] + 10.0 * axes[2];
                let slab = |axis: usize| {
                    let ends = [-1.0, 1.0].map(|side| (side - origin[axis]) / -axes[2][axis]);
                    [ends[0].min(ends[1]), ends[0].max(ends[1])]
                };
                let slabs = [0, 1, 2].map(slab);
                let near = (0..3).max_by(|a, b| slabs[*a][0].total_cmp(&slabs[*b][0])).expect("three");
                let far = slabs.iter().map(|slab| slab[1]).fold(f64::INFINITY, f64::min);
                let margin = slabs[near][0] - far;
                if margin.abs() < 1e-3 || axes[2][near].abs() < f64::from(1.5 * EDGE_ON) {
                    continue; // on the outline, or on a face that is a line
                }
                assert_eq!(under.is_empty(), margin > 0.0, "at {x}, {y}: {under:?}");
                let meets = under.iter().any(|face| face.axis == near && face.is_negative == (axes[2][near] < 0.0));
                assert!(under.is_empty() || meets, "at {x}, {y}: axis {near}, {under:?}");
            }
        }
    }
}
