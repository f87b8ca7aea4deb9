//! Instances of plugins: creation, parameters, activation, calls, and destruction on drop.

use crate::calls::{InCall, register};
use crate::error::HostError;
use crate::host_table::host_table;
use crate::library::Library;
use crate::messages::{Inbox, NewMessages};
use crate::plugin_info::{ParamKind, ParamValue, PluginInfo, PluginKind};
use pliant_plugin_api::abi::{self, Status};
use std::ffi::{CStr, CString, c_void};
use std::sync::atomic::{AtomicBool, Ordering};

/// Values of parameters by their index in [`PluginInfo::params`]; parameters that are not listed keep their defaults.
pub type ParamSettings = Vec<(usize, ParamValue)>;

/// A table of functions that an instance offers under a name.
#[derive(Clone, Copy)]
pub(crate) struct Extension {
    /// Name in the interface, such as `pliant.grid/1`.
    id: &'static CStr,
    /// Smallest size of the table, bytes.
    size: usize,
}

impl Extension {
    /// The extension `id` with a table of type `T`.
    pub(crate) const fn new<T>(id: &'static CStr) -> Self {
        Self { id, size: size_of::<T>() }
    }
}

/// An instance of a plugin and the table of its main extension.
pub(crate) struct Instance {
    /// Index of its name on the call board.
    board_index: u32,
    /// Library of the plugin.
    library: &'static Library,
    /// Id of the plugin.
    id: String,
    /// The plugin's table, first argument of every call.
    plugin: *const abi::Plugin,
    /// Table of the main extension.
    extension: *const c_void,
    /// Messages of the plugin; owned.
    inbox: *mut Inbox,
    /// Functions that the plugin calls; owned.
    host: *mut abi::Host,
    /// Whether it was activated.
    active: bool,
    /// Whether a call panicked.
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
    /// Creates an instance with the main extension `extension`, sets its parameters and activates it for steps of up to `dt` (s).
    pub(crate) fn open(
        library: &'static Library,
        info: &PluginInfo,
        settings: &ParamSettings,
        dt: f64,
        extension: Extension,
    ) -> Result<Self, HostError> {
        let mut instance = Self::create(library, info, settings, extension)?;
        let limits = abi::Limits { size: size_of::<abi::Limits>(), dt };
        // SAFETY: [main & !active]; `create` checked it.
        let activate = || unsafe { ((*instance.plugin).activate.expect("checked"))(instance.plugin, &limits) };
        instance.run_input("activate", activate)?;
        instance.active = true;
        Ok(instance)
    }

    /// Creates an instance and sets its parameters without activating it.
    pub(crate) fn create(
        library: &'static Library,
        info: &PluginInfo,
        settings: &ParamSettings,
        extension: Extension,
    ) -> Result<Self, HostError> {
        let create = library.table.create.expect("checked when the library was opened");
        let id = CString::new(info.id.as_str()).expect("came from a C string");
        let inbox = Box::into_raw(Box::<Inbox>::default());
        let host = Box::into_raw(Box::new(host_table(inbox.cast())));
        let board_index = register(&format!("`{}` ({})", info.id, library.path().display()));
        let in_call = InCall::enter(board_index, "create");
        // SAFETY: [main]; the host table lives until the instance is dropped.
        let plugin = unsafe { create(host, id.as_ptr()) };
        drop(in_call);
        let mut instance = Self {
            board_index,
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
        instance.check_tables(extension)?;
        for (index, value) in settings {
            instance.set_param(info, *index, value)?;
        }
        Ok(instance)
    }

    /// Checks the instance's own table and looks up that of its main extension.
    fn check_tables(&mut self, Extension { id, size: needed }: Extension) -> Result<(), HostError> {
        // SAFETY: `create` returned it; only `size` is used until it is checked.
        let table = unsafe { &*self.plugin };
        let is_complete = table.size >= size_of::<abi::Plugin>()
            && table.destroy.is_some()
            && table.set_number.is_some()
            && table.set_text.is_some()
            && table.set_table.is_some()
            && table.activate.is_some()
            && table.deactivate.is_some();
        let (true, Some(get)) = (is_complete, table.extension) else {
            return Err(self.error("create", "the instance's table is too small or has a null in it"));
        };
        // SAFETY: [any]; null or a table that lives as long as the library, starting with its size.
        let found = unsafe { get(self.plugin, id.as_ptr()) };
        if found.is_null() {
            return Err(self.error("extension", &format!("`{}` is not offered", id.to_string_lossy())));
        }
        // SAFETY: every table of the interface starts with its size.
        let size = unsafe { *found.cast::<usize>() };
        if size < needed {
            let text = format!("`{}` has {size} bytes, {needed} needed", id.to_string_lossy());
            return Err(self.error("extension", &text));
        }
        self.extension = found;
        Ok(())
    }

    /// Sets the parameter `index`, after checking the value against its declaration.
    fn set_param(&self, info: &PluginInfo, index: usize, value: &ParamValue) -> Result<(), HostError> {
        let param = &info.params[index];
        let refused = |reason| HostError::Param { plugin: info.id.clone(), key: param.key.clone(), reason };
        param.check(value).map_err(refused)?;
        // SAFETY: only called after `check_tables`.
        let table = unsafe { &*self.plugin };
        let (number, text, rows) = (table.set_number, table.set_text, table.set_table);
        let (number, text, rows) = (number.expect("checked"), text.expect("checked"), rows.expect("checked"));
        let i = index as u32;
        let _in = InCall::enter(self.board_index, "set_param");
        // SAFETY: [main & !active]; strings and spans live for the call.
        let status = unsafe {
            match (&param.kind, value) {
                (ParamKind::Choice { choices, .. }, ParamValue::Text(choice)) => {
                    let index = choices.iter().position(|c| c == choice).expect("checked above");
                    number(self.plugin, i, index as f64)
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
        if status == Status::OK { Ok(()) } else { Err(refused(self.with_message(status.meaning()))) }
    }

    /// The table of another extension; `None` if the instance does not offer it or the table is too small.
    pub(crate) fn extension_table(&self, Extension { id, size }: Extension) -> Option<*const c_void> {
        // SAFETY: only called after `check_tables`.
        let get = unsafe { (*self.plugin).extension }?;
        // SAFETY: [any]; null or a table that lives as long as the library, starting with its size.
        let found = unsafe { get(self.plugin, id.as_ptr()) };
        // SAFETY: every table of the interface starts with its size.
        (!found.is_null() && unsafe { *found.cast::<usize>() } >= size).then_some(found)
    }

    /// The table of the main extension.
    ///
    /// # Safety
    /// `T` is the table type of the extension this was created with.
    pub(crate) unsafe fn table<T>(&self) -> &'static T {
        // SAFETY: checked at `create` to be at least as large as `T`; lives as long as the library.
        unsafe { &*self.extension.cast() }
    }

    /// The pointer that is the first argument of every call.
    pub(crate) fn plugin(&self) -> *const abi::Plugin {
        self.plugin
    }

    /// Makes a call, which is on the call board while it lasts.
    #[inline]
    pub(crate) fn within<T>(&self, call: &'static str, make: impl FnOnce() -> T) -> T {
        let _in = InCall::enter(self.board_index, call);
        make()
    }

    /// Makes a call and turns its status into a result.
    #[inline]
    pub(crate) fn run(&self, call: &'static str, make: impl FnOnce() -> Status) -> Result<(), HostError> {
        self.check(call, self.within(call, make))
    }

    /// Makes a call that passes values of the scene, and turns its status into a result.
    pub(crate) fn run_input(&self, call: &'static str, make: impl FnOnce() -> Status) -> Result<(), HostError> {
        self.check_input(call, self.within(call, make))
    }

    /// Turns a status into a result. A panic quarantines the instance: it is not called again.
    #[inline]
    pub(crate) fn check(&self, call: &'static str, status: Status) -> Result<(), HostError> {
        if status == Status::OK { Ok(()) } else { Err(self.failed(call, status)) }
    }

    /// Turns the status of a call that passes values of the scene into a result: a bad argument is an error of the scene.
    pub(crate) fn check_input(&self, call: &'static str, status: Status) -> Result<(), HostError> {
        if status != Status::BAD_ARGUMENT {
            return self.check(call, status);
        }
        let (plugin, path) = (self.id.clone(), self.library.path().to_path_buf());
        Err(HostError::Refused { plugin, path, reason: self.with_message(status.meaning()) })
    }

    /// The error of a call that failed.
    #[cold]
    fn failed(&self, call: &'static str, status: Status) -> HostError {
        if status == Status::PANICKED {
            self.quarantined.store(true, Ordering::Relaxed);
        }
        self.error(call, status.meaning())
    }

    /// An error of this instance in `call`, with the last error message of the plugin.
    pub(crate) fn error(&self, call: &'static str, what: &str) -> HostError {
        let (plugin, path) = (self.id.clone(), self.library.path().to_path_buf());
        HostError::Call { plugin, path, call, reason: self.with_message(what) }
    }

    /// `what`, followed by the last error message of the plugin if there is one.
    fn with_message(&self, what: &str) -> String {
        let last = self.messages().messages.into_iter().rev().find(|m| m.severity == abi::ERROR);
        last.map_or_else(|| what.to_owned(), |m| format!("{what}: {}", m.text))
    }

    /// Whether the plugin panicked in a call.
    pub(crate) fn is_quarantined(&self) -> bool {
        self.quarantined.load(Ordering::Relaxed)
    }

    /// Makes a call in which warnings of the plugin are about elements, and turns its status into a result.
    pub(crate) fn run_about_elements(
        &self,
        call: &'static str,
        make: impl FnOnce() -> Status,
    ) -> Result<(), HostError> {
        self.run(call, || self.inbox().about_elements(make))
    }

    /// The inbox of the plugin's messages.
    pub(crate) fn inbox(&self) -> &Inbox {
        // SAFETY: the inbox lives until this is dropped, and is `Sync`.
        unsafe { &*self.inbox }
    }

    /// Messages of the plugin since the last call.
    pub(crate) fn messages(&self) -> NewMessages {
        self.inbox().take()
    }

    /// Descriptor of the plugin, which is of `kind`.
    pub(crate) fn info(&self, kind: PluginKind) -> &'static PluginInfo {
        self.library.plugin(kind, &self.id).expect("opened from it")
    }

    /// Library of the plugin.
    pub(crate) fn library(&self) -> &'static Library {
        self.library
    }
}

#[allow(unsafe_code, reason = "ends what `open` began")]
impl Drop for Instance {
    fn drop(&mut self) {
        let _in = InCall::enter(self.board_index, "destroy");
        // SAFETY: [main]; the instance has no other user any more, so its host and inbox are freed after it.
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
