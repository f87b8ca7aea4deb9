//! From fine nodes to coarse ones and back.
//!
//! What a node takes is listed row by row, as many terms in each of sixteen rows as the longest of them has: lists of one
//! length have no end that a processor could guess wrong.

use super::aggregate::Weights;
use super::lanes::Lanes;
use super::single::Quad;
use std::ops::Range;

/// Weights, listed both ways.
#[derive(Debug, Default)]
pub struct Transfer {
    /// Of each coarse node, fine nodes.
    fine: Lists,
    /// Of each fine node, coarse nodes.
    coarse: Lists,
}

/// Of rows, others and weights.
#[derive(Debug, Default)]
struct Lists {
    /// Of each sixteen rows' terms.
    start: Vec<u32>,
    terms: Vec<Term>,
}

type Term = (u32, f32);

/// Rows with lists of one length.
const ROWS: usize = 16;

impl Lists {
    /// With lengths that are multiples of `step`.
    fn new<'a>(rows: impl Iterator<Item = Vec<Term>> + 'a, step: usize) -> Self {
        let (mut this, rows) = (Self { start: vec![0], ..Self::default() }, rows.collect::<Vec<_>>());
        for slice in rows.chunks(ROWS) {
            let longest = slice.iter().map(Vec::len).max().unwrap_or(0);
            let width = longest.max(1).next_multiple_of(step);
            for row in slice {
                this.terms.extend(row.iter().copied().chain(std::iter::repeat((0, 0.0))).take(width));
            }
            this.terms.resize(this.start[this.start.len() - 1] as usize + ROWS * width, (0, 0.0));
            this.start.push(this.terms.len() as u32);
        }
        this
    }

    fn bytes(&self) -> usize {
        self.terms.len() * size_of::<Term>() + self.start.len() * 4
    }

    /// Rows from one on that have lists of one length, up to an end; these lists and their length.
    #[inline(always)]
    fn alike(&self, from: usize, end: usize) -> (Range<usize>, &[Term], usize) {
        let (slice, row) = (from / ROWS, from % ROWS);
        let terms = &self.terms[self.start[slice] as usize..self.start[slice + 1] as usize];
        let width = terms.len() / ROWS;
        (from..(from + ROWS - row).min(end), &terms[row * width..], width)
    }
}

impl Transfer {
    /// To `coarse` nodes.
    pub fn new(weights: &Weights, coarse: usize) -> Self {
        let count = weights.start.len() - 1;
        let mut fine = vec![Vec::new(); coarse];
        for i in 0..count {
            weights.of(i).for_each(|(a, weight)| fine[a as usize].push((i as u32, weight)));
        }
        let by_fine = (0..count).map(|i| weights.of(i).collect());
        Self { fine: Lists::new(fine.into_iter(), 2), coarse: Lists::new(by_fine, 1) }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.fine.bytes() + self.coarse.bytes()
    }

    /// What coarse nodes `first` on get of `from` fine ones, in two sums that do not wait for each other.
    #[inline(always)]
    pub fn gather<U: Lanes>(&self, unit: U, first: usize, from: &[Quad], out: &mut [Quad]) {
        let (mut at, end) = (first, first + out.len());
        while at < end {
            let (here, terms, width) = self.fine.alike(at, end);
            at = here.end;
            for (node, terms) in here.zip(terms.chunks_exact(width)) {
                let (mut even, mut odd) = ([0.0; 4], [0.0; 4]);
                for [one, other] in terms.as_chunks::<2>().0 {
                    even = add(unit, even, one, from);
                    odd = add(unit, odd, other, from);
                }
                for c in 0..4 {
                    even[c] += odd[c];
                }
                out[node - first] = even;
            }
        }
    }

    /// Adds to fine nodes `first` on what they get of `from` coarse ones.
    #[inline(always)]
    pub fn spread<U: Lanes>(&self, unit: U, first: usize, from: &[Quad], rows: &mut impl Receiver) {
        let (mut at, end) = (first, first + rows.count());
        while at < end {
            let (here, terms, width) = self.coarse.alike(at, end);
            at = here.end;
            let here = here.start - first..here.end - first;
            match width {
                1 => spread::<1, U>(unit, terms, from, here, rows),
                2 => spread::<2, U>(unit, terms, from, here, rows),
                3 => spread::<3, U>(unit, terms, from, here, rows),
                4 => spread::<4, U>(unit, terms, from, here, rows),
                _ => {
                    for (i, terms) in here.zip(terms.chunks_exact(width)) {
                        let mut sum = rows.own(i);
                        for term in terms {
                            sum = add(unit, sum, term, from);
                        }
                        rows.put(i, sum);
                    }
                }
            }
        }
    }
}

/// Vectors of fine nodes to which something is added.
pub trait Receiver {
    /// How many.
    fn count(&self) -> usize;
    /// What one has by itself.
    fn own(&self, i: usize) -> Quad;
    /// Takes what it comes to.
    fn put(&mut self, i: usize, sum: Quad);
}

#[inline(always)]
fn spread<const WIDTH: usize, U: Lanes>(
    unit: U,
    terms: &[Term],
    from: &[Quad],
    here: Range<usize>,
    rows: &mut impl Receiver,
) {
    for (i, terms) in here.zip(terms.as_chunks::<WIDTH>().0) {
        let mut sum = rows.own(i);
        for term in terms {
            sum = add(unit, sum, term, from);
        }
        rows.put(i, sum);
    }
}

#[inline(always)]
fn add<U: Lanes>(unit: U, to: Quad, &(node, weight): &Term, from: &[Quad]) -> Quad {
    unit.vector_fma(weight, from[node as usize], to)
}

#[cfg(test)]
mod tests {
    use super::super::lanes::Plain;
    use super::*;

    struct Sums(Vec<Quad>);

    impl Receiver for Sums {
        fn count(&self) -> usize {
            self.0.len()
        }

        fn own(&self, i: usize) -> Quad {
            self.0[i]
        }

        fn put(&mut self, i: usize, sum: Quad) {
            self.0[i] = sum;
        }
    }

    #[test]
    fn both_ways_are_the_weights_from_any_node_on() {
        let (n, coarse) = (75, 21);
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
        let transfer = Transfer::new(&weights, coarse);
        let close = |a: Quad, b: [f64; 4]| (0..4).all(|c| (f64::from(a[c]) - b[c]).abs() < 1e-3);
        let mut rough_of_fine = vec![[9.0; 4]; coarse];
        let (low, high) = rough_of_fine.split_at_mut(5);
        transfer.gather(Plain, 0, &fine, low);
        transfer.gather(Plain, 5, &fine, high);
        for a in 0..coarse {
            let mut want = [0.0; 4];
            for i in 0..n {
                for (_, weight) in weights.of(i).filter(|(to, _)| *to == a as u32) {
                    (0..4).for_each(|c| want[c] += f64::from(weight * fine[i][c]));
                }
            }
            assert!(close(rough_of_fine[a], want), "{a}");
        }
        for first in [0, 5, 16, 37, 74] {
            let mut rows = Sums(fine[first..].to_vec());
            transfer.spread(Plain, first, &rough, &mut rows);
            for (i, got) in (first..n).zip(rows.0) {
                let mut want = fine[i].map(f64::from);
                for (a, weight) in weights.of(i) {
                    (0..4).for_each(|c| want[c] += f64::from(weight * rough[a as usize][c]));
                }
                assert!(close(got, want), "{first} {i}: {got:?} {want:?}");
            }
        }
    }
}
