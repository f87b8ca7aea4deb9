//! From a coarse level to the nodes of a regular mesh, sixteen at a time.
//!
//! What sixteen nodes in a row take is within two windows of sixteen coarse nodes each, which registers hold: so a shuffle finds it, and
//! nothing is gathered from memory.

use super::aggregate::Weights;
use super::lanes::{LOOKED_UP, Lanes, load};
use super::lines::Lines;
use super::single::Quad;
use super::sliced::LANES;

/// Terms of a node: those of a mesh with more are not looked up.
const WIDTH: usize = 4;

/// Weights of fine nodes by sixteen, and what they are weights of.
#[derive(Debug)]
pub struct Windows {
    /// First coarse nodes of the two windows of each sixteen.
    start: Vec<[u32; 2]>,
    /// By sixteen and term: places in the windows, and weights.
    place: Lines<u32>,
    weight: Lines<f32>,
    /// Vectors of coarse nodes, by component.
    planes: [Lines<f32>; 3],
}

impl Windows {
    /// To `coarse` nodes; `None` where some nodes take more, or from further away.
    pub fn new(weights: &Weights, coarse: usize) -> Option<Self> {
        let slices = (weights.start.len() - 1).div_ceil(LANES);
        let room = LANES * WIDTH * slices;
        let (mut place, mut weight) = (Lines::new(room), Lines::new(room));
        let (mut start, mut met) = (Vec::with_capacity(slices), Vec::new());
        for slice in 0..slices {
            let rows = LANES * slice..(LANES * (slice + 1)).min(weights.start.len() - 1);
            met.clear();
            met.extend(rows.clone().flat_map(|i| weights.of(i)).map(|(a, _)| a));
            met.sort_unstable();
            let low = *met.first()?;
            let high = met.iter().copied().find(|a| a - low >= LANES as u32).unwrap_or(low);
            for (lane, i) in rows.enumerate() {
                for (term, (a, share)) in weights.of(i).enumerate() {
                    let second = a >= low + LANES as u32;
                    let at = if second { a - high + LANES as u32 } else { a - low };
                    if term == WIDTH || at as usize >= LOOKED_UP {
                        return None;
                    }
                    place.flat_mut()[LANES * (WIDTH * slice + term) + lane] = at;
                    weight.flat_mut()[LANES * (WIDTH * slice + term) + lane] = share;
                }
            }
            start.push([low, high]);
        }
        // Windows may reach past the last.
        let planes = [(); 3].map(|()| Lines::new(coarse.next_multiple_of(LANES) + LANES));
        Some(Self { start, place, weight, planes })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let planes: usize = self.planes.iter().map(Lines::bytes).sum();
        8 * self.start.len() + self.place.bytes() + self.weight.bytes() + planes
    }

    /// Takes over the vectors of the coarse nodes.
    pub fn take(&mut self, unit: impl Lanes, vectors: &[Quad]) {
        let mut put = |at: usize, sixteen: &[Quad; LANES]| {
            let planes = unit.planes(load(unit, sixteen));
            for (to, plane) in self.planes.iter_mut().zip(planes) {
                to.flat_mut()[at..at + LANES].copy_from_slice(&unit.store(plane));
            }
        };
        let (all, rest) = vectors.as_chunks();
        all.iter().enumerate().for_each(|(k, sixteen)| put(LANES * k, sixteen));
        let mut last = [[0.0; 4]; LANES];
        last[..rest.len()].copy_from_slice(rest);
        put(LANES * all.len(), &last);
    }

    /// Adds what a sixteen of fine nodes takes, by component.
    #[inline(always)]
    pub fn add<U: Lanes>(&self, unit: U, slice: usize, mut sum: [U::V; 3]) -> [U::V; 3] {
        let mut tables = [[sum[0]; 2]; 3];
        for (table, plane) in tables.iter_mut().zip(&self.planes) {
            for (half, start) in table.iter_mut().zip(self.start[slice]) {
                *half = unit.load(plane.flat()[start as usize..].first_chunk().expect("windows end before planes do"));
            }
        }
        let terms = LANES * WIDTH * slice..LANES * WIDTH * (slice + 1);
        let places = self.place.flat()[terms.clone()].as_chunks().0;
        for (place, weight) in places.iter().zip(self.weight.flat()[terms].as_chunks().0) {
            let weight = unit.load(weight);
            for c in 0..3 {
                sum[c] = unit.fma(weight, unit.lookup(tables[c], place), sum[c]);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::lanes::{Work, widest};

    /// One to four terms each, of coarse nodes around two places that move on.
    fn weights(n: usize, far: u32) -> Weights {
        let mut weights = Weights { start: vec![0], ..Weights::default() };
        for i in 0..n as u32 {
            let count = 1 + (i * i + i / 4) % 4;
            weights.coarse.extend((0..count).map(|k| i / 3 + 2 * k + if k > 1 { far } else { 0 }));
            weights.weight.extend((0..count).map(|k| 0.1 + (i * k % 7) as f32));
            weights.start.push(weights.coarse.len() as u32);
        }
        weights
    }

    struct All<'a>(&'a mut Windows, &'a [Quad], usize);

    impl Work for All<'_> {
        type Output = Vec<[f32; 3]>;

        #[inline(always)]
        fn on(self, unit: impl Lanes) -> Vec<[f32; 3]> {
            self.0.take(unit, self.1);
            let own = [1.0, 2.0, 3.0].map(|c| unit.load(&[c; LANES]));
            let slices = (0..self.2.div_ceil(LANES)).map(|slice| self.0.add(unit, slice, own).map(|v| unit.store(v)));
            slices.flat_map(|planes| (0..LANES).map(move |l| planes.map(|plane| plane[l]))).take(self.2).collect()
        }
    }

    #[test]
    fn every_vector_unit_adds_what_the_weights_say() {
        let (n, coarse, weights) = (75, 150, weights(75, 100));
        let mut windows = Windows::new(&weights, coarse).expect("two windows");
        let from: Vec<Quad> = (0..coarse).map(|i| [i as f32, (1.7 * i as f32).sin(), 0.3, 0.0]).collect();
        let found = widest(All(&mut windows, &from, n));
        assert_eq!(found, All(&mut windows, &from, n).on(crate::step::lanes::Plain));
        for (i, found) in found.iter().enumerate() {
            for c in 0..3 {
                let more: f64 = weights.of(i).map(|(a, w)| f64::from(w * from[a as usize][c])).sum();
                let want = 1.0 + c as f64 + more;
                assert!((f64::from(found[c]) - want).abs() < 1e-5 * (1.0 + want.abs()), "{i}: {found:?}, {want}");
            }
        }
    }

    #[test]
    fn what_is_too_far_or_too_much_is_left_to_others() {
        assert!(Windows::new(&weights(75, 100), 150).is_some());
        let (mut scattered, mut many) = (weights(75, 100), weights(75, 100));
        // Between both windows.
        scattered.coarse[20] = 60;
        assert!(Windows::new(&scattered, 190).is_none());
        many.start.remove(70);
        assert!(Windows::new(&many, 150).is_none(), "five terms");
    }
}
