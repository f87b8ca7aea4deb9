//! Energy, forces and stiffness of a triangle in its plane: the energy is `area / 2 e : C : e`.
//!
//! Two strain measures: that of the corotated frame (`sym(L) - I`), or Green's, `(F^T F - I) / 2`, in which shear does not stretch the
//! yarns and which softens under compression.

use crate::elasticity::ElasticityTensor;
use crate::frame::{Frame, FrameRule};
use crate::tangent::{ElementTangent, positive_part};
use crate::triangle::Triangle;
use crate::vector::{Mat2, Vec2, Vec3, Voigt, contract, scale};
use crate::wrinkling::{Relaxed, relax};
use pliant_plugin_api::TangentScale;
use pliant_plugin_api::lanes::Real;

/// The strain measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StrainMeasure {
    /// `sym(L) - I` in the frame of a rule.
    Corotated(FrameRule),
    /// `(F^T F - I) / 2`
    Green,
}

/// The constitutive law of the sheet in its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Membrane {
    pub(crate) strain: StrainMeasure,
    pub(crate) elasticity: ElasticityTensor,
    /// Viscosity over stiffness, s.
    pub(crate) damping_time: f64,
    /// Share of compressive stress that stays, 0 to 1: less than 1 for a sheet that wrinkles below the mesh.
    pub(crate) compression: f64,
    /// Whether the matrix is made positive semi-definite.
    pub(crate) project: bool,
}

/// Least area over rest area by which tension is divided; used in the matrix only.
const MIN_AREA_RATIO: f64 = 1e-3;

/// Stress and energy density of a strain.
struct Elastic<T> {
    /// Membrane stress, N/m.
    stress: Voigt<T>,
    /// Energy per area at rest, J/m^2.
    energy: T,
}

impl Membrane {
    /// Energy density at a deformation gradient (columns), J/m^2.
    pub(crate) fn energy(&self, shape: &Triangle, f: [Vec3; 2]) -> f64 {
        let e = match self.strain {
            StrainMeasure::Corotated(rule) => Frame::new(rule, f, shape.gradient[2]).strain(),
            StrainMeasure::Green => green_strain(f),
        };
        self.elastic(e).energy
    }

    /// Stress and energy of a strain, with the share of compression that wrinkles leave.
    #[inline(always)]
    fn elastic<T: Real>(&self, e: Voigt<T>) -> Elastic<T> {
        let q = self.elasticity.stress(e);
        let energy = contract(e, q) * 0.5;
        let kept = self.compression;
        if kept == 1.0 {
            return Elastic { stress: q, energy };
        }
        let [e11, e22, gamma] = e;
        let relaxed = T::map_lanes([e11, e22, gamma, e11], |[e11, e22, gamma, _]| {
            let Relaxed { stress: [s11, s22, s12], energy } = relax(&self.elasticity, [e11, e22, gamma]);
            [s11, s22, s12, energy]
        });
        let (r, lost) = (relaxed, 1.0 - kept);
        Elastic {
            stress: [q[0] * kept + r[0] * lost, q[1] * kept + r[1] * lost, q[2] * kept + r[2] * lost],
            energy: energy * kept + r[3] * lost,
        }
    }

    /// Elastic stress and, if a rate of strain (1/s) is given, viscous stress, N/m.
    #[inline(always)]
    fn viscoelastic_stress<T: Real>(&self, e: Voigt<T>, rate: Option<Voigt<T>>) -> Voigt<T> {
        let [a, b, c] = self.elastic(e).stress;
        let Some(rate) = rate else { return [a, b, c] };
        let viscous = scale(self.elasticity.stress(rate), self.damping_time);
        [a + viscous[0], b + viscous[1], c + viscous[2]]
    }

    /// First Piola-Kirchhoff stress by columns, N/m, at a deformation gradient and, if given, its rate (1/s).
    #[inline(always)]
    pub(crate) fn stress<T: Real>(
        &self,
        shape: &Triangle<T>,
        f: [Vec3<T>; 2],
        rate: Option<[Vec3<T>; 2]>,
    ) -> [Vec3<T>; 2] {
        match self.strain {
            StrainMeasure::Corotated(rule) => {
                let frame = Frame::new(rule, f, shape.gradient[2]);
                let spin_strain = frame.spin_strain();
                let spin = frame.spin_gradient();
                let [t, u] = frame.axes;
                let strain_rate = rate.map(|rate| {
                    let a = [[t.dot(rate[0]), t.dot(rate[1])], [u.dot(rate[0]), u.dot(rate[1])]];
                    let w = spin[0][0] * a[0][0] + spin[0][1] * a[0][1] + spin[1][0] * a[1][0] + spin[1][1] * a[1][1];
                    [a[0][0] - w * spin_strain[0], a[1][1] - w * spin_strain[1], a[0][1] + a[1][0] - w * spin_strain[2]]
                });
                let q = self.viscoelastic_stress(frame.strain(), strain_rate);
                let p = piola_in_frame(q, contract(q, spin_strain), spin);
                [t * p[0][0] + u * p[1][0], t * p[0][1] + u * p[1][1]]
            }
            StrainMeasure::Green => {
                let strain_rate = rate.map(|rate| {
                    let shear = f[0].dot(rate[1]) + f[1].dot(rate[0]);
                    [f[0].dot(rate[0]), f[1].dot(rate[1]), shear]
                });
                let q = self.viscoelastic_stress(green_strain(f), strain_rate);
                [f[0] * q[0] + f[1] * q[2], f[0] * q[2] + f[1] * q[1]]
            }
        }
    }

    /// `factors.stiffness` K + `factors.damping` C per area.
    ///
    /// K is the exact second derivative where `project` is off and nothing wrinkles (wrinkling only softens it). With `project`, tension
    /// alone resists rotation out of the plane, and the spin gets at least the stiffness that makes the rest positive
    /// semi-definite: never softer than the exact K.
    #[inline(always)]
    pub(crate) fn tangent<T: Real>(
        &self,
        shape: &Triangle<T>,
        f: [Vec3<T>; 2],
        factors: TangentScale,
    ) -> ElementTangent<T> {
        let TangentScale { stiffness, damping } = factors;
        let c = &self.elasticity;
        let factor = stiffness + damping * self.damping_time;
        let (zero, one) = (f[0][0].splat(0.0), f[0][0].splat(1.0));
        let strain_stiffness = [
            zero.splat(factor * c.c11),
            zero.splat(factor * c.c22),
            zero.splat(factor * c.c12),
            zero.splat(factor * c.shear),
        ];
        let [_, gb, gc] = shape.gradient;
        match self.strain {
            StrainMeasure::Green => {
                let s = self.elastic(green_strain(f)).stress;
                let tension = scale(if self.project { positive_part(s) } else { s }, stiffness);
                // A displacement along a column of F changes the strain by the shape function gradient.
                let strain_rows = [
                    [[gb[0], zero], [zero, gb[1]], [gb[1], gb[0]], [zero; 2]],
                    [[gc[0], zero], [zero, gc[1]], [gc[1], gc[0]], [zero; 2]],
                ];
                ElementTangent {
                    axes: f,
                    strain_rows,
                    strain_stiffness,
                    spin_stiffness: [zero; 4],
                    tension,
                    tension_projection: [one, one, one, zero, zero, zero],
                }
            }
            StrainMeasure::Corotated(rule) => {
                let frame = Frame::new(rule, f, shape.gradient[2]);
                let (spin_strain, spin) = (frame.spin_strain(), frame.spin_gradient());
                let strain_rows =
                    [corotated_strain_rows(gb, spin_strain, spin), corotated_strain_rows(gc, spin_strain, spin)];
                let q = self.elastic(frame.strain()).stress;
                let l = &frame.stretch;
                let p = piola_in_frame(q, contract(q, spin_strain), spin);
                let k = frame.normalised_condition();
                let trace = p[0][0] + p[1][1];
                // Second derivatives by each strain and the spin, and by the spin.
                let m = [-p[1][0] - trace * k[0], p[0][1] - trace * k[1], (p[0][0] - p[1][1]) * 0.5 - trace * k[2]];
                let own = q[0] * l[0][0] + q[1] * l[1][1] + q[2] * (l[0][1] + l[1][0]);
                let own = if self.project { own.max(c.compliance_product(m, m)) } else { own };
                let s = second_piola_kirchhoff(l, &p);
                let tension = scale(if self.project { positive_part(s) } else { s }, stiffness);
                let n = frame.normal;
                let tension_projection = [n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1], n[0] * n[2], n[1] * n[2]];
                let spin_stiffness = [m[0] * stiffness, m[1] * stiffness, m[2] * stiffness, own * stiffness];
                ElementTangent {
                    axes: frame.axes,
                    strain_rows,
                    strain_stiffness,
                    spin_stiffness,
                    tension,
                    tension_projection,
                }
            }
        }
    }
}

/// Derivative of (11, 22, gamma, w) by a displacement of a corner along the frame's axes, 1/m; `g` is its shape function gradient.
#[inline(always)]
fn corotated_strain_rows<T: Real>(g: Vec2<T>, spin_strain: Voigt<T>, spin: Mat2<T>) -> [Vec2<T>; 4] {
    let w = [spin[0][0] * g[0] + spin[0][1] * g[1], spin[1][0] * g[0] + spin[1][1] * g[1]];
    [
        [g[0] - spin_strain[0] * w[0], -(spin_strain[0] * w[1])],
        [-(spin_strain[1] * w[0]), g[1] - spin_strain[1] * w[1]],
        [g[1] - spin_strain[2] * w[0], g[0] - spin_strain[2] * w[1]],
        w,
    ]
}

/// Green's strain of a deformation gradient's columns.
#[inline(always)]
fn green_strain<T: Real>(f: [Vec3<T>; 2]) -> Voigt<T> {
    let one = f[0][0].splat(1.0);
    [(f[0].dot(f[0]) - one) * 0.5, (f[1].dot(f[1]) - one) * 0.5, f[0].dot(f[1])]
}

/// First Piola-Kirchhoff stress in the frame, N/m, from the stress `q` of the frame's strain and its product with the spin strain.
#[inline(always)]
fn piola_in_frame<T: Real>(q: Voigt<T>, spin_product: T, spin: Mat2<T>) -> Mat2<T> {
    [
        [q[0] - spin_product * spin[0][0], q[2] - spin_product * spin[0][1]],
        [q[2] - spin_product * spin[1][0], q[1] - spin_product * spin[1][1]],
    ]
}

/// Second Piola-Kirchhoff stress `L^-1 P`, symmetrised, N/m.
#[inline(always)]
fn second_piola_kirchhoff<T: Real>(l: &Mat2<T>, p: &Mat2<T>) -> Voigt<T> {
    let det = l[0][0] * l[1][1] - l[0][1] * l[1][0];
    let inverse_det = det.splat(1.0) / det.max(det.splat(MIN_AREA_RATIO));
    let [[a, b], [c, d]] = [[l[1][1], -l[0][1]], [-l[1][0], l[0][0]]];
    let (s11, s12) = ((a * p[0][0] + b * p[1][0]) * inverse_det, a * p[0][1] + b * p[1][1]);
    let (s21, s22) = (c * p[0][0] + d * p[1][0], (c * p[0][1] + d * p[1][1]) * inverse_det);
    [s11, s22, (s12 + s21) * 0.5 * inverse_det]
}
