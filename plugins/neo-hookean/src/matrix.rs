//! 3 x 3 matrices, and what of them an element needs. Row-major; nothing allocates.

/// `m[row][column]`
pub(crate) type M3 = [[f64; 3]; 3];

pub(crate) const IDENTITY: M3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[inline(always)]
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `m v`
#[inline(always)]
pub(crate) fn times(m: &M3, v: [f64; 3]) -> [f64; 3] {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// `a b`
#[inline(always)]
pub(crate) fn product(a: &M3, b: &M3) -> M3 {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// `a b^T`
#[inline(always)]
pub(crate) fn product_transposed(a: &M3, b: &M3) -> M3 {
    a.map(|row| b.map(|other| dot(row, other)))
}

#[inline(always)]
pub(crate) fn transposed(m: &M3) -> M3 {
    [0, 1, 2].map(|j| [m[0][j], m[1][j], m[2][j]])
}

#[inline(always)]
pub(crate) fn determinant(m: &M3) -> f64 {
    dot(m[0], cross(m[1], m[2]))
}

/// The matrix of cofactors, dJ/dF.
#[inline(always)]
pub(crate) fn cofactors(m: &M3) -> M3 {
    [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])]
}

/// Sum of squares.
#[inline(always)]
pub(crate) fn squared(m: &M3) -> f64 {
    dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2])
}

/// Sweeps of Jacobi's method. It converges quadratically: five are plenty, and a matrix of NaN must end too.
const SWEEPS: usize = 10;

/// One rotation of Jacobi's: makes entry (p, q) zero. Inlined, so that the indices are known where it is called.
#[inline(always)]
fn turn(a: &mut M3, v: &mut M3, p: usize, q: usize, r: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    let (apq, arp, arq) = (a[p][q], a[r][p], a[r][q]);
    a[p][p] -= t * apq;
    a[q][q] += t * apq;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    (a[r][p], a[r][q]) = (c * arp - s * arq, s * arp + c * arq);
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    for row in v {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

/// Eigenvalues of a symmetric matrix, and its eigenvectors as columns of a rotation (Jacobi 1846).
pub(crate) fn eigen(mut a: M3) -> ([f64; 3], M3) {
    let mut v = IDENTITY;
    let size = squared(&a);
    for _ in 0..SWEEPS {
        let off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        if off <= 1e-32 * size {
            break;
        }
        turn(&mut a, &mut v, 0, 1, 2);
        turn(&mut a, &mut v, 0, 2, 1);
        turn(&mut a, &mut v, 1, 2, 0);
    }
    ([a[0][0], a[1][1], a[2][2]], v)
}

/// `F = U diag(s) V^T` with U and V rotations: the least of s has the sign of det F (Irving, Teran and Fedkiw 2004).
pub(crate) fn singular(f: &M3) -> (M3, [f64; 3], M3) {
    let (values, v) = eigen(product(&transposed(f), f));
    let columns = transposed(&v);
    let mut order = [0, 1, 2];
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if values[order[i]] < values[order[j]] {
            order.swap(i, j);
        }
    }
    let (v0, v1) = (columns[order[0]], columns[order[1]]);
    let v2 = cross(v0, v1);
    let unit = |w: [f64; 3]| {
        let length = dot(w, w).sqrt();
        (length, w.map(|c| c / length))
    };
    let (s0, u0) = unit(times(f, v0));
    if s0 == 0.0 {
        return (IDENTITY, [0.0; 3], IDENTITY);
    }
    let w = times(f, v1);
    let along = dot(w, u0);
    let (left, mut u1) = unit([0, 1, 2].map(|i| w[i] - along * u0[i]));
    if left <= 1e-14 * s0 {
        // Flat to a line: any direction across it will do.
        let least = [0, 1, 2].into_iter().min_by(|a, b| u0[*a].abs().total_cmp(&u0[*b].abs())).unwrap_or(0);
        u1 = unit(cross(u0, IDENTITY[least])).1;
    }
    let u2 = cross(u0, u1);
    let s = [s0, dot(u1, w), dot(u2, times(f, v2))];
    (transposed(&[u0, u1, u2]), s, transposed(&[v0, v1, v2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn back((u, s, v): (M3, [f64; 3], M3)) -> M3 {
        let scaled = u.map(|row| [row[0] * s[0], row[1] * s[1], row[2] * s[2]]);
        product_transposed(&scaled, &v)
    }

    #[test]
    fn singular_values_come_back_to_the_matrix() {
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for flat in [1.0, 1e-3, 1e-9, 0.0] {
            for _ in 0..200 {
                let mut f = [[0.0; 3]; 3].map(|row| row.map(|_: f64| next()));
                f[2] = [0, 1, 2].map(|i| flat * f[2][i] + (1.0 - flat) * (f[0][i] - f[1][i]));
                let (u, s, v) = singular(&f);
                for rotation in [u, v] {
                    assert!((determinant(&rotation) - 1.0).abs() < 1e-12);
                    let square = product_transposed(&rotation, &rotation);
                    assert!((0..9).all(|i| (square[i / 3][i % 3] - IDENTITY[i / 3][i % 3]).abs() < 1e-12));
                }
                let again = back((u, s, v));
                assert!((0..9).all(|i| (again[i / 3][i % 3] - f[i / 3][i % 3]).abs() < 1e-12), "{f:?} {again:?}");
                assert!(s[0] >= s[1] && s[1] >= s[2].abs() - 1e-9, "{s:?}");
            }
        }
    }

    #[test]
    fn collapsed_matrices_have_rotations_too() {
        let line = [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0; 3]];
        for f in [[[0.0; 3]; 3], line] {
            let (u, s, v) = singular(&f);
            let again = back((u, s, v));
            assert!((0..9).all(|i| (again[i / 3][i % 3] - f[i / 3][i % 3]).abs() < 1e-12), "{s:?}");
            assert!((determinant(&u) - 1.0).abs() < 1e-12 && (determinant(&v) - 1.0).abs() < 1e-12);
        }
    }
}
