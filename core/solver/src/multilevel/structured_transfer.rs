//! Restriction and prolongation on regular meshes, sixteen nodes at a time.

use super::COARSE_CHUNK;
use super::finest::{Coarser, Finest};
use super::graph::Weights;
use super::lookups::Lookups;
use crate::algebra::Block;
use crate::lanes::aligned::{Lines, Sixteens};
use crate::lanes::symmetric::{put_inverse, times};
use crate::lanes::{LANES, Lanes, Sixteen, Vectors, Work, put, three, widest};
use crate::threads::Pool;

/// Groups of sixteen nodes in a chunk of work for a thread.
const CHUNK: usize = 64;
/// Smallest fraction of used lanes in the lookups of the finest level; below it shuffles cost more than they save.
const MIN_FILL: f64 = 0.25;

/// Vectors of the coarse levels, with the transfers between them.
#[derive(Debug)]
pub struct StructuredTransfer(Vec<Stage>);

/// One coarse level.
#[derive(Debug)]
struct Stage {
    /// Restriction from the finer level.
    restriction: Lookups,
    /// Prolongation to the finer level.
    prolongation: Lookups,
    /// Weighted inverses of the diagonal blocks, six numbers each, in groups of sixteen nodes; `None` on an intermediate level.
    inverse: Option<Lines<f32>>,
    r: Lines<f32>,
    /// Preconditioned residual; empty on an intermediate level, which reuses `r`.
    h: Lines<f32>,
}

impl StructuredTransfer {
    /// Transfers between levels, from the prolongation, the number of nodes and the weight of each coarse level; `None` if the mesh is irregular.
    pub fn new(levels: &[(Weights, usize)], shares: &[f64]) -> Option<Self> {
        let mut stages = Vec::with_capacity(levels.len());
        for ((weights, coarse), share) in levels.iter().zip(shares) {
            let least = if stages.is_empty() { MIN_FILL } else { 0.0 };
            let (prolongation, restriction) =
                (Lookups::new(weights, least)?, Lookups::new(&weights.transposed(*coarse), least)?);
            let room = |numbers: usize| Lines::new(numbers * coarse.next_multiple_of(LANES));
            let inverse = (*share > 0.0).then(|| room(6));
            let h = if inverse.is_some() { room(3) } else { Lines::new(0) };
            stages.push(Stage { restriction, prolongation, inverse, r: room(3), h });
        }
        Some(Self(stages))
    }

    /// Memory of weights and vectors, bytes.
    pub fn bytes(&self) -> usize {
        let of = |s: &Stage| {
            let inverse = s.inverse.as_ref().map_or(0, Lines::bytes);
            s.restriction.bytes() + s.prolongation.bytes() + inverse + s.r.bytes() + s.h.bytes()
        };
        self.0.iter().map(of).sum()
    }

    /// Stores the inverse of a diagonal block.
    pub fn put(&mut self, level: usize, node: usize, inverse: &Block) {
        let all = self.0[level].inverse.as_mut().expect("only levels with a share have inverses");
        put_inverse(all.flat_mut(), node, inverse);
    }

    /// Applies the preconditioner with all levels of this kind of transfer; arguments and result as in [`super::Multilevel::apply`].
    pub fn apply(&mut self, pool: &Pool, inverse: &[f32], r: &[Vectors], h: &mut [Vectors]) -> f64 {
        for at in 0..self.0.len() {
            let (finer, rest) = self.0.split_at_mut(at);
            let (from, Stage { restriction, inverse, r, h, .. }) =
                (finer.last().map_or(r, |stage| stage.r.vectors()), &mut rest[0]);
            let Some(inverse) = inverse else {
                pool.par_chunks(r.vectors_mut(), CHUNK, &|first, to| {
                    widest(Transfer { lookups: restriction, first, from, to, adds: false });
                });
                continue;
            };
            let inverse = inverse.flat().as_chunks().0.as_chunks().0;
            pool.par_chunks((r.vectors_mut(), h.vectors_mut()), COARSE_CHUNK / LANES, &|first, (r, h)| {
                widest(Restriction { restriction, first, inverse: &inverse[first..], from, r, h });
            });
        }
        for at in (1..self.0.len()).rev() {
            let (finer, rest) = self.0.split_at_mut(at);
            let (lookups, from, Stage { inverse, r, h, .. }) =
                (&rest[0].prolongation, rest[0].source(), &mut finer[at - 1]);
            let adds = inverse.is_some();
            let to = if adds { h } else { r };
            pool.par_chunks(to.vectors_mut(), CHUNK, &|first, to| widest(Transfer { lookups, first, from, to, adds }));
        }
        let (coarser, inverse) = (self.0.first(), inverse.as_chunks().0.as_chunks().0);
        pool.fold(Sixteens(h), &|first, Sixteens(h)| {
            let first = first / LANES;
            widest(Finest { coarser, first, inverse: &inverse[first..], r: &r[first..], h })
        })
    }
}

impl Stage {
    /// The vectors that are prolongated to the finer level.
    fn source(&self) -> &[Vectors] {
        if self.inverse.is_some() { self.h.vectors() } else { self.r.vectors() }
    }
}

impl Coarser for Stage {
    #[inline(always)]
    fn add<U: Lanes>(&self, unit: U, sixteen: usize, sum: [U::V; 3]) -> [U::V; 3] {
        self.prolongation.add(unit, sixteen, self.source(), sum)
    }
}

/// Restriction to the coarse nodes from a group of sixteen on, with the block Jacobi term of the level.
struct Restriction<'a> {
    restriction: &'a Lookups,
    first: usize,
    inverse: &'a [[Sixteen; 6]],
    from: &'a [Vectors],
    r: &'a mut [Vectors],
    h: &'a mut [Vectors],
}

impl Work for Restriction<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let zero = unit.load(&[0.0; LANES]);
        for (sixteen, ((r, h), inverse)) in (self.first..).zip(self.r.iter_mut().zip(self.h).zip(self.inverse)) {
            let sum = self.restriction.add(unit, sixteen, self.from, [zero; 3]);
            *r = put(unit, sum);
            *h = put(unit, times(unit, inverse, sum));
        }
    }
}

/// Transfer to the nodes from a group of sixteen on; adds to their values if `adds` is set, otherwise overwrites them.
struct Transfer<'a> {
    lookups: &'a Lookups,
    first: usize,
    from: &'a [Vectors],
    to: &'a mut [Vectors],
    adds: bool,
}

impl Work for Transfer<'_> {
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
