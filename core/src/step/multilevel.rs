//! An additive multilevel preconditioner: on every level a share of block Jacobi, added up (Bramble, Pasciak and Xu 1990).
//!
//! Coarse matrices are those of Galerkin, `P^T A P`, with weights that the mesh alone decides ([`super::aggregate`]). A sum of
//! positive parts is positive whatever the matrix is, so nothing has to be estimated; a level costs its transfer and no product.

use super::age::{Due, PARTS};
use super::aggregate::{Graph, Weights};
use super::elements::ElementSet;
use super::galerkin::Galerkin;
use super::inner::{WIDEST, width};
use super::lanes::{Lanes, Sixteen, Work, load, store, widest};
use super::matrix::Matrix;
use super::pcg::symmetric_inverse;
use super::pool::Pool;
use super::single::{Quad, SingleBlock};
use super::sliced::LANES;
use super::transfer::{Receiver, Transfer};
use super::windows::Windows;
use super::{Block, V3};
use std::ops::Range;

/// Share of block Jacobi on the finest level, and on all others: what takes the fewest iterations for many cloths and steps.
const OF_SQUARES: [f64; 2] = [0.5, 0.25];
const OF_AGGREGATES: [f64; 2] = [0.6, 0.4];
/// Nodes of the coarsest level, at most.
const COARSEST: usize = 12;
/// Items in a piece of work for a thread.
const PIECE: usize = 512;
/// The same of coarse nodes, which sum over many finer ones.
const COARSE_PIECE: usize = 128;

/// The levels above the finest, finer ones first.
#[derive(Debug, Default)]
pub struct Multilevel {
    levels: Vec<Level>,
    shares: [f64; 2],
    /// Of every part, coarse nodes by level, and the blocks of the finest level that they are made of.
    parts: Vec<(Vec<Range<usize>>, Range<usize>)>,
}

#[derive(Debug, Default)]
struct Level {
    transfer: Transfer,
    /// Of the finest transfer, where its mesh is regular.
    windows: Option<Windows>,
    galerkin: Galerkin,
    /// Where the diagonal blocks of the coarse matrix are, and the matrix.
    diagonal: Vec<u32>,
    values: Vec<SingleBlock>,
    inverse: Vec<Inverse>,
    r: Vec<Quad>,
    h: Vec<Quad>,
}

/// Columns of a 3 x 3 block, with zeros behind them.
pub type Inverse = [Quad; 3];

/// Block times vector.
#[inline(always)]
pub fn turned(m: &Inverse, v: Quad) -> Quad {
    let mut out = [0.0; 4];
    for c in 0..4 {
        out[c] = m[0][c] * v[0] + m[1][c] * v[1] + m[2][c] * v[2];
    }
    out
}

/// `a + s b`
#[inline(always)]
pub fn plus(a: Quad, s: f32, b: Quad) -> Quad {
    let mut out = a;
    for c in 0..4 {
        out[c] += s * b[c];
    }
    out
}

impl Multilevel {
    /// For a body's elements, its nodes at rest, m (n x 3), and the pattern of its matrix.
    pub fn new(matrix: &Matrix, sets: &[ElementSet], rest: &[V3]) -> Self {
        let mut levels: Vec<Level> = Vec::new();
        let mut graph = Graph::of_elements(rest, sets);
        let shares = if graph.is_level() { OF_SQUARES } else { OF_AGGREGATES };
        let mut finer: Option<Matrix> = None;
        while let Some((coarse, weights)) = Some(&graph).filter(|graph| graph.len() > COARSEST).and_then(Graph::coarsen)
        {
            let (mut level, pattern) = Level::new(finer.as_ref().unwrap_or(matrix), coarse.len(), &weights);
            if levels.is_empty() {
                level.windows = Windows::new(&weights, coarse.len());
            }
            levels.push(level);
            (graph, finer) = (coarse, Some(pattern));
        }
        let parts = parts(&levels);
        Self { levels, shares, parts }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level| {
            let lists = level.transfer.bytes() + level.galerkin.bytes() + level.diagonal.len() * 4;
            let vectors = level.h.len() * (2 * size_of::<Quad>() + size_of::<Inverse>());
            let windows = level.windows.as_ref().map_or(0, Windows::bytes);
            lists + vectors + windows + level.values.len() * size_of::<SingleBlock>()
        };
        self.levels.iter().map(of).sum()
    }

    /// Blocks of the finest level that are needed for what is due.
    pub fn sources(&self, due: Due) -> Range<usize> {
        match due {
            Due::All => 0..self.parts.iter().map(|(_, slots)| slots.end).max().unwrap_or(0),
            Due::Part(part) => self.parts[part].1.clone(),
        }
    }

    /// Makes what is due from values of the finest level.
    pub fn update(&mut self, pool: &Pool, values: &[SingleBlock], due: Due) {
        for at in 0..self.levels.len() {
            let nodes = match due {
                Due::All => 0..self.levels[at].h.len(),
                Due::Part(part) => self.parts[part].0[at].clone(),
            };
            let (finer, rest) = self.levels.split_at_mut(at);
            rest[0].update(pool, finer.last().map_or(values, |level| &level.values), nodes, self.shares[1]);
        }
    }

    /// `h = P r`, with `inverse` for the share of the finest level, by sixteen nodes; gives `r.h`, where `r` is zero for what may not move.
    pub fn apply(&mut self, pool: &Pool, inverse: &[f32], r: &[Quad], h: &mut [Quad]) -> f64 {
        for at in 0..self.levels.len() {
            let (finer, rest) = self.levels.split_at_mut(at);
            rest[0].restrict(pool, finer.last().map_or(r, |level| &level.r));
        }
        for at in (1..self.levels.len()).rev() {
            let (finer, rest) = self.levels.split_at_mut(at);
            rest[0].prolong(pool, &mut finer[at - 1].h);
        }
        if let Some(Level { windows: Some(windows), h, .. }) = self.levels.first_mut() {
            widest(TakeOver { windows, h });
        }
        let (coarse, inverse) = (self.levels.first(), inverse.as_chunks().0.as_chunks().0);
        pool.fold(h, &|first, h| {
            let (inverse, r) = (&inverse[first / LANES..], &r[first..]);
            widest(Finest { coarse, first, inverse, r, h })
        })
    }

    /// Share of block Jacobi on the finest level.
    pub fn share(&self) -> f64 {
        if self.levels.is_empty() { 1.0 } else { self.shares[0] }
    }
}

/// Cuts levels into parts that take about as long to make, finer levels first.
fn parts(levels: &[Level]) -> Vec<(Vec<Range<usize>>, Range<usize>)> {
    let mut total = 0;
    let mut ends: Vec<Vec<usize>> = Vec::with_capacity(levels.len());
    for level in levels {
        let terms = |node: usize| total + level.galerkin.terms_before(level.block(node));
        ends.push((0..=level.h.len()).map(terms).collect());
        total = terms(level.h.len());
    }
    let part = |part: usize| {
        let cut =
            |ends: &[usize], part: usize| ends.partition_point(|end| end * PARTS < part * total).min(ends.len() - 1);
        let nodes: Vec<_> = ends.iter().map(|ends| cut(ends, part)..cut(ends, part + 1)).collect();
        let sources = levels
            .first()
            .zip(nodes.first())
            .map_or(0..0, |(level, nodes)| level.galerkin.sources(level.block(nodes.start)..level.block(nodes.end)));
        (nodes, sources)
    };
    (0..PARTS).map(part).collect()
}

impl Level {
    /// And the pattern of its matrix.
    fn new(fine: &Matrix, coarse: usize, weights: &Weights) -> (Self, Matrix) {
        let (galerkin, pattern) = Galerkin::new(fine, coarse, weights);
        let level = Self {
            transfer: Transfer::new(weights, coarse),
            windows: None,
            galerkin,
            diagonal: (0..coarse).map(|a| pattern.diagonal_slot(a) as u32).collect(),
            values: vec![[0.0; 9]; pattern.blocks() + 1],
            inverse: vec![[[0.0; 4]; 3]; coarse],
            r: vec![[0.0; 4]; coarse],
            h: vec![[0.0; 4]; coarse],
        };
        (level, pattern)
    }

    /// Where the blocks of coarse nodes from one on begin.
    fn block(&self, node: usize) -> usize {
        self.diagonal.get(node).map_or(self.values.len() - 1, |slot| *slot as usize)
    }

    fn update(&mut self, pool: &Pool, fine: &[SingleBlock], nodes: Range<usize>, share: f64) {
        let blocks = self.block(nodes.start)..self.block(nodes.end);
        self.galerkin.update(pool, fine, blocks.start, &mut self.values[blocks]);
        let (values, diagonal) = (&self.values, &self.diagonal[nodes.clone()]);
        pool.pieces(&mut self.inverse[nodes], PIECE, &|first, out| {
            for (inverse, &slot) in out.iter_mut().zip(&diagonal[first..]) {
                // Where nothing moves, or rounding has left too little, there is nothing to add.
                let block = values[slot as usize].map(f64::from);
                let least = |b: &Block| b[0].min(b[4]).min(b[8]);
                let sound = |m: &Block| least(&block).min(least(m)) > 0.0 && width(&block, m) <= WIDEST;
                let inner = symmetric_inverse(&block).filter(sound);
                *inverse = columns(&inner.map_or([0.0; 9], |m| m.map(|c| share * c)));
            }
        });
    }

    fn restrict(&mut self, pool: &Pool, from: &[Quad]) {
        let (transfer, inverse) = (&self.transfer, &self.inverse);
        pool.pieces((&mut self.r[..], &mut self.h[..]), COARSE_PIECE, &|first, (r, h)| {
            widest(Restrict { transfer, first, inverse: &inverse[first..], from, r, h });
        });
    }

    fn prolong(&self, pool: &Pool, h: &mut [Quad]) {
        pool.pieces(h, PIECE, &|first, h| self.transfer.spread(first, &self.h, &mut More(h)));
    }
}

/// Columns of a symmetric block, in single precision.
pub fn columns(m: &Block) -> Inverse {
    [0, 1, 2].map(|c| [m[3 * c] as f32, m[3 * c + 1] as f32, m[3 * c + 2] as f32, 0.0])
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

/// What is coarse, to where it is looked up.
struct TakeOver<'a> {
    windows: &'a mut Windows,
    h: &'a [Quad],
}

impl Work for TakeOver<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        self.windows.take(unit, self.h);
    }
}

/// Fine nodes `first` on: their own part of P, and that of all coarser levels; gives `r . h`.
struct Finest<'a> {
    coarse: Option<&'a Level>,
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
        let windows = coarse.and_then(|level| level.windows.as_ref());
        let mut all = unit.load(&[0.0; LANES]);
        let slices = h.as_chunks_mut().0.iter_mut().zip(r.as_chunks().0).zip(inverse);
        for (slice, ((h, r), m)) in (first / LANES..).zip(slices) {
            let r = unit.planes(load(unit, r));
            let mut own = [r[0]; 3];
            for (c, places) in [[0, 1, 2], [1, 3, 4], [2, 4, 5]].into_iter().enumerate() {
                own[c] = unit.mul(unit.load(&m[places[0]]), r[0]);
                own[c] = unit.fma(unit.load(&m[places[1]]), r[1], own[c]);
                own[c] = unit.fma(unit.load(&m[places[2]]), r[2], own[c]);
            }
            if let Some(windows) = windows {
                own = windows.add(unit, slice, own);
                for c in 0..3 {
                    all = unit.fma(own[c], r[c], all);
                }
            }
            store(unit, h, unit.vectors(own));
        }
        if windows.is_none() {
            if let Some(level) = coarse {
                level.transfer.spread(first, &level.h, &mut More(h));
            }
            let (h, r) = (h.as_flattened().as_chunks().0, r.as_flattened().as_chunks().0);
            for (h, r) in h.iter().zip(r) {
                all = unit.fma(unit.load(h), unit.load(r), all);
            }
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
