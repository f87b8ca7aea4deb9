//! Active materials: opening and element requests.

use crate::error::HostError;
use crate::instance::{Extension, Instance, ParamSettings};
use crate::library::Library;
use crate::messages::NewMessages;
use crate::plugin_info::{PluginInfo, PluginKind};
use pliant_plugin_api::ElementRequest;
use pliant_plugin_api::abi::{self, Status};

/// An active material; its force model is in `force_model.rs`.
pub struct Material {
    /// The plugin instance.
    pub(crate) instance: Instance,
    /// Function table of the material.
    pub(crate) table: &'static abi::Material,
    /// Element kinds that the material requests.
    pub(crate) requests: Vec<ElementRequest>,
    /// Strains of coupled hinges, if a request has them.
    pub(crate) coupled: Option<&'static abi::Coupled>,
    /// Energy of vertex normals, if requests ask for normals.
    pub(crate) normals: Option<&'static abi::Normals>,
    /// Elements that have failed, if those of a request may be.
    pub(crate) failure: Option<&'static abi::Failure>,
    /// Rest data of elements with fibre directions, if those of a request want them.
    pub(crate) directions: Option<&'static abi::Directions>,
    /// Stiffness in single precision, if a request offers it.
    pub(crate) single: Option<&'static abi::Single>,
}

/// Largest number of requests of a material.
const MAX_REQUESTS: u32 = 16;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Opens the material `name` of a library for steps of up to `dt` (s).
    ///
    /// # Errors
    /// Fails for a library without that material, a malformed table or request and refused parameters.
    pub fn open(library: &'static Library, name: &str, settings: &ParamSettings, dt: f64) -> Result<Self, HostError> {
        let info = library.plugin(PluginKind::Material, name)?;
        let extension = Extension::new::<abi::Material>(abi::MATERIAL);
        let instance = Instance::open(library, info, settings, dt, extension)?;
        // SAFETY: opened with the material extension.
        let table: &'static abi::Material = unsafe { instance.table() };
        let is_complete = table.elements.is_some()
            && table.rest.is_some()
            && table.mass.is_some()
            && table.energy.is_some()
            && table.forces.is_some()
            && table.tangent.is_some();
        if !is_complete {
            return Err(instance.error("extension", "the material's table has a null in it"));
        }
        let requests = Vec::new();
        let mut material = Self {
            instance,
            table,
            requests,
            coupled: None,
            normals: None,
            failure: None,
            directions: None,
            single: None,
        };
        material.read_requests()?;
        if material.requests.iter().any(|r| r.flags & abi::IS_COUPLED != 0) {
            let found = material.instance.extension_table(Extension::new::<abi::Coupled>(abi::COUPLED));
            // SAFETY: at least as large as the table, and lives as long as the library.
            let table = found.map(|table| unsafe { &*table.cast::<abi::Coupled>() });
            material.coupled = table.filter(|t| t.strain.is_some() && t.compliance.is_some());
            if material.coupled.is_none() {
                return Err(material.instance.error("extension", "coupled hinges without `pliant.coupled/1`"));
            }
        }
        material.read_normals()?;
        material.read_failure()?;
        material.read_directions()?;
        material.read_single()?;
        Ok(material)
    }

    /// Reads the element requests.
    fn read_requests(&mut self) -> Result<(), HostError> {
        let elements = self.table.elements.expect("checked");
        for index in 0..MAX_REQUESTS {
            let mut raw = abi::ElementRequest {
                size: size_of::<abi::ElementRequest>(),
                kind: 0,
                families: 0,
                flags: 0,
                rest_stride: 0,
                history_stride: 0,
            };
            // SAFETY: [main & active]; `raw` is ours to fill.
            match self.instance.within("elements", || unsafe { elements(self.instance.plugin(), index, &mut raw) }) {
                Status::UNSUPPORTED => break,
                status => self.instance.check("elements", status)?,
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

    /// Whether the material panicked in a call; it must not be called again.
    pub fn is_quarantined(&self) -> bool {
        self.instance.is_quarantined()
    }

    /// Messages of the material since the last call.
    pub fn messages(&self) -> NewMessages {
        self.instance.messages()
    }

    /// Descriptor of the plugin.
    pub fn info(&self) -> &'static PluginInfo {
        self.instance.info(PluginKind::Material)
    }

    /// Library of the plugin.
    pub fn library(&self) -> &'static Library {
        self.instance.library()
    }
}
