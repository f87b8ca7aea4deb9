//! An instance of a Rust plugin behind the C interface: it holds the parameter values, and between `activate` and `deactivate` the
//! material, grid, device or contact law.
//!
//! Every function the host can call goes through `guarded`: it catches a panic (one that left an `extern "C"` function would abort
//! the host), turns it into a status, reports its message to the host and refuses all later calls of the instance.

use crate::abi::{self, Plugin, Status};
use crate::fault::Fault;
use crate::info::Info;
use crate::param::{Params, Table, Value, defaults};
use core::cell::UnsafeCell;
use core::ffi::{CStr, c_char, c_void};
use core::sync::atomic::{AtomicBool, Ordering};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What the instances of a material, a grid or a device have of their own: the type of the object and its function tables.
pub trait Role: Sized + 'static {
    /// The object an active instance holds.
    type Object: 'static;
    /// The plugin's descriptor.
    const INFO: Info;
    /// [`abi::KIND_MATERIAL`], [`abi::KIND_GRID`], [`abi::KIND_DEVICE`] or [`abi::KIND_CONTACT_LAW`].
    const KIND: u32;
    /// Flags of the descriptor that not every plugin has ([`abi::FLAG_WHOLE_LISTS`]).
    const FLAGS: u32 = 0;
    /// Id of the extension every instance of this kind offers.
    const EXTENSION: &'static CStr;
    /// Function table of that extension.
    fn table() -> *const c_void;
    /// Function table of an optional extension, or null where it is not offered.
    fn optional_table(_id: &CStr) -> *const c_void {
        core::ptr::null()
    }
    /// Makes the object from its parameters.
    ///
    /// # Errors
    /// A combination of parameters it cannot work with.
    fn activate(params: &Params<'_>) -> Result<Self::Object, Fault>;
}

/// Holds the descriptor of a role as a static.
pub struct DescriptorOf<R>(core::marker::PhantomData<R>);

impl<R: Role> DescriptorOf<R> {
    const SHARED: &'static abi::Shared<abi::Descriptor> = &abi::Shared(R::INFO.descriptor(R::KIND, R::FLAGS));
    /// Function that gives a pointer to the descriptor.
    pub const GET: fn() -> *const abi::Descriptor = || &raw const Self::SHARED.0;
}

/// An instance, from `create` to `destroy`.
struct Instance<R: Role> {
    plugin: Plugin,
    host: *const abi::Host,
    /// Parameter values, in the order of the declarations.
    values: UnsafeCell<Vec<Value>>,
    /// The material, grid, device or contact law while active.
    object: UnsafeCell<Option<R::Object>>,
    /// Set by a panic: every later call is refused.
    poisoned: AtomicBool,
}

/// Makes an instance with default parameters. It lives until the host calls its `destroy`.
pub fn create<R: Role>(host: *const abi::Host) -> *const Plugin {
    let plugin = Plugin {
        size: size_of::<Plugin>(),
        descriptor: DescriptorOf::<R>::GET(),
        data: core::ptr::null_mut(),
        destroy: Some(destroy::<R>),
        set_number: Some(set_number::<R>),
        set_text: Some(set_text::<R>),
        set_table: Some(set_table::<R>),
        activate: Some(activate::<R>),
        deactivate: Some(deactivate::<R>),
        extension: Some(extension::<R>),
    };
    let instance = Box::into_raw(Box::new(Instance::<R> {
        plugin,
        host,
        values: UnsafeCell::new(defaults(R::INFO.params)),
        object: UnsafeCell::new(None),
        poisoned: AtomicBool::new(false),
    }));
    #[allow(unsafe_code, reason = "the box was just made and has no other user")]
    // SAFETY: `instance` was just made, so the writes and the reference to its first field are unique and in bounds.
    unsafe {
        (*instance).plugin.data = instance.cast();
        &raw const (*instance).plugin
    }
}

/// Runs `body` with a shared reference to the active object of `plugin`.
///
/// # Safety
/// `plugin` came from [`create`] with this role, is alive, and no `activate`, `deactivate` or exclusive call runs.
#[allow(unsafe_code, reason = "dereferences the host's pointer")]
pub unsafe fn call<R: Role, F: FnOnce(&R::Object) -> Result<(), Fault>>(plugin: *const Plugin, body: F) -> Status {
    // SAFETY: the caller's promise; nothing writes the object while shared calls run.
    unsafe {
        guarded::<R>(plugin, |instance| match &*instance.object.get() {
            Some(object) => body(object),
            None => Err(Fault::bad_argument("called while not active")),
        })
    }
}

/// Runs `body` with the parameters set so far, whether the instance is active or not.
///
/// # Safety
/// As for [`call`], and no parameter is being set.
#[allow(unsafe_code, reason = "as `call`")]
pub unsafe fn with_params<R: Role, F: FnOnce(&Params<'_>) -> Result<(), Fault>>(
    plugin: *const Plugin,
    body: F,
) -> Status {
    // SAFETY: the caller's promise; nothing writes the values.
    unsafe { guarded::<R>(plugin, |instance| body(&Params::new(R::INFO.params, &*instance.values.get()))) }
}

/// Runs `body` with an exclusive reference to the active object of `plugin`.
///
/// # Safety
/// As for [`call`], and no other call on this instance runs.
#[allow(unsafe_code, reason = "as `call`")]
pub unsafe fn call_mut<R: Role, F: FnOnce(&mut R::Object) -> Result<(), Fault>>(
    plugin: *const Plugin,
    body: F,
) -> Status {
    // SAFETY: the caller's promise of exclusiveness.
    unsafe {
        guarded::<R>(plugin, |instance| match &mut *instance.object.get() {
            Some(object) => body(object),
            None => Err(Fault::bad_argument("called while not active")),
        })
    }
}

/// Runs `body` on the instance; turns a fault into a status and a report, and a panic into [`Status::PANICKED`].
///
/// # Safety
/// `plugin` came from [`create`] with this role and is alive.
#[allow(unsafe_code, reason = "dereferences the host's pointer")]
unsafe fn guarded<R: Role>(plugin: *const Plugin, body: impl FnOnce(&Instance<R>) -> Result<(), Fault>) -> Status {
    // SAFETY: `data` was set by `create` to the instance that holds `plugin`.
    let instance = unsafe { &*(*plugin).data.cast::<Instance<R>>() };
    if instance.poisoned.load(Ordering::Relaxed) {
        return Status::PANICKED;
    }
    match catch_unwind(AssertUnwindSafe(|| body(instance))) {
        Ok(Ok(())) => Status::OK,
        Ok(Err(fault)) => {
            if !fault.reason.is_empty() {
                report(instance.host, abi::ERROR, &fault.reason);
            }
            fault.status
        }
        Err(payload) => {
            instance.poisoned.store(true, Ordering::Relaxed);
            let text = payload.downcast_ref::<&str>().copied();
            let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
            report(instance.host, abi::ERROR, crate::export::last_panic(text.unwrap_or("panic")).as_str());
            Status::PANICKED
        }
    }
}

/// Passes a warning to the host of `plugin`, cut to the 255 bytes it keeps.
///
/// # Safety
/// `plugin` came from [`create`] with this role and is alive.
#[allow(unsafe_code, reason = "dereferences the host's pointer")]
pub unsafe fn warn<R: Role>(plugin: *const Plugin, text: &str) {
    // SAFETY: `data` was set by `create` to the instance that holds `plugin`.
    let instance = unsafe { &*(*plugin).data.cast::<Instance<R>>() };
    report(instance.host, abi::WARNING, text);
}

/// Passes one line to the host, cut to the 255 bytes it keeps. Does not allocate.
#[allow(unsafe_code, reason = "calls back into the host")]
pub(crate) fn report(host: *const abi::Host, severity: u32, text: &str) {
    let mut line = [0_u8; 256];
    let mut len = text.len().min(255);
    while !text.is_char_boundary(len) {
        len -= 1;
    }
    line[..len].copy_from_slice(&text.as_bytes()[..len]);
    line[..len].iter_mut().filter(|b| **b == 0).for_each(|b| *b = b' ');
    // SAFETY: the host outlives every instance it is handed to; the line is a C string for the call.
    unsafe {
        if let Some(report) = host.as_ref().and_then(|h| h.report) {
            report(host, severity, line.as_ptr().cast());
        }
    }
}

#[allow(unsafe_code, reason = "frees what `create` made")]
unsafe extern "C" fn destroy<R: Role>(plugin: *const Plugin) {
    // SAFETY: the host calls this once, last; `data` is the box of `create`.
    let free = || unsafe { drop(Box::from_raw((*plugin).data.cast::<Instance<R>>())) };
    let _ = catch_unwind(AssertUnwindSafe(free));
}

/// Sets parameter `index`, if it is declared with one of the kinds `accepts`.
///
/// # Safety
/// As [`guarded`], and no other call on this instance runs.
#[allow(unsafe_code, reason = "writes a parameter")]
unsafe fn set<R: Role>(
    plugin: *const Plugin,
    index: u32,
    accepts: &[u32],
    value: impl FnOnce() -> Result<Value, Fault>,
) -> Status {
    // SAFETY: the host sets parameters on [main], while nothing else runs on the instance.
    unsafe {
        guarded::<R>(plugin, |instance| {
            let declared = R::INFO.params.get(index as usize);
            if !declared.is_some_and(|p| accepts.contains(&p.0.kind)) {
                return Err(Fault::bad_argument(format!("no parameter {index} of this type")));
            }
            (&mut *instance.values.get())[index as usize] = value()?;
            Ok(())
        })
    }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn set_number<R: Role>(plugin: *const Plugin, index: u32, value: f64) -> Status {
    let read = || match R::INFO.params[index as usize].0 {
        abi::Param { kind: abi::PARAM_NUMBER, min, max, .. } if !(min..=max).contains(&value) => {
            Err(Fault::bad_argument(format!("parameter {index}: {value} is outside {min} to {max}")))
        }
        abi::Param { kind: abi::PARAM_CHOICE, choices, .. } if !is_choice_index(value, choices) => {
            Err(Fault::bad_argument(format!("parameter {index}: {value} is not the index of a choice")))
        }
        _ if !value.is_finite() => Err(Fault::bad_argument(format!("parameter {index} is not finite"))),
        _ => Ok(Value::Number(value)),
    };
    // SAFETY: [main & !active].
    unsafe { set::<R>(plugin, index, &[abi::PARAM_NUMBER, abi::PARAM_CHOICE], read) }
}

/// Whether a number is the index of one of `choices`, a list `one|two|three`.
fn is_choice_index(value: f64, choices: *const c_char) -> bool {
    #[allow(unsafe_code, reason = "reads back a pointer the constructor took from a CStr")]
    // SAFETY: a parameter of this kind has a list, from a `&'static CStr`.
    let count = unsafe { CStr::from_ptr(choices) }.to_bytes().split(|b| *b == b'|').count();
    value.fract() == 0.0 && value >= 0.0 && value < count as f64
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn set_text<R: Role>(plugin: *const Plugin, index: u32, text: *const c_char) -> Status {
    // SAFETY: [main & !active]; `text` is a C string for the call.
    unsafe {
        set::<R>(plugin, index, &[abi::PARAM_TEXT, abi::PARAM_PATH], || {
            let text = CStr::from_ptr(text).to_str();
            text.map(|t| Value::Text(t.to_owned())).map_err(|_| Fault::bad_argument("text is not UTF-8"))
        })
    }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn set_table<R: Role>(
    plugin: *const Plugin,
    index: u32,
    values: *const f64,
    rows: usize,
    columns: usize,
) -> Status {
    // SAFETY: [main & !active]; `values` holds rows * columns doubles for the call.
    unsafe {
        set::<R>(plugin, index, &[abi::PARAM_TABLE], || {
            let values = if rows * columns == 0 { &[] } else { core::slice::from_raw_parts(values, rows * columns) };
            Ok(Value::Table(Table { columns, values: values.to_vec() }))
        })
    }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn activate<R: Role>(plugin: *const Plugin, _limits: *const abi::Limits) -> Status {
    // SAFETY: [main & !active]: exclusive.
    unsafe {
        guarded::<R>(plugin, |instance| {
            let params = Params::new(R::INFO.params, &*instance.values.get());
            *instance.object.get() = Some(R::activate(&params)?);
            Ok(())
        })
    }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn deactivate<R: Role>(plugin: *const Plugin) {
    // SAFETY: [main & active]: exclusive.
    unsafe {
        guarded::<R>(plugin, |instance| {
            *instance.object.get() = None;
            Ok(())
        });
    }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn extension<R: Role>(_plugin: *const Plugin, id: *const c_char) -> *const c_void {
    // SAFETY: `id` is a C string for the call.
    let id = unsafe { CStr::from_ptr(id) };
    if id == R::EXTENSION { R::table() } else { R::optional_table(id) }
}
