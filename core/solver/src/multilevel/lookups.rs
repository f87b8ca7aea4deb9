//! Sparse products for sixteen rows at a time by register lookups, where the columns of adjacent rows are close together.
//!
//! The next terms of sixteen sums are among two groups of sixteen vectors, which fit into registers: a shuffle selects them, and nothing is
//! gathered from memory.

use super::graph::Weights;
use crate::lanes::{LANES, LOOKED_UP, Lanes, Vectors};
use std::cmp::Reverse;
use std::collections::HashMap;

/// Number of groups among which the second group of a lookup is searched.
const CANDIDATES: usize = 8;
/// Number of lookups after which the fill is first tested.
const MIN_TESTED: usize = 32;

/// Weights of sums, in groups of sixteen, as lists of lookups.
#[derive(Debug)]
pub struct Lookups {
    /// Index of the first lookup of each group of sums (groups + 1).
    start: Vec<u32>,
    lookups: Vec<Lookup>,
    /// Distinct patterns. A regular mesh has few, which stay in the cache.
    patterns: Vec<Pattern>,
}

/// The next terms of sixteen sums, from two groups of sixteen vectors.
#[derive(Debug)]
struct Lookup {
    from: [u32; 2],
    pattern: u32,
}

/// For each of sixteen sums, an index into the 32 vectors of two groups, and a weight.
#[derive(Debug)]
struct Pattern {
    weight: [f32; LANES],
    place: [u8; LANES],
}

const _: () = assert!(2 * LANES == LOOKED_UP, "places of two sixteens can be looked up");

impl Lookups {
    /// Lookups for these weights; `None` if the fraction of used lanes is below `least`.
    pub fn new(weights: &Weights, least: f64) -> Option<Self> {
        let count = weights.start.len() - 1;
        let (mut this, mut terms) = (Self { start: vec![0], lookups: Vec::new(), patterns: Vec::new() }, 0);
        let mut known = HashMap::new();
        for first in (0..count).step_by(LANES) {
            let mut left: [Vec<(u32, f32)>; LANES] = std::array::from_fn(|lane| weights.of(first + lane).collect());
            terms += left.iter().map(Vec::len).sum::<usize>();
            while let Some(from) = pair(&left) {
                let mut pattern = Pattern { weight: [0.0; LANES], place: [0; LANES] };
                for (lane, terms) in left.iter_mut().enumerate() {
                    if let Some(at) = terms.iter().position(|term| from.contains(&sixteen(term.0))) {
                        let term = terms.remove(at);
                        let half = u32::from(sixteen(term.0) != from[0]) * LANES as u32;
                        pattern.place[lane] = (half + term.0 % LANES as u32) as u8;
                        pattern.weight[lane] = term.1;
                    }
                }
                let found =
                    *known.entry((pattern.place, pattern.weight.map(f32::to_bits))).or_insert(this.patterns.len());
                if found == this.patterns.len() {
                    this.patterns.push(pattern);
                }
                this.lookups.push(Lookup { from, pattern: found as u32 });
            }
            this.start.push(this.lookups.len() as u32);
            // Tested early, so that an irregular mesh is rejected quickly.
            if least * (LANES * this.lookups.len().saturating_sub(MIN_TESTED)) as f64 > terms as f64 {
                return None;
            }
        }
        Some(this)
    }

    /// Memory of the lookups, bytes.
    pub fn bytes(&self) -> usize {
        4 * self.start.len() + size_of_val(&self.lookups[..]) + size_of_val(&self.patterns[..])
    }

    /// Adds the terms of a group of sixteen sums to `sum`.
    #[inline(always)]
    pub fn add<U: Lanes>(&self, unit: U, sixteen: usize, from: &[Vectors], mut sum: [U::V; 3]) -> [U::V; 3] {
        for lookup in &self.lookups[self.start[sixteen] as usize..self.start[sixteen + 1] as usize] {
            let Pattern { weight, place } = &self.patterns[lookup.pattern as usize];
            let (weight, [low, high]) = (unit.load(weight), lookup.from.map(|at| &from[at as usize]));
            for c in 0..3 {
                let found = unit.lookup([unit.load(&low[c]), unit.load(&high[c])], place);
                sum[c] = unit.fma(weight, found, sum[c]);
            }
        }
        sum
    }
}

/// The group of sixteen that a vector is in.
fn sixteen(vector: u32) -> u32 {
    vector / LANES as u32
}

/// Two groups for the next lookup: the first group with a remaining term, and the one that together with it serves the most sums; `None` if no terms
/// remain.
fn pair(left: &[Vec<(u32, f32)>; LANES]) -> Option<[u32; 2]> {
    let of = |from: [u32; 2]| {
        let served = left.iter().filter(|terms| terms.iter().any(|term| from.contains(&sixteen(term.0))));
        served.map(Vec::len).sum::<usize>()
    };
    let mut all: Vec<u32> = left.iter().flatten().map(|term| sixteen(term.0)).collect();
    all.sort_unstable();
    all.dedup();
    let low = *all.first()?;
    // The first one of equals.
    all.truncate(CANDIDATES);
    all.into_iter().map(|high| [low, high]).min_by_key(|pair| Reverse(of(*pair)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Plain, Work, widest};

    /// Sums of one to four terms each, with columns around a diagonal.
    fn weights(n: usize, far: u32) -> Weights {
        let mut weights = Weights { start: vec![0], ..Weights::default() };
        for i in 0..n as u32 {
            let count = 1 + (i * i + i / 4) % 4;
            weights.coarse.extend((0..count).map(|k| i / 3 + 2 * k + far * k.saturating_sub(1)));
            weights.weight.extend((0..count).map(|k| 0.1 + (i * k % 7) as f32));
            weights.start.push(weights.coarse.len() as u32);
        }
        weights
    }

    struct All<'a>(&'a Lookups, &'a [Vectors], usize);

    impl Work for All<'_> {
        type Output = Vec<[f32; 3]>;

        #[inline(always)]
        fn on(self, unit: impl Lanes) -> Vec<[f32; 3]> {
            let own = [1.0, 2.0, 3.0].map(|c| unit.load(&[c; LANES]));
            let sums = (0..self.2.div_ceil(LANES)).map(|at| self.0.add(unit, at, self.1, own).map(|v| unit.store(v)));
            sums.flat_map(|planes| (0..LANES).map(move |l| planes.map(|plane| plane[l]))).take(self.2).collect()
        }
    }

    #[test]
    fn every_vector_unit_computes_the_weighted_sums() {
        for far in [0, 40, 100] {
            let (n, count, weights) = (75, 240, weights(75, far));
            let lookups = Lookups::new(&weights, 0.3).expect("near each other");
            let vector = |i: usize| [i as f32, (1.7 * i as f32).sin(), 0.3];
            let sixteen = |at: usize| [0, 1, 2].map(|c| std::array::from_fn(|lane| vector(LANES * at + lane)[c]));
            let from: Vec<Vectors> = (0..count / LANES).map(sixteen).collect();
            let found = widest(All(&lookups, &from, n));
            assert_eq!(found, All(&lookups, &from, n).on(Plain));
            for (i, found) in found.iter().enumerate() {
                for c in 0..3 {
                    let more: f64 = weights.of(i).map(|(a, w)| f64::from(w * vector(a as usize)[c])).sum();
                    let want = 1.0 + c as f64 + more;
                    assert!((f64::from(found[c]) - want).abs() < 1e-5 * (1.0 + want.abs()), "{i}: {found:?}, {want}");
                }
            }
        }
    }

    #[test]
    fn scattered_columns_are_rejected() {
        let n = 1000_u32;
        let coarse = (0..4 * n).map(|k| k * 7919 % 4001).collect();
        let anywhere = Weights { start: (0..=n).map(|i| 4 * i).collect(), coarse, weight: vec![0.25; 4 * n as usize] };
        assert!(Lookups::new(&anywhere, 0.3).is_none() && Lookups::new(&anywhere, 0.0).is_some());
    }
}
