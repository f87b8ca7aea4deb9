//! Fibre directions that a material takes (`pliant.directions/1`).

use crate::error::HostError;
use crate::instance::Extension;
use crate::material::Material;
use pliant_plugin_api::abi;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Whether elements take fibre directions.
    pub fn takes_directions(&self) -> bool {
        self.directions.is_some()
    }

    /// Looks up the table of functions if elements of a request want directions.
    ///
    /// # Errors
    /// Fails for a request of other elements than tetrahedra or without rest data, and for a missing or incomplete table.
    pub(crate) fn read_directions(&mut self) -> Result<(), HostError> {
        let mut wanting = self.requests.iter().filter(|r| r.flags & abi::WANTS_DIRECTIONS != 0).peekable();
        if wanting.peek().is_none() {
            return Ok(());
        }
        if wanting.any(|r| r.kind != abi::TETRAHEDRON || r.rest_stride == 0) {
            let text = "directions of elements that are no tetrahedra, or have no rest data to keep them";
            return Err(self.instance.error("elements", text));
        }
        let found = self.instance.extension_table(Extension::new::<abi::Directions>(abi::DIRECTIONS));
        // SAFETY: at least as large as the table, and lives as long as the library.
        let table = found.map(|table| unsafe { &*table.cast::<abi::Directions>() });
        self.directions = table.filter(|t| t.rest.is_some());
        match self.directions {
            Some(_) => Ok(()),
            None => Err(self.instance.error("extension", "directions without `pliant.directions/1`")),
        }
    }
}
