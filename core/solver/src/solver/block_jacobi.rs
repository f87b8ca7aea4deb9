//! Inverses of the diagonal blocks for the block Jacobi preconditioner, eight free nodes at a time.

use super::filtered_system::FilteredSystem;
use crate::algebra::{condition, matrix3};
use crate::constraint::{Constraint, constrained_inverse};
use crate::lanes::Sixteen;
use crate::lanes::symmetric::{PLACES, put_block};

/// Number of nodes processed together.
const LANES: usize = 8;

/// Computes the inverses of the diagonal blocks of the nodes from `first`, times `weight`, in units of A^-1. Returns `sum_i x_i . A_ii x_i` of
/// the positions, in m^2 times the unit of A, and the largest condition number of a block, estimated as the largest diagonal entry of the
/// block times that of its inverse.
pub struct BlockInverses<'a> {
    pub system: &'a FilteredSystem<'a>,
    pub weight: f64,
    pub first: usize,
    pub out: &'a mut [[Sixteen; 6]],
}

type Plane = [f64; LANES];

impl pulp::NullaryFnOnce for BlockInverses<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn call(self) -> (f64, f64) {
        let Self { system: FilteredSystem { matrix, constraints, positions, .. }, weight, first, out } = self;
        let (mut quadratic_form, mut max_condition, n) = (0.0, 0.0_f64, constraints.len());
        for at in 0..2 * out.len() {
            let (out, half, first) = (&mut out[at / 2], at % 2 * LANES, first + at * LANES);
            let count = n.saturating_sub(first).min(LANES);
            let (mut m, mut x): ([Plane; 6], [Plane; 3]) = ([[1.0; LANES]; 6], [[0.0; LANES]; 3]);
            for lane in 0..count {
                let (block, place) = (matrix.diagonal(first + lane), positions[first + lane]);
                for (e, from) in PLACES.into_iter().enumerate() {
                    m[e][lane] = block[from];
                }
                for c in 0..3 {
                    x[c][lane] = place[c];
                }
            }
            let (inverse, conditions) = inverted(&m, weight);
            let quadratic_forms = quadratic_forms(&m, &x);
            for e in 0..6 {
                out[e][half..half + LANES].copy_from_slice(&inverse[e]);
            }
            for lane in 0..count {
                let (block, constraint) = (matrix.diagonal(first + lane), &constraints[first + lane]);
                // Singular blocks and constrained nodes are inverted one by one.
                let is_plain = matches!(constraint, Constraint::Free) && conditions[lane].is_finite();
                if is_plain {
                    max_condition = max_condition.max(conditions[lane]);
                    quadratic_form += quadratic_forms[lane];
                } else {
                    let exact = constrained_inverse(block, constraint);
                    max_condition = max_condition.max(condition(block, &exact));
                    put_block(out, half + lane, &exact.map(|c| weight * c));
                    quadratic_form += positions[first + lane].dot(&(matrix3(block) * positions[first + lane]));
                }
            }
            for lane in count..LANES {
                put_block(out, half + lane, &[0.0; 9]);
            }
        }
        (quadratic_form, max_condition)
    }
}

/// Inverses by cofactors, times `weight`, and the estimated condition number of each block.
#[inline(always)]
fn inverted(m: &[Plane; 6], weight: f64) -> ([[f32; LANES]; 6], Plane) {
    let (mut out, mut conditions) = ([[0.0; LANES]; 6], [0.0; LANES]);
    for l in 0..LANES {
        let [a, b, c, d, e, f] = [m[0][l], m[1][l], m[2][l], m[3][l], m[4][l], m[5][l]];
        let (c0, c1, c2) = (d * f - e * e, e * c - b * f, b * e - d * c);
        let (c3, c4, c5) = (a * f - c * c, c * b - a * e, a * d - b * b);
        let i = 1.0 / (a * c0 + b * c1 + c * c2);
        let most = |p: f64, q: f64| if p > q { p } else { q };
        conditions[l] = most(most(a, d), f) * most(most(c0 * i, c3 * i), c5 * i);
        let i = weight * i;
        out[0][l] = (c0 * i) as f32;
        out[1][l] = (c1 * i) as f32;
        out[2][l] = (c2 * i) as f32;
        out[3][l] = (c3 * i) as f32;
        out[4][l] = (c4 * i) as f32;
        out[5][l] = (c5 * i) as f32;
    }
    (out, conditions)
}

/// Quadratic forms `x . m x` of eight nodes.
#[inline(always)]
fn quadratic_forms(m: &[Plane; 6], [x, y, z]: &[Plane; 3]) -> Plane {
    let mut quadratic_forms = [0.0; LANES];
    for l in 0..LANES {
        let across = m[1][l] * x[l] * y[l] + m[2][l] * x[l] * z[l] + m[4][l] * y[l] * z[l];
        quadratic_forms[l] = m[0][l] * x[l] * x[l] + m[3][l] * y[l] * y[l] + m[5][l] * z[l] * z[l] + (across + across);
    }
    quadratic_forms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::MAX_BLOCK_CONDITION;
    use crate::algebra::Vec3;
    use crate::matrix::Matrix;
    use pulp::NullaryFnOnce;

    #[test]
    fn inverses_are_those_of_one_node() {
        let n = 19;
        let mut matrix = Matrix::default();
        matrix.set_pattern(n, |_| {});
        let wave = |i: usize| (1.7 * i as f64).sin();
        for i in 0..n {
            let [a, b, c] = [wave(3 * i), wave(3 * i + 1), wave(3 * i + 2)];
            *matrix.diagonal_mut(i) = [4.0 + a, b, c, b, 3.0 + b, a, c, a, 5.0 + c].map(|v| 1e3 * v);
        }
        *matrix.diagonal_mut(5) = [0.0; 9];
        let mut constraints = vec![Constraint::Free; n];
        (constraints[2], constraints[11]) = (Constraint::Fixed, Constraint::Plane(Vec3::new(0.0, 0.6, 0.8)));
        let x: Vec<_> = (0..n).map(|i| Vec3::new(wave(i), wave(i + 50), wave(i + 90))).collect();
        let mut out = vec![[[7.0; 16]; 6]; n.div_ceil(16)];
        let mut run = |matrix: &Matrix| {
            let (b, constraints, positions) = (&x[..], &constraints[..], &x[..]);
            let system = FilteredSystem {
                matrix,
                b,
                z: b,
                constraints,
                positions,
                displacement_per_unit: 1.0,
                same_matrix: false,
                tolerance: 1.0,
                max_iterations: 1,
                interrupts: None,
            };
            BlockInverses { system: &system, weight: 0.5, first: 0, out: &mut out }.call()
        };
        let (quadratic_form, condition) = run(&matrix);
        assert!(condition <= MAX_BLOCK_CONDITION);
        let expected: f64 = (0..n).map(|i| x[i].dot(&(matrix3(matrix.diagonal(i)) * x[i]))).sum();
        assert!((quadratic_form - expected).abs() < 1e-12 * expected.abs(), "{quadratic_form} {expected}");
        let before = matrix.diagonal(7).to_owned();
        *matrix.diagonal_mut(7) = [1e6, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1e-3];
        assert!(run(&matrix).1 > MAX_BLOCK_CONDITION);
        *matrix.diagonal_mut(7) = before;
        assert!(run(&matrix).1 <= MAX_BLOCK_CONDITION);
        for i in 0..n {
            let exact = constrained_inverse(matrix.diagonal(i), &constraints[i]).map(|c| 0.5 * c);
            for (e, place) in PLACES.into_iter().enumerate() {
                let (got, exact) = (f64::from(out[i / 16][e][i % 16]), exact[place]);
                assert!((got - exact).abs() <= 1e-6 * exact.abs().max(1e-4), "{i}: {got} {exact}");
            }
        }
        assert!((n..32).all(|i| (0..6).all(|e| out[i / 16][e][i % 16] == 0.0)));
    }
}
