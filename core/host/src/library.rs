//! Opened plugin libraries.

use crate::calls::{InCall, register};
use crate::elf;
use crate::error::HostError;
use crate::host_table::host_for_init;
use crate::plugin_info::{PluginInfo, PluginKind};
use pliant_plugin_api::abi;
use pliant_plugin_api::kit::Candidate;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// An opened library whose entry table was checked. It is opened once and stays mapped until the program ends.
pub struct Library {
    /// Absolute path of the file.
    path: PathBuf,
    /// Descriptors of the plugins that the library offers, in its order.
    plugins: Vec<PluginInfo>,
    /// Entry table that the entry point of the library returned.
    pub(crate) table: &'static abi::Library,
}

/// Every library opened so far; opening one again returns the same.
static OPENED: Mutex<Vec<&'static Library>> = Mutex::new(Vec::new());

/// Largest number of plugins in one library.
const MAX_PLUGINS: u32 = 256;

#[allow(unsafe_code, reason = "opens a library and reads its entry")]
impl Library {
    /// Opens the library at an absolute path.
    ///
    /// # Errors
    /// Fails for a file that is not a shared library, is truncated, has no entry point, was made for another major version of the interface or
    /// has malformed tables, and if its `init` fails.
    pub fn open(path: &Path) -> Result<&'static Self, HostError> {
        let mut opened = OPENED.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(known) = opened.iter().find(|l| l.path == path) {
            return Ok(known);
        }
        let not_a_library = |reason: String| HostError::NotALibrary { path: path.into(), reason };
        if let Some(reason) = elf::truncation(path) {
            return Err(not_a_library(reason));
        }
        let _in = InCall::enter(register(&path.display().to_string()), "open");
        // SAFETY: running a library's initialisers is what loading a plugin means; the user chose the folder.
        let handle = unsafe { open_now(path) }.map_err(|e| not_a_library(error_chain(&e)))?;
        // SAFETY: the symbol, if there, is the entry table; only `size` and the version are used until it is checked.
        let table: &'static abi::Library = unsafe {
            match handle.get::<*const abi::Library>(abi::ENTRY_SYMBOL) {
                Ok(symbol) if !(*symbol).is_null() => &**symbol,
                _ => return Err(HostError::NoEntry { path: path.into() }),
            }
        };
        std::mem::forget(handle); // never unmapped, see the front page of the crate
        if table.abi_major != abi::ABI_MAJOR {
            return Err(HostError::Abi {
                path: path.into(),
                found: format!("{}.{}", table.abi_major, table.abi_minor),
                expected: format!("{}.{}", abi::ABI_MAJOR, abi::ABI_MINOR),
            });
        }
        let malformed = |reason: String| HostError::Malformed { path: path.into(), reason };
        let plugins = read_plugins(table).map_err(malformed)?;
        let library: &'static Self = Box::leak(Box::new(Self { path: path.into(), plugins, table }));
        library.init()?;
        opened.push(library);
        Ok(library)
    }

    /// Runs the library's `init`, if it has one, with the folder of its file.
    fn init(&'static self) -> Result<(), HostError> {
        let Some(init) = self.table.init else { return Ok(()) };
        let folder = self.path.parent().unwrap_or(Path::new("/")).to_string_lossy().into_owned();
        let folder = CString::new(folder).unwrap_or_default();
        // SAFETY: [main], once, first; the host, which must not be null, drops messages.
        let status = unsafe { init(host_for_init(), folder.as_ptr()) };
        if status == abi::Status::OK {
            return Ok(());
        }
        Err(HostError::Malformed { path: self.path.clone(), reason: format!("`init` failed: {}", status.meaning()) })
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Every plugin in the library.
    pub fn plugins(&self) -> &[PluginInfo] {
        &self.plugins
    }

    /// Plugin `index` for the conformance kit.
    ///
    /// # Panics
    /// If `index` is not below the number of plugins.
    pub fn candidate(&'static self, index: usize) -> Candidate {
        assert!(index < self.plugins.len(), "plugin {index} of {}", self.plugins.len());
        // SAFETY: the entry and every descriptor were checked when the library was opened.
        unsafe { Candidate::from_library(self.table, index as u32) }
    }

    /// The plugin of `kind` whose id, or last part of the id after a dot, is `name`.
    ///
    /// # Errors
    /// [`HostError::NoSuchPlugin`], with the plugins of the library.
    pub fn plugin(&self, kind: PluginKind, name: &str) -> Result<&PluginInfo, HostError> {
        let of_kind = || self.plugins.iter().filter(|p| p.kind == kind);
        let last = |id: &str| id.rsplit('.').next() == Some(name);
        let named = of_kind().find(|p| p.id == name).or_else(|| of_kind().find(|p| last(&p.id)));
        named.ok_or_else(|| {
            let offered = self.plugins.iter().map(|p| format!("{} `{}`", p.kind.name(), p.id)).collect::<Vec<_>>();
            HostError::NoSuchPlugin {
                path: self.path.clone(),
                kind: kind.name(),
                id: name.to_owned(),
                offered: if offered.is_empty() { "no plugins".into() } else { offered.join(", ") },
            }
        })
    }

    /// The plugin of `kind` if the library has exactly one; it may then be named by the library.
    pub fn only_plugin(&self, kind: PluginKind) -> Option<&PluginInfo> {
        let mut of_kind = self.plugins.iter().filter(|p| p.kind == kind);
        of_kind.next().filter(|_| of_kind.next().is_none())
    }
}

/// An error and its sources: the message of the linker is the innermost.
fn error_chain(error: &dyn std::error::Error) -> String {
    error.source().map_or_else(|| error.to_string(), |source| format!("{error}: {}", error_chain(source)))
}

/// Opens a library and binds every symbol at once: a first call inside a servo loop must not run the dynamic linker.
#[allow(unsafe_code, reason = "opens a library")]
unsafe fn open_now(path: &Path) -> Result<libloading::Library, libloading::Error> {
    #[cfg(unix)]
    {
        use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
        // SAFETY: the caller's promise.
        unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
    }
    #[cfg(not(unix))]
    {
        // SAFETY: the caller's promise.
        unsafe { libloading::Library::new(path) }
    }
}

/// Descriptors of all plugins of a library; the error says what is wrong with its entry.
#[allow(unsafe_code, reason = "calls the entry's functions")]
fn read_plugins(table: &'static abi::Library) -> Result<Vec<PluginInfo>, String> {
    if table.size < size_of::<abi::Library>() {
        return Err(format!("entry of {} bytes, at least {} needed", table.size, size_of::<abi::Library>()));
    }
    let Some(descriptor) = table.descriptor else { return Err("entry: `descriptor` is null".into()) };
    if table.create.is_none() {
        return Err("entry: `create` is null".into());
    }
    let mut plugins: Vec<PluginInfo> = Vec::new();
    for index in 0..=MAX_PLUGINS {
        // SAFETY: [any]; the pointer is null or a descriptor that lives as long as the library.
        let Some(raw) = (unsafe { descriptor(index).as_ref() }) else { return Ok(plugins) };
        // SAFETY: as above.
        let info = unsafe { PluginInfo::read(raw) }.map_err(|reason| format!("plugin {index}: {reason}"))?;
        if plugins.iter().any(|p| p.id == info.id) {
            return Err(format!("plugin {index}: `{}` is declared twice", info.id));
        }
        plugins.push(info);
    }
    Err(format!("the list of plugins has no end within {MAX_PLUGINS}"))
}
