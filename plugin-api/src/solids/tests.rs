//! An energy through the kit: stress and stiffness are its derivatives, on every vector unit, and inverted elements have a semi-definite
//! matrix.

use super::matrix::{IDENTITY, cofactors, determinant, norm_squared, product, transposed};
use super::*;
use crate::kit::Random;
use crate::lanes::{Real, Vec3};

/// `mu/2 (|F|^2 - 3) - mu (J - 1) + lambda/2 (J - 1)^2` (Macklin and Mueller 2021).
struct Energy {
    mu: f64,
    lambda: f64,
    project: bool,
}

impl Energy {
    fn pressure<T: Real>(&self, j: T) -> T {
        (j - j.splat(1.0)) * self.lambda - j.splat(self.mu)
    }
}

impl SolidEnergy for Energy {
    fn density(&self, f: &Mat3) -> f64 {
        let loss = determinant(f) - 1.0;
        0.5 * self.mu * (norm_squared(f) - 3.0) - self.mu * loss + 0.5 * self.lambda * loss * loss
    }

    fn stress<T: Real>(&self, f: &Mat3<T>) -> Mat3<T> {
        let (pressure, cofactors) = (self.pressure(determinant(f)), cofactors(f));
        [0, 1, 2].map(|i| f[i] * pressure.splat(self.mu) + cofactors[i] * pressure)
    }

    fn hessian<T: Real>(&self, f: &Mat3<T>) -> EnergyHessian<T> {
        let svd = svd(f);
        let s = svd.s;
        let (pressure, mu) = (self.pressure(s[0] * s[1] * s[2]), s[0].splat(self.mu));
        let slope = Vec3([s[1] * s[2], s[2] * s[0], s[0] * s[1]]);
        let entry =
            |i: usize, j: usize| slope[i] * slope[j] * self.lambda + if i == j { mu } else { pressure * s[3 - i - j] };
        let stretch = [0, 1, 2].map(|i| Vec3([0, 1, 2].map(|j| entry(i, j))));
        let symmetric = Vec3([0, 1, 2].map(|i| mu - pressure * s[i]));
        let antisymmetric = Vec3([0, 1, 2].map(|i| mu + pressure * s[i]));
        EnergyHessian::new(&svd, PrincipalModes { stretch, symmetric, antisymmetric }, self.project)
    }
}

/// A tetrahedron, and positions of its corners that are `spread` (m) away from rest at random.
fn deformed(random: &mut Random, spread: f64) -> (Tetrahedron, [Vec3; 4]) {
    let rest = [[0.0; 3], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.0, 0.2, 1.1]].map(Vec3);
    let x = rest.map(|r| r + Vec3(random.vector()) * spread);
    (Tetrahedron::new(rest, 1.0).expect("has a volume"), x)
}

fn energy_of(energy: &Energy, shape: &Tetrahedron, x: [Vec3; 4]) -> f64 {
    shape.volume * energy.density(&shape.deformation_gradient(x))
}

fn forces_of(energy: &Energy, shape: &Tetrahedron, x: [Vec3; 4]) -> [Vec3; 4] {
    shape.forces(&energy.stress(&shape.deformation_gradient(x)))
}

#[test]
fn forces_and_blocks_are_derivatives_at_any_deformation() {
    let (mut random, step) = (Random(3), 1e-5);
    let energy = Energy { mu: 2.0, lambda: 3.0, project: false };
    for spread in [0.0, 0.05, 0.5, 1.5] {
        for _ in 0..20 {
            let (shape, x) = deformed(&mut random, spread);
            let forces = forces_of(&energy, &shape, x);
            let stiffness = Stiffness::new(&shape, 1.0, energy.hessian(&shape.deformation_gradient(x)));
            for (corner, axis) in (0..12).map(|i| (i / 3, i % 3)) {
                let moved = |by: f64| {
                    let mut x = x;
                    x[corner][axis] += by;
                    x
                };
                let ahead = energy_of(&energy, &shape, moved(step)) - energy_of(&energy, &shape, moved(-step));
                assert!((forces[corner][axis] + ahead / (2.0 * step)).abs() < 1e-8, "spread {spread}");
                let (after, before) =
                    (forces_of(&energy, &shape, moved(step)), forces_of(&energy, &shape, moved(-step)));
                for other in 0..4 {
                    let block = stiffness.block(other, corner);
                    for i in 0..3 {
                        let slope = (before[other][i] - after[other][i]) / (2.0 * step);
                        assert!((block[i][axis] - slope).abs() < 1e-7, "spread {spread}: {} {slope}", block[i][axis]);
                    }
                }
            }
        }
    }
}

#[test]
#[cfg_attr(miri, ignore = "takes minutes for 4,000 decompositions, without unsafe code")]
fn projected_blocks_are_semi_definite_where_exact_ones_are_not() {
    let mut random = Random(5);
    let work = |project: bool, shape: &Tetrahedron, x: [Vec3; 4], d: [Vec3; 4]| -> f64 {
        let energy = Energy { mu: 2.0, lambda: 3.0, project };
        let stiffness = Stiffness::new(shape, 1.0, energy.hessian(&shape.deformation_gradient(x)));
        let along = |a: usize, b: usize| d[a].dot(matrix::apply(&stiffness.block(a, b), d[b]));
        (0..16).map(|i| along(i / 4, i % 4)).sum()
    };
    let (mut least, mut negative) = (f64::INFINITY, 0);
    for _ in 0..2000 {
        let (shape, x) = deformed(&mut random, 1.0);
        let d = [(); 4].map(|()| Vec3(random.vector()));
        least = least.min(work(true, &shape, x, d));
        negative += usize::from(work(false, &shape, x, d) < 0.0);
    }
    assert!(least > -1e-12 && negative > 20, "{least}, {negative} of the exact ones are negative");
}

#[test]
fn an_energy_of_the_elastic_part_alone_sees_no_plastic_flow() {
    let (shape, x) = deformed(&mut Random(7), 0.0);
    let flow = [Vec3([1.25, 0.2, 0.0]), Vec3([0.0, 0.8, 0.0]), Vec3([0.0, 0.0, 1.0])];
    // Positions that follow the flow exactly: F = Fp, whose inverse is given.
    let inverse = [Vec3([0.8, -0.2, 0.0]), Vec3([0.0, 1.25, 0.0]), Vec3([0.0, 0.0, 1.0])];
    let unit = product(&flow, &inverse);
    assert!(norm_squared(&[0, 1, 2].map(|i| unit[i] - IDENTITY[i])) < 1e-28);
    let moved = x.map(|p| matrix::apply(&flow, p));
    let elastic = shape.after_flow(&inverse).deformation_gradient(moved);
    assert!(norm_squared(&[0, 1, 2].map(|i| elastic[i] - IDENTITY[i])) < 1e-28, "{elastic:?}");
    assert!(norm_squared(&transposed(&flow)) > 3.0);
}
