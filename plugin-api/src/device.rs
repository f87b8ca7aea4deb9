//! The trait of a device, and its side of the wire.

use crate::abi::{self, DeviceInfo, Output, Pose, Status};
use crate::fault::Fault;
use crate::info::Info;
use crate::instance::{Role, call, with_params};
use crate::param::Params;
use core::ffi::{CStr, c_char, c_void};
use core::marker::PhantomData;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use std::ffi::CString;

/// Where the hand is, and what force and touch to give it.
///
/// `stop` may come from any thread at any time, so everything takes `&self`: keep what changes in atomics.
pub trait Device: Send + Sync + Sized + 'static {
    /// Facts for the descriptor.
    const INFO: Info;

    /// Opens the device.
    ///
    /// # Errors
    /// No device, no driver, no rights, or parameters it cannot work with.
    fn new(params: &Params<'_>) -> Result<Self, Fault>;

    /// Its limits, which the host scales its gains to.
    fn describe(&self) -> DeviceInfo;

    /// One pose per effector, at `time` (ns). A real device gives its newest and leaves `time` alone. *Servo*.
    ///
    /// # Errors
    /// The device is lost; the host lets go of everything it held.
    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault>;

    /// What each effector is to render from now on. *Servo*.
    ///
    /// # Errors
    /// The device is lost.
    fn write(&self, time: u64, outputs: &[Output]) -> Result<(), Fault>;

    /// Zero force, at once, from any thread.
    fn stop(&self);

    /// What each effector really renders at `time` (ns), where the device knows. *Servo*.
    ///
    /// # Errors
    /// A device that does not know.
    fn rendered(&self, _time: u64, _outputs: &mut [Output]) -> Result<(), Fault> {
        Err(Fault::unsupported(""))
    }

    /// What it has counted since it was opened, by place from 0 on; `None` past the last. *Any*.
    fn counter(&self, _index: u32) -> Option<(&'static CStr, u64)> {
        None
    }

    /// What it needs, whether that is there, and how to get it. Holds on to nothing it opens.
    fn probe(_params: &Params<'_>) -> Vec<Finding> {
        Vec::new()
    }
}

/// One thing a device needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// [`abi::INFO`] it is there, [`abi::WARNING`] it works worse without, [`abi::ERROR`] it does not work without.
    pub severity: u32,
    /// What was looked for.
    pub what: String,
    /// What was found.
    pub found: String,
    /// How to get it; empty where nothing is to be done.
    pub remedy: String,
}

impl Finding {
    /// It is there.
    pub fn good(what: impl Into<String>, found: impl Into<String>) -> Self {
        Self { severity: abi::INFO, what: what.into(), found: found.into(), remedy: String::new() }
    }

    /// It is not, and nothing works without.
    pub fn missing(what: impl Into<String>, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { severity: abi::ERROR, what: what.into(), found: found.into(), remedy: remedy.into() }
    }

    /// It is not, and the rest works without.
    pub fn wanting(what: impl Into<String>, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { severity: abi::WARNING, ..Self::missing(what, found, remedy) }
    }
}

/// A [`Device`] as [`crate::export_plugins`] hands it over.
pub struct AsDevice<T>(PhantomData<T>);

impl<T: Device> Role for AsDevice<T> {
    type Object = T;
    const INFO: Info = T::INFO;
    const KIND: u32 = abi::KIND_DEVICE;
    const EXTENSION: &'static CStr = abi::DEVICE;

    fn table() -> *const c_void {
        (&raw const *Self::TABLE).cast()
    }

    fn other_table(id: &CStr) -> *const c_void {
        match id {
            _ if id == abi::RENDERED => (&raw const *Self::RENDERED).cast(),
            _ if id == abi::COUNTERS => (&raw const *Self::COUNTERS).cast(),
            _ if id == abi::PROBE => (&raw const *Self::PROBE).cast(),
            _ => core::ptr::null(),
        }
    }

    fn open(params: &Params<'_>, _limits: &abi::Limits) -> Result<T, Fault> {
        T::new(params)
    }
}

#[allow(unsafe_code, reason = "the functions behind the table")]
impl<T: Device> AsDevice<T> {
    const RENDERED: &'static abi::Rendered =
        &abi::Rendered { size: size_of::<abi::Rendered>(), rendered: Some(Self::rendered) };

    unsafe extern "C" fn rendered(plugin: *const abi::Plugin, time: u64, outputs: *mut Output, count: usize) -> Status {
        // SAFETY: a live, active instance of this role; `count` outputs that are the host's to fill.
        unsafe { call::<Self, _>(plugin, |device| device.rendered(time, from_raw_parts_mut(outputs, count))) }
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
                *out = device.describe();
                Ok(())
            })
        }
    }

    unsafe extern "C" fn read(plugin: *const abi::Plugin, time: u64, poses: *mut Pose, count: usize) -> Status {
        // SAFETY: as above, with `count` poses; [servo] calls are exclusive.
        unsafe { call::<Self, _>(plugin, |device| device.read(time, from_raw_parts_mut(poses, count))) }
    }

    unsafe extern "C" fn write(plugin: *const abi::Plugin, time: u64, outputs: *const Output, count: usize) -> Status {
        // SAFETY: as above, with `count` outputs; [servo] calls are exclusive.
        unsafe { call::<Self, _>(plugin, |device| device.write(time, from_raw_parts(outputs, count))) }
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
