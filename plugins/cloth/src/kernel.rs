//! Passes over the elements of a call, as many at once as the vector unit takes.
//!
//! Corners are gathered into planes of lanes, the kernels are those of one element ([`pliant_plugin_api::lanes`]), and results are added
//! element by element in their order.

use crate::arc::angle_of;
use crate::dihedral;
use crate::membrane::Membrane;
use crate::single::MAX_SINGLE_LANES;
use crate::small::V3;
use crate::triangle::{self, Triangle};
use crate::turn::{self, Points};
use pliant_plugin_api::lanes::{MAX_LANES, Wide};
use pliant_plugin_api::{BlockWindow, Blocks, Elements, NodeVectors, NodeWindow, SingleBlocks, abi, prefetch};
use pulp::{Simd, WithSimd};

/// Elements ahead that memory is asked for: a page of a plane.
const AHEAD: usize = 512;

/// Asks memory for corners and planes of as many elements as are done at once, so much further on than element `e`.
#[inline(always)]
fn ask_ahead<S: Simd, const K: usize, const P: usize>(nodes: &[[u32; K]], planes: &[&[f64]; P], e: usize) {
    prefetch(nodes, e + AHEAD);
    prefetch(nodes, e + AHEAD + S::F64_LANES - 1);
    for plane in planes {
        prefetch(plane, e + AHEAD);
    }
}

/// The same of where the blocks of `count` triangles go.
#[inline(always)]
fn ask_for_slots(slots: &[[u32; 6]], e: usize, count: usize) {
    for line in 0..(6 * count).div_ceil(16) {
        prefetch(slots.as_flattened(), 6 * (e + AHEAD) + 16 * line);
    }
}

/// What is known of the corners of elements `e ..` of `nodes`, by corner and axis; lanes past the end repeat the last element.
#[inline(always)]
fn gather<S: Simd, const K: usize>(simd: S, nodes: &[[u32; K]], e: usize, of: Points<'_>) -> [V3<Wide<S>>; K] {
    let mut end = [[0; K]; MAX_LANES];
    let elements = match nodes.get(e..e + S::F64_LANES) {
        Some(elements) => elements,
        None => {
            for lane in 0..S::F64_LANES {
                end[lane] = nodes[(e + lane).min(nodes.len() - 1)];
            }
            &end[..S::F64_LANES]
        }
    };
    const { assert!(K <= 4, "corners are written out") };
    let nothing = [Wide(simd.splat_f64s(0.0), simd); 3];
    let mut all = [nothing; K];
    // Written out, for a loop would keep all of it in memory.
    if K > 0 {
        all[0] = of.of(simd, elements, 0);
    }
    if K > 1 {
        all[1] = of.of(simd, elements, 1);
    }
    if K > 2 {
        all[2] = of.of(simd, elements, 2);
    }
    if K > 3 {
        all[3] = of.of(simd, elements, 3);
    }
    all
}

/// Writes values `e ..` of a plane.
#[inline(always)]
fn write<S: Simd>(plane: &mut [f64], e: usize, values: Wide<S>) {
    if e + S::F64_LANES <= plane.len() {
        return values.store(&mut plane[e..]);
    }
    let lanes = values.to_array();
    let rest = &mut plane[e..];
    rest.copy_from_slice(&lanes[..rest.len()]);
}

/// A number that is finite only if all are, which they are if their sum is.
#[inline(always)]
fn sum<S: Simd>(values: Wide<S>) -> f64 {
    values.to_array().iter().sum()
}

#[inline(always)]
fn triangles<S: Simd>(simd: S, planes: &[&[f64]; triangle::STRIDE], e: usize) -> Triangle<Wide<S>> {
    let (b, c) = (
        [Wide::load_clamped(simd, planes[0], e), Wide::load_clamped(simd, planes[1], e)],
        [Wide::load_clamped(simd, planes[2], e), Wide::load_clamped(simd, planes[3], e)],
    );
    Triangle::whole([b, c], Wide::load_clamped(simd, planes[4], e))
}

/// What begins where memory is read at once.
#[repr(align(64))]
struct Lines<T>(T);

/// Adds the forces of triangles. Gives the sum of their stresses, to see whether all is finite.
pub(crate) struct Forces<'a, 'b> {
    pub(crate) membrane: &'a Membrane,
    pub(crate) at: &'a Elements<'a>,
    pub(crate) out: &'a mut NodeVectors<'b>,
}

impl WithSimd for Forces<'_, '_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let NodeWindow { first_node, values } = self.out.window();
        // Implicit steps ask for forces at rest; all nodes of the call are in the window.
        let still = self.at.v()[first_node..first_node + values.len()].as_flattened().iter().all(|v| *v == 0.0);
        if still || self.membrane.damping == 0.0 { self.add::<S, false>(simd) } else { self.add::<S, true>(simd) }
    }
}

impl Forces<'_, '_> {
    #[inline(always)]
    fn add<S: Simd, const VISCOUS: bool>(self, simd: S) -> f64 {
        let Self { membrane, at, out } = self;
        let (x, v, nodes) = (Points::new(at.x()), Points::new(at.v()), at.corners::<3>());
        let planes = core::array::from_fn(|s| at.rest_data(s));
        let mut seen = Wide(simd.splat_f64s(0.0), simd);
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            ask_ahead::<S, 3, { triangle::STRIDE }>(nodes, &planes, e);
            let shape = triangles(simd, &planes, e);
            let f = shape.derivative(gather(simd, nodes, e, x));
            let rate = if VISCOUS { Some(shape.derivative(gather(simd, nodes, e, v))) } else { None };
            let count = S::F64_LANES.min(nodes.len() - e);
            let wide = shape.forces(membrane.stress(&shape, f, rate));
            let mut forces = [[[0.0; MAX_LANES]; 3]; 3];
            for corner in 0..3 {
                for i in 0..3 {
                    forces[corner][i] = wide[corner][i].to_array();
                }
                seen = seen + (wide[corner][0] + wide[corner][1] + wide[corner][2]);
            }
            for lane in 0..count {
                for corner in 0..3 {
                    let planes = &forces[corner];
                    let force = [planes[0][lane], planes[1][lane], planes[2][lane]];
                    out.add(nodes[e + lane][corner], force);
                }
            }
        }
        sum(seen)
    }
}

/// Adds `factors.0` K + `factors.1` C of triangles.
pub(crate) struct Stiffness<'a, 'b> {
    pub(crate) membrane: &'a Membrane,
    pub(crate) at: &'a Elements<'a>,
    pub(crate) factors: (f64, f64),
    pub(crate) out: &'a mut Blocks<'b>,
}

impl WithSimd for Stiffness<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { membrane, at, factors, out } = self;
        let (x, nodes) = (Points::new(at.x()), at.corners::<3>());
        let BlockWindow { slots, first_slot, blocks: targets } = out.window::<6>();
        let (mut rows, mut last) = ([[[0.0; 8]; MAX_LANES]; 6], [[0.0; MAX_LANES]; 6]);
        let planes = core::array::from_fn(|s| at.rest_data(s));
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            ask_ahead::<S, 3, { triangle::STRIDE }>(nodes, &planes, e);
            ask_for_slots(slots, e, S::F64_LANES);
            let shape = triangles(simd, &planes, e);
            let f = shape.derivative(gather(simd, nodes, e, x));
            let count = S::F64_LANES.min(nodes.len() - e);
            let blocks = membrane.linear(&shape, f, factors).blocks(&shape);
            for pair in 0..6 {
                let [[a, b, c], [d, e, f], [g, h, i]] = blocks[pair];
                (rows[pair], last[pair]) = (turn::rows(simd, [a, b, c, d, e, f, g, h]), i.to_array());
            }
            for lane in 0..count {
                let slots = &slots[e + lane];
                for pair in 0..6 {
                    let to = &mut targets[(slots[pair] & !abi::TRANSPOSED) as usize - first_slot];
                    let transposed = slots[pair] & abi::TRANSPOSED != 0;
                    turn::add(simd, to, (&rows[pair][lane], last[pair][lane]), transposed);
                }
            }
        }
    }
}

/// The same in single precision, of two corners alone.
pub(crate) struct SingleStiffness<'a, 'b> {
    pub(crate) membrane: &'a Membrane,
    pub(crate) at: &'a Elements<'a>,
    pub(crate) factors: (f64, f64),
    pub(crate) out: &'a mut SingleBlocks<'b>,
}

/// Pairs of two corners among all.
const BETWEEN: [usize; 3] = [1, 2, 4];

impl WithSimd for SingleStiffness<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { membrane, at, factors, out } = self;
        let (x, nodes) = (Points::new(at.x()), at.corners::<3>());
        let BlockWindow { slots, first_slot, blocks: targets } = out.window::<6>();
        let planes = core::array::from_fn(|s| at.rest_data(s));
        let (mut rows, mut last) = (Lines([[[0.0; 8]; MAX_SINGLE_LANES]; 3]), Lines([[0.0; MAX_SINGLE_LANES]; 3]));
        let (rows, last) = (&mut rows.0, &mut last.0);
        for e in (0..nodes.len()).step_by(S::F32_LANES) {
            ask_ahead::<S, 3, { triangle::STRIDE }>(nodes, &planes, e);
            ask_ahead::<S, 3, { triangle::STRIDE }>(nodes, &planes, e + S::F64_LANES);
            ask_for_slots(slots, e, S::F32_LANES);
            // Differences of places are rounded, not places.
            let (low, high) = (triangles(simd, &planes, e), triangles(simd, &planes, e + S::F64_LANES));
            let (f, g) =
                (low.derivative(gather(simd, nodes, e, x)), high.derivative(gather(simd, nodes, e + S::F64_LANES, x)));
            let mut both = [[turn::rounded(f[0][0], g[0][0]); 3]; 2];
            for k in 0..2 {
                for i in 0..3 {
                    both[k][i] = turn::rounded(f[k][i], g[k][i]);
                }
            }
            let ([_, b, c], [_, p, q]) = (low.gradient, high.gradient);
            let gradients = [
                [turn::rounded(b[0], p[0]), turn::rounded(b[1], p[1])],
                [turn::rounded(c[0], q[0]), turn::rounded(c[1], q[1])],
            ];
            let shape = Triangle::whole(gradients, turn::rounded(low.area, high.area));
            let blocks = membrane.linear(&shape, both, factors).between(&shape);
            for k in 0..3 {
                let [[a, b, c], [d, e, f], [g, h, i]] = blocks[k];
                (rows[k], last[k]) = (turn::single_rows(simd, [a, b, c, d, e, f, g, h]), i.to_array());
            }
            for lane in 0..S::F32_LANES.min(nodes.len() - e) {
                for k in 0..3 {
                    let slot = slots[e + lane][BETWEEN[k]];
                    let to = &mut targets[(slot & !abi::TRANSPOSED) as usize - first_slot];
                    let block = (&rows[k][lane], last[k][lane]);
                    turn::single_add(simd, to, block, slot & abi::TRANSPOSED != 0);
                }
            }
        }
    }
}

/// Hinges whose angles are found together: an angle is a long way from sum to sum, and processors look ahead only so far.
const FOLDS: usize = 64;

/// Writes angles of hinges in the place of those at rest, and their gradients, over their length: 13 planes.
pub(crate) struct Strains<'a> {
    pub(crate) at: &'a Elements<'a>,
    pub(crate) out: [&'a mut [f64]; 13],
}

impl WithSimd for Strains<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { at, out } = self;
        let (x, nodes, angles, lengths) = (Points::new(at.x()), at.corners::<4>(), at.rest_data(0), at.rest_data(1));
        let mut seen = Wide(simd.splat_f64s(0.0), simd);
        let (mut sine, mut cosine) = ([0.0; FOLDS], [0.0; FOLDS]);
        for begin in (0..nodes.len()).step_by(FOLDS) {
            let end = nodes.len().min(begin + FOLDS);
            for e in (begin..end).step_by(S::F64_LANES) {
                ask_ahead::<S, 4, 2>(nodes, &[angles, lengths], e);
                let place = gather(simd, nodes, e, x);
                let l = Wide::load_clamped(simd, lengths, e);
                let ([y, x], gradient) = (dihedral::fold(place), dihedral::gradient(place));
                y.store(&mut sine[e - begin..]);
                x.store(&mut cosine[e - begin..]);
                for corner in 0..4 {
                    for i in 0..3 {
                        write(out[1 + 3 * corner + i], e, l * gradient[corner][i]);
                    }
                }
            }
            for e in (begin..end).step_by(S::F64_LANES) {
                let (y, x) = (Wide::load(simd, &sine[e - begin..]), Wide::load(simd, &cosine[e - begin..]));
                let strain =
                    Wide::load_clamped(simd, lengths, e) * (angle_of(y, x) - Wide::load_clamped(simd, angles, e));
                write(out[0], e, strain);
                seen = seen + strain;
            }
        }
        sum(seen)
    }
}

#[cfg(test)]
mod tests {
    use crate::Cloth;
    use pliant_plugin_api::TangentScale;
    use pliant_plugin_api::kit::{self, Body};

    #[test]
    fn every_vector_unit_gives_the_same_bytes() {
        let sheet = kit::sheet([7, 5], 0.01);
        for (frame, compression) in [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (0.0, 0.2)] {
            let given = [("frame", frame), ("compression", compression), ("damping-time", 1e-2), ("poisson", 0.3)];
            let mut material: Cloth = kit::material(&given).unwrap();
            let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            for (i, (x, v)) in body.x.iter_mut().zip(&mut body.v).enumerate() {
                let i = i as f64;
                *x = [x[0] + 2e-3 * i.sin(), x[1] - 1e-3 * (2.0 * i).cos(), 3e-3 * (0.7 * i).sin()];
                *v = [i.cos(), 0.5, -i.sin()];
            }
            body.x[9] = body.x[8]; // triangles that have collapsed
            body.x[1] = body.x[0];
            body.x[2] = body.x[0];
            let mut results = Vec::new();
            let mut units = vec![pulp::Arch::Scalar, pulp::Arch::new()];
            #[cfg(target_arch = "x86_64")]
            units.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
            for arch in units {
                material.1 = arch;
                let tangent = body.tangent(&material, TangentScale { stiffness: 0.7, damping: 0.3 }).unwrap();
                let single =
                    body.single_blocks(&material, TangentScale { stiffness: 0.7, damping: 0.3 }, usize::MAX).unwrap();
                let single = single.iter().flatten().flatten().map(|v| f64::from(*v));
                let strains = body.strains(&material).unwrap().values;
                let forces = body.forces(&material).unwrap().into_iter().flatten();
                results.push(forces.chain(tangent).chain(strains).chain(single).map(f64::to_bits).collect::<Vec<_>>());
            }
            for result in &results[1..] {
                let first = results[0].iter().zip(result).position(|(a, b)| a != b);
                assert_eq!(first, None, "frame {frame}, compression {compression}");
            }
            assert!(results[0].iter().all(|&bits| f64::from_bits(bits).is_finite()));
        }
    }
    #[test]
    fn without_speed_forces_are_those_without_viscosity() {
        let sheet = kit::sheet([7, 5], 0.01);
        let bits = |forces: Vec<[f64; 3]>| forces.into_iter().map(|f| f.map(f64::to_bits)).collect::<Vec<_>>();
        let material = |time| kit::material::<Cloth>(&[("damping-time", time)]).unwrap();
        let mut body = Body::new(&material(1e-2), sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
        for (i, x) in body.x.iter_mut().enumerate() {
            *x = [x[0] + 1e-3 * (i as f64).sin(), x[1], 2e-3 * (0.7 * i as f64).cos()];
        }
        let still = bits(body.forces(&material(1e-2)).unwrap());
        let last = body.v.len() - 1;
        body.v[last] = [1.0, 2.0, 3.0];
        assert_eq!(still, bits(body.forces(&material(0.0)).unwrap()));
        let moving = bits(body.forces(&material(1e-2)).unwrap());
        assert_eq!(still[..20], moving[..20], "far from the node that moves");
        assert_ne!(still[last], moving[last]);
    }
}
