//! An active device and safe calls into it.

use crate::error::HostError;
use crate::instance::{Extension, Instance, ParamSettings};
use crate::library::Library;
use crate::messages::NewMessages;
use crate::plugin_info::{PluginInfo, PluginKind};
use pliant_plugin_api::abi::{self, Status};
use std::ffi::CStr;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

pub use pliant_plugin_api::abi::{DeviceInfo, POSE_VALID, Pose};

/// Force, torque and taxels that one effector is to render.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EffectorOutput<'a> {
    /// Force on the hand, N, in the axes of the device.
    pub force: [f64; 3],
    /// Torque on the hand, N m, in the axes of the device.
    pub torque: [f64; 3],
    /// Normal force of each pin of the tactile array, N (rows x columns); empty without one.
    pub taxels: &'a [f64],
    /// Time after which the device sets its force to zero by itself, ns.
    pub valid_until: u64,
}

/// Largest number of effectors of one device.
pub const MAX_EFFECTORS: usize = 8;

/// Largest number of taxels of one effector.
const MAX_TAXELS: u64 = 1 << 16;

/// Checks the description of a device, from the device or from a recording.
///
/// # Errors
/// Returns a message with the quantity, its value and what is allowed.
pub fn check_device_info(info: &DeviceInfo) -> Result<(), String> {
    let DeviceInfo { rate, peak_force, continuous_force, stiffness, effectors, .. } = *info;
    if ![rate, peak_force, continuous_force, stiffness].iter().all(|l| l.is_finite() && *l > 0.0) {
        return Err("rate, forces and stiffness must be finite and above zero".into());
    }
    if !(info.peak_torque.is_finite() && info.peak_torque >= 0.0) {
        return Err(format!("a peak torque of {} N m; allowed is 0 or more", info.peak_torque));
    }
    if !(1..=MAX_EFFECTORS as u32).contains(&effectors) {
        return Err(format!("{effectors} effectors; allowed is 1 to {MAX_EFFECTORS}"));
    }
    let (rows, columns) = (info.taxel_rows, info.taxel_columns);
    if u64::from(rows) * u64::from(columns) > MAX_TAXELS {
        return Err(format!("{rows} x {columns} taxels; allowed is at most {MAX_TAXELS}"));
    }
    Ok(())
}

/// Largest number of counters that are read from one device.
const MAX_COUNTERS: u32 = 64;

/// An active device. Dropping it stops it (zero force) first.
pub struct Device {
    /// The plugin instance.
    instance: Arc<Instance>,
    /// Function table of the device.
    table: &'static abi::Device,
    /// Function table of its counters; `None` if it counts nothing.
    counters: Option<&'static abi::Counters>,
    /// What the device says of itself: effectors, axes, largest forces.
    device_info: DeviceInfo,
}

#[allow(unsafe_code, reason = "calls the device's functions")]
impl Device {
    /// Opens the device `name` of a library. `dt` (s) is the time between two reads.
    ///
    /// # Errors
    /// Fails for a library without that device, a malformed table, refused parameters and hardware that cannot be opened.
    pub fn open(library: &'static Library, name: &str, settings: &ParamSettings, dt: f64) -> Result<Self, HostError> {
        let info = library.plugin(PluginKind::Device, name)?;
        let instance = Instance::open(library, info, settings, dt, Extension::new::<abi::Device>(abi::DEVICE))?;
        // SAFETY: opened with the device extension.
        let table: &'static abi::Device = unsafe { instance.table() };
        let (Some(describe), true) =
            (table.describe, table.read.is_some() && table.write.is_some() && table.stop.is_some())
        else {
            return Err(instance.error("extension", "the device's table has a null in it"));
        };
        let mut device_info = DeviceInfo::default();
        // SAFETY: [main & active]; `device_info` is ours to fill.
        instance.run("describe", || unsafe { describe(instance.plugin(), &mut device_info) })?;
        check_device_info(&device_info).map_err(|reason| instance.error("describe", &reason))?;
        let counters = instance.extension_table(Extension::new::<abi::Counters>(abi::COUNTERS));
        // SAFETY: the table of that extension, of at least its size, for the life of the library.
        let counters = counters.map(|table| unsafe { &*table.cast() });
        let instance = Arc::new(instance);
        register_open(&instance, table.stop.expect("checked"));
        Ok(Self { instance, table, counters, device_info })
    }

    /// The device's description: effectors, rate, limits, workspace, tactile array.
    pub fn device_info(&self) -> &DeviceInfo {
        &self.device_info
    }

    /// Reads one pose per effector at `time` (ns). `[servo]`
    ///
    /// # Errors
    /// Fails if the device is lost; the error has its message.
    pub fn read(&mut self, time: u64, poses: &mut [Pose]) -> Result<(), HostError> {
        let status = self.read_realtime(time, poses);
        self.instance.check("read", status)
    }

    /// As [`Device::read`], without allocating: returns the status, which [`Device::check`] turns into a result later. `[servo]`
    pub fn read_realtime(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let read = self.table.read.expect("checked");
        // SAFETY: [servo & active], exclusive by `&mut`.
        self.instance.within("read", || unsafe { read(self.instance.plugin(), time, poses.as_mut_ptr(), poses.len()) })
    }

    /// Sets what each effector renders from `time` (ns) on. `[servo]`
    ///
    /// # Errors
    /// Fails if the device is lost; the error has its message.
    pub fn write(&mut self, time: u64, outputs: &[EffectorOutput<'_>]) -> Result<(), HostError> {
        let status = self.write_realtime(time, outputs);
        self.instance.check("write", status)
    }

    /// As [`Device::write`], without allocating: returns the status. `[servo]`
    pub fn write_realtime(&mut self, time: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        let zero = abi::Output {
            size: size_of::<abi::Output>(),
            force: [0.0; 3],
            torque: [0.0; 3],
            taxels: std::ptr::null(),
            valid_until_ns: 0,
        };
        let mut raw = [zero; MAX_EFFECTORS];
        for (to, from) in raw.iter_mut().zip(outputs) {
            to.force = from.force;
            to.torque = from.torque;
            to.taxels = if from.taxels.is_empty() { std::ptr::null() } else { from.taxels.as_ptr() };
            to.valid_until_ns = from.valid_until;
        }
        let write = self.table.write.expect("checked");
        let count = outputs.len().min(MAX_EFFECTORS);
        // SAFETY: [servo & active], exclusive by `&mut`; taxels are borrowed for the call.
        self.instance.within("write", || unsafe { write(self.instance.plugin(), time, raw.as_ptr(), count) })
    }

    /// Turns the status that `call` returned into a result.
    ///
    /// # Errors
    /// Fails for any status but OK; the error has the device's message.
    pub fn check(&self, call: &'static str, status: Status) -> Result<(), HostError> {
        self.instance.check(call, status)
    }

    /// A handle that stops the device from any thread, at any time.
    pub fn stop_handle(&self) -> StopHandle {
        StopHandle { instance: Arc::clone(&self.instance), stop: self.table.stop.expect("checked") }
    }

    /// Sets all forces to zero at once. `[any]`
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn stop(&self) -> Result<(), HostError> {
        // SAFETY: [any & active].
        self.instance.run("stop", || unsafe { (self.table.stop.expect("checked"))(self.instance.plugin()) })
    }

    /// Names and values of the device's counters since it was opened; empty if it has none. `[any]`
    pub fn counters(&self) -> Vec<(String, u64)> {
        let Some(counter) = self.counters.and_then(|table| table.counter) else { return Vec::new() };
        let mut found = Vec::new();
        for index in 0..MAX_COUNTERS {
            let (mut name, mut value) = (std::ptr::null(), 0);
            // SAFETY: [any & active]; both are ours to fill.
            let status = self
                .instance
                .within("counter", || unsafe { counter(self.instance.plugin(), index, &mut name, &mut value) });
            if status != abi::Status::OK || name.is_null() {
                break;
            }
            // SAFETY: a C string that lives as long as the library.
            found.push((unsafe { CStr::from_ptr(name) }.to_string_lossy().into_owned(), value));
        }
        found
    }

    /// Messages of the device since the last call.
    pub fn messages(&self) -> NewMessages {
        self.instance.messages()
    }

    /// Descriptor of the plugin.
    pub fn info(&self) -> &'static PluginInfo {
        self.instance.info(PluginKind::Device)
    }

    /// Library of the plugin.
    pub fn library(&self) -> &'static Library {
        self.instance.library()
    }
}

/// Stops a device from any thread, at any time.
pub struct StopHandle {
    /// The device, kept open as long as the handle exists.
    instance: Arc<Instance>,
    /// Function that stops the device, with zero force.
    stop: unsafe extern "C" fn(*const abi::Plugin) -> Status,
}

impl StopHandle {
    /// Sets all forces to zero at once. `[any]`
    #[allow(unsafe_code, reason = "calls the device's function")]
    pub fn stop(&self) {
        // SAFETY: [any & active]; the instance lives as long as this.
        let _ = self.instance.within("stop", || unsafe { (self.stop)(self.instance.plugin()) });
    }
}

/// A device that was opened, for [`stop_devices`].
struct OpenDevice {
    /// The plugin instance, unless it was closed.
    instance: Weak<Instance>,
    /// Function that stops the device, with zero force.
    stop: unsafe extern "C" fn(*const abi::Plugin) -> Status,
}

impl OpenDevice {
    /// A handle, if the device is still open.
    fn handle(&self) -> Option<StopHandle> {
        self.instance.upgrade().map(|instance| StopHandle { instance, stop: self.stop })
    }
}

/// Devices that were opened; closed ones are removed when another one is opened.
static OPEN: Mutex<Vec<OpenDevice>> = Mutex::new(Vec::new());

/// Adds a device to those that [`stop_devices`] stops.
fn register_open(instance: &Arc<Instance>, stop: unsafe extern "C" fn(*const abi::Plugin) -> Status) {
    let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    open.retain(|device| device.instance.strong_count() > 0);
    open.push(OpenDevice { instance: Arc::downgrade(instance), stop });
}

/// Sets all forces of every open device to zero. Waits for the devices for at most `limit`.
pub(crate) fn stop_devices(limit: Duration) {
    let open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    let handles: Vec<Arc<StopHandle>> = open.iter().filter_map(OpenDevice::handle).map(Arc::new).collect();
    drop(open);
    let (sender, stopped) = channel();
    let started = handles.into_iter().filter(|handle| {
        let (device, sender) = (Arc::clone(handle), sender.clone());
        let on_thread = std::thread::Builder::new().spawn(move || {
            device.stop();
            let _ = sender.send(());
            // Dropping it could close the device, which may take long.
            std::mem::forget(device);
        });
        if on_thread.is_err() {
            // Without a thread a device that hangs delays the others.
            handle.stop();
        }
        on_thread.is_ok()
    });
    let started = started.count();
    let end = Instant::now() + limit;
    for _ in 0..started {
        if stopped.recv_timeout(end.saturating_duration_since(Instant::now())).is_err() {
            break;
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let _ = self.stop();
    }
}
