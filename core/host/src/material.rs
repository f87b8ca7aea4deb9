//! Safe calls into a material.

use super::error::HostError;
use super::instance::{Instance, Settings};
use super::library::Library;
use super::plugin::{Kind, PluginInfo};
use super::report::Message;
use pliant_plugin_api::ElementRequest;
use pliant_plugin_api::abi::{self, Status};

/// An active material.
pub struct Material {
    pub(super) instance: Instance,
    pub(super) table: &'static abi::Material,
    pub(super) requests: Vec<ElementRequest>,
    pub(super) coupled: Option<&'static abi::Coupled>,
    pub(super) normals: Option<&'static abi::Normals>,
    pub(super) single: Option<&'static abi::Single>,
}

/// The most kinds of elements a material may want.
const MOST_REQUESTS: u32 = 16;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Opens a material. `dt` (s) is the longest step that will be asked for.
    ///
    /// # Errors
    /// Whatever the plugin or its tables have wrong.
    pub fn open(library: &'static Library, name: &str, settings: &Settings, dt: f64) -> Result<Self, HostError> {
        let info = library.plugin(Kind::Material, name)?;
        let size = size_of::<abi::Material>();
        let instance = Instance::open(library, info, settings, dt, abi::MATERIAL, size)?;
        // SAFETY: opened with the material extension.
        let table: &'static abi::Material = unsafe { instance.table() };
        let whole = table.elements.is_some()
            && table.rest.is_some()
            && table.mass.is_some()
            && table.energy.is_some()
            && table.forces.is_some()
            && table.tangent.is_some();
        if !whole {
            return Err(instance.error("extension", "the material's table has a null in it"));
        }
        let mut material = Self { instance, table, requests: Vec::new(), coupled: None, normals: None, single: None };
        material.read_requests()?;
        if material.requests.iter().any(|r| r.flags & abi::IS_COUPLED != 0) {
            let found = material.instance.other_table(abi::COUPLED, size_of::<abi::Coupled>());
            // SAFETY: at least as large as the table, and lives as long as the library.
            let table = found.map(|table| unsafe { &*table.cast::<abi::Coupled>() });
            material.coupled = table.filter(|t| t.strain.is_some() && t.compliance.is_some());
            if material.coupled.is_none() {
                return Err(material.instance.error("extension", "coupled hinges without `pliant.coupled/1`"));
            }
        }
        material.read_normals()?;
        material.read_single()?;
        Ok(material)
    }

    fn read_requests(&mut self) -> Result<(), HostError> {
        let elements = self.table.elements.expect("checked");
        for index in 0..MOST_REQUESTS {
            let mut raw = abi::ElementRequest {
                size: size_of::<abi::ElementRequest>(),
                kind: 0,
                families: 0,
                flags: 0,
                rest_stride: 0,
                history_stride: 0,
            };
            // SAFETY: [main & active]; `raw` is ours to fill.
            match unsafe { elements(self.instance.plugin(), index, &mut raw) } {
                Status::UNSUPPORTED => break,
                status => self.instance.done("elements", status)?,
            }
            if !(abi::POINT..=abi::TETRAHEDRON).contains(&raw.kind) {
                return Err(self.instance.error("elements", &format!("unknown element kind {}", raw.kind)));
            }
            if raw.flags & abi::HAS_HISTORY != 0 && self.table.advance.is_none() {
                return Err(self.instance.error("elements", "history without `advance`"));
            }
            let abi::ElementRequest { kind, families, flags, rest_stride, history_stride, .. } = raw;
            self.requests.push(ElementRequest { kind, families, flags, rest_stride, history_stride });
        }
        if self.requests.iter().all(|r| r.flags & abi::HAS_MASS == 0) {
            return Err(self.instance.error("elements", "no element kind gives mass"));
        }
        Ok(())
    }

    /// Whether it panicked and is not to be called again.
    pub fn is_quarantined(&self) -> bool {
        self.instance.is_quarantined()
    }

    /// What it said since the last time, and how many lines were lost.
    pub fn messages(&self) -> (Vec<Message>, u64) {
        self.instance.messages()
    }

    /// Its descriptor.
    pub fn info(&self) -> &'static PluginInfo {
        self.instance.info(Kind::Material)
    }

    /// Its library.
    pub fn library(&self) -> &'static Library {
        self.instance.library()
    }
}
