//! Forces and stiffness of the elements of a call, one element for each lane of a vector register.

use super::call::SolidCall;
use super::energy::SolidEnergy;
use super::hessian::Stiffness;
use super::registers::{CORNER_PAIRS, ElementBlocks, gather, scatter};
use super::viscosity::{Damping, ViscosityCoefficients, add_viscous_stress};
use crate::lanes::{Vec3, Wide};
use crate::{BlockScalar, Blocks, NodeVectors, TangentScale};
use pulp::{Simd, WithSimd};

/// Adds forces. Returns a sum over the elements that is finite only if the forces are.
pub(super) struct Forces<'a, 'b, 'c, E> {
    pub(super) call: &'b SolidCall<'a, E>,
    pub(super) out: &'b mut NodeVectors<'c>,
}

impl<E: SolidEnergy> WithSimd for Forces<'_, '_, '_, E> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { call: SolidCall { energy, elements, shapes }, out } = self;
        let (nodes, viscosity, mut sum) = (elements.corners::<4>(), energy.viscosity(), 0.0);
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let shape = shapes.load(simd, e);
            let f = shape.deformation_gradient(gather(simd, nodes, e, elements.x()));
            let mut stress = energy.stress(&f);
            if E::HAS_FIBRES
                && let Some(fibres) = &shapes.fibres
            {
                fibres.load(simd, *energy, e, &f).add_stress(&mut stress);
            }
            if viscosity.shear > 0.0 {
                let f_rate = shape.deformation_gradient(gather(simd, nodes, e, elements.v()));
                add_viscous_stress(&f, &f_rate, viscosity, &mut stress);
            }
            sum += scatter(nodes, e, &shape.forces(&stress), out);
        }
        sum
    }
}

/// Adds `scale.stiffness` K + `scale.damping` C.
pub(super) struct Tangent<'a, 'b, 'c, E, T> {
    pub(super) call: &'b SolidCall<'a, E>,
    pub(super) scale: TangentScale,
    pub(super) out: &'b mut Blocks<'c, T>,
}

impl<E: SolidEnergy, T: BlockScalar> WithSimd for Tangent<'_, '_, '_, E, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { call: SolidCall { energy, elements, shapes }, scale, out } = self;
        let (nodes, viscosity) = (elements.corners::<4>(), energy.viscosity());
        let viscosity = ViscosityCoefficients {
            shear: scale.damping * viscosity.shear,
            dilatation: scale.damping * viscosity.dilatation,
        };
        let mut blocks = ElementBlocks::<T>::default();
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let shape = shapes.load(simd, e);
            let f = shape.deformation_gradient(gather(simd, nodes, e, elements.x()));
            let stiffness = if scale.stiffness == 0.0 {
                None
            } else {
                Some(Stiffness::new(&shape, scale.stiffness, energy.hessian(&f)))
            };
            let fibres = match &shapes.fibres {
                Some(fibres) if E::HAS_FIBRES && scale.stiffness != 0.0 => Some(fibres.load(simd, *energy, e, &f)),
                _ => None,
            };
            let damping = if viscosity.shear == 0.0 { None } else { Some(Damping::new(&shape, &f, viscosity)) };
            for (a, b) in CORNER_PAIRS {
                if a == b && !T::HAS_DIAGONAL_BLOCKS {
                    continue;
                }
                let mut block = [Vec3([Wide(simd.splat_f64s(0.0), simd); 3]); 3];
                if let Some(stiffness) = &stiffness {
                    block = stiffness.block(a, b);
                }
                if let Some(fibres) = &fibres {
                    fibres.add_block(&shape, scale.stiffness, a, b, &mut block);
                }
                if let Some(damping) = &damping {
                    damping.add_block(a, b, &mut block);
                }
                blocks.set(a, b, &block);
            }
            blocks.add_to(out, e, 0..S::F64_LANES.min(nodes.len() - e));
        }
    }
}
