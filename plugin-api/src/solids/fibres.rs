//! Fibres in a solid: an energy of the stretch along one direction of each element, added to the isotropic density.
//!
//! With the unit vector a along the fibres at rest and `m = F a`, the energy density is psi(I4) of the squared stretch `I4 = m . m`. Its stress is
//! `2 psi' m a^T`, and its second derivative takes `dF` to `(2 psi' dF a + 4 psi'' (m . dF a) m) a^T`: positive semi-definite where neither psi' nor
//! psi'' is negative, as of fibres that carry tension alone, so nothing has to be projected.

use super::energy::SolidEnergy;
use super::matrix::{Mat3, apply};
use super::tetrahedron::{STRIDE, Tetrahedron};
use crate::lanes::{Real, Vec3, Wide};
use crate::{ElementRequest, Elements, Planes, abi};
use pulp::Simd;

/// Planes of rest data that fibres add to those of the shape ([`STRIDE`]): the unit vector along the fibres, then the factor of their energy.
pub const FIBRE_STRIDE: usize = 4;
/// Planes of rest data of an element with fibres.
const ALL: usize = STRIDE + FIBRE_STRIDE;

/// The energy of fibres at a squared stretch I4 (1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FibreEnergy {
    /// Energy density psi per volume at rest, J/m^3.
    pub density: f64,
    /// First derivative `dpsi/dI4`, Pa.
    pub slope: f64,
    /// Second derivative `d2psi/dI4^2`, Pa.
    pub curvature: f64,
}

impl FibreEnergy {
    /// This energy times a factor (1).
    fn scaled(self, factor: f64) -> Self {
        Self { density: factor * self.density, slope: factor * self.slope, curvature: factor * self.curvature }
    }
}

/// The requests of a solid with fibres: those of [`requests`](super::requests), whose tetrahedra want directions.
pub fn with_fibres(mut requests: Vec<ElementRequest>) -> Vec<ElementRequest> {
    for request in requests.iter_mut().filter(|request| request.kind == abi::TETRAHEDRON) {
        request.flags |= abi::WANTS_DIRECTIONS;
        request.rest_stride += FIBRE_STRIDE as u32;
    }
    requests
}

/// Writes the fibre directions of a call after the rest data of the shapes, which [`write_rest_data`](super::write_rest_data) writes. `factor` gives
/// the factor of the energy of an element's fibres over that of its isotropic density (1).
pub fn write_fibres(elements: &Elements<'_>, factor: impl Fn(usize) -> f64, out: &mut Planes<'_>) {
    let planes = out.first_planes::<ALL>();
    for e in 0..elements.len() {
        let [x, y, z] = elements.direction(e);
        [x, y, z, factor(e)].into_iter().enumerate().for_each(|(s, value)| planes[STRIDE + s][e] = value);
    }
}

/// Planes of rest data of the fibres of a call.
#[derive(Clone, Copy)]
pub(super) struct FibrePlanes<'a>([&'a [f64]; FIBRE_STRIDE]);

impl<'a> FibrePlanes<'a> {
    /// The planes that [`write_fibres`] wrote.
    pub(super) fn new(elements: &Elements<'a>) -> Self {
        Self(std::array::from_fn(|s| elements.rest_data(STRIDE + s)))
    }

    /// Energy density of the fibres of element `e` at the deformation gradient `f`, J/m^3.
    pub(super) fn density<E: SolidEnergy>(&self, energy: &E, e: usize, f: &Mat3) -> f64 {
        let direction = Vec3([0, 1, 2].map(|s| self.0[s][e]));
        let stretched = apply(f, direction);
        energy.fibres(stretched.dot(stretched)).scaled(self.0[3][e]).density
    }

    /// The fibres of elements `e, e + 1, ..`, one per lane, at the deformation gradient `f`; lanes past the end repeat the last one.
    #[inline(always)]
    pub(super) fn load<S: Simd, E: SolidEnergy>(
        &self,
        simd: S,
        energy: &E,
        e: usize,
        f: &Mat3<Wide<S>>,
    ) -> Fibres<Wide<S>> {
        let mut direction = Vec3([Wide(simd.splat_f64s(0.0), simd); 3]);
        for i in 0..3 {
            direction[i] = Wide::load_clamped(simd, self.0[i], e);
        }
        let stretched = apply(f, direction);
        let factor = Wide::load_clamped(simd, self.0[3], e);
        let [slope, curvature] = Wide::map_lanes([stretched.dot(stretched), factor], |[squared_stretch, factor]| {
            let FibreEnergy { slope, curvature, .. } = energy.fibres(squared_stretch).scaled(factor);
            [slope, curvature]
        });
        Fibres { direction, stretched, slope, curvature }
    }
}

/// Fibres of an element at a deformation gradient F.
pub(super) struct Fibres<T> {
    /// Unit vector a along the fibres at rest; zero without fibres.
    direction: Vec3<T>,
    /// Fibre direction in the deformed shape, `F a`; its length is the stretch.
    stretched: Vec3<T>,
    /// First derivative of the energy density by the squared stretch, `dpsi/dI4`, Pa.
    slope: T,
    /// Second derivative of the energy density by the squared stretch, `d2psi/dI4^2`, Pa.
    curvature: T,
}

impl<T: Real> Fibres<T> {
    /// Adds their first Piola-Kirchhoff stress, Pa.
    #[inline(always)]
    pub(super) fn add_stress(&self, stress: &mut Mat3<T>) {
        let tension = self.stretched * (self.slope * 2.0);
        for i in 0..3 {
            stress[i] = stress[i] + self.direction * tension[i];
        }
    }

    /// Adds `factor` times their stiffness between corners a and b, N/m.
    #[inline(always)]
    pub(super) fn add_block(&self, shape: &Tetrahedron<T>, factor: f64, a: usize, b: usize, block: &mut Mat3<T>) {
        let (g, m) = (&shape.gradient, self.stretched);
        let both = g[a].dot(self.direction) * g[b].dot(self.direction) * (shape.volume * factor);
        let (across, along) = (both * self.slope * 2.0, both * self.curvature * 4.0);
        for i in 0..3 {
            block[i] = block[i] + m * (along * m[i]);
            block[i][i] = block[i][i] + across;
        }
    }
}
