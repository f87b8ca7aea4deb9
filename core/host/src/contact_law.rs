//! Active contact laws, and the arrays of contact points that they are called with.

use crate::error::HostError;
use crate::instance::{Extension, Instance, ParamSettings};
use crate::library::Library;
use crate::messages::NewMessages;
use crate::plugin_info::{PluginInfo, PluginKind};
use pliant_plugin_api::abi;

/// An active contact law.
pub struct ContactLaw {
    /// The plugin instance.
    instance: Instance,
    /// Function table of the law.
    table: &'static abi::ContactLaw,
    /// What the law asked for.
    request: abi::ContactRequest,
}

/// States of contact points (m), with their histories. All arrays are plane-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactStates {
    /// Distance of the two surfaces along the normal, m (m); negative where they overlap.
    pub gap: Vec<f64>,
    /// Rate of the gap, m/s (m).
    pub gap_rate: Vec<f64>,
    /// Path of the body along the tool since the contact began, m (2 x m).
    pub slip: Vec<f64>,
    /// Velocity of the body along the tool, m/s (2 x m).
    pub slip_rate: Vec<f64>,
    /// Area of the undeformed surface that a point stands for, m^2 (m).
    pub area: Vec<f64>,
    /// History of the law (stride x m).
    pub history: Vec<f64>,
}

/// Tractions on the body at contact points (m) and their derivatives. All arrays are plane-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tractions {
    /// Normal traction, Pa (m); positive pushes the two apart.
    pub normal: Vec<f64>,
    /// Its derivative by the gap, Pa/m (m).
    pub normal_by_gap: Vec<f64>,
    /// Its derivative by the gap rate, Pa s/m (m).
    pub normal_by_gap_rate: Vec<f64>,
    /// Tangential traction, Pa (2 x m).
    pub tangential: Vec<f64>,
    /// Its derivative by the slip, Pa/m (4 x m).
    pub tangential_by_slip: Vec<f64>,
    /// Its derivative by the slip rate, Pa s/m (4 x m).
    pub tangential_by_slip_rate: Vec<f64>,
}

impl ContactStates {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.gap.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.gap.is_empty()
    }

    /// Makes room for this number of points of a law with `stride` doubles of history, all zero; keeps the storage.
    pub fn reset(&mut self, points: usize, stride: usize) {
        let arrays = [&mut self.gap, &mut self.gap_rate, &mut self.area];
        arrays.into_iter().for_each(|array| refill(array, points));
        refill(&mut self.slip, 2 * points);
        refill(&mut self.slip_rate, 2 * points);
        refill(&mut self.history, stride * points);
    }
}

impl Tractions {
    /// Makes room for this number of points, all zero; keeps the storage.
    fn reset(&mut self, points: usize) {
        let arrays = [&mut self.normal, &mut self.normal_by_gap, &mut self.normal_by_gap_rate];
        arrays.into_iter().for_each(|array| refill(array, points));
        refill(&mut self.tangential, 2 * points);
        refill(&mut self.tangential_by_slip, 4 * points);
        refill(&mut self.tangential_by_slip_rate, 4 * points);
    }

    /// Whether every number is finite.
    fn is_finite(&self) -> bool {
        let scalars = self.normal.iter().chain(&self.normal_by_gap).chain(&self.normal_by_gap_rate);
        let of_slip = self.tangential.iter().chain(&self.tangential_by_slip).chain(&self.tangential_by_slip_rate);
        scalars.chain(of_slip).all(|x| x.is_finite())
    }
}

/// Fills an array with this number of zeros.
fn refill(array: &mut Vec<f64>, len: usize) {
    array.clear();
    array.resize(len, 0.0);
}

/// Most doubles of history per contact point.
const MAX_HISTORY: u32 = 64;

#[allow(unsafe_code, reason = "calls the law's functions")]
impl ContactLaw {
    /// Opens the contact law `name` of a library for steps of up to `dt` (s).
    ///
    /// # Errors
    /// Fails for a library without that law, a malformed table or request and refused parameters.
    pub fn open(library: &'static Library, name: &str, settings: &ParamSettings, dt: f64) -> Result<Self, HostError> {
        let info = library.plugin(PluginKind::ContactLaw, name)?;
        let extension = Extension::new::<abi::ContactLaw>(abi::CONTACT_LAW);
        let instance = Instance::open(library, info, settings, dt, extension)?;
        // SAFETY: opened with the extension of contact laws.
        let table: &'static abi::ContactLaw = unsafe { instance.table() };
        let (Some(ask), true) = (table.request, table.tractions.is_some()) else {
            return Err(instance.error("extension", "the contact law's table has a null in it"));
        };
        let size = size_of::<abi::ContactRequest>();
        let mut request = abi::ContactRequest { size, flags: 0, history_stride: 0, reach: 0.0 };
        // SAFETY: [main & active]; `request` is ours to fill.
        instance.run("request", || unsafe { ask(instance.plugin(), &mut request) })?;
        if request.history_stride > MAX_HISTORY || !(request.reach.is_finite() && request.reach >= 0.0) {
            let abi::ContactRequest { history_stride, reach, .. } = request;
            let text = format!(
                "{history_stride} doubles of history and a reach of {reach} m; allowed is up to {MAX_HISTORY}, and 0 m or more"
            );
            return Err(instance.error("request", &text));
        }
        if request.history_stride > 0 && table.advance.is_none() {
            return Err(instance.error("request", "history without `advance`"));
        }
        Ok(Self { instance, table, request })
    }

    /// Doubles of history per contact point.
    pub fn history_stride(&self) -> usize {
        self.request.history_stride as usize
    }

    /// Whether the normal traction may be negative.
    pub fn is_adhesive(&self) -> bool {
        self.request.flags & abi::ADHESIVE != 0
    }

    /// Largest gap at which the law has a traction, m.
    pub fn reach(&self) -> f64 {
        self.request.reach
    }

    /// Computes tractions in a state of a step of `dt` (s) that starts at `time` (s). `[sim]`
    ///
    /// # Errors
    /// Fails with the law's message; for a result that is not finite; for a negative normal traction of a law that is not adhesive.
    pub fn tractions(&self, states: &ContactStates, time: f64, dt: f64, out: &mut Tractions) -> Result<(), HostError> {
        out.reset(states.len());
        let call = self.table.tractions.expect("checked");
        let raw = abi::Traction {
            size: size_of::<abi::Traction>(),
            normal: out.normal.as_mut_ptr(),
            normal_by_gap: out.normal_by_gap.as_mut_ptr(),
            normal_by_gap_rate: out.normal_by_gap_rate.as_mut_ptr(),
            tangential: out.tangential.as_mut_ptr(),
            tangential_by_slip: out.tangential_by_slip.as_mut_ptr(),
            tangential_by_slip_rate: out.tangential_by_slip_rate.as_mut_ptr(),
        };
        let batch = self.batch(states, time, dt);
        // SAFETY: [sim & active]; arrays of the sizes that the header states.
        self.instance.run("tractions", || unsafe { call(self.instance.plugin(), &batch, &raw) })?;
        if !out.is_finite() {
            return Err(self.instance.error("tractions", "a traction is not finite"));
        }
        if !self.is_adhesive() && out.normal.iter().any(|p| *p < 0.0) {
            return Err(self.instance.error("tractions", "a normal traction is negative, and the law is not adhesive"));
        }
        Ok(())
    }

    /// Updates the histories of `states`, which are those at the end of an accepted step of `dt` (s) that started at `time` (s). `[sim]`
    ///
    /// # Errors
    /// Fails with the law's message, and for a history that is not finite.
    pub fn advance(&self, states: &mut ContactStates, time: f64, dt: f64) -> Result<(), HostError> {
        let Some(call) = self.table.advance.filter(|_| self.history_stride() > 0) else { return Ok(()) };
        let batch = self.batch(states, time, dt);
        let to = states.history.as_mut_ptr();
        let batch = abi::ContactBatch { history: to, ..batch };
        // SAFETY: [sim & active]; `to` has as many values as the batch's history, as the header allows the same ones.
        let done = self.instance.run("advance", || unsafe { call(self.instance.plugin(), &batch, to) });
        done?;
        if states.history.iter().all(|h| h.is_finite()) {
            return Ok(());
        }
        Err(self.instance.error("advance", "a history is not finite"))
    }

    /// The batch of a call for all points.
    fn batch(&self, states: &ContactStates, time: f64, dt: f64) -> abi::ContactBatch {
        let (m, stride) = (states.len(), self.history_stride());
        let planes = [&states.slip, &states.slip_rate];
        assert!(
            states.gap_rate.len() == m && states.area.len() == m && planes.iter().all(|array| array.len() == 2 * m),
            "one state for each point"
        );
        assert_eq!(states.history.len(), stride * m, "one history for each point");
        abi::ContactBatch {
            size: size_of::<abi::ContactBatch>(),
            begin: 0,
            end: m,
            count: m,
            gap: states.gap.as_ptr(),
            gap_rate: states.gap_rate.as_ptr(),
            slip: states.slip.as_ptr(),
            slip_rate: states.slip_rate.as_ptr(),
            area: states.area.as_ptr(),
            history: states.history.as_ptr(),
            history_stride: stride,
            time,
            dt,
        }
    }

    /// Messages of the law since the last call.
    pub fn messages(&self) -> NewMessages {
        self.instance.messages()
    }

    /// Descriptor of the plugin.
    pub fn info(&self) -> &'static PluginInfo {
        self.instance.info(PluginKind::ContactLaw)
    }
}
