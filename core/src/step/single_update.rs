//! New values for a matrix in single precision ([`super::single`]).

use super::Block;
use super::matrix::{Matrix, Rows};
use super::pool::Parts;
use super::single::{SingleBlock, TINY};
use super::sliced::Band;

/// Some rows with their blocks, `height` of them a piece, each with its band where rows lie alike.
pub struct Pieces<'a> {
    pub rows: Rows<'a>,
    pub height: usize,
    pub first: usize,
    pub values: &'a mut [SingleBlock],
    pub own: &'a mut [SingleBlock],
    pub bands: &'a mut [Band],
}

impl Parts for Pieces<'_> {
    fn count(&self) -> usize {
        self.own.len().div_ceil(self.height)
    }

    fn part(self, at: usize) -> (Self, Self) {
        let Self { rows, height, first, values, own, bands } = self;
        let middle = (at * height).min(own.len());
        let (values, others) = values.split_at_mut(rows.slots(first..first + middle).len());
        let (own, more) = own.split_at_mut(middle);
        let (bands, rest) = bands.split_at_mut(at.min(bands.len()));
        (
            Self { rows, height, first, values, own, bands },
            Self { rows, height, first: first + middle, values: others, own: more, bands: rest },
        )
    }
}

impl Pieces<'_> {
    /// One after the other: what is read in one part of the work is still at hand in the next.
    pub fn update(mut self, scale: f64, matrix: &Matrix) {
        let arch = pulp::Arch::new();
        while self.count() > 0 {
            let (Self { rows, first, values, own, bands, .. }, rest) = self.part(1);
            let slots = rows.slots(first..first + own.len());
            let from = &matrix.values()[slots.clone()];
            arch.dispatch(Rounded { scale, from, out: values });
            arch.dispatch(Sums { scale, matrix, first, out: own });
            if let [band] = bands {
                band.update(rows, (slots.start, values), own);
            }
            self = rest;
        }
    }
}

/// In single precision, without what is next to nothing.
#[inline(always)]
pub fn rounded(value: f64) -> f32 {
    let value = value as f32;
    if value.abs() < TINY { 0.0 } else { value }
}

struct Rounded<'a> {
    scale: f64,
    from: &'a [Block],
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
