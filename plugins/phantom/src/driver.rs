//! Opening, closing and opening again: everything that may take its time, outside of the servo loop.
#![allow(unsafe_code, reason = "calls a C library; each call says what makes it sound")]

use crate::errors::{self, Class};
use crate::hd::{self, Api, Handle, MOST_PRIORITY, calibration, get, switch};
use crate::locale;
use crate::params::Settings;
use crate::servo::{Arm, MOST_ARMS, Servo};
use core::ffi::{c_ulong, c_void};
use pliant_plugin_api::abi::DeviceInfo;
use std::ffi::CString;
use std::ptr::null;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// One driver library has one scheduler: one instance at a time.
static IN_USE: AtomicBool = AtomicBool::new(false);

/// How long the servo loop is given to leave arms without force.
const PATIENCE: Duration = Duration::from_millis(200);
/// Between two tries to open a lost arm again.
const AGAIN: Duration = Duration::from_millis(250);

/// An open driver with its arms.
pub struct Driver {
    servo: Arc<Servo>,
    arms: Vec<CString>,
    settings: Settings,
    /// What `unschedule` takes back.
    scheduled: c_ulong,
    /// What the arms say they can do.
    pub facts: DeviceInfo,
    /// The thread that opens lost arms again, and what ends it.
    keeper: Option<std::thread::JoinHandle<()>>,
    ended: Arc<(Mutex<bool>, Condvar)>,
}

/// Gives the driver back on every way out.
struct Claim;

impl Claim {
    fn new() -> Result<Self, String> {
        let taken = IN_USE.swap(true, Ordering::AcqRel);
        let text = "the driver is in use; give both arms to one device: `arm` and `second-arm`";
        if taken { Err(text.into()) } else { Ok(Self) }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        IN_USE.store(false, Ordering::Release);
    }
}

impl Driver {
    /// Opens the library and its arms, in the order that works, and starts the servo loop.
    ///
    /// # Errors
    /// What is missing, with the driver's own code.
    pub(crate) fn open(settings: Settings) -> Result<Self, String> {
        let claim = Claim::new()?;
        let api = Api::load(&settings.library)?;
        let names = [Some(settings.arm.as_str()), settings.second.as_deref()];
        let arms: Vec<CString> = names.into_iter().flatten().map(|n| CString::new(n).unwrap_or_default()).collect();
        let servo = Arc::new(Servo {
            api,
            arms: [const { None::<()> }; MOST_ARMS].map(|_| Arm::default()),
            start: Instant::now(),
            ticked: AtomicU64::new(0),
            closing: AtomicBool::new(false),
            closed: AtomicBool::new(false),
            rests: settings.rests,
        });
        let mut facts = None;
        for (name, arm) in arms.iter().zip(&servo.arms) {
            let (handle, found) = bring_up(&servo.api, name, &settings).inspect_err(|_| bring_down(&servo))?;
            let facts = facts.get_or_insert(found);
            facts.peak_force = facts.peak_force.min(found.peak_force);
            facts.continuous_force = facts.continuous_force.min(found.continuous_force);
            facts.stiffness = facts.stiffness.min(found.stiffness);
            arm.limit(found.peak_force);
            arm.opened(handle, servo.now());
        }
        let mut facts = facts.ok_or("no arm is named")?;
        facts.effectors = arms.len() as u32;
        let data = Arc::as_ptr(&servo).cast_mut().cast::<c_void>();
        // SAFETY: the servo lives until `drop` has taken the callback off; what else is given are plain numbers.
        let scheduled = unsafe {
            let scheduled = (servo.api.schedule)(Servo::tick, data, MOST_PRIORITY);
            if let Some(error) = servo.api.clear() {
                (servo.api.unschedule)(scheduled);
                bring_down(&servo);
                return Err(told("the scheduler does not take the servo loop", error.code));
            }
            (servo.api.set_rate)(settings.rate as c_ulong);
            // A rate it does not have is no reason to stop: what it runs at is asked below.
            servo.api.clear();
            (servo.api.start_scheduler)();
            scheduled
        };
        if let Some(error) = servo.api.clear() {
            // SAFETY: as above.
            unsafe { (servo.api.unschedule)(scheduled) };
            bring_down(&servo);
            return Err(told("the servo loop does not start", error.code));
        }
        let rate = servo.api.integer(get::UPDATE_RATE);
        facts.rate = if rate > 0 { f64::from(rate) } else { settings.rate };
        servo.api.clear();
        std::mem::forget(claim);
        let ended = Arc::new((Mutex::new(false), Condvar::new()));
        let mut driver = Self { servo, arms, settings, scheduled, facts, keeper: None, ended };
        driver.keeper = Some(driver.keep());
        Ok(driver)
    }

    /// What is shared with the servo loop.
    pub fn servo(&self) -> &Servo {
        &self.servo
    }

    /// Starts the thread that opens lost arms again: slow, and never inside of a servo loop.
    fn keep(&self) -> std::thread::JoinHandle<()> {
        let (servo, ended) = (Arc::clone(&self.servo), Arc::clone(&self.ended));
        let (names, settings) = (self.arms.clone(), self.settings.clone());
        std::thread::spawn(move || {
            let (lock, wake) = &*ended;
            let mut end = lock.lock().unwrap_or_else(PoisonError::into_inner);
            loop {
                end = wake.wait_timeout(end, AGAIN).unwrap_or_else(PoisonError::into_inner).0;
                if *end {
                    return;
                }
                let lost = |arm: &Arm| arm.handle.load(Ordering::Acquire) == hd::INVALID_HANDLE;
                if servo.arms[..names.len()].iter().any(lost) {
                    recover(&servo, &names, &settings);
                }
            }
        })
    }
}

/// Opens the arms that are lost, with the servo loop stopped, as the driver wants it.
fn recover(servo: &Servo, names: &[CString], settings: &Settings) {
    // SAFETY: published prototypes; nothing else controls the driver while this thread lives.
    unsafe { (servo.api.stop_scheduler)() };
    for (name, arm) in names.iter().zip(&servo.arms) {
        if arm.handle.load(Ordering::Acquire) != hd::INVALID_HANDLE {
            continue;
        }
        give_back(servo, arm);
        if let Ok((handle, _)) = bring_up(&servo.api, name, settings) {
            arm.counts.recovered.fetch_add(1, Ordering::Relaxed);
            arm.opened(handle, servo.now());
        }
    }
    servo.api.clear();
    // SAFETY: as above.
    unsafe { (servo.api.start_scheduler)() };
    servo.api.clear();
}

fn told(what: &str, code: u32) -> String {
    let remedy = match errors::class(code) {
        Class::Licence => "; point OH_SDK_LICENSE_PATH at the driver's licence",
        Class::Lost => "; look at the cable and the power, and run the vendor's diagnosis",
        _ => "",
    };
    format!("{what}: {} ({code:#06x}){remedy}", errors::name(code))
}

/// Opens and calibrates one arm, and asks what it can do.
fn bring_up(api: &Api, name: &std::ffi::CStr, settings: &Settings) -> Result<(Handle, DeviceInfo), String> {
    let _locale = locale::Numeric::c();
    api.clear();
    let shown = name.to_string_lossy();
    // SAFETY: a C string, or null for the default device.
    let handle = unsafe {
        let mut handle = (api.init)(name.as_ptr());
        let mut error = api.clear();
        if name.is_empty() && (error.is_some() || handle == hd::INVALID_HANDLE) {
            handle = (api.init)(null());
            error = api.clear();
        }
        if let Some(error) = error {
            return Err(told(&format!("arm `{shown}`"), error.code));
        }
        handle
    };
    if handle == hd::INVALID_HANDLE {
        return Err(format!("arm `{shown}`: the driver has no such device"));
    }
    let facts = calibrate(api, &shown, settings.patience).map(|()| describe(api, settings)).inspect_err(|_| {
        // SAFETY: the handle was just given.
        unsafe { (api.disable_device)(handle) };
    })?;
    // SAFETY: the scheduler is stopped; the arm is the current one.
    unsafe {
        (api.enable)(switch::FORCE_OUTPUT);
        (api.enable)(switch::FORCE_CLAMPING);
        (api.enable)(switch::FORCE_RAMPING);
    }
    // A device without ramping says so; force output it must have.
    match api.clear() {
        Some(error) if errors::class(error.code) != Class::Usage => Err(told(&format!("arm `{shown}`"), error.code)),
        _ => Ok((handle, facts)),
    }
}

/// Brings the calibration up to date; where it takes a hand, waits for it.
fn calibrate(api: &Api, name: &str, patience: f64) -> Result<(), String> {
    let begun = Instant::now();
    loop {
        // SAFETY: published prototypes; the arm is the current one.
        match unsafe { (api.check_calibration)() } {
            calibration::OK => return Ok(()),
            calibration::NEEDS_UPDATE => {
                let style = api.integer(get::CALIBRATION_STYLE);
                // SAFETY: as above.
                unsafe { (api.update_calibration)(style as u32) };
            }
            calibration::NEEDS_MANUAL_INPUT if api.integer(get::CALIBRATION_STYLE) & calibration::INKWELL != 0 => {
                if begun.elapsed().as_secs_f64() > patience {
                    return Err(format!("arm `{name}` is not calibrated: put the stylus into the inkwell"));
                }
            }
            _ => return Err(format!("arm `{name}` is not calibrated: run the vendor's calibration")),
        }
        if let Some(error) = api.clear() {
            return Err(told(&format!("arm `{name}`: calibration"), error.code));
        }
        if begun.elapsed().as_secs_f64() > patience {
            return Err(format!("arm `{name}`: the calibration does not end"));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What the arm says it can do; what it does not say is taken from the parameters.
fn describe(api: &Api, settings: &Settings) -> DeviceInfo {
    let asked = |what: u32, otherwise: f64| {
        let value = api.numbers(what)[0];
        let failed = api.clear().is_some();
        if !failed && value.is_finite() && value > 0.0 { value } else { otherwise }
    };
    let workspace = api.numbers(get::USABLE_WORKSPACE);
    let known = api.clear().is_none() && (0..3).all(|i| workspace[i] < workspace[i + 3]);
    let axes = api.integer(get::OUTPUT_DOF);
    api.clear();
    let peak = asked(get::FORCE, settings.peak_force).min(settings.peak_force);
    DeviceInfo {
        size: size_of::<DeviceInfo>(),
        effectors: 1,
        buttons: 4,
        driven_axes: if axes > 0 { axes as u32 } else { 3 },
        taxel_rows: 0,
        taxel_columns: 0,
        rate: settings.rate,
        peak_force: peak,
        continuous_force: asked(get::CONTINUOUS_FORCE, 0.88).min(peak),
        // The driver's unit is the millimetre.
        stiffness: 1e3 * asked(get::STIFFNESS, 0.5),
        damping: 1e3 * asked(get::DAMPING, 0.002),
        resolution: settings.resolution,
        workspace: std::array::from_fn(|i| {
            if known { 1e-3 * workspace[i] } else { [-0.08, -0.06, -0.035, 0.08, 0.06, 0.035][i] }
        }),
        taxel_pitch: 0.0,
        taxel_force: 0.0,
    }
}

/// Closes every arm that is open; the scheduler is stopped.
fn bring_down(servo: &Servo) {
    for arm in &servo.arms {
        arm.handle.store(hd::INVALID_HANDLE, Ordering::Release);
        give_back(servo, arm);
    }
}

/// Gives back the handle of an arm, lost or not: the driver opens no device twice.
fn give_back(servo: &Servo, arm: &Arm) {
    let handle = arm.held.swap(hd::INVALID_HANDLE, Ordering::Relaxed);
    if handle != hd::INVALID_HANDLE {
        // SAFETY: a handle of this driver.
        unsafe { (servo.api.disable_device)(handle) };
        servo.api.clear();
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        *self.ended.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.ended.1.notify_all();
        if let Some(keeper) = self.keeper.take() {
            let _ = keeper.join();
        }
        self.servo.closing.store(true, Ordering::Release);
        let begun = Instant::now();
        while !self.servo.closed.load(Ordering::Acquire) && begun.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(1));
        }
        // SAFETY: published prototypes; after `unschedule` nobody calls back, so the servo may go.
        unsafe {
            (self.servo.api.stop_scheduler)();
            (self.servo.api.unschedule)(self.scheduled);
        }
        bring_down(&self.servo);
        drop(Claim);
    }
}

/// Opens a library, and says what it has: for a probe.
pub(crate) fn look(settings: &Settings) -> Result<String, String> {
    let _claim = Claim::new()?;
    let api = Api::load(&settings.library)?;
    let name = CString::new(settings.arm.as_str()).unwrap_or_default();
    let (handle, facts) = bring_up(&api, &name, settings)?;
    let (model, serial) = (api.text(get::MODEL), api.text(get::SERIAL));
    // SAFETY: the handle was just given; the scheduler never ran.
    unsafe {
        (api.disable)(switch::FORCE_OUTPUT);
        (api.disable_device)(handle);
    }
    api.clear();
    Ok(format!("{model} {serial}, {} N", facts.peak_force))
}
