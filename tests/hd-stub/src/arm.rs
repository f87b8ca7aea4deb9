//! The arm as a multibody under joint torques J^T F, and the hand that holds it.
//!
//! Links are thin rods; friction is Coulomb's, smoothed around rest, and viscous. Gravity is left out, as the arm is balanced.
//! Masses are chosen for the apparent mass at the tip that is commonly quoted (45 g); none of it was compared with hardware.

use crate::kinematics::{self, L1, L2, L3, L4, LIMITS};
use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

/// N, the most the motors give at the tip
pub const PEAK: f64 = 3.3;
/// s, of one step of the multibody
const STEP: f64 = 2.5e-4;
/// rad/s, below which friction is smoothed
const SLOW: f64 = 0.02;
/// N m/rad and N m s/rad, of the elbow's stops
const STOP: [f64; 2] = [20.0, 0.05];

/// What pulls at the tip besides the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// m, where it wants to be
    pub target: Vector3<f64>,
    /// N/m; 0 lets go
    pub stiffness: f64,
    /// N s/m
    pub damping: f64,
}

/// A simulated arm.
pub struct Arm {
    world: PhysicsWorld,
    links: [RigidBodyHandle; 3],
    joint: MultibodyJointHandle,
    /// N, at the tip, of friction; and N s/m
    pub friction: f64,
    /// See `friction`.
    pub viscosity: f64,
    /// Its user.
    pub hand: Hand,
}

fn vector(v: Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// A rod from the origin to `end`, with a mass at its end.
fn rod(mass: f64, end: Vector3<f64>, tip: f64) -> MassProperties {
    let length = end.norm();
    let total = mass + tip;
    let com = (0.5 * mass + tip) / total;
    let across =
        mass * length * length * (1.0 / 12.0 + (com - 0.5).powi(2)) + tip * length * length * (1.0 - com).powi(2);
    let along = 1e-2 * across;
    let axis = end.iamax();
    let inertia = Vector::new(
        if axis == 0 { along } else { across },
        if axis == 1 { along } else { across },
        if axis == 2 { along } else { across },
    );
    MassProperties::new(vector(com * end), total, inertia)
}

impl Arm {
    /// At rest with its tip at a place (m).
    ///
    /// # Panics
    /// If the place is out of reach.
    pub fn new(tip: Vector3<f64>) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters.dt = STEP;
        let base = world.insert_body(RigidBodyBuilder::fixed());
        let link = |at: [f64; 3], mass: MassProperties| {
            let at = Vector::new(at[0], at[1], at[2]);
            RigidBodyBuilder::dynamic().translation(at).additional_mass_properties(mass).can_sleep(false)
        };
        let waist = MassProperties::new(Vector::ZERO, 0.05, Vector::new(2e-5, 2e-5, 2e-5));
        let waist = world.insert_body(link([0.0, L3, -L4], waist));
        let upper = world.insert_body(link([0.0, L3, -L4], rod(0.025, Vector3::z() * L1, 0.0)));
        let fore = world.insert_body(link([0.0, L3, -L4 + L1], rod(0.015, -Vector3::y() * L2, 0.025)));
        let joint = |axis: Vector, at: Vector, limits: Option<[f64; 2]>| {
            let joint = RevoluteJointBuilder::new(axis).local_anchor1(at).local_anchor2(Vector::ZERO);
            limits.map_or(joint, |limits| joint.limits(limits))
        };
        let (y, x) = (Vector::new(0.0, -1.0, 0.0), Vector::new(-1.0, 0.0, 0.0));
        let insert = "a joint between two bodies that have none";
        world.insert_multibody_joint(base, waist, joint(y, Vector::new(0.0, L3, -L4), Some(LIMITS[0]))).expect(insert);
        world.insert_multibody_joint(waist, upper, joint(x, Vector::ZERO, Some(LIMITS[1]))).expect(insert);
        let elbow = joint(x, Vector::new(0.0, 0.0, L1), None);
        let joint = world.insert_multibody_joint(upper, fore, elbow).expect(insert);
        // The fixed root becomes one in the first step.
        world.step();
        let t = kinematics::inverse(tip).expect("within reach");
        let (multibody, _) = world.multibody_joints.get_mut(joint).expect("just inserted");
        multibody.apply_displacements(&[t[0], t[1], t[2] - t[1]]);
        multibody.forward_kinematics(&world.bodies, false);
        multibody.update_rigid_bodies(&mut world.bodies, true);
        let hand = Hand { target: tip, stiffness: 0.0, damping: 0.0 };
        Self { world, links: [waist, upper, fore], joint, friction: 0.26, viscosity: 0.2, hand }
    }

    /// m, where the tip really is
    pub fn tip(&self) -> Vector3<f64> {
        let body = &self.world.bodies[self.links[2]];
        let tip = body.translation() + *body.rotation() * Vector::new(0.0, -L2, 0.0);
        Vector3::new(tip.x, tip.y, tip.z)
    }

    /// rad, the joints
    ///
    /// # Panics
    /// If the arm came apart.
    pub fn angles(&self) -> [f64; 3] {
        kinematics::inverse(self.tip()).expect("an arm in one piece")
    }

    /// rad/s; the elbow's is absolute
    pub fn rates(&self) -> [f64; 3] {
        let (multibody, _) = self.world.multibody_joints.get(self.joint).expect("inserted");
        let v = multibody.generalized_velocity();
        [v[0], v[1], v[1] + v[2]]
    }

    /// m/s
    pub fn velocity(&self) -> Vector3<f64> {
        kinematics::jacobian(self.angles()) * Vector3::from(self.rates())
    }

    /// N, what the hand does to the tip now
    pub fn pull(&self) -> Vector3<f64> {
        self.hand.stiffness * (self.hand.target - self.tip()) - self.hand.damping * self.velocity()
    }

    /// Moves on by `dt` (s) under a force of the motors at the tip (N), cut to what they give.
    pub fn advance(&mut self, dt: f64, force: Vector3<f64>) {
        let size = force.norm();
        let force = if size > PEAK { force * (PEAK / size) } else { force };
        for _ in 0..(dt / STEP).round().max(1.0) as usize {
            self.step(force);
        }
    }

    fn step(&mut self, force: Vector3<f64>) {
        let (t, w) = (self.angles(), Vector3::from(self.rates()));
        let mut torque = kinematics::jacobian(t).transpose() * (force + self.pull());
        for joint in 0..3 {
            torque[joint] -= L1 * self.friction * (w[joint] / SLOW).tanh() + L1 * L1 * self.viscosity * w[joint];
        }
        let [least, most] = LIMITS[2];
        let beyond = t[2] - t[2].clamp(least, most);
        if beyond != 0.0 {
            torque[2] -= STOP[0] * beyond + STOP[1] * w[2];
        }
        // The elbow's absolute angle is the sum of two joints: its torque acts on the fore arm, and on the base, not on the upper arm.
        let waist = *self.world.bodies[self.links[0]].rotation();
        let axes = [Vector::new(0.0, -1.0, 0.0), waist * Vector::new(-1.0, 0.0, 0.0)];
        let on = [torque[0] * axes[0] - (torque[1] + torque[2]) * axes[1], torque[1] * axes[1], torque[2] * axes[1]];
        for (link, torque) in self.links.into_iter().zip(on) {
            let body = &mut self.world.bodies[link];
            body.reset_torques(true);
            body.add_torque(torque, true);
        }
        self.world.step();
    }
}
