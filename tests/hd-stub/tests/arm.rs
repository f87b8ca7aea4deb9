//! The simulated arm: its kinematics, and its statics and dynamics where they have a closed form.

use HD::arm::{Arm, Hand, PEAK_FORCE};
use HD::kinematics::{ENCODER_STEP, FORE_ARM, JOINT_LIMITS, UPPER_ARM, forward, inverse, jacobian, quantized};
use nalgebra::{Matrix3, Vector3};
use pliant_plugin_api::kit::Random;

/// Joint angles within the limits, away from the singular poses: the outstretched arm, and a tip above the waist.
fn random_angles() -> Vec<[f64; 3]> {
    let mut random = Random(1);
    let angles =
        |_| std::array::from_fn(|i| JOINT_LIMITS[i][0] + random.unit() * (JOINT_LIMITS[i][1] - JOINT_LIMITS[i][0]));
    let is_regular = |[_, shoulder, elbow]: &[f64; 3]| {
        (shoulder - elbow).abs() < 1.5 && UPPER_ARM * shoulder.cos() + FORE_ARM * elbow.sin() > 0.01
    };
    (0..12_000).map(angles).filter(is_regular).take(5000).collect()
}

#[test]
fn inverse_kinematics_invert_forward_kinematics() {
    let all = random_angles();
    assert!(all.len() > 3000, "{}", all.len());
    let (mut position_error, mut jacobian_error) = (0.0_f64, 0.0_f64);
    for angles in all {
        let tip = forward(angles);
        let back = forward(inverse(tip).expect("within reach"));
        position_error = position_error.max((back - tip).amax());
        let j = jacobian(angles);
        for i in 0..3 {
            let h = 1e-6;
            let tip_at = |s: f64| forward(std::array::from_fn(|k| angles[k] + if k == i { s * h } else { 0.0 }));
            let difference = (tip_at(1.0) - tip_at(-1.0)) / (2.0 * h);
            jacobian_error = jacobian_error.max((difference - j.column(i)).amax());
        }
    }
    println!("forward after inverse: {position_error:e} m; Jacobian and differences: {jacobian_error:e} m/rad");
    assert!(position_error < 1e-13 && jacobian_error < 1e-9);
    assert!((forward([0.0; 3]) - Vector3::new(0.0, -0.110, -0.035)).amax() < 1e-15);
    assert!(inverse(Vector3::new(0.0, 0.0, 0.5)).is_none());
}

#[test]
fn encoders_have_the_published_resolution() {
    let mut largest = 0.0_f64;
    for angles in random_angles() {
        largest = largest.max((forward(quantized(angles)) - forward(angles)).norm());
    }
    let count = ENCODER_STEP * UPPER_ARM;
    println!("quantisation moves the tip by at most {largest:e} m; one count of one joint moves it by {count:e} m");
    assert!((count - 5.65e-5).abs() < 1e-6 && largest < 1e-4 && largest > 2e-5);
}

fn arm_held_by_a_hand(stiffness: f64) -> Arm {
    let mut arm = Arm::new(Vector3::zeros());
    arm.hand = Hand { stiffness, damping: 3.0, ..arm.hand };
    arm
}

#[test]
fn the_hand_balances_a_constant_force() {
    let mut largest = 0.0_f64;
    for force in [[1.0, 0.0, 0.0], [0.0, -0.8, 0.0], [0.0, 0.0, 2.0], [0.6, 0.7, -0.9]].map(Vector3::from) {
        let mut arm = arm_held_by_a_hand(400.0);
        arm.friction = 0.0;
        (0..3000).for_each(|_| arm.advance(1e-3, force));
        let error = (arm.hand_force() + force).norm();
        largest = largest.max(error);
    }
    println!("largest error of the force at the hand without friction: {largest:e} N");
    assert!(largest < 1e-3, "{largest}");
}

#[test]
fn friction_resists_the_motion() {
    let mut arm = arm_held_by_a_hand(400.0);
    let (mut sum, mut count) = (0.0, 0.0);
    for tick in 0..1200 {
        arm.hand.target.x = 5e-5 * f64::from(tick) - 0.03;
        arm.advance(1e-3, Vector3::zeros());
        if tick > 600 {
            (sum, count) = (sum + arm.hand_force().x, count + 1.0);
        }
    }
    let drag = sum / count;
    println!("drag at 50 mm/s: {drag:.3} N, of {} N friction at the tip", arm.friction);
    // Every joint that turns resists: from one joint to three whose forces at the tip are orthogonal.
    assert!((0.7 * arm.friction..3.0_f64.sqrt() * arm.friction + 0.01).contains(&drag), "{drag}");
}

#[test]
fn the_force_is_limited_to_the_peak_of_the_motors() {
    let mut arm = arm_held_by_a_hand(400.0);
    arm.friction = 0.0;
    (0..3000).for_each(|_| arm.advance(1e-3, Vector3::new(0.0, 0.0, 50.0)));
    assert!((arm.hand_force().norm() - PEAK_FORCE).abs() < 1e-3, "{}", arm.hand_force().norm());
}

#[test]
fn the_tip_has_the_published_apparent_mass() {
    // A force during one millisecond on the free arm: F t = m v, along each axis.
    let mut mass = Vector3::zeros();
    for axis in 0..3 {
        let mut arm = arm_held_by_a_hand(0.0);
        (arm.friction, arm.viscosity, arm.hand.damping) = (0.0, 0.0, 0.0);
        arm.advance(1e-3, Vector3::ith(axis, 1.0));
        mass[axis] = 1e-3 / arm.velocity()[axis];
    }
    println!("apparent mass at the tip: {mass:?} kg");
    // 45 g is published without a direction; it depends on it by about a factor of 2.
    assert!(mass.iter().all(|m| (0.02..0.09).contains(m)), "{mass:?}");
}

#[test]
fn joints_stop_at_their_limits() {
    let mut arm = arm_held_by_a_hand(0.0);
    arm.hand.damping = 1.0;
    for force in [Vector3::new(3.0, 0.0, 0.0), Vector3::new(-3.0, 3.0, 3.0), Vector3::new(0.0, -3.0, -3.0)] {
        (0..2000).for_each(|_| arm.advance(1e-3, force));
        let angles = arm.angles();
        // The stops are soft.
        let inside = (0..3).all(|i| (JOINT_LIMITS[i][0] - 0.06..=JOINT_LIMITS[i][1] + 0.06).contains(&angles[i]));
        assert!(inside && arm.tip().iter().all(|c| c.is_finite()), "{angles:?}");
    }
}

#[test]
fn joint_torques_do_the_work_of_the_force() {
    let angles = inverse(Vector3::new(0.03, 0.01, 0.02)).unwrap();
    let (force, j): (Vector3<f64>, Matrix3<f64>) = (Vector3::new(0.3, -1.0, 0.7), jacobian(angles));
    let torque = j.transpose() * force;
    let rotation = Vector3::new(1e-7, -2e-7, 1.5e-7);
    let displacement = forward(std::array::from_fn(|i| angles[i] + rotation[i])) - forward(angles);
    assert!((torque.dot(&rotation) - force.dot(&displacement)).abs() < 1e-12);
}
