//! An instance under test, and safe calls through its tables.
#![allow(unsafe_code, reason = "plays the host")]

use super::candidate::Candidate;
use super::subject::{Call, Subject, raw_blocks, raw_single_blocks};
use crate::abi::{self, Status};
use crate::fault::Fault;
use crate::material::{ElementRequest, Tangent};
use core::ffi::{CStr, c_char, c_void};
use std::sync::Mutex;

/// An instance. Dropping it deactivates and destroys it.
pub struct Opened {
    plugin: *const abi::Plugin,
    host: Box<abi::Host>,
    said: Box<Said>,
    active: bool,
}

/// The newest error line: a buffer of its own, so that saying something takes no memory.
struct Said(Mutex<(usize, [u8; 256])>);

unsafe extern "C" fn report(host: *const abi::Host, severity: u32, text: *const c_char) {
    if severity != abi::ERROR || text.is_null() {
        return;
    }
    // SAFETY: `data` is the `Said` of the instance, which outlives it; `text` is a C string.
    let (said, text) = unsafe { (&*(*host).data.cast::<Said>(), CStr::from_ptr(text).to_bytes()) };
    if let Ok(mut line) = said.0.try_lock() {
        line.0 = text.len().min(256);
        let len = line.0;
        line.1[..len].copy_from_slice(&text[..len]);
    }
}

/// A host table with `data`, which outlives it.
fn host_table(said: &Said) -> Box<abi::Host> {
    Box::new(abi::Host {
        size: size_of::<abi::Host>(),
        abi_major: abi::ABI_MAJOR,
        abi_minor: abi::ABI_MINOR,
        data: core::ptr::from_ref(said).cast_mut().cast(),
        report: Some(report),
    })
}

impl Opened {
    pub(super) fn new(of: &Candidate) -> Result<Self, Fault> {
        Self::named(of, of.id())
    }

    /// Whether the library makes an instance of `id`.
    pub(super) fn named(of: &Candidate, id: &CStr) -> Result<Self, Fault> {
        let said = Box::new(Said(Mutex::new((0, [0; 256]))));
        let host = host_table(&said);
        let plugin = of.create(&raw const *host, id);
        if plugin.is_null() {
            return Err(Fault::unsupported("`create` refused"));
        }
        let opened = Self { plugin, host, said, active: false };
        let t = opened.table();
        let whole = t.size >= size_of::<abi::Plugin>()
            && t.destroy.is_some()
            && t.set_number.is_some()
            && t.set_text.is_some()
            && t.set_table.is_some()
            && t.activate.is_some()
            && t.deactivate.is_some()
            && t.extension.is_some();
        if whole {
            Ok(opened)
        } else {
            Err(Fault::bad_argument("the instance's table is too small or has a null in it"))
        }
    }

    fn table(&self) -> &abi::Plugin {
        // SAFETY: `create` gave it, and it lives until `destroy`.
        unsafe { &*self.plugin }
    }

    /// What the plugin said last, or nothing.
    fn told(&self) -> String {
        let mut line = self.said.0.lock().unwrap_or_else(|p| p.into_inner());
        let text = String::from_utf8_lossy(&line.1[..line.0]).into_owned();
        line.0 = 0;
        text
    }

    pub(super) fn done(&self, status: Status) -> Result<(), Fault> {
        if status == Status::OK {
            return Ok(());
        }
        Err(Fault { status, reason: self.told().into() })
    }

    /// Sets a number or choice by place.
    ///
    /// # Errors
    /// What the plugin says.
    pub fn set(&mut self, place: u32, value: f64) -> Result<(), Fault> {
        let set = self.table().set_number.expect("checked");
        // SAFETY: [main & !active]: `&mut`, and the suite activates last.
        self.done(unsafe { set(self.plugin, place, value) })
    }

    pub(super) fn activate(&mut self) -> Result<(), Fault> {
        let limits = abi::Limits { size: size_of::<abi::Limits>(), dt: 1e-3 };
        let activate = self.table().activate.expect("checked");
        // SAFETY: [main & !active].
        self.done(unsafe { activate(self.plugin, &limits) })?;
        self.active = true;
        Ok(())
    }

    /// A table of `id` that is at least a `T`.
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

    /// What goes first into every call.
    pub(super) fn raw(&self) -> *const abi::Plugin {
        self.plugin
    }

    fn material(&self) -> Result<&'static abi::Material, Fault> {
        self.extension::<abi::Material>(abi::MATERIAL)?.ok_or(Fault::unsupported("`pliant.material/1` is not offered"))
    }

    fn coupled(&self) -> Result<&'static abi::Coupled, Fault> {
        self.extension::<abi::Coupled>(abi::COUPLED)?.ok_or(Fault::unsupported("`pliant.coupled/1` is not offered"))
    }

    fn normals(&self) -> Result<&'static abi::Normals, Fault> {
        self.extension::<abi::Normals>(abi::NORMALS)?.ok_or(Fault::unsupported("`pliant.normals/1` is not offered"))
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        let (deactivate, destroy) = (self.table().deactivate, self.table().destroy);
        // SAFETY: [main]; nobody else has the instance. The host table goes after it.
        unsafe {
            if let (true, Some(deactivate)) = (self.active, deactivate) {
                deactivate(self.plugin);
            }
            if let Some(destroy) = destroy {
                destroy(self.plugin);
            }
        }
        debug_assert!(!self.host.data.is_null());
        self.host.data = core::ptr::null_mut::<c_void>();
    }
}

/// A function of a table, or why not.
fn there<F>(function: Option<F>) -> Result<F, Fault> {
    function.ok_or(Fault::bad_argument("the material's table has a null in it"))
}

// SAFETY of every call below: [sim & active] (`elements`: [main & active]) on one thread, with a batch that a test body made
// for the call and output of the size the header states.
impl Subject for Opened {
    fn wants(&self) -> Result<Vec<ElementRequest>, Fault> {
        let elements = there(self.material()?.elements)?;
        let mut wanted = Vec::new();
        for index in 0..16 {
            let size = size_of::<abi::ElementRequest>();
            let mut raw =
                abi::ElementRequest { size, kind: 0, families: 0, flags: 0, rest_stride: 0, history_stride: 0 };
            // SAFETY: see above.
            match unsafe { elements(self.plugin, index, &mut raw) } {
                Status::UNSUPPORTED => break,
                status => self.done(status)?,
            }
            if !(abi::POINT..=abi::TETRAHEDRON).contains(&raw.kind) {
                return Err(Fault::bad_argument(format!("unknown element kind {}", raw.kind)));
            }
            let abi::ElementRequest { kind, families, flags, rest_stride, history_stride, .. } = raw;
            wanted.push(ElementRequest { kind, families, flags, rest_stride, history_stride });
        }
        self.told();
        Ok(wanted)
    }

    fn rest_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        let rest = there(self.material()?.rest)?;
        // SAFETY: see above.
        self.done(unsafe { rest(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn mass_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one mass a node");
        let mass = there(self.material()?.mass)?;
        // SAFETY: see above.
        self.done(unsafe { mass(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn energy_of(&self, call: &Call<'_>) -> Result<f64, Fault> {
        let (energy, mut sum) = (there(self.material()?.energy)?, 0.0);
        // SAFETY: see above.
        self.done(unsafe { energy(self.plugin, &call.batch, &mut sum) }).map(|()| sum)
    }

    fn forces_of(&self, call: &Call<'_>, out: &mut [[f64; 3]]) -> Result<(), Fault> {
        assert!(out.len() >= call.batch.nodes, "one force a node");
        let forces = there(self.material()?.forces)?;
        // SAFETY: see above.
        self.done(unsafe { forces(self.plugin, &call.batch, out.as_mut_ptr().cast()) })
    }

    fn tangent_of(&self, call: &Call<'_>, scale: Tangent, slots: &[u32], out: &mut [[f64; 9]]) -> Result<(), Fault> {
        let tangent = there(self.material()?.tangent)?;
        let raw = raw_blocks(call, slots, out);
        // SAFETY: see above.
        self.done(unsafe { tangent(self.plugin, &call.batch, scale.stiffness, scale.damping, &raw) })
    }

    fn single_tangent_of(
        &self,
        call: &Call<'_>,
        scale: Tangent,
        slots: &[u32],
        out: &mut [[f32; 9]],
    ) -> Result<(), Fault> {
        let table = self.extension::<abi::Single>(abi::SINGLE)?;
        let tangent = there(table.ok_or(Fault::unsupported("`pliant.single/1` is not offered"))?.tangent)?;
        let raw = raw_single_blocks(call, slots, out);
        // SAFETY: see above.
        self.done(unsafe { tangent(self.plugin, &call.batch, scale.stiffness, scale.damping, &raw) })
    }

    fn strain_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 13 * call.batch.count, "thirteen planes");
        let strain = there(self.coupled()?.strain)?;
        // SAFETY: see above.
        self.done(unsafe { strain(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn compliance_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 6 * call.batch.count, "six planes");
        let compliance = there(self.coupled()?.compliance)?;
        // SAFETY: see above.
        self.done(unsafe { compliance(self.plugin, &call.batch, out.as_mut_ptr()) })
    }

    fn normals_energy_of(&self, call: &Call<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault> {
        assert!(normals.len() >= call.batch.nodes, "one normal a node");
        let (energy, mut sum) = (there(self.normals()?.energy)?, 0.0);
        // SAFETY: see above.
        self.done(unsafe { energy(self.plugin, &call.batch, normals.as_ptr().cast(), &mut sum) }).map(|()| sum)
    }

    fn normals_forces_of(&self, call: &Call<'_>, normals: &[[f64; 3]], out: &mut [[f64; 6]]) -> Result<(), Fault> {
        assert!(normals.len() >= call.batch.nodes && out.len() >= call.batch.nodes, "one normal and result a node");
        let forces = there(self.normals()?.forces)?;
        // SAFETY: see above.
        self.done(unsafe { forces(self.plugin, &call.batch, normals.as_ptr().cast(), out.as_mut_ptr().cast()) })
    }

    fn tilt_of(&self, call: &Call<'_>, out: &mut [f64]) -> Result<(), Fault> {
        assert!(out.len() >= 3 * call.batch.count, "three planes");
        let tilt = there(self.normals()?.tilt)?;
        // SAFETY: see above.
        self.done(unsafe { tilt(self.plugin, &call.batch, out.as_mut_ptr()) })
    }
}
