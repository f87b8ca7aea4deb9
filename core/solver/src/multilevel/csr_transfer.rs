//! Restriction and prolongation on irregular meshes, node by node, with weights in CSR format.

use super::COARSE_CHUNK;
use super::finest::{Coarser, Finest};
use super::graph::Weights;
use super::weights_by_row::WeightsByRow;
use crate::algebra::Block;
use crate::lanes::aligned::Sixteens;
use crate::lanes::{LANES, Lanes, Quad, Vectors, Work, load, store, three, widest};
use crate::threads::Pool;

/// Number of nodes in a chunk of work for a thread.
const CHUNK: usize = 512;

/// Vectors of all levels, with the transfers between them.
#[derive(Debug, Default)]
pub struct CsrTransfer {
    /// Residual of the finest level, as an array of vectors.
    r: Vec<Quad>,
    stages: Vec<Stage>,
}

/// One coarse level.
#[derive(Debug)]
struct Stage {
    transfer: WeightsByRow,
    inverse: Vec<Inverse>,
    r: Vec<Quad>,
    h: Vec<Quad>,
}

/// Columns of a 3 x 3 block, each padded with a zero.
type Inverse = [Quad; 3];

impl CsrTransfer {
    /// Transfers between levels, from the weights and the number of nodes of each coarse level.
    pub fn new(levels: &[(Weights, usize)]) -> Self {
        let stage = |(weights, coarse): &(Weights, usize)| Stage {
            transfer: WeightsByRow::new(weights, *coarse),
            inverse: vec![[[0.0; 4]; 3]; *coarse],
            r: vec![[0.0; 4]; *coarse],
            h: vec![[0.0; 4]; *coarse],
        };
        let finest = levels.first().map_or(0, |(weights, _)| weights.start.len() - 1);
        Self { r: vec![[0.0; 4]; finest.next_multiple_of(LANES)], stages: levels.iter().map(stage).collect() }
    }

    /// Memory of weights and vectors, bytes.
    pub fn bytes(&self) -> usize {
        let vectors = |stage: &Stage| stage.h.len() * (2 * size_of::<Quad>() + size_of::<Inverse>());
        16 * self.r.len() + self.stages.iter().map(|stage| stage.transfer.bytes() + vectors(stage)).sum::<usize>()
    }

    /// Stores the inverse of a diagonal block.
    pub fn put(&mut self, level: usize, node: usize, m: &Block) {
        let columns = [0, 1, 2].map(|c| [m[3 * c] as f32, m[3 * c + 1] as f32, m[3 * c + 2] as f32, 0.0]);
        self.stages[level].inverse[node] = columns;
    }

    /// Applies the preconditioner with all levels of this kind of transfer; arguments and result as in [`super::Multilevel::apply`].
    pub fn apply(&mut self, pool: &Pool, inverse: &[f32], r: &[Vectors], h: &mut [Vectors]) -> f64 {
        let Self { r: finest, stages } = self;
        pool.par_chunks(finest.as_chunks_mut().0, CHUNK / LANES, &|first, to| {
            widest(Interleave { from: &r[first..], to })
        });
        for at in 0..stages.len() {
            let (finer, rest) = stages.split_at_mut(at);
            let (from, Stage { transfer, inverse, r, h }) =
                (finer.last().map_or(&*finest, |stage| &stage.r), &mut rest[0]);
            pool.par_chunks((&mut r[..], &mut h[..]), COARSE_CHUNK, &|first, (r, h)| {
                widest(Restriction { transfer, first, inverse: &inverse[first..], from, r, h });
            });
        }
        for at in (1..stages.len()).rev() {
            let (finer, rest) = stages.split_at_mut(at);
            let (transfer, from) = (&rest[0].transfer, &rest[0].h);
            pool.par_chunks(&mut finer[at - 1].h[..], CHUNK, &|first, h| transfer.prolongate(first, from, h));
        }
        let (coarser, inverse) = (stages.first(), inverse.as_chunks().0.as_chunks().0);
        pool.fold(Sixteens(h), &|first, Sixteens(h)| {
            let first = first / LANES;
            widest(Finest { coarser, first, inverse: &inverse[first..], r: &r[first..], h })
        })
    }
}

/// Converts groups of sixteen nodes, stored by component, to an array of vectors.
struct Interleave<'a> {
    from: &'a [Vectors],
    to: &'a mut [[Quad; LANES]],
}

impl Work for Interleave<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        for (to, from) in self.to.iter_mut().zip(self.from) {
            store(unit, to, unit.vectors(three(unit, from)));
        }
    }
}

/// Product of a block and a vector.
#[inline(always)]
fn turned(m: &Inverse, v: Quad) -> Quad {
    let mut out = [0.0; 4];
    for c in 0..4 {
        out[c] = m[0][c] * v[0] + m[1][c] * v[1] + m[2][c] * v[2];
    }
    out
}

/// Restriction to the coarse nodes from `first`, with the block Jacobi term of the level.
struct Restriction<'a> {
    transfer: &'a WeightsByRow,
    first: usize,
    inverse: &'a [Inverse],
    from: &'a [Quad],
    r: &'a mut [Quad],
    h: &'a mut [Quad],
}

impl Work for Restriction<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { transfer, first, inverse, from, r, h } = self;
        for (a, ((r, h), inverse)) in r.iter_mut().zip(h).zip(inverse).enumerate() {
            *r = transfer.restricted(unit, first + a, from);
            *h = turned(inverse, *r);
        }
    }
}

impl Coarser for Stage {
    #[inline(always)]
    fn add<U: Lanes>(&self, unit: U, sixteen: usize, sum: [U::V; 3]) -> [U::V; 3] {
        let mut vectors = [[0.0; 4]; LANES];
        store(unit, &mut vectors, unit.vectors(sum));
        self.transfer.prolongate(LANES * sixteen, &self.h, &mut vectors);
        unit.planes(load(unit, &vectors))
    }
}
