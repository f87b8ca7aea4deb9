//! Kinematics of the Phantom Omni (Silva et al. 2009): waist, shoulder, and an elbow whose angle is absolute, as a parallelogram
//! drives it.

use nalgebra::{Matrix3, Vector3};

/// m, both arms
pub const L1: f64 = 0.135;
/// See `L1`.
pub const L2: f64 = 0.135;
/// m, from the base to the workspace: up, and back
pub const L3: f64 = 0.025;
/// See `L3`.
pub const L4: f64 = 0.170;
/// rad, least and greatest of each joint
pub const LIMITS: [[f64; 2]; 3] = [[-0.98, 0.98], [-0.24, 1.57], [-0.2, 1.95]];
/// rad, of one count of an encoder
pub const QUANTUM: f64 = std::f64::consts::TAU / 15_000.0;

/// m, the tip at joint angles (rad).
pub fn forward(t: [f64; 3]) -> Vector3<f64> {
    let rho = L1 * t[1].cos() + L2 * t[2].sin();
    Vector3::new(-rho * t[0].sin(), L3 + L1 * t[1].sin() - L2 * t[2].cos(), -L4 + rho * t[0].cos())
}

/// rad, the joint angles at a tip (m); `None` out of reach.
pub fn inverse(x: Vector3<f64>) -> Option<[f64; 3]> {
    let (out, up) = (x.z + L4, x.y - L3);
    let reach = x.x.hypot(out);
    let r = reach.hypot(up);
    let cosine = |c: f64| (-1.0..=1.0).contains(&c).then(|| c.acos());
    let b = up.atan2(reach);
    let g = cosine((L1 * L1 + r * r - L2 * L2) / (2.0 * L1 * r))?;
    let a = cosine((L1 * L1 + L2 * L2 - r * r) / (2.0 * L1 * L2))?;
    let t2 = g + b;
    Some([-x.x.atan2(out), t2, t2 + a - std::f64::consts::FRAC_PI_2])
}

/// m/rad, how the tip moves with the joints.
pub fn jacobian(t: [f64; 3]) -> Matrix3<f64> {
    let [(s1, c1), (s2, c2), (s3, c3)] = t.map(f64::sin_cos);
    let rho = L1 * c2 + L2 * s3;
    Matrix3::new(
        -c1 * rho,
        s1 * L1 * s2,
        -s1 * L2 * c3, //
        0.0,
        L1 * c2,
        L2 * s3, //
        -s1 * rho,
        -c1 * L1 * s2,
        c1 * L2 * c3,
    )
}

/// As the encoders tell it.
pub fn quantised(t: [f64; 3]) -> [f64; 3] {
    t.map(|angle| (angle / QUANTUM).round() * QUANTUM)
}
