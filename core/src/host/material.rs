//! Safe calls into a material.

use super::error::HostError;
use super::instance::{Instance, Settings};
use super::library::Library;
use super::planes::Planes;
use super::plugin::{Kind, PluginInfo};
use super::report::Message;
use pliant_plugin_api::abi::{self, Batch, Status};
use pliant_plugin_api::{ElementRequest, Tangent};
use std::ops::Range;
use std::ptr::null;

/// One call: a range of the elements of one kind, and the state they are in.
#[derive(Clone, Debug)]
pub struct Call<'a> {
    /// [`abi::POINT`], [`abi::LINK`], ...
    pub kind: u32,
    /// Nodes of each element.
    pub corners: usize,
    /// Elements of this call.
    pub range: Range<usize>,
    /// Nodes they touch: all of their corners lie in it.
    pub window: Range<usize>,
    /// (m x k)
    pub elements: &'a [u32],
    /// (m), or empty
    pub family: &'a [u32],
    /// (m)
    pub measure: &'a [f64],
    /// m (m x k x 2), or empty
    pub material: &'a [f64],
    /// m (n x 3)
    pub rest: &'a [[f64; 3]],
    /// m (n x 3)
    pub x: &'a [[f64; 3]],
    /// m/s (n x 3)
    pub v: &'a [[f64; 3]],
    /// (stride x m)
    pub rest_data: &'a [f64],
    /// (stride x m)
    pub history: &'a [f64],
    /// Of the state.
    pub time: StepTime,
}

/// When a step begins and how long it is, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepTime {
    /// When the state is that of the nodes.
    pub start: f64,
    /// From there to the next.
    pub dt: f64,
}

impl StepTime {
    /// s
    pub fn end(self) -> f64 {
        self.start + self.dt
    }
}

impl Call<'_> {
    /// Checks in debug builds what the border promises to plugins.
    pub(super) fn batch(&self) -> Batch {
        let count = self.elements.len() / self.corners;
        debug_assert!(self.range.end <= count && self.window.end <= self.x.len());
        debug_assert!(self.family.is_empty() || self.family.len() == count);
        debug_assert!(self.measure.len() == count);
        debug_assert!(self.material.is_empty() || self.material.len() == 2 * self.elements.len());
        debug_assert!(self.rest.len() == self.x.len() && self.v.len() == self.x.len());
        debug_assert!(
            self.elements[self.range.start * self.corners..self.range.end * self.corners]
                .iter()
                .all(|&n| self.window.contains(&(n as usize)))
        );
        let or_null = |slice: &[f64]| if slice.is_empty() { null() } else { slice.as_ptr() };
        Batch {
            size: size_of::<Batch>(),
            kind: self.kind,
            corners: self.corners as u32,
            begin: self.range.start,
            end: self.range.end,
            count,
            node_begin: self.window.start,
            node_end: self.window.end,
            nodes: self.x.len(),
            elements: self.elements.as_ptr(),
            family: if self.family.is_empty() { null() } else { self.family.as_ptr() },
            measure: self.measure.as_ptr(),
            material: or_null(self.material),
            rest: self.rest.as_ptr().cast(),
            x: self.x.as_ptr().cast(),
            v: self.v.as_ptr().cast(),
            rest_data: or_null(self.rest_data),
            history: or_null(self.history),
            time: self.time.start,
            dt: self.time.dt,
        }
    }
}

/// An active material.
pub struct Material {
    pub(super) instance: Instance,
    table: &'static abi::Material,
    pub(super) requests: Vec<ElementRequest>,
    coupled: Option<&'static abi::Coupled>,
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

    /// The kinds of elements it wants.
    pub fn requests(&self) -> &[ElementRequest] {
        &self.requests
    }

    /// Writes rest data of the call's range into `out` (stride x m). `[sim]`
    ///
    /// # Errors
    /// What the material says, or a value that is not finite.
    pub fn rest(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), HostError> {
        let rest = self.table.rest.expect("checked");
        // SAFETY: [sim & active]; `out` holds the planes of all elements.
        self.instance.done("rest", unsafe { rest(self.instance.plugin(), &call.batch(), out.as_mut_ptr()) })
    }

    /// Adds masses, kg, into `out`, the window of the call. `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn mass(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), HostError> {
        assert_eq!(out.len(), call.window.len());
        let (mass, base) = (self.table.mass.expect("checked"), out.as_mut_ptr().wrapping_sub(call.window.start));
        // SAFETY: [sim & active]; the window behind `base` is `out`, all ours.
        self.instance.done("mass", unsafe { mass(self.instance.plugin(), &call.batch(), base) })
    }

    /// Energy of the call's range, J. `[sim]`
    ///
    /// # Errors
    /// What the material says, or a value that is not finite.
    pub fn energy(&self, call: &Call<'_>) -> Result<f64, HostError> {
        let (energy, mut sum) = (self.table.energy.expect("checked"), 0.0);
        // SAFETY: [sim & active]; `sum` is ours.
        let status = unsafe { energy(self.instance.plugin(), &call.batch(), &mut sum) };
        self.instance.done("energy", status)?;
        if sum.is_finite() { Ok(sum) } else { Err(self.instance.error("energy", &format!("the result is {sum} J"))) }
    }

    /// Adds forces, N, into `out`, the window of the call. `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn forces(&self, call: &Call<'_>, out: &mut [[f64; 3]]) -> Result<(), HostError> {
        assert_eq!(out.len(), call.window.len());
        let (forces, base) = (self.table.forces.expect("checked"), out.as_mut_ptr().wrapping_sub(call.window.start));
        // SAFETY: [sim & active]; the window behind `base` is `out`, all ours.
        self.instance.done("forces", unsafe { forces(self.instance.plugin(), &call.batch(), base.cast()) })
    }

    /// Adds `stiffness` K + `damping` C to the blocks `first..` that `values` holds, where `slots` (m x pairs) says. `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn tangent(
        &self,
        call: &Call<'_>,
        Tangent { stiffness, damping }: Tangent,
        slots: &[u32],
        first: usize,
        values: &mut [[f64; 9]],
    ) -> Result<(), HostError> {
        debug_assert_eq!(slots.len(), call.elements.len() / call.corners * (call.corners * (call.corners + 1) / 2));
        let tangent = self.table.tangent.expect("checked");
        let blocks = abi::Blocks {
            size: size_of::<abi::Blocks>(),
            values: values.as_mut_ptr().wrapping_sub(first).cast(),
            slots: slots.as_ptr(),
            slot_begin: first,
            slot_end: first + values.len(),
        };
        // SAFETY: [sim & active]; the blocks behind `values` are ours for the call.
        let status = unsafe { tangent(self.instance.plugin(), &call.batch(), stiffness, damping, &blocks) };
        self.instance.done("tangent", status)
    }

    /// Brings history (stride x m) of the call's range up to date. `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn advance(&self, call: &Call<'_>, history: &mut [f64]) -> Result<(), HostError> {
        let Some(advance) = self.table.advance else { return Ok(()) };
        // SAFETY: [sim & active]; `history` holds the planes of all elements.
        self.instance.done("advance", unsafe { advance(self.instance.plugin(), &call.batch(), history.as_mut_ptr()) })
    }

    /// The error of a result of `call` for a node that is not finite.
    pub fn not_finite(&self, call: &'static str, node: usize) -> HostError {
        self.instance.error(call, &format!("the result for node {node} is not finite"))
    }

    /// Writes strain and its gradient of the call's range of coupled hinges into `planes`, 13. `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn strain(&self, call: &Call<'_>, planes: &mut Planes<'_>) -> Result<(), HostError> {
        let strain = self.coupled.and_then(|table| table.strain).expect("checked when it was opened");
        let base = planes.base_for(&call.range, (13, call.elements.len() / call.corners));
        // SAFETY: [sim & active]; `planes` holds the planes of all elements, and those of the call's range, which are all that the
        // call writes, are ours.
        self.instance.done("strain", unsafe { strain(self.instance.plugin(), &call.batch(), base) })
    }

    /// Writes the compliance of the call's range of coupled triangles into `planes` (6 x m). `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn compliance(&self, call: &Call<'_>, planes: &mut [f64]) -> Result<(), HostError> {
        let compliance = self.coupled.and_then(|table| table.compliance).expect("checked when it was opened");
        // SAFETY: [sim & active]; `planes` holds the planes of all elements.
        let status = unsafe { compliance(self.instance.plugin(), &call.batch(), planes.as_mut_ptr()) };
        self.instance.done("compliance", status)
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
