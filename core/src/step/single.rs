//! The matrix of a body in single precision, for the iterations of a solve ([`super::inner`]).
//!
//! Blocks off the diagonal are those of [`Matrix`], rounded. On the diagonal stands what the others leave of it, and the product
//! is one of differences, `y_i = D_i x_i + sum_j A_ij (x_j - x_i)`: so a motion of the whole costs what its masses say, however
//! stiff the body is, where plain rounding would drown them.

use super::Constraint;
use super::matrix::Matrix;
use super::multilevel::plus;
use super::pool::Pool;
use super::single_product::{Blocks, rows_product};
use super::sliced::{Band, Sliced};

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
        // What is read in one part of the work is still at hand in the next.
        let rows = matrix.pattern();
        let height = self.sliced.as_ref().map_or(ROWS, Sliced::height);
        let mut bands = self.sliced.as_mut().map(|sliced| sliced.bands_mut().iter_mut());
        let (mut values, mut pieces) = (&mut self.values[..], Vec::with_capacity(n.div_ceil(height)));
        for (at, own) in self.own[..n].chunks_mut(height).enumerate() {
            let first = at * height;
            let slots = rows.slots(first..first + own.len());
            let (mine, others) = values.split_at_mut(slots.len());
            pieces.push(Piece { first, values: mine, own, band: bands.as_mut().and_then(Iterator::next) });
            values = others;
        }
        pool.pieces(&mut pieces[..], 1, &|_, pieces| {
            pieces.iter_mut().for_each(|piece| piece.update(scale, matrix));
        });
    }

    /// Finds `scale A x`, for [`Single::take`]; gives `x . scale A x`.
    pub fn product(&mut self, pool: &Pool, matrix: &Matrix, x: &[Quad]) -> f64 {
        if let Some(sliced) = &mut self.sliced {
            return sliced.product(pool, x);
        }
        let blocks =
            Blocks { values: self.values.as_flattened(), own: self.own.as_flattened(), rows: matrix.pattern() };
        self.product.resize(x.len(), [0.0; 4]);
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

/// Some rows, with their blocks.
struct Piece<'a> {
    first: usize,
    values: &'a mut [SingleBlock],
    own: &'a mut [SingleBlock],
    band: Option<&'a mut Band>,
}

impl Piece<'_> {
    fn update(&mut self, scale: f64, matrix: &Matrix) {
        let (arch, first) = (pulp::Arch::new(), self.first);
        let slots = matrix.pattern().slots(first..first + self.own.len());
        let from = &matrix.values()[slots.clone()];
        arch.dispatch(Rounded { scale, from, out: self.values });
        arch.dispatch(Sums { scale, matrix, first, out: self.own });
        if let Some(band) = &mut self.band {
            band.update(matrix.pattern(), (slots.start, self.values), self.own);
        }
    }
}

#[inline(always)]
fn rounded(value: f64) -> f32 {
    let value = value as f32;
    if value.abs() < TINY { 0.0 } else { value }
}

struct Rounded<'a> {
    scale: f64,
    from: &'a [super::Block],
    out: &'a mut [SingleBlock],
}

impl pulp::NullaryFnOnce for Rounded<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (from, out) = (self.from.as_flattened(), self.out.as_flattened_mut());
        for (out, from) in out.iter_mut().zip(from) {
            *out = rounded(self.scale * from);
        }
    }
}

struct Sums<'a> {
    scale: f64,
    matrix: &'a Matrix,
    first: usize,
    out: &'a mut [SingleBlock],
}

impl pulp::NullaryFnOnce for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (values, rows) = (self.matrix.values(), self.matrix.pattern());
        for (at, out) in self.out.iter_mut().enumerate() {
            let (lower, above, columns) = rows.around(self.first + at);
            let (mut straight, mut turned) = ([0.0; 9], [0.0; 9]);
            for block in &values[above - 1..above + columns.len()] {
                (0..9).for_each(|e| straight[e] += block[e]);
            }
            for &(_, slot) in lower {
                let block = &values[slot as usize];
                (0..9).for_each(|e| turned[e] += block[e]);
            }
            *out = std::array::from_fn(|e| (self.scale * (straight[e] + turned[3 * (e % 3) + e / 3])) as f32);
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

/// What a held node may still do, as a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    node: u32,
    filter: SingleBlock,
}

impl Held {
    /// Of those that are not free.
    pub fn list(constraints: &[Constraint], held: &mut Vec<Self>) {
        held.clear();
        for (node, constraint) in constraints.iter().enumerate().filter(|(_, c)| !c.is_free()) {
            let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| constraint.filter(axis));
            let filter = std::array::from_fn(|e| columns[e % 3][e / 3] as f32);
            held.push(Self { node: node as u32, filter });
        }
    }

    /// Takes out of `field` what held nodes may not do.
    pub fn filter(held: &[Self], field: &mut [Quad]) {
        for Self { node, filter: m } in held {
            let [x, y, z, _] = field[*node as usize];
            let row = |r: usize| m[3 * r] * x + m[3 * r + 1] * y + m[3 * r + 2] * z;
            field[*node as usize] = [row(0), row(1), row(2), 0.0];
        }
    }
}
