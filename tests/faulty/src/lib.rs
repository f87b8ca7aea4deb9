//! Faulty plugins for tests: each has one fault, named by its id. One plugin of each kind (`sound-...`) has none, to show that a failure
//! comes from the fault.

mod contact_law;
mod device;
mod fibres;
mod grid;
mod material;
mod normals;
mod sheet;

pub use contact_law::StickingLayer;
use contact_law::{OverrunningLayer, RangedLayer};
use device::FingerDevice;
use fibres::FibreSolid;
use grid::BoxGrid;
pub use material::SpringMaterial;
use pliant_plugin_api::{AsContactLaw, AsDevice, AsGrid, AsMaterial, Info, Param, export_plugins};
pub use sheet::SpringSheet;
use std::ffi::CStr;

/// The faults, as const arguments of the plugin types. One list serves all kinds: a type ignores the faults of other kinds.
pub mod fault {
    /// The plugin has no fault.
    pub const NONE: u8 = 0;
    /// Panics in `new`.
    pub const PANIC_IN_NEW: u8 = 1;
    /// Panics in `forces`, `build` or `read`.
    pub const PANIC: u8 = 2;
    /// Gives NaN as force, weight or position.
    pub const NAN: u8 = 3;
    /// Returns a fault from `rest`, `build` or `read`.
    pub const REFUSES: u8 = 4;
    /// Requests an element kind that does not exist.
    pub const UNKNOWN_KIND: u8 = 5;
    /// Gives every node a mass of zero.
    pub const NO_MASS: u8 = 6;
    /// Multiplies its forces by -1e30.
    pub const BLOWS_UP: u8 = 7;
    /// Lists a node id below the one before.
    pub const DESCENDING_IDS: u8 = 8;
    /// Lists a link to a node that does not exist.
    pub const LINK_TO_NOWHERE: u8 = 9;
    /// Swells and shrinks in time, which does work on what touches it.
    pub const MAKES_ENERGY: u8 = 10;

    // One fault for each case of the conformance suite.
    /// Gives node 0 a negative mass.
    pub const MASS_BELOW_ZERO: u8 = 20;
    /// Has springs that are stretched at rest.
    pub const PULLS_AT_REST: u8 = 21;
    /// Returns 1.01 times the energy of its forces.
    pub const ENERGY_OFF: u8 = 22;
    /// Returns 1.01 times the stiffness of its forces.
    pub const STIFFNESS_OFF: u8 = 23;
    /// Has negative damping.
    pub const DAMPING_GAINS: u8 = 24;
    /// Ties its links to the origin.
    pub const DEPENDS_ON_POSITION: u8 = 25;
    /// Measures stretch along the rest direction of each spring.
    pub const NOT_OBJECTIVE: u8 = 26;
    /// Doubles the stiffness of every other element of the list.
    pub const DEPENDS_ON_ORDER: u8 = 27;
    /// Makes the first element of each call stiffer.
    pub const DEPENDS_ON_RANGE: u8 = 28;
    /// Grows stiffer with every state it is called with.
    pub const KEEPS_STATE: u8 = 29;
    /// Uses the parameter of the instance that was made last.
    pub const SHARES_STATE: u8 = 30;
    /// Divides by the distance of a parameter from the end of its range.
    pub const DIVIDES_BY_ZERO: u8 = 31;
    /// Replaces a NaN by zero.
    pub const HIDES_NAN: u8 = 32;
    /// Allocates in `forces`.
    pub const ALLOCATES: u8 = 33;
    /// Takes 1.2 s for a call of `forces`, from a time on.
    pub const SLOW_AFTER: u8 = 34;
    /// Ignores the measure of its springs.
    pub const MEASURE_IGNORED: u8 = 73;
    /// Has springs that are stiffer the more they lie along x at rest.
    pub const KEEPS_REST_AXES: u8 = 74;
    /// Gains energy from springs that are stretched faster than 5 m/s.
    pub const DAMPING_GAINS_WHEN_FAST: u8 = 75;
    /// Damps turning springs too.
    pub const DAMPS_TURNING: u8 = 76;
    /// As [`FLOWS`], and panics in `advance` where a spring has fifty times its length.
    pub const PANICS_IN_ADVANCE: u8 = 77;
    /// Measures the strain of a hinge from a flat sheet.
    pub const HINGE_FLAT_AT_REST: u8 = 78;
    /// Returns 1.01 times the gradient of a hinge's strain.
    pub const HINGE_GRADIENT_OFF: u8 = 35;
    /// Measures the strain of a hinge along its rest direction.
    pub const HINGE_NOT_OBJECTIVE: u8 = 36;
    /// Has an indefinite compliance.
    pub const COMPLIANCE_INDEFINITE: u8 = 37;
    /// Is 5 % too soft, consistently: only a comparison with a reference shows it.
    pub const TOO_SOFT: u8 = 38;
    /// Takes 2 ms for a call of `forces`: only a comparison with a baseline shows it.
    pub const SLOW: u8 = 39;
    /// Never returns from `forces`, from a time on.
    pub const HANGS: u8 = 65;
    /// Ends the process in `forces`, from a time on.
    pub const ABORTS: u8 = 66;
    /// Ends the process with `exit(0)` in `forces`, from a time on.
    pub const EXITS: u8 = 67;
    /// Returns weights that sum to 1.01.
    pub const WEIGHTS_TOO_LARGE: u8 = 40;
    /// Exchanges two weights.
    pub const WEIGHTS_SWAPPED: u8 = 41;
    /// Pulls back 1.01 times the loads.
    pub const PULLS_BACK_MORE: u8 = 42;
    /// Exchanges two corners of cells without surface points.
    pub const CELLS_DISTORTED: u8 = 43;
    /// Lists a node outside the body in the region around a ball.
    pub const REGION_OUTSIDE: u8 = 44;
    /// Marks surface cells as inside.
    pub const HIDES_SURFACE: u8 = 45;
    /// Returns 1.01 times the stiffness, in single precision only.
    pub const SINGLE_OFF: u8 = 46;
    /// None: springs whose rest lengths flow beyond a strain.
    pub const FLOWS: u8 = 47;
    /// As [`FLOWS`], in the wrong direction.
    pub const FLOW_GAINS: u8 = 48;
    /// As [`FLOWS`], more where a spring is along x.
    pub const FLOW_NOT_OBJECTIVE: u8 = 49;
    /// As [`FLOWS`], and springs that have flowed by a third of their length have failed.
    pub const FAILS: u8 = 90;
    /// As [`FAILS`], and springs have failed that are stretched by a third.
    pub const FAILS_BY_POSITION: u8 = 91;
    /// Declares a continuous force above its peak force.
    pub const LIMITS_REVERSED: u8 = 50;
    /// Gives positions outside its workspace.
    pub const LEAVES_WORKSPACE: u8 = 51;
    /// Renders forces above its peak force.
    pub const OVER_PEAK: u8 = 52;
    /// Goes on rendering after a stop.
    pub const IGNORES_STOP: u8 = 53;
    /// Goes on rendering after a force has expired.
    pub const NEVER_EXPIRES: u8 = 54;
    /// Renders, when opened, the force of the previous instance.
    pub const KEEPS_FORCE_WHEN_REOPENED: u8 = 55;
    /// None: springs whose stiffness may differ from spring to spring.
    pub const FIELDS: u8 = 70;
    /// As [`FIELDS`], and does not read the field.
    pub const FIELD_IGNORED: u8 = 71;
    /// As [`FIELDS`], and takes the factor of the next spring of the list.
    pub const FIELD_OF_NEIGHBOUR: u8 = 72;
    /// Has stiffer fibres along x.
    pub const FIBRES_KEEP_AXES: u8 = 92;
    /// Has stiffer fibres in one of the two directions of a line.
    pub const FIBRES_HAVE_SIGN: u8 = 93;
    /// Has no fibres, whatever their direction.
    pub const FIBRES_IGNORED: u8 = 94;
    /// Returns 1.01 times the energy of fibres that go neither along nor across an edge or diagonal of a cell.
    pub const OBLIQUE_FIBRES_OFF: u8 = 95;
    /// Pulls a tenth less beyond a strain of 0.6, and its energy does not.
    pub const WEAK_WHEN_STRETCHED: u8 = 80;
    /// Returns 1.01 times the energy where a parameter is not the default.
    pub const ENERGY_OFF_WITH_PARAMETER: u8 = 81;
    /// Its matrix has one percent more stiffness where damping is asked for too.
    pub const TANGENT_NOT_LINEAR: u8 = 82;
    /// Keeps a factor in a static variable during a call.
    pub const STATIC_SCRATCH: u8 = 83;
    /// None: springs, or a solid, that want whole lists.
    pub const WHOLE_LISTS: u8 = 114;
    /// As [`WHOLE_LISTS`], and leaves out the springs of a list behind the first 16,384.
    pub const CUTS_LONG_LISTS: u8 = 115;
    /// As [`WHOLE_LISTS`], and its springs break.
    pub const LISTS_FAIL: u8 = 116;
    /// Allocates in `new` and gives nothing back.
    pub const LEAKS: u8 = 88;
    /// Reads the position behind that of the last node.
    pub const READS_PAST_NODES: u8 = 84;
    /// Writes to the force behind that of the last node.
    pub const WRITES_PAST_NODES: u8 = 85;
    /// Writes to the value behind its rest data.
    pub const WRITES_PAST_PLANES: u8 = 86;
    /// Writes to the force of a node that is none of its elements'.
    pub const TOUCHES_OTHER_NODES: u8 = 87;
    /// Returns 1.01 times the forces of its energy of normals.
    pub const NORMALS_FORCE_OFF: u8 = 60;
    /// Returns 0.99 times the derivatives by the normals.
    pub const NORMALS_DERIVATIVE_OFF: u8 = 61;
    /// Has an energy of the normals' z components.
    pub const NORMALS_NOT_OBJECTIVE: u8 = 62;
    /// Has an energy of normals with forces at rest.
    pub const NORMALS_PULL_AT_REST: u8 = 63;
    /// Gives half the stiffness against tilting.
    pub const TILT_TOO_SOFT: u8 = 64;
    /// Returns 1.01 times the derivative of its normal traction by the gap.
    pub const LAW_DERIVATIVE_OFF: u8 = 100;
    /// Pushes surfaces that do not touch.
    pub const LAW_ACTS_APART: u8 = 101;
    /// Attracts surfaces that part fast.
    pub const LAW_ATTRACTS: u8 = 102;
    /// Drives what slides fast.
    pub const LAW_FRICTION_PUSHES: u8 = 103;
    /// Pushes harder where surfaces part than where they meet.
    pub const LAW_GAINS: u8 = 104;
    /// Has twice the friction along the first axis of the tangent plane.
    pub const LAW_AXES_DIFFER: u8 = 105;
    /// Pushes the first point of each call harder.
    pub const LAW_DEPENDS_ON_RANGE: u8 = 106;
    /// Is harder once it was pressed deep.
    pub const LAW_KEEPS_STATE: u8 = 107;
    /// Keeps a gap in a static variable during a call.
    pub const LAW_STATIC_SCRATCH: u8 = 108;
    /// Divides by a parameter that may be zero.
    pub const LAW_DIVIDES_BY_ZERO: u8 = 109;
    /// Takes a gap that is not a number for none.
    pub const LAW_HIDES_NAN: u8 = 110;
    /// Writes to the normal traction behind that of the last point.
    pub const LAW_WRITES_PAST: u8 = 111;
    /// Writes to the weights behind those of the last point.
    pub const WEIGHTS_PAST: u8 = 112;
    /// Writes a pose behind that of the last effector.
    pub const POSE_PAST: u8 = 113;
}

use fault::*;

/// Variable with the path of a file in which `hangs` writes the id of its process before it hangs.
pub const HANGS_FILE: &str = "PLIANT_TEST_HANGS_FILE";

/// The descriptor of a faulty plugin.
const fn info(id: &'static CStr, params: &'static [Param]) -> Info {
    Info { id, name: c"Faulty", version: c"0.1.0", summary: c"a plugin for tests, with the fault its id names", params }
}

/// Adds zero to a number outside of the arrays of a call, which changes at most the sign of a zero.
#[allow(unsafe_code, reason = "goes where a plugin may not")]
fn write_same(at: *mut f64) {
    // SAFETY: none: this is the fault. The suite has guards there.
    unsafe { at.write_volatile(at.read_volatile() + 0.0) }
}

/// The time from which faults in the course of a run occur.
const AFTER: Param = Param::number(c"after", c"s", 0.0..=1e3, 0.01, c"time from which the fault occurs");

export_plugins!(
    AsMaterial<SpringMaterial<NONE>>,
    AsMaterial<SpringMaterial<PANIC_IN_NEW>>,
    AsMaterial<SpringMaterial<PANIC>>,
    AsMaterial<SpringMaterial<NAN>>,
    AsMaterial<SpringMaterial<REFUSES>>,
    AsMaterial<SpringMaterial<UNKNOWN_KIND>>,
    AsMaterial<SpringMaterial<NO_MASS>>,
    AsMaterial<SpringMaterial<BLOWS_UP>>,
    AsMaterial<SpringMaterial<MAKES_ENERGY>>,
    AsMaterial<SpringMaterial<HANGS>>,
    AsMaterial<SpringMaterial<ABORTS>>,
    AsMaterial<SpringMaterial<EXITS>>,
    AsMaterial<SpringMaterial<MASS_BELOW_ZERO>>,
    AsMaterial<SpringMaterial<PULLS_AT_REST>>,
    AsMaterial<SpringMaterial<ENERGY_OFF>>,
    AsMaterial<SpringMaterial<STIFFNESS_OFF>>,
    AsMaterial<SpringMaterial<SINGLE_OFF>>,
    AsMaterial<SpringMaterial<DAMPING_GAINS>>,
    AsMaterial<SpringMaterial<DEPENDS_ON_POSITION>>,
    AsMaterial<SpringMaterial<NOT_OBJECTIVE>>,
    AsMaterial<SpringMaterial<DEPENDS_ON_ORDER>>,
    AsMaterial<SpringMaterial<DEPENDS_ON_RANGE>>,
    AsMaterial<SpringMaterial<KEEPS_STATE>>,
    AsMaterial<SpringMaterial<SHARES_STATE>>,
    AsMaterial<SpringMaterial<DIVIDES_BY_ZERO>>,
    AsMaterial<SpringMaterial<HIDES_NAN>>,
    AsMaterial<SpringMaterial<ALLOCATES>>,
    AsMaterial<SpringMaterial<SLOW_AFTER>>,
    AsMaterial<SpringMaterial<TOO_SOFT>>,
    AsMaterial<SpringMaterial<SLOW>>,
    AsMaterial<SpringMaterial<FLOWS>>,
    AsMaterial<SpringMaterial<FLOW_GAINS>>,
    AsMaterial<SpringMaterial<FLOW_NOT_OBJECTIVE>>,
    AsMaterial<SpringMaterial<FAILS>>,
    AsMaterial<SpringMaterial<FAILS_BY_POSITION>>,
    AsMaterial<SpringMaterial<FIELDS>>,
    AsMaterial<SpringMaterial<FIELD_IGNORED>>,
    AsMaterial<SpringMaterial<FIELD_OF_NEIGHBOUR>>,
    AsMaterial<SpringMaterial<WEAK_WHEN_STRETCHED>>,
    AsMaterial<SpringMaterial<ENERGY_OFF_WITH_PARAMETER>>,
    AsMaterial<SpringMaterial<TANGENT_NOT_LINEAR>>,
    AsMaterial<SpringMaterial<STATIC_SCRATCH>>,
    AsMaterial<SpringMaterial<READS_PAST_NODES>>,
    AsMaterial<SpringMaterial<WRITES_PAST_NODES>>,
    AsMaterial<SpringMaterial<WRITES_PAST_PLANES>>,
    AsMaterial<SpringMaterial<TOUCHES_OTHER_NODES>>,
    AsMaterial<SpringMaterial<MEASURE_IGNORED>>,
    AsMaterial<SpringMaterial<KEEPS_REST_AXES>>,
    AsMaterial<SpringMaterial<DAMPING_GAINS_WHEN_FAST>>,
    AsMaterial<SpringMaterial<DAMPS_TURNING>>,
    AsMaterial<SpringMaterial<PANICS_IN_ADVANCE>>,
    AsMaterial<SpringMaterial<WHOLE_LISTS>>,
    AsMaterial<SpringMaterial<CUTS_LONG_LISTS>>,
    AsMaterial<SpringMaterial<LISTS_FAIL>>,
    AsMaterial<SpringSheet<NONE>>,
    AsMaterial<SpringSheet<HINGE_GRADIENT_OFF>>,
    AsMaterial<SpringSheet<HINGE_NOT_OBJECTIVE>>,
    AsMaterial<SpringSheet<HINGE_FLAT_AT_REST>>,
    AsMaterial<SpringSheet<COMPLIANCE_INDEFINITE>>,
    AsMaterial<SpringSheet<NORMALS_FORCE_OFF>>,
    AsMaterial<SpringSheet<NORMALS_DERIVATIVE_OFF>>,
    AsMaterial<SpringSheet<NORMALS_NOT_OBJECTIVE>>,
    AsMaterial<SpringSheet<NORMALS_PULL_AT_REST>>,
    AsMaterial<SpringSheet<TILT_TOO_SOFT>>,
    AsMaterial<FibreSolid<NONE>>,
    AsMaterial<FibreSolid<WHOLE_LISTS>>,
    AsMaterial<FibreSolid<FIBRES_KEEP_AXES>>,
    AsMaterial<FibreSolid<FIBRES_HAVE_SIGN>>,
    AsMaterial<FibreSolid<FIBRES_IGNORED>>,
    AsMaterial<FibreSolid<OBLIQUE_FIBRES_OFF>>,
    AsGrid<BoxGrid<NONE>>,
    AsGrid<BoxGrid<PANIC>>,
    AsGrid<BoxGrid<NAN>>,
    AsGrid<BoxGrid<REFUSES>>,
    AsGrid<BoxGrid<DESCENDING_IDS>>,
    AsGrid<BoxGrid<LINK_TO_NOWHERE>>,
    AsGrid<BoxGrid<WEIGHTS_TOO_LARGE>>,
    AsGrid<BoxGrid<WEIGHTS_SWAPPED>>,
    AsGrid<BoxGrid<PULLS_BACK_MORE>>,
    AsGrid<BoxGrid<CELLS_DISTORTED>>,
    AsGrid<BoxGrid<REGION_OUTSIDE>>,
    AsGrid<BoxGrid<HIDES_SURFACE>>,
    AsGrid<BoxGrid<WEIGHTS_PAST>>,
    AsDevice<FingerDevice<NONE>>,
    AsDevice<FingerDevice<LIMITS_REVERSED>>,
    AsDevice<FingerDevice<LEAVES_WORKSPACE>>,
    AsDevice<FingerDevice<OVER_PEAK>>,
    AsDevice<FingerDevice<IGNORES_STOP>>,
    AsDevice<FingerDevice<NEVER_EXPIRES>>,
    AsDevice<FingerDevice<KEEPS_FORCE_WHEN_REOPENED>>,
    AsDevice<FingerDevice<POSE_PAST>>,
    AsDevice<FingerDevice<PANIC>>,
    AsDevice<FingerDevice<NAN>>,
    AsDevice<FingerDevice<REFUSES>>,
    AsContactLaw<StickingLayer<NONE>>,
    AsContactLaw<StickingLayer<PANIC>>,
    AsContactLaw<StickingLayer<NAN>>,
    AsContactLaw<StickingLayer<LAW_DERIVATIVE_OFF>>,
    AsContactLaw<StickingLayer<LAW_ACTS_APART>>,
    AsContactLaw<StickingLayer<LAW_ATTRACTS>>,
    AsContactLaw<StickingLayer<LAW_FRICTION_PUSHES>>,
    AsContactLaw<StickingLayer<LAW_GAINS>>,
    AsContactLaw<StickingLayer<LAW_AXES_DIFFER>>,
    AsContactLaw<StickingLayer<LAW_KEEPS_STATE>>,
    AsContactLaw<StickingLayer<LAW_STATIC_SCRATCH>>,
    AsContactLaw<StickingLayer<LAW_DIVIDES_BY_ZERO>>,
    AsContactLaw<StickingLayer<LAW_HIDES_NAN>>,
    RangedLayer,
    OverrunningLayer,
);
