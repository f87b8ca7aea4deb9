//! Up the levels and down again where a mesh is not regular, node by node.

use super::COARSE_PIECE;
use super::transfer::{Receiver, Transfer};
use crate::step::Block;
use crate::step::aggregate::Weights;
use crate::step::lanes::{Lanes, Sixteen, Work, load, store, widest};
use crate::step::pool::Pool;
use crate::step::single::Quad;
use crate::step::sliced::LANES;

/// Nodes in a piece of work for a thread.
const PIECE: usize = 512;

/// Vectors of all levels but the finest, and what leads from one to the next.
#[derive(Debug, Default)]
pub struct Each(Vec<Stage>);

#[derive(Debug)]
struct Stage {
    transfer: Transfer,
    inverse: Vec<Inverse>,
    r: Vec<Quad>,
    h: Vec<Quad>,
}

/// Columns of a 3 x 3 block, with zeros behind them.
type Inverse = [Quad; 3];

impl Each {
    /// For levels that are led to by these weights.
    pub fn new(levels: &[(Weights, usize)]) -> Self {
        let stage = |(weights, coarse): &(Weights, usize)| Stage {
            transfer: Transfer::new(weights, *coarse),
            inverse: vec![[[0.0; 4]; 3]; *coarse],
            r: vec![[0.0; 4]; *coarse],
            h: vec![[0.0; 4]; *coarse],
        };
        Self(levels.iter().map(stage).collect())
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let vectors = |stage: &Stage| stage.h.len() * (2 * size_of::<Quad>() + size_of::<Inverse>());
        self.0.iter().map(|stage| stage.transfer.bytes() + vectors(stage)).sum()
    }

    /// Takes over an inverse.
    pub fn put(&mut self, level: usize, node: usize, m: &Block) {
        let columns = [0, 1, 2].map(|c| [m[3 * c] as f32, m[3 * c + 1] as f32, m[3 * c + 2] as f32, 0.0]);
        self.0[level].inverse[node] = columns;
    }

    /// See [`super::Multilevel::apply`].
    pub fn apply(&mut self, pool: &Pool, inverse: &[f32], r: &[Quad], h: &mut [Quad]) -> f64 {
        for at in 0..self.0.len() {
            let (finer, rest) = self.0.split_at_mut(at);
            let (from, Stage { transfer, inverse, r, h }) = (finer.last().map_or(r, |stage| &stage.r), &mut rest[0]);
            pool.pieces((&mut r[..], &mut h[..]), COARSE_PIECE, &|first, (r, h)| {
                widest(Restrict { transfer, first, inverse: &inverse[first..], from, r, h });
            });
        }
        for at in (1..self.0.len()).rev() {
            let (finer, rest) = self.0.split_at_mut(at);
            let (transfer, from) = (&rest[0].transfer, &rest[0].h);
            pool.pieces(&mut finer[at - 1].h[..], PIECE, &|first, h| transfer.spread(first, from, &mut More(h)));
        }
        let (coarse, inverse) = (self.0.first(), inverse.as_chunks().0.as_chunks().0);
        pool.fold(h, &|first, h| {
            let (inverse, r) = (&inverse[first / LANES..], &r[first..]);
            widest(Finest { coarse, first, inverse, r, h })
        })
    }
}

/// Block times vector.
#[inline(always)]
fn turned(m: &Inverse, v: Quad) -> Quad {
    let mut out = [0.0; 4];
    for c in 0..4 {
        out[c] = m[0][c] * v[0] + m[1][c] * v[1] + m[2][c] * v[2];
    }
    out
}

/// Coarse nodes `first` on: what they get, and the level's own part of P.
struct Restrict<'a> {
    transfer: &'a Transfer,
    first: usize,
    inverse: &'a [Inverse],
    from: &'a [Quad],
    r: &'a mut [Quad],
    h: &'a mut [Quad],
}

impl Work for Restrict<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { transfer, first, inverse, from, r, h } = self;
        for (a, ((r, h), inverse)) in r.iter_mut().zip(h).zip(inverse).enumerate() {
            *r = transfer.gathered(unit, first + a, from);
            *h = turned(inverse, *r);
        }
    }
}

/// Fine nodes `first` on: their own part of P, and that of all coarser levels; gives `r . h`.
struct Finest<'a> {
    coarse: Option<&'a Stage>,
    first: usize,
    inverse: &'a [[Sixteen; 6]],
    r: &'a [Quad],
    h: &'a mut [Quad],
}

impl Work for Finest<'_> {
    type Output = f64;

    #[inline(always)]
    fn on(self, unit: impl Lanes) -> f64 {
        let Self { coarse, first, inverse, r, h } = self;
        for ((h, r), m) in h.as_chunks_mut().0.iter_mut().zip(r.as_chunks().0).zip(inverse) {
            store(unit, h, unit.vectors(super::times(unit, m, unit.planes(load(unit, r)))));
        }
        if let Some(stage) = coarse {
            stage.transfer.spread(first, &stage.h, &mut More(h));
        }
        let mut all = unit.load(&[0.0; LANES]);
        let (h, r) = (h.as_flattened().as_chunks().0, r.as_flattened().as_chunks().0);
        for (h, r) in h.iter().zip(r) {
            all = unit.fma(unit.load(h), unit.load(r), all);
        }
        unit.store(all).iter().map(|v| f64::from(*v)).sum()
    }
}

/// Nodes have their own part already.
struct More<'a>(&'a mut [Quad]);

impl Receiver for More<'_> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn own(&self, i: usize) -> Quad {
        self.0[i]
    }

    #[inline(always)]
    fn put(&mut self, i: usize, sum: Quad) {
        self.0[i] = sum;
    }
}
