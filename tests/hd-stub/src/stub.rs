//! The exported functions, and what a test may do to them from behind (`pliant_stub_…`).
#![allow(
    unsafe_code,
    reason = "exports a C interface: pointers are as the real one takes them, null where that says so"
)]

use crate::arm::{Arm, Hand, PEAK};
use nalgebra::Vector3;
use std::cell::Cell;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_char, c_int, c_ulong, c_void};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const INVALID_VALUE: u32 = 0x0101;
const INVALID_OPERATION: u32 = 0x0102;
const BAD_HANDLE: u32 = 0x0104;
const EXCEEDED_MAX_FORCE: u32 = 0x0201;
const ALREADY_INITIATED: u32 = 0x0301;
const COMM_ERROR: u32 = 0x0302;
const COMM_CONFIG_ERROR: u32 = 0x0303;
const ILLEGAL_BEGIN: u32 = 0x0400;
const ILLEGAL_END: u32 = 0x0401;
const FORCE_OUTPUT: u32 = 0x4000;
const FORCE_CLAMPING: u32 = 0x4001;
const CALIBRATED: u32 = 0x5000;
const NEEDS_UPDATE: u32 = 0x5001;
const NOBODY: u32 = 0xffff_ffff;

/// An error record.
#[repr(C)]
pub struct ErrorRecord {
    code: u32,
    internal: c_int,
    handle: u32,
}

struct Device {
    name: String,
    arm: Arm,
    enabled: BTreeSet<u32>,
    framed: bool,
    wanted: Vector3<f64>,
    /// N, what the motors give until the next frame
    force: Vector3<f64>,
    buttons: c_int,
    inkwell: bool,
    calibration: u32,
    /// s, of a hand that comes down and goes up again by itself, until a test takes it
    time: Option<f64>,
}

/// m, where the hand is by itself
fn by_itself(time: f64) -> Vector3<f64> {
    Vector3::new(0.0, 0.0, 0.006 + 0.009 * (std::f64::consts::PI * time).cos())
}

#[derive(Default)]
struct Stub {
    devices: Vec<Option<Device>>,
    current: u32,
    errors: Vec<(u32, u32)>,
    /// Codes the next frames end with.
    inject: Vec<u32>,
    /// Code `schedule` fails with.
    refuse: u32,
    unplugged: bool,
    calibration: u32,
    style: c_int,
    rate: u32,
    callback: Option<(unsafe extern "C" fn(*mut c_void) -> u32, usize)>,
    locale: String,
}

static STUB: Mutex<Option<Stub>> = Mutex::new(None);
static RUNS: AtomicBool = AtomicBool::new(false);
static STALL: AtomicU64 = AtomicU64::new(0);
static THREAD: Mutex<Option<JoinHandle<()>>> = Mutex::new(None);
/// Calls that were against the rules.
static BROKEN: AtomicU64 = AtomicU64::new(0);

thread_local! {
    /// Whether this is the scheduler's thread, where a callback runs.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// What a thread holds while it looks at the stub.
struct Locked(MutexGuard<'static, Option<Stub>>);

fn stub() -> Locked {
    let mut stub = STUB.lock().unwrap_or_else(PoisonError::into_inner);
    stub.get_or_insert_with(|| Stub {
        calibration: CALIBRATED,
        style: 2,
        rate: 1000,
        current: NOBODY,
        ..Stub::default()
    });
    Locked(stub)
}

impl std::ops::Deref for Locked {
    type Target = Stub;
    fn deref(&self) -> &Stub {
        self.0.as_ref().expect("made")
    }
}

impl std::ops::DerefMut for Locked {
    fn deref_mut(&mut self) -> &mut Stub {
        self.0.as_mut().expect("made")
    }
}

impl Stub {
    fn error(&mut self, code: u32) {
        self.errors.push((code, self.current));
        BROKEN.fetch_add(u64::from([ILLEGAL_BEGIN, ILLEGAL_END, INVALID_OPERATION].contains(&code)), Ordering::Relaxed);
    }

    fn device(&mut self) -> Option<&mut Device> {
        let current = self.current as usize;
        self.devices.get_mut(current).and_then(Option::as_mut)
    }

    /// Capabilities change in a callback or while the scheduler stands.
    fn switch(&mut self, capability: u32, on: bool) {
        if RUNS.load(Ordering::Relaxed) && !INSIDE.get() {
            return self.error(INVALID_OPERATION);
        }
        let Some(device) = self.device() else { return self.error(BAD_HANDLE) };
        if on {
            device.enabled.insert(capability);
        } else {
            device.enabled.remove(&capability);
        }
    }
}

unsafe extern "C" {
    fn setlocale(category: c_int, locale: *const c_char) -> *const c_char;
}

/// The locale of numbers, as the process has it.
fn numeric_locale() -> String {
    // SAFETY: asking gives a C string that is copied at once.
    unsafe {
        let text = setlocale(1, std::ptr::null());
        if text.is_null() { String::new() } else { CStr::from_ptr(text).to_string_lossy().into_owned() }
    }
}

// SAFETY of what follows: pointers are what the interface says, large enough for what is asked.

#[unsafe(no_mangle)]
unsafe extern "C" fn hdInitDevice(name: *const c_char) -> u32 {
    let name = if name.is_null() {
        "Default Device".to_owned()
    } else {
        // SAFETY: a C string.
        unsafe { CStr::from_ptr(name) }.to_string_lossy().into_owned()
    };
    let mut stub = stub();
    stub.locale = numeric_locale();
    stub.current = NOBODY;
    if stub.unplugged {
        stub.error(COMM_ERROR);
        return NOBODY;
    }
    if stub.locale != "C" {
        // What a decimal comma does to the configuration.
        stub.error(COMM_CONFIG_ERROR);
        return NOBODY;
    }
    if !["Default Device", "left", "right"].contains(&name.as_str()) {
        stub.error(INVALID_VALUE);
        return NOBODY;
    }
    if stub.devices.iter().flatten().any(|d| d.name == name) {
        stub.error(ALREADY_INITIATED);
        return NOBODY;
    }
    let calibration = stub.calibration;
    let device = Device {
        name,
        arm: Arm::new(by_itself(0.0)),
        enabled: BTreeSet::new(),
        framed: false,
        wanted: Vector3::zeros(),
        force: Vector3::zeros(),
        buttons: 0,
        inkwell: false,
        calibration,
        time: Some(0.0),
    };
    let free = stub.devices.iter().position(Option::is_none).unwrap_or(stub.devices.len());
    if free == stub.devices.len() {
        stub.devices.push(None);
    }
    stub.devices[free] = Some(device);
    stub.current = free as u32;
    stub.current
}

#[unsafe(no_mangle)]
extern "C" fn hdDisableDevice(handle: u32) {
    let mut stub = stub();
    match stub.devices.get_mut(handle as usize) {
        Some(device @ Some(_)) => *device = None,
        _ => stub.error(BAD_HANDLE),
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdMakeCurrentDevice(handle: u32) {
    let mut stub = stub();
    stub.current = handle;
    if stub.device().is_none() {
        stub.error(BAD_HANDLE);
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdBeginFrame(handle: u32) {
    let mut stub = stub();
    stub.current = handle;
    let unplugged = stub.unplugged;
    let Some(device) = stub.device() else { return stub.error(BAD_HANDLE) };
    let again = std::mem::replace(&mut device.framed, true);
    device.wanted = Vector3::zeros();
    if again {
        stub.error(ILLEGAL_BEGIN);
    } else if unplugged {
        stub.error(COMM_ERROR);
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdEndFrame(handle: u32) {
    let mut stub = stub();
    stub.current = handle;
    let unplugged = stub.unplugged;
    let Some(device) = stub.device() else { return stub.error(BAD_HANDLE) };
    if !std::mem::replace(&mut device.framed, false) {
        return stub.error(ILLEGAL_END);
    }
    let (size, clamps) = (device.wanted.norm(), device.enabled.contains(&FORCE_CLAMPING));
    device.force = if device.enabled.contains(&FORCE_OUTPUT) && !unplugged { device.wanted } else { Vector3::zeros() };
    if size > PEAK && !clamps {
        stub.error(EXCEEDED_MAX_FORCE);
    }
    if let Some(code) = stub.inject.pop() {
        // Not the caller's doing.
        stub.errors.push((code, handle));
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdEnable(capability: u32) {
    stub().switch(capability, true);
}

#[unsafe(no_mangle)]
extern "C" fn hdDisable(capability: u32) {
    stub().switch(capability, false);
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdGetBooleanv(what: u32, out: *mut u8) {
    let mut stub = stub();
    match (what, stub.device()) {
        // SAFETY: one value.
        (0x2002, Some(device)) => unsafe { *out = u8::from(device.inkwell) },
        _ => stub.error(0x0100),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdGetIntegerv(what: u32, out: *mut c_int) {
    let mut stub = stub();
    let (style, rate) = (stub.style, stub.rate as c_int);
    let value = match (what, stub.device()) {
        (0x2000, Some(device)) => device.buttons,
        (0x2554, Some(_)) => 3,
        (0x2555, _) => style,
        (0x2600, _) => rate,
        _ => return stub.error(0x0100),
    };
    // SAFETY: one value.
    unsafe { *out = value };
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdGetDoublev(what: u32, out: *mut f64) {
    let mut stub = stub();
    let Some(device) = stub.device() else { return stub.error(BAD_HANDLE) };
    let t = crate::kinematics::quantised(device.arm.angles());
    let tip = 1e3 * crate::kinematics::forward(t);
    let velocity = 1e3 * device.arm.velocity();
    let values: Vec<f64> = match what {
        0x2050 => tip.as_slice().to_vec(),
        0x2051 => velocity.as_slice().to_vec(),
        0x2052 => {
            // The stylus turns with the waist.
            let (s, c) = t[0].sin_cos();
            vec![c, 0.0, s, 0.0, 0.0, 1.0, 0.0, 0.0, -s, 0.0, c, 0.0, tip.x, tip.y, tip.z, 1.0]
        }
        0x2551 => vec![-80.0, -60.0, -35.0, 80.0, 60.0, 35.0],
        0x2602 => vec![0.5],
        0x2603 => vec![PEAK],
        0x2604 => vec![0.88],
        0x2609 => vec![0.002],
        _ => return stub.error(0x0100),
    };
    // SAFETY: as many values as the interface says.
    unsafe { std::slice::from_raw_parts_mut(out, values.len()) }.copy_from_slice(&values);
}

#[unsafe(no_mangle)]
extern "C" fn hdGetString(what: u32) -> *const c_char {
    match what {
        0x2501 => c"a twin of an Omni".as_ptr(),
        0x2504 => c"of no number".as_ptr(),
        _ => c"".as_ptr(),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdSetDoublev(what: u32, from: *const f64) {
    let mut stub = stub();
    if what != 0x2700 {
        return stub.error(0x0100);
    }
    // SAFETY: three values.
    let wanted = Vector3::from_column_slice(unsafe { std::slice::from_raw_parts(from, 3) });
    match stub.device() {
        None => stub.error(BAD_HANDLE),
        Some(device) if !device.framed => stub.error(INVALID_OPERATION),
        Some(device) => device.wanted = wanted,
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdGetError() -> ErrorRecord {
    let (code, handle) = stub().errors.pop().unwrap_or((0, NOBODY));
    ErrorRecord { code, internal: 0, handle }
}

#[unsafe(no_mangle)]
extern "C" fn hdCheckCalibration() -> u32 {
    let mut stub = stub();
    stub.device().map_or(0x5002, |device| device.calibration)
}

#[unsafe(no_mangle)]
extern "C" fn hdUpdateCalibration(_style: u32) {
    let mut stub = stub();
    if let Some(device) = stub.device().filter(|d| d.calibration == NEEDS_UPDATE) {
        device.calibration = CALIBRATED;
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdSetSchedulerRate(rate: c_ulong) {
    let mut stub = stub();
    match rate {
        500 | 1000 | 1600 | 2000 => stub.rate = rate as u32,
        _ => stub.error(INVALID_VALUE),
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdScheduleAsynchronous(
    callback: unsafe extern "C" fn(*mut c_void) -> u32,
    data: *mut c_void,
    _priority: u16,
) -> c_ulong {
    let mut stub = stub();
    if stub.refuse != 0 {
        let code = stub.refuse;
        stub.error(code);
        return 0;
    }
    stub.callback = Some((callback, data as usize));
    1
}

#[unsafe(no_mangle)]
extern "C" fn hdUnschedule(_handle: c_ulong) {
    stub().callback = None;
}

#[unsafe(no_mangle)]
extern "C" fn hdStartScheduler() {
    let mut thread = THREAD.lock().unwrap_or_else(PoisonError::into_inner);
    if thread.is_none() {
        RUNS.store(true, Ordering::Relaxed);
        *thread = Some(std::thread::spawn(run));
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdStopScheduler() {
    RUNS.store(false, Ordering::Relaxed);
    let thread = THREAD.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(thread) = thread {
        let _ = thread.join();
    }
}

/// The servo loop.
fn run() {
    INSIDE.set(true);
    let mut due = Instant::now();
    while RUNS.load(Ordering::Relaxed) {
        let stall = STALL.swap(0, Ordering::Relaxed);
        if stall > 0 {
            std::thread::sleep(Duration::from_millis(stall));
        }
        let (callback, rate) = {
            let stub = stub();
            (stub.callback, stub.rate)
        };
        if let Some((callback, data)) = callback {
            // SAFETY: who scheduled it keeps the data alive until it is taken off.
            unsafe { callback(data as *mut c_void) };
        }
        let period = Duration::from_secs_f64(1.0 / f64::from(rate));
        for device in stub().devices.iter_mut().flatten() {
            if let Some(time) = &mut device.time {
                *time += period.as_secs_f64();
                device.arm.hand = Hand { target: by_itself(*time), stiffness: 300.0, damping: 3.0 };
            }
            device.arm.advance(period.as_secs_f64(), device.force);
        }
        due += period;
        match due.checked_duration_since(Instant::now()) {
            Some(wait) => std::thread::sleep(wait),
            None => due = Instant::now(),
        }
    }
}

/// As it was when it was loaded.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_reset() {
    hdStopScheduler();
    *STUB.lock().unwrap_or_else(PoisonError::into_inner) = None;
    BROKEN.store(0, Ordering::Relaxed);
    STALL.store(0, Ordering::Relaxed);
}

/// The next frame ends with this error.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_inject(code: u32) {
    stub().inject.push(code);
}

/// `schedule` fails with this error; 0: it does not.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_refuse(code: u32) {
    stub().refuse = code;
}

#[unsafe(no_mangle)]
extern "C" fn pliant_stub_plug(plugged: u8) {
    stub().unplugged = plugged == 0;
}

/// The servo loop stands still for a while, ms.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_stall(ms: u64) {
    STALL.store(ms, Ordering::Relaxed);
}

/// Of arms that are opened from now on.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_calibration(state: u32, style: c_int) {
    (stub().calibration, stub().style) = (state, style);
}

/// Of an arm: where its hand wants to be (m), and its spring (N/m).
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_hand(arm: u32, x: f64, y: f64, z: f64, stiffness: f64) {
    if let Some(Some(device)) = stub().devices.get_mut(arm as usize) {
        device.time = None;
        device.arm.hand = Hand { target: Vector3::new(x, y, z), stiffness, damping: 3.0 };
    }
}

/// Of an arm: its buttons, and whether the stylus is in the inkwell.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_stylus(arm: u32, buttons: c_int, inkwell: u8) {
    if let Some(Some(device)) = stub().devices.get_mut(arm as usize) {
        (device.buttons, device.inkwell) = (buttons, inkwell != 0);
    }
}

/// Of an arm: tip (m), force of the motors (N), pull of the hand (N), 1 if output is on; calls against the rules. 11 numbers; NaN if it
/// is not open.
#[unsafe(no_mangle)]
unsafe extern "C" fn pliant_stub_look(arm: u32, out: *mut f64) {
    // SAFETY: the caller gives room for 11.
    let out = unsafe { std::slice::from_raw_parts_mut(out, 11) };
    out.fill(f64::NAN);
    if let Some(Some(device)) = stub().devices.get(arm as usize) {
        out[..3].copy_from_slice(device.arm.tip().as_slice());
        out[3..6].copy_from_slice(device.force.as_slice());
        out[6..9].copy_from_slice(device.arm.pull().as_slice());
        out[9] = f64::from(u8::from(device.enabled.contains(&FORCE_OUTPUT)));
    }
    out[10] = BROKEN.load(Ordering::Relaxed) as f64;
}

/// Whether the last `init` found the locale of numbers to be "C".
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_locale_was_c() -> u8 {
    u8::from(stub().locale == "C")
}
