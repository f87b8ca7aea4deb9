//! Energy of vertex normals of a material (`pliant.normals/1`).

use crate::error::HostError;
use crate::instance::Extension;
use crate::material::Material;
use pliant_plugin_api::abi;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Looks up the table of functions if requests ask for normals.
    ///
    /// # Errors
    /// Fails if only one of triangles and hinges asks for normals, and for a missing or incomplete table.
    pub(crate) fn read_normals(&mut self) -> Result<(), HostError> {
        let wants = |kind: u32| self.requests.iter().any(|r| r.kind == kind && r.flags & abi::WANTS_NORMALS != 0);
        let (triangles, hinges) = (wants(abi::TRIANGLE), wants(abi::HINGE));
        if triangles != hinges {
            return Err(self.instance.error("elements", "triangles and hinges want normals together"));
        }
        if triangles {
            let found = self.instance.extension_table(Extension::new::<abi::Normals>(abi::NORMALS));
            // SAFETY: at least as large as the table, and lives as long as the library.
            let table = found.map(|table| unsafe { &*table.cast::<abi::Normals>() });
            self.normals = table.filter(|t| t.energy.is_some() && t.forces.is_some() && t.tilt.is_some());
            if self.normals.is_none() {
                return Err(self.instance.error("extension", "normals without `pliant.normals/1`"));
            }
        }
        Ok(())
    }

    /// The table of functions of a material that asks for normals.
    ///
    /// # Panics
    /// If it does not.
    pub(crate) fn normals(&self) -> &'static abi::Normals {
        self.normals.expect("checked when it was opened")
    }
}
