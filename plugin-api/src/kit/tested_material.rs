//! A material under test, as a Rust type or as an instance behind the C interface.

use crate::abi;
use crate::batch::{Elements, NodeScalars, NodeVectors, Planes, Strides};
use crate::blocks::{Blocks, SingleBlocks};
use crate::fault::Fault;
use crate::material::{ElementRequest, Material, TangentScale};
use crate::normals::NormalForces;
use core::marker::PhantomData;

/// The arguments of one call. Only [`super::Body`] makes them, so the pointers in the batch are valid.
pub struct Call<'a> {
    pub(super) batch: abi::Batch,
    pub(super) strides: Strides,
    pub(super) borrowed: PhantomData<&'a f64>,
}

impl Call<'_> {
    /// The elements of the call.
    pub fn elements(&self) -> Elements<'_> {
        Elements(&self.batch, self.strides, &[], core::ptr::null())
    }

    /// The elements of the call, for a material that declares these parameters.
    fn elements_of<M: Material>(&self) -> Elements<'_> {
        Elements(&self.batch, self.strides, M::INFO.params, core::ptr::null())
    }
}

/// A material under test: every [`Material`], and [`super::TestInstance`].
///
/// Shapes: m elements, n nodes; "Errors" is the fault of the material.
pub trait MaterialUnderTest {
    /// The kinds of elements the material works on.
    ///
    /// # Errors
    /// The material's fault.
    fn element_requests(&self) -> Result<Vec<ElementRequest>, Fault>;

    /// Writes rest data (stride x m, plane-major).
    ///
    /// # Errors
    /// The material's fault.
    fn call_rest(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// Writes rest data of elements with fibre `directions`, unit vectors or zero (m x 3).
    ///
    /// # Errors
    /// The material's fault.
    fn call_directed_rest(&self, call: &Call<'_>, directions: &[[f64; 3]], out: &mut [f64]) -> Result<(), Fault>;

    /// Adds lumped masses, kg (n).
    ///
    /// # Errors
    /// The material's fault.
    fn call_mass(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// Elastic energy, J.
    ///
    /// # Errors
    /// The material's fault.
    fn call_energy(&self, call: &Call<'_>) -> Result<f64, Fault>;

    /// Adds forces, N (n x 3).
    ///
    /// # Errors
    /// The material's fault.
    fn call_forces(&self, call: &Call<'_>, out: &mut [[f64; 3]]) -> Result<(), Fault>;

    /// Adds `scale.stiffness` K + `scale.damping` C, N/m, to the blocks `slots` (m x pairs) names.
    ///
    /// # Errors
    /// The material's fault.
    fn call_tangent(
        &self,
        call: &Call<'_>,
        scale: TangentScale,
        slots: &[u32],
        out: &mut [[f64; 9]],
    ) -> Result<(), Fault>;

    /// Adds off-diagonal blocks in single precision, N/m, to the blocks `slots` (m x pairs) names.
    ///
    /// # Errors
    /// The material's fault.
    fn call_single_tangent(
        &self,
        call: &Call<'_>,
        scale: TangentScale,
        slots: &[u32],
        out: &mut [[f32; 9]],
    ) -> Result<(), Fault>;

    /// Updates history (stride x m, plane-major) that holds its present values.
    ///
    /// # Errors
    /// The material's fault.
    fn call_advance(&self, call: &Call<'_>, history: &mut [f64]) -> Result<(), Fault>;

    /// Writes 1 for each element that has failed, else 0 (m).
    ///
    /// # Errors
    /// The material's fault.
    fn call_failed(&self, call: &Call<'_>, out: &mut [u8]) -> Result<(), Fault>;

    /// Writes strains of coupled hinges, m, and their gradients (13 x m, plane-major).
    ///
    /// # Errors
    /// The material's fault.
    fn call_strain(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// Writes compliances between the sides of triangles, m/N (6 x m, plane-major).
    ///
    /// # Errors
    /// The material's fault.
    fn call_compliance(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// Energy of vertex normals, J, for unit `normals` (n x 3).
    ///
    /// # Errors
    /// The material's fault.
    fn call_normals_energy(&self, call: &Call<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault>;

    /// Adds its forces at fixed normals, N, and its derivatives by the normals, J (n x 6).
    ///
    /// # Errors
    /// The material's fault.
    fn call_normals_forces(&self, call: &Call<'_>, normals: &[[f64; 3]], out: &mut [[f64; 6]]) -> Result<(), Fault>;

    /// Writes the stiffness of normals against tilting across the sides of triangles, N m (3 x m, plane-major).
    ///
    /// # Errors
    /// The material's fault.
    fn call_tilt(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;
}

/// Asserts that `slots` has an entry for every pair of corners, and that each names one of `blocks` blocks.
fn check_slots(call: &Call<'_>, slots: &[u32], blocks: usize) {
    let corners = call.batch.corners as usize;
    assert!(slots.len() >= call.batch.count * corners * (corners + 1) / 2, "a slot for every pair of every element");
    assert!(slots.iter().all(|s| ((s & !abi::TRANSPOSED) as usize) < blocks), "every slot names a block");
}

/// Blocks in single precision as the C interface hands them over.
pub(super) fn raw_single_blocks(call: &Call<'_>, slots: &[u32], out: &mut [[f32; 9]]) -> abi::SingleBlocks {
    check_slots(call, slots, out.len());
    abi::SingleBlocks {
        size: size_of::<abi::SingleBlocks>(),
        values: out.as_mut_ptr().cast(),
        slots: slots.as_ptr(),
        slot_begin: 0,
        slot_end: out.len(),
    }
}

/// Blocks as the C interface hands them over.
pub(super) fn raw_blocks(call: &Call<'_>, slots: &[u32], out: &mut [[f64; 9]]) -> abi::Blocks {
    check_slots(call, slots, out.len());
    abi::Blocks {
        size: size_of::<abi::Blocks>(),
        values: out.as_mut_ptr().cast(),
        slots: slots.as_ptr(),
        slot_begin: 0,
        slot_end: out.len(),
    }
}

impl<M: Material> MaterialUnderTest for M {
    fn element_requests(&self) -> Result<Vec<ElementRequest>, Fault> {
        Ok(self.elements())
    }

    fn call_rest(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= call.strides.rest * call.batch.count, "planes of every element");
        self.rest(&call.elements_of::<M>(), &mut Planes::new(&call.batch, out.as_mut_ptr(), call.strides.rest))
    }

    fn call_directed_rest(&self, call: &Call<'_>, directions: &[[f64; 3]], out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= call.strides.rest * call.batch.count, "planes of every element");
        assert!(directions.len() >= call.batch.count, "a direction for every element");
        let mut elements = call.elements_of::<M>();
        elements.3 = directions.as_ptr().cast();
        self.rest(&elements, &mut Planes::new(&call.batch, out.as_mut_ptr(), call.strides.rest))
    }

    fn call_mass(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one mass a node");
        self.mass(&call.elements_of::<M>(), &mut NodeScalars::new(&call.batch, out.as_mut_ptr()))
    }

    fn call_energy(&self, call: &Call<'_>) -> Result<f64, Fault> {
        self.energy(&call.elements_of::<M>())
    }

    fn call_forces(&self, call: &Call<'_>, out: &mut [[f64; 3]]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one force a node");
        self.forces(&call.elements_of::<M>(), &mut NodeVectors::new(&call.batch, out.as_mut_ptr().cast()))
    }

    fn call_tangent(
        &self,
        call: &Call<'_>,
        scale: TangentScale,
        slots: &[u32],
        out: &mut [[f64; 9]],
    ) -> Result<(), Fault> {
        let raw = raw_blocks(call, slots, out);
        self.tangent(&call.elements_of::<M>(), scale, &mut Blocks::new(&call.batch, &raw))
    }

    fn call_single_tangent(
        &self,
        call: &Call<'_>,
        scale: TangentScale,
        slots: &[u32],
        out: &mut [[f32; 9]],
    ) -> Result<(), Fault> {
        let raw = raw_single_blocks(call, slots, out);
        self.single_tangent(&call.elements_of::<M>(), scale, &mut SingleBlocks::new_single(&call.batch, &raw))
    }

    fn call_advance(&self, call: &Call<'_>, history: &mut [f64]) -> Result<(), Fault> {
        assert!(history.len() >= call.strides.history * call.batch.count, "planes of every element");
        self.advance(
            &call.elements_of::<M>(),
            &mut Planes::new(&call.batch, history.as_mut_ptr(), call.strides.history),
        )
    }

    fn call_failed(&self, call: &Call<'_>, out: &mut [u8]) -> Result<(), Fault> {
        let elements = call.elements_of::<M>();
        let own = elements.first_index()..elements.first_index() + elements.len();
        out[own].iter_mut().enumerate().for_each(|(e, out)| *out = u8::from(self.has_failed(&elements, e)));
        Ok(())
    }

    fn call_strain(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 13 * call.batch.count, "thirteen planes");
        self.strain(&call.elements_of::<M>(), &mut Planes::new(&call.batch, out.as_mut_ptr(), 13))
    }

    fn call_compliance(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 6 * call.batch.count, "six planes");
        self.compliance(&call.elements_of::<M>(), &mut Planes::new(&call.batch, out.as_mut_ptr(), 6))
    }

    fn call_normals_energy(&self, call: &Call<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault> {
        assert!(normals.len() >= call.batch.nodes, "one normal a node");
        self.normals_energy(&call.elements_of::<M>(), normals)
    }

    fn call_normals_forces(&self, call: &Call<'_>, normals: &[[f64; 3]], out: &mut [[f64; 6]]) -> Result<(), Fault> {
        assert!(normals.len() >= call.batch.nodes && out.len() >= call.batch.nodes, "one normal and result a node");
        self.normals_forces(
            &call.elements_of::<M>(),
            normals,
            &mut NormalForces::new(&call.batch, out.as_mut_ptr().cast()),
        )
    }

    fn call_tilt(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 3 * call.batch.count, "three planes");
        self.tilt(&call.elements_of::<M>(), &mut Planes::new(&call.batch, out.as_mut_ptr(), 3))
    }
}
