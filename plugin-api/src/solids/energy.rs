//! What a solid says of itself: the energy density of a deformation gradient.

use super::fibres::FibreEnergy;
use super::hessian::EnergyHessian;
use super::matrix::Mat3;
use super::viscosity::ViscosityCoefficients;
use crate::lanes::Real;

/// An isotropic energy density psi(F) of the deformation gradient F, per volume at rest, and that of fibres if there are any. Zero stress at F = I is expected, and a finite value for
/// every finite F: implicit steps and touches invert elements.
pub trait SolidEnergy: Sync {
    /// Energy density, zero at rest, J/m^3.
    fn density(&self, f: &Mat3) -> f64;

    /// First Piola-Kirchhoff stress dpsi/dF, Pa. Mark it `#[inline(always)]`.
    fn stress<T: Real>(&self, f: &Mat3<T>) -> Mat3<T>;

    /// d2psi/dF2, Pa. Mark it `#[inline(always)]`. It should be positive semi-definite (`project` of [`EnergyHessian::new`]), or implicit steps
    /// may not converge.
    fn hessian<T: Real>(&self, f: &Mat3<T>) -> EnergyHessian<T>;

    /// Whether elements have fibres: [`SolidEnergy::fibres`] is then added. The material asks for their directions by
    /// [`with_fibres`](super::with_fibres) and keeps them by [`write_fibres`](super::write_fibres). Not together with plastic flow.
    const HAS_FIBRES: bool = false;

    /// Energy of the fibres by the squared stretch I4 along them, 0 or more; without energy and slope at 1. The matrix is positive semi-definite where
    /// neither slope nor curvature is negative.
    fn fibres(&self, _squared_stretch: f64) -> FibreEnergy {
        FibreEnergy::default()
    }

    /// Coefficients of a viscosity on the rate of Green's strain; none by default.
    #[inline(always)]
    fn viscosity(&self) -> ViscosityCoefficients {
        ViscosityCoefficients::default()
    }
}
