use super::*;
use crate::algebra::Vec3;
use crate::lanes::{Lanes, Unit, Work, by_sixteen, one_by_one};
use crate::matrix::{Matrix, Values};

fn wave(i: usize) -> f32 {
    (1.7 * i as f32).sin() * 10_f32.powi((i % 7) as i32 - 3)
}

/// A matrix of `n` rows with up to nine blocks each at irregular distances of at most `far` from the diagonal.
fn matrix(n: usize, far: u32) -> Matrix {
    let mut matrix = Matrix::default();
    matrix.set_pattern(n, |pair| {
        for i in 0..n as u32 {
            let last = far.min(n as u32 - 1 - i);
            (0..i * 7919 % 10).filter(|_| last > 0).for_each(|k| pair(i, i + 1 + (i + 1) * (k + 1) * 7919 % last));
        }
    });
    for (slot, block) in matrix.values_mut().iter_mut().enumerate() {
        *block = std::array::from_fn(|e| f64::from(wave(9 * slot + e)) * (1.0 + 1e-9 * e as f64));
    }
    matrix
}

fn vectors(n: usize) -> Vec<[f32; 3]> {
    (0..n).map(|j| [wave(3 * j + 1), wave(3 * j + 2), wave(3 * j + 3)]).collect()
}

const SCALE: f64 = 0.25;

#[test]
fn steps_along_directions_are_those_of_the_matrix_for_any_number_of_threads() {
    for (n, far, bands) in [(2003, 97, 4), (2003, 900, 2), (5, 3, 1)] {
        let (matrix, h) = (matrix(n, far), by_sixteen(&vectors(n)));
        let steps = |threads: usize| {
            let (pool, mut columns) = (Pool::new(threads), SellColumns::new(n, matrix.pattern()));
            assert!(columns.bands.len() == bands && columns.bytes() > 36 * matrix.blocks());
            columns.update(&pool, &matrix, SCALE);
            columns.start();
            columns.update_direction(&pool, &h, 0.0, 0.0);
            let dot = columns.product(&pool);
            let mut r = vec![[[0.0; LANES]; 3]; h.len()];
            let (low, high) = r.split_at_mut(h.len() / 3);
            columns.update_residual(0, -0.5, low);
            columns.update_residual(low.len(), -0.5, high);
            columns.update_direction(&pool, &r, 0.3, 0.9);
            columns.update_direction(&pool, &h, 2.0, 0.5);
            let mut x = vec![Vec3::repeat(1.0); n];
            columns.add_to(0, 0.5, &mut x[..n / 2]);
            columns.add_to(n / 2, 0.5, &mut x[n / 2..]);
            (dot.to_bits(), r, x)
        };
        let first = steps(1);
        assert!(first == steps(3));
        let (dot, r, x) = first;
        let (r, h) = (one_by_one(&r), vectors(n).iter().map(|h| Vec3::from(h.map(f64::from))).collect::<Vec<Vec3>>());
        let mut product = vec![Vec3::zeros(); n];
        matrix.rows_product(0, &h, &mut product);
        // A bound of the sum of absolute values in each row.
        let Values::F64(blocks) = matrix.values() else { panic!("it was not rounded") };
        let sizes = |i: usize| {
            let row = matrix.pattern().off_diagonal(i);
            let of = |slot: usize| blocks[slot].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            let size = |j: usize| h[j].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            let upper =
                row.columns.iter().enumerate().map(|(k, j)| of(row.first_slot + k) * (size(*j as usize) + size(i)));
            let lower = row.lower.iter().map(|b| of(b.slot as usize) * (size(b.column as usize) + size(i)));
            upper.chain(lower).sum::<f64>() + of(row.first_slot - 1) * size(i)
        };
        let mut total = (0.0, 0.0);
        for i in 0..n {
            let most = sizes(i);
            for c in 0..3 {
                let want = SCALE * product[i][c];
                assert!((f64::from(r[i][c]) - 0.5 * want).abs() < 1e-6 * most, "{i}: {} {want}", r[i][c]);
                // 0.3 h + 2 (r + 0.9 h), halved.
                let (h, r) = (h[i][c], f64::from(r[i][c]));
                let (expected, size) = (1.0 + 1.05 * h + r, 1.0 + 1.05 * h.abs() + r.abs());
                assert!((x[i][c] - expected).abs() < 1e-6 * size, "{i}: {} {expected}", x[i][c]);
                total = (total.0 + h * want, total.1 + h.abs() * SCALE * most);
            }
        }
        assert!((f64::from_bits(dot) - total.0).abs() < 1e-6 * total.1, "{} {total:?}", f64::from_bits(dot));
    }
}

/// The products of all bands on one vector unit.
struct Products<'a>(&'a mut SellColumns, &'a [Quad]);

impl Work for Products<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn on(self, unit: impl Lanes) -> Vec<u32> {
        let Self(SellColumns { bands, .. }, p) = self;
        bands.iter_mut().for_each(|band| Multiply { band, p }.on(unit));
        let all = bands.iter().flat_map(|band| band.y.iter().flatten().map(|v| v.to_bits()));
        all.chain(bands.iter().map(|band| (band.dot as f32).to_bits())).collect()
    }
}

#[test]
fn every_vector_unit_gives_the_same_bytes() {
    let (n, matrix) = (1003, matrix(1003, 60));
    let mut columns = SellColumns::new(n, matrix.pattern());
    columns.update(&Pool::new(1), &matrix, SCALE);
    let mut p: Vec<Quad> = vectors(n).iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
    p.resize(columns.p.len(), [0.0; 4]);
    let all = Unit::ALL.map(|unit| unit.run(Products(&mut columns, &p)));
    assert!(all.iter().all(|bits| *bits == all[0]));
}
