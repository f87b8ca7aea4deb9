//! Bytes of the vector units, and definiteness of the matrix.

use crate::FibreReinforced;
use pliant_plugin_api::kit::{self, Body, Random};
use pliant_plugin_api::lanes::units;
use pliant_plugin_api::{TangentScale, abi};

const BOTH: TangentScale = TangentScale { stiffness: 0.7, damping: 0.3 };

/// A random unit vector, or none.
fn direction(random: &mut Random) -> [f64; 3] {
    let v = random.vector();
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length < 0.5 { [0.0; 3] } else { v.map(|c| c / length) }
}

/// A distorted block with a direction in each element, and elements without fibres.
fn block(material: &FibreReinforced, stretch: f64) -> Body {
    let block = kit::block([3, 3, 2], 0.01, abi::STRUCTURAL);
    let mut body = Body::new(material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
    let mut random = Random(2);
    body.set_directions(material, |_| direction(&mut random)).unwrap();
    for (x, v) in body.x.iter_mut().zip(&mut body.v) {
        *x = x.map(|c| stretch * c + 4e-3 * random.signed());
        *v = random.vector();
    }
    body
}

#[test]
fn every_vector_unit_gives_the_same_bytes() {
    let mut material: FibreReinforced = kit::material(&[]).unwrap();
    let body = block(&material, 1.2);
    let mut results = Vec::new();
    for arch in units() {
        material.arch = arch;
        let forces = body.forces(&material).unwrap().into_iter().flatten();
        let single = body.single_blocks(&material, BOTH, usize::MAX).unwrap();
        let single = single.into_iter().flatten().flatten().map(f64::from);
        let all = forces.chain(body.tangent(&material, BOTH).unwrap()).chain(single);
        results.push(all.map(f64::to_bits).collect::<Vec<_>>());
    }
    assert!(results[0].iter().all(|bits| f64::from_bits(*bits).is_finite()));
    for result in &results[1..] {
        assert_eq!(results[0].iter().zip(result).position(|(a, b)| a != b), None);
    }
}

#[test]
fn the_projected_matrix_is_positive_semi_definite_in_any_state() {
    let material: FibreReinforced = kit::material(&[("fibre-stiffness", 1e5)]).unwrap();
    let mut random = Random(4);
    for stretch in [-0.8, 0.3, 1.0, 2.5] {
        let body = block(&material, stretch);
        let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 0.0 }).unwrap();
        let n = 3 * body.x.len();
        let largest = k.iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
        for _ in 0..100 {
            let u: Vec<f64> = (0..n).map(|_| random.signed()).collect();
            let work: f64 = (0..n).map(|i| u[i] * (0..n).map(|j| k[i * n + j] * u[j]).sum::<f64>()).sum();
            assert!(work > -1e-9 * largest, "stretch {stretch}: {work}");
        }
    }
}
