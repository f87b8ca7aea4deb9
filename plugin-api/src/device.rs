//! The trait of a device, and the C functions behind its tables.

use crate::abi::{self, DeviceInfo, Output, Pose, Status};
use crate::fault::Fault;
use crate::info::Info;
use crate::instance::{Role, call, with_params};
use crate::param::Params;
use core::ffi::{CStr, c_char, c_void};
use core::marker::PhantomData;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use std::ffi::CString;

/// A haptic device: it reads the pose of a hand and renders force, torque and touch on it.
///
/// `stop` may be called from any thread at any time, so every method takes `&self`: keep what changes in atomics. Methods marked
/// *Servo* are called at the device's rate, one at a time, and must not allocate, lock or do I/O.
pub trait Device: Send + Sync + Sized + 'static {
    /// The plugin's descriptor.
    const INFO: Info;

    /// Opens the device.
    ///
    /// # Errors
    /// No device, no driver, no rights, or a combination of parameters it cannot work with.
    fn new(params: &Params<'_>) -> Result<Self, Fault>;

    /// The device's limits; the host scales its gains to them.
    fn describe(&self) -> DeviceInfo;

    /// Fills in one pose per effector for `time_ns`; hardware gives its newest sample and ignores the time. *Servo*.
    ///
    /// # Errors
    /// The connection is lost; the host then releases everything the hand held.
    fn read(&self, time_ns: u64, poses: &mut [Pose]) -> Result<(), Fault>;

    /// Sets what each effector is to render from `time_ns` on. *Servo*.
    ///
    /// # Errors
    /// The connection is lost.
    fn write(&self, time_ns: u64, outputs: &[Output]) -> Result<(), Fault>;

    /// Renders zero at once. *Any thread*.
    fn stop(&self);

    /// Fills in the force and torque each effector really renders at `time_ns`. *Servo*.
    ///
    /// # Errors
    /// `UNSUPPORTED`, the default, where the device cannot tell.
    fn rendered(&self, _time_ns: u64, _outputs: &mut [Output]) -> Result<(), Fault> {
        Err(Fault::unsupported(""))
    }

    /// Name and value of counter number `index` since the device was opened, such as datagrams lost; `None` past the last. The host may
    /// call it on any thread.
    fn counter(&self, _index: u32) -> Option<(&'static CStr, u64)> {
        None
    }

    /// Checks what the device needs (driver, rights, cables), for `pliant device doctor`. Closes everything it opens.
    fn probe(_params: &Params<'_>) -> Vec<Finding> {
        Vec::new()
    }
}

/// The result of checking one requirement of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// [`abi::INFO`]: it is met; [`abi::WARNING`]: the device works worse without it; [`abi::ERROR`]: the device does not work without
    /// it.
    pub severity: u32,
    /// The requirement, such as `driver library`.
    pub what: String,
    /// What was found.
    pub found: String,
    /// What the user can do; empty where nothing has to be done.
    pub remedy: String,
}

impl Finding {
    /// The requirement is met.
    pub fn present(what: impl Into<String>, found: impl Into<String>) -> Self {
        Self { severity: abi::INFO, what: what.into(), found: found.into(), remedy: String::new() }
    }

    /// The requirement is not met, and the device does not work without it.
    pub fn missing(what: impl Into<String>, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { severity: abi::ERROR, what: what.into(), found: found.into(), remedy: remedy.into() }
    }

    /// The requirement is not met, and the device works worse without it.
    pub fn degraded(what: impl Into<String>, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { severity: abi::WARNING, ..Self::missing(what, found, remedy) }
    }
}

/// Adapter: a [`Device`] as a plugin, for [`crate::export_plugins`].
pub struct AsDevice<T>(PhantomData<T>);

impl<T: Device> Role for AsDevice<T> {
    type Object = T;
    const INFO: Info = T::INFO;
    const KIND: u32 = abi::KIND_DEVICE;
    const EXTENSION: &'static CStr = abi::DEVICE;

    fn table() -> *const c_void {
        (&raw const *Self::TABLE).cast()
    }

    fn optional_table(id: &CStr) -> *const c_void {
        match id {
            _ if id == abi::RENDERED => (&raw const *Self::RENDERED).cast(),
            _ if id == abi::COUNTERS => (&raw const *Self::COUNTERS).cast(),
            _ if id == abi::PROBE => (&raw const *Self::PROBE).cast(),
            _ => core::ptr::null(),
        }
    }

    fn activate(params: &Params<'_>) -> Result<T, Fault> {
        T::new(params)
    }
}

#[allow(unsafe_code, reason = "the functions behind the table")]
impl<T: Device> AsDevice<T> {
    const RENDERED: &'static abi::Rendered =
        &abi::Rendered { size: size_of::<abi::Rendered>(), rendered: Some(Self::rendered) };

    unsafe extern "C" fn rendered(
        plugin: *const abi::Plugin,
        time_ns: u64,
        outputs: *mut Output,
        count: usize,
    ) -> Status {
        // SAFETY: a live, active instance of this role; `count` outputs that are the host's to fill.
        unsafe { call::<Self, _>(plugin, |device| device.rendered(time_ns, from_raw_parts_mut(outputs, count))) }
    }

    const COUNTERS: &'static abi::Counters =
        &abi::Counters { size: size_of::<abi::Counters>(), counter: Some(Self::counter) };

    unsafe extern "C" fn counter(
        plugin: *const abi::Plugin,
        index: u32,
        name: *mut *const c_char,
        value: *mut u64,
    ) -> Status {
        // SAFETY: a live, active instance of this role; the host's to fill.
        unsafe {
            call::<Self, _>(plugin, |device| {
                let (text, count) = device.counter(index).ok_or(Fault::unsupported(""))?;
                (*name, *value) = (text.as_ptr(), count);
                Ok(())
            })
        }
    }

    const PROBE: &'static abi::Probe = &abi::Probe { size: size_of::<abi::Probe>(), probe: Some(Self::probe) };

    unsafe extern "C" fn probe(plugin: *const abi::Plugin, data: *mut c_void, say: abi::Say) -> Status {
        // SAFETY: a live instance of this role on [main]; `say` takes strings for the call.
        unsafe {
            with_params::<Self, _>(plugin, |params| {
                for finding in T::probe(params) {
                    let text = |text: String| CString::new(text.replace('\0', " ")).unwrap_or_default();
                    let (what, found, remedy) = (text(finding.what), text(finding.found), text(finding.remedy));
                    say(data, finding.severity, what.as_ptr(), found.as_ptr(), remedy.as_ptr());
                }
                Ok(())
            })
        }
    }

    const TABLE: &'static abi::Device = &abi::Device {
        size: size_of::<abi::Device>(),
        describe: Some(Self::describe),
        read: Some(Self::read),
        write: Some(Self::write),
        stop: Some(Self::stop),
    };

    unsafe extern "C" fn describe(plugin: *const abi::Plugin, out: *mut DeviceInfo) -> Status {
        // SAFETY: a live, active instance of this role; `out` is the host's to fill.
        unsafe {
            call::<Self, _>(plugin, |device| {
                // A host of an earlier minor has a shorter struct.
                let size = (*out).size.min(size_of::<DeviceInfo>());
                let info = DeviceInfo { size, ..device.describe() };
                core::ptr::copy_nonoverlapping((&raw const info).cast::<u8>(), out.cast::<u8>(), size);
                Ok(())
            })
        }
    }

    unsafe extern "C" fn read(plugin: *const abi::Plugin, time_ns: u64, poses: *mut Pose, count: usize) -> Status {
        // SAFETY: as above, with `count` poses; [servo] calls are exclusive.
        unsafe { call::<Self, _>(plugin, |device| device.read(time_ns, from_raw_parts_mut(poses, count))) }
    }

    unsafe extern "C" fn write(
        plugin: *const abi::Plugin,
        time_ns: u64,
        outputs: *const Output,
        count: usize,
    ) -> Status {
        // SAFETY: as above, with `count` outputs; [servo] calls are exclusive.
        unsafe { call::<Self, _>(plugin, |device| device.write(time_ns, from_raw_parts(outputs, count))) }
    }

    unsafe extern "C" fn stop(plugin: *const abi::Plugin) -> Status {
        // SAFETY: as above.
        unsafe {
            call::<Self, _>(plugin, |device| {
                device.stop();
                Ok(())
            })
        }
    }
}
