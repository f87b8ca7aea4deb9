//! Forces of springs, eight at a time.
//!
//! A grid lists its links so that runs of them have consecutive first nodes and consecutive second nodes. Eight springs of a run form a
//! block: the vectors of their ends are 24 consecutive doubles, loaded and stored without gathering. A block at the end of a shorter
//! run is computed whole, with zero force in the lanes past the run, if those lanes stay within the nodes of the call. All other springs
//! are computed one by one. Every path does the same operations in the same order on each spring and uses no fused multiply-add,
//! so the bytes do not depend on the vector unit found at run time.

use crate::gather::Energy;
use crate::stiffness::Stiffness;
use crate::volume::{self, Tetrahedra};
use pliant_plugin_api::lanes::{Interleaved, Real, Vec3, Wide, vector_unit};
use pliant_plugin_api::{BlockScalar, Blocks, Elements, NodeVectors, NodeWindow, TangentScale, prefetch};
use pulp::{Simd, WithSimd};

/// Springs in a block.
pub const LANES: usize = 8;
/// Fewest springs that are computed as a block.
const MIN_BLOCK: usize = 3;
/// Springs ahead of the current one whose ends, rest lengths and stiffnesses are prefetched: two pages (8 KiB) of f64.
const AHEAD: usize = 1024;
/// Springs ahead of the current one whose second nodes are prefetched: about a row of a grid. First nodes were second nodes of earlier
/// springs, so they are in the cache.
const NODES_AHEAD: usize = 64;
/// A spring shorter than this share of its rest length has no direction, and its force is zero.
pub const MIN_LENGTH_RATIO: f64 = 1e-9;

/// Vectors of the eight springs of a block.
type BlockVectors = [[f64; 3]; LANES];

/// State of a spring, as input of the force law.
#[derive(Clone, Copy)]
struct SpringState<T> {
    /// Squared length, m^2.
    l2: T,
    /// Scalar product of the spring's vector and the relative velocity of its ends, m^2/s.
    d_dot_w: T,
    /// Rest length, m.
    l0: T,
    /// Stiffness of the spring, N/m.
    k: T,
}

/// The force over the spring's vector, N/m: `k ((l - l0) l + tau d.w) / l^2`. In this form the square root and the division do not
/// depend on each other, and the force at rest is exactly zero.
#[inline(always)]
fn force_factor<const DAMPED: bool, T: Real>(spring: SpringState<T>, damping_time: f64) -> T {
    let SpringState { l2, d_dot_w, l0, k } = spring;
    let l = l2.sqrt();
    let elastic = (l - l0) * l;
    let total = if DAMPED { elastic + d_dot_w * damping_time } else { elastic };
    let min_length = l0 * MIN_LENGTH_RATIO;
    l2.if_less(min_length * min_length, l2.splat(0.0), k / l2 * total)
}

/// Runs the loops over the elements of a call on a vector unit.
pub struct Kernel {
    /// The vector unit.
    arch: pulp::Arch,
}

/// The springs of a call.
#[derive(Clone, Copy)]
pub struct Springs<'a> {
    /// Nodes of each spring.
    pub ends: &'a [[u32; 2]],
    /// Positions of all nodes, m.
    pub x: &'a [[f64; 3]],
    /// Velocities of all nodes, m/s.
    v: &'a [[f64; 3]],
    /// Rest length of each spring, m.
    pub rest_length: &'a [f64],
    /// Stiffness of each spring, N/m.
    pub stiffness: &'a [f64],
    /// Damping along each spring's axis over its stiffness, s.
    pub damping_time: f64,
}

impl<'a> Springs<'a> {
    /// The springs of a call, with a damping along their axes of `damping_time` (s) times their stiffness.
    pub fn new(elements: &'a Elements<'_>, damping_time: f64) -> Self {
        Self {
            ends: elements.corners(),
            x: elements.x(),
            v: elements.v(),
            rest_length: elements.rest_data(0),
            stiffness: elements.rest_data(1),
            damping_time,
        }
    }

    /// Prefetches what later blocks read. It helps bodies of more than some ten thousand nodes, which do not fit into the cache.
    #[inline(always)]
    fn prefetch<const DAMPED: bool>(&self, e: usize) {
        prefetch(self.ends, e + AHEAD);
        prefetch(self.rest_length, e + AHEAD);
        prefetch(self.stiffness, e + AHEAD);
        let Some(&[_, b]) = self.ends.get(e + NODES_AHEAD) else { return };
        prefetch_block(self.x, b as usize);
        if DAMPED {
            prefetch_block(self.v, b as usize);
        }
    }
}

/// Prefetches the vectors of a block of nodes: three cache lines of eight f64.
#[inline(always)]
fn prefetch_block(vectors: &[[f64; 3]], first: usize) {
    for line in 0..3 {
        prefetch(vectors.as_flattened(), 3 * first + LANES * line);
    }
}

/// A block of springs: springs `first_spring + i` between nodes `a + i` and `b + i`, for i below `len`.
#[derive(Clone, Copy)]
struct Block {
    /// Index of the first spring.
    first_spring: usize,
    /// First node of the first spring.
    a: usize,
    /// Second node of the first spring.
    b: usize,
    /// Number of springs, at most [`LANES`].
    len: usize,
}

impl Kernel {
    /// A kernel for the widest vector unit of the processor.
    pub fn new() -> Self {
        Self { arch: vector_unit() }
    }

    /// Adds the force of each spring, `k ((l - l0) + tau dl/dt)` along its axis, to its ends, N.
    pub fn forces(&self, springs: Springs<'_>, out: &mut NodeVectors<'_>) {
        self.arch.dispatch(ForcePass { springs, window: out.window() });
    }

    /// Adds the stiffness and damping of each spring: see [`Stiffness`].
    pub fn stiffness<T: BlockScalar>(&self, springs: Springs<'_>, scale: TangentScale, out: &mut Blocks<'_, T>) {
        self.arch.dispatch(Stiffness::new(springs, scale, out));
    }

    /// Adds the forces of volumes: see [`volume`].
    pub fn volume_forces(&self, tetrahedra: Tetrahedra<'_>, out: &mut NodeVectors<'_>) {
        self.arch.dispatch(volume::Forces { tetrahedra, out });
    }

    /// Adds `factor` times the stiffness of volumes: see [`volume::Stiffness`].
    pub fn volume_stiffness<T: BlockScalar>(&self, tetrahedra: Tetrahedra<'_>, factor: f64, out: &mut Blocks<'_, T>) {
        self.arch.dispatch(volume::Stiffness { tetrahedra, factor, out });
    }

    /// Sum of `k/2 (l - l0)^2`, J.
    pub fn energy(&self, springs: Springs<'_>) -> f64 {
        self.arch.dispatch(Energy(springs))
    }
}

/// Index of each spring of a block.
const INDEX: [f64; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

impl Springs<'_> {
    /// Forces on the first ends of the springs of a block, N; zero in the lanes past it.
    #[inline(always)]
    fn block_forces<S: Simd, const DAMPED: bool>(&self, simd: S, block: Block) -> BlockVectors {
        let Block { first_spring, a, b, len } = block;
        let mut forces = [[0.0; 3]; LANES];
        for at in (0..LANES).step_by(S::F64_LANES) {
            let (a, b, e) = (a + at, b + at, first_spring + at);
            let d = Interleaved::load(simd, &self.x[b..]) - Interleaved::load(simd, &self.x[a..]);
            let l2 = d.dot(d);
            let d_dot_w = match DAMPED {
                true => d.dot(Interleaved::load(simd, &self.v[b..]) - Interleaved::load(simd, &self.v[a..])),
                false => l2.splat(0.0),
            };
            let (l0, k) = (Wide::load(simd, &self.rest_length[e..]), Wide::load(simd, &self.stiffness[e..]));
            let factor = force_factor::<DAMPED, _>(SpringState { l2, d_dot_w, l0, k }, self.damping_time);
            let factor = Wide::load(simd, &INDEX[at..]).if_less(l2.splat(len as f64), factor, l2.splat(0.0));
            d.scale(factor).store(&mut forces[at..]);
        }
        forces
    }
}

/// The force on the first end of spring `e` between nodes `a` and `b`, N.
#[inline(always)]
fn spring_force<const DAMPED: bool>(s: &Springs<'_>, e: usize, a: usize, b: usize) -> Vec3 {
    let d = Vec3(s.x[b]) - Vec3(s.x[a]);
    let w = Vec3(s.v[b]) - Vec3(s.v[a]);
    let spring = SpringState { l2: d.dot(d), d_dot_w: d.dot(w), l0: s.rest_length[e], k: s.stiffness[e] };
    d * force_factor::<DAMPED, _>(spring, s.damping_time)
}

/// Adds the forces of all springs of a call.
struct ForcePass<'a> {
    springs: Springs<'a>,
    window: NodeWindow<'a>,
}

impl WithSimd for ForcePass<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if self.springs.damping_time > 0.0 { self.run::<S, true>(simd) } else { self.run::<S, false>(simd) }
    }
}

impl ForcePass<'_> {
    #[inline(always)]
    fn run<S: Simd, const DAMPED: bool>(self, simd: S) {
        let ForcePass { springs, window: NodeWindow { first_node: first, values: force } } = self;
        let count = springs.ends.len();
        let mut e = 0;
        while e < count {
            let [a, b] = springs.ends[e].map(|node| node as usize);
            let len = run_length(&springs.ends[e..]);
            let fits = a.max(b) + LANES <= first + force.len() && e + LANES <= count;
            if len < MIN_BLOCK || !fits {
                let f = spring_force::<DAMPED>(&springs, e, a, b).0;
                add_scaled(&mut force[a - first], f, 1.0);
                add_scaled(&mut force[b - first], f, -1.0);
                e += 1;
                continue;
            }
            springs.prefetch::<DAMPED>(e);
            let f = springs.block_forces::<S, DAMPED>(simd, Block { first_spring: e, a, b, len });
            // A node may be the second end of one spring of the block and the first end of another. This order gives it both forces in
            // the order of single springs, so that the bytes do not depend on where a call's range begins.
            if a < b {
                add_block(&mut force[b - first..], &f, -1.0);
                add_block(&mut force[a - first..], &f, 1.0);
            } else {
                add_block(&mut force[a - first..], &f, 1.0);
                add_block(&mut force[b - first..], &f, -1.0);
            }
            e += len;
        }
    }
}

/// Number of springs from the first one on that form a block: those whose first nodes and whose second nodes are consecutive.
#[inline(always)]
fn run_length(ends: &[[u32; 2]]) -> usize {
    // Fast path without branches, as most runs fill a block: both ends of a spring are compared as one 64-bit number.
    if let Some(block) = ends.first_chunk::<LANES>() {
        let (pairs, next): ([u64; LANES], u64) = (pulp::cast(*block), pulp::cast([1_u32; 2]));
        let follower = |lane: usize| pairs[0].wrapping_add(next.wrapping_mul(lane as u64));
        if (0..LANES).fold(0, |apart, lane| apart | (pairs[lane] ^ follower(lane))) == 0 {
            return LANES;
        }
    }
    let [a, b] = ends[0];
    let follows = |lane: usize, pair: [u32; 2]| pair == [a + lane as u32, b + lane as u32];
    ends.iter().take(LANES).enumerate().take_while(|(lane, pair)| follows(*lane, **pair)).count()
}

/// `sum += sign f`.
#[inline(always)]
fn add_scaled(sum: &mut [f64; 3], f: [f64; 3], sign: f64) {
    for i in 0..3 {
        sum[i] += sign * f[i];
    }
}

/// `sums += sign f` for the nodes of a block.
#[inline(always)]
fn add_block(sums: &mut [[f64; 3]], f: &BlockVectors, sign: f64) {
    let sums: &mut BlockVectors = sums.first_chunk_mut().expect("the caller checked that the block fits");
    for i in 0..LANES {
        add_scaled(&mut sums[i], f[i], sign);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MassSpring;
    use pliant_plugin_api::lanes::units;
    use pliant_plugin_api::{abi, kit};

    #[test]
    fn every_vector_unit_gives_the_same_bytes() {
        let block = kit::block([11, 4, 3], 0.01, abi::STRUCTURAL | abi::SHEAR);
        for tau in [0.0, 0.01] {
            let mut material: MassSpring = kit::material(&[("damping-time", tau)]).unwrap();
            let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
            for (i, (x, v)) in body.x.iter_mut().zip(&mut body.v).enumerate() {
                // Squeezed to half, so that volumes resist.
                *x = [x[0] + 2e-3 * (i as f64).sin(), 0.5 * x[1] - 1e-3 * (2.0 * i as f64).cos(), x[2]];
                *v = [(i as f64).cos(), 0.5, -(i as f64).sin()];
            }
            body.x[7] = body.x[6]; // a spring without direction
            let mut results = Vec::new();
            for arch in units() {
                material.kernel = Kernel { arch };
                let mut force = vec![[0.0; 3]; body.x.len()];
                body.add_forces(&material, &mut force).unwrap();
                let both = TangentScale { stiffness: 0.7, damping: 0.3 };
                let single = body.single_blocks(&material, both, usize::MAX).unwrap();
                let stiffness = body.tangent(&material, both).unwrap();
                let energy = body.energy(&material).unwrap();
                let summed = body.summed_blocks(&material, both).unwrap();
                let single = single.into_iter().chain(summed.single).flatten().flatten().map(f64::from);
                let stiffness =
                    stiffness.into_iter().chain(summed.double.into_iter().flatten().flatten()).chain(single);
                results.push(
                    force.into_iter().flatten().chain(stiffness).chain([energy]).map(f64::to_bits).collect::<Vec<_>>(),
                );
            }
            assert!(results.iter().all(|result| *result == results[0]));
            assert!(results[0].iter().all(|&bits| f64::from_bits(bits).is_finite()));
            assert!(results[0].iter().any(|&bits| f64::from_bits(bits) != 0.0));
        }
    }

    #[test]
    fn force_at_rest_is_exactly_zero() {
        let mut block = kit::block([11, 4, 3], 0.01, abi::STRUCTURAL | abi::SHEAR | abi::FLEXION);
        for (i, x) in block.rest.iter_mut().enumerate() {
            *x = [0, 1, 2].map(|axis| x[axis] + 2e-3 * ((3 * i + axis) as f64).sin());
        }
        for (tau, arch) in [0.0, 0.01].into_iter().flat_map(|tau| units().into_iter().map(move |arch| (tau, arch))) {
            let mut material: MassSpring = kit::material(&[("damping-time", tau)]).unwrap();
            let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
            material.kernel = Kernel { arch };
            assert!(body.forces(&material).unwrap().as_flattened().iter().all(|f| *f == 0.0));
            body.x[20][1] *= 1.0 + 1e-12;
            assert!(body.forces(&material).unwrap().as_flattened().iter().any(|f| *f != 0.0), "slightly off rest");
        }
    }

    #[test]
    fn a_spring_below_the_minimum_length_has_no_force() {
        let block = kit::block([9, 1, 1], 1.0, abi::STRUCTURAL);
        for (tau, arch) in [0.0, 0.01].into_iter().flat_map(|tau| units().into_iter().map(move |arch| (tau, arch))) {
            let mut material: MassSpring = kit::material(&[("damping-time", tau)]).unwrap();
            let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
            material.kernel = Kernel { arch };
            for (ratio, has_force) in [(0.0, false), (0.9, false), (1.1, true)] {
                // All nodes lie on one line, and neighbours at this distance; node 4 is computed in a block, node 9 by itself.
                let distance = ratio * MIN_LENGTH_RATIO;
                body.x.iter_mut().enumerate().for_each(|(i, x)| *x = [0.0, distance * (i % 2) as f64, 0.0]);
                let force = body.forces(&material).unwrap();
                assert!(force.as_flattened().iter().all(|f| f.is_finite()), "{ratio}");
                assert_eq!(force[4][1] != 0.0, has_force, "{ratio}");
                assert_eq!(force[9][1] != 0.0, has_force, "{ratio}");
            }
        }
    }
}
