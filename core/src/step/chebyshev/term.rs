//! One term of the iteration, on any vector unit.

use super::Chebyshev;
use super::rows::Rows;
use super::slices::{LANES, Slice};
use pulp::{Simd, WithSimd, bytemuck};

/// From the solution so far, and the one before in whose place it is put, the next one.
pub struct Term<'a> {
    pub of: &'a Chebyshev,
    pub first: usize,
    pub next: &'a mut [Slice],
    pub factors: (f64, f64),
}

impl WithSimd for Term<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { of, first, next, factors } = self;
        let (load, solution) = (&of.load.all()[1 + first..], of.solution.flat());
        match &of.rows {
            Rows::Alike { start, partner, value } => {
                let value = value.all();
                for (at, (next, load)) in next.iter_mut().zip(load).enumerate() {
                    let (slice, own) = (first + at, LANES * (first + at + 1));
                    let all = start[slice]..start[slice + 1];
                    let (partner, value) = (&partner[all.clone()], &value[all]);
                    for half in (0..LANES).step_by(S::F64_LANES) {
                        let m = read(simd, &solution[own..own + LANES], half);
                        let mut sum = m;
                        if let ([a, b, c, d], [u, v, w, x]) = (partner, value) {
                            // Most slices: without a loop, whose end is guessed wrong where the next one is longer.
                            let one = simd
                                .add_f64s(product(simd, solution, *a, u, half), product(simd, solution, *b, v, half));
                            let two = simd
                                .add_f64s(product(simd, solution, *c, w, half), product(simd, solution, *d, x, half));
                            sum = simd.add_f64s(sum, simd.add_f64s(one, two));
                        } else {
                            for (&partner, value) in partner.iter().zip(value) {
                                sum = simd.add_f64s(sum, product(simd, solution, partner, value, half));
                            }
                        }
                        let before = read(simd, next, half);
                        let rest = simd.sub_f64s(read(simd, load, half), sum);
                        let turn = simd.mul_f64s(simd.splat_f64s(factors.1), simd.sub_f64s(m, before));
                        let step = simd.add_f64s(simd.mul_f64s(simd.splat_f64s(factors.0), rest), turn);
                        let whole = simd.add_f64s(m, step);
                        let bytes = bytemuck::cast_slice_mut::<f64, u8>(&mut next[half..half + S::F64_LANES]);
                        bytes.copy_from_slice(bytemuck::bytes_of(&whole));
                    }
                }
            }
            Rows::Each { partner, value } => {
                let from = LANES * first;
                let rows = next.as_flattened_mut().iter_mut().zip(load.as_flattened()).zip(&solution[LANES + from..]);
                for (((next, load), m), (at, v)) in rows.zip(partner[from..].iter().zip(&value[from..])) {
                    let sum = (v[0] * solution[at[0] as usize] + v[1] * solution[at[1] as usize])
                        + (v[2] * solution[at[2] as usize] + v[3] * solution[at[3] as usize]);
                    let step = factors.0 * (load - (m + sum)) + factors.1 * (m - *next);
                    *next = m + step;
                }
            }
        }
    }
}

/// Values times what partners have.
#[inline(always)]
fn product<S: Simd>(simd: S, solution: &[f64], partner: u32, value: &Slice, half: usize) -> S::f64s {
    simd.mul_f64s(read(simd, value, half), read(simd, solution, partner as usize + half))
}

#[inline(always)]
fn read<S: Simd>(_: S, from: &[f64], at: usize) -> S::f64s {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice::<f64, u8>(&from[at..at + S::F64_LANES]))
}
