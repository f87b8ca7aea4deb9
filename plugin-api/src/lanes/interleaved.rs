//! Vectors one behind the other in registers, as they lie in memory.

#[cfg(target_arch = "x86_64")]
use super::x86;
use super::{MAX_LANES, Vec3, Wide};
use core::ops::Sub;
use pulp::Simd;

/// As many vectors as a register has lanes, their components x y z x y z .. in three registers.
#[derive(Clone, Copy)]
pub struct Interleaved<S: Simd>([Wide<S>; 3]);

impl<S: Simd> Interleaved<S> {
    /// The first vectors of a list.
    ///
    /// # Panics
    /// If there are fewer vectors than lanes.
    #[inline(always)]
    pub fn load(simd: S, vectors: &[[f64; 3]]) -> Self {
        let flat = vectors[..S::F64_LANES].as_flattened();
        let of = |register: usize| Wide::load(simd, &flat[register * S::F64_LANES..]);
        Self([of(0), of(1), of(2)])
    }

    /// Writes the vectors to the beginning of a list.
    ///
    /// # Panics
    /// If the list is shorter than the number of lanes.
    #[inline(always)]
    pub fn store(self, vectors: &mut [[f64; 3]]) {
        let flat = vectors[..S::F64_LANES].as_flattened_mut();
        for register in 0..3 {
            self.0[register].store(&mut flat[register * S::F64_LANES..]);
        }
    }

    /// A register for each component, and a vector in each lane.
    #[inline(always)]
    pub fn components(self) -> Vec3<Wide<S>> {
        let simd = self.0[0].1;
        #[cfg(target_arch = "x86_64")]
        if let Some(components) = x86::components(simd, self.0) {
            return Vec3(components);
        }
        let (mut vectors, mut components) = ([[0.0; 3]; MAX_LANES], [[0.0; MAX_LANES]; 3]);
        self.store(&mut vectors);
        for lane in 0..S::F64_LANES {
            for i in 0..3 {
                components[i][lane] = vectors[lane][i];
            }
        }
        let [x, y, z] = &components;
        Vec3([Wide::load(simd, x), Wide::load(simd, y), Wide::load(simd, z)])
    }

    /// The scalar products of pairs of vectors, each summed in the order x, y, z.
    #[inline(always)]
    pub fn dot(self, other: Self) -> Wide<S> {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        let [x, y, z] = Self([a * d, b * e, c * f]).components().0;
        x + y + z
    }

    /// Each vector times the factor in its lane.
    #[inline(always)]
    pub fn scale(self, factors: Wide<S>) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, thrice(factors));
        Self([a * d, b * e, c * f])
    }
}

impl<S: Simd> Sub for Interleaved<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        Self([a - d, b - e, c - f])
    }
}

/// Each lane three times.
#[inline(always)]
fn thrice<S: Simd>(numbers: Wide<S>) -> [Wide<S>; 3] {
    let simd = numbers.1;
    #[cfg(target_arch = "x86_64")]
    if let Some(thrice) = x86::thrice(simd, numbers) {
        return thrice;
    }
    let (lanes, mut thrice) = (numbers.to_array(), [[0.0; 3]; MAX_LANES]);
    for lane in 0..S::F64_LANES {
        thrice[lane] = [lanes[lane]; 3];
    }
    Interleaved::load(simd, &thrice).0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::units;
    use pulp::WithSimd;

    #[derive(Clone, Copy)]
    struct Interleaves;

    impl WithSimd for Interleaves {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let wave = |i: usize| (1.7 * i as f64).sin();
            let list = |first: usize| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| [0, 1, 2].map(|i| wave(first + 3 * k + i)));
            let (a, b, factors) = (list(0), list(40), [0, 1, 2, 3, 4, 5, 6, 7].map(|k| wave(90 + k)));
            let (wide_a, wide_b) = (Interleaved::load(simd, &a), Interleaved::load(simd, &b));
            let components = wide_a.components().0.map(Wide::to_array);
            let dot = wide_a.dot(wide_b).to_array();
            let mut scaled = [[0.0; 3]; MAX_LANES];
            (wide_a - wide_b).scale(Wide::load(simd, &factors)).store(&mut scaled);
            for lane in 0..S::F64_LANES {
                assert_eq!(components.map(|component| component[lane]), a[lane]);
                assert_eq!(dot[lane], Vec3(a[lane]).dot(Vec3(b[lane])));
                assert_eq!(scaled[lane], [0, 1, 2].map(|i| (a[lane][i] - b[lane][i]) * factors[lane]));
            }
        }
    }

    #[test]
    fn vectors_come_apart_and_are_scaled() {
        units().into_iter().for_each(|unit| unit.dispatch(Interleaves));
    }
}
