//! What a test body asks of a material, whether it is a Rust type or an instance behind the border.

use crate::abi;
use crate::batch::{Elements, NodeScalars, NodeVectors, Planes};
use crate::blocks::{Blocks, SingleBlocks};
use crate::fault::Fault;
use crate::material::{ElementRequest, Material, Tangent};
use crate::normals::NormalForces;
use core::marker::PhantomData;

/// One call: only a test body makes them, so the spans in it hold.
pub struct Call<'a> {
    pub(super) batch: abi::Batch,
    pub(super) borrowed: PhantomData<&'a f64>,
}

impl Call<'_> {
    /// The elements it is about.
    pub fn elements(&self) -> Elements<'_> {
        Elements(&self.batch)
    }
}

/// A material under test. Every [`Material`] is one, and so is [`super::Opened`].
pub trait Subject {
    /// The kinds of elements wanted.
    ///
    /// # Errors
    /// What the material says.
    fn wants(&self) -> Result<Vec<ElementRequest>, Fault>;

    /// Writes rest data (stride x m).
    ///
    /// # Errors
    /// What the material says.
    fn rest_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// Adds masses, kg (n).
    ///
    /// # Errors
    /// What the material says.
    fn mass_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// J
    ///
    /// # Errors
    /// What the material says.
    fn energy_of(&self, call: &Call<'_>) -> Result<f64, Fault>;

    /// Adds forces, N (n x 3).
    ///
    /// # Errors
    /// What the material says.
    fn forces_of(&self, call: &Call<'_>, out: &mut [[f64; 3]]) -> Result<(), Fault>;

    /// Adds blocks, N/m, where `slots` (m x pairs) says.
    ///
    /// # Errors
    /// What the material says.
    fn tangent_of(&self, call: &Call<'_>, scale: Tangent, slots: &[u32], out: &mut [[f64; 9]]) -> Result<(), Fault>;

    /// Adds blocks of two corners in single precision, N/m, likewise.
    ///
    /// # Errors
    /// What the material says.
    fn single_tangent_of(
        &self,
        call: &Call<'_>,
        scale: Tangent,
        slots: &[u32],
        out: &mut [[f32; 9]],
    ) -> Result<(), Fault>;

    /// Writes strains of coupled hinges and their gradients (13 x m).
    ///
    /// # Errors
    /// What the material says.
    fn strain_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// Writes compliances between the sides of triangles, m/N (6 x m).
    ///
    /// # Errors
    /// What the material says.
    fn compliance_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;

    /// Energy of the sheet's unit `normals` (n x 3), J.
    ///
    /// # Errors
    /// What the material says.
    fn normals_energy_of(&self, call: &Call<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault>;

    /// Adds its forces at fixed normals, N, and its slopes in them, J (n x 6).
    ///
    /// # Errors
    /// What the material says.
    fn normals_forces_of(&self, call: &Call<'_>, normals: &[[f64; 3]], out: &mut [[f64; 6]]) -> Result<(), Fault>;

    /// Writes how stiffly normals tilt across the sides of triangles, N m (3 x m).
    ///
    /// # Errors
    /// What the material says.
    fn tilt_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault>;
}

/// Checks the slots of a call.
fn check(call: &Call<'_>, slots: &[u32], blocks: usize) {
    let corners = call.batch.corners as usize;
    assert!(slots.len() >= call.batch.count * corners * (corners + 1) / 2, "a slot for every pair of every element");
    assert!(slots.iter().all(|s| ((s & !abi::TRANSPOSED) as usize) < blocks), "a slot there is not");
}

/// The blocks of a call as they cross the border in single precision.
pub(super) fn raw_single_blocks(call: &Call<'_>, slots: &[u32], out: &mut [[f32; 9]]) -> abi::SingleBlocks {
    check(call, slots, out.len());
    abi::SingleBlocks {
        size: size_of::<abi::SingleBlocks>(),
        values: out.as_mut_ptr().cast(),
        slots: slots.as_ptr(),
        slot_begin: 0,
        slot_end: out.len(),
    }
}

/// The blocks of a call as they cross the border.
pub(super) fn raw_blocks(call: &Call<'_>, slots: &[u32], out: &mut [[f64; 9]]) -> abi::Blocks {
    check(call, slots, out.len());
    abi::Blocks {
        size: size_of::<abi::Blocks>(),
        values: out.as_mut_ptr().cast(),
        slots: slots.as_ptr(),
        slot_begin: 0,
        slot_end: out.len(),
    }
}

impl<M: Material> Subject for M {
    fn wants(&self) -> Result<Vec<ElementRequest>, Fault> {
        Ok(self.elements())
    }

    fn rest_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        self.rest(&call.elements(), &mut Planes::new(&call.batch, out.as_mut_ptr()))
    }

    fn mass_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one mass a node");
        self.mass(&call.elements(), &mut NodeScalars::new(&call.batch, out.as_mut_ptr()))
    }

    fn energy_of(&self, call: &Call<'_>) -> Result<f64, Fault> {
        self.energy(&call.elements())
    }

    fn forces_of(&self, call: &Call<'_>, out: &mut [[f64; 3]]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one force a node");
        self.forces(&call.elements(), &mut NodeVectors::new(&call.batch, out.as_mut_ptr().cast()))
    }

    fn tangent_of(&self, call: &Call<'_>, scale: Tangent, slots: &[u32], out: &mut [[f64; 9]]) -> Result<(), Fault> {
        let raw = raw_blocks(call, slots, out);
        self.tangent(&call.elements(), scale, &mut Blocks::new(&call.batch, &raw))
    }

    fn single_tangent_of(
        &self,
        call: &Call<'_>,
        scale: Tangent,
        slots: &[u32],
        out: &mut [[f32; 9]],
    ) -> Result<(), Fault> {
        let raw = raw_single_blocks(call, slots, out);
        self.single_tangent(&call.elements(), scale, &mut SingleBlocks::single(&call.batch, &raw))
    }

    fn strain_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 13 * call.batch.count, "thirteen planes");
        self.strain(&call.elements(), &mut Planes::new(&call.batch, out.as_mut_ptr()))
    }

    fn compliance_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 6 * call.batch.count, "six planes");
        self.compliance(&call.elements(), &mut Planes::new(&call.batch, out.as_mut_ptr()))
    }

    fn normals_energy_of(&self, call: &Call<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault> {
        assert!(normals.len() >= call.batch.nodes, "one normal a node");
        self.normals_energy(&call.elements(), normals)
    }

    fn normals_forces_of(&self, call: &Call<'_>, normals: &[[f64; 3]], out: &mut [[f64; 6]]) -> Result<(), Fault> {
        assert!(normals.len() >= call.batch.nodes && out.len() >= call.batch.nodes, "one normal and result a node");
        self.normals_forces(&call.elements(), normals, &mut NormalForces::new(&call.batch, out.as_mut_ptr().cast()))
    }

    fn tilt_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 3 * call.batch.count, "three planes");
        self.tilt(&call.elements(), &mut Planes::new(&call.batch, out.as_mut_ptr()))
    }
}
