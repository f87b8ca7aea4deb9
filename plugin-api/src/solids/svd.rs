//! Eigenvalues of symmetric 3 x 3 matrices and singular values of any, on scalars and vector registers.
//!
//! Nothing branches on a single lane: a lane that has converged, or is degenerate, is selected by comparison, so that an element's result
//! does not depend on its neighbours in the register.

use super::matrix::{Mat3, apply, norm_squared, product_transposed, transposed};
use crate::lanes::{Real, Vec3};

/// The most sweeps of Jacobi's method. It converges quadratically, five are enough; the bound ends the loop for NaN.
const MAX_SWEEPS: usize = 10;
/// Sum of squares of the off-diagonal entries over that of all entries at which a matrix counts as diagonal.
const CONVERGED: f64 = 1e-32;
/// Second singular value over the first below which a matrix counts as of rank one.
const RANK_ONE: f64 = 1e-14;

/// Eigenvalues of a symmetric matrix, and its eigenvectors as the columns of a rotation.
pub struct Eigen<T> {
    /// Eigenvalues, in no order.
    pub values: Vec3<T>,
    /// Eigenvectors, as columns in the order of the values.
    pub vectors: Mat3<T>,
}

/// The state of Jacobi's method (1846): `a = vectors^T (matrix) vectors`.
struct Jacobi<T> {
    a: Mat3<T>,
    vectors: Mat3<T>,
    /// Sum of squares of the off-diagonal entries at the start of the sweep.
    off_diagonal: T,
    /// The sum at which the matrix counts as diagonal.
    converged: T,
}

impl<T: Real> Jacobi<T> {
    /// Rotates in the plane of axes p and q so that entry (p, q) becomes zero; r is the third axis. Lanes that have converged stay as
    /// they are. Inlined, so that the indices are constants.
    #[inline(always)]
    fn rotate(&mut self, p: usize, q: usize, r: usize) {
        let Self { a, vectors, off_diagonal, converged } = self;
        let (off_diagonal, converged) = (*off_diagonal, *converged);
        let (zero, one, apq) = (off_diagonal.splat(0.0), off_diagonal.splat(1.0), a[p][q]);
        // The smaller root t = tan of the angle, in the form that does not cancel.
        let (difference, twice) = (a[q][q] - a[p][p], apq + apq);
        let denominator = difference.abs() + (difference * difference + twice * twice).sqrt();
        let t = difference.if_less(zero, -twice, twice) / denominator.max(twice.abs()).max(denominator.min_positive());
        let t = converged.if_less(off_diagonal, t, zero);
        let c = one / (t * t + one).sqrt();
        let s = t * c;
        let (arp, arq) = (a[r][p], a[r][q]);
        a[p][p] = a[p][p] - t * apq;
        a[q][q] = a[q][q] + t * apq;
        let remaining = converged.if_less(off_diagonal, zero, apq);
        (a[p][q], a[q][p]) = (remaining, remaining);
        (a[r][p], a[r][q]) = (c * arp - s * arq, s * arp + c * arq);
        (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
        for row in vectors {
            (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
        }
    }
}

/// Eigenvalues and eigenvectors of a symmetric matrix, in no order.
#[inline(always)]
pub fn symmetric_eigen<T: Real>(a: Mat3<T>) -> Eigen<T> {
    let converged = norm_squared(&a) * CONVERGED;
    let (zero, one) = (converged.splat(0.0), converged.splat(1.0));
    let identity = [Vec3([one, zero, zero]), Vec3([zero, one, zero]), Vec3([zero, zero, one])];
    let mut jacobi = Jacobi { a, vectors: identity, off_diagonal: zero, converged };
    for _ in 0..MAX_SWEEPS {
        let a = &jacobi.a;
        let off_diagonal = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        if !(converged - off_diagonal).any_below(0.0) {
            break;
        }
        jacobi.off_diagonal = off_diagonal;
        jacobi.rotate(0, 1, 2);
        jacobi.rotate(0, 2, 1);
        jacobi.rotate(1, 2, 0);
    }
    let Jacobi { a, vectors, .. } = jacobi;
    Eigen { values: Vec3([a[0][0], a[1][1], a[2][2]]), vectors }
}

/// `F = U diag(s) V^T` with rotations U and V.
pub struct Svd<T> {
    /// Left singular vectors, as columns.
    pub u: Mat3<T>,
    /// Descending; the last one has the sign of det F.
    pub s: Vec3<T>,
    /// Right singular vectors, as columns.
    pub v: Mat3<T>,
}

/// Singular values with the sign convention of Irving, Teran and Fedkiw (2004).
#[inline(always)]
pub fn svd<T: Real>(f: &Mat3<T>) -> Svd<T> {
    let columns = transposed(f);
    let Eigen { mut values, vectors } = symmetric_eigen(product_transposed(&columns, &columns));
    // By rows from here on: `v[i]` is the direction of singular value i.
    let mut v = transposed(&vectors);
    sort_pair(&mut values, &mut v, 0, 1);
    sort_pair(&mut values, &mut v, 1, 2);
    sort_pair(&mut values, &mut v, 0, 1);
    v[2] = v[0].cross(v[1]);
    let (zero, one, least) = (values[0].splat(0.0), values[0].splat(1.0), values[0].min_positive());
    let first = apply(f, v[0]);
    let s0 = first.norm();
    let u0 = first * (one / s0.max(least));
    let second = apply(f, v[1]);
    let across = second - u0 * u0.dot(second);
    let norm = across.norm();
    let mut u1 = across * (one / norm.max(least));
    let rank_one = s0 * RANK_ONE;
    if (norm - rank_one).any_below(f64::MIN_POSITIVE) {
        // Any perpendicular direction will do.
        let other = perpendicular(u0);
        for k in 0..3 {
            u1[k] = rank_one.if_less(norm, u1[k], other[k]);
        }
    }
    let u2 = u0.cross(u1);
    let s = Vec3([s0, u1.dot(second), u2.dot(apply(f, v[2]))]);
    let (mut u, mut v) = (transposed(&[u0, u1, u2]), transposed(&v));
    // A zero matrix has no directions: U and V are the identity.
    for i in 0..3 {
        for j in 0..3 {
            let identity = if i == j { one } else { zero };
            (u[i][j], v[i][j]) = (s0.if_less(least, identity, u[i][j]), s0.if_less(least, identity, v[i][j]));
        }
    }
    Svd { u, s, v }
}

/// Exchanges values i and j, and their vectors, unless value i is the greater one.
#[inline(always)]
fn sort_pair<T: Real>(values: &mut Vec3<T>, vectors: &mut Mat3<T>, i: usize, j: usize) {
    let (a, b) = (values[i], values[j]);
    (values[i], values[j]) = (a.if_less(b, b, a), a.if_less(b, a, b));
    for k in 0..3 {
        let (p, q) = (vectors[i][k], vectors[j][k]);
        (vectors[i][k], vectors[j][k]) = (a.if_less(b, q, p), a.if_less(b, p, q));
    }
}

/// A unit vector perpendicular to `a`.
#[inline(always)]
fn perpendicular<T: Real>(a: Vec3<T>) -> Vec3<T> {
    let (zero, one, half) = (a[0].splat(0.0), a[0].splat(1.0), a[0].splat(0.5));
    let [x, y, z] = [a[0].abs(), a[1].abs(), a[2].abs()];
    // The axis `a` has the smallest component along.
    let axis_x = y.if_less(x, zero, z.if_less(x, zero, one));
    let axis_y = half.if_less(axis_x, zero, z.if_less(y, zero, one));
    let b = a.cross(Vec3([axis_x, axis_y, one - axis_x - axis_y]));
    b * (one / b.norm().max(zero.min_positive()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::Random;
    use crate::solids::matrix::{IDENTITY, determinant};

    fn compose(Svd { u, s, v }: &Svd<f64>) -> Mat3 {
        let scaled = u.map(|row| Vec3([row[0] * s[0], row[1] * s[1], row[2] * s[2]]));
        product_transposed(&scaled, v)
    }

    fn largest_difference(a: &Mat3, b: &Mat3) -> f64 {
        (0..9).map(|i| (a[i / 3][i % 3] - b[i / 3][i % 3]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn svd_composes_to_the_matrix() {
        let mut random = Random(1);
        for flatness in [1.0, 1e-3, 1e-9, 0.0] {
            for _ in 0..200 {
                let mut f: Mat3 = [(); 3].map(|()| Vec3(random.vector()));
                f[2] = f[2] * flatness + (f[0] - f[1]) * (1.0 - flatness);
                let svd = svd(&f);
                for rotation in [svd.u, svd.v] {
                    assert!((determinant(&rotation) - 1.0).abs() < 1e-12);
                    let square = product_transposed(&rotation, &rotation);
                    assert!(largest_difference(&square, &IDENTITY) < 1e-12);
                }
                assert!(largest_difference(&compose(&svd), &f) < 1e-12, "{f:?} {:?}", compose(&svd));
                let s = svd.s;
                assert!(s[0] >= s[1] && s[1] >= s[2].abs() - 1e-9, "{s:?}");
            }
        }
    }

    #[test]
    fn matrices_of_rank_zero_and_one_have_rotations_too() {
        let rank_one = [Vec3([1.0, 2.0, 3.0]), Vec3([2.0, 4.0, 6.0]), Vec3([0.0; 3])];
        for f in [[Vec3([0.0; 3]); 3], rank_one] {
            let svd = svd(&f);
            assert!(largest_difference(&compose(&svd), &f) < 1e-12, "{:?}", svd.s);
            assert!((determinant(&svd.u) - 1.0).abs() < 1e-12 && (determinant(&svd.v) - 1.0).abs() < 1e-12);
        }
    }
}
