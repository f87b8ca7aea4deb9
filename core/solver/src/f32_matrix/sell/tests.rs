use super::*;
use crate::algebra::Vec3;
use crate::f32_matrix::sell_columns::SellColumns;
use crate::lanes::{Lanes, Unit, Work, by_sixteen, one_by_one};
use crate::matrix::{Matrix, Values};

fn wave(i: usize) -> f32 {
    (1.7 * i as f32).sin() * 10_f32.powi((i % 7) as i32 - 3)
}

/// A matrix of a grid of `rows` rows of `n` nodes, in which nodes are joined to the next ones, above, along both diagonals and two above.
fn grid(n: usize, rows: usize) -> Matrix {
    let mut matrix = Matrix::default();
    matrix.set_pattern(n * rows, |pair| {
        for (i, column) in (0..n * rows).map(|i| (i, i % n)) {
            for (across, up) in [(1, 0), (-1, 1), (0, 1), (1, 1), (0, 2)] {
                let (to, line) = (column as i32 + across, i / n + up);
                if (0..n as i32).contains(&to) && line < rows {
                    pair(i as u32, (line * n) as u32 + to as u32);
                }
            }
        }
    });
    for (slot, block) in matrix.values_mut().iter_mut().enumerate() {
        *block = std::array::from_fn(|e| f64::from(wave(9 * slot + e)) * (1.0 + 1e-9 * e as f64));
    }
    matrix
}

const SCALE: f64 = 0.25;

/// Results of steps along directions, with a product after the first one.
struct Steps {
    /// Bits of all results.
    bits: Vec<u32>,
    /// Sum of steps.
    x: Vec<Vec3>,
    /// Residual of each node after the steps (n x 3).
    r: Vec<[f32; 3]>,
    /// `p . A p`.
    dot: f64,
}

fn take_steps(matrix: &Matrix, threads: usize, h: &[Vectors]) -> Steps {
    let (n, pool) = (matrix.rows(), Pool::new(threads));
    let mut sell = SellDistances::new(n, matrix.pattern()).expect("a regular pattern");
    assert!(sell.bands.len() > 2 && sell.bytes() > 36 * matrix.blocks());
    sell.update(&pool, matrix, SCALE);
    sell.start();
    sell.update_direction(&pool, h, 0.0, 0.0);
    let dot = sell.product(&pool);
    let mut r = h.to_vec();
    let (low, high) = r.split_at_mut(h.len() / 3);
    sell.update_residual(0, 0.7, low);
    sell.update_residual(h.len() / 3, 0.7, high);
    sell.update_direction(&pool, &r, 0.3, 0.9);
    sell.update_direction(&pool, h, 2.0, 0.5);
    let mut x = vec![Vec3::repeat(1.0); n];
    sell.add_to(0, 0.5, &mut x[..n / 2]);
    sell.add_to(n / 2, 0.5, &mut x[n / 2..]);
    let r = one_by_one(&r);
    let all = x.iter().flatten().map(|v| *v as f32).chain(r.iter().flatten().copied());
    let all = all.chain(sell.p.iter().flat_map(|p| p.flat().to_vec()));
    let bits = all.map(f32::to_bits).chain([dot as f32].map(f32::to_bits)).collect();
    Steps { bits, x, r: r[..n].to_vec(), dot }
}

#[test]
fn steps_along_directions_are_those_with_columns_for_any_number_of_threads() {
    let matrix = grid(53, 45);
    let n = matrix.rows();
    let h: Vec<[f32; 3]> = (0..n).map(|j| [wave(3 * j + 1), wave(3 * j + 2), wave(3 * j + 3)]).collect();
    let h = by_sixteen(&h);
    let (pool, first) = (Pool::new(1), take_steps(&matrix, 1, &h));
    assert_eq!(first.bits, take_steps(&matrix, 3, &h).bits);

    let mut columns = SellColumns::new(n, matrix.pattern());
    columns.update(&pool, &matrix, SCALE);
    columns.start();
    columns.update_direction(&pool, &h, 0.0, 0.0);
    let dot = columns.product(&pool);
    let (mut r, mut x) = (h.clone(), vec![Vec3::repeat(1.0); n]);
    columns.update_residual(0, 0.7, &mut r);
    columns.update_direction(&pool, &r, 0.3, 0.9);
    columns.update_direction(&pool, &h, 2.0, 0.5);
    columns.add_to(0, 0.5, &mut x);
    assert!((dot - first.dot).abs() < 1e-4 * dot.abs(), "{dot} {}", first.dot);
    let close = |a: &[f64], b: &[f64]| {
        let most = a.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5 * most)
    };
    assert!(close(bytemuck::cast_slice(&x), bytemuck::cast_slice(&first.x)));
    let wide = |r: &[[f32; 3]]| r.iter().flatten().map(|v| f64::from(*v)).collect::<Vec<_>>();
    assert!(close(&wide(&one_by_one(&r)[..n]), &wide(&first.r)));
}

/// All loops over the bands on one vector unit.
struct AllLoops<'a>(&'a mut SellDistances, &'a Matrix, &'a [Vectors]);

impl Work for AllLoops<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn on(self, unit: impl Lanes) -> Vec<u32> {
        let Self(SellDistances { bands, p, sum, height }, matrix, h) = self;
        let (n, Values::F32(of)) = (matrix.rows(), matrix.values()) else {
            panic!("the matrix is in single precision")
        };
        let (blocks, row_sum) = (of.blocks(), |i: usize| of.row_sum(i));
        bands.iter_mut().for_each(|band| band.fill(n, blocks, row_sum, SCALE).on(unit));
        let exact: Vec<Vec3> =
            one_by_one(h)[..matrix.rows()].iter().map(|q| f64::from(q[1]) * Vec3::new(1.1, 0.3, 7.7)).collect();
        bands.iter_mut().for_each(|band| exact::Multiply { band, x: [&exact[..]] }.on(unit));
        let mut products = vec![Vec3::zeros(); matrix.rows()];
        exact::collect_rows(bands, *height, 0, 0, &mut products);
        let products: Vec<u64> = products.iter().flatten().map(|v| v.to_bits()).collect();
        let [p0, p1, p2] = p.each_mut().map(|p| p.flat_mut().as_chunks_mut().0);
        let steps = sum.vectors_mut();
        UpdateDirection { h, a: 0.3, beta: 0.6, p: [p0, p1, p2], sum: steps }.on(unit);
        let p = p.each_ref().map(Lines::flat);
        bands.iter_mut().for_each(|band| Multiply { band, p }.on(unit));
        let [y, before] = [1, 0].map(|band: usize| bands[band].y.each_ref().map(Lines::flat));
        let (mut r, before) = (h[..8].to_vec(), before.map(|y| &y[*height..]));
        UpdateResidual { y, before, a: 0.7, r: &mut r }.on(unit);
        let values = bands.iter().flat_map(|band| band.values.flat().iter().chain(band.y[1].flat()));
        let all = values.chain(p[2]).chain(sum.flat()).chain(r.iter().flatten().flatten());
        let products = products.into_iter().flat_map(|bits| [bits as u32, (bits >> 32) as u32]);
        all.map(|v| v.to_bits()).chain(products).chain(bands.iter().map(|band| (band.dot as f32).to_bits())).collect()
    }
}

#[test]
fn every_vector_unit_gives_the_same_bytes() {
    let mut matrix = grid(53, 45);
    matrix.round();
    let n = matrix.rows();
    let h: Vec<[f32; 3]> = (0..n).map(|j| [wave(3 * j + 1), wave(3 * j + 2), wave(3 * j + 3)]).collect();
    let h = by_sixteen(&h);
    let mut sell = SellDistances::new(n, matrix.pattern()).expect("a regular pattern");
    let all = Unit::ALL.map(|unit| {
        sell.start();
        unit.run(AllLoops(&mut sell, &matrix, &h))
    });
    assert!(all.iter().all(|bits| *bits == all[0]));
}

#[test]
fn exact_products_are_those_of_the_rows() {
    let mut matrix = grid(53, 45);
    matrix.round();
    let n = matrix.rows();
    let wide = |seed: usize| {
        (0..n).map(|i| Vec3::from_fn(|c, _| (1.3 * (seed + 3 * i + c) as f64).sin())).collect::<Vec<Vec3>>()
    };
    let x = [wide(0), wide(77)];
    let products = |threads: usize| {
        let (pool, mut out) = (Pool::new(threads), [vec![Vec3::zeros(); n], vec![Vec3::repeat(1.0); n]]);
        let mut sell = SellDistances::new(n, matrix.pattern()).expect("a regular pattern");
        sell.update(&pool, &matrix, SCALE);
        let Values::F32(of) = matrix.values() else { panic!("the matrix is in single precision") };
        let [a, b] = &mut out;
        sell.exact_products(&pool, of, 1.0 / SCALE, [&x[0], &x[1]], [a, b]);
        out
    };
    let out = products(1);
    assert_eq!(out, products(3));
    for (x, out) in x.iter().zip(&out) {
        let mut want = vec![Vec3::zeros(); n];
        matrix.rows_product(0, x, &mut want);
        let most = want.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
        for (out, want) in out.iter().flatten().zip(want.iter().flatten()) {
            assert!((out - want).abs() < 1e-13 * most, "{out} {want}");
        }
    }
}

#[test]
fn products_with_masses_and_tools_are_those_of_the_rows() {
    let mut matrix = grid(53, 45);
    matrix.round();
    let n = matrix.rows();
    let p: Vec<[f32; 3]> = (0..n).map(|i| [0, 1, 2].map(|c| (1.3 * (3 * i + c) as f32).sin())).collect();
    let (mut sell, mut columns) =
        (SellDistances::new(n, matrix.pattern()).expect("a regular pattern"), SellColumns::new(n, matrix.pattern()));
    let (pool, exact) = (Pool::new(1), p.iter().map(|p| Vec3::from(p.map(f64::from))).collect::<Vec<Vec3>>());
    let mut want = vec![Vec3::zeros(); n];
    matrix.rows_product(0, &exact, &mut want);
    let most = want.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
    let p = by_sixteen(&p);
    let mut products = [vec![[[0.0; LANES]; 3]; p.len()], vec![[[0.0; LANES]; 3]; p.len()]];
    sell.update(&pool, &matrix, SCALE);
    sell.start();
    sell.update_direction(&pool, &p, 0.0, 0.0);
    sell.product(&pool);
    sell.update_residual(0, -1.0, &mut products[0]);
    columns.update(&pool, &matrix, SCALE);
    columns.start();
    columns.update_direction(&pool, &p, 0.0, 0.0);
    columns.product(&pool);
    columns.update_residual(0, -1.0, &mut products[1]);
    let masses: Vec<bool> =
        sell.bands.iter().flat_map(|b| (1..b.start.len()).map(|slice| b.diagonal.is_mass(slice - 1))).collect();
    assert!(masses.contains(&true) && masses.contains(&false));
    for product in &products {
        for (got, want) in one_by_one(product).iter().zip(&want) {
            assert!((0..3).all(|c| (f64::from(got[c]) - SCALE * want[c]).abs() < 1e-6 * most), "{got:?} {want:?}");
        }
    }
}

#[test]
fn irregular_and_empty_patterns_are_refused() {
    let mut matrix = Matrix::default();
    matrix.set_pattern(300, |pair| {
        (0..290_u32).for_each(|i| (1..5).for_each(|k| pair(i, i + 1 + (i * k * 7919) % (299 - i).min(97))));
    });
    assert!(SellDistances::new(300, matrix.pattern()).is_none());
    assert!(SellDistances::new(0, Matrix::default().pattern()).is_none());
}
