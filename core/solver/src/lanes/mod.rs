//! Registers of sixteen numbers in single precision on any vector unit.
//!
//! Operations are on each number by itself, and each is rounded once: a product that is added to something is not rounded before. Blocks (`blocks`) round a
//! product before it is added.
//! Where no unit does that it is done in double precision, so every unit gives the same bytes.

pub mod aligned;
pub mod blocks;
mod entry;
pub mod interleaved;
mod plain;
pub mod symmetric;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use blocks::BlockUnit;
use pliant_plugin_api::lanes::vector_unit;
use pulp::NullaryFnOnce;

pub use entry::Entry;
pub use plain::Plain;

/// Number of lanes: rows or nodes that are processed together.
pub const LANES: usize = 16;
/// Numbers that a lookup selects from.
pub const LOOKED_UP: usize = 32;
/// A vector padded with a zero.
pub type Quad = [f32; 4];
/// Sixteen numbers in memory.
pub type Sixteen = [f32; 16];
/// Sixteen vectors, by component.
pub type Vectors = [Sixteen; 3];

/// Numbers below this are set to zero where values are about 1: processors are a hundred times as slow on denormal ones.
pub const TINY: f32 = 1e-18;

/// Sets a number below [`TINY`] to zero.
#[inline(always)]
pub fn flush_denormals(value: f32) -> f32 {
    if value.abs() < TINY { 0.0 } else { value }
}

/// A vector unit.
pub trait Lanes: Copy {
    /// Sixteen numbers in its registers.
    type V: Copy;
    /// Numbers in double precision, as many as it takes at once.
    type D: Copy;
    /// The unit for blocks in double precision.
    type F64Blocks: BlockUnit<f64>;
    /// The unit for blocks in single precision.
    type F32Blocks: BlockUnit<f32>;
    /// Numbers in [`Lanes::D`]: 16 or a divisor of it.
    const EXACT: usize;
    /// Operations on blocks in double precision.
    fn f64_blocks(self) -> Self::F64Blocks;
    /// Operations on blocks in single precision.
    fn f32_blocks(self) -> Self::F32Blocks;
    /// Loads from memory.
    fn load(self, from: &Sixteen) -> Self::V;
    /// Stores to memory.
    fn store(self, v: Self::V) -> Sixteen;
    /// `a + b`
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a - b`
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a b`
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a b + c`
    fn fma(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// `c - a b`
    fn fnma(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// Gathers four padded vectors.
    fn four(self, vectors: [&Quad; 4]) -> Self::V;
    /// Repeats each of four numbers four times.
    fn each_four(self, numbers: &Quad) -> Self::V;
    /// The sum of four vectors, in the order `(0 + 2) + (1 + 3)`.
    fn sum_of_four(self, vectors: Self::V) -> Quad;
    /// Selects sixteen of the numbers of two registers by their places, each below [`LOOKED_UP`].
    fn lookup(self, from: [Self::V; 2], places: &[u8; 16]) -> Self::V;
    /// Sets numbers below [`TINY`] to zero.
    fn flush_denormals(self, v: Self::V) -> Self::V;
    /// The first [`Lanes::EXACT`] numbers of a slice, in double precision.
    fn exact(self, from: &[f32]) -> Self::D;
    /// The first [`Lanes::EXACT`] numbers of a slice in double precision.
    fn load_exact(self, from: &[f64]) -> Self::D;
    /// Stores to the beginning of a slice.
    fn store_exact(self, v: Self::D, to: &mut [f64]);
    /// `a + b`
    fn add_exact(self, a: Self::D, b: Self::D) -> Self::D;
    /// `a - b`
    fn sub_exact(self, a: Self::D, b: Self::D) -> Self::D;
    /// `a b + c` with the product rounded first, as results that are compared by bytes need.
    fn add_product(self, a: Self::D, b: Self::D, c: Self::D) -> Self::D;
    /// `c - a b` with the product rounded first.
    fn take_product(self, a: Self::D, b: Self::D, c: Self::D) -> Self::D;
    /// Numbers in double precision, rounded.
    fn round(self, from: &[f64; 16]) -> Self::V;
    /// Splits sixteen padded vectors into components.
    fn planes(self, vectors: [Self::V; 4]) -> [Self::V; 3];
    /// Interleaves components into sixteen padded vectors.
    fn vectors(self, planes: [Self::V; 3]) -> [Self::V; 4];

    /// The entries of sixteen blocks, times `scale`, a power of two.
    #[inline(always)]
    fn entries<T: Entry>(self, blocks: [&[T; 9]; 16], scale: f64) -> [Self::V; 9] {
        let mut planes = [[0.0; 16]; 9];
        for lane in 0..16 {
            for e in 0..9 {
                planes[e][lane] = blocks[lane][e].rounded(scale);
            }
        }
        let mut all = [self.load(&planes[0]); 9];
        for e in 1..9 {
            all[e] = self.load(&planes[e]);
        }
        all
    }
}

/// Sixteen vectors from memory.
#[inline(always)]
pub fn load<U: Lanes>(unit: U, from: &[Quad; 16]) -> [U::V; 4] {
    let flat = from.as_flattened().as_chunks().0;
    [unit.load(&flat[0]), unit.load(&flat[1]), unit.load(&flat[2]), unit.load(&flat[3])]
}

/// Sixteen vectors to memory.
#[inline(always)]
pub fn store<U: Lanes>(unit: U, to: &mut [Quad; 16], vectors: [U::V; 4]) {
    let flat = to.as_flattened_mut().as_chunks_mut().0;
    for k in 0..4 {
        flat[k] = unit.store(vectors[k]);
    }
}

/// The components of sixteen vectors, from memory.
#[inline(always)]
pub fn three<U: Lanes>(unit: U, from: &Vectors) -> [U::V; 3] {
    [unit.load(&from[0]), unit.load(&from[1]), unit.load(&from[2])]
}

/// Stores components of sixteen vectors to memory.
#[inline(always)]
pub fn put<U: Lanes>(unit: U, [x, y, z]: [U::V; 3]) -> Vectors {
    [unit.store(x), unit.store(y), unit.store(z)]
}

/// Vectors in groups of sixteen, the last one padded with zeros.
#[cfg(test)]
pub fn by_sixteen(vectors: &[[f32; 3]]) -> Vec<Vectors> {
    let sixteen = |all: &[[f32; 3]]| [0, 1, 2].map(|c| std::array::from_fn(|lane| all.get(lane).map_or(0.0, |v| v[c])));
    vectors.chunks(16).map(sixteen).collect()
}

/// The vectors of groups of sixteen, one after the other, with the padding.
#[cfg(test)]
pub fn one_by_one(sixteens: &[Vectors]) -> Vec<[f32; 3]> {
    sixteens.iter().flat_map(|planes| (0..16).map(move |lane| planes.map(|plane| plane[lane]))).collect()
}

/// A loop that is compiled for each vector unit.
pub trait Work {
    /// Result of the loop.
    type Output;
    /// Runs the loop on a vector unit.
    fn on(self, unit: impl Lanes) -> Self::Output;
}

/// Runs `work` on the widest vector unit of the processor.
pub fn widest<W: Work>(work: W) -> W::Output {
    match vector_unit() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(unit) => unit.vectorize(On { work, unit }),
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(unit) => unit.vectorize(On { work, unit }),
        _ => work.on(Plain),
    }
}

/// Registers of 256 bits where the processor has them, for loops over eight numbers in single precision.
pub fn arch_of_256_bits() -> pulp::Arch {
    #[cfg(target_arch = "x86_64")]
    {
        let unit = vector_unit();
        let is_wider = matches!(unit, pulp::Arch::V4(_));
        if is_wider { pulp::x86::V3::try_new().map_or(pulp::Arch::Scalar, pulp::Arch::V3) } else { unit }
    }
    #[cfg(not(target_arch = "x86_64"))]
    pulp::Arch::Scalar
}

/// The vector units a processor may have; tests compare their bytes.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub enum Unit {
    Plain,
    Avx2,
    Widest,
}

#[cfg(test)]
impl Unit {
    pub const ALL: [Self; 3] = [Self::Plain, Self::Avx2, Self::Widest];

    /// Runs `work` on this unit, or on the portable one where the processor does not have it.
    pub fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            Self::Plain => work.on(Plain),
            Self::Avx2 => match arch_of_256_bits() {
                #[cfg(target_arch = "x86_64")]
                pulp::Arch::V3(unit) => unit.vectorize(On { work, unit }),
                _ => work.on(Plain),
            },
            Self::Widest => widest(work),
        }
    }
}

struct On<W, U> {
    work: W,
    unit: U,
}

impl<W: Work, U: Lanes> NullaryFnOnce for On<W, U> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.work.on(self.unit)
    }
}
