//! Homogeneous stretches of a block against the formulas of the law.

use pliant_fibre_reinforced::FibreReinforced;
use pliant_plugin_api::abi;
use pliant_plugin_api::kit::{self, Body, Random};

const YOUNG: f64 = 3e3;
const POISSON: f64 = 0.3;
const K1: f64 = 2e3;
const K2: f64 = 0.8;
/// Edge of a cell, m.
const EDGE: f64 = 0.01;
const CELLS: [u32; 3] = [3, 2, 2];

/// A block of the material whose fibres have one direction, at the deformation gradient `f`.
fn block(fibres: f64, direction: [f64; 3], f: [[f64; 3]; 3]) -> (FibreReinforced, Body) {
    let numbers = [("young", YOUNG), ("poisson", POISSON), ("fibre-stiffness", fibres), ("fibre-stiffening", K2)];
    let material: FibreReinforced = kit::material(&numbers).unwrap();
    let block = kit::block(CELLS, EDGE, abi::STRUCTURAL);
    let mut body = Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
    body.set_directions(&material, |_| direction).unwrap();
    body.x.iter_mut().for_each(|x| *x = [0, 1, 2].map(|i| (0..3).map(|j| f[i][j] * x[j]).sum()));
    (material, body)
}

/// The traction on the face of the block with the greatest x, Pa per area at rest: column x of the first Piola-Kirchhoff stress.
fn traction(fibres: f64, direction: [f64; 3], f: [[f64; 3]; 3]) -> [f64; 3] {
    let (material, body) = block(fibres, direction, f);
    let forces = body.forces(&material).unwrap();
    let end = f64::from(CELLS[0]) * EDGE;
    let area = f64::from(CELLS[1] * CELLS[2]) * EDGE * EDGE;
    let on_end = body.rest.iter().zip(&forces).filter(|(rest, _)| (rest[0] - end).abs() < 1e-9);
    on_end.fold([0.0; 3], |sum, (_, force)| [0, 1, 2].map(|i| sum[i] - force[i] / area))
}

/// The part of the traction that fibres add by the law: column x of `2 k1 E exp(k2 E^2) (F a) a^T`.
fn formula(direction: [f64; 3], f: [[f64; 3]; 3]) -> [f64; 3] {
    let m = [0, 1, 2].map(|i| (0..3).map(|j| f[i][j] * direction[j]).sum::<f64>());
    let strain = (m.iter().map(|c| c * c).sum::<f64>() - 1.0).max(0.0);
    m.map(|c| 2.0 * K1 * strain * (K2 * strain * strain).exp() * c * direction[0])
}

/// Requires that fibres add to the traction what the formula says.
fn assert_formula(direction: [f64; 3], f: [[f64; 3]; 3]) {
    let (with, without, exact) = (traction(K1, direction, f), traction(0.0, direction, f), formula(direction, f));
    for i in 0..3 {
        let found = with[i] - without[i];
        assert!((found - exact[i]).abs() < 1e-9 * K1, "{direction:?}, {f:?}: {found} of {exact:?} along axis {i}");
    }
}

fn stretch(along: f64, across: f64) -> [[f64; 3]; 3] {
    [[along, 0.0, 0.0], [0.0, across, 0.0], [0.0, 0.0, across]]
}

#[test]
fn a_stretch_along_the_fibres_follows_the_law_and_one_across_is_that_of_the_matrix() {
    for along in [0.8, 1.001, 1.05, 1.3, 1.8] {
        let f = stretch(along, 1.0 / along.sqrt());
        assert_formula([1.0, 0.0, 0.0], f);
        assert_formula([0.0, 0.0, 1.0], f);
    }
}

#[test]
fn any_direction_and_homogeneous_deformation_follows_the_law() {
    let mut random = Random(3);
    for _ in 0..40 {
        let v = random.vector();
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let f = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { 1.1 } else { 0.0 } + 0.3 * random.signed()));
        assert_formula(v.map(|c| c / length), f);
    }
}

#[test]
fn fibres_at_an_angle_shear_a_stretched_block_towards_them() {
    let diagonal = [0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0];
    let f = stretch(1.2, 1.0);
    assert_formula(diagonal, f);
    // The block would have to shear until this vanishes.
    let [_, shear, lift] = traction(K1, diagonal, f);
    assert!(shear > 100.0 && lift.abs() < 1e-9, "{shear} {lift}");
}

/// Near rest, `4 k1` along the fibres is what the documentation promises.
#[test]
fn fibres_add_four_times_their_stiffness_to_the_modulus() {
    let strain = 1e-4;
    let f = stretch(1.0 + strain, 1.0);
    let added = traction(K1, [1.0, 0.0, 0.0], f)[0] - traction(0.0, [1.0, 0.0, 0.0], f)[0];
    assert!((added / strain / (4.0 * K1) - 1.0).abs() < 2.0 * strain, "{added}");
}
