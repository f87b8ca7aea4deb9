//! Safe calls into a device.

use super::error::HostError;
use super::instance::{Instance, Settings};
use super::library::Library;
use super::plugin::{Kind, PluginInfo};
use super::report::Message;
use pliant_plugin_api::abi::{self, Status};
use std::ffi::CStr;
use std::sync::Arc;

pub use pliant_plugin_api::abi::{DeviceInfo, Pose};

/// What one effector is to render.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output<'a> {
    /// N, on the hand
    pub force: [f64; 3],
    /// N m
    pub torque: [f64; 3],
    /// N (rows x columns), or empty
    pub taxels: &'a [f64],
    /// ns; past this the device falls to zero by itself
    pub valid_until: u64,
}

/// The most effectors one device may have.
pub const MOST_EFFECTORS: usize = 8;

/// The most counters that are asked for.
const MOST_COUNTERS: u32 = 64;

/// An active device. Dropping it stops it first.
pub struct Device {
    instance: Arc<Instance>,
    table: &'static abi::Device,
    counters: Option<&'static abi::Counters>,
    facts: DeviceInfo,
}

#[allow(unsafe_code, reason = "calls the device's functions")]
impl Device {
    /// Opens a device. `dt` (s) is the time between two reads.
    ///
    /// # Errors
    /// Whatever the plugin, its tables or the hardware have wrong.
    pub fn open(library: &'static Library, name: &str, settings: &Settings, dt: f64) -> Result<Self, HostError> {
        let info = library.plugin(Kind::Device, name)?;
        let instance = Instance::open(library, info, settings, dt, abi::DEVICE, size_of::<abi::Device>())?;
        // SAFETY: opened with the device extension.
        let table: &'static abi::Device = unsafe { instance.table() };
        let (Some(describe), true) =
            (table.describe, table.read.is_some() && table.write.is_some() && table.stop.is_some())
        else {
            return Err(instance.error("extension", "the device's table has a null in it"));
        };
        let mut facts = empty_facts();
        // SAFETY: [main & active]; `facts` is ours to fill.
        instance.done("describe", unsafe { describe(instance.plugin(), &mut facts) })?;
        let limits = [facts.rate, facts.peak_force, facts.continuous_force, facts.stiffness];
        if !limits.iter().all(|l| l.is_finite() && *l > 0.0) {
            return Err(instance.error("describe", "rate, forces and stiffness must be finite and above zero"));
        }
        if !(1..=MOST_EFFECTORS as u32).contains(&facts.effectors) {
            let text = format!("{} effectors; allowed is 1 to {MOST_EFFECTORS}", facts.effectors);
            return Err(instance.error("describe", &text));
        }
        let counters = instance.other_table(abi::COUNTERS, size_of::<abi::Counters>());
        // SAFETY: the table of that extension, of at least its size, for the life of the library.
        let counters = counters.map(|table| unsafe { &*table.cast() });
        Ok(Self { instance: Arc::new(instance), table, counters, facts })
    }

    /// Its limits.
    pub fn facts(&self) -> &DeviceInfo {
        &self.facts
    }

    /// One pose per effector at `time` (ns). `[servo]`
    ///
    /// # Errors
    /// The device is lost.
    pub fn read(&mut self, time: u64, poses: &mut [Pose]) -> Result<(), HostError> {
        let status = self.read_now(time, poses);
        self.instance.done("read", status)
    }

    /// The same for a thread that may not allocate: a status, which [`Device::told`] puts into words later. `[servo]`
    pub fn read_now(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let read = self.table.read.expect("checked");
        // SAFETY: [servo & active], exclusive by `&mut`.
        unsafe { read(self.instance.plugin(), time, poses.as_mut_ptr(), poses.len()) }
    }

    /// What each effector is to render from now on. `[servo]`
    ///
    /// # Errors
    /// The device is lost.
    pub fn write(&mut self, time: u64, outputs: &[Output<'_>]) -> Result<(), HostError> {
        let status = self.write_now(time, outputs);
        self.instance.done("write", status)
    }

    /// The same for a thread that may not allocate. `[servo]`
    pub fn write_now(&mut self, time: u64, outputs: &[Output<'_>]) -> Status {
        let nothing = abi::Output {
            size: size_of::<abi::Output>(),
            force: [0.0; 3],
            torque: [0.0; 3],
            taxels: std::ptr::null(),
            valid_until_ns: 0,
        };
        let mut raw = [nothing; MOST_EFFECTORS];
        for (to, from) in raw.iter_mut().zip(outputs) {
            to.force = from.force;
            to.torque = from.torque;
            to.taxels = if from.taxels.is_empty() { std::ptr::null() } else { from.taxels.as_ptr() };
            to.valid_until_ns = from.valid_until;
        }
        let write = self.table.write.expect("checked");
        let count = outputs.len().min(MOST_EFFECTORS);
        // SAFETY: [servo & active], exclusive by `&mut`; taxels are borrowed for the call.
        unsafe { write(self.instance.plugin(), time, raw.as_ptr(), count) }
    }

    /// What a call of it that gave `status` comes to.
    ///
    /// # Errors
    /// The device is lost.
    pub fn told(&self, call: &'static str, status: Status) -> Result<(), HostError> {
        self.instance.done(call, status)
    }

    /// A handle that can stop it from any thread, at any time.
    pub fn stopper(&self) -> Stopper {
        Stopper { instance: Arc::clone(&self.instance), stop: self.table.stop.expect("checked") }
    }

    /// Zero force, at once. `[any]`
    ///
    /// # Errors
    /// The device is lost.
    pub fn stop(&self) -> Result<(), HostError> {
        // SAFETY: [any & active].
        self.instance.done("stop", unsafe { (self.table.stop.expect("checked"))(self.instance.plugin()) })
    }

    /// What it has counted since it was opened, where it counts; `[any]`.
    pub fn counters(&self) -> Vec<(String, u64)> {
        let Some(counter) = self.counters.and_then(|table| table.counter) else { return Vec::new() };
        let mut found = Vec::new();
        for index in 0..MOST_COUNTERS {
            let (mut name, mut value) = (std::ptr::null(), 0);
            // SAFETY: [any & active]; both are ours to fill.
            let status = unsafe { counter(self.instance.plugin(), index, &mut name, &mut value) };
            if status != abi::Status::OK || name.is_null() {
                break;
            }
            // SAFETY: a C string that lives as long as the library.
            found.push((unsafe { CStr::from_ptr(name) }.to_string_lossy().into_owned(), value));
        }
        found
    }

    /// What it said since the last time, and how many lines were lost.
    pub fn messages(&self) -> (Vec<Message>, u64) {
        self.instance.messages()
    }

    /// Its descriptor.
    pub fn info(&self) -> &'static PluginInfo {
        self.instance.info(Kind::Device)
    }

    /// Its library.
    pub fn library(&self) -> &'static Library {
        self.instance.library()
    }
}

/// Stops a device from any thread.
pub struct Stopper {
    instance: Arc<Instance>,
    stop: unsafe extern "C" fn(*const abi::Plugin) -> Status,
}

impl Stopper {
    /// Zero force, at once. `[any]`
    #[allow(unsafe_code, reason = "calls the device's function")]
    pub fn stop(&self) {
        // SAFETY: [any & active]; the instance lives as long as this.
        let _ = unsafe { (self.stop)(self.instance.plugin()) };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let _ = self.stop();
    }
}

fn empty_facts() -> DeviceInfo {
    DeviceInfo {
        size: size_of::<DeviceInfo>(),
        effectors: 0,
        buttons: 0,
        driven_axes: 0,
        taxel_rows: 0,
        taxel_columns: 0,
        rate: 0.0,
        peak_force: 0.0,
        continuous_force: 0.0,
        stiffness: 0.0,
        damping: 0.0,
        resolution: 0.0,
        workspace: [0.0; 6],
        taxel_pitch: 0.0,
        taxel_force: 0.0,
    }
}
