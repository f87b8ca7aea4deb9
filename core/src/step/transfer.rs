//! From fine nodes to coarse ones and back.
//!
//! What a fine node takes is listed row by row, as many terms in each of sixteen rows as the longest of them has: lists of one
//! length have no end that a processor could guess wrong.

use super::aggregate::Weights;
use super::single::Quad;
use std::ops::Range;

/// Weights, listed both ways.
#[derive(Debug, Default)]
pub struct Transfer {
    /// Of each coarse node's terms (coarse nodes + 1).
    start: Vec<u32>,
    /// Fine nodes and weights.
    fine: Vec<Term>,
    /// Of each sixteen fine nodes' terms.
    slice: Vec<u32>,
    /// Coarse nodes and weights, by fine node.
    coarse: Vec<Term>,
}

type Term = (u32, f32);

/// Rows with lists of one length.
const ROWS: usize = 16;

impl Transfer {
    /// To `coarse` nodes.
    pub fn new(weights: &Weights, coarse: usize) -> Self {
        let count = weights.start.len() - 1;
        let mut by_coarse: Vec<(u32, u32, f32)> = Vec::with_capacity(weights.coarse.len());
        let mut this = Self { slice: vec![0], ..Self::default() };
        for first in (0..count).step_by(ROWS) {
            let rows = first..count.min(first + ROWS);
            let width = rows.clone().map(|i| weights.of(i).count()).max().unwrap_or(0);
            for i in rows {
                by_coarse.extend(weights.of(i).map(|(a, weight)| (a, i as u32, weight)));
                this.coarse.extend(weights.of(i).chain(std::iter::repeat((0, 0.0))).take(width));
            }
            this.coarse.resize((this.slice[first / ROWS] as usize) + ROWS * width, (0, 0.0));
            this.slice.push(this.coarse.len() as u32);
        }
        by_coarse.sort_unstable_by_key(|t| (t.0, t.1));
        this.start = (0..=coarse as u32).map(|a| by_coarse.partition_point(|t| t.0 < a) as u32).collect();
        this.fine = by_coarse.iter().map(|t| (t.1, t.2)).collect();
        this
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        (self.fine.len() + self.coarse.len()) * size_of::<Term>() + (self.start.len() + self.slice.len()) * 4
    }

    /// What a coarse node gets of `from` fine ones, in two sums that do not wait for each other.
    #[inline(always)]
    pub fn gathered(&self, node: usize, from: &[Quad]) -> Quad {
        let (pairs, last) = self.fine[self.start[node] as usize..self.start[node + 1] as usize].as_chunks::<2>();
        let (mut even, mut odd) = ([0.0; 4], [0.0; 4]);
        for [first, second] in pairs {
            add(&mut even, first, from);
            add(&mut odd, second, from);
        }
        if let [last] = last {
            add(&mut even, last, from);
        }
        for c in 0..4 {
            even[c] += odd[c];
        }
        even
    }

    /// Adds to fine nodes `first` on what they get of `from` coarse ones.
    #[inline(always)]
    pub fn spread(&self, first: usize, from: &[Quad], rows: &mut impl Rows) {
        let (mut at, end) = (first, first + rows.count());
        while at < end {
            let (slice, row) = (at / ROWS, at % ROWS);
            let here = at - first..(at - first + ROWS - row).min(end - first);
            let terms = &self.coarse[self.slice[slice] as usize..self.slice[slice + 1] as usize];
            let width = terms.len() / ROWS;
            let terms = &terms[row * width..];
            at += here.len();
            match width {
                1 => spread::<1>(terms, from, here, rows),
                2 => spread::<2>(terms, from, here, rows),
                3 => spread::<3>(terms, from, here, rows),
                4 => spread::<4>(terms, from, here, rows),
                _ => {
                    for (i, terms) in here.zip(terms.chunks_exact(width)) {
                        let mut sum = rows.own(i);
                        terms.iter().for_each(|term| add(&mut sum, term, from));
                        rows.put(i, sum);
                    }
                }
            }
        }
    }
}

/// Vectors of fine nodes to which something is added.
pub trait Rows {
    /// How many.
    fn count(&self) -> usize;
    /// What one has by itself.
    fn own(&self, i: usize) -> Quad;
    /// Takes what it comes to.
    fn put(&mut self, i: usize, sum: Quad);
}

#[inline(always)]
fn spread<const WIDTH: usize>(terms: &[Term], from: &[Quad], here: Range<usize>, rows: &mut impl Rows) {
    for (i, terms) in here.zip(terms.as_chunks::<WIDTH>().0) {
        let mut sum = rows.own(i);
        for term in terms {
            add(&mut sum, term, from);
        }
        rows.put(i, sum);
    }
}

#[inline(always)]
fn add(to: &mut Quad, &(node, weight): &Term, from: &[Quad]) {
    let from = from[node as usize];
    for c in 0..4 {
        to[c] += weight * from[c];
    }
}
