//! 3 x 3 matrices, and what of them an element needs. Row-major; nothing allocates, and nothing branches on a lane.

use pliant_plugin_api::lanes::Real;

pub(crate) type V3<T = f64> = [T; 3];

/// `m[row][column]`
pub(crate) type M3<T = f64> = [[T; 3]; 3];

#[cfg(test)]
const IDENTITY: M3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[inline(always)]
pub(crate) fn dot<T: Real>(a: V3<T>, b: V3<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn scaled<T: Real>(a: V3<T>, by: T) -> V3<T> {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// `m v`
#[inline(always)]
pub(crate) fn times<T: Real>(m: &M3<T>, v: V3<T>) -> V3<T> {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// `a b`
#[inline(always)]
pub(crate) fn product<T: Real>(a: &M3<T>, b: &M3<T>) -> M3<T> {
    product_transposed(a, &transposed(b))
}

/// `a b^T`
#[inline(always)]
pub(crate) fn product_transposed<T: Real>(a: &M3<T>, b: &M3<T>) -> M3<T> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = dot(a[i], b[j]);
        }
    }
    out
}

#[inline(always)]
pub(crate) fn transposed<T: Real>(m: &M3<T>) -> M3<T> {
    [[m[0][0], m[1][0], m[2][0]], [m[0][1], m[1][1], m[2][1]], [m[0][2], m[1][2], m[2][2]]]
}

#[inline(always)]
pub(crate) fn determinant<T: Real>(m: &M3<T>) -> T {
    dot(m[0], cross(m[1], m[2]))
}

/// The matrix of cofactors, dJ/dF.
#[inline(always)]
pub(crate) fn cofactors<T: Real>(m: &M3<T>) -> M3<T> {
    [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])]
}

/// Sum of squares.
#[inline(always)]
pub(crate) fn squared<T: Real>(m: &M3<T>) -> T {
    dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2])
}

/// Sweeps of Jacobi's method. It converges quadratically: five are plenty, and a matrix of NaN must end too.
const SWEEPS: usize = 10;
/// Of the sum of all squares, that of entries off the diagonal that are as good as none.
const NONE: f64 = 1e-32;

/// One rotation of Jacobi's: makes entry (p, q) zero, unless `off` is not above `none`. Inlined, so that the indices are known where it
/// is called.
#[inline(always)]
fn turn<T: Real>((a, v): (&mut M3<T>, &mut M3<T>), (p, q, r): (usize, usize, usize), (none, off): (T, T)) {
    let (zero, one, apq) = (off.splat(0.0), off.splat(1.0), a[p][q]);
    let (apart, twice) = (a[q][q] - a[p][p], apq + apq);
    let below = apart.abs() + (apart * apart + twice * twice).sqrt();
    let t = apart.if_less(zero, -twice, twice) / below.max(twice.abs()).max(below.min_positive());
    // One that is done must not depend on others that are not.
    let t = none.if_less(off, t, zero);
    let c = one / (t * t + one).sqrt();
    let s = t * c;
    let (arp, arq) = (a[r][p], a[r][q]);
    a[p][p] = a[p][p] - t * apq;
    a[q][q] = a[q][q] + t * apq;
    let left = none.if_less(off, zero, apq);
    (a[p][q], a[q][p]) = (left, left);
    (a[r][p], a[r][q]) = (c * arp - s * arq, s * arp + c * arq);
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    for row in v {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

/// Eigenvalues of a symmetric matrix, and its eigenvectors as columns of a rotation (Jacobi 1846).
#[inline(always)]
pub(crate) fn eigen<T: Real>(mut a: M3<T>) -> (V3<T>, M3<T>) {
    let none = squared(&a) * NONE;
    let (zero, one) = (none.splat(0.0), none.splat(1.0));
    let mut v = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    for _ in 0..SWEEPS {
        let off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        if !(none - off).any_below(0.0) {
            break;
        }
        turn((&mut a, &mut v), (0, 1, 2), (none, off));
        turn((&mut a, &mut v), (0, 2, 1), (none, off));
        turn((&mut a, &mut v), (1, 2, 0), (none, off));
    }
    ([a[0][0], a[1][1], a[2][2]], v)
}

/// Puts the greater of two values first, and its vector.
#[inline(always)]
fn ordered<T: Real>(values: &mut V3<T>, vectors: &mut M3<T>, i: usize, j: usize) {
    let (a, b) = (values[i], values[j]);
    (values[i], values[j]) = (a.if_less(b, b, a), a.if_less(b, a, b));
    for k in 0..3 {
        let (p, q) = (vectors[i][k], vectors[j][k]);
        (vectors[i][k], vectors[j][k]) = (a.if_less(b, q, p), a.if_less(b, p, q));
    }
}

/// `F = U diag(s) V^T` with U and V rotations: the least of s has the sign of det F (Irving, Teran and Fedkiw 2004).
#[inline(always)]
pub(crate) fn singular<T: Real>(f: &M3<T>) -> (M3<T>, V3<T>, M3<T>) {
    let columns = transposed(f);
    let (mut values, v) = eigen(product_transposed(&columns, &columns));
    let mut v = transposed(&v);
    ordered(&mut values, &mut v, 0, 1);
    ordered(&mut values, &mut v, 1, 2);
    ordered(&mut values, &mut v, 0, 1);
    v[2] = cross(v[0], v[1]);
    let (zero, one, least) = (values[0].splat(0.0), values[0].splat(1.0), values[0].min_positive());
    let longest = times(f, v[0]);
    let s0 = dot(longest, longest).sqrt();
    let u0 = scaled(longest, one / s0.max(least));
    let w = times(f, v[1]);
    let along = dot(u0, w);
    let rest = [w[0] - along * u0[0], w[1] - along * u0[1], w[2] - along * u0[2]];
    let left = dot(rest, rest).sqrt();
    let mut u1 = scaled(rest, one / left.max(least));
    let flat = s0 * 1e-14;
    if (left - flat).any_below(f64::MIN_POSITIVE) {
        // Flat to a line: any direction across it will do.
        let other = across(u0);
        for k in 0..3 {
            u1[k] = flat.if_less(left, u1[k], other[k]);
        }
    }
    let u2 = cross(u0, u1);
    let s = [s0, dot(u1, w), dot(u2, times(f, v[2]))];
    // Where there is no direction at all, those of the axes.
    let (mut u, mut v) = (transposed(&[u0, u1, u2]), transposed(&v));
    for i in 0..3 {
        for j in 0..3 {
            let axis = if i == j { one } else { zero };
            (u[i][j], v[i][j]) = (s0.if_less(least, axis, u[i][j]), s0.if_less(least, axis, v[i][j]));
        }
    }
    (u, s, v)
}

/// A unit vector across one.
#[inline(always)]
fn across<T: Real>(a: V3<T>) -> V3<T> {
    let (zero, one, half) = (a[0].splat(0.0), a[0].splat(1.0), a[0].splat(0.5));
    let [x, y, z] = [a[0].abs(), a[1].abs(), a[2].abs()];
    // The axis it has the least of.
    let first = y.if_less(x, zero, z.if_less(x, zero, one));
    let second = half.if_less(first, zero, z.if_less(y, zero, one));
    let b = cross(a, [first, second, one - first - second]);
    scaled(b, one / dot(b, b).sqrt().max(zero.min_positive()))
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
