//! The simulated arm: a multibody driven by the joint torques J^T F of the motors, and the hand that holds it.
//!
//! The links are thin rods. Friction is Coulomb friction, smoothed around rest, and viscous friction. There is no gravity, as the arm is
//! balanced. The masses give the apparent mass at the tip that the vendor publishes (45 g); nothing was compared with hardware.

use crate::kinematics::{self, FORE_ARM, JOINT_LIMITS, SHOULDER_DEPTH, SHOULDER_HEIGHT, UPPER_ARM};
use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

/// Largest force of the motors at the tip, N.
pub const PEAK_FORCE: f64 = 3.3;
/// Largest force the motors can hold, N.
pub const OMNI_CONTINUOUS_FORCE: f64 = 0.88;
/// Time step of the multibody, s.
const STEP: f64 = 2.5e-4;
/// Joint velocity below which the Coulomb friction is smoothed, rad/s.
const FRICTION_SMOOTHING: f64 = 0.02;
/// Stiffness (N m/rad) and damping (N m s/rad) of the stops of the elbow.
const STOP_STIFFNESS: f64 = 20.0;
const STOP_DAMPING: f64 = 0.05;
/// Masses of the upper arm, of the fore arm and of the stylus at its end, kg.
const UPPER_ARM_MASS: f64 = 0.025;
const FORE_ARM_MASS: f64 = 0.015;
const STYLUS_MASS: f64 = 0.025;
/// Mass (kg) and moment of inertia (kg m^2) of the waist.
const WAIST_MASS: f64 = 0.05;
const WAIST_INERTIA: f64 = 2e-5;
/// Moment of inertia of a rod about its axis as a share of that across it.
const ROD_AXIAL_INERTIA: f64 = 1e-2;

/// The hand: a spring and a damper between the tip and a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Position the hand pulls the tip to, m.
    pub target: Vector3<f64>,
    /// N/m; 0 for a hand that lets go.
    pub stiffness: f64,
    /// Damping of the hand's hold, N s/m.
    pub damping: f64,
}

/// A simulated arm.
pub struct Arm {
    world: PhysicsWorld,
    /// Waist, upper arm, fore arm.
    links: [RigidBodyHandle; 3],
    elbow: MultibodyJointHandle,
    /// Coulomb friction of each joint, as a force at the tip, N.
    pub friction: f64,
    /// Viscous friction of each joint, at the tip, N s/m.
    pub viscosity: f64,
    /// The hand that holds the arm.
    pub hand: Hand,
}

fn vector(v: Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// A rod of `rod_mass` (kg) from the origin to `end` (m, along a coordinate axis), with `end_mass` (kg) at its end.
fn rod(end: Vector3<f64>, rod_mass: f64, end_mass: f64) -> MassProperties {
    let length = end.norm();
    let mass = rod_mass + end_mass;
    // Position of the centre of mass along the rod, and the moments about it (parallel axes).
    let centre = (0.5 * rod_mass + end_mass) / mass;
    let rod_inertia = rod_mass * length * length * (1.0 / 12.0 + (centre - 0.5).powi(2));
    let across = rod_inertia + end_mass * length * length * (1.0 - centre).powi(2);
    let axis = end.iamax();
    let inertia = [0, 1, 2].map(|i| if i == axis { ROD_AXIAL_INERTIA * across } else { across });
    MassProperties::new(vector(centre * end), mass, Vector::new(inertia[0], inertia[1], inertia[2]))
}

/// A link whose frame is at `origin` (m).
fn link(origin: [f64; 3], mass: MassProperties) -> RigidBodyBuilder {
    let [x, y, z] = origin;
    RigidBodyBuilder::dynamic().translation(Vector::new(x, y, z)).additional_mass_properties(mass).can_sleep(false)
}

/// A joint at `anchor` (m) of its first link and at the origin of its second.
fn revolute(axis: Vector, anchor: Vector) -> RevoluteJointBuilder {
    RevoluteJointBuilder::new(axis).local_anchor1(anchor).local_anchor2(Vector::ZERO)
}

impl Arm {
    /// An arm at rest with its tip at a position (m), held by a hand that lets go.
    ///
    /// # Panics
    /// If the position is out of reach.
    pub fn new(tip: Vector3<f64>) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters.dt = STEP;
        let base = world.insert_body(RigidBodyBuilder::fixed());
        let shoulder = [0.0, SHOULDER_HEIGHT, -SHOULDER_DEPTH];
        let elbow_origin = [0.0, SHOULDER_HEIGHT, -SHOULDER_DEPTH + UPPER_ARM];
        let waist_inertia = Vector::new(WAIST_INERTIA, WAIST_INERTIA, WAIST_INERTIA);
        let waist = world.insert_body(link(shoulder, MassProperties::new(Vector::ZERO, WAIST_MASS, waist_inertia)));
        let upper_arm = rod(Vector3::z() * UPPER_ARM, UPPER_ARM_MASS, 0.0);
        let upper_arm = world.insert_body(link(shoulder, upper_arm));
        let fore_arm = rod(-Vector3::y() * FORE_ARM, FORE_ARM_MASS, STYLUS_MASS);
        let fore_arm = world.insert_body(link(elbow_origin, fore_arm));
        let (down, left) = (Vector::new(0.0, -1.0, 0.0), Vector::new(-1.0, 0.0, 0.0));
        let waist_joint = revolute(down, Vector::new(0.0, SHOULDER_HEIGHT, -SHOULDER_DEPTH)).limits(JOINT_LIMITS[0]);
        let shoulder_joint = revolute(left, Vector::ZERO).limits(JOINT_LIMITS[1]);
        // The multibody's elbow joint is relative to the upper arm; the stop of the absolute angle is a spring in `step`.
        let elbow_joint = revolute(left, Vector::new(0.0, 0.0, UPPER_ARM));
        let inserted = "the two bodies have no joint yet";
        world.insert_multibody_joint(base, waist, waist_joint).expect(inserted);
        world.insert_multibody_joint(waist, upper_arm, shoulder_joint).expect(inserted);
        let elbow = world.insert_multibody_joint(upper_arm, fore_arm, elbow_joint).expect(inserted);
        // rapier makes the fixed body the root of the multibody in the first step.
        world.step();
        let angles = kinematics::inverse(tip).expect("the tip is within reach");
        let (multibody, _) = world.multibody_joints.get_mut(elbow).expect("inserted above");
        multibody.apply_displacements(&[angles[0], angles[1], angles[2] - angles[1]]);
        multibody.forward_kinematics(&world.bodies, false);
        multibody.update_rigid_bodies(&mut world.bodies, true);
        let hand = Hand { target: tip, stiffness: 0.0, damping: 0.0 };
        Self { world, links: [waist, upper_arm, fore_arm], elbow, friction: 0.26, viscosity: 0.2, hand }
    }

    /// Position of the tip, m.
    pub fn tip(&self) -> Vector3<f64> {
        let body = &self.world.bodies[self.links[2]];
        let tip = body.translation() + *body.rotation() * Vector::new(0.0, -FORE_ARM, 0.0);
        Vector3::new(tip.x, tip.y, tip.z)
    }

    /// Joint angles, rad.
    ///
    /// # Panics
    /// If the simulation diverged, so that the tip is out of reach.
    pub fn angles(&self) -> [f64; 3] {
        kinematics::inverse(self.tip()).expect("the tip is within reach")
    }

    /// Velocities of the joint angles, rad/s; that of the elbow is relative to the base, as its angle.
    pub fn joint_velocities(&self) -> [f64; 3] {
        let (multibody, _) = self.world.multibody_joints.get(self.elbow).expect("inserted by `new`");
        let v = multibody.generalized_velocity();
        [v[0], v[1], v[1] + v[2]]
    }

    /// Velocity of the tip, m/s.
    pub fn velocity(&self) -> Vector3<f64> {
        kinematics::jacobian(self.angles()) * Vector3::from(self.joint_velocities())
    }

    /// Force of the hand on the tip, N.
    pub fn hand_force(&self) -> Vector3<f64> {
        self.hand.stiffness * (self.hand.target - self.tip()) - self.hand.damping * self.velocity()
    }

    /// Advances the simulation by `dt` (s) under a force of the motors at the tip (N), which is limited to [`PEAK_FORCE`].
    pub fn advance(&mut self, dt: f64, motor_force: Vector3<f64>) {
        let norm = motor_force.norm();
        let force = if norm > PEAK_FORCE { motor_force * (PEAK_FORCE / norm) } else { motor_force };
        for _ in 0..(dt / STEP).round().max(1.0) as usize {
            self.step(force);
        }
    }

    fn step(&mut self, motor_force: Vector3<f64>) {
        let (angles, velocities) = (self.angles(), Vector3::from(self.joint_velocities()));
        let mut torque = kinematics::jacobian(angles).transpose() * (motor_force + self.hand_force());
        for joint in 0..3 {
            let coulomb = UPPER_ARM * self.friction * (velocities[joint] / FRICTION_SMOOTHING).tanh();
            torque[joint] -= coulomb + UPPER_ARM * UPPER_ARM * self.viscosity * velocities[joint];
        }
        let [min, max] = JOINT_LIMITS[2];
        let beyond_stop = angles[2] - angles[2].clamp(min, max);
        if beyond_stop != 0.0 {
            torque[2] -= STOP_STIFFNESS * beyond_stop + STOP_DAMPING * velocities[2];
        }
        // The elbow's angle is relative to the base, so its torque acts between base and fore arm, not on the upper arm.
        let waist = *self.world.bodies[self.links[0]].rotation();
        let axes = [Vector::new(0.0, -1.0, 0.0), waist * Vector::new(-1.0, 0.0, 0.0)];
        let torques =
            [torque[0] * axes[0] - (torque[1] + torque[2]) * axes[1], torque[1] * axes[1], torque[2] * axes[1]];
        for (link, torque) in self.links.into_iter().zip(torques) {
            let body = &mut self.world.bodies[link];
            body.reset_torques(true);
            body.add_torque(torque, true);
        }
        self.world.step();
    }
}
