//! Forces of many springs at a time.
//!
//! A grid lists its links so that runs of them have consecutive first and consecutive second nodes. Eight springs of a run
//! are one block: their ends are 24 doubles in a row, loaded and stored without gathering. A block whose run is shorter
//! than eight is computed whole and the lanes past its end are given no force, if they stay within the nodes of the call;
//! the rest goes spring by spring. Every path does the same operations in the same order on each spring, and no fused
//! multiply-add, so the bytes do not depend on the vector unit found at run time.
//!
//! The block is written out for AVX-512, where a spring takes less than 1.5 ns, and for AVX2; left to the compiler's own vectors the same
//! loop was found to come out four times slower after harmless edits.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

use crate::gather::Energy;
use crate::stiffness::Stiffness;
use pliant_plugin_api::{BlockScalar, Blocks, Elements, NodeVectors, NodeWindow, TangentScale, prefetch};

/// Springs in a block.
pub const LANES: usize = 8;
/// Springs ahead whose lists memory is asked for, two pages of each.
const AHEAD: usize = 1024;
/// And springs ahead whose second ends it is asked for, a row of a grid or so: the first ends of a grid have been second ones before.
const NEXT: usize = 64;
/// A spring shorter than this share of its rest length has no direction, and no force.
pub const NO_DIRECTION: f64 = 1e-9;

/// Eight vectors, one to a lane.
type Vectors = [[f64; 3]; LANES];

/// m, between two points.
#[inline(always)]
pub fn length(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

/// The force over the spring's vector, N/m: `k ((l - l0) l + tau d.w) / l^2`, whose root and division do not wait for each other. Nothing
/// at rest, to the last digit.
#[inline(always)]
fn law<const DAMPED: bool>(l2: f64, rate: f64, l0: f64, k: f64, damping_time: f64) -> f64 {
    let l = l2.sqrt();
    let stretched = (l - l0) * l;
    let ahead = if DAMPED { stretched + damping_time * rate } else { stretched };
    let shortest = NO_DIRECTION * l0;
    if l2 < shortest * shortest { 0.0 } else { k / l2 * ahead }
}

/// The widest vector unit of this machine.
pub struct Kernel {
    arch: pulp::Arch,
}

/// What a call reads, sliced once.
#[derive(Clone, Copy)]
pub struct Springs<'a> {
    pub ends: &'a [[u32; 2]],
    pub x: &'a [[f64; 3]],
    v: &'a [[f64; 3]],
    pub length: &'a [f64],
    pub stiffness: &'a [f64],
    /// s
    pub damping_time: f64,
}

impl<'a> Springs<'a> {
    /// Damping along each spring's axis is `damping_time` (s) times its stiffness.
    pub fn new(at: &'a Elements<'_>, damping_time: f64) -> Self {
        let (length, stiffness) = (at.rest_data(0), at.rest_data(1));
        Self { ends: at.corners(), x: at.x(), v: at.v(), length, stiffness, damping_time }
    }

    /// Asks memory for what a block needs later: of a body of more than some ten thousand nodes it is not near when its turn comes.
    #[inline(always)]
    fn ask_ahead<const DAMPED: bool>(&self, e: usize) {
        prefetch(self.ends, e + AHEAD);
        prefetch(self.length, e + AHEAD);
        prefetch(self.stiffness, e + AHEAD);
        let Some(&[_, b]) = self.ends.get(e + NEXT) else { return };
        ask_for_eight(self.x, b as usize);
        if DAMPED {
            ask_for_eight(self.v, b as usize);
        }
    }
}

/// Asks memory for eight vectors.
#[inline(always)]
fn ask_for_eight(of: &[[f64; 3]], from: usize) {
    for row in 0..3 {
        prefetch(of.as_flattened(), 3 * from + LANES * row);
    }
}

/// How a block is computed.
trait Block: Copy {
    /// Forces on the first ends of springs `e .. e + run`, whose ends follow `a` and `b`; zero in the lanes past them.
    fn forces<const DAMPED: bool>(self, s: &Springs<'_>, e: usize, a: usize, b: usize, run: usize) -> Vectors;
}

impl Kernel {
    /// Looks once.
    pub fn new() -> Self {
        Self { arch: pulp::Arch::new() }
    }

    /// Adds the force of each spring, `k ((l - l0) + tau dl/dt)` along its axis, to its ends.
    pub fn forces(&self, springs: Springs<'_>, out: &mut NodeVectors<'_>) {
        let NodeWindow { first_node: first, values: force } = out.window();
        match self.arch {
            #[cfg(target_arch = "x86_64")]
            pulp::Arch::V4(simd) => simd.vectorize(Pass { block: simd, springs, first, force }),
            #[cfg(target_arch = "x86_64")]
            pulp::Arch::V3(simd) => simd.vectorize(Pass { block: simd, springs, first, force }),
            arch => arch.dispatch(Pass { block: Portable, springs, first, force }),
        }
    }

    /// Adds the stiffness of each spring, as [`Stiffness`] has it.
    pub fn stiffness<T: BlockScalar>(&self, springs: Springs<'_>, scale: TangentScale, out: &mut Blocks<'_, T>) {
        self.arch.dispatch(Stiffness::new(springs, scale, out));
    }

    /// J
    pub fn energy(&self, springs: Springs<'_>) -> f64 {
        self.arch.dispatch(Energy(springs))
    }
}

#[derive(Clone, Copy)]
struct Portable;

impl Block for Portable {
    #[inline(always)]
    fn forces<const DAMPED: bool>(self, s: &Springs<'_>, e: usize, a: usize, b: usize, run: usize) -> Vectors {
        std::array::from_fn(|lane| if lane < run { one::<DAMPED>(s, e + lane, a + lane, b + lane) } else { [0.0; 3] })
    }
}

/// The force on the first end of spring `e`, between nodes `a` and `b`.
#[inline(always)]
fn one<const DAMPED: bool>(s: &Springs<'_>, e: usize, a: usize, b: usize) -> [f64; 3] {
    let d: [f64; 3] = std::array::from_fn(|i| s.x[b][i] - s.x[a][i]);
    let w: [f64; 3] = std::array::from_fn(|i| s.v[b][i] - s.v[a][i]);
    let rate = d[0] * w[0] + d[1] * w[1] + d[2] * w[2];
    let l2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let factor = law::<DAMPED>(l2, rate, s.length[e], s.stiffness[e], s.damping_time);
    d.map(|d| factor * d)
}

/// All springs of a call.
struct Pass<'a, B> {
    block: B,
    springs: Springs<'a>,
    /// The node of `force[0]`.
    first: usize,
    force: &'a mut [[f64; 3]],
}

impl<B: Block> pulp::NullaryFnOnce for Pass<'_, B> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        if self.springs.damping_time > 0.0 { self.run::<true>() } else { self.run::<false>() }
    }
}

impl<B: Block> Pass<'_, B> {
    #[inline(always)]
    fn run<const DAMPED: bool>(self) {
        let Pass { block, springs, first, force } = self;
        let count = springs.ends.len();
        let mut e = 0;
        while e < count {
            let [a, b] = springs.ends[e].map(|node| node as usize);
            let run = run_length(&springs.ends[e..]);
            let fits = a.max(b) + LANES <= first + force.len() && e + LANES <= count;
            if run < 3 || !fits {
                let f = one::<DAMPED>(&springs, e, a, b);
                add(&mut force[a - first], f, 1.0);
                add(&mut force[b - first], f, -1.0);
                e += 1;
                continue;
            }
            springs.ask_ahead::<DAMPED>(e);
            let f = block.forces::<DAMPED>(&springs, e, a, b, run);
            // Where a node is the second end of one spring and the first of another, it gets what it would spring by spring, in that
            // order: bytes do not depend on where a call's range begins.
            if a < b {
                add_all(&mut force[b - first..], &f, -1.0);
                add_all(&mut force[a - first..], &f, 1.0);
            } else {
                add_all(&mut force[a - first..], &f, 1.0);
                add_all(&mut force[b - first..], &f, -1.0);
            }
            e += run;
        }
    }
}

/// Springs from the first on whose ends follow each other, at most a block.
#[inline(always)]
fn run_length(ends: &[[u32; 2]]) -> usize {
    // Both ends in one number, and no branch: most runs are as long as a block.
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

#[inline(always)]
fn add(to: &mut [f64; 3], f: [f64; 3], sign: f64) {
    for i in 0..3 {
        to[i] += sign * f[i];
    }
}

#[inline(always)]
fn add_all(to: &mut [[f64; 3]], f: &Vectors, sign: f64) {
    let to: &mut Vectors = to.first_chunk_mut().expect("the caller saw that the block fits");
    for lane in 0..LANES {
        add(&mut to[lane], f[lane], sign);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MassSpring;
    use pliant_plugin_api::{abi, kit};

    fn units() -> Vec<pulp::Arch> {
        let mut units = vec![pulp::Arch::Scalar, pulp::Arch::new()];
        #[cfg(target_arch = "x86_64")]
        units.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
        units
    }

    #[test]
    fn every_vector_unit_gives_the_same_bytes() {
        let block = kit::block([11, 4, 3], 0.01, abi::STRUCTURAL | abi::SHEAR);
        for tau in [0.0, 0.01] {
            let mut material: MassSpring = kit::material(&[("damping-time", tau)]).unwrap();
            let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
            for (i, (x, v)) in body.x.iter_mut().zip(&mut body.v).enumerate() {
                *x = [x[0] + 2e-3 * (i as f64).sin(), x[1] - 1e-3 * (2.0 * i as f64).cos(), x[2]];
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
                let stiffness = stiffness.into_iter().chain(single.into_iter().flatten().flatten().map(f64::from));
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
    fn at_rest_there_is_no_force_to_the_last_digit() {
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
            assert!(body.forces(&material).unwrap().as_flattened().iter().any(|f| *f != 0.0), "a little off it");
        }
    }

    #[test]
    fn a_spring_without_length_has_no_direction_and_one_a_little_longer_has() {
        let block = kit::block([9, 1, 1], 1.0, abi::STRUCTURAL);
        for (tau, arch) in [0.0, 0.01].into_iter().flat_map(|tau| units().into_iter().map(move |arch| (tau, arch))) {
            let mut material: MassSpring = kit::material(&[("damping-time", tau)]).unwrap();
            let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
            material.kernel = Kernel { arch };
            for (apart, pushed) in [(0.0, false), (0.9 * NO_DIRECTION, false), (1.1 * NO_DIRECTION, true)] {
                // All along one line, so that what is across it is what springs in blocks and alone push.
                body.x.iter_mut().enumerate().for_each(|(i, x)| *x = [0.0, apart * (i % 2) as f64, 0.0]);
                let force = body.forces(&material).unwrap();
                assert!(force.as_flattened().iter().all(|f| f.is_finite()), "{apart}");
                assert_eq!(force[4][1] != 0.0, pushed, "{apart}");
                assert_eq!(force[9][1] != 0.0, pushed, "{apart}");
            }
        }
    }
}
