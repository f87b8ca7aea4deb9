//! SIMD kernels over the elements of a call: one element per lane of a vector register.
//!
//! The corners of several elements are gathered into registers, the generic code of one element ([`pliant_plugin_api::lanes`]) runs on
//! all lanes, and results are added element by element in the order of the list. So the bytes do not depend on the vector unit.

mod forces;
mod stiffness;
mod strains;

pub(crate) use forces::Forces;
pub(crate) use stiffness::{SingleStiffness, Stiffness};
pub(crate) use strains::Strains;

use crate::triangle::{self, Triangle};
use pliant_plugin_api::lanes::Wide;
use pliant_plugin_api::prefetch;
use pulp::Simd;

/// Elements ahead of the current one that are prefetched: one page (4 KiB) of a plane of f64.
const AHEAD: usize = 512;

/// Prefetches the corners and planes of the register of elements that begins `AHEAD` elements after `e`.
#[inline(always)]
fn prefetch_elements<S: Simd, const K: usize, const P: usize>(nodes: &[[u32; K]], planes: &[&[f64]; P], e: usize) {
    prefetch(nodes, e + AHEAD);
    prefetch(nodes, e + AHEAD + S::F64_LANES - 1);
    for plane in planes {
        prefetch(plane, e + AHEAD);
    }
}

/// Prefetches the slots of `count` triangles that begin `AHEAD` elements after `e`.
#[inline(always)]
fn prefetch_slots(slots: &[[u32; 6]], e: usize, count: usize) {
    const SLOTS_PER_LINE: usize = 16;
    for line in 0..(6 * count).div_ceil(SLOTS_PER_LINE) {
        prefetch(slots.as_flattened(), 6 * (e + AHEAD) + SLOTS_PER_LINE * line);
    }
}

/// Writes the lanes to elements `e, e + 1, ..` of a plane; lanes past the end are dropped.
#[inline(always)]
fn store_clamped<S: Simd>(plane: &mut [f64], e: usize, values: Wide<S>) {
    if e + S::F64_LANES <= plane.len() {
        return values.store(&mut plane[e..]);
    }
    let lanes = values.to_array();
    let rest = &mut plane[e..];
    rest.copy_from_slice(&lanes[..rest.len()]);
}

/// Sum of the lanes: finite only if every lane is.
#[inline(always)]
fn sum_of_lanes<S: Simd>(values: Wide<S>) -> f64 {
    values.to_array().iter().sum()
}

/// Rest shapes of elements `e, e + 1, ..`
#[inline(always)]
fn load_triangles<S: Simd>(simd: S, planes: &[&[f64]; triangle::STRIDE], e: usize) -> Triangle<Wide<S>> {
    let b = [Wide::load_clamped(simd, planes[0], e), Wide::load_clamped(simd, planes[1], e)];
    let c = [Wide::load_clamped(simd, planes[2], e), Wide::load_clamped(simd, planes[3], e)];
    Triangle::from_gradients([b, c], Wide::load_clamped(simd, planes[4], e))
}

#[cfg(test)]
mod tests {
    use crate::Cloth;
    use pliant_plugin_api::TangentScale;
    use pliant_plugin_api::kit::{self, Body};
    use pliant_plugin_api::lanes::units;

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
            body.x[9] = body.x[8]; // collapsed triangles
            body.x[1] = body.x[0];
            body.x[2] = body.x[0];
            let mut results = Vec::new();
            for arch in units() {
                material.arch = arch;
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
    fn forces_at_zero_velocity_are_those_without_viscosity() {
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
