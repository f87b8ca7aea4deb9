//! A plugin to run the conformance suite on: its descriptor, and a way to make instances.
#![allow(unsafe_code, reason = "plays the host")]

use super::allocations::{allocations, counted, live_counted, malloc_calls, malloc_live};
use super::instance::TestInstance;
use super::protected_memory::ProtectedMemory;
use crate::abi;
use crate::fault::Fault;
use crate::instance::{DescriptorOf, Role, create};
use core::ffi::CStr;

/// Kind of a plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A grid ([`abi::KIND_GRID`]).
    Grid,
    /// A material ([`abi::KIND_MATERIAL`]).
    Material,
    /// A device ([`abi::KIND_DEVICE`]).
    Device,
    /// A contact law ([`abi::KIND_CONTACT_LAW`]).
    ContactLaw,
}

type Descriptor = Box<dyn Fn() -> *const abi::Descriptor>;
type Create = Box<dyn Fn(*const abi::Host, &CStr) -> *const abi::Plugin>;

/// A plugin of any language, called through its C tables.
pub struct Candidate {
    descriptor: Descriptor,
    create: Create,
    /// Whether it is linked into the program and allocates with the program's allocator.
    is_linked: bool,
    /// Where arrays lie at guard pages; `None` in a process that must not end by that.
    protected_memory: Option<ProtectedMemory>,
}

impl Candidate {
    /// A Rust plugin that is linked in: `Candidate::of::<AsMaterial<Spring>>()`.
    pub fn of<R: Role>() -> Self {
        let make =
            |host: *const abi::Host, id: &CStr| if id == R::INFO.id { create::<R>(host) } else { core::ptr::null() };
        Self {
            descriptor: Box::new(DescriptorOf::<R>::GET),
            create: Box::new(make),
            is_linked: true,
            protected_memory: None,
        }
    }

    /// Plugin number `index` of an opened library.
    ///
    /// # Safety
    /// `entry` was checked as a host checks it: version, sizes, functions that are not null, and a descriptor at `index`.
    pub unsafe fn from_library(entry: &'static abi::Library, index: u32) -> Self {
        let (descriptor, create) = (entry.descriptor.expect("checked"), entry.create.expect("checked"));
        Self {
            // SAFETY: [any].
            descriptor: Box::new(move || unsafe { descriptor(index) }),
            // SAFETY: [main]; the suite runs on one thread.
            create: Box::new(move |host, id| unsafe { create(host, id.as_ptr()) }),
            is_linked: false,
            protected_memory: None,
        }
    }

    /// The same plugin, with memory whose edges it may not cross. A process that only runs one case has it, for the system ends it at such an access.
    #[must_use]
    pub fn with_protected_memory(self, memory: ProtectedMemory) -> Self {
        Self { protected_memory: Some(memory), ..self }
    }

    /// The memory of [`Candidate::with_protected_memory`].
    pub(super) fn protected_memory(&self) -> Option<ProtectedMemory> {
        self.protected_memory
    }

    /// The descriptor. Each call asks the plugin again.
    pub fn descriptor(&self) -> &'static abi::Descriptor {
        // SAFETY: a descriptor lives as long as its library, which is never unloaded.
        unsafe { &*(self.descriptor)() }
    }

    /// The function that returns the number of allocations of this thread so far, those of the plugin included; `None` where nothing
    /// counts them.
    pub(super) fn allocation_count(&self) -> Option<fn() -> u64> {
        if malloc_calls().is_some() {
            return Some(|| malloc_calls().unwrap_or(0));
        }
        (self.is_linked && allocations().is_some()).then_some(counted)
    }

    /// The function that returns the number of allocations of this thread that were not given back; `None` where nothing counts them.
    pub(super) fn live_count(&self) -> Option<fn() -> i64> {
        if malloc_live().is_some() {
            return Some(|| malloc_live().unwrap_or(0));
        }
        (self.is_linked && allocations().is_some()).then_some(live_counted)
    }

    /// Id of the plugin.
    pub fn id(&self) -> &'static CStr {
        // SAFETY: strings of a descriptor live as long as the library.
        unsafe { CStr::from_ptr(self.descriptor().id) }
    }

    /// Kind of the plugin; `None` for one this version does not know.
    pub fn kind(&self) -> Option<Kind> {
        match self.descriptor().kind {
            abi::KIND_GRID => Some(Kind::Grid),
            abi::KIND_MATERIAL => Some(Kind::Material),
            abi::KIND_DEVICE => Some(Kind::Device),
            abi::KIND_CONTACT_LAW => Some(Kind::ContactLaw),
            _ => None,
        }
    }

    /// The declared parameters, in the order their indices count.
    pub fn params(&self) -> Vec<abi::Param> {
        let d = self.descriptor();
        // SAFETY: the header: parameters of `param_size` bytes follow each other and live as long as the library.
        (0..d.param_count)
            .map(|i| unsafe { abi::Param::read(d.params.byte_add(i * d.param_size), d.param_size) })
            .collect()
    }

    /// Key of a parameter; `?` where it is not UTF-8.
    pub fn key(param: &abi::Param) -> &'static str {
        // SAFETY: strings of a descriptor live as long as the library.
        unsafe { CStr::from_ptr(param.key) }.to_str().unwrap_or("?")
    }

    /// The choices of a parameter, or the columns of a table; empty for other kinds.
    pub fn choices(param: &abi::Param) -> Vec<&'static str> {
        if param.choices.is_null() {
            return Vec::new();
        }
        // SAFETY: as above.
        unsafe { CStr::from_ptr(param.choices) }.to_str().unwrap_or("").split('|').collect()
    }

    /// Calls the plugin's `create`; null where it refuses.
    pub(super) fn create(&self, host: *const abi::Host, id: &CStr) -> *const abi::Plugin {
        (self.create)(host, id)
    }

    /// Makes an instance, sets numbers and choices by parameter index, and activates it.
    ///
    /// # Errors
    /// The plugin's fault.
    pub fn open(&self, numbers: &[(usize, f64)]) -> Result<TestInstance, Fault> {
        let mut instance = TestInstance::new(self)?;
        for &(index, value) in numbers {
            instance.set(index as u32, value)?;
        }
        instance.activate()?;
        Ok(instance)
    }
}
