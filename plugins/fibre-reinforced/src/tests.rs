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
fn block(material: &FibreReinforced) -> Body {
    let block = kit::block([3, 3, 2], 0.01, abi::STRUCTURAL);
    let mut body = Body::new(material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
    let mut random = Random(2);
    body.set_directions(material, |_| direction(&mut random)).unwrap();
    for (x, v) in body.x.iter_mut().zip(&mut body.v) {
        *x = x.map(|c| 1.2 * c + 4e-3 * random.signed());
        *v = random.vector();
    }
    body
}

#[test]
fn every_vector_unit_gives_the_same_bytes() {
    let mut material: FibreReinforced = kit::material(&[]).unwrap();
    let body = block(&material);
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

/// The least eigenvalue of the matrix of an inverted, distorted cell over the largest, with a value of the parameter `tangent`.
fn least_eigenvalue(tangent: f64) -> f64 {
    let material: FibreReinforced = kit::material(&[("tangent", tangent), ("poisson", 0.49)]).unwrap();
    let block = kit::block([1, 1, 1], 0.01, abi::STRUCTURAL);
    let mut body = Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
    let mut random = Random(4);
    body.set_directions(&material, |_| direction(&mut random)).unwrap();
    body.x.iter_mut().for_each(|x| *x = [-1.5 * x[0], 0.4 * x[1] + 0.3 * x[0], 0.9 * x[2]]);
    let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 0.0 }).unwrap();
    let values = nalgebra::DMatrix::from_row_slice(24, 24, &k).symmetric_eigenvalues();
    values.min() / values.max()
}

#[test]
fn the_projected_matrix_is_positive_semi_definite_where_the_exact_one_is_not() {
    let [projected, exact] = [0.0, 1.0].map(least_eigenvalue);
    assert!(projected > -1e-12 && exact < -1e-3, "{projected} {exact}");
}
