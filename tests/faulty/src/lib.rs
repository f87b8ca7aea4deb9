//! Plugins that go wrong, each in one way, and one of each kind that does not, to show that it is the fault that ends a run.

mod device;
mod grid;
mod material;
mod normals;
mod sheet;

use device::Finger;
use grid::Brick;
pub use material::Springs;
use pliant_plugin_api::{AsDevice, AsGrid, AsMaterial, Info, Param, export_plugins};
pub use sheet::Net;
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
    pub const MAKES_ENERGY: u8 = 10;
    // One for each case of the conformance suite.
    pub const MASS_BELOW_ZERO: u8 = 20;
    pub const PULLS_AT_REST: u8 = 21;
    pub const ENERGY_OFF: u8 = 22;
    pub const STIFFNESS_OFF: u8 = 23;
    pub const DAMPING_GAINS: u8 = 24;
    pub const KNOWS_WHERE: u8 = 25;
    pub const DOES_NOT_TURN: u8 = 26;
    pub const KNOWS_ORDER: u8 = 27;
    pub const KNOWS_RANGE: u8 = 28;
    pub const REMEMBERS: u8 = 29;
    pub const SHARES: u8 = 30;
    pub const DIVIDES_BY_ZERO: u8 = 31;
    pub const SWALLOWS_NAN: u8 = 32;
    pub const ALLOCATES: u8 = 33;
    pub const TAKES_LONG: u8 = 34;
    pub const HINGE_SLOPE_OFF: u8 = 35;
    pub const HINGE_DOES_NOT_TURN: u8 = 36;
    pub const COMPLIANCE_INDEFINITE: u8 = 37;
    pub const SINGLE_OFF: u8 = 46;
    // What a report must notice and a conformance suite cannot.
    pub const TOO_SOFT: u8 = 38;
    pub const SLOW: u8 = 39;
    pub const WEIGHTS_TOO_LARGE: u8 = 40;
    pub const WEIGHTS_SWAPPED: u8 = 41;
    pub const PULLS_BACK_MORE: u8 = 42;
    pub const CELLS_ASKEW: u8 = 43;
    pub const REGION_OUTSIDE: u8 = 44;
    pub const HIDES_SURFACE: u8 = 45;
    pub const LIMITS_UPSIDE_DOWN: u8 = 50;
    pub const LEAVES_WORKSPACE: u8 = 51;
    pub const OVER_PEAK: u8 = 52;
    pub const IGNORES_STOP: u8 = 53;
    pub const NEVER_EXPIRES: u8 = 54;
    pub const OUTLIVES_ITSELF: u8 = 55;
    pub const NORMALS_FORCE_OFF: u8 = 60;
    pub const NORMALS_SLOPE_OFF: u8 = 61;
    pub const NORMALS_DO_NOT_TURN: u8 = 62;
    pub const NORMALS_PULL_AT_REST: u8 = 63;
    pub const TILT_TOO_SOFT: u8 = 64;
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
    AsMaterial<Springs<MAKES_ENERGY>>,
    AsMaterial<Springs<MASS_BELOW_ZERO>>,
    AsMaterial<Springs<PULLS_AT_REST>>,
    AsMaterial<Springs<ENERGY_OFF>>,
    AsMaterial<Springs<STIFFNESS_OFF>>,
    AsMaterial<Springs<SINGLE_OFF>>,
    AsMaterial<Springs<DAMPING_GAINS>>,
    AsMaterial<Springs<KNOWS_WHERE>>,
    AsMaterial<Springs<DOES_NOT_TURN>>,
    AsMaterial<Springs<KNOWS_ORDER>>,
    AsMaterial<Springs<KNOWS_RANGE>>,
    AsMaterial<Springs<REMEMBERS>>,
    AsMaterial<Springs<SHARES>>,
    AsMaterial<Springs<DIVIDES_BY_ZERO>>,
    AsMaterial<Springs<SWALLOWS_NAN>>,
    AsMaterial<Springs<ALLOCATES>>,
    AsMaterial<Springs<TAKES_LONG>>,
    AsMaterial<Springs<TOO_SOFT>>,
    AsMaterial<Springs<SLOW>>,
    AsMaterial<Net<NONE>>,
    AsMaterial<Net<HINGE_SLOPE_OFF>>,
    AsMaterial<Net<HINGE_DOES_NOT_TURN>>,
    AsMaterial<Net<COMPLIANCE_INDEFINITE>>,
    AsMaterial<Net<NORMALS_FORCE_OFF>>,
    AsMaterial<Net<NORMALS_SLOPE_OFF>>,
    AsMaterial<Net<NORMALS_DO_NOT_TURN>>,
    AsMaterial<Net<NORMALS_PULL_AT_REST>>,
    AsMaterial<Net<TILT_TOO_SOFT>>,
    AsGrid<Brick<NONE>>,
    AsGrid<Brick<PANIC>>,
    AsGrid<Brick<NOT_A_NUMBER>>,
    AsGrid<Brick<REFUSES>>,
    AsGrid<Brick<FALLING_IDS>>,
    AsGrid<Brick<LINK_TO_NOWHERE>>,
    AsGrid<Brick<WEIGHTS_TOO_LARGE>>,
    AsGrid<Brick<WEIGHTS_SWAPPED>>,
    AsGrid<Brick<PULLS_BACK_MORE>>,
    AsGrid<Brick<CELLS_ASKEW>>,
    AsGrid<Brick<REGION_OUTSIDE>>,
    AsGrid<Brick<HIDES_SURFACE>>,
    AsDevice<Finger<NONE>>,
    AsDevice<Finger<LIMITS_UPSIDE_DOWN>>,
    AsDevice<Finger<LEAVES_WORKSPACE>>,
    AsDevice<Finger<OVER_PEAK>>,
    AsDevice<Finger<IGNORES_STOP>>,
    AsDevice<Finger<NEVER_EXPIRES>>,
    AsDevice<Finger<OUTLIVES_ITSELF>>,
    AsDevice<Finger<PANIC>>,
    AsDevice<Finger<NOT_A_NUMBER>>,
    AsDevice<Finger<REFUSES>>,
);
