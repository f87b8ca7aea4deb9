use super::slices::Number;
use super::term::Term;
use super::*;
use crate::lanes::arch_of_256_bits;

const SPECTRUM: [f64; 2] = [0.3, 1.7];

/// Entries of rows of three kinds in turn, each with neighbours of the other kinds; the first and last rows have fewer entries.
fn banded(n: usize) -> Vec<(u32, u32, f64)> {
    let mut entries = Vec::new();
    for i in 0..n {
        let far = [17, 31, 44][i % 3];
        for j in [i.checked_sub(far), i.checked_sub(1), Some(i + 1), Some(i + far)].into_iter().flatten() {
            if j < n {
                entries.push((i as u32, j as u32, 0.3 * (1.0 + ((i * j) as f64).sin()) / 2.0));
            }
        }
    }
    entries
}

/// Chebyshev's iteration written with steps and residuals, row by row.
fn reference(diagonal: &[f64], entries: &[(u32, u32, f64)], terms: usize, b: &[f64]) -> Vec<f64> {
    let [low, high] = SPECTRUM;
    let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
    let mut residual: Vec<f64> = b.iter().zip(diagonal).map(|(b, d)| b / d).collect();
    let (mut step, mut out, mut alpha) = (vec![0.0; b.len()], vec![0.0; b.len()], 1.0 / centre);
    for k in 0..terms {
        let beta = [0.0, 0.5 * (half * alpha).powi(2), (0.5 * half * alpha).powi(2)][k.min(2)];
        alpha = if k > 0 { 1.0 / (centre - beta / alpha) } else { alpha };
        step = residual.iter().zip(&step).map(|(r, s)| alpha * r + beta * s).collect::<Vec<f64>>();
        (0..b.len()).for_each(|i| out[i] += step[i]);
        (0..b.len()).for_each(|i| residual[i] -= step[i]);
        entries.iter().for_each(|&(i, j, v)| residual[i as usize] -= v / diagonal[i as usize] * step[j as usize]);
    }
    out
}

#[test]
fn both_formats_give_the_polynomial_for_any_number_of_threads() {
    let n = 5003;
    let entries = banded(n);
    let diagonal: Vec<f64> = (0..n).map(|i| 2.0 + (i as f64).cos()).collect();
    let b: Vec<f64> = (0..n).map(|i| ((i * i) as f64).sin()).collect();
    let want = reference(&diagonal, &entries, 12, &b);
    let mut sell = Chebyshev::new(&diagonal, &entries, SPECTRUM, 12);
    assert!(matches!(sell.format, RowFormat::Sell { .. }) && sell.row.windows(2).any(|rows| rows[1] != rows[0] + 1));
    let mut ellpack = Chebyshev::new(&diagonal, &entries, SPECTRUM, 12);
    ellpack.set_ellpack(&OffDiagonals::new(n, &entries), &diagonal);
    for (use_sell, single) in [(true, false), (false, false), (true, true), (false, true)] {
        let inverse = if use_sell { &mut sell } else { &mut ellpack };
        let mut first = vec![0.0; n];
        inverse.apply(&Pool::new(1), &b, &mut first, single);
        let most = want.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let bound = if single { 1e-6 } else { 1e-13 };
        assert!(first.iter().zip(&want).all(|(a, b)| (a - b).abs() < bound * most));
        for threads in [1, 3] {
            let mut again = vec![0.0; n];
            inverse.apply(&Pool::new(threads), &b, &mut again, single);
            assert!(first.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}

#[test]
fn every_vector_unit_gives_the_same_bytes() {
    let n = 1003;
    let mut of = Chebyshev::new(&vec![2.0; n], &banded(n), SPECTRUM, 12);
    let b: Vec<f64> = (0..n).map(|i| ((i * i) as f64).sin()).collect();
    for single in [false, true] {
        of.apply(&Pool::new(1), &b, &mut vec![0.0; n], single);
    }
    fn term<T: Number>(arch: pulp::Arch, format: &RowFormat, of: &Vectors<T>) -> Vec<u64> {
        let mut next = of.before.all()[1..of.before.all().len() - 1].to_vec();
        let Vectors { value, load, solution, .. } = of;
        arch.dispatch(Term {
            format,
            value,
            load,
            solution,
            first: 0,
            next: &mut next,
            alpha: T::of(0.7),
            beta: T::of(0.2),
        });
        next.into_iter().flatten().map(|v| v.exact().to_bits()).collect()
    }
    let both = |double, single| {
        [term(double, &of.format, &of.double), term(single, &of.format, of.single.as_ref().unwrap())].concat()
    };
    let first = both(pulp::Arch::Scalar, pulp::Arch::Scalar);
    assert_eq!(first, both(f64::arch(), f32::arch()));
    assert_eq!(first, both(arch_of_256_bits(), arch_of_256_bits()));
}

#[test]
fn irregular_rows_and_rows_with_a_zero_diagonal() {
    let n = 2000;
    let mut entries = Vec::new();
    for i in 0..n / 2 {
        let j = n / 2 + i * 7919 % (n / 2);
        entries.extend([(i as u32, j as u32, 0.4), (j as u32, i as u32, 0.4)]);
    }
    entries.sort_by_key(|(i, j, _)| (*i, *j));
    let mut diagonal = vec![1.0; n];
    (diagonal[0], diagonal[n / 2]) = (0.0, 0.0);
    entries.retain(|(i, j, _)| ![0, n as u32 / 2].contains(i) && ![0, n as u32 / 2].contains(j));
    let mut inverse = Chebyshev::new(&diagonal, &entries, [0.6, 1.4], 20);
    let mut out = vec![1.0; n];
    inverse.apply(&Pool::new(1), &vec![1.0; n], &mut out, false);
    for (i, out) in out.iter().enumerate() {
        let want = if diagonal[i] == 0.0 { 0.0 } else { 1.0 / 1.4 };
        assert!((out - want).abs() < 1e-9, "{i}: {out}");
    }
}
