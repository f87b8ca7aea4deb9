//! A contact law: a layer of springs and dampers whose friction sticks by springs along the surface.

use crate::{AFTER, fault, info};
use pliant_plugin_api::abi::{self, Status};
use pliant_plugin_api::instance::Role;
use pliant_plugin_api::{AsContactLaw, ContactLaw, ContactPoint, Fault, Info, Param, Params, PointTraction};
use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A contact law with the fault `F` (see [`fault`]). Its history is the slip at which the springs along the surface are at rest.
pub struct StickingLayer<const F: u8> {
    /// s
    after: f64,
    /// Stiffness of the springs along the normal, Pa/m.
    stiffness: f64,
    /// Whether it was pressed very deep, for [`fault::LAW_KEEPS_STATE`].
    was_deep: AtomicBool,
}

/// Pa/m
const STIFFNESS: f64 = 1e7;
/// Stiffness of the springs along the surface over that along the normal.
const SHEAR: f64 = 0.5;
/// s/m
const DAMPING: f64 = 0.5;
const FRICTION: f64 = 0.4;
/// Overlap that [`fault::LAW_KEEPS_STATE`] remembers, m.
const DEEP: f64 = 0.02;
/// Slip rate from which [`fault::LAW_FRICTION_PUSHES`] pushes, m/s.
const FAST: f64 = 3.0;

const SOFTNESS: Param = Param::number(c"softness", c"1", 0.0..=1.0, 0.5, c"its inverse is a factor of the stiffness");

impl<const F: u8> ContactLaw for StickingLayer<F> {
    const INFO: Info = info(
        match F {
            fault::PANIC => c"law-panics",
            fault::NAN => c"law-not-a-number",
            fault::LAW_DERIVATIVE_OFF => c"law-derivative-off",
            fault::LAW_ACTS_APART => c"law-acts-apart",
            fault::LAW_ATTRACTS => c"law-attracts",
            fault::LAW_FRICTION_PUSHES => c"law-friction-pushes",
            fault::LAW_GAINS => c"law-gains",
            fault::LAW_AXES_DIFFER => c"law-axes-differ",
            fault::LAW_DEPENDS_ON_RANGE => c"law-depends-on-range",
            fault::LAW_KEEPS_STATE => c"law-keeps-state",
            fault::LAW_STATIC_SCRATCH => c"law-static-scratch",
            fault::LAW_DIVIDES_BY_ZERO => c"law-divides-by-zero",
            fault::LAW_HIDES_NAN => c"law-hides-nan",
            fault::LAW_WRITES_PAST => c"law-writes-past",
            fault::ALLOCATES => c"law-allocates",
            _ => c"sound-layer",
        },
        const { &[AFTER, SOFTNESS] as &[Param] },
    );
    const HISTORY: usize = 2;

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let softness = params.number("softness");
        let factor = if F == fault::LAW_DIVIDES_BY_ZERO { 0.5 / softness } else { 1.0 };
        Ok(Self { after: params.number("after"), stiffness: factor * STIFFNESS, was_deep: AtomicBool::new(false) })
    }

    fn traction(&self, point: &ContactPoint, history: &[f64]) -> Result<PointTraction, Fault> {
        let is_due = point.time >= self.after;
        assert!(!(is_due && F == fault::PANIC), "panicked on purpose, in tractions");
        if point.gap >= 0.0 {
            let acts = F == fault::LAW_ACTS_APART && point.gap < 0.01;
            return Ok(PointTraction { normal: if acts { 1.0 } else { 0.0 }, ..PointTraction::default() });
        }
        if F == fault::ALLOCATES {
            std::hint::black_box(vec![point.gap]);
        }
        let mut stiffness = self.stiffness;
        if F == fault::LAW_KEEPS_STATE {
            let deep = self.was_deep.fetch_or(point.gap < -DEEP, Ordering::Relaxed);
            stiffness *= if deep { 1.01 } else { 1.0 };
        }
        if F == fault::LAW_STATIC_SCRATCH {
            stiffness *= through_static(point);
        }
        let depth = if F == fault::LAW_HIDES_NAN { (-point.gap).max(0.0) } else { -point.gap };
        let sign = if F == fault::LAW_GAINS { -1.0 } else { 1.0 };
        let factor = 1.0 - sign * DAMPING * point.gap_rate;
        if factor <= 0.0 && F != fault::LAW_ATTRACTS {
            return Ok(PointTraction::default());
        }
        let normal = if is_due && F == fault::NAN { f64::NAN } else { stiffness * depth * factor };
        let (mut tangential, mut by_slip) = friction(normal, point.slip, history);
        let [u, v] = point.slip_rate;
        if F == fault::LAW_FRICTION_PUSHES && u * u + v * v > FAST * FAST {
            tangential = tangential.map(|t| -t);
            by_slip = by_slip.map(|row| row.map(|k| -k));
        }
        if F == fault::LAW_AXES_DIFFER {
            tangential[0] *= 2.0;
            by_slip[0] = by_slip[0].map(|k| 2.0 * k);
        }
        Ok(PointTraction {
            normal,
            normal_by_gap: -stiffness * factor * if F == fault::LAW_DERIVATIVE_OFF { 1.01 } else { 1.0 },
            normal_by_gap_rate: -sign * DAMPING * stiffness * depth,
            tangential,
            tangential_by_slip: by_slip,
            tangential_by_slip_rate: [[0.0; 2]; 2],
        })
    }

    fn advance(&self, point: &ContactPoint, history: &mut [f64]) -> Result<(), Fault> {
        let factor = (1.0 - DAMPING * point.gap_rate).max(0.0);
        let pressed = (-point.gap).max(0.0) * self.stiffness * factor;
        let (tangential, _) = friction(pressed, point.slip, history);
        for axis in 0..2 {
            history[axis] = point.slip[axis] + tangential[axis] / (SHEAR * STIFFNESS);
        }
        Ok(())
    }
}

/// Friction of a slip, Pa, whose springs are at rest at `history` (m), and its derivative, Pa/m: as the springs say, up to Coulomb's.
fn friction(normal: f64, slip: [f64; 2], history: &[f64]) -> ([f64; 2], [[f64; 2]; 2]) {
    let stiffness = SHEAR * STIFFNESS;
    let trial = [0, 1].map(|axis| -stiffness * (slip[axis] - history[axis]));
    let size = (trial[0] * trial[0] + trial[1] * trial[1]).sqrt();
    let most = FRICTION * normal.max(0.0);
    if most == 0.0 {
        return ([0.0; 2], [[0.0; 2]; 2]);
    }
    if size <= most {
        return (trial, [[-stiffness, 0.0], [0.0, -stiffness]]);
    }
    let along = trial.map(|t| t / size);
    let entry = |i: usize, j: usize| {
        let identity = if i == j { 1.0 } else { 0.0 };
        -stiffness * most / size * (identity - along[i] * along[j])
    };
    (along.map(|a| most * a), [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]])
}

/// 1, unless another thread writes to the static variable meanwhile.
fn through_static(point: &ContactPoint) -> f64 {
    static SCRATCH: AtomicU64 = AtomicU64::new(0);
    let own = point.gap.to_bits();
    SCRATCH.store(own, Ordering::Relaxed);
    std::thread::yield_now();
    if SCRATCH.load(Ordering::Relaxed) == own { 1.0 } else { 1.0 + 1e-12 }
}

/// The layer with [`fault::LAW_DEPENDS_ON_RANGE`], which a law that sees one point at a time cannot have.
pub struct RangedLayer;

type Layer = StickingLayer<{ fault::LAW_DEPENDS_ON_RANGE }>;

impl Role for RangedLayer {
    type Object = Layer;
    const INFO: Info = Layer::INFO;
    const KIND: u32 = abi::KIND_CONTACT_LAW;
    const EXTENSION: &'static CStr = abi::CONTACT_LAW;

    fn table() -> *const c_void {
        (&raw const RANGED.0).cast()
    }

    fn activate(params: &Params<'_>) -> Result<Layer, Fault> {
        Layer::new(params)
    }
}

/// The layer with [`fault::LAW_WRITES_PAST`].
pub struct OverrunningLayer;

type Overrunning = StickingLayer<{ fault::LAW_WRITES_PAST }>;

impl Role for OverrunningLayer {
    type Object = Overrunning;
    const INFO: Info = Overrunning::INFO;
    const KIND: u32 = abi::KIND_CONTACT_LAW;
    const EXTENSION: &'static CStr = abi::CONTACT_LAW;

    fn table() -> *const c_void {
        (&raw const OVERRUNNING.0).cast()
    }

    fn activate(params: &Params<'_>) -> Result<Overrunning, Fault> {
        Overrunning::new(params)
    }
}

static OVERRUNNING: abi::Shared<abi::ContactLaw> = abi::Shared(abi::ContactLaw {
    size: size_of::<abi::ContactLaw>(),
    request: Some(request),
    tractions: Some(overrunning_tractions),
    advance: Some(advance),
});

static RANGED: abi::Shared<abi::ContactLaw> = abi::Shared(abi::ContactLaw {
    size: size_of::<abi::ContactLaw>(),
    request: Some(request),
    tractions: Some(tractions),
    advance: Some(advance),
});

/// The table of the layer without the fault, whose instances are the same.
#[allow(unsafe_code, reason = "the table of a contact law")]
fn sound() -> &'static abi::ContactLaw {
    // SAFETY: that is the type of the table, which lives as long as the library.
    unsafe { &*AsContactLaw::<Layer>::table().cast() }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn request(plugin: *const abi::Plugin, out: *mut abi::ContactRequest) -> Status {
    // SAFETY: the host's promises are those of the function called.
    unsafe { sound().request.expect("not null")(plugin, out) }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn tractions(
    plugin: *const abi::Plugin,
    batch: *const abi::ContactBatch,
    out: *const abi::Traction,
) -> Status {
    // SAFETY: as above; the first point of the call is the host's to be written.
    unsafe {
        let status = sound().tractions.expect("not null")(plugin, batch, out);
        *(*out).tangential_by_slip_rate.add((*batch).begin) *= 1.0 + 1e-12;
        *(*out).normal.add((*batch).begin) *= 1.0 + 1e-12;
        status
    }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn advance(plugin: *const abi::Plugin, batch: *const abi::ContactBatch, to: *mut f64) -> Status {
    // SAFETY: as above.
    unsafe { sound().advance.expect("not null")(plugin, batch, to) }
}

#[allow(unsafe_code, reason = "called by the host")]
unsafe extern "C" fn overrunning_tractions(
    plugin: *const abi::Plugin,
    batch: *const abi::ContactBatch,
    out: *const abi::Traction,
) -> Status {
    // SAFETY: as above for the call; what follows writes outside of the plane, which is the fault, and changes at most the sign of a zero.
    unsafe {
        let status = sound().tractions.expect("not null")(plugin, batch, out);
        let behind = (*out).normal.add((*batch).count);
        behind.write_volatile(behind.read_volatile() + 0.0);
        status
    }
}
