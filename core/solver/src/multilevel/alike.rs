//! Up the levels and down again where a mesh is regular, sixteen nodes at a time.

use super::COARSE_PIECE;
use super::finest::{Coarser, Finest};
use super::graph::Weights;
use super::lookups::Lookups;
use crate::algebra::Block;
use crate::lanes::aligned::{Lines, Sixteens};
use crate::lanes::symmetric::{put_inverse, times};
use crate::lanes::{LANES, Lanes, Sixteen, Vectors, Work, put, three, widest};
use crate::threads::Pool;

/// Sixteens in a piece of work for a thread.
const PIECE: usize = 64;
/// What lookups have to need of their room on the finest level: below that they shuffle more than they save.
const FULL: f64 = 0.25;

/// Vectors of all levels but the finest, and what leads from one to the next.
#[derive(Debug)]
pub struct Alike(Vec<Stage>);

#[derive(Debug)]
struct Stage {
    /// From the finer level to this one, and back.
    up: Lookups,
    down: Lookups,
    /// By sixteen nodes, six numbers of each; nothing where a level only leads to the next.
    inverse: Option<Lines<f32>>,
    r: Lines<f32>,
    /// Nothing without inverses: `r` has room for it once it is not needed any more.
    h: Lines<f32>,
}

impl Alike {
    /// For levels that are led to by these weights, and their shares; `None` where the mesh is not regular.
    pub fn new(levels: &[(Weights, usize)], shares: &[f64]) -> Option<Self> {
        let mut stages = Vec::with_capacity(levels.len());
        for ((weights, coarse), share) in levels.iter().zip(shares) {
            let least = if stages.is_empty() { FULL } else { 0.0 };
            let (down, up) = (Lookups::new(weights, least)?, Lookups::new(&weights.transposed(*coarse), least)?);
            let room = |numbers: usize| Lines::new(numbers * coarse.next_multiple_of(LANES));
            let inverse = (*share > 0.0).then(|| room(6));
            let h = if inverse.is_some() { room(3) } else { Lines::new(0) };
            stages.push(Stage { up, down, inverse, r: room(3), h });
        }
        Some(Self(stages))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |s: &Stage| {
            let inverse = s.inverse.as_ref().map_or(0, Lines::bytes);
            s.up.bytes() + s.down.bytes() + inverse + s.r.bytes() + s.h.bytes()
        };
        self.0.iter().map(of).sum()
    }

    /// Takes over an inverse.
    pub fn put(&mut self, level: usize, node: usize, inverse: &Block) {
        let all = self.0[level].inverse.as_mut().expect("only levels with a share have inverses");
        put_inverse(all.flat_mut(), node, inverse);
    }

    /// See [`super::Multilevel::apply`].
    pub fn apply(&mut self, pool: &Pool, inverse: &[f32], r: &[Vectors], h: &mut [Vectors]) -> f64 {
        for at in 0..self.0.len() {
            let (finer, rest) = self.0.split_at_mut(at);
            let (from, Stage { up, inverse, r, h, .. }) =
                (finer.last().map_or(r, |stage| stage.r.vectors()), &mut rest[0]);
            let Some(inverse) = inverse else {
                pool.pieces(r.vectors_mut(), PIECE, &|first, to| {
                    widest(Take { lookups: up, first, from, to, adds: false });
                });
                continue;
            };
            let inverse = inverse.flat().as_chunks().0.as_chunks().0;
            pool.pieces((r.vectors_mut(), h.vectors_mut()), COARSE_PIECE / LANES, &|first, (r, h)| {
                widest(Restrict { up, first, inverse: &inverse[first..], from, r, h });
            });
        }
        for at in (1..self.0.len()).rev() {
            let (finer, rest) = self.0.split_at_mut(at);
            let (lookups, from, Stage { inverse, r, h, .. }) = (&rest[0].down, rest[0].given(), &mut finer[at - 1]);
            let adds = inverse.is_some();
            let to = if adds { h } else { r };
            pool.pieces(to.vectors_mut(), PIECE, &|first, to| widest(Take { lookups, first, from, to, adds }));
        }
        let (coarser, inverse) = (self.0.first(), inverse.as_chunks().0.as_chunks().0);
        pool.fold(Sixteens(h), &|first, Sixteens(h)| {
            let first = first / LANES;
            widest(Finest { coarser, first, inverse: &inverse[first..], r: &r[first..], h })
        })
    }
}

impl Stage {
    /// What finer nodes take of it.
    fn given(&self) -> &[Vectors] {
        if self.inverse.is_some() { self.h.vectors() } else { self.r.vectors() }
    }
}

impl Coarser for Stage {
    #[inline(always)]
    fn add<U: Lanes>(&self, unit: U, sixteen: usize, sum: [U::V; 3]) -> [U::V; 3] {
        self.down.add(unit, sixteen, self.given(), sum)
    }
}

/// Coarse nodes, from a sixteen on: what they get, and the level's own part of P.
struct Restrict<'a> {
    up: &'a Lookups,
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
            *r = put(unit, sum);
            *h = put(unit, times(unit, inverse, sum));
        }
    }
}

/// Nodes of a level, from a sixteen on: what they get of another one, and if it `adds`, what they had.
struct Take<'a> {
    lookups: &'a Lookups,
    first: usize,
    from: &'a [Vectors],
    to: &'a mut [Vectors],
    adds: bool,
}

impl Work for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let zero = unit.load(&[0.0; LANES]);
        for (sixteen, to) in (self.first..).zip(self.to) {
            let had = if self.adds { three(unit, to) } else { [zero; 3] };
            *to = put(unit, self.lookups.add(unit, sixteen, self.from, had));
        }
    }
}
