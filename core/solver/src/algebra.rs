//! Vectors and 3 x 3 blocks.

use nalgebra::Matrix3;

pub use pliant_mesh::geometry::Vec3;

/// A 3 x 3 block, row-major.
pub type Block = [f64; 9];
/// A 3 x 3 block in single precision, row-major.
pub type SingleBlock = [f32; 9];

/// A block as a matrix.
#[inline(always)]
pub fn matrix3(block: &Block) -> Matrix3<f64> {
    Matrix3::from_row_slice(block)
}

/// Speeds below this are set to zero, m/s.
const DENORMAL_SPEED: f64 = 1e-40;

/// Sets components of a velocity below 1e-40 m/s to zero. A touch on a flat sheet spreads as ever smaller numbers, and processors take a
/// hundred times as long for denormal ones.
#[inline(always)]
pub fn flush_denormals(v: Vec3) -> Vec3 {
    v.map(|c| if c.abs() < DENORMAL_SPEED { 0.0 } else { c })
}

/// The inverse of a symmetric block, by cofactors; `None` if it is singular or not finite.
pub fn symmetric_inverse(m: &Block) -> Option<Block> {
    let (c0, c1, c2) = (m[4] * m[8] - m[5] * m[5], m[5] * m[2] - m[1] * m[8], m[1] * m[5] - m[4] * m[2]);
    let det = m[0] * c0 + m[1] * c1 + m[2] * c2;
    if !(det.is_finite() && det != 0.0) {
        return None;
    }
    let (c3, c4, c5) = (m[0] * m[8] - m[2] * m[2], m[2] * m[1] - m[0] * m[5], m[0] * m[4] - m[1] * m[1]);
    let i = 1.0 / det;
    Some([c0 * i, c1 * i, c2 * i, c1 * i, c3 * i, c4 * i, c2 * i, c4 * i, c5 * i])
}

/// Condition of a block up to which its inverse in single precision keeps the least eigenvalue within a fifth.
pub const MAX_BLOCK_CONDITION: f64 = 1e6;

/// Estimates the condition of a block: the largest entry of its diagonal times that of its inverse; infinite for a singular block.
pub fn condition(block: &Block, inverse: &Block) -> f64 {
    let most = |b: &Block| b[0].max(b[4]).max(b[8]);
    let condition = most(block) * most(inverse);
    if condition.is_nan() { f64::INFINITY } else { condition }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_is_one() {
        let a = [4.0, 1.0, -0.5, 1.0, 3.0, 0.25, -0.5, 0.25, 2.0];
        let b = symmetric_inverse(&a).unwrap();
        for i in 0..9 {
            let product: f64 = (0..3).map(|k| a[3 * (i / 3) + k] * b[3 * k + i % 3]).sum();
            assert!((product - f64::from(u8::from(i % 4 == 0))).abs() < 1e-15, "{i}: {product}");
        }
        assert!(symmetric_inverse(&[0.0; 9]).is_none() && symmetric_inverse(&[f64::NAN; 9]).is_none());
    }
}
