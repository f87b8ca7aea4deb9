//! Mapping of a two-dimensional pointer to a hand.
//!
//! A stroke begins where a ray through the pointer hits the model. The hand then follows the pointer in the plane through that point facing the viewer, or
//! along the surface as it was at the beginning of the stroke; a wheel, a modifier key or the pressure of a pen controls the third dimension. The result is
//! a pose for the engine's virtual coupling; no forces are computed here.

use nalgebra::{Rotation3, UnitQuaternion};
use pliant_engine::tool::Frame;
use pliant_live::PointerHandle;
use pliant_solver::Vec3;

/// Mapping from pointer to hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// Along the surface, at a depth below it.
    Press,
    /// In the plane facing the viewer through the starting point of the stroke.
    Drag,
    /// Like [`Gesture::Drag`], with a blade that points away from the viewer.
    Slice,
}

/// A ray of the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointerRay {
    /// Point from which the ray starts, m.
    pub origin: Vec3,
    /// Unit direction, away from the viewer.
    pub direction: Vec3,
}

/// Intersection of a ray with the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Point of the surface in the scene, m.
    pub point: Vec3,
    /// Unit outward normal.
    pub normal: Vec3,
}

/// Pose of a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandPlace {
    /// Position of the hand in the scene, m.
    pub position: Vec3,
    /// Rotation from axes of the hand to those of the scene; z points towards the viewer.
    pub rotation: UnitQuaternion<f64>,
}

impl HandPlace {
    /// The place with the same direction of z, to which the hand turns from `start` on the shortest way: in a motion between them z stays in the plane of both
    /// directions. What a blade sweeps is flat then.
    #[must_use]
    pub fn turned_from(&self, start: &Self) -> Self {
        let turn = Rotation3::rotation_between(&(start.rotation * Vec3::z()), &(self.rotation * Vec3::z()));
        let turned = |turn| UnitQuaternion::from_rotation_matrix(&turn) * start.rotation;
        Self { position: self.position, rotation: turn.map_or(self.rotation, turned) }
    }

    /// Sends a pointer whose device has this `frame` there within `duration` (s), and has it press these buttons (bit i is button i) once it is there.
    pub fn glide_then_press(&self, pointer: &mut PointerHandle, frame: &Frame, buttons: u32, duration: f64) {
        let rotation = frame.rotation.inverse() * self.rotation;
        pointer.glide_then_press(frame.to_hand(self.position), rotation, buttons, duration);
    }

    /// Sends a pointer whose device has this `frame` there within `duration` (s), with these buttons (bit i is button i).
    pub fn glide(&self, pointer: &mut PointerHandle, frame: &Frame, buttons: u32, duration: f64) {
        let rotation = frame.rotation.inverse() * self.rotation;
        pointer.glide_to(frame.to_hand(self.position), rotation, buttons, duration);
    }
}

/// Parameters of the beginning of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeStart {
    /// Mapping from pointer to hand.
    pub gesture: Gesture,
    /// Ray of the pointer.
    pub ray: PointerRay,
    /// Intersection of the ray with the model; `None` if it misses.
    pub hit: Option<SurfacePoint>,
    /// Unit vector towards the viewer at the centre of the image.
    pub back: Vec3,
    /// A point at the depth of a stroke that begins beside the model, m.
    pub focus: Vec3,
    /// Radius of the tool, m.
    pub radius: f64,
    /// Depth of a press, or distance of a blade's tip behind the starting point, m.
    pub depth: f64,
}

/// A stroke in progress.
#[derive(Clone, Debug)]
pub struct PointerStroke {
    start: StrokeStart,
    /// Starting point on the model, m.
    anchor: Vec3,
    /// Last intersection of the pointer's ray with the surface.
    surface: SurfacePoint,
    /// Present ray of the pointer.
    ray: PointerRay,
    /// Target depth, m.
    depth: f64,
    /// Present depth, m.
    reached: f64,
    /// Displacement towards the viewer by wheel or modifier key, m.
    lift: f64,
}

/// Time in which a press reaches its depth, s.
const PRESS_TIME: f64 = 0.2;
/// Initial distance of a press from the surface, in radii of the tool.
const CLEARANCE: f64 = 0.05;

impl PointerStroke {
    /// Begins a stroke; `None` for a press or drag whose ray misses the model.
    pub fn begin(start: StrokeStart) -> Option<Self> {
        let beside = || {
            let along = (start.focus - start.ray.origin).dot(&start.back) / start.ray.direction.dot(&start.back);
            SurfacePoint { point: start.ray.origin + along * start.ray.direction, normal: start.back }
        };
        let surface = match (start.hit, start.gesture) {
            (Some(hit), _) => hit,
            (None, Gesture::Slice) => beside(),
            (None, Gesture::Press | Gesture::Drag) => return None,
        };
        let reached = -CLEARANCE * start.radius;
        let (anchor, ray, depth) = (surface.point, start.ray, start.depth);
        Some(Self { start, anchor, surface, ray, depth, reached, lift: 0.0 })
    }

    /// Updates the pointer's ray; `hit` is its intersection with the surface as it was at the beginning of the stroke.
    pub fn follow(&mut self, ray: PointerRay, hit: Option<SurfacePoint>) {
        self.ray = ray;
        if let Some(hit) = hit {
            self.surface = hit;
        }
    }

    /// Sets the depth of a press, or the distance of a blade's tip behind the surface, m.
    pub fn set_depth(&mut self, depth: f64) {
        self.depth = depth;
    }

    /// Target depth, m.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Moves the hand towards the viewer by a length (m), which reduces the depth of a press.
    pub fn lift(&mut self, length: f64) {
        match self.start.gesture {
            Gesture::Press => self.depth -= length,
            Gesture::Drag | Gesture::Slice => self.lift += length,
        }
    }

    /// The gesture of the stroke.
    pub fn gesture(&self) -> Gesture {
        self.start.gesture
    }

    /// Pose of the hand `dt` (s) after the last call.
    pub fn advance(&mut self, dt: f64) -> HandPlace {
        let StrokeStart { gesture, back, radius, .. } = self.start;
        let position = match gesture {
            Gesture::Press => {
                let step = dt / PRESS_TIME * (self.depth.abs() + CLEARANCE * radius);
                self.reached += (self.depth - self.reached).clamp(-step, step);
                self.surface.point + (radius - self.reached) * self.surface.normal
            }
            Gesture::Drag => self.in_plane(self.anchor + self.lift * back),
            // The tip is behind the plane of the pointer, along the ray.
            Gesture::Slice => self.in_plane(self.anchor) + (self.depth - self.lift) * self.ray.direction,
        };
        let towards_viewer = match gesture {
            Gesture::Slice => -self.ray.direction,
            Gesture::Press | Gesture::Drag => back,
        };
        HandPlace { position, rotation: rotation_from_z(&towards_viewer) }
    }

    /// Intersection of the ray with the plane facing the viewer through a point, m.
    fn in_plane(&self, through: Vec3) -> Vec3 {
        let back = self.start.back;
        let slope = self.ray.direction.dot(&back);
        // A ray parallel to the plane does not intersect it; the hand stays at the point.
        if slope.abs() < 1e-6 {
            return through;
        }
        self.ray.origin + (through - self.ray.origin).dot(&back) / slope * self.ray.direction
    }
}

/// The smallest rotation from z to `to`; half a turn about x if `to` is -z.
fn rotation_from_z(to: &Vec3) -> UnitQuaternion<f64> {
    let turn = Rotation3::rotation_between(&Vec3::z(), to);
    let turn = turn.unwrap_or_else(|| Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI));
    UnitQuaternion::from_rotation_matrix(&turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(gesture: Gesture, hit: bool) -> StrokeStart {
        let back = Vec3::z();
        let hit = hit.then_some(SurfacePoint { point: Vec3::new(0.0, 0.0, 0.05), normal: Vec3::z() });
        StrokeStart {
            gesture,
            ray: PointerRay { origin: Vec3::new(0.0, 0.0, 0.3), direction: -back },
            hit,
            back,
            focus: Vec3::zeros(),
            radius: 0.005,
            depth: 0.003,
        }
    }

    fn ray_through(x: f64, y: f64, z: f64) -> PointerRay {
        let origin = Vec3::new(0.0, 0.0, 0.3);
        PointerRay { origin, direction: (Vec3::new(x, y, z) - origin).normalize() }
    }

    #[test]
    fn a_press_begins_above_the_surface_and_goes_in_by_its_depth() {
        let mut stroke = PointerStroke::begin(start(Gesture::Press, true)).unwrap();
        let first = stroke.advance(0.0).position;
        assert!(first.z > 0.05 + 0.005, "{first}");
        let mut before = first.z;
        for _ in 0..40 {
            let now = stroke.advance(0.01).position.z;
            assert!(now <= before);
            before = now;
        }
        assert!((before - (0.05 + 0.005 - 0.003)).abs() < 1e-12, "{before}");
        stroke.lift(-0.001);
        for _ in 0..40 {
            stroke.advance(0.01);
        }
        assert!((stroke.advance(0.01).position.z - 0.051).abs() < 1e-12);
    }

    #[test]
    fn a_drag_follows_the_pointer_in_the_plane_of_the_viewer() {
        let mut stroke = PointerStroke::begin(start(Gesture::Drag, true)).unwrap();
        assert!((stroke.advance(0.01).position - Vec3::new(0.0, 0.0, 0.05)).norm() < 1e-12);
        stroke.follow(ray_through(0.02, -0.01, 0.05), None);
        assert!((stroke.advance(0.01).position - Vec3::new(0.02, -0.01, 0.05)).norm() < 1e-12);
        stroke.lift(0.04);
        let lifted = stroke.advance(0.01).position;
        assert!((lifted.z - 0.09).abs() < 1e-12 && lifted.x > 0.0);
        // A ray parallel to the plane leaves the hand at its starting point.
        stroke.follow(PointerRay { origin: Vec3::zeros(), direction: Vec3::x() }, None);
        assert!(stroke.advance(0.01).position.iter().all(|c| c.is_finite()));
    }

    #[test]
    fn z_stays_in_a_plane_between_two_places() {
        let directions = [[1.0, 0.3, 0.0], [0.9, -0.35, 0.1], [-0.1, 0.2, -1.0], [0.1, -0.1, -1.0]].map(Vec3::from);
        for (a, b) in directions.iter().flat_map(|a| directions.map(|b| (a.normalize(), b.normalize()))) {
            let [start, end] = [a, b].map(|z| HandPlace { position: z, rotation: rotation_from_z(&z) });
            let turned = end.turned_from(&start);
            assert!((turned.rotation * Vec3::z() - b).norm() < 1e-12 && turned.position == b);
            for share in [0.2, 0.5, 0.8] {
                let z = start.rotation.nlerp(&turned.rotation, share) * Vec3::z();
                assert!(z.dot(&a.cross(&b)).abs() < 1e-12, "{a:?} to {b:?}: {z:?}");
            }
        }
    }

    #[test]
    fn a_blade_points_away_from_the_viewer_and_may_begin_beside_the_model() {
        let mut stroke = PointerStroke::begin(start(Gesture::Slice, false)).unwrap();
        let place = stroke.advance(0.01);
        assert!((place.position - Vec3::new(0.0, 0.0, -0.003)).norm() < 1e-12, "{}", place.position);
        assert!((place.rotation * Vec3::z() - Vec3::z()).norm() < 1e-12, "its heel is towards the viewer");
        stroke.follow(ray_through(0.02, 0.0, 0.0), None);
        let moved = stroke.advance(0.01);
        let heel = moved.position + 0.2 * (moved.rotation * Vec3::z());
        let ray = ray_through(0.02, 0.0, 0.0);
        let off_ray = (heel - ray.origin).cross(&ray.direction).norm();
        assert!(off_ray < 1e-12, "the blade lies in the ray: {off_ray}");
        assert!(PointerStroke::begin(start(Gesture::Press, false)).is_none());
        assert!(PointerStroke::begin(start(Gesture::Drag, false)).is_none());
    }
}
