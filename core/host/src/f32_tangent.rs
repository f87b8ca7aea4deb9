//! Stiffness of a material in single precision (`pliant.single/1`).

use crate::error::HostError;
use crate::instance::Extension;
use crate::material::Material;
use pliant_plugin_api::abi;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Looks up the table of functions if a request offers stiffness in single precision.
    ///
    /// # Errors
    /// Fails for a request without forces or of points, and for a missing or incomplete table.
    pub(crate) fn read_single(&mut self) -> Result<(), HostError> {
        let has = |flag: u32| self.requests.iter().filter(move |r| r.flags & flag != 0);
        if has(abi::HAS_SINGLE).count() == 0 {
            return Ok(());
        }
        if has(abi::HAS_SINGLE).any(|r| r.flags & abi::HAS_FORCES == 0 || r.kind == abi::POINT) {
            return Err(self.instance.error("elements", "single precision without forces, or of points"));
        }
        let found = self.instance.extension_table(Extension::new::<abi::Single>(abi::SINGLE));
        // SAFETY: at least as large as the table, and lives as long as the library.
        let table = found.map(|table| unsafe { &*table.cast::<abi::Single>() });
        self.single = table.filter(|t| t.tangent.is_some());
        if self.single.is_none() {
            return Err(self.instance.error("extension", "single precision without `pliant.single/1`"));
        }
        Ok(())
    }
}
