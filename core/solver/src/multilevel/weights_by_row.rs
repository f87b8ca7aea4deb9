//! Interpolation weights stored row by row, for restriction and prolongation.
//!
//! The rows of sixteen fine nodes are padded to the longest of them; with equal lengths no loop end is mispredicted.

use super::graph::Weights;
use crate::lanes::{Lanes, Quad};

/// Interpolation weights between a level and the next coarser one, stored in both directions.
#[derive(Debug, Default)]
pub struct WeightsByRow {
    /// Index of the first run of each coarse node (coarse nodes + 1).
    start: Vec<u32>,
    /// Runs of restriction: the first of four consecutive fine nodes, and their weights.
    fine: Vec<(u32, Quad)>,
    /// Index of the first term of each group of sixteen fine nodes.
    slice: Vec<u32>,
    /// Terms of prolongation, by fine node.
    coarse: Vec<Term>,
}

/// A coarse node and its weight.
type Term = (u32, f32);

/// Number of rows that are padded to equal length.
const ROWS: usize = 16;

impl WeightsByRow {
    /// Stores the prolongation from `coarse` nodes.
    pub fn new(weights: &Weights, coarse: usize) -> Self {
        let count = weights.start.len() - 1;
        let mut this = Self { slice: vec![0], start: vec![0], ..Self::default() };
        for first in (0..count).step_by(ROWS) {
            let rows = first..count.min(first + ROWS);
            let width = rows.clone().map(|i| weights.of(i).count()).max().unwrap_or(0);
            for i in rows {
                this.coarse.extend(weights.of(i).chain(std::iter::repeat((0, 0.0))).take(width));
            }
            this.coarse.resize((this.slice[first / ROWS] as usize) + ROWS * width, (0, 0.0));
            this.slice.push(this.coarse.len() as u32);
        }
        // Runs have four nodes, so there must be at least four.
        let last = count as u32 - 4;
        let fine = weights.transposed(coarse);
        for node in 0..coarse {
            let begun = this.fine.len();
            for (at, weight) in fine.of(node) {
                if this.fine[begun..].last().is_none_or(|run| at >= run.0 + 4) {
                    this.fine.push((at.min(last), [0.0; 4]));
                }
                let run = this.fine.last_mut().expect("one at least");
                run.1[(at - run.0) as usize] = weight;
            }
            this.start.push(this.fine.len() as u32);
        }
        this
    }

    /// Memory of the weights, bytes.
    pub fn bytes(&self) -> usize {
        self.fine.len() * size_of::<(u32, Quad)>()
            + self.coarse.len() * size_of::<Term>()
            + (self.start.len() + self.slice.len()) * 4
    }

    /// Restriction of fine vectors to one coarse node, in two independent sums that hide latency.
    #[inline(always)]
    pub fn restricted(&self, unit: impl Lanes, node: usize, from: &[Quad]) -> Quad {
        let (pairs, last) = self.fine[self.start[node] as usize..self.start[node + 1] as usize].as_chunks::<2>();
        let (mut even, mut odd) = (unit.load(&[0.0; 16]), unit.load(&[0.0; 16]));
        for [first, second] in pairs {
            even = unit.fma(unit.each_four(&first.1), four(unit, from, first.0), even);
            odd = unit.fma(unit.each_four(&second.1), four(unit, from, second.0), odd);
        }
        if let [last] = last {
            even = unit.fma(unit.each_four(&last.1), four(unit, from, last.0), even);
        }
        unit.sum_of_four(unit.add(even, odd))
    }

    /// Prolongation: adds the coarse vectors `from` to the fine nodes from `first`.
    #[inline(always)]
    pub fn prolongate(&self, first: usize, from: &[Quad], rows: &mut [Quad]) {
        let (mut at, end) = (first, first + rows.len());
        while at < end {
            let (slice, row) = (at / ROWS, at % ROWS);
            let here = at - first..(at - first + ROWS - row).min(end - first);
            let terms = &self.coarse[self.slice[slice] as usize..self.slice[slice + 1] as usize];
            let width = terms.len() / ROWS;
            let terms = &terms[row * width..];
            at += here.len();
            match width {
                1 => spread::<1>(terms, from, &mut rows[here]),
                2 => spread::<2>(terms, from, &mut rows[here]),
                3 => spread::<3>(terms, from, &mut rows[here]),
                4 => spread::<4>(terms, from, &mut rows[here]),
                _ => {
                    for (row, terms) in rows[here].iter_mut().zip(terms.chunks_exact(width)) {
                        terms.iter().for_each(|term| add(row, term, from));
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn spread<const WIDTH: usize>(terms: &[Term], from: &[Quad], rows: &mut [Quad]) {
    for (row, terms) in rows.iter_mut().zip(terms.as_chunks::<WIDTH>().0) {
        let mut sum = *row;
        for term in terms {
            add(&mut sum, term, from);
        }
        *row = sum;
    }
}

/// Loads four consecutive vectors.
#[inline(always)]
fn four<U: Lanes>(unit: U, from: &[Quad], at: u32) -> U::V {
    unit.load(from[at as usize..].as_flattened().first_chunk().expect("runs end with the last at most"))
}

#[inline(always)]
fn add(to: &mut Quad, &(node, weight): &Term, from: &[Quad]) {
    let from = from[node as usize];
    for c in 0..4 {
        to[c] += weight * from[c];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Plain, Work, widest};

    struct Gather<'a>(&'a WeightsByRow, usize, &'a [Quad]);

    impl Work for Gather<'_> {
        type Output = Quad;

        #[inline(always)]
        fn on(self, unit: impl Lanes) -> Quad {
            self.0.restricted(unit, self.1, self.2)
        }
    }

    #[test]
    fn restriction_and_prolongation_match_the_weights() {
        let (n, coarse) = (75, 11);
        let mut weights = Weights { start: vec![0], ..Weights::default() };
        for i in 0..n {
            // One to seven terms, each slice with a longest of its own.
            let count = 1 + (i * i + i / ROWS) % (2 + 2 * (i / ROWS)).min(7);
            weights.coarse.extend((0..count).map(|k| ((i + k) % coarse) as u32));
            weights.weight.extend((0..count).map(|k| 0.1 + (i * k % 7) as f32));
            weights.start.push(weights.coarse.len() as u32);
        }
        let wave = |i: usize| [(i as f32).sin(), (2.0 * i as f32).cos(), 0.3 * i as f32, 0.0];
        let (fine, rough): (Vec<Quad>, Vec<Quad>) = ((0..n).map(wave).collect(), (50..50 + coarse).map(wave).collect());
        let transfer = WeightsByRow::new(&weights, coarse);
        let close = |a: Quad, b: [f64; 4]| (0..4).all(|c| (f64::from(a[c]) - b[c]).abs() < 1e-3);
        for a in 0..coarse {
            let mut want = [0.0; 4];
            for i in 0..n {
                for (_, weight) in weights.of(i).filter(|(to, _)| *to == a as u32) {
                    (0..4).for_each(|c| want[c] += f64::from(weight * fine[i][c]));
                }
            }
            let [found, plain] = [widest(Gather(&transfer, a, &fine)), Gather(&transfer, a, &fine).on(Plain)];
            assert!(close(found, want) && found == plain, "{a}");
        }
        for first in [0, 5, 16, 37, 74] {
            let mut rows = fine[first..].to_vec();
            transfer.prolongate(first, &rough, &mut rows);
            for (i, got) in (first..n).zip(rows) {
                let mut want = fine[i].map(f64::from);
                for (a, weight) in weights.of(i) {
                    (0..4).for_each(|c| want[c] += f64::from(weight * rough[a as usize][c]));
                }
                assert!(close(got, want), "{first} {i}: {got:?} {want:?}");
            }
        }
    }
}
