//! A descent with rows that do not lie alike: one after the other ([`super::single_product`]).

use super::V3;
use super::matrix::{Matrix, Rows};
use super::multilevel::plus;
use super::pool::Pool;
use super::single::{Quad, SingleBlock, without_dust};
use super::single_product::{Blocks, rows_product};
use super::single_update::row_sums;

/// Nodes in a piece of a vector for a thread.
const PIECE: usize = 2048;

/// Blocks of the diagonal, and the vectors that are multiplied.
#[derive(Debug)]
pub struct Each {
    /// (n + 1), what the others leave of the diagonal
    own: Vec<SingleBlock>,
    /// The direction of descent, and how far it has gone in all.
    p: Vec<Quad>,
    sum: Vec<Quad>,
    product: Vec<Quad>,
}

impl Each {
    /// Of `n` rows.
    pub fn new(n: usize) -> Self {
        let vector = || vec![[0.0; 4]; n];
        Self { own: vec![[0.0; 9]; n + 1], p: vector(), sum: vector(), product: vector() }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.own.len() * size_of::<SingleBlock>() + 3 * self.p.len() * size_of::<Quad>()
    }

    /// Takes over new values, times `scale`.
    pub fn update(&mut self, pool: &Pool, matrix: &Matrix, scale: f64) {
        row_sums(pool, scale, matrix, &mut self.own[..matrix.rows()]);
    }

    /// `p = 0`, and nothing gone.
    pub fn start(&mut self) {
        self.p.fill([0.0; 4]);
        self.sum.fill([0.0; 4]);
    }

    /// Finds `A p` with blocks off the diagonal; gives `p . A p`.
    pub fn product(&mut self, pool: &Pool, values: &[f32], rows: Rows<'_>) -> f64 {
        let (x, blocks) = (&self.p, Blocks { values, own: self.own.as_flattened(), rows });
        pool.fold(&mut self.product[..], &|first, out| rows_product(first, out, x, blocks))
    }

    /// `r -= a A p`, rows `first` on.
    pub fn take(&self, first: usize, a: f32, r: &mut [Quad]) {
        pulp::Arch::new().dispatch(Take { product: &self.product[first..], a, r });
    }

    /// Goes by `a`, then `p = h + beta p`.
    pub fn turn(&mut self, pool: &Pool, h: &[Quad], a: f32, beta: f32) {
        pool.pieces((&mut self.p[..], &mut self.sum[..]), PIECE, &|first, (p, sum)| {
            pulp::Arch::new().dispatch(Turn { h: &h[first..], a, beta, p, sum });
        });
    }

    /// Adds `scale` times all that was gone to rows `first` on.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [V3]) {
        for (x, sum) in x.iter_mut().zip(&self.sum[first..]) {
            (0..3).for_each(|c| x[c] += scale * f64::from(sum[c]));
        }
    }
}

/// `r -= a product`
struct Take<'a> {
    product: &'a [Quad],
    a: f32,
    r: &'a mut [Quad],
}

impl pulp::NullaryFnOnce for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (r, product) in self.r.iter_mut().zip(self.product) {
            *r = without_dust(plus(*r, -self.a, *product));
        }
    }
}

/// `sum += a p`, then `p = h + beta p`.
struct Turn<'a> {
    h: &'a [Quad],
    a: f32,
    beta: f32,
    p: &'a mut [Quad],
    sum: &'a mut [Quad],
}

impl pulp::NullaryFnOnce for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { h, a, beta, p, sum } = self;
        for ((p, sum), h) in p.iter_mut().zip(sum).zip(h) {
            *sum = plus(*sum, a, *p);
            *p = without_dust(plus(*h, beta, *p));
        }
    }
}
