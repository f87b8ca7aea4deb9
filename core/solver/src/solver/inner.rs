//! Conjugate gradients in single precision, inside a solve that counts in double.
//!
//! An iteration is bound by what it reads, and single precision halves that. What is solved for is a correction, so its last
//! digits are not those of the solution: [`crate::solver`] finds the residual in double precision and asks again until it is small
//! enough (iterative refinement: Wilkinson 1963). Matrix and residual are scaled by powers of two, so no unit is too small.

use super::held::Held;
use super::inverses::Inverses;
use super::peek::Peek;
use super::residual::BySixteen;
use super::solve::Solve;
use crate::algebra::{Vec3, WIDEST};
use crate::constraint::{Constraint, constrained_inverse};
use crate::elements::ElementSet;
use crate::lanes::aligned::{Lines, Sixteens};
use crate::lanes::symmetric::put_inverse;
use crate::lanes::{LANES, widest};
use crate::matrix::Matrix;
use crate::multilevel::Multilevel;
use crate::multilevel::refresh::Refresh;
use crate::single::{Single, power_of_two};
use crate::threads::Pool;
use std::sync::atomic::{AtomicU64, Ordering};

/// Vectors and matrices of the corrections.
#[derive(Debug, Default)]
pub struct Inner {
    matrix: Single,
    /// Of the blocks of the diagonal, by sixteen nodes: six numbers of each.
    inverse: Lines<f32>,
    levels: Option<Multilevel>,
    refresh: Refresh,
    held: Vec<Held>,
    /// Constraints of nodes that were held in the last solve.
    was: Vec<(usize, Constraint)>,
    /// Of block Jacobi, over the scale of the matrix.
    share: f64,
    /// What `update` gave.
    size: f64,
    /// Of the widest block of the diagonal; 0 before the first.
    width: f64,
    /// Vectors by sixteen.
    r: Lines<f32>,
    h: Lines<f32>,
    /// Of the residual in `r`.
    scale: f64,
}

/// How far the residual of one correction is brought down: single precision has no more to give.
const DEEPEST: f64 = 1e-10;
/// Sixteens of nodes in a piece of a vector for a thread.
const PIECE: usize = 128;

/// Of the tolerance of a solve, the width of blocks up to which the matrix may be rounded: then neighbours that move against each
/// other meet some 1e-3 of the tolerance more or less.
const ROUGH: f64 = 1e10;
/// The same, at most: the least of a block is 1 % off.
const ROUGHEST: f64 = 1e5;

/// Of `r . P r`, what is left of it when it is looked at again.
const LOOK: f64 = 0.1;
/// Times what is enough: with less to do, what is begun is ended sooner than begun anew.
const LATE: f64 = 20.0;

/// Tells whether a correction is to stop.
pub type Watch<'a> = dyn FnMut(&Peek<'_>) -> bool + 'a;

/// What a correction took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Corrected {
    /// Products.
    pub iterations: usize,
    /// Whether a direction of no or negative curvature was met, or a number that is not finite.
    pub broken: bool,
    /// Whether it was told to stop.
    pub stopped: bool,
}

impl Inner {
    /// Room for `n` nodes.
    pub fn resize(&mut self, n: usize) {
        let room = n.next_multiple_of(LANES);
        (self.r, self.h) = (Lines::new(3 * room), Lines::new(3 * room));
        self.inverse = Lines::new(6 * room);
        self.held.clear();
        self.held.reserve(n);
        self.was.clear();
        self.was.reserve(n);
        self.levels = None;
        self.refresh.end();
        self.matrix.forget();
        self.width = 0.0;
    }

    /// Finds the levels, if they are not there since the nodes or elements changed.
    pub fn prepare(&mut self, matrix: &Matrix, sets: &[ElementSet], rest: &[Vec3]) {
        self.levels.get_or_insert_with(|| Multilevel::new(matrix, sets, rest));
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let vectors = 2 * self.r.bytes() + self.inverse.bytes();
        vectors + self.matrix.bytes() + self.levels.as_ref().map_or(0, Multilevel::bytes)
    }

    /// Takes over the values of a matrix.
    pub fn load(&mut self, pool: &Pool, matrix: &Matrix) {
        self.matrix.update(pool, matrix);
    }

    /// Nodes that are not free, as of the last update.
    pub fn held(&self) -> &[Held] {
        &self.held
    }

    /// `out[k] = A x[k]` in double precision.
    pub fn products<const K: usize>(&mut self, pool: &Pool, matrix: &Matrix, x: [&[Vec3]; K], out: [&mut [Vec3]; K]) {
        self.matrix.exact_products(pool, matrix, x, out);
    }

    /// Prepares for solves with the matrix that was loaded. Gives `sum_i x_i . A_ii x_i` of positions, m (n x 3), and whether single precision has room for it.
    pub fn update(&mut self, pool: &Pool, system: &Solve<'_>) -> (f64, bool) {
        let constraints = system.constraints;
        Held::list(constraints, &mut self.held);
        if system.again {
            // Levels that still know other nodes as held do as well.
            let before = |i: usize| match self.was.binary_search_by_key(&i, |(node, _)| *node) {
                Ok(at) => self.was[at].1,
                Err(_) => Constraint::Free,
            };
            let nodes = self.was.iter().map(|(node, _)| *node).chain(self.held.iter().map(Held::node));
            for i in nodes.filter(|i| constraints[*i] != before(*i)) {
                let inverse = constrained_inverse(system.matrix.diagonal(i), &constraints[i]);
                put_inverse(self.inverse.flat_mut(), i, &inverse.map(|c| self.share * c));
            }
        }
        self.was.clear();
        self.was.extend(self.held.iter().map(|held| (held.node(), constraints[held.node()])));
        if system.again {
            return (self.size, self.width <= WIDEST);
        }
        self.share = 1.0 / self.matrix.scale();
        if let Some(levels) = &mut self.levels {
            let due = self.refresh.due(self.matrix.scale());
            self.matrix.without_fixed(pool, system.matrix, constraints, levels.sources(due));
            levels.update(pool, self.matrix.values(), due);
            self.share *= levels.share();
        }
        // Widths are not negative, so they are in the order of their bits.
        let (share, width) = (self.share, AtomicU64::new(0));
        let all = Sixteens(self.inverse.flat_mut().as_chunks_mut().0.as_chunks_mut().0);
        self.size = pool.fold(all, &|first, Sixteens(out)| {
            let (size, widest) = pulp::Arch::new().dispatch(Inverses { system, share, first, out });
            width.fetch_max(widest.to_bits(), Ordering::Relaxed);
            size
        });
        self.width = f64::from_bits(width.into_inner());
        (self.size, self.width <= WIDEST)
    }

    /// Whether rounding the blocks of a matrix as the last one changes less than a solve to a tolerance leaves; of the first one that is
    /// hoped for.
    pub fn bears_rounding(&self, tolerance: f64) -> bool {
        let scale = self.matrix.scale();
        self.width <= (tolerance * ROUGH).min(ROUGHEST) && (scale == 0.0 || (1e-20..1e20).contains(&scale))
    }

    /// What the last solve has to do with the next is not known.
    pub fn forget(&mut self) {
        self.refresh.end();
    }

    /// Tells what the first solve with a matrix took.
    pub fn took(&mut self, iterations: usize) {
        self.refresh.took(iterations);
    }

    /// Takes over a residual, filtered, with the sum of its squares; gives `r . P r`, where P stands for the inverse of A.
    pub fn weigh(&mut self, pool: &Pool, r: &[Vec3], squares: f64) -> f64 {
        let size = squares.sqrt();
        self.scale = if size.is_normal() { power_of_two(size) } else { 1.0 };
        let down = 1.0 / self.scale;
        pool.pieces(self.r.vectors_mut(), PIECE, &|first, to| widest(BySixteen { down, r: &r[LANES * first..], to }));
        self.unit() * self.precondition(pool)
    }

    /// Of `r . P r`, as it is counted here.
    fn unit(&self) -> f64 {
        self.scale * self.scale * self.matrix.scale()
    }

    /// Adds a correction of what was weighed last to `x`, until `r . P r` is `enough`, at most `most` iterations are done,
    /// or `watch`, which is given what was there of `x` and `r . P r` as it comes down, says that it is to stop.
    pub fn correct(
        &mut self,
        pool: &Pool,
        (system, x): (&Solve<'_>, &mut [Vec3]),
        (d, enough): (f64, f64),
        most: usize,
        watch: &mut Watch<'_>,
    ) -> Corrected {
        let (mut d, mut look) = (d / self.unit(), f64::INFINITY);
        let enough = (enough / self.unit()).max(DEEPEST * d);
        self.matrix.start();
        self.matrix.turn(pool, self.h.vectors(), 0.0, 0.0);
        let mut done = Corrected::default();
        while d > enough && done.iterations < most {
            if d < look && d > LATE * enough {
                done.stopped = watch(&Peek::new(system, x, (&self.matrix, self.step()), d * self.unit()));
                look = LOOK * d;
                if done.stopped {
                    break;
                }
            }
            let q = self.matrix.product(pool);
            if !(q > 0.0 && q.is_finite()) {
                done.broken = true;
                break;
            }
            let a = (d / q) as f32;
            let next = self.descend(pool, a);
            self.matrix.turn(pool, self.h.vectors(), a, (next / d) as f32);
            d = next;
            done.iterations += 1;
        }
        let (matrix, step) = (&self.matrix, self.step());
        pool.pieces(x, LANES * PIECE, &|first, x| matrix.add_to(first, step, x));
        done
    }

    /// Of the solution, what a unit of the correction is.
    fn step(&self) -> f64 {
        self.scale * self.matrix.scale()
    }

    /// `r -= a S A p`, `h = P r`; gives `r.h`.
    fn descend(&mut self, pool: &Pool, a: f32) -> f64 {
        let matrix = &self.matrix;
        pool.pieces(self.r.vectors_mut(), PIECE, &|first, r| matrix.take(first, a, r));
        Held::filter(&self.held, self.r.vectors_mut());
        self.precondition(pool)
    }

    /// `h = P r`; gives `r.h`.
    fn precondition(&mut self, pool: &Pool) -> f64 {
        let mut none = Multilevel::default();
        let levels = self.levels.as_mut().unwrap_or(&mut none);
        let sum = levels.apply(pool, self.inverse.flat(), self.r.vectors(), self.h.vectors_mut());
        Held::filter(&self.held, self.h.vectors_mut());
        sum
    }
}
