//! An arm that leans on a virtual wall: the smallest closed loop there is.

use crate::arm::{Arm, ArmModel};
use pliant_engine::tool::ContactModel;
use pliant_live::{HapticDevice, Servo};
use pliant_mesh::geometry::Vec3;

/// A wall and who leans on it.
pub struct Wall {
    /// Rate of the servo loop, Hz.
    pub rate: f64,
    /// N s/m, of the device
    pub damping: f64,
    /// N/m, of the wall
    pub stiffness: f64,
    /// m, of the encoders
    pub resolution: f64,
    /// Ticks of the haptic side for a step of the simulation.
    pub every: u64,
    /// Whether the simulation tells the wall's stiffness, or its force alone.
    pub slope: bool,
    /// Whether the controller of passivity acts.
    pub controls: bool,
}

impl Default for Wall {
    fn default() -> Self {
        Self { rate: 1000.0, damping: 0.2, stiffness: 100.0, resolution: 5.5e-5, every: 1, slope: true, controls: true }
    }
}

/// N, towards the wall
const LEAN: f64 = 2.0;
/// N, far over what the arm's peak of 3.3 N cuts off, so that it is the loop that is looked at and not the limit
const PEAK: f64 = 1e4;

/// m, how far the arm still goes to and fro after nine times what its own damping takes to calm it by a factor of e, and a second
pub fn swing(wall: &Wall) -> f64 {
    // A session only for its tool: nothing of it is stepped.
    let mut session = crate::open(&crate::box_scene("", "", ""), 1);
    drop(session.take_devices());
    session.tools[0].hand.fastest = 1e3;
    session.tools[0].safety = pliant_engine::tool::ForceSafety::new(pliant_engine::tool::ForceLimits {
        peak: PEAK,
        continuous: PEAK,
        slew: 1e9,
    });
    // The lean is the hold of a hand as soft as air, far away.
    let soft = 1e-3;
    let frame = session.devices[0].frame;
    let target = move |_: f64| Vec3::new(0.0, 0.0, -LEAN / soft);
    let mut model = ArmModel::desktop(target);
    (model.rate, model.damping, model.resolution) = (wall.rate, wall.damping, wall.resolution);
    (model.grip_stiffness, model.grip_damping) = (soft, 0.0);
    (model.peak_force, model.continuous_force) = (PEAK, PEAK);
    let mass = model.mass;
    let (arm, state) = Arm::new(model);
    state.lock().expect("alone").position = Vec3::new(0.0, 0.0, 0.005);
    let (mut servo, mut port) = Servo::new(&session, vec![Box::new(arm) as Box<dyn HapticDevice>], Some(wall.rate));
    servo.safety().for_each(|safety| safety.control(wall.controls));
    let seconds = 1.0 + 9.0 * 2.0 * mass / wall.damping;
    let (ticks, mut least, mut most) = ((seconds * wall.rate) as u64, f64::INFINITY, f64::NEG_INFINITY);
    let normal = frame.to_scene(Vec3::z()) - frame.origin;
    for tick in 1..=ticks {
        let now = (tick as f64 / wall.rate * 1e9).round() as u64;
        servo.tick(now);
        if tick % wall.every == 0 {
            let samples = port.latest();
            let (time, place) = (samples.time, samples.poses[0][0].position);
            let depth = (-place[2]).max(0.0);
            let k = if wall.slope { wall.stiffness } else { 0.0 };
            let contact = ContactModel {
                time,
                force: wall.stiffness * depth * normal,
                at: frame.to_scene(Vec3::new(place[0], place[1], place[2].min(0.0))),
                stiffness: std::array::from_fn(|e| k * normal[e / 3] * normal[e % 3]),
                normal: Some(normal),
                ..ContactModel::default()
            };
            port.publish(&[contact]);
        }
        let height = state.lock().expect("alone").position[2];
        if tick + (0.5 * wall.rate) as u64 > ticks {
            (least, most) = (least.min(height), most.max(height));
        }
        if height.is_nan() || height.abs() > 1.0 {
            return f64::INFINITY;
        }
    }
    most - least
}
