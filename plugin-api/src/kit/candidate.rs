//! A plugin to be held against the suite: a descriptor, and a way to make instances.
#![allow(unsafe_code, reason = "plays the host")]

use super::opened::Opened;
use crate::abi;
use crate::fault::Fault;
use crate::instance::{DescriptorOf, Role, create};
use core::ffi::CStr;

/// What a plugin is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// See [`abi::KIND_GRID`].
    Grid,
    /// See [`abi::KIND_MATERIAL`].
    Material,
    /// See [`abi::KIND_DEVICE`].
    Device,
}

type Descriptor = Box<dyn Fn() -> *const abi::Descriptor>;
type Create = Box<dyn Fn(*const abi::Host, &CStr) -> *const abi::Plugin>;

/// A plugin of any language, behind its table.
pub struct Candidate {
    descriptor: Descriptor,
    create: Create,
}

impl Candidate {
    /// A Rust plugin that is linked in: `Candidate::of::<AsMaterial<Spring>>()`.
    pub fn of<R: Role>() -> Self {
        let make =
            |host: *const abi::Host, id: &CStr| if id == R::INFO.id { create::<R>(host) } else { core::ptr::null() };
        Self { descriptor: Box::new(DescriptorOf::<R>::GET), create: Box::new(make) }
    }

    /// Plugin `index` of an opened library.
    ///
    /// # Safety
    /// `entry` was checked as a host checks it: version, sizes, functions that are not null, and a descriptor at `index`.
    pub unsafe fn exported(entry: &'static abi::Library, index: u32) -> Self {
        let (descriptor, create) = (entry.descriptor.expect("checked"), entry.create.expect("checked"));
        Self {
            // SAFETY: [any].
            descriptor: Box::new(move || unsafe { descriptor(index) }),
            // SAFETY: [main]; the suite runs on one thread.
            create: Box::new(move |host, id| unsafe { create(host, id.as_ptr()) }),
        }
    }

    /// What it says of itself. Asked anew each time.
    pub fn descriptor(&self) -> &'static abi::Descriptor {
        // SAFETY: a descriptor lives as long as its library, which is never unloaded.
        unsafe { &*(self.descriptor)() }
    }

    /// Its id.
    pub fn id(&self) -> &'static CStr {
        // SAFETY: strings of a descriptor live as long as the library.
        unsafe { CStr::from_ptr(self.descriptor().id) }
    }

    /// What it is; a kind of a later version counts as none.
    pub fn kind(&self) -> Option<Kind> {
        match self.descriptor().kind {
            abi::KIND_GRID => Some(Kind::Grid),
            abi::KIND_MATERIAL => Some(Kind::Material),
            abi::KIND_DEVICE => Some(Kind::Device),
            _ => None,
        }
    }

    /// Its parameters.
    pub fn params(&self) -> Vec<&'static abi::Param> {
        let d = self.descriptor();
        // SAFETY: the header: parameters follow each other `param_size` apart and live as long as the library.
        (0..d.param_count).map(|i| unsafe { &*d.params.byte_add(i * d.param_size) }).collect()
    }

    /// Key of a parameter.
    pub fn key(param: &abi::Param) -> &'static str {
        // SAFETY: strings of a descriptor live as long as the library.
        unsafe { CStr::from_ptr(param.key) }.to_str().unwrap_or("?")
    }

    /// The choices of a parameter, or its columns.
    pub fn choices(param: &abi::Param) -> Vec<&'static str> {
        if param.choices.is_null() {
            return Vec::new();
        }
        // SAFETY: as above.
        unsafe { CStr::from_ptr(param.choices) }.to_str().unwrap_or("").split('|').collect()
    }

    /// The raw instance function.
    pub(super) fn create(&self, host: *const abi::Host, id: &CStr) -> *const abi::Plugin {
        (self.create)(host, id)
    }

    /// Makes an instance, sets numbers by place, and activates it.
    ///
    /// # Errors
    /// What the plugin says.
    pub fn open(&self, numbers: &[(usize, f64)]) -> Result<Opened, Fault> {
        let mut opened = Opened::new(self)?;
        for &(place, value) in numbers {
            opened.set(place as u32, value)?;
        }
        opened.activate()?;
        Ok(opened)
    }
}
