//! The orientation in a transform of the driver.

/// The unit quaternion x y z w of the rotation in a column-major 4 x 4 transform (Shepperd 1978); the identity if the transform has no
/// rotation.
pub(crate) fn quaternion(transform: &[f64; 16]) -> [f64; 4] {
    let m = |row: usize, column: usize| transform[4 * column + row];
    let trace = m(0, 0) + m(1, 1) + m(2, 2);
    let mut q = [0.0; 4];
    // The component with the largest magnitude is computed first: dividing by it keeps the others accurate.
    let largest = (0..3).fold(3, |best, i| {
        let value = |i: usize| if i == 3 { trace } else { m(i, i) };
        if value(i) > value(best) { i } else { best }
    });
    if largest == 3 {
        q[3] = 1.0 + trace;
        for i in 0..3 {
            q[i] = m((i + 2) % 3, (i + 1) % 3) - m((i + 1) % 3, (i + 2) % 3);
        }
    } else {
        let (i, j, k) = (largest, (largest + 1) % 3, (largest + 2) % 3);
        q[i] = 1.0 + m(i, i) - m(j, j) - m(k, k);
        q[j] = m(j, i) + m(i, j);
        q[k] = m(k, i) + m(i, k);
        q[3] = m(k, j) - m(j, k);
    }
    let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if norm > 1e-9 { q.map(|c| c / norm) } else { [0.0, 0.0, 0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The column-major transform of a unit quaternion.
    fn transform([x, y, z, w]: [f64; 4]) -> [f64; 16] {
        let rows = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        std::array::from_fn(|i| if i % 4 < 3 && i / 4 < 3 { rows[i % 4][i / 4] } else { 0.0 })
    }

    #[test]
    fn a_transform_has_the_quaternion_it_was_made_from() {
        for q in [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.5, 0.5, -0.5, 0.5], [0.1, -0.7, 0.7, 0.1]] {
            let norm = q.iter().map(|c: &f64| c * c).sum::<f64>().sqrt();
            let q = q.map(|c| c / norm);
            let computed = quaternion(&transform(q));
            // q and -q are the same rotation.
            let dot: f64 = q.iter().zip(computed).map(|(a, b)| a * b).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-12, "{q:?} {computed:?}");
        }
        assert_eq!(quaternion(&[0.0; 16])[3], 1.0);
    }
}
