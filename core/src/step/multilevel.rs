//! An additive multilevel preconditioner: on every level a share of block Jacobi, added up (Bramble, Pasciak and Xu 1990).
//!
//! Coarse matrices are those of Galerkin, `P^T A P`, with weights that the mesh alone decides ([`super::aggregate`]). A sum of
//! positive parts is positive whatever the matrix is, so nothing has to be estimated; a level costs its transfer and no product.

use super::Block;
use super::aggregate::{Graph, Weights};
use super::elements::ElementSet;
use super::inner::is_narrow;
use super::matrix::Matrix;
use super::pcg::symmetric_inverse;
use super::pool::Pool;
use super::single::{Quad, Single, SingleBlock};

/// Share of block Jacobi on all levels but the coarsest.
const SHARE: f64 = 0.6;
/// Nodes of the coarsest level, at most.
const COARSEST: usize = 12;
/// A level that keeps more of the nodes than this is not worth it.
const KEPT: f64 = 0.7;
/// Items in a piece of work for a thread.
const PIECE: usize = 512;
/// The same of coarse nodes, which sum over many finer ones.
const COARSE_PIECE: usize = 128;

/// The levels above the finest, finer ones first.
#[derive(Debug, Default)]
pub struct Multilevel {
    levels: Vec<Level>,
}

#[derive(Debug, Default)]
struct Level {
    weights: Weights,
    /// By coarse node: fine node and weight.
    start: Vec<u32>,
    fine: Vec<(u32, f32)>,
    /// Where the diagonal blocks of the coarse matrix are, and the matrix.
    diagonal: Vec<u32>,
    values: Vec<SingleBlock>,
    products: Products,
    inverse: Vec<Inverse>,
    r: Vec<Quad>,
    h: Vec<Quad>,
}

/// Columns of a 3 x 3 block, with zeros behind them.
pub type Inverse = [Quad; 3];

/// What a block of the coarse matrix is made of: fine blocks as they are, then transposed ones.
#[derive(Debug, Default)]
struct Products {
    /// (coarse blocks x 2 + 1)
    start: Vec<u32>,
    /// Fine slot and its weight.
    terms: Vec<(u32, f32)>,
}

/// Block times vector.
#[inline(always)]
pub fn turned(m: &Inverse, v: Quad) -> Quad {
    std::array::from_fn(|c| m[0][c] * v[0] + m[1][c] * v[1] + m[2][c] * v[2])
}

/// `a + s b`
#[inline(always)]
pub fn plus(a: Quad, s: f32, b: Quad) -> Quad {
    std::array::from_fn(|c| a[c] + s * b[c])
}

impl Multilevel {
    /// For a body's elements and the pattern of its matrix.
    pub fn new(matrix: &Matrix, sets: &[ElementSet]) -> Self {
        let mut levels: Vec<Level> = Vec::new();
        let mut graph = Graph::of_elements(matrix.rows(), sets);
        let mut finer: Option<Matrix> = None;
        while graph.len() > COARSEST {
            let (coarse, weights) = graph.coarsen();
            if coarse.len() as f64 > KEPT * graph.len() as f64 {
                break;
            }
            let (level, pattern) = Level::new(finer.as_ref().unwrap_or(matrix), coarse.len(), weights);
            levels.push(level);
            (graph, finer) = (coarse, Some(pattern));
        }
        Self { levels }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level| {
            let lists = level.weights.weight.len() * 20 + level.products.terms.len() * 8 + level.h.len() * 88;
            lists + level.products.start.len() * 4 + level.values.len() * size_of::<SingleBlock>()
        };
        self.levels.iter().map(of).sum()
    }

    /// Takes over new values.
    pub fn update(&mut self, pool: &Pool, matrix: &Single) {
        for at in 0..self.levels.len() {
            let (finer, rest) = self.levels.split_at_mut(at);
            let last = rest.len() == 1;
            rest[0].update(pool, finer.last().map_or(matrix.values(), |level| &level.values), last);
        }
    }

    /// Adds to `h`, which has the share of the finest level, what the others make of `r`; gives `r.h`, where `r` is zero for what
    /// may not move.
    pub fn add(&mut self, pool: &Pool, r: &[Quad], h: &mut [Quad]) -> f64 {
        for at in 0..self.levels.len() {
            let (finer, rest) = self.levels.split_at_mut(at);
            rest[0].restrict(pool, finer.last().map_or(r, |level| &level.r));
        }
        for at in (0..self.levels.len()).rev() {
            let (finer, rest) = self.levels.split_at_mut(at);
            if let Some(finer) = finer.last_mut() {
                rest[0].prolong(pool, &mut finer.h);
            }
        }
        pool.fold(h, &|first, h| {
            if let Some(level) = self.levels.first() {
                level.prolong_piece(first, h);
            }
            dot(h, &r[first..])
        })
    }

    /// Share of block Jacobi on the finest level.
    pub fn share(&self) -> f64 {
        if self.levels.is_empty() { 1.0 } else { SHARE }
    }
}

/// Sum of products, in lanes of single precision: for a few hundred vectors.
#[inline(always)]
pub fn dot(a: &[Quad], b: &[Quad]) -> f64 {
    let mut sum = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|c| sum[c] += a[c] * b[c]);
    }
    f64::from(sum[0]) + f64::from(sum[1]) + f64::from(sum[2])
}

impl Level {
    /// And the pattern of its matrix.
    fn new(fine: &Matrix, coarse: usize, weights: Weights) -> (Self, Matrix) {
        let mut level = Self {
            inverse: vec![[[0.0; 4]; 3]; coarse],
            r: vec![[0.0; 4]; coarse],
            h: vec![[0.0; 4]; coarse],
            ..Self::default()
        };
        let mut by_coarse: Vec<(u32, u32, f32)> = Vec::with_capacity(weights.coarse.len());
        for i in 0..weights.start.len() - 1 {
            let row = weights.start[i] as usize..weights.start[i + 1] as usize;
            by_coarse.extend(row.map(|at| (weights.coarse[at], i as u32, weights.weight[at])));
        }
        by_coarse.sort_unstable_by_key(|t| (t.0, t.1));
        level.start = (0..=coarse as u32).map(|a| by_coarse.partition_point(|t| t.0 < a) as u32).collect();
        level.fine = by_coarse.iter().map(|t| (t.1, t.2)).collect();
        level.weights = weights;
        let pattern = level.list_products(fine, coarse);
        level.diagonal = (0..coarse).map(|a| pattern.diagonal_slot(a) as u32).collect();
        level.values = vec![[0.0; 9]; pattern.values().len() + 1];
        (level, pattern)
    }

    /// Every fine block with two weights: (a, b, slot, place of a, place of b).
    fn visit(&self, fine: &Matrix, mut visit: impl FnMut(u32, u32, [u32; 3])) {
        let row = |i: u32| self.weights.start[i as usize]..self.weights.start[i as usize + 1];
        let mut pair = |i: u32, j: u32, slot: u32| {
            for at in row(i) {
                for bt in row(j) {
                    visit(self.weights.coarse[at as usize], self.weights.coarse[bt as usize], [slot, at, bt]);
                }
            }
        };
        for i in 0..fine.rows() as u32 {
            pair(i, i, fine.diagonal_slot(i as usize) as u32);
        }
        for (i, (j, slot)) in fine.off_diagonal() {
            pair(i, j, slot);
        }
    }

    fn list_products(&mut self, fine: &Matrix, coarse: usize) -> Matrix {
        let mut matrix = Matrix::default();
        matrix.set_pattern(coarse, |pair| {
            self.visit(fine, |a, b, _| {
                if a != b {
                    pair(a.min(b), a.max(b));
                }
            });
        });
        // Of a block on the fine diagonal, (a, b) and (b, a) are both visited: one of them is enough.
        let on_diagonal = |term: &[u32; 3]| self.node_of(term[1]) == self.node_of(term[2]);
        let lists = |visit: &mut dyn FnMut(usize, [u32; 3])| {
            self.visit(fine, |a, b, term| {
                let slot = matrix.slot(a.min(b), a.max(b));
                match (a.cmp(&b), on_diagonal(&term)) {
                    (std::cmp::Ordering::Less, _) | (std::cmp::Ordering::Equal, true) => visit(2 * slot, term),
                    (std::cmp::Ordering::Greater, false) => visit(2 * slot + 1, term),
                    (std::cmp::Ordering::Greater, true) => {}
                    (std::cmp::Ordering::Equal, false) => {
                        visit(2 * slot, term);
                        visit(2 * slot + 1, term);
                    }
                }
            });
        };
        let mut start = vec![0_u32; 2 * matrix.values().len() + 1];
        lists(&mut |list, _| start[list + 1] += 1);
        for list in 1..start.len() {
            start[list] += start[list - 1];
        }
        let mut next = start.clone();
        let mut terms = vec![(0, 0.0); start[start.len() - 1] as usize];
        lists(&mut |list, [slot, a, b]| {
            terms[next[list] as usize] = (slot, self.weights.weight[a as usize] * self.weights.weight[b as usize]);
            next[list] += 1;
        });
        self.products = Products { start, terms };
        matrix
    }

    /// The fine node a weight belongs to.
    fn node_of(&self, at: u32) -> usize {
        self.weights.start.partition_point(|start| *start <= at)
    }

    fn update(&mut self, pool: &Pool, fine: &[SingleBlock], is_last: bool) {
        let (products, fine, count) = (&self.products, fine.as_flattened(), self.values.len() - 1);
        pool.pieces(&mut self.values[..count], PIECE, &|first, out| {
            pulp::Arch::new().dispatch(Galerkin { products, fine, first, out });
        });
        let share = if is_last { 1.0 } else { SHARE };
        let (values, diagonal) = (&self.values, &self.diagonal);
        pool.pieces(&mut self.inverse[..], PIECE, &|first, out| {
            for (inverse, &slot) in out.iter_mut().zip(&diagonal[first..]) {
                // Where nothing moves, or rounding has left too little, there is nothing to add.
                let block = values[slot as usize].map(f64::from);
                let least = |b: &Block| b[0].min(b[4]).min(b[8]);
                let sound = |m: &Block| least(&block).min(least(m)) > 0.0 && is_narrow(&block, m);
                let inner = symmetric_inverse(&block).filter(sound);
                *inverse = columns(&inner.map_or([0.0; 9], |m| m.map(|c| share * c)));
            }
        });
    }

    fn restrict(&mut self, pool: &Pool, r: &[Quad]) {
        let (start, fine, inverse) = (&self.start, &self.fine, &self.inverse);
        pool.pieces((&mut self.r[..], &mut self.h[..]), COARSE_PIECE, &|first, (r_coarse, h)| {
            for a in 0..h.len() {
                let range = start[first + a] as usize..start[first + a + 1] as usize;
                let sum = fine[range].iter().fold([0.0; 4], |sum, &(i, weight)| plus(sum, weight, r[i as usize]));
                (r_coarse[a], h[a]) = (sum, turned(&inverse[first + a], sum));
            }
        });
    }

    fn prolong(&self, pool: &Pool, h: &mut [Quad]) {
        pool.pieces(h, PIECE, &|first, h| self.prolong_piece(first, h));
    }

    fn prolong_piece(&self, first: usize, h: &mut [Quad]) {
        let Weights { start, coarse, weight } = &self.weights;
        for (i, h) in h.iter_mut().enumerate() {
            let range = start[first + i] as usize..start[first + i + 1] as usize;
            let terms = coarse[range.clone()].iter().zip(&weight[range]);
            *h = terms.fold(*h, |sum, (&a, &weight)| plus(sum, weight, self.h[a as usize]));
        }
    }
}

/// Columns of a symmetric block, in single precision.
pub fn columns(m: &Block) -> Inverse {
    [0, 1, 2].map(|c| [m[3 * c] as f32, m[3 * c + 1] as f32, m[3 * c + 2] as f32, 0.0])
}

/// `P^T A P`, blocks `first` on.
struct Galerkin<'a> {
    products: &'a Products,
    fine: &'a [f32],
    first: usize,
    out: &'a mut [SingleBlock],
}

impl pulp::NullaryFnOnce for Galerkin<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (at, block) in self.out.iter_mut().enumerate() {
            let list = 2 * (self.first + at);
            let (direct, turned) = (sum(self.products, list, self.fine), sum(self.products, list + 1, self.fine));
            *block = std::array::from_fn(|e| direct[e] + turned[3 * (e % 3) + e / 3]);
        }
    }
}

/// Of one list; numbers past the ninth belong to other blocks and are not looked at.
#[inline(always)]
fn sum(Products { start, terms }: &Products, list: usize, fine: &[f32]) -> [f32; 16] {
    let mut sum = [0.0_f32; 16];
    for &(slot, weight) in &terms[start[list] as usize..start[list + 1] as usize] {
        let block: &[f32; 16] = fine[9 * slot as usize..].first_chunk().expect("blocks have one behind them");
        (0..16).for_each(|e| sum[e] += weight * block[e]);
    }
    sum
}
