//! The twin of the arm against its own kinematics, and against statics and dynamics that can be written down.

use HD::arm::{Arm, Hand, PEAK};
use HD::kinematics::{LIMITS, QUANTUM, forward, inverse, jacobian, quantised};
use nalgebra::{Matrix3, Vector3};

/// Angles within the limits, away from the singular poses.
fn poses() -> Vec<[f64; 3]> {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let pose = |_| std::array::from_fn(|i| LIMITS[i][0] + random() * (LIMITS[i][1] - LIMITS[i][0]));
    let sound = |t: &[f64; 3]| (t[1] - t[2]).abs() < 1.5 && 0.135 * (t[1].cos() + t[2].sin()) > 0.01;
    (0..12_000).map(pose).filter(sound).take(5000).collect()
}

#[test]
fn inverse_kinematics_undo_forward_kinematics() {
    let poses = poses();
    assert!(poses.len() > 3000, "{}", poses.len());
    let (mut worst, mut slope) = (0.0_f64, 0.0_f64);
    for t in poses {
        let x = forward(t);
        let back = forward(inverse(x).expect("within reach"));
        worst = worst.max((back - x).amax());
        let j = jacobian(t);
        for i in 0..3 {
            let h = 1e-6;
            let at = |s: f64| forward(std::array::from_fn(|k| t[k] + if k == i { s * h } else { 0.0 }));
            slope = slope.max(((at(1.0) - at(-1.0)) / (2.0 * h) - j.column(i)).amax());
        }
    }
    println!("forward after inverse: {worst:e} m; Jacobian against differences: {slope:e}");
    assert!(worst < 1e-13 && slope < 1e-9);
    assert!((forward([0.0; 3]) - Vector3::new(0.0, -0.110, -0.035)).amax() < 1e-15);
    assert!(inverse(Vector3::new(0.0, 0.0, 0.5)).is_none());
}

#[test]
fn encoders_resolve_what_the_vendor_says() {
    let mut worst = 0.0_f64;
    for t in poses() {
        worst = worst.max((forward(quantised(t)) - forward(t)).norm());
    }
    println!("quantisation moves the tip by at most {worst:e} m; one count of one joint is {:e} m", QUANTUM * 0.135);
    assert!((QUANTUM * 0.135 - 5.65e-5).abs() < 1e-6 && worst < 1e-4 && worst > 2e-5);
}

fn held(stiffness: f64) -> Arm {
    let mut arm = Arm::new(Vector3::zeros());
    arm.hand = Hand { stiffness, damping: 3.0, ..arm.hand };
    arm
}

#[test]
fn a_steady_force_arrives_at_the_hand() {
    let mut worst = 0.0_f64;
    for force in [[1.0, 0.0, 0.0], [0.0, -0.8, 0.0], [0.0, 0.0, 2.0], [0.6, 0.7, -0.9]].map(Vector3::from) {
        let mut arm = held(400.0);
        arm.friction = 0.0;
        (0..3000).for_each(|_| arm.advance(1e-3, force));
        let error = (arm.pull() + force).norm();
        worst = worst.max(error);
    }
    println!("force at the hand without friction: off by at most {worst:e} N");
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn friction_is_felt_while_the_arm_moves() {
    let mut arm = held(400.0);
    let mut felt = (0.0, 0.0);
    for tick in 0..1200 {
        arm.hand.target.x = 5e-5 * f64::from(tick) - 0.03;
        arm.advance(1e-3, Vector3::zeros());
        if tick > 600 {
            felt = (felt.0 + arm.pull().x, felt.1 + 1.0);
        }
    }
    let drag = felt.0 / felt.1;
    println!("drag at 50 mm/s: {drag:.3} N, of {} N friction at the tip", arm.friction);
    // Each joint that turns takes its own: between one of them and all three at right angles.
    assert!((0.7 * arm.friction..3.0_f64.sqrt() * arm.friction + 0.01).contains(&drag), "{drag}");
}

#[test]
fn more_than_the_motors_give_is_not_rendered() {
    let mut arm = held(400.0);
    arm.friction = 0.0;
    (0..3000).for_each(|_| arm.advance(1e-3, Vector3::new(0.0, 0.0, 50.0)));
    assert!((arm.pull().norm() - PEAK).abs() < 1e-3, "{}", arm.pull().norm());
}

#[test]
fn the_tip_has_the_mass_it_should_and_the_joints_their_stops() {
    // Let go and pushed for a millisecond: F t = m v, in each direction.
    let mut mass = Vector3::zeros();
    for axis in 0..3 {
        let mut arm = held(0.0);
        (arm.friction, arm.viscosity, arm.hand.damping) = (0.0, 0.0, 0.0);
        arm.advance(1e-3, Vector3::ith(axis, 1.0));
        mass[axis] = 1e-3 / arm.velocity()[axis];
    }
    println!("apparent mass at the tip: {mass:?} kg");
    assert!(mass.iter().all(|m| (0.02..0.09).contains(m)), "{mass:?}");
    let mut arm = held(0.0);
    arm.hand.damping = 1.0;
    for force in [Vector3::new(3.0, 0.0, 0.0), Vector3::new(-3.0, 3.0, 3.0), Vector3::new(0.0, -3.0, -3.0)] {
        (0..2000).for_each(|_| arm.advance(1e-3, force));
        let t = arm.angles();
        let inside = (0..3).all(|i| (LIMITS[i][0] - 0.06..=LIMITS[i][1] + 0.06).contains(&t[i]));
        assert!(inside && arm.tip().iter().all(|c| c.is_finite()), "{t:?}");
    }
}

#[test]
fn torques_are_those_of_virtual_work() {
    let t = inverse(Vector3::new(0.03, 0.01, 0.02)).unwrap();
    let (force, j): (Vector3<f64>, Matrix3<f64>) = (Vector3::new(0.3, -1.0, 0.7), jacobian(t));
    let torque = j.transpose() * force;
    let step = Vector3::new(1e-7, -2e-7, 1.5e-7);
    let moved = forward(std::array::from_fn(|i| t[i] + step[i])) - forward(t);
    assert!((torque.dot(&step) - force.dot(&moved)).abs() < 1e-12);
}
