//! Plugins that go wrong, each in one way, and one of each kind that does not, to show that it is the fault that ends a run.

mod device;
mod grid;
mod material;

use device::Finger;
use grid::Brick;
use material::Springs;
use pliant_plugin_api::{AsDevice, AsGrid, AsMaterial, Info, Param, export_plugins};
use std::ffi::CStr;

/// What goes wrong. One list for all kinds; a fault that a kind does not know leaves it sound.
pub mod fault {
    #![expect(missing_docs, reason = "the names say it")]
    pub const NONE: u8 = 0;
    pub const PANIC_IN_NEW: u8 = 1;
    pub const PANIC: u8 = 2;
    pub const NOT_A_NUMBER: u8 = 3;
    pub const REFUSES: u8 = 4;
    pub const UNKNOWN_KIND: u8 = 5;
    pub const NOTHING: u8 = 6;
    pub const BLOWS_UP: u8 = 7;
    pub const FALLING_IDS: u8 = 8;
    pub const LINK_TO_NOWHERE: u8 = 9;
}

use fault::*;

const fn info(id: &'static CStr, params: &'static [Param]) -> Info {
    Info { id, name: c"Faulty", version: c"0.1.0", summary: c"goes wrong as its id says", params }
}

/// Faults that come in the course of a run come from this time on.
const AFTER: Param = Param::number(c"after", c"s", (0.0, 1e3), 0.01, c"when it goes wrong");

export_plugins!(
    AsMaterial<Springs<NONE>>,
    AsMaterial<Springs<PANIC_IN_NEW>>,
    AsMaterial<Springs<PANIC>>,
    AsMaterial<Springs<NOT_A_NUMBER>>,
    AsMaterial<Springs<REFUSES>>,
    AsMaterial<Springs<UNKNOWN_KIND>>,
    AsMaterial<Springs<NOTHING>>,
    AsMaterial<Springs<BLOWS_UP>>,
    AsGrid<Brick<NONE>>,
    AsGrid<Brick<PANIC>>,
    AsGrid<Brick<NOT_A_NUMBER>>,
    AsGrid<Brick<REFUSES>>,
    AsGrid<Brick<FALLING_IDS>>,
    AsGrid<Brick<LINK_TO_NOWHERE>>,
    AsDevice<Finger<NONE>>,
    AsDevice<Finger<PANIC>>,
    AsDevice<Finger<NOT_A_NUMBER>>,
    AsDevice<Finger<REFUSES>>,
);
