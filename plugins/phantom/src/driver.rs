//! The open driver: its arms, its servo loop, and the thread that opens lost arms again.
#![allow(unsafe_code, reason = "calls a C library; each call says what makes it sound")]

use crate::arm::Arm;
use crate::hd::{self, Api, MAX_PRIORITY, parameter};
use crate::params::Settings;
use crate::servo::{MAX_ARMS, Servo};
use crate::setup::{OpenedArm, close_arm, error_message, open_arm};
use core::ffi::{c_ulong, c_void};
use pliant_plugin_api::abi::DeviceInfo;
use std::ffi::CString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the servo loop may take to leave the arms without force when the driver is closed.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(200);
/// Time between two attempts to open a lost arm again.
const REOPEN_INTERVAL: Duration = Duration::from_millis(250);

/// Whether this process uses the driver. A driver library has one scheduler, so one instance at a time can use it.
static IN_USE: AtomicBool = AtomicBool::new(false);

/// The right to use the driver, until it is dropped.
pub(crate) struct DriverClaim;

impl DriverClaim {
    /// # Errors
    /// If another instance uses the driver.
    pub(crate) fn new() -> Result<Self, String> {
        if IN_USE.swap(true, Ordering::AcqRel) {
            Err("the driver is in use; give both arms to one device: `arm` and `second-arm`".into())
        } else {
            Ok(Self)
        }
    }
}

impl Drop for DriverClaim {
    fn drop(&mut self) {
        IN_USE.store(false, Ordering::Release);
    }
}

/// The open driver with its arms.
pub struct Driver {
    servo: Arc<Servo>,
    info: DeviceInfo,
    /// Handle of the scheduled servo loop.
    callback: c_ulong,
    /// The thread that opens lost arms again, and the flag that ends it.
    reopener: Option<JoinHandle<()>>,
    is_ending: Arc<(Mutex<bool>, Condvar)>,
    /// Released after everything else.
    _claim: DriverClaim,
}

impl Driver {
    /// Loads the driver library, opens the arms and starts the servo loop, in the order the driver requires.
    ///
    /// # Errors
    /// If the library or an arm cannot be opened or the servo loop does not start; the message has the driver's error code.
    pub(crate) fn open(settings: Settings) -> Result<Self, String> {
        let claim = DriverClaim::new()?;
        let servo = Arc::new(Servo {
            api: Api::load(&settings.library)?,
            arms: [const { None::<()> }; MAX_ARMS].map(|_| Arm::default()),
            start: Instant::now(),
            is_closing: AtomicBool::new(false),
            is_closed: AtomicBool::new(false),
            inkwell_disables_force: settings.inkwell_disables_force,
        });
        let names: Vec<CString> = [Some(&settings.arm), settings.second_arm.as_ref()]
            .into_iter()
            .flatten()
            .map(|name| CString::new(name.as_str()).unwrap_or_default())
            .collect();
        let opened = open_arms(&servo, &names, &settings)
            .and_then(|info| start_servo(&servo, settings.rate).map(|callback| (info, callback)))
            .inspect_err(|_| close_arms(&servo));
        let (mut info, callback) = opened?;
        let rate = servo.api.integer(parameter::UPDATE_RATE);
        info.rate = if rate > 0 { f64::from(rate) } else { settings.rate };
        servo.api.clear_errors();
        let is_ending = Arc::default();
        let reopener = spawn_reopener(Arc::clone(&servo), names, settings, Arc::clone(&is_ending));
        Ok(Self { servo, info, callback, reopener, is_ending, _claim: claim })
    }

    /// What the servo loop and the host share.
    pub fn servo(&self) -> &Servo {
        &self.servo
    }

    /// The limits of the arms; of two arms the smaller ones.
    pub fn info(&self) -> DeviceInfo {
        self.info
    }
}

/// Opens the arms with these names, at least one, and returns their common limits.
fn open_arms(servo: &Servo, names: &[CString], settings: &Settings) -> Result<DeviceInfo, String> {
    let mut common: Option<DeviceInfo> = None;
    for (name, arm) in names.iter().zip(&servo.arms) {
        let OpenedArm { handle, info } = open_arm(&servo.api, name, settings)?;
        arm.set_peak_force(info.peak_force);
        arm.set_open(handle, servo.now_ns());
        let common = common.get_or_insert(info);
        common.peak_force = common.peak_force.min(info.peak_force);
        common.continuous_force = common.continuous_force.min(info.continuous_force);
        common.stiffness = common.stiffness.min(info.stiffness);
    }
    let mut info = common.ok_or("no arm is named")?;
    info.effectors = names.len() as u32;
    Ok(info)
}

/// Schedules the servo loop and starts the scheduler. Returns the handle for unscheduling it.
fn start_servo(servo: &Arc<Servo>, rate: f64) -> Result<c_ulong, String> {
    let api = &servo.api;
    let data = Arc::as_ptr(servo).cast_mut().cast::<c_void>();
    // SAFETY: the servo lives until `Driver::drop`, or the code below, has unscheduled the callback.
    let callback = unsafe { (api.schedule)(Servo::tick, data, MAX_PRIORITY) };
    // SAFETY: published prototype.
    let unschedule = || unsafe { (api.unschedule)(callback) };
    if let Some(error) = api.clear_errors() {
        unschedule();
        return Err(error_message("the scheduler does not accept the servo loop", error.code));
    }
    // SAFETY: published prototypes.
    unsafe {
        (api.set_scheduler_rate)(rate as c_ulong);
        // Ignored: if the driver does not have this rate, it keeps its own, which is reported later.
        api.clear_errors();
        (api.start_scheduler)();
    }
    if let Some(error) = api.clear_errors() {
        unschedule();
        return Err(error_message("the servo loop does not start", error.code));
    }
    Ok(callback)
}

/// Starts the thread that opens lost arms again: opening takes too long for the servo loop. If the system gives no thread, lost arms stay lost.
fn spawn_reopener(
    servo: Arc<Servo>,
    names: Vec<CString>,
    settings: Settings,
    is_ending: Arc<(Mutex<bool>, Condvar)>,
) -> Option<JoinHandle<()>> {
    let reopen = move || {
        let (lock, wake) = &*is_ending;
        let mut ends = lock.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            ends = wake.wait_timeout(ends, REOPEN_INTERVAL).unwrap_or_else(PoisonError::into_inner).0;
            if *ends {
                return;
            }
            if servo.arms[..names.len()].iter().any(is_lost) {
                reopen_lost_arms(&servo, &names, &settings);
            }
        }
    };
    std::thread::Builder::new().spawn(reopen).ok()
}

fn is_lost(arm: &Arm) -> bool {
    arm.handle.load(Ordering::Acquire) == hd::INVALID_HANDLE
}

/// Opens the lost arms with the scheduler stopped, as the driver requires.
fn reopen_lost_arms(servo: &Servo, names: &[CString], settings: &Settings) {
    // SAFETY: published prototypes; no other thread starts or stops the scheduler while the reopener runs.
    unsafe { (servo.api.stop_scheduler)() };
    for (name, arm) in names.iter().zip(&servo.arms).filter(|(_, arm)| is_lost(arm)) {
        close_arm(&servo.api, arm);
        // An arm that cannot be opened yet is tried again after the interval.
        if let Ok(OpenedArm { handle, .. }) = open_arm(&servo.api, name, settings) {
            arm.counters.recoveries.fetch_add(1, Ordering::Relaxed);
            arm.set_open(handle, servo.now_ns());
        }
    }
    servo.api.clear_errors();
    // SAFETY: as above.
    unsafe { (servo.api.start_scheduler)() };
    servo.api.clear_errors();
}

/// Closes all arms; the scheduler must be stopped.
fn close_arms(servo: &Servo) {
    for arm in &servo.arms {
        arm.handle.store(hd::INVALID_HANDLE, Ordering::Release);
        close_arm(&servo.api, arm);
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let (lock, wake) = &*self.is_ending;
        *lock.lock().unwrap_or_else(PoisonError::into_inner) = true;
        wake.notify_all();
        if let Some(reopener) = self.reopener.take() {
            let _ = reopener.join();
        }
        self.servo.is_closing.store(true, Ordering::Release);
        let begin = Instant::now();
        while !self.servo.is_closed.load(Ordering::Acquire) && begin.elapsed() < CLOSE_TIMEOUT {
            std::thread::sleep(Duration::from_millis(1));
        }
        // SAFETY: published prototypes; the driver does not call back after `unschedule`, so the servo can be dropped.
        unsafe {
            (self.servo.api.stop_scheduler)();
            (self.servo.api.unschedule)(self.callback);
        }
        close_arms(&self.servo);
    }
}
