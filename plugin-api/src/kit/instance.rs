//! An instance under test, and safe calls through its C tables.
#![allow(unsafe_code, reason = "plays the host")]

use super::candidate::Candidate;
use super::tested_material::{Call, MaterialUnderTest, raw_blocks, raw_single_blocks};
use crate::abi::{self, Status};
use crate::fault::Fault;
use crate::material::{ElementRequest, TangentScale};
use core::ffi::{CStr, c_char, c_void};
use std::sync::Mutex;

/// An instance of a plugin under test. Dropping it deactivates and destroys it.
pub struct TestInstance {
    plugin: *const abi::Plugin,
    host: Box<abi::Host>,
    last_error: Box<LastError>,
    active: bool,
}

/// The last error line the plugin reported, in a fixed buffer so that a report does not allocate.
struct LastError(Mutex<Line>);

/// A line of text in a fixed buffer.
struct Line {
    len: usize,
    bytes: [u8; 256],
}

/// The host's `report`: keeps the last error.
unsafe extern "C" fn report(host: *const abi::Host, severity: u32, text: *const c_char) {
    if severity != abi::ERROR || text.is_null() {
        return;
    }
    // SAFETY: `data` is the `LastError` of the instance, which outlives it; `text` is a C string.
    let (last, text) = unsafe { (&*(*host).data.cast::<LastError>(), CStr::from_ptr(text).to_bytes()) };
    if let Ok(mut line) = last.0.try_lock() {
        let len = text.len().min(line.bytes.len());
        line.len = len;
        line.bytes[..len].copy_from_slice(&text[..len]);
    }
}

/// A host that keeps errors in `last_error`, which must outlive it.
fn host_table(last_error: &LastError) -> Box<abi::Host> {
    Box::new(abi::Host {
        size: size_of::<abi::Host>(),
        abi_major: abi::ABI_MAJOR,
        abi_minor: abi::ABI_MINOR,
        data: core::ptr::from_ref(last_error).cast_mut().cast(),
        report: Some(report),
    })
}

impl TestInstance {
    /// An instance with default parameters, not active yet.
    pub(super) fn new(candidate: &Candidate) -> Result<Self, Fault> {
        Self::with_id(candidate, candidate.id())
    }

    /// As [`TestInstance::new`], asking the candidate's library for the plugin `id`.
    pub(super) fn with_id(candidate: &Candidate, id: &CStr) -> Result<Self, Fault> {
        let last_error = Box::new(LastError(Mutex::new(Line { len: 0, bytes: [0; 256] })));
        let host = host_table(&last_error);
        let plugin = candidate.create(&raw const *host, id);
        if plugin.is_null() {
            return Err(Fault::unsupported("`create` refused"));
        }
        let instance = Self { plugin, host, last_error, active: false };
        let t = instance.table();
        let complete = t.size >= size_of::<abi::Plugin>()
            && t.destroy.is_some()
            && t.set_number.is_some()
            && t.set_text.is_some()
            && t.set_table.is_some()
            && t.activate.is_some()
            && t.deactivate.is_some()
            && t.extension.is_some();
        if complete {
            Ok(instance)
        } else {
            Err(Fault::bad_argument("the instance's table is too small or has a null in it"))
        }
    }

    /// The instance's C struct.
    fn table(&self) -> &abi::Plugin {
        // SAFETY: `create` gave it, and it lives until `destroy`.
        unsafe { &*self.plugin }
    }

    /// Takes the last error line the plugin reported; empty where there is none.
    fn take_last_error(&self) -> String {
        let mut line = self.last_error.0.lock().unwrap_or_else(|p| p.into_inner());
        let text = String::from_utf8_lossy(&line.bytes[..line.len]).into_owned();
        line.len = 0;
        text
    }

    /// Turns a status into a fault with the last error line.
    pub(super) fn check(&self, status: Status) -> Result<(), Fault> {
        if status == Status::OK {
            return Ok(());
        }
        Err(Fault { status, reason: self.take_last_error().into() })
    }

    /// Sets a number or choice by parameter index.
    ///
    /// # Errors
    /// The plugin's fault.
    pub fn set(&mut self, index: u32, value: f64) -> Result<(), Fault> {
        let set = self.table().set_number.expect("checked");
        // SAFETY: [main & !active]: `&mut`, and the suite activates last.
        self.check(unsafe { set(self.plugin, index, value) })
    }

    /// Activates the instance.
    pub(super) fn activate(&mut self) -> Result<(), Fault> {
        let limits = abi::Limits { size: size_of::<abi::Limits>(), dt: 1e-3 };
        let activate = self.table().activate.expect("checked");
        // SAFETY: [main & !active].
        self.check(unsafe { activate(self.plugin, &limits) })?;
        self.active = true;
        Ok(())
    }

    /// The function table of an extension, which must be at least as large as `T`; `None` where it is not offered.
    pub(super) fn extension<T>(&self, id: &CStr) -> Result<Option<&'static T>, Fault> {
        let get = self.table().extension.expect("checked");
        // SAFETY: [any]; null or a table that starts with its size and lives as long as the library.
        let found = unsafe { get(self.plugin, id.as_ptr()) };
        if found.is_null() {
            return Ok(None);
        }
        // SAFETY: as above.
        if unsafe { *found.cast::<usize>() } < size_of::<T>() {
            return Err(Fault::bad_argument(format!("table `{}` is too small", id.to_string_lossy())));
        }
        // SAFETY: as above.
        Ok(Some(unsafe { &*found.cast::<T>() }))
    }

    /// The instance pointer, the first argument of every call.
    pub(super) fn raw(&self) -> *const abi::Plugin {
        self.plugin
    }

    /// Table of [`abi::MATERIAL`].
    fn material(&self) -> Result<&'static abi::Material, Fault> {
        self.extension::<abi::Material>(abi::MATERIAL)?.ok_or(Fault::unsupported("`pliant.material/1` is not offered"))
    }

    /// Table of [`abi::COUPLED`].
    fn coupled(&self) -> Result<&'static abi::Coupled, Fault> {
        self.extension::<abi::Coupled>(abi::COUPLED)?.ok_or(Fault::unsupported("`pliant.coupled/1` is not offered"))
    }

    /// Table of [`abi::FAILURE`].
    fn failure(&self) -> Result<&'static abi::Failure, Fault> {
        self.extension::<abi::Failure>(abi::FAILURE)?.ok_or(Fault::unsupported("`pliant.failure/1` is not offered"))
    }

    /// Table of [`abi::NORMALS`].
    fn normals(&self) -> Result<&'static abi::Normals, Fault> {
        self.extension::<abi::Normals>(abi::NORMALS)?.ok_or(Fault::unsupported("`pliant.normals/1` is not offered"))
    }
}

impl Drop for TestInstance {
    fn drop(&mut self) {
        let (deactivate, destroy) = (self.table().deactivate, self.table().destroy);
        // SAFETY: [main]; the instance has no other user. The host table is freed after it.
        unsafe {
            if let (true, Some(deactivate)) = (self.active, deactivate) {
                deactivate(self.plugin);
            }
            if let Some(destroy) = destroy {
                destroy(self.plugin);
            }
        }
        assert!(!self.host.data.is_null());
        self.host.data = core::ptr::null_mut::<c_void>();
    }
}

/// A function of a table, or a fault where it is null.
fn non_null<F>(function: Option<F>) -> Result<F, Fault> {
    function.ok_or(Fault::bad_argument("the material's table has a null in it"))
}

/// The most element kinds a material may request, as in the host.
const MAX_REQUESTS: u32 = 16;

// SAFETY of every call below: [sim & active] (`elements`: [main & active]) on one thread, with a batch that a test body made
// for the call and output of the size the header states.
impl MaterialUnderTest for TestInstance {
    fn element_requests(&self) -> Result<Vec<ElementRequest>, Fault> {
        let elements = non_null(self.material()?.elements)?;
        let mut requests = Vec::new();
        for index in 0..MAX_REQUESTS {
            let size = size_of::<abi::ElementRequest>();
            let mut raw =
                abi::ElementRequest { size, kind: 0, families: 0, flags: 0, rest_stride: 0, history_stride: 0 };
            // SAFETY: see above.
            match unsafe { elements(self.plugin, index, &mut raw) } {
                Status::UNSUPPORTED => break,
                status => self.check(status)?,
            }
            if !(abi::POINT..=abi::TETRAHEDRON).contains(&raw.kind) {
                return Err(Fault::bad_argument(format!("unknown element kind {}", raw.kind)));
            }
            let abi::ElementRequest { kind, families, flags, rest_stride, history_stride, .. } = raw;
            requests.push(ElementRequest { kind, families, flags, rest_stride, history_stride });
        }
        self.take_last_error(); // the last request ends with a fault
        Ok(requests)
    }

    fn call_rest(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        let rest = non_null(self.material()?.rest)?;
        // SAFETY: see above.
        self.check(unsafe { rest(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn call_directed_rest(&self, call: &Call<'_>, directions: &[[f64; 3]], out: &mut [f64]) -> Result<(), Fault> {
        assert!(directions.len() >= call.batch.count, "a direction for each element");
        let table = self.extension::<abi::Directions>(abi::DIRECTIONS)?;
        let rest = non_null(table.ok_or(Fault::unsupported("`pliant.directions/1` is not offered"))?.rest)?;
        // SAFETY: see above.
        self.check(unsafe { rest(self.plugin, &call.batch, directions.as_ptr().cast(), out.as_mut_ptr()) })
    }

    fn call_mass(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one mass a node");
        let mass = non_null(self.material()?.mass)?;
        // SAFETY: see above.
        self.check(unsafe { mass(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn call_energy(&self, call: &Call<'_>) -> Result<f64, Fault> {
        let (energy, mut sum) = (non_null(self.material()?.energy)?, 0.0);
        // SAFETY: see above.
        self.check(unsafe { energy(self.plugin, &call.batch, &mut sum) }).map(|()| sum)
    }

    fn call_forces(&self, call: &Call<'_>, out: &mut [[f64; 3]]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one force a node");
        let forces = non_null(self.material()?.forces)?;
        // SAFETY: see above.
        self.check(unsafe { forces(self.plugin, &call.batch, out.as_mut_ptr().cast()) })
    }

    fn call_tangent(
        &self,
        call: &Call<'_>,
        scale: TangentScale,
        slots: &[u32],
        out: &mut [[f64; 9]],
    ) -> Result<(), Fault> {
        let tangent = non_null(self.material()?.tangent)?;
        let raw = raw_blocks(call, slots, out);
        // SAFETY: see above.
        self.check(unsafe { tangent(self.plugin, &call.batch, scale.stiffness, scale.damping, &raw) })
    }

    fn call_single_tangent(
        &self,
        call: &Call<'_>,
        scale: TangentScale,
        slots: &[u32],
        out: &mut [[f32; 9]],
    ) -> Result<(), Fault> {
        let table = self.extension::<abi::Single>(abi::SINGLE)?;
        let tangent = non_null(table.ok_or(Fault::unsupported("`pliant.single/1` is not offered"))?.tangent)?;
        let raw = raw_single_blocks(call, slots, out);
        // SAFETY: see above.
        self.check(unsafe { tangent(self.plugin, &call.batch, scale.stiffness, scale.damping, &raw) })
    }

    fn call_advance(&self, call: &Call<'_>, history: &mut [f64]) -> Result<(), Fault> {
        let advance = non_null(self.material()?.advance)?;
        assert!(history.len() >= call.strides.history * call.batch.count, "planes of every element");
        // SAFETY: see above.
        self.check(unsafe { advance(self.plugin, &call.batch, history.as_mut_ptr()) })
    }

    fn call_failed(&self, call: &Call<'_>, out: &mut [u8]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.count, "a byte for each element");
        let failed = non_null(self.failure()?.failed)?;
        // SAFETY: see above.
        self.check(unsafe { failed(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn call_strain(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 13 * call.batch.count, "thirteen planes");
        let strain = non_null(self.coupled()?.strain)?;
        // SAFETY: see above.
        self.check(unsafe { strain(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn call_compliance(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 6 * call.batch.count, "six planes");
        let compliance = non_null(self.coupled()?.compliance)?;
        // SAFETY: see above.
        self.check(unsafe { compliance(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn call_normals_energy(&self, call: &Call<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault> {
        assert!(normals.len() >= call.batch.nodes, "one normal a node");
        let (energy, mut sum) = (non_null(self.normals()?.energy)?, 0.0);
        // SAFETY: see above.
        self.check(unsafe { energy(self.plugin, &call.batch, normals.as_ptr().cast(), &mut sum) }).map(|()| sum)
    }

    fn call_normals_forces(&self, call: &Call<'_>, normals: &[[f64; 3]], out: &mut [[f64; 6]]) -> Result<(), Fault> {
        assert!(normals.len() >= call.batch.nodes && out.len() >= call.batch.nodes, "one normal and result a node");
        let forces = non_null(self.normals()?.forces)?;
        // SAFETY: see above.
        self.check(unsafe { forces(self.plugin, &call.batch, normals.as_ptr().cast(), out.as_mut_ptr().cast()) })
    }

    fn call_tilt(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 3 * call.batch.count, "three planes");
        let tilt = non_null(self.normals()?.tilt)?;
        // SAFETY: see above.
        self.check(unsafe { tilt(self.plugin, &call.batch, out.as_mut_ptr()) })
    }
}
