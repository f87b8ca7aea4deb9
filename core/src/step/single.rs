//! The matrix of a body in single precision, for the iterations of a solve ([`super::inner`]).
//!
//! Blocks off the diagonal are those of [`Matrix`], rounded. On the diagonal stands what the others leave of it, and the product
//! is one of differences, `y_i = D_i x_i + sum_j A_ij (x_j - x_i)`: so a motion of the whole costs what its masses say, however
//! stiff the body is, where plain rounding would drown them.

use super::matrix::Matrix;
use super::multilevel::plus;
use super::pool::Pool;
use super::single_product::{Blocks, rows_product};
use super::single_update::{Pieces, rounded};
use super::sliced::Sliced;

/// A vector with a zero behind it.
pub type Quad = [f32; 4];
/// A 3 x 3 block, row-major.
pub type SingleBlock = [f32; 9];

/// What is smaller than this beside 1 is zero: processors take a hundred times as long over the smallest numbers.
pub const TINY: f32 = 1e-18;
/// Rows in a piece of work for a thread.
const ROWS: usize = 256;

/// A vector in single precision, without what is next to nothing.
#[inline(always)]
pub fn without_dust(mut q: Quad) -> Quad {
    for c in &mut q {
        *c = if c.abs() < TINY { 0.0 } else { *c };
    }
    q
}

/// `scale A`
#[derive(Debug, Default)]
pub struct Single {
    /// A power of two that brings the largest entry of the diagonal to about 1.
    scale: f64,
    /// As in [`Matrix`], and one more that is never used: blocks are read 16 numbers at a time.
    values: Vec<SingleBlock>,
    /// (n + 1), `D`
    own: Vec<SingleBlock>,
    /// The same once more where rows lie alike, and whether that was asked.
    sliced: Option<Sliced>,
    is_sorted: bool,
    /// Of the last product, where rows do not lie alike.
    product: Vec<Quad>,
}

/// The power of two at or below a number above zero.
pub fn power_of_two(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & (0x7ff << 52))
}

impl Single {
    /// `scale`
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Blocks, and one more.
    pub fn values(&self) -> &[SingleBlock] {
        &self.values
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let sliced = self.sliced.as_ref().map_or(0, Sliced::bytes);
        let blocks = (self.values.len() + self.own.len()) * size_of::<SingleBlock>();
        blocks + self.product.len() * size_of::<Quad>() + sliced
    }

    /// The next matrix has another pattern.
    pub fn forget(&mut self) {
        (self.sliced, self.is_sorted) = (None, false);
    }

    /// Room for the blocks of `matrix`.
    fn resize(&mut self, matrix: &Matrix) {
        self.values.resize(matrix.values().len() + 1, [0.0; 9]);
        self.own.resize(matrix.rows() + 1, [0.0; 9]);
        if !self.is_sorted {
            (self.sliced, self.is_sorted) = (Sliced::new(matrix.rows(), matrix.pattern()), true);
            self.product.resize(if self.sliced.is_none() { matrix.rows() } else { 0 }, [0.0; 4]);
        }
    }

    /// Takes over new values.
    pub fn update(&mut self, pool: &Pool, matrix: &Matrix) {
        self.resize(matrix);
        let n = matrix.rows();
        let largest = (0..n).map(|i| matrix.diagonal(i)).fold(0.0_f64, |m, b| m.max(b[0]).max(b[4]).max(b[8]));
        let normal = largest.is_normal() && largest > 0.0;
        let scale = if normal { 1.0 / power_of_two(largest) } else { 1.0 };
        self.scale = scale;
        let (rows, height) = (matrix.pattern(), self.sliced.as_ref().map_or(ROWS, Sliced::height));
        let bands = self.sliced.as_mut().map_or(&mut [][..], Sliced::bands_mut);
        let (values, own) = (&mut self.values[..], &mut self.own[..n]);
        let pieces = Pieces { rows, height, first: 0, values, own, bands };
        pool.pieces(pieces, 1, &|_, pieces: Pieces<'_>| pieces.update(scale, matrix));
    }

    /// Finds `scale A x`, for [`Single::take`]; gives `x . scale A x`.
    pub fn product(&mut self, pool: &Pool, matrix: &Matrix, x: &[Quad]) -> f64 {
        if let Some(sliced) = &mut self.sliced {
            return sliced.product(pool, x);
        }
        let blocks =
            Blocks { values: self.values.as_flattened(), own: self.own.as_flattened(), rows: matrix.pattern() };
        pool.fold(&mut self.product[..], &|first, out| rows_product(first, out, x, blocks))
    }

    /// `r -= a scale A x`, rows `first` on, of the last product.
    pub fn take(&self, first: usize, a: f32, r: &mut [Quad]) {
        match &self.sliced {
            Some(sliced) => sliced.take(first, a, r),
            None => pulp::Arch::new().dispatch(Take { product: &self.product[first..], a, r }),
        }
    }

    /// Runs `work` on the blocks as they would be if fixed nodes were joined to no other and to nothing.
    pub fn without_fixed<R>(&mut self, matrix: &Matrix, fixed: &[u32], work: impl FnOnce(&Self) -> R) -> R {
        let rows = matrix.pattern();
        let slots = |i: u32| {
            let (lower, above, columns) = rows.around(i as usize);
            lower.iter().map(|(_, slot)| *slot as usize).chain(above - 1..above + columns.len())
        };
        fixed.iter().flat_map(|i| slots(*i)).for_each(|slot| self.values[slot] = [0.0; 9]);
        let done = work(self);
        let scale = self.scale;
        for slot in fixed.iter().flat_map(|i| slots(*i)) {
            self.values[slot] = matrix.values()[slot].map(|value| rounded(scale * value));
        }
        done
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
