//! Up the levels and down again where a mesh is regular, sixteen nodes at a time.

use super::looks::{Looks, Vectors};
use super::{COARSE_PIECE, times};
use crate::step::Block;
use crate::step::aggregate::Weights;
use crate::step::inverses::put_inverse;
use crate::step::lanes::{Lanes, Sixteen, Work, load, store, widest};
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
    r: Lines<f32>,
    stages: Vec<Stage>,
}

#[derive(Debug)]
struct Stage {
    /// From the finer level to this one, and back.
    up: Looks,
    down: Looks,
    /// By sixteen nodes, six numbers of each.
    inverse: Lines<f32>,
    r: Lines<f32>,
    h: Lines<f32>,
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
            let room = |numbers: usize| Lines::new(numbers * coarse.next_multiple_of(LANES));
            stages.push(Stage { up, down, inverse: room(6), r: room(3), h: room(3) });
        }
        let finest = levels.first().map_or(0, |(weights, _)| weights.start.len() - 1);
        Some(Self { r: Lines::new(3 * finest.next_multiple_of(LANES)), stages })
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
        pool.pieces(vectors_mut(&mut self.r), PIECE, &|first, to| widest(Turn { from: &r[first..], to }));
        for at in 0..self.stages.len() {
            let (finer, rest) = self.stages.split_at_mut(at);
            let (from, Stage { up, inverse, r, h, .. }) =
                (finer.last().map_or(&self.r, |stage| &stage.r), &mut rest[0]);
            let (from, inverse) = (vectors(from), inverse.flat().as_chunks().0.as_chunks().0);
            pool.pieces((vectors_mut(r), vectors_mut(h)), COARSE_PIECE / LANES, &|first, (r, h)| {
                widest(Restrict { up, first, inverse: &inverse[first..], from, r, h });
            });
        }
        for at in (1..self.stages.len()).rev() {
            let (finer, rest) = self.stages.split_at_mut(at);
            let (down, from) = (&rest[0].down, vectors(&rest[0].h));
            pool.pieces(vectors_mut(&mut finer[at - 1].h), PIECE, &|first, h| widest(Prolong { down, first, from, h }));
        }
        let (inverse, r) = (inverse.as_chunks().0.as_chunks().0, vectors(&self.r));
        let coarse = self.stages.first().map(|stage| (&stage.down, vectors(&stage.h)));
        pool.fold(h, &|first, h| {
            let first = first / LANES;
            let (inverse, r) = (&inverse[first..], &r[first..]);
            widest(Finest { coarse, first, inverse, r, h: h.as_chunks_mut().0 })
        })
    }
}

fn vectors(of: &Lines<f32>) -> &[Vectors] {
    of.flat().as_chunks().0.as_chunks().0
}

fn vectors_mut(of: &mut Lines<f32>) -> &mut [Vectors] {
    of.flat_mut().as_chunks_mut().0.as_chunks_mut().0
}

#[inline(always)]
fn three<U: Lanes>(unit: U, from: &Vectors) -> [U::V; 3] {
    from.each_ref().map(|plane| unit.load(plane))
}

/// Vectors by component.
struct Turn<'a> {
    from: &'a [[Quad; LANES]],
    to: &'a mut [Vectors],
}

impl Work for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        for (to, from) in self.to.iter_mut().zip(self.from) {
            *to = unit.planes(load(unit, from)).map(|plane| unit.store(plane));
        }
    }
}

/// Coarse nodes, from a sixteen on: what they get, and the level's own part of P.
struct Restrict<'a> {
    up: &'a Looks,
    first: usize,
    inverse: &'a [[Sixteen; 6]],
    from: &'a [Vectors],
    r: &'a mut [Vectors],
    h: &'a mut [Vectors],
}

impl Work for Restrict<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let zero = unit.load(&[0.0; LANES]);
        for (sixteen, ((r, h), inverse)) in (self.first..).zip(self.r.iter_mut().zip(self.h).zip(self.inverse)) {
            let sum = self.up.add(unit, sixteen, self.from, [zero; 3]);
            *r = sum.map(|plane| unit.store(plane));
            *h = times(unit, inverse, sum).map(|plane| unit.store(plane));
        }
    }
}

/// Nodes of a level that is not the finest, from a sixteen on: what they get of the coarser one.
struct Prolong<'a> {
    down: &'a Looks,
    first: usize,
    from: &'a [Vectors],
    h: &'a mut [Vectors],
}

impl Work for Prolong<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        for (sixteen, h) in (self.first..).zip(self.h) {
            *h = self.down.add(unit, sixteen, self.from, three(unit, h)).map(|plane| unit.store(plane));
        }
    }
}

/// Nodes of the finest level, from a sixteen on: their own part of P, and that of all coarser ones; gives `r . h`.
struct Finest<'a> {
    coarse: Option<(&'a Looks, &'a [Vectors])>,
    first: usize,
    inverse: &'a [[Sixteen; 6]],
    r: &'a [Vectors],
    h: &'a mut [[Quad; LANES]],
}

impl Work for Finest<'_> {
    type Output = f64;

    #[inline(always)]
    fn on(self, unit: impl Lanes) -> f64 {
        let mut all = unit.load(&[0.0; LANES]);
        for (sixteen, ((h, r), inverse)) in (self.first..).zip(self.h.iter_mut().zip(self.r).zip(self.inverse)) {
            let r = three(unit, r);
            let mut sum = times(unit, inverse, r);
            if let Some((down, from)) = self.coarse {
                sum = down.add(unit, sixteen, from, sum);
            }
            for c in 0..3 {
                all = unit.fma(sum[c], r[c], all);
            }
            store(unit, h, unit.vectors(sum));
        }
        unit.store(all).iter().map(|v| f64::from(*v)).sum()
    }
}
