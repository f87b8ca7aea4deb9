//! The trait of a contact law, safe views of a call, and the C functions behind its table.

use crate::abi::{self, ContactBatch, Status};
use crate::fault::Fault;
use crate::info::Info;
use crate::instance::{Role, call};
use crate::param::Params;
use core::ffi::{CStr, c_void};
use core::marker::PhantomData;

/// A contact law: the traction between a tool and a body at a contact point, of its gap and its slip.
///
/// Methods run inside a step, several of them at once on disjoint points: no allocation, lock or I/O. State belongs into the history,
/// which the host owns.
pub trait ContactLaw: Send + Sync + Sized + 'static {
    /// The plugin's descriptor.
    const INFO: Info;
    /// Doubles of history per contact point; they are zero where a contact begins.
    const HISTORY: usize = 0;
    /// Whether the normal traction may be negative; the host takes a negative one of any other law for an error.
    const IS_ADHESIVE: bool = false;

    /// Makes the law from its parameters.
    ///
    /// # Errors
    /// A combination of parameters it cannot work with.
    fn new(params: &Params<'_>) -> Result<Self, Fault>;

    /// Largest gap at which the law has a traction, m; 0 for a law of surfaces that touch.
    fn reach(&self) -> f64 {
        0.0
    }

    /// Traction at a contact point with its history at the start of the step (as many numbers as [`ContactLaw::HISTORY`]).
    ///
    /// # Errors
    /// A state in which the law has no finite traction. NaN may be passed on instead.
    fn traction(&self, point: &ContactPoint, history: &[f64]) -> Result<PointTraction, Fault>;

    /// Updates the history of a contact point at the end of an accepted step, in the state it ended in.
    ///
    /// # Errors
    /// As for [`ContactLaw::traction`].
    fn advance(&self, _point: &ContactPoint, _history: &mut [f64]) -> Result<(), Fault> {
        Ok(())
    }
}

/// State of a contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactPoint {
    /// Distance of the two surfaces along the normal, m; negative where they overlap.
    pub gap: f64,
    /// Rate of the gap, m/s; negative where they approach.
    pub gap_rate: f64,
    /// Path of the body along the tool since the contact began, m, along the two axes of the tangent plane.
    pub slip: [f64; 2],
    /// Velocity of the body along the tool, m/s.
    pub slip_rate: [f64; 2],
    /// Area of the undeformed surface for which the point stands, m^2.
    pub area: f64,
    /// Start of the step, s.
    pub time: f64,
    /// Length of the step, s.
    pub dt: f64,
}

/// Traction at a contact point, on the body, and its derivatives. The default is that of two surfaces that do not touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointTraction {
    /// Normal traction, Pa; positive pushes the two apart.
    pub normal: f64,
    /// Derivative of `normal` by the gap, Pa/m.
    pub normal_by_gap: f64,
    /// Derivative of `normal` by the gap rate, Pa s/m.
    pub normal_by_gap_rate: f64,
    /// Tangential traction, Pa; friction is opposite to the slip rate.
    pub tangential: [f64; 2],
    /// Derivative of `tangential` by the slip, Pa/m, rows first.
    pub tangential_by_slip: [[f64; 2]; 2],
    /// Derivative of `tangential` by the slip rate, Pa s/m, rows first.
    pub tangential_by_slip_rate: [[f64; 2]; 2],
}

/// Most doubles of history per contact point of a law written with [`ContactLaw`].
pub const MAX_CONTACT_HISTORY: usize = 16;

/// Adapter: a [`ContactLaw`] as a plugin, for [`crate::export_plugins`].
pub struct AsContactLaw<T>(PhantomData<T>);

impl<T: ContactLaw> Role for AsContactLaw<T> {
    type Object = T;
    const INFO: Info = T::INFO;
    const KIND: u32 = abi::KIND_CONTACT_LAW;
    const EXTENSION: &'static CStr = abi::CONTACT_LAW;

    fn table() -> *const c_void {
        (&raw const *Self::TABLE).cast()
    }

    fn activate(params: &Params<'_>) -> Result<T, Fault> {
        T::new(params)
    }
}

#[allow(unsafe_code, reason = "the functions behind the table")]
impl<T: ContactLaw> AsContactLaw<T> {
    const TABLE: &'static abi::ContactLaw = &abi::ContactLaw {
        size: size_of::<abi::ContactLaw>(),
        request: Some(Self::request),
        tractions: Some(Self::tractions),
        advance: if T::HISTORY > 0 { Some(Self::advance) } else { None },
    };

    unsafe extern "C" fn request(plugin: *const abi::Plugin, out: *mut abi::ContactRequest) -> Status {
        const { assert!(T::HISTORY <= MAX_CONTACT_HISTORY, "more history per contact point than is allowed") };
        // SAFETY: a live, active instance of this role; `out` is the host's to fill.
        unsafe {
            call::<Self, _>(plugin, |law| {
                (*out).flags = if T::IS_ADHESIVE { abi::ADHESIVE } else { 0 };
                (*out).history_stride = T::HISTORY as u32;
                (*out).reach = law.reach();
                Ok(())
            })
        }
    }

    unsafe extern "C" fn tractions(
        plugin: *const abi::Plugin,
        batch: *const ContactBatch,
        out: *const abi::Traction,
    ) -> Status {
        // SAFETY: a live, active instance of this role; the host gives arrays of `count` points, in planes.
        unsafe {
            call::<Self, _>(plugin, |law| {
                let (batch, out) = (&*batch, &*out);
                let mut history = [0.0; MAX_CONTACT_HISTORY];
                for i in batch.begin..batch.end {
                    read_history::<T>(batch, batch.history, i, &mut history);
                    let found = law.traction(&point(batch, i), &history[..T::HISTORY])?;
                    write(batch.count, i, &found, out);
                }
                Ok(())
            })
        }
    }

    unsafe extern "C" fn advance(plugin: *const abi::Plugin, batch: *const ContactBatch, to: *mut f64) -> Status {
        // SAFETY: as above; `to` has as many values as the batch's history.
        unsafe {
            call::<Self, _>(plugin, |law| {
                let batch = &*batch;
                let mut history = [0.0; MAX_CONTACT_HISTORY];
                for i in batch.begin..batch.end {
                    read_history::<T>(batch, to.cast_const(), i, &mut history);
                    law.advance(&point(batch, i), &mut history[..T::HISTORY])?;
                    for (plane, value) in history[..T::HISTORY].iter().enumerate() {
                        *to.add(plane * batch.count + i) = *value;
                    }
                }
                Ok(())
            })
        }
    }
}

/// Reads the history of a point out of planes.
///
/// # Safety
/// `from` has [`ContactLaw::HISTORY`] planes of `batch.count` doubles, and `i` is below that.
#[allow(unsafe_code, reason = "reads the host's arrays")]
unsafe fn read_history<T: ContactLaw>(batch: &ContactBatch, from: *const f64, i: usize, to: &mut [f64]) {
    assert!(batch.history_stride >= T::HISTORY, "{} planes of history of {}", batch.history_stride, T::HISTORY);
    for (plane, value) in to[..T::HISTORY].iter_mut().enumerate() {
        // SAFETY: the caller's promise.
        *value = unsafe { *from.add(plane * batch.count + i) };
    }
}

/// The state of a point.
///
/// # Safety
/// The arrays of the batch are those of the header, and `i` is below `batch.count`.
#[allow(unsafe_code, reason = "reads the host's arrays")]
unsafe fn point(batch: &ContactBatch, i: usize) -> ContactPoint {
    // SAFETY: the caller's promise.
    let at = |array: *const f64, plane: usize| unsafe { *array.add(plane * batch.count + i) };
    ContactPoint {
        gap: at(batch.gap, 0),
        gap_rate: at(batch.gap_rate, 0),
        slip: [at(batch.slip, 0), at(batch.slip, 1)],
        slip_rate: [at(batch.slip_rate, 0), at(batch.slip_rate, 1)],
        area: at(batch.area, 0),
        time: batch.time,
        dt: batch.dt,
    }
}

/// Writes the results of a point.
///
/// # Safety
/// The arrays of `out` are those of the header for `count` points, and `i` is below `count`.
#[allow(unsafe_code, reason = "writes to the host's arrays")]
unsafe fn write(count: usize, i: usize, from: &PointTraction, out: &abi::Traction) {
    // SAFETY: the caller's promise.
    let put = |array: *mut f64, plane: usize, value: f64| unsafe { *array.add(plane * count + i) = value };
    put(out.normal, 0, from.normal);
    put(out.normal_by_gap, 0, from.normal_by_gap);
    put(out.normal_by_gap_rate, 0, from.normal_by_gap_rate);
    for a in 0..2 {
        put(out.tangential, a, from.tangential[a]);
        for b in 0..2 {
            put(out.tangential_by_slip, 2 * a + b, from.tangential_by_slip[a][b]);
            put(out.tangential_by_slip_rate, 2 * a + b, from.tangential_by_slip_rate[a][b]);
        }
    }
}
