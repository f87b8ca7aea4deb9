//! An additive multilevel preconditioner (Bramble, Pasciak and Xu 1990): the sum over all levels of weighted block Jacobi terms. Intermediate
//! levels of a semicoarsened grid have the weight zero.
//!
//! Coarse matrices are Galerkin products `P^T A P` with interpolation weights from the mesh alone ([`coarsen`]). A sum of positive definite
//! terms is positive definite whatever the matrix is, so no eigenvalues have to be estimated. The cost of a level is its transfer, without a
//! matrix product.

mod aggregate;
mod coarsen;
mod csr_transfer;
mod finest;
mod galerkin;
mod graph;
mod lookups;
mod planar_grid;
pub mod refresh;
mod structured_transfer;
mod weights_by_row;

use super::algebra::{Block, MAX_BLOCK_CONDITION, SingleBlock, Vec3, condition, symmetric_inverse};
use super::elements::ElementSet;
use super::lanes::Vectors;
use super::matrix::Matrix;
use super::threads::Pool;
use coarsen::{Coarsened, Layout};
use csr_transfer::CsrTransfer;
use galerkin::Galerkin;
use graph::Weights;
use planar_grid::CoarsenedAxes;
use refresh::{Due, PARTS};
use std::ops::Range;
use structured_transfer::StructuredTransfer;

/// Weights of the block Jacobi terms by level, tuned for the fewest iterations over many cloths and steps.
#[derive(Clone, Copy, Debug)]
struct LevelWeights {
    /// Weight on the finest level.
    finest: f64,
    /// Weight on the first coarse level.
    first: f64,
    /// Ratio of the weights of consecutive coarse levels.
    ratio: f64,
}

const OF_SQUARES: LevelWeights = LevelWeights { finest: 0.5, first: 0.25, ratio: 1.0 };
const OF_SMOOTH_SQUARES: LevelWeights = LevelWeights { finest: 0.5, first: 0.2, ratio: 0.85 };
const OF_AGGREGATES: LevelWeights = LevelWeights { finest: 0.6, first: 0.4, ratio: 1.0 };

impl LevelWeights {
    /// The weight of each coarse level, from its coarsened axes. Of two consecutive levels that coarsen one axis each, the first has the weight zero.
    fn of(&self, axes: &[CoarsenedAxes]) -> Vec<f64> {
        let (mut weight, mut weights_of_levels) = (self.first, Vec::with_capacity(axes.len()));
        for at in 0..axes.len() {
            if axes[at..].starts_with(&[CoarsenedAxes::Across, CoarsenedAxes::Along]) {
                weights_of_levels.push(0.0);
            } else {
                weights_of_levels.push(weight);
                weight *= self.ratio;
            }
        }
        weights_of_levels
    }
}

/// Largest number of nodes of the coarsest level.
const MAX_COARSEST: usize = 12;
/// Smallest number of coarse nodes in a chunk of work for a thread; each is a sum over many finer nodes.
const COARSE_CHUNK: usize = 256;

/// The preconditioner: its coarse levels from fine to coarse.
#[derive(Debug, Default)]
pub struct Multilevel {
    levels: Vec<Level>,
    /// Weight of block Jacobi on the finest level.
    finest: f64,
    /// Parts of the levels, which are refreshed in turn.
    parts: Vec<Part>,
    transfer: TransferOperator,
}

/// A part of all levels that is refreshed at once.
#[derive(Debug)]
struct Part {
    /// Range of coarse nodes of each level.
    nodes: Vec<Range<usize>>,
    /// Range of the finest level's slots that they depend on.
    sources: Range<usize>,
}

/// The matrix of a coarse level.
#[derive(Debug)]
struct Level {
    galerkin: Galerkin,
    /// Weight of block Jacobi; 0 on an intermediate level.
    weight: f64,
    /// Slots of the diagonal blocks.
    diagonal: Vec<u32>,
    values: Vec<SingleBlock>,
}

/// Restriction and prolongation between the levels.
#[derive(Debug)]
enum TransferOperator {
    /// Sixteen nodes at a time, for regular meshes.
    Structured(StructuredTransfer),
    /// Node by node, for irregular meshes.
    Csr(CsrTransfer),
}

impl Default for TransferOperator {
    fn default() -> Self {
        Self::Csr(CsrTransfer::default())
    }
}

impl Multilevel {
    /// Builds the levels for the pattern of a body's matrix, its elements and its rest positions, m (n x 3).
    pub fn new(matrix: &Matrix, sets: &[ElementSet], rest: &[Vec3]) -> Self {
        let mut layout = Layout::of_elements(rest, sets);
        let weights_of_levels = match layout.planar_grid() {
            Some(grid) if grid.is_smooth() => OF_SMOOTH_SQUARES,
            Some(_) => OF_SQUARES,
            None => OF_AGGREGATES,
        };
        let (mut transfers, mut all_axes) = (Vec::new(), Vec::new());
        while let Some(Coarsened { layout: next, weights, axes }) =
            Some(&layout).filter(|layout| layout.len() > MAX_COARSEST).and_then(Layout::coarsen)
        {
            transfers.push((weights, next.len()));
            all_axes.push(axes);
            layout = next;
        }
        Self::of(matrix, &transfers, weights_of_levels.finest, &weights_of_levels.of(&all_axes))
    }

    /// Builds the levels from the prolongation and the number of nodes of each coarse level, and the weights of block Jacobi.
    fn of(matrix: &Matrix, transfers: &[(Weights, usize)], finest: f64, weights_of_levels: &[f64]) -> Self {
        let (mut levels, mut finer) = (Vec::with_capacity(transfers.len()), None);
        for ((weights, coarse), weight) in transfers.iter().zip(weights_of_levels) {
            let (level, pattern) = Level::new(finer.as_ref().unwrap_or(matrix), *coarse, weights, *weight);
            levels.push(level);
            finer = Some(pattern);
        }
        let transfer = match StructuredTransfer::new(transfers, weights_of_levels) {
            Some(structured) => TransferOperator::Structured(structured),
            None => TransferOperator::Csr(CsrTransfer::new(transfers)),
        };
        Self { parts: parts(&levels), levels, finest, transfer }
    }

    /// Memory of all levels, bytes.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level| {
            level.galerkin.bytes() + level.diagonal.len() * 4 + level.values.len() * size_of::<SingleBlock>()
        };
        let transfer = match &self.transfer {
            TransferOperator::Structured(transfer) => transfer.bytes(),
            TransferOperator::Csr(transfer) => transfer.bytes(),
        };
        transfer + self.levels.iter().map(of).sum::<usize>()
    }

    /// Slots of the finest level's blocks that a refresh reads.
    pub fn sources(&self, due: Due) -> Range<usize> {
        match due {
            Due::All => 0..self.parts.iter().map(|part| part.sources.end).max().unwrap_or(0),
            Due::Part(part) => self.parts[part].sources.clone(),
        }
    }

    /// Refreshes the parts that are due from the blocks of the finest level.
    pub fn update(&mut self, pool: &Pool, values: &[SingleBlock], due: Due) {
        for at in 0..self.levels.len() {
            let nodes = match due {
                Due::All => 0..self.levels[at].diagonal.len(),
                Due::Part(part) => self.parts[part].nodes[at].clone(),
            };
            let (finer, rest) = self.levels.split_at_mut(at);
            rest[0].update(pool, finer.last().map_or(values, |level| &level.values), nodes.clone());
            // Inverses of intermediate levels stay zero.
            for node in if rest[0].weight > 0.0 { nodes } else { 0..0 } {
                let inverse = rest[0].inverse(node);
                match &mut self.transfer {
                    TransferOperator::Structured(transfer) => transfer.put(at, node, &inverse),
                    TransferOperator::Csr(transfer) => transfer.put(at, node, &inverse),
                }
            }
        }
    }

    /// Computes `h = P r`, with the weighted block inverses `inverse` of the finest level; vectors are in groups of sixteen nodes. Returns `r . h`. `r`
    /// must be zero in constrained directions.
    pub fn apply(&mut self, pool: &Pool, inverse: &[f32], r: &[Vectors], h: &mut [Vectors]) -> f64 {
        match &mut self.transfer {
            TransferOperator::Structured(transfer) => transfer.apply(pool, inverse, r, h),
            TransferOperator::Csr(transfer) => transfer.apply(pool, inverse, r, h),
        }
    }

    /// Weight of block Jacobi on the finest level.
    pub fn finest_weight(&self) -> f64 {
        if self.levels.is_empty() { 1.0 } else { self.finest }
    }
}

/// Divides the levels into parts with about equal cost of a refresh.
fn parts(levels: &[Level]) -> Vec<Part> {
    let mut total = 0;
    let mut ends: Vec<Vec<usize>> = Vec::with_capacity(levels.len());
    for level in levels {
        let terms = |node: usize| total + level.galerkin.terms_before(level.block(node));
        ends.push((0..=level.diagonal.len()).map(terms).collect());
        total = terms(level.diagonal.len());
    }
    let part = |part: usize| {
        let cut =
            |ends: &[usize], part: usize| ends.partition_point(|end| end * PARTS < part * total).min(ends.len() - 1);
        let nodes: Vec<_> = ends.iter().map(|ends| cut(ends, part)..cut(ends, part + 1)).collect();
        let sources = levels
            .first()
            .zip(nodes.first())
            .map_or(0..0, |(level, nodes)| level.galerkin.sources(level.block(nodes.start)..level.block(nodes.end)));
        Part { nodes, sources }
    };
    (0..PARTS).map(part).collect()
}

impl Level {
    /// A level of `coarse` nodes, and the pattern of its matrix.
    fn new(fine: &Matrix, coarse: usize, weights: &Weights, weight: f64) -> (Self, Matrix) {
        let (galerkin, pattern) = Galerkin::new(fine, coarse, weights);
        let diagonal = (0..coarse).map(|a| pattern.diagonal_slot(a) as u32).collect();
        (Self { galerkin, weight, diagonal, values: vec![[0.0; 9]; pattern.blocks() + 1] }, pattern)
    }

    /// Slot of the first block of a coarse node.
    fn block(&self, node: usize) -> usize {
        self.diagonal.get(node).map_or(self.values.len() - 1, |slot| *slot as usize)
    }

    fn update(&mut self, pool: &Pool, fine: &[SingleBlock], nodes: Range<usize>) {
        let blocks = self.block(nodes.start)..self.block(nodes.end);
        self.galerkin.update(pool, fine, blocks.start, &mut self.values[blocks]);
    }

    /// Inverse of the diagonal block of a coarse node, times the level's weight.
    fn inverse(&self, node: usize) -> Block {
        // A zero block (no free node) or one that is singular up to rounding contributes nothing.
        let block = self.values[self.diagonal[node] as usize].map(f64::from);
        let least = |b: &Block| b[0].min(b[4]).min(b[8]);
        let sound = |m: &Block| least(&block).min(least(m)) > 0.0 && condition(&block, m) <= MAX_BLOCK_CONDITION;
        symmetric_inverse(&block).filter(sound).map_or([0.0; 9], |m| m.map(|c| self.weight * c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::LANES;
    use crate::lanes::{by_sixteen, one_by_one};

    // Large enough for several chunks in every loop.
    const N: usize = 9000;
    const FEWER: [usize; 2] = [4500, 2250];

    fn wave(i: usize) -> f32 {
        (1.7 * i as f32).sin()
    }

    /// Weights of a regular or an irregular mesh.
    fn weights(is_regular: bool, n: usize, coarse: usize) -> Weights {
        let mut weights = Weights { start: vec![0], ..Weights::default() };
        for i in 0..n {
            let first = if is_regular { i * (coarse - 1) / n } else { i * 7919 % (coarse - 1) };
            weights.coarse.extend([first as u32, first as u32 + 1]);
            weights.weight.extend([0.25, 0.75]);
            weights.start.push(2 * (i + 1) as u32);
        }
        weights
    }

    /// A matrix and its values.
    fn matrix() -> (Matrix, Vec<SingleBlock>) {
        let mut matrix = Matrix::default();
        matrix.set_pattern(N, |pair| {
            (0..N as u32 - 7).for_each(|i| [1, 2, 7].into_iter().for_each(|k| pair(i, i + k)));
        });
        let mut values: Vec<SingleBlock> =
            (0..=matrix.blocks()).map(|slot| std::array::from_fn(|e| 0.1 * wave(9 * slot + e))).collect();
        for i in 0..N {
            let b = values[matrix.diagonal_slot(i)];
            values[matrix.diagonal_slot(i)] = [4.0 + b[0], b[1], b[2], b[1], 5.0 + b[4], b[5], b[2], b[5], 6.0 + b[8]];
        }
        (matrix, values)
    }

    /// A preconditioner with two coarse levels for the matrix of these tests, and the values of the matrix.
    fn levels(is_regular: bool) -> (Multilevel, Vec<SingleBlock>) {
        let (matrix, values) = matrix();
        let [some, few] = FEWER;
        let transfers = [(weights(is_regular, N, some), some), (weights(is_regular, some, few), few)];
        (Multilevel::of(&matrix, &transfers, 0.5, &[0.25; 2]), values)
    }

    /// `P r`, and `r . P r`.
    fn applied(levels: &mut Multilevel, threads: usize, r: &[[f32; 3]]) -> (Vec<[f32; 3]>, f64) {
        let (r, inverse) = (by_sixteen(r), vec![0.25; 6 * N.next_multiple_of(LANES)]);
        let mut h = r.clone();
        let dot = levels.apply(&Pool::new(threads), &inverse, &r, &mut h);
        (one_by_one(&h), dot)
    }

    #[test]
    fn part_by_part_everything_is_made_of_what_it_needs() {
        for is_regular in [true, false] {
            let ((mut whole, values), mut parts) = (levels(is_regular), levels(is_regular).0);
            assert_eq!(matches!(whole.transfer, TransferOperator::Structured(_)), is_regular);
            let pool = Pool::new(1);
            whole.update(&pool, &values[..], Due::All);
            for part in 0..PARTS {
                let sources = parts.sources(Due::Part(part));
                let mut known = vec![[f32::NAN; 9]; values.len()];
                known[sources.clone()].copy_from_slice(&values[sources]);
                parts.update(&pool, &known, Due::Part(part));
            }
            let r: Vec<[f32; 3]> = (0..N).map(|i| [wave(i), wave(3 * i), wave(5 * i)]).collect();
            let (first, second) = (applied(&mut whole, 1, &r), applied(&mut parts, 3, &r));
            assert!(first == second && first.1 > 0.0, "{}, {}", first.1, second.1);
        }
    }

    #[test]
    fn of_two_levels_that_are_coarser_one_way_each_the_second_one_has_the_share() {
        use CoarsenedAxes::{Across, Along, Both};
        let weights_of_levels = LevelWeights { finest: 0.5, first: 1.0, ratio: 0.5 };
        let of_each = [(Across, 0.0), (Along, 1.0), (Across, 0.0), (Along, 0.5), (Along, 0.25), (Across, 0.125)];
        assert_eq!(weights_of_levels.of(&of_each.map(|each| each.0)), of_each.map(|each| each.1));
        assert_eq!(weights_of_levels.of(&[Both, Both]), [1.0, 0.5]);
    }

    #[test]
    fn a_level_that_only_leads_to_another_is_as_one_step_with_the_weights_of_both() {
        let (matrix, values) = matrix();
        let r: Vec<[f32; 3]> = (0..N).map(|i| [wave(i), wave(3 * i), wave(5 * i)]).collect();
        for is_regular in [true, false] {
            let [some, few] = FEWER;
            let two = [weights(is_regular, N, some), weights(is_regular, some, few)];
            let mut one = Weights { start: vec![0], ..Weights::default() };
            for i in 0..N {
                let mut sums = std::collections::BTreeMap::new();
                for (a, first) in two[0].of(i) {
                    two[1].of(a as usize).for_each(|(b, second)| *sums.entry(b).or_insert(0.0) += first * second);
                }
                one.coarse.extend(sums.keys());
                one.weight.extend(sums.values());
                one.start.push(one.coarse.len() as u32);
            }
            let [first, second] = two;
            let mut halves = Multilevel::of(&matrix, &[(first, some), (second, few)], 0.5, &[0.0, 0.25]);
            let mut whole = Multilevel::of(&matrix, &[(one, few)], 0.5, &[0.25]);
            assert_eq!(matches!(halves.transfer, TransferOperator::Structured(_)), is_regular);
            for levels in [&mut halves, &mut whole] {
                levels.update(&Pool::new(1), &values, Due::All);
            }
            // Previous contents must be overwritten.
            applied(&mut halves, 1, &r);
            let serial = applied(&mut halves, 1, &r);
            let (halves, whole) = (applied(&mut halves, 4, &r), applied(&mut whole, 1, &r));
            assert!(halves == serial);
            let close = |a: &f32, b: &f32| (a - b).abs() < 1e-5 * (1.0 + b.abs());
            assert!(halves.0.iter().flatten().zip(whole.0.iter().flatten()).all(|(a, b)| close(a, b)));
            assert!((halves.1 - whole.1).abs() < 1e-5 * whole.1);
        }
    }

    #[test]
    fn both_ways_are_symmetric_and_the_same_sum() {
        let r: Vec<[f32; 3]> = (0..N).map(|i| [wave(i), wave(3 * i), wave(5 * i)]).collect();
        let s: Vec<[f32; 3]> = (0..N).map(|i| [wave(7 * i), wave(2 * i), 1.0]).collect();
        let dot = |a: &[[f32; 3]], b: &[[f32; 3]]| -> f64 {
            a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
        };
        for is_regular in [true, false] {
            let (mut levels, values) = levels(is_regular);
            levels.update(&Pool::new(1), &values, Due::All);
            let (of_r, of_s) = (applied(&mut levels, 1, &r), applied(&mut levels, 1, &s));
            let (one, other) = (dot(&of_r.0, &s), dot(&r, &of_s.0));
            assert!((one - other).abs() < 1e-4 * (of_r.1 * of_s.1).sqrt(), "{one} {other}");
            assert!((dot(&of_r.0, &r) - of_r.1).abs() < 1e-5 * of_r.1);
        }
    }
}
