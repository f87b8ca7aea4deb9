//! One instance of a plugin: made, given its parameters, active until dropped.

use super::error::HostError;
use super::face::host_table;
use super::library::Library;
use super::plugin::{Kind, ParamKind, ParamValue, PluginInfo};
use super::report::{Inbox, Message};
use pliant_plugin_api::abi::{self, Status};
use std::ffi::{CStr, CString, c_void};
use std::sync::atomic::{AtomicBool, Ordering};

/// Parameters by place in the plugin's list; those not named keep their defaults.
pub type Settings = Vec<(usize, ParamValue)>;

/// An active instance, and the table of its kind.
pub(super) struct Instance {
    library: &'static Library,
    id: String,
    plugin: *const abi::Plugin,
    extension: *const c_void,
    inbox: *mut Inbox,
    host: *mut abi::Host,
    active: bool,
    quarantined: AtomicBool,
}

#[allow(unsafe_code, reason = "holds pointers whose thread rules the header states")]
// SAFETY: the plugin's functions carry thread classes; this type calls [main] functions from `open` and `drop` only, which
// have it exclusively, and its users keep to the classes of the rest.
unsafe impl Send for Instance {}
#[allow(unsafe_code, reason = "as above")]
// SAFETY: as above: what can be called through `&self` is [any], [sim] or [servo], each within its class.
unsafe impl Sync for Instance {}

#[allow(unsafe_code, reason = "calls the instance's functions")]
impl Instance {
    /// Makes, sets and activates an instance that offers `extension`, a table of at least `table_size` bytes.
    pub(super) fn open(
        library: &'static Library,
        info: &PluginInfo,
        settings: &Settings,
        dt: f64,
        extension: &CStr,
        table_size: usize,
    ) -> Result<Self, HostError> {
        let mut instance = Self::make(library, info, settings, extension, table_size)?;
        let limits = abi::Limits { size: size_of::<abi::Limits>(), dt };
        // SAFETY: [main & !active]; `make` checked it.
        let status = unsafe { ((*instance.plugin).activate.expect("checked"))(instance.plugin, &limits) };
        instance.taken("activate", status)?;
        instance.active = true;
        Ok(instance)
    }

    /// The same without activating it.
    pub(super) fn make(
        library: &'static Library,
        info: &PluginInfo,
        settings: &Settings,
        extension: &CStr,
        table_size: usize,
    ) -> Result<Self, HostError> {
        let create = library.table.create.expect("checked when the library was opened");
        let id = CString::new(info.id.as_str()).expect("came from a C string");
        let inbox = Box::into_raw(Box::<Inbox>::default());
        let host = Box::into_raw(Box::new(host_table(inbox.cast())));
        // SAFETY: [main]; the host table lives until the instance is dropped.
        let plugin = unsafe { create(host, id.as_ptr()) };
        let mut instance = Self {
            library,
            id: info.id.clone(),
            plugin,
            extension: std::ptr::null(),
            inbox,
            host,
            active: false,
            quarantined: AtomicBool::new(false),
        };
        if plugin.is_null() {
            return Err(instance.error("create", "refused"));
        }
        instance.check_tables(extension, table_size)?;
        for (index, value) in settings {
            instance.set(info, *index, value)?;
        }
        Ok(instance)
    }

    fn check_tables(&mut self, extension: &CStr, table_size: usize) -> Result<(), HostError> {
        // SAFETY: `create` gave it; only `size` is believed until checked.
        let table = unsafe { &*self.plugin };
        let whole = table.size >= size_of::<abi::Plugin>()
            && table.destroy.is_some()
            && table.set_number.is_some()
            && table.set_text.is_some()
            && table.set_table.is_some()
            && table.activate.is_some()
            && table.deactivate.is_some();
        let (true, Some(get)) = (whole, table.extension) else {
            return Err(self.error("create", "the instance's table is too small or has a null in it"));
        };
        // SAFETY: [any]; null or a table that lives as long as the library, starting with its size.
        let found = unsafe { get(self.plugin, extension.as_ptr()) };
        if found.is_null() {
            return Err(self.error("extension", &format!("`{}` is not offered", extension.to_string_lossy())));
        }
        // SAFETY: every table of the interface starts with its size.
        let size = unsafe { *found.cast::<usize>() };
        if size < table_size {
            let text = format!("`{}` has {size} bytes, {table_size} needed", extension.to_string_lossy());
            return Err(self.error("extension", &text));
        }
        self.extension = found;
        Ok(())
    }

    fn set(&self, info: &PluginInfo, index: usize, value: &ParamValue) -> Result<(), HostError> {
        let param = &info.params[index];
        let refused = |reason| HostError::Param { plugin: info.id.clone(), key: param.key.clone(), reason };
        param.check(value).map_err(refused)?;
        // SAFETY: only called after `check_tables`.
        let table = unsafe { &*self.plugin };
        let (number, text, rows) = (table.set_number, table.set_text, table.set_table);
        let (number, text, rows) = (number.expect("checked"), text.expect("checked"), rows.expect("checked"));
        let i = index as u32;
        // SAFETY: [main & !active]; strings and spans live for the call.
        let status = unsafe {
            match (&param.kind, value) {
                (ParamKind::Choice { choices, .. }, ParamValue::Text(choice)) => {
                    let place = choices.iter().position(|c| c == choice).expect("checked above");
                    number(self.plugin, i, place as f64)
                }
                (_, ParamValue::Number(value)) => number(self.plugin, i, *value),
                (_, ParamValue::Text(value)) => {
                    let value = CString::new(value.as_str()).expect("checked above");
                    text(self.plugin, i, value.as_ptr())
                }
                (_, ParamValue::Table { columns, values }) => {
                    rows(self.plugin, i, values.as_ptr(), values.len() / columns.max(&1), *columns)
                }
            }
        };
        if status == Status::OK { Ok(()) } else { Err(refused(self.reason(status.meaning()))) }
    }

    /// Another table the instance may offer, of at least `size` bytes.
    pub(super) fn other_table(&self, extension: &CStr, size: usize) -> Option<*const c_void> {
        // SAFETY: only called after `check_tables`.
        let get = unsafe { (*self.plugin).extension }?;
        // SAFETY: [any]; null or a table that lives as long as the library, starting with its size.
        let found = unsafe { get(self.plugin, extension.as_ptr()) };
        // SAFETY: every table of the interface starts with its size.
        (!found.is_null() && unsafe { *found.cast::<usize>() } >= size).then_some(found)
    }

    /// The table of the kind.
    ///
    /// # Safety
    /// `T` is the table of the extension this was opened with.
    pub(super) unsafe fn table<T>(&self) -> &'static T {
        // SAFETY: checked at `open` to be at least as large as `T`; lives as long as the library.
        unsafe { &*self.extension.cast() }
    }

    /// What goes first into every call.
    pub(super) fn plugin(&self) -> *const abi::Plugin {
        self.plugin
    }

    /// Turns a status into a result. A panic quarantines the instance: it is not called again.
    #[inline]
    pub(super) fn done(&self, call: &'static str, status: Status) -> Result<(), HostError> {
        if status == Status::OK { Ok(()) } else { Err(self.failed(call, status)) }
    }

    /// The same, of a call that hands over what the scene says: a bad argument is the scene's.
    pub(super) fn taken(&self, call: &'static str, status: Status) -> Result<(), HostError> {
        if status != Status::BAD_ARGUMENT {
            return self.done(call, status);
        }
        let (plugin, path) = (self.id.clone(), self.library.path().to_path_buf());
        Err(HostError::Refused { plugin, path, reason: self.reason(status.meaning()) })
    }

    #[cold]
    fn failed(&self, call: &'static str, status: Status) -> HostError {
        if status == Status::PANICKED {
            self.quarantined.store(true, Ordering::Relaxed);
        }
        self.error(call, status.meaning())
    }

    /// An error of this instance, with what the plugin said last.
    pub(super) fn error(&self, call: &'static str, what: &str) -> HostError {
        let (plugin, path) = (self.id.clone(), self.library.path().to_path_buf());
        HostError::Call { plugin, path, call, reason: self.reason(what) }
    }

    fn reason(&self, what: &str) -> String {
        let said = self.messages().0.into_iter().rev().find(|m| m.severity == abi::ERROR);
        said.map_or_else(|| what.to_owned(), |m| format!("{what}: {}", m.text))
    }

    /// Whether it panicked.
    pub(super) fn is_quarantined(&self) -> bool {
        self.quarantined.load(Ordering::Relaxed)
    }

    /// What it said since the last time, and how many lines were lost.
    pub(super) fn messages(&self) -> (Vec<Message>, u64) {
        // SAFETY: the inbox lives until this is dropped, and is made to be shared.
        unsafe { &*self.inbox }.take()
    }

    /// The descriptor it was opened from.
    pub(super) fn info(&self, kind: Kind) -> &'static PluginInfo {
        self.library.plugin(kind, &self.id).expect("opened from it")
    }

    /// The file it came from.
    pub(super) fn library(&self) -> &'static Library {
        self.library
    }
}

#[allow(unsafe_code, reason = "ends what `open` began")]
impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: [main]; nobody else has the instance any more, so its host and inbox go after it.
        unsafe {
            if let Some(table) = self.plugin.as_ref() {
                if let (true, Some(deactivate)) = (self.active, table.deactivate) {
                    deactivate(self.plugin);
                }
                if let Some(destroy) = table.destroy {
                    destroy(self.plugin);
                }
            }
            drop(Box::from_raw(self.host));
            drop(Box::from_raw(self.inbox));
        }
    }
}
