//! Up the levels and down again where a mesh is regular, sixteen nodes at a time.

use super::looks::Looks;
use super::planes::{Planes, Sixteens, store};
use super::{COARSE_PIECE, times};
use crate::step::Block;
use crate::step::aggregate::Weights;
use crate::step::inverses::put_inverse;
use crate::step::lanes::{self, Lanes, Sixteen, Work, load, widest};
use crate::step::lines::Lines;
use crate::step::pool::Pool;
use crate::step::single::Quad;
use crate::step::sliced::LANES;

/// Sixteens in a piece of work for a thread.
const PIECE: usize = 64;
/// What looks have to need of their room on the finest level: below that they shuffle more than they save.
const FULL: f64 = 0.35;

/// Vectors of all levels, and what leads from one to the next.
#[derive(Debug)]
pub struct Alike {
    /// Of the finest level.
    r: Planes,
    stages: Vec<Stage>,
}

#[derive(Debug)]
struct Stage {
    /// From the finer level to this one, and back.
    up: Looks,
    down: Looks,
    /// By sixteen nodes, six numbers of each.
    inverse: Lines<f32>,
    r: Planes,
    h: Planes,
}

impl Alike {
    /// For levels that are led to by these weights; `None` where the mesh is not regular.
    pub fn new(levels: &[(Weights, usize)]) -> Option<Self> {
        let mut stages = Vec::with_capacity(levels.len());
        for (weights, coarse) in levels {
            let (up, down) = (Looks::new(&weights.transposed(*coarse)), Looks::new(weights));
            let terms = weights.coarse.len();
            if stages.is_empty() && up.fullness(terms).min(down.fullness(terms)) < FULL {
                return None;
            }
            let inverse = Lines::new(6 * coarse.next_multiple_of(LANES));
            stages.push(Stage { up, down, inverse, r: Planes::new(*coarse), h: Planes::new(*coarse) });
        }
        let finest = levels.first().map_or(0, |(weights, _)| weights.start.len() - 1);
        Some(Self { r: Planes::new(finest), stages })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |s: &Stage| s.up.bytes() + s.down.bytes() + s.inverse.bytes() + s.r.bytes() + s.h.bytes();
        self.r.bytes() + self.stages.iter().map(of).sum::<usize>()
    }

    /// Takes over an inverse.
    pub fn put(&mut self, level: usize, node: usize, inverse: &Block) {
        put_inverse(self.stages[level].inverse.flat_mut(), node, inverse);
    }

    /// See [`super::Multilevel::apply`].
    pub fn apply(&mut self, pool: &Pool, inverse: &[f32], r: &[Quad], h: &mut [Quad]) -> f64 {
        let r = r.as_chunks().0;
        pool.pieces(self.r.sixteens(), PIECE, &|first, to| widest(Turn { from: &r[first..], to }));
        for at in 0..self.stages.len() {
            let (finer, rest) = self.stages.split_at_mut(at);
            let (from, Stage { up, inverse, r, h, .. }) =
                (finer.last().map_or(&self.r, |stage| &stage.r), &mut rest[0]);
            let inverse = inverse.flat().as_chunks().0.as_chunks().0;
            pool.pieces((r.sixteens(), h.sixteens()), COARSE_PIECE / LANES, &|first, (r, h)| {
                widest(Restrict { up, first, inverse: &inverse[first..], from, r, h });
            });
        }
        for at in (1..self.stages.len()).rev() {
            let (finer, rest) = self.stages.split_at_mut(at);
            let (down, from, h) = (&rest[0].down, &rest[0].h, finer[at - 1].h.sixteens());
            pool.pieces(h, PIECE, &|first, h| widest(Prolong { down, first, from, h }));
        }
        let (inverse, r, coarse) = (inverse.as_chunks().0.as_chunks().0, &self.r, self.stages.first());
        pool.fold(h, &|first, h| {
            let first = first / LANES;
            widest(Finest { coarse, first, inverse: &inverse[first..], r, h: h.as_chunks_mut().0 })
        })
    }
}

/// Vectors by component.
struct Turn<'a> {
    from: &'a [[Quad; LANES]],
    to: Sixteens<'a>,
}

impl Work for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn on(mut self, unit: impl Lanes) {
        for (at, from) in self.from.iter().enumerate().take(self.to[0].len()) {
            store(unit, &mut self.to, at, unit.planes(load(unit, from)));
        }
    }
}

/// Coarse nodes, from a sixteen on: what they get, and the level's own part of P.
struct Restrict<'a> {
    up: &'a Looks,
    first: usize,
    inverse: &'a [[Sixteen; 6]],
    from: &'a Planes,
    r: Sixteens<'a>,
    h: Sixteens<'a>,
}

impl Work for Restrict<'_> {
    type Output = ();

    #[inline(always)]
    fn on(mut self, unit: impl Lanes) {
        let zero = unit.load(&[0.0; LANES]);
        for (at, inverse) in self.inverse.iter().enumerate().take(self.r[0].len()) {
            let sum = self.up.add(unit, self.first + at, self.from, [zero; 3]);
            store(unit, &mut self.r, at, sum);
            store(unit, &mut self.h, at, times(unit, inverse, sum));
        }
    }
}

/// Nodes of a level that is not the finest, from a sixteen on: what they get of the coarser one.
struct Prolong<'a> {
    down: &'a Looks,
    first: usize,
    from: &'a Planes,
    h: Sixteens<'a>,
}

impl Work for Prolong<'_> {
    type Output = ();

    #[inline(always)]
    fn on(mut self, unit: impl Lanes) {
        for at in 0..self.h[0].len() {
            let own = self.h.each_ref().map(|plane| unit.load(&plane[at]));
            store(unit, &mut self.h, at, self.down.add(unit, self.first + at, self.from, own));
        }
    }
}

/// Nodes of the finest level, from a sixteen on: their own part of P, and that of all coarser ones; gives `r . h`.
struct Finest<'a> {
    coarse: Option<&'a Stage>,
    first: usize,
    inverse: &'a [[Sixteen; 6]],
    r: &'a Planes,
    h: &'a mut [[Quad; LANES]],
}

impl Work for Finest<'_> {
    type Output = f64;

    #[inline(always)]
    fn on(self, unit: impl Lanes) -> f64 {
        let Self { coarse, first, inverse, r, h } = self;
        let mut all = unit.load(&[0.0; LANES]);
        for (sixteen, (h, inverse)) in (first..).zip(h.iter_mut().zip(inverse)) {
            let r = r.load(unit, sixteen);
            let mut sum = times(unit, inverse, r);
            if let Some(coarse) = coarse {
                sum = coarse.down.add(unit, sixteen, &coarse.h, sum);
            }
            for c in 0..3 {
                all = unit.fma(sum[c], r[c], all);
            }
            lanes::store(unit, h, unit.vectors(sum));
        }
        unit.store(all).iter().map(|v| f64::from(*v)).sum()
    }
}
