//! The Galerkin matrix of a coarse level, `P^T A P`, from a list of terms for each of its blocks.

use super::graph::Weights;
use crate::algebra::SingleBlock;
use crate::matrix::Matrix;
use crate::threads::Pool;
use pliant_plugin_api::lanes::vector_unit;
use std::cmp::Ordering;
use std::ops::Range;

/// The terms of each coarse block: first fine blocks, then transposed fine blocks.
#[derive(Debug, Default)]
pub struct Galerkin {
    /// Index of the first term of each list (coarse blocks x 2 + 1).
    start: Vec<u32>,
    /// Fine slots with the products of their weights.
    terms: Vec<(u32, f32)>,
}

/// Number of blocks in a chunk of work for a thread.
const CHUNK: usize = 256;

impl Galerkin {
    /// Lists the terms for a fine pattern and a prolongation from `coarse` nodes. Also returns the coarse matrix with its pattern.
    pub fn new(fine: &Matrix, coarse: usize, weights: &Weights) -> (Self, Matrix) {
        let mut matrix = Matrix::default();
        matrix.set_pattern(coarse, |pair| {
            visit(fine, weights, |a, b, _, _| {
                if a != b {
                    pair(a.min(b), a.max(b));
                }
            });
        });
        // For a block on the fine diagonal both (a, b) and (b, a) are visited; one of them suffices.
        let lists = |add: &mut dyn FnMut(usize, (u32, f32))| {
            visit(fine, weights, |a, b, is_diagonal, term| {
                let slot = matrix.slot(a.min(b), a.max(b));
                match (a.cmp(&b), is_diagonal) {
                    (Ordering::Less, _) | (Ordering::Equal, true) => add(2 * slot, term),
                    (Ordering::Greater, false) => add(2 * slot + 1, term),
                    (Ordering::Greater, true) => {}
                    (Ordering::Equal, false) => {
                        add(2 * slot, term);
                        add(2 * slot + 1, term);
                    }
                }
            });
        };
        let mut start = vec![0_u32; 2 * matrix.blocks() + 1];
        lists(&mut |list, _| start[list + 1] += 1);
        for list in 1..start.len() {
            start[list] += start[list - 1];
        }
        let mut next = start.clone();
        let mut terms = vec![(0, 0.0); start[start.len() - 1] as usize];
        lists(&mut |list, term| {
            terms[next[list] as usize] = term;
            next[list] += 1;
        });
        (Self { start, terms }, matrix)
    }

    /// Memory of the terms, bytes.
    pub fn bytes(&self) -> usize {
        self.terms.len() * 8 + self.start.len() * 4
    }

    /// Number of terms before a coarse block.
    pub fn terms_before(&self, block: usize) -> usize {
        self.start[2 * block] as usize
    }

    /// A range of fine slots that contains all terms of some coarse blocks.
    pub fn sources(&self, blocks: Range<usize>) -> Range<usize> {
        let slots = self.terms[self.terms_before(blocks.start)..self.terms_before(blocks.end)]
            .iter()
            .map(|term| term.0 as usize);
        slots.clone().min().map_or(0..0, |least| least..slots.max().map_or(0, |most| most + 1))
    }

    /// Computes the coarse blocks from `first` from the fine blocks, which are padded by one block at the end.
    pub fn update(&self, pool: &Pool, fine: &[SingleBlock], first: usize, coarse: &mut [SingleBlock]) {
        let fine = fine.as_flattened();
        pool.par_chunks(coarse, CHUNK, &|at, out| {
            vector_unit().dispatch(Sums { galerkin: self, fine, first: first + at, out });
        });
    }
}

/// Calls `visit` with every pair of coarse nodes a, b of a fine block, whether the block is on the diagonal, and its slot with the product of
/// weights.
fn visit(fine: &Matrix, weights: &Weights, mut visit: impl FnMut(u32, u32, bool, (u32, f32))) {
    let mut pair = |i: u32, j: u32, slot: u32| {
        for (a, left) in weights.of(i as usize) {
            for (b, right) in weights.of(j as usize) {
                visit(a, b, i == j, (slot, left * right));
            }
        }
    };
    for i in 0..fine.rows() as u32 {
        pair(i, i, fine.diagonal_slot(i as usize) as u32);
    }
    for block in fine.upper_blocks() {
        pair(block.row, block.column, block.slot);
    }
}

/// Computes the coarse blocks from `first`.
struct Sums<'a> {
    galerkin: &'a Galerkin,
    fine: &'a [f32],
    first: usize,
    out: &'a mut [SingleBlock],
}

impl pulp::NullaryFnOnce for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (at, block) in self.out.iter_mut().enumerate() {
            let list = 2 * (self.first + at);
            let direct = sum(self.galerkin, list, self.fine);
            let turned = sum(self.galerkin, list + 1, self.fine);
            for e in 0..9 {
                block[e] = direct[e] + turned[3 * (e % 3) + e / 3];
            }
        }
    }
}

/// Sum of one list of terms, in two independent sums that hide latency. Only the first nine numbers are meaningful; the others belong to adjacent
/// blocks.
#[inline(always)]
fn sum(Galerkin { start, terms }: &Galerkin, list: usize, fine: &[f32]) -> [f32; 16] {
    let (pairs, last) = terms[start[list] as usize..start[list + 1] as usize].as_chunks::<2>();
    let (mut even, mut odd) = ([0.0_f32; 16], [0.0_f32; 16]);
    for [first, second] in pairs {
        add(&mut even, first, fine);
        add(&mut odd, second, fine);
    }
    if let [last] = last {
        add(&mut even, last, fine);
    }
    for e in 0..16 {
        even[e] += odd[e];
    }
    even
}

#[inline(always)]
fn add(sum: &mut [f32; 16], &(slot, weight): &(u32, f32), fine: &[f32]) {
    let block: &[f32; 16] = fine[9 * slot as usize..].first_chunk().expect("blocks have one behind them");
    for e in 0..16 {
        sum[e] += weight * block[e];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coarse_matrix_is_the_galerkin_product() {
        let (n, coarse) = (40_usize, 9_usize);
        let mut matrix = Matrix::default();
        matrix.set_pattern(n, |pair| {
            (0..n as u32).for_each(|i| (1..6).filter(|k| i + k * k < n as u32).for_each(|k| pair(i, i + k * k)));
        });
        let mut weights = Weights { start: vec![0], ..Weights::default() };
        for i in 0..n {
            weights.coarse.extend((0..1 + i % 3).map(|k| ((i / 5 + 2 * k) % coarse) as u32));
            weights.weight.extend((0..1 + i % 3).map(|k| 0.2 + 0.1 * (i + k) as f32 / n as f32));
            weights.start.push(weights.coarse.len() as u32);
        }
        let mut fine: Vec<SingleBlock> =
            (0..=matrix.blocks()).map(|b| std::array::from_fn(|e| (1.7 * (9 * b + e) as f32).sin())).collect();
        for i in 0..n {
            let b = fine[matrix.diagonal_slot(i)];
            fine[matrix.diagonal_slot(i)] = [b[0], b[1], b[2], b[1], b[4], b[5], b[2], b[5], b[8]];
        }
        let (galerkin, pattern) = Galerkin::new(&matrix, coarse, &weights);
        let mut got = vec![[0.0; 9]; pattern.blocks()];
        galerkin.update(&Pool::new(1), &fine, 0, &mut got);
        let mut want = vec![[0.0_f64; 9]; coarse * coarse];
        let mut add = |i: usize, j: usize, block: &dyn Fn(usize) -> f32| {
            for (a, left) in weights.of(i) {
                for (b, right) in weights.of(j) {
                    let to = &mut want[a as usize * coarse + b as usize];
                    (0..9).for_each(|e| to[e] += f64::from(left * right * block(e)));
                }
            }
        };
        for i in 0..n {
            add(i, i, &|e| fine[matrix.diagonal_slot(i)][e]);
        }
        for block in matrix.upper_blocks() {
            let (i, j, values) = (block.row as usize, block.column as usize, &fine[block.slot as usize]);
            add(i, j, &|e| values[e]);
            add(j, i, &|e| values[3 * (e % 3) + e / 3]);
        }
        for a in 0..coarse as u32 {
            for b in a..coarse as u32 {
                let want = want[a as usize * coarse + b as usize];
                if want != [0.0; 9] {
                    let got = got[pattern.slot(a, b)];
                    assert!((0..9).all(|e| (f64::from(got[e]) - want[e]).abs() < 1e-5), "{a} {b}: {got:?} {want:?}");
                }
            }
        }
    }
}
