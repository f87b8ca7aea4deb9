//! Safe calls into a material's stiffness in single precision.

use super::error::HostError;
use super::material::{Call, Material};
use pliant_plugin_api::{Tangent, abi};

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Takes the table where a request has it.
    pub(super) fn read_single(&mut self) -> Result<(), HostError> {
        let has = |flag: u32| self.requests.iter().filter(move |r| r.flags & flag != 0);
        if has(abi::HAS_SINGLE).count() == 0 {
            return Ok(());
        }
        if has(abi::HAS_SINGLE).any(|r| r.flags & abi::HAS_FORCES == 0 || r.kind == abi::POINT) {
            return Err(self.instance.error("elements", "single precision without forces, or of points"));
        }
        let found = self.instance.other_table(abi::SINGLE, size_of::<abi::Single>());
        // SAFETY: at least as large as the table, and lives as long as the library.
        let table = found.map(|table| unsafe { &*table.cast::<abi::Single>() });
        self.single = table.filter(|t| t.tangent.is_some());
        if self.single.is_none() {
            return Err(self.instance.error("extension", "single precision without `pliant.single/1`"));
        }
        Ok(())
    }

    /// Whether all stiffness there is can be had in single precision.
    pub fn has_single(&self) -> bool {
        let mut forces = self.requests.iter().filter(|r| r.flags & abi::HAS_FORCES != 0);
        self.normals.is_none() && forces.all(|r| r.flags & abi::HAS_SINGLE != 0)
    }

    /// As [`Material::tangent`], in single precision and without the blocks of the diagonal. `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn single_tangent(
        &self,
        call: &Call<'_>,
        Tangent { stiffness, damping }: Tangent,
        slots: &[u32],
        first: usize,
        values: &mut [[f32; 9]],
    ) -> Result<(), HostError> {
        debug_assert_eq!(slots.len(), call.elements.len() / call.corners * (call.corners * (call.corners + 1) / 2));
        let tangent = self.single.and_then(|table| table.tangent).expect("checked when it was opened");
        let blocks = abi::SingleBlocks {
            size: size_of::<abi::SingleBlocks>(),
            values: values.as_mut_ptr().wrapping_sub(first).cast(),
            slots: slots.as_ptr(),
            slot_begin: first,
            slot_end: first + values.len(),
        };
        // SAFETY: [sim & active]; the blocks behind `values` are ours for the call.
        let status = unsafe { tangent(self.instance.plugin(), &call.batch(), stiffness, damping, &blocks) };
        self.instance.done("single_tangent", status)
    }
}
