//! An additive multilevel preconditioner: on every level a share of block Jacobi, added up (Bramble, Pasciak and Xu 1990).
//!
//! Coarse matrices are those of Galerkin, `P^T A P`, with weights that the mesh alone decides ([`super::aggregate`]). A sum of
//! positive parts is positive whatever the matrix is, so nothing has to be estimated; a level costs its transfer and no product.

use super::aggregate::{Graph, Weights};
use super::elements::ElementSet;
use super::matrix::Matrix;
use super::pcg::symmetric_inverse;
use super::pool::Pool;
use super::{Block, Constraint, V3, axpy, dot, times};

/// Share of block Jacobi on all levels but the coarsest.
const SHARE: f64 = 0.6;
/// Nodes of the coarsest level, at most.
const COARSEST: usize = 12;
/// A level that keeps more of the nodes than this is not worth it.
const KEPT: f64 = 0.7;
/// Items in a piece of work for a thread.
const PIECE: usize = 512;

/// The levels above the finest, finer ones first.
#[derive(Debug, Default)]
pub struct Multilevel {
    levels: Vec<Level>,
}

#[derive(Debug, Default)]
struct Level {
    weights: Weights,
    /// `weights.weight`, without nodes that do not move.
    moving: Vec<f64>,
    /// By coarse node: fine node and place in `moving`.
    start: Vec<u32>,
    fine: Vec<(u32, u32)>,
    matrix: Matrix,
    products: Products,
    inverse: Vec<Block>,
    r: Vec<V3>,
    h: Vec<V3>,
}

/// What a block of the coarse matrix is made of: fine blocks as they are, then transposed ones.
#[derive(Debug, Default)]
struct Products {
    /// (coarse blocks x 2 + 1)
    start: Vec<u32>,
    /// Fine slot and the places of its two weights.
    terms: Vec<[u32; 3]>,
}

impl Multilevel {
    /// For a body's elements and the pattern of its matrix.
    pub fn new(matrix: &Matrix, sets: &[ElementSet]) -> Self {
        let mut levels: Vec<Level> = Vec::new();
        let mut graph = Graph::of_elements(matrix.rows(), sets);
        while graph.len() > COARSEST {
            let (coarse, weights) = graph.coarsen();
            if coarse.len() as f64 > KEPT * graph.len() as f64 {
                break;
            }
            let level = Level::new(levels.last().map_or(matrix, |level| &level.matrix), coarse.len(), weights);
            levels.push(level);
            graph = coarse;
        }
        Self { levels }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level| {
            let lists = level.weights.weight.len() * 28 + level.products.terms.len() * 12 + level.h.len() * 120;
            lists + level.products.start.len() * 4 + level.matrix.bytes()
        };
        self.levels.iter().map(of).sum()
    }

    /// Takes over new values; `again` where the matrix is that of the last time, and only constraints may differ.
    pub fn update(&mut self, pool: &Pool, matrix: &Matrix, constraints: &[Constraint], again: bool) {
        let Some(first) = self.levels.first_mut() else { return };
        let mut changed = !again;
        for i in 0..constraints.len() {
            let row = first.weights.start[i] as usize..first.weights.start[i + 1] as usize;
            let moves = constraints[i] != Constraint::Fixed;
            changed |= (first.moving[row.start] != 0.0) != moves;
            for at in row {
                first.moving[at] = if moves { first.weights.weight[at] } else { 0.0 };
            }
        }
        if !changed {
            return;
        }
        for at in 0..self.levels.len() {
            let (finer, rest) = self.levels.split_at_mut(at);
            let last = rest.len() == 1;
            rest[0].update(pool, finer.last().map_or(matrix, |level| &level.matrix), last);
        }
    }

    /// Adds to `h`, which has the share of the finest level, what the others make of `r`; gives `r.h`.
    pub fn add(&mut self, pool: &Pool, r: &[V3], h: &mut [V3], constraints: &[Constraint]) -> f64 {
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
            let rows = h.iter_mut().zip(&r[first..]).zip(&constraints[first..]);
            rows.fold(0.0, |sum, ((h, r), constraint)| {
                *h = constraint.filter(*h);
                sum + dot(*r, *h)
            })
        })
    }

    /// Share of block Jacobi on the finest level.
    pub fn share(&self) -> f64 {
        if self.levels.is_empty() { 1.0 } else { SHARE }
    }
}

impl Level {
    fn new(fine: &Matrix, coarse: usize, weights: Weights) -> Self {
        let mut level = Self {
            inverse: vec![[0.0; 9]; coarse],
            r: vec![[0.0; 3]; coarse],
            h: vec![[0.0; 3]; coarse],
            ..Self::default()
        };
        let mut by_coarse: Vec<(u32, u32, u32)> = Vec::with_capacity(weights.coarse.len());
        for i in 0..weights.start.len() - 1 {
            let row = weights.start[i]..weights.start[i + 1];
            by_coarse.extend(row.map(|at| (weights.coarse[at as usize], i as u32, at)));
        }
        by_coarse.sort_unstable();
        level.start = (0..=coarse as u32).map(|a| by_coarse.partition_point(|t| t.0 < a) as u32).collect();
        level.fine = by_coarse.iter().map(|t| (t.1, t.2)).collect();
        level.moving.clone_from(&weights.weight);
        level.weights = weights;
        level.list_products(fine, coarse);
        level
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

    fn list_products(&mut self, fine: &Matrix, coarse: usize) {
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
        let mut terms = vec![[0; 3]; start[start.len() - 1] as usize];
        lists(&mut |list, term| {
            terms[next[list] as usize] = term;
            next[list] += 1;
        });
        self.products = Products { start, terms };
        self.matrix = matrix;
    }

    /// The fine node a weight belongs to.
    fn node_of(&self, at: u32) -> usize {
        self.weights.start.partition_point(|start| *start <= at)
    }

    fn update(&mut self, pool: &Pool, fine: &Matrix, is_last: bool) {
        let (products, moving, values) = (&self.products, &self.moving, fine.values());
        pool.pieces(self.matrix.values_mut(), PIECE, &|first, out| {
            for (at, block) in out.iter_mut().enumerate() {
                let [direct, turned] = [0, 1].map(|k| {
                    let list = 2 * (first + at) + k;
                    let range = products.start[list] as usize..products.start[list + 1] as usize;
                    let mut sum = [0.0; 9];
                    for &[slot, a, b] in &products.terms[range] {
                        let weight = moving[a as usize] * moving[b as usize];
                        let from = &values[slot as usize];
                        (0..9).for_each(|e| sum[e] += weight * from[e]);
                    }
                    sum
                });
                *block = std::array::from_fn(|e| direct[e] + turned[3 * (e % 3) + e / 3]);
            }
        });
        let share = if is_last { 1.0 } else { SHARE };
        for (i, inverse) in self.inverse.iter_mut().enumerate() {
            // Where nothing moves there is nothing to add.
            *inverse = symmetric_inverse(self.matrix.diagonal(i)).map_or([0.0; 9], |m| m.map(|c| share * c));
        }
    }

    fn restrict(&mut self, pool: &Pool, r: &[V3]) {
        let (start, fine, moving) = (&self.start, &self.fine, &self.moving);
        pool.pieces(&mut self.r, PIECE, &|first, out| {
            for (a, out) in out.iter_mut().enumerate() {
                let range = start[first + a] as usize..start[first + a + 1] as usize;
                *out = fine[range].iter().fold([0.0; 3], |sum, &(i, at)| axpy(sum, moving[at as usize], r[i as usize]));
            }
        });
        for i in 0..self.h.len() {
            self.h[i] = times(&self.inverse[i], self.r[i]);
        }
    }

    fn prolong(&self, pool: &Pool, h: &mut [V3]) {
        pool.pieces(h, PIECE, &|first, h| self.prolong_piece(first, h));
    }

    fn prolong_piece(&self, first: usize, h: &mut [V3]) {
        for (i, h) in h.iter_mut().enumerate() {
            for at in self.weights.start[first + i] as usize..self.weights.start[first + i + 1] as usize {
                *h = axpy(*h, self.moving[at], self.h[self.weights.coarse[at] as usize]);
            }
        }
    }
}
