//! Kinematics of the Phantom Omni (Silva et al. 2009). The joints are waist, shoulder and elbow; the elbow's angle is relative to the
//! base, because a parallelogram drives it. Angles are rad, positions m; x right, y up, z towards the user.

use nalgebra::{Matrix3, Vector3};

/// Length of the upper arm, m.
pub const UPPER_ARM: f64 = 0.135;
/// Length of the fore arm, m.
pub const FORE_ARM: f64 = 0.135;
/// Height of the shoulder above the origin of the workspace, m.
pub const SHOULDER_HEIGHT: f64 = 0.025;
/// Distance of the shoulder behind the origin of the workspace, m.
pub const SHOULDER_DEPTH: f64 = 0.170;
/// Smallest and largest angle of each joint, rad.
pub const JOINT_LIMITS: [[f64; 2]; 3] = [[-0.98, 0.98], [-0.24, 1.57], [-0.2, 1.95]];
/// Angle of one encoder count, rad.
pub const ENCODER_STEP: f64 = std::f64::consts::TAU / 15_000.0;

/// Position of the tip at the joint angles.
pub fn forward(angles: [f64; 3]) -> Vector3<f64> {
    let [waist, shoulder, elbow] = angles;
    let reach = UPPER_ARM * shoulder.cos() + FORE_ARM * elbow.sin();
    Vector3::new(
        -reach * waist.sin(),
        SHOULDER_HEIGHT + UPPER_ARM * shoulder.sin() - FORE_ARM * elbow.cos(),
        -SHOULDER_DEPTH + reach * waist.cos(),
    )
}

/// Joint angles at a position of the tip; `None` if it is out of reach. The limits of the joints are not checked.
pub fn inverse(tip: Vector3<f64>) -> Option<[f64; 3]> {
    let (out, up) = (tip.z + SHOULDER_DEPTH, tip.y - SHOULDER_HEIGHT);
    let reach = tip.x.hypot(out);
    let distance = reach.hypot(up);
    // The triangle of shoulder, elbow and tip, by the law of cosines.
    let acos = |cosine: f64| (-1.0..=1.0).contains(&cosine).then(|| cosine.acos());
    let elevation = up.atan2(reach);
    let at_shoulder =
        acos((UPPER_ARM * UPPER_ARM + distance * distance - FORE_ARM * FORE_ARM) / (2.0 * UPPER_ARM * distance))?;
    let at_elbow =
        acos((UPPER_ARM * UPPER_ARM + FORE_ARM * FORE_ARM - distance * distance) / (2.0 * UPPER_ARM * FORE_ARM))?;
    let shoulder = at_shoulder + elevation;
    Some([-tip.x.atan2(out), shoulder, shoulder + at_elbow - std::f64::consts::FRAC_PI_2])
}

/// Derivative of the tip position by the joint angles, m/rad; one column per joint.
pub fn jacobian(angles: [f64; 3]) -> Matrix3<f64> {
    let [(s1, c1), (s2, c2), (s3, c3)] = angles.map(f64::sin_cos);
    let reach = UPPER_ARM * c2 + FORE_ARM * s3;
    Matrix3::from_columns(&[
        Vector3::new(-c1 * reach, 0.0, -s1 * reach),
        Vector3::new(s1 * UPPER_ARM * s2, UPPER_ARM * c2, -c1 * UPPER_ARM * s2),
        Vector3::new(-s1 * FORE_ARM * c3, FORE_ARM * s3, c1 * FORE_ARM * c3),
    ])
}

/// The angles as the encoders report them.
pub fn quantized(angles: [f64; 3]) -> [f64; 3] {
    angles.map(|angle| (angle / ENCODER_STEP).round() * ENCODER_STEP)
}
