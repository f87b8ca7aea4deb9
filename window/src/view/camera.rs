//! The camera: orbits a target, in perspective or orthographic, with a pair of off-axis eyes for stereo.

use nalgebra::{Matrix4, Point3, Vector3};

/// How depth is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Far things are small.
    Perspective,
    /// Parallel lines stay parallel.
    Orthographic,
}

/// Which axis of the scene points up on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpAxis {
    /// As OBJ files of most modelers have it.
    Y,
    /// As CAD programs have it.
    Z,
}

/// One of the eyes that look at the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Eye {
    /// The only one.
    Both,
    /// The left one of a pair.
    Left,
    /// The right one of a pair.
    Right,
}

/// A half-line in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Point from which the ray starts, m.
    pub origin: Point3<f64>,
    /// Unit vector along the ray.
    pub direction: Vector3<f64>,
}

/// A camera that looks at a target from a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// m, what it looks at and turns about
    pub target: Point3<f64>,
    /// m, from the target
    pub distance: f64,
    /// rad, turn about the up axis; 0 looks along -z (y up) or +y (z up)
    pub yaw: f64,
    /// rad, height above the horizon, -pi/2 to pi/2
    pub pitch: f64,
    /// How depth is shown.
    pub projection: Projection,
    /// Which axis points up.
    pub up: UpAxis,
    /// rad, vertical angle of view in perspective; in orthographic the picture is as large at the target
    pub field_of_view: f64,
    /// m, radius of what there is to see around the target: sets the depth range
    pub scene_radius: f64,
}

/// Distance between the eyes over the distance of the target: 1/30, the usual limit for comfort.
const EYE_SEPARATION: f64 = 1.0 / 30.0;
/// rad, half a degree short of straight up or down, where yaw would turn the picture in its plane.
const MAX_PITCH: f64 = std::f64::consts::FRAC_PI_2 - 0.0087;

impl Default for Camera {
    fn default() -> Self {
        Self {
            target: Point3::origin(),
            distance: 0.3,
            yaw: 0.6,
            pitch: 0.35,
            projection: Projection::Perspective,
            up: UpAxis::Y,
            field_of_view: 35_f64.to_radians(),
            scene_radius: 0.1,
        }
    }
}

impl Camera {
    /// Unit vectors of the picture in the scene: right, up, and back towards the viewer.
    pub fn axes(&self) -> [Vector3<f64>; 3] {
        let (sy, cy) = self.yaw.sin_cos();
        let (sp, cp) = self.pitch.sin_cos();
        // In axes with y up: z is back at yaw 0.
        let back = Vector3::new(cp * sy, sp, cp * cy);
        let right = Vector3::new(cy, 0.0, -sy);
        let up = back.cross(&right);
        [right, up, back].map(|v| self.to_scene(v))
    }

    /// A direction in axes with y up, in the axes of the scene.
    pub(crate) fn to_scene(self, v: Vector3<f64>) -> Vector3<f64> {
        match self.up {
            UpAxis::Y => v,
            UpAxis::Z => Vector3::new(v.x, -v.z, v.y),
        }
    }

    /// Unit vector of the scene that points up.
    pub fn up_direction(&self) -> Vector3<f64> {
        self.to_scene(Vector3::y())
    }

    /// m, where the camera is
    pub fn position(&self) -> Point3<f64> {
        self.target + self.distance * self.axes()[2]
    }

    /// Follows a scene that becomes larger by a factor about its origin: the picture of it stays the same.
    pub fn scale(&mut self, factor: f64) {
        self.target *= factor;
        self.distance *= factor;
        self.scene_radius *= factor;
    }

    /// m, half the height of what is seen at the distance of the target
    pub fn half_height(&self) -> f64 {
        self.distance * (0.5 * self.field_of_view).tan()
    }

    /// m of the scene at the distance of the target for a pixel of a picture `height` pixels high
    pub fn metres_per_pixel(&self, height: f64) -> f64 {
        2.0 * self.half_height() / height.max(1.0)
    }

    /// Sideways shift of an eye, m.
    fn eye_offset(&self, eye: Eye) -> f64 {
        let half = 0.5 * EYE_SEPARATION * self.distance;
        match eye {
            Eye::Both => 0.0,
            Eye::Left => -half,
            Eye::Right => half,
        }
    }

    /// From scene to eye axes: x right, y up, z towards the viewer.
    pub fn view_matrix(&self, eye: Eye) -> Matrix4<f64> {
        let [right, up, back] = self.axes();
        let position = self.position() + self.eye_offset(eye) * right;
        let row = |axis: Vector3<f64>| [axis.x, axis.y, axis.z, -axis.dot(&position.coords)];
        let [r, u, b] = [row(right), row(up), row(back)];
        Matrix4::new(r[0], r[1], r[2], r[3], u[0], u[1], u[2], u[3], b[0], b[1], b[2], b[3], 0.0, 0.0, 0.0, 1.0)
    }

    /// m, nearest and farthest depth that is drawn
    fn depth_range(&self) -> (f64, f64) {
        let reach = self.scene_radius.max(1e-9);
        match self.projection {
            Projection::Perspective => ((self.distance - reach).max(0.02 * self.distance), self.distance + 4.0 * reach),
            Projection::Orthographic => (self.distance - 4.0 * reach, self.distance + 4.0 * reach),
        }
    }

    /// From eye axes to clip space, for a picture of `aspect` = width / height. The eyes of a pair meet at the target.
    pub fn projection_matrix(&self, aspect: f64, eye: Eye) -> Matrix4<f64> {
        let (near, far) = self.depth_range();
        let (half_height, distance) = (self.half_height(), self.distance);
        let half_width = half_height * aspect;
        let offset = self.eye_offset(eye);
        let mut m = Matrix4::zeros();
        match self.projection {
            Projection::Perspective => {
                m[(0, 0)] = distance / half_width;
                m[(1, 1)] = distance / half_height;
                m[(0, 2)] = -offset / half_width;
                m[(2, 2)] = -(far + near) / (far - near);
                m[(2, 3)] = -2.0 * far * near / (far - near);
                m[(3, 2)] = -1.0;
            }
            Projection::Orthographic => {
                // A sheared parallel projection: what is at the target stays where it is for both eyes.
                m[(0, 0)] = 1.0 / half_width;
                m[(1, 1)] = 1.0 / half_height;
                m[(0, 2)] = -offset / (half_width * distance);
                m[(2, 2)] = -2.0 / (far - near);
                m[(2, 3)] = -(far + near) / (far - near);
                m[(3, 3)] = 1.0;
            }
        }
        m
    }

    /// The ray through a place of the picture: -1 to 1 from left to right and from bottom to top.
    pub fn ray(&self, place: [f64; 2], aspect: f64) -> Ray {
        let [right, up, back] = self.axes();
        let half = self.half_height();
        let aside = place[0] * half * aspect * right + place[1] * half * up;
        match self.projection {
            Projection::Perspective => {
                let origin = self.position();
                Ray { origin, direction: (self.target + aside - origin).normalize() }
            }
            Projection::Orthographic => {
                let start = self.distance.max(4.0 * self.scene_radius);
                Ray { origin: self.target + aside + start * back, direction: -back }
            }
        }
    }

    /// Where a point of the scene is in the picture (as for [`Camera::ray`]), and its depth in front of the camera, m.
    /// `None` behind a perspective camera.
    pub fn project(&self, point: &Point3<f64>, aspect: f64) -> Option<([f64; 2], f64)> {
        let eye = self.view_matrix(Eye::Both) * point.to_homogeneous();
        let depth = -eye.z;
        if self.projection == Projection::Perspective && depth <= 0.0 {
            return None;
        }
        let clip = self.projection_matrix(aspect, Eye::Both) * eye;
        Some(([clip.x / clip.w, clip.y / clip.w], depth))
    }

    /// Turns about the target by a move of the pointer, in fractions of the picture's height.
    pub fn orbit(&mut self, across: f64, up: f64) {
        const TURN: f64 = std::f64::consts::PI; // for a move over the whole picture
        self.yaw = (self.yaw - TURN * across).rem_euclid(std::f64::consts::TAU);
        self.pitch = (self.pitch + TURN * up).clamp(-MAX_PITCH, MAX_PITCH);
    }

    /// Moves so that what is at the target's depth follows the pointer, in fractions of the picture's height.
    pub fn pan(&mut self, across: f64, up: f64) {
        let [right, upwards, _] = self.axes();
        let height = 2.0 * self.half_height();
        self.target -= height * (across * right + up * upwards);
    }

    /// Comes nearer by a factor (below 1: nearer), so that what is at the place of the picture stays there.
    pub fn zoom(&mut self, factor: f64, place: [f64; 2], aspect: f64) {
        let before = self.half_height();
        let least = 1e-3 * self.scene_radius;
        let most = 100.0 * self.scene_radius;
        self.distance = (self.distance * factor).clamp(least, most);
        let [right, up, _] = self.axes();
        let gained = before - self.half_height();
        self.target += gained * (place[0] * aspect * right + place[1] * up);
    }

    /// Looks at a ball so that all of it is in a picture of this aspect.
    pub fn frame(&mut self, centre: Point3<f64>, radius: f64, aspect: f64) {
        self.target = centre;
        let half = 0.5 * self.field_of_view;
        let narrow = (half.tan() * aspect.min(1.0)).atan();
        self.distance = radius.max(1e-9) / narrow.sin();
        self.scene_radius = radius.max(1e-9);
    }

    /// Looks along an axis of the scene at the target: from where `from` points.
    pub fn look_from(&mut self, from: Vector3<f64>) {
        // Back into axes with y up.
        let v = match self.up {
            UpAxis::Y => from,
            UpAxis::Z => Vector3::new(from.x, from.z, -from.y),
        };
        self.pitch = v.y.atan2(v.x.hypot(v.z)).clamp(-MAX_PITCH, MAX_PITCH);
        if v.x.hypot(v.z) > 1e-9 {
            self.yaw = v.x.atan2(v.z).rem_euclid(std::f64::consts::TAU);
        } else {
            self.yaw = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cameras() -> Vec<Camera> {
        let mut all = Vec::new();
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for up in [UpAxis::Y, UpAxis::Z] {
                for (yaw, pitch) in [(0.0, 0.0), (0.7, 0.3), (3.0, -1.2), (5.5, 1.5)] {
                    let target = Point3::new(0.01, -0.02, 0.03);
                    all.push(Camera { target, yaw, pitch, projection, up, ..Camera::default() });
                }
            }
        }
        all
    }

    #[test]
    fn a_ray_goes_through_what_is_seen_there() {
        for camera in cameras() {
            for place in [[0.0, 0.0], [0.4, -0.7], [-0.9, 0.9]] {
                let ray = camera.ray(place, 1.5);
                let point = ray.origin + 0.27 * ray.direction;
                let (seen, _) = camera.project(&point, 1.5).unwrap();
                assert!((seen[0] - place[0]).abs() < 1e-9 && (seen[1] - place[1]).abs() < 1e-9, "{camera:?}");
            }
        }
    }

    #[test]
    fn panning_and_zooming_keep_what_is_under_the_pointer_there() {
        for mut camera in cameras() {
            let held = camera.target;
            let before = camera.project(&held, 1.0).unwrap().0;
            camera.pan(0.1, -0.2);
            let after = camera.project(&held, 1.0).unwrap().0;
            // A fraction of the height is two units of the picture from bottom to top.
            assert!((after[0] - before[0] - 0.2).abs() < 1e-9 && (after[1] - before[1] + 0.4).abs() < 1e-9);
            let at = [0.3, 0.5];
            let ray = camera.ray(at, 1.0);
            let t = (camera.target - ray.origin).dot(&camera.axes()[2]) / ray.direction.dot(&camera.axes()[2]);
            let held = ray.origin + t * ray.direction;
            camera.zoom(0.5, at, 1.0);
            let seen = camera.project(&held, 1.0).unwrap().0;
            assert!((seen[0] - at[0]).abs() < 1e-9 && (seen[1] - at[1]).abs() < 1e-9, "{camera:?} {seen:?}");
        }
    }

    #[test]
    fn a_framed_ball_is_inside_and_fills_the_picture() {
        for aspect in [0.5, 1.0, 2.0] {
            let mut camera = Camera::default();
            camera.frame(Point3::new(1.0, 2.0, 3.0), 0.5, aspect);
            let [right, up, _] = camera.axes();
            let mut largest = 0.0_f64;
            for turn in 0..64 {
                let (s, c) = (f64::from(turn) * std::f64::consts::TAU / 64.0).sin_cos();
                let edge = camera.target + 0.5 * (c * right + s * up);
                let (place, _) = camera.project(&edge, aspect).unwrap();
                largest = largest.max(place[0].abs()).max(place[1].abs());
            }
            assert!(largest <= 1.0 && largest > 0.9, "{largest}");
        }
    }

    #[test]
    fn looking_from_an_axis_looks_from_there() {
        for mut camera in cameras() {
            for from in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()] {
                camera.look_from(from);
                assert!(camera.axes()[2].dot(&from) > 0.9999, "{camera:?}");
            }
        }
    }

    #[test]
    fn eyes_meet_at_the_target_and_part_before_it() {
        for camera in cameras() {
            let shift = |point: Point3<f64>| {
                let place = |eye| {
                    let clip = camera.projection_matrix(1.0, eye) * camera.view_matrix(eye) * point.to_homogeneous();
                    clip.x / clip.w
                };
                place(Eye::Left) - place(Eye::Right)
            };
            assert!(shift(camera.target).abs() < 1e-9);
            // What is nearer than the target is seen crossed: farther right by the left eye.
            assert!(shift(camera.target + 0.1 * camera.distance * camera.axes()[2]) > 0.0);
            assert!(shift(camera.target - 0.1 * camera.distance * camera.axes()[2]) < 0.0);
        }
    }
}
