//! Elements that a material says have failed (`pliant.failure/1`).

use crate::error::HostError;
use crate::instance::Extension;
use crate::material::Material;
use pliant_plugin_api::abi;

/// Flags of requests whose elements cannot fail: what they do is spread over their neighbours.
const SPREAD: u32 = abi::IS_COUPLED | abi::WANTS_NORMALS;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Looks up the table of functions if elements of a request may fail.
    ///
    /// # Errors
    /// Fails for a request without history or with coupled bending or normals, and for a missing or incomplete table.
    pub(crate) fn read_failure(&mut self) -> Result<(), HostError> {
        let mut failing = self.requests.iter().filter(|r| r.flags & abi::CAN_FAIL != 0).peekable();
        if failing.peek().is_none() {
            return Ok(());
        }
        if failing.any(|r| r.flags & abi::HAS_HISTORY == 0 || r.history_stride == 0 || r.flags & SPREAD != 0) {
            let text = "elements that can fail need a history, and have neither coupled bending nor normals";
            return Err(self.instance.error("elements", text));
        }
        if self.info().whole_lists {
            let text =
                "elements that can fail, where calls are to have whole lists: those that have failed are left out";
            return Err(self.instance.error("elements", text));
        }
        let found = self.instance.extension_table(Extension::new::<abi::Failure>(abi::FAILURE));
        // SAFETY: at least as large as the table, and lives as long as the library.
        let table = found.map(|table| unsafe { &*table.cast::<abi::Failure>() });
        self.failure = table.filter(|t| t.failed.is_some());
        match self.failure {
            Some(_) => Ok(()),
            None => Err(self.instance.error("extension", "elements that can fail without `pliant.failure/1`")),
        }
    }
}
