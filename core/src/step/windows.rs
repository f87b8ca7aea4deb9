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
