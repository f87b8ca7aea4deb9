//! Rotation vectors as unit quaternions.

use std::f64::consts::PI;

/// The unit quaternion (x, y, z, w) of a rotation vector in degrees: axis times angle.
pub fn quaternion(degrees: [f64; 3]) -> [f64; 4] {
    let vector = degrees.map(|d| d * (PI / 180.0));
    let angle = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    if angle == 0.0 {
        return [0.0, 0.0, 0.0, 1.0];
    }
    let scale = libm::sin(0.5 * angle) / angle;
    [scale * vector[0], scale * vector[1], scale * vector[2], libm::cos(0.5 * angle)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_is_one_and_no_turn_is_the_identity() {
        let half = 0.5_f64.sqrt();
        let turned = quaternion([0.0, 90.0, 0.0]);
        assert!((turned[1] - half).abs() < 1e-15 && (turned[3] - half).abs() < 1e-15, "{turned:?}");
        assert_eq!(quaternion([0.0; 3]), [0.0, 0.0, 0.0, 1.0]);
    }
}
