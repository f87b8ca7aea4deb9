//! `pliant.contact-law/1`.

use super::{Plugin, Status};
use core::ffi::CStr;

/// Extension id of [`ContactLaw`].
pub const CONTACT_LAW: &CStr = c"pliant.contact-law/1";

/// Flag of a contact law: its normal traction may be negative. Without it the host takes a negative one for an error.
pub const ADHESIVE: u32 = 1;

/// What a contact law asks of the host.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactRequest {
    /// `size_of` this struct.
    pub size: usize,
    /// [`ADHESIVE`], or 0.
    pub flags: u32,
    /// Doubles of history per contact point; zero where a contact begins.
    pub history_stride: u32,
    /// m, the largest gap at which the law has a traction; 0 for a law of surfaces that touch.
    pub reach: f64,
}

/// One call: the contact points `[begin, end)`, each of which stands for an area of the body's surface.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ContactBatch {
    /// `size_of` this struct.
    pub size: usize,
    /// First point of the call.
    pub begin: usize,
    /// One past the last point of the call.
    pub end: usize,
    /// Contact points behind each pointer, m.
    pub count: usize,
    /// (m) m, distance of the two surfaces along the normal; negative where they overlap.
    pub gap: *const f64,
    /// (m) m/s, rate of the gap; negative where they approach.
    pub gap_rate: *const f64,
    /// (2 x m) m, plane-major: path of the body along the tool since the contact began.
    pub slip: *const f64,
    /// (2 x m) m/s, plane-major: velocity of the body along the tool.
    pub slip_rate: *const f64,
    /// (m) m^2, of the undeformed surface.
    pub area: *const f64,
    /// (history_stride x m), plane-major.
    pub history: *const f64,
    /// Planes behind `history`.
    pub history_stride: usize,
    /// s, start of the step.
    pub time: f64,
    /// s, length of the step.
    pub dt: f64,
}

/// Tractions on the body and their derivatives, to be written for the points of the call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Traction {
    /// `size_of` this struct.
    pub size: usize,
    /// (m) Pa; positive pushes the two apart.
    pub normal: *mut f64,
    /// (m) Pa/m, derivative of `normal` by the gap.
    pub normal_by_gap: *mut f64,
    /// (m) Pa s/m, derivative of `normal` by the gap rate.
    pub normal_by_gap_rate: *mut f64,
    /// (2 x m) Pa, plane-major; friction is opposite to the slip rate.
    pub tangential: *mut f64,
    /// (4 x m) Pa/m, plane-major, rows first: derivative of `tangential` by the slip.
    pub tangential_by_slip: *mut f64,
    /// (4 x m) Pa s/m, plane-major, rows first: derivative of `tangential` by the slip rate.
    pub tangential_by_slip_rate: *mut f64,
}

/// Function table of [`CONTACT_LAW`].
#[repr(C)]
pub struct ContactLaw {
    /// `size_of` this struct.
    pub size: usize,
    /// Fills in what the law asks of the host.
    pub request: Option<unsafe extern "C" fn(*const Plugin, *mut ContactRequest) -> Status>,
    /// Writes tractions and derivatives of the points of the call.
    pub tractions: Option<unsafe extern "C" fn(*const Plugin, *const ContactBatch, *const Traction) -> Status>,
    /// Updates the history of the points of the call after an accepted step; null where the law has none.
    pub advance: Option<unsafe extern "C" fn(*const Plugin, *const ContactBatch, history: *mut f64) -> Status>,
}
