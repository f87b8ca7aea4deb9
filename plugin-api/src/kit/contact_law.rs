//! Safe calls into a contact law under test.
#![allow(unsafe_code, reason = "plays the host")]

use super::guarded::{Guarded, Guards};
use super::instance::TestInstance;
use crate::abi;
use crate::contact_law::{ContactPoint, PointTraction};
use crate::fault::Fault;

/// An active contact law and its table.
pub struct TestContactLaw {
    instance: TestInstance,
    table: &'static abi::ContactLaw,
    request: abi::ContactRequest,
    pub(super) guards: Guards,
}

// SAFETY: `tractions` and `advance` are [sim], which the header lets a host call from several threads at once, on disjoint points;
// the lock of the instance's last error is one for threads.
unsafe impl Sync for TestContactLaw {}

/// Most doubles of history per contact point, as in the host.
const MAX_HISTORY: u32 = 64;

// SAFETY of every call below: [sim & active] or less, with arrays of the sizes that the header states.
impl TestContactLaw {
    /// Looks up the table of an active instance and asks for its request.
    ///
    /// # Errors
    /// A missing or incomplete table, a request out of range, or the plugin's fault.
    pub fn new(instance: TestInstance) -> Result<Self, Fault> {
        let missing = || Fault::bad_argument("`pliant.contact-law/1` is not offered or has a null in it");
        let table: &'static abi::ContactLaw = instance.extension(abi::CONTACT_LAW)?.ok_or_else(missing)?;
        let ask = table.request.ok_or_else(missing)?;
        let size = size_of::<abi::ContactRequest>();
        let mut request = abi::ContactRequest { size, flags: 0, history_stride: 0, reach: 0.0 };
        // SAFETY: see above.
        instance.check(unsafe { ask(instance.raw(), &mut request) })?;
        let needs_advance = request.history_stride > 0;
        if table.tractions.is_none() || (needs_advance && table.advance.is_none()) {
            return Err(missing());
        }
        if request.history_stride > MAX_HISTORY || !(request.reach.is_finite() && request.reach >= 0.0) {
            return Err(Fault::bad_argument(format!(
                "{} doubles of history and a reach of {} m; allowed is up to {MAX_HISTORY}, and 0 or more",
                request.history_stride, request.reach
            )));
        }
        Ok(Self { instance, table, request, guards: Guards::default() })
    }

    /// Whether the normal traction may be negative.
    pub fn is_adhesive(&self) -> bool {
        self.request.flags & abi::ADHESIVE != 0
    }

    /// Largest gap at which the law has a traction, m.
    pub fn reach(&self) -> f64 {
        self.request.reach
    }

    /// Doubles of history per contact point.
    pub fn history_stride(&self) -> usize {
        self.request.history_stride as usize
    }

    /// Tractions of points with their histories (as many numbers for each), in calls of at most `max_points` points.
    ///
    /// # Errors
    /// The plugin's fault, and a value written outside of the points of a call.
    pub fn tractions(
        &self,
        points: &[ContactPoint],
        histories: &[f64],
        max_points: usize,
    ) -> Result<Vec<PointTraction>, Fault> {
        let (m, stride) = (points.len(), self.history_stride());
        let state = Planes::new(points, histories, stride, &self.guards);
        let mut planes = RESULTS.map(|(name, count)| self.guards.around(name, &vec![UNWRITTEN; count * m]));
        let mut begin = 0;
        while begin < m {
            let end = m.min(begin.saturating_add(max_points));
            let before = planes.each_ref().map(|plane| plane.array().to_vec());
            let [normal, by_gap, by_rate, tangential, by_slip, by_slip_rate] = &mut planes;
            let out = abi::Traction {
                size: size_of::<abi::Traction>(),
                normal: normal.as_mut_ptr(),
                normal_by_gap: by_gap.as_mut_ptr(),
                normal_by_gap_rate: by_rate.as_mut_ptr(),
                tangential: tangential.as_mut_ptr(),
                tangential_by_slip: by_slip.as_mut_ptr(),
                tangential_by_slip_rate: by_slip_rate.as_mut_ptr(),
            };
            let call = self.table.tractions.expect("checked");
            // SAFETY: see above.
            self.instance.check(unsafe { call(self.instance.raw(), &state.batch(points, begin, end), &out) })?;
            let inside = |i: usize| (begin..end).contains(&(i % m));
            let is_kept = |(new, old): (&Guarded<f64>, &Vec<f64>)| {
                let pairs = new.array().iter().zip(old);
                pairs.enumerate().all(|(i, (new, old))| inside(i) || new.to_bits() == old.to_bits())
            };
            if !planes.iter().zip(&before).all(is_kept) {
                return Err(Fault::bad_argument("`tractions` wrote values of points outside of its call"));
            }
            begin = end;
        }
        RESULTS.iter().zip(&planes).for_each(|((name, _), plane)| self.guards.look_at_output("tractions", name, plane));
        state.look_at("tractions", &self.guards);
        let [normal, by_gap, by_rate, tangential, by_slip, by_slip_rate] = planes.each_ref().map(Guarded::array);
        let pair = |planes: &[f64], i: usize| [planes[i], planes[m + i]];
        let matrix = |p: &[f64], i: usize| [[p[i], p[m + i]], [p[2 * m + i], p[3 * m + i]]];
        Ok((0..m)
            .map(|i| PointTraction {
                normal: normal[i],
                normal_by_gap: by_gap[i],
                normal_by_gap_rate: by_rate[i],
                tangential: pair(tangential, i),
                tangential_by_slip: matrix(by_slip, i),
                tangential_by_slip_rate: matrix(by_slip_rate, i),
            })
            .collect())
    }

    /// Traction of one point.
    ///
    /// # Errors
    /// The plugin's fault.
    pub fn traction(&self, point: ContactPoint, history: &[f64]) -> Result<PointTraction, Fault> {
        Ok(self.tractions(&[point], history, 1)?[0])
    }

    /// Updates the histories of points, in calls of at most `max_points` points.
    ///
    /// # Errors
    /// The plugin's fault.
    pub fn advance(&self, points: &[ContactPoint], histories: &mut [f64], max_points: usize) -> Result<(), Fault> {
        let (m, stride) = (points.len(), self.history_stride());
        let Some(call) = self.table.advance.filter(|_| stride > 0) else { return Ok(()) };
        let mut begin = 0;
        while begin < m {
            let end = m.min(begin.saturating_add(max_points));
            let state = Planes::new(points, histories, stride, &self.guards);
            let mut new = self.guards.around("out", state.history.array());
            // SAFETY: see above.
            let status = unsafe { call(self.instance.raw(), &state.batch(points, begin, end), new.as_mut_ptr()) };
            self.instance.check(status)?;
            self.guards.look_at_output("advance", "out", &new);
            state.look_at("advance", &self.guards);
            for (i, value) in new.array().iter().enumerate() {
                let (plane, point) = (i / m, i % m);
                histories[point * stride + plane] = *value;
            }
            begin = end;
        }
        Ok(())
    }
}

/// What is in a result before the plugin writes it.
const UNWRITTEN: f64 = -7.25e-37;

/// Names of the results, and their numbers of planes.
const RESULTS: [(&str, usize); 6] = [
    ("normal", 1),
    ("normal_by_gap", 1),
    ("normal_by_gap_rate", 1),
    ("tangential", 2),
    ("tangential_by_slip", 4),
    ("tangential_by_slip_rate", 4),
];

/// Names of the arrays that a law reads.
pub(super) const STATES: [&str; 6] = ["gap", "gap_rate", "slip", "slip_rate", "area", "history"];

/// States of points in the planes of the interface, between guards.
struct Planes {
    gap: Guarded<f64>,
    gap_rate: Guarded<f64>,
    slip: Guarded<f64>,
    slip_rate: Guarded<f64>,
    area: Guarded<f64>,
    history: Guarded<f64>,
    stride: usize,
}

impl Planes {
    /// Planes of points whose histories follow each other, `stride` numbers each.
    fn new(points: &[ContactPoint], histories: &[f64], stride: usize, guards: &Guards) -> Self {
        assert_eq!(histories.len(), points.len() * stride, "a history for each point");
        // As many allocations for one point as for many, so that those of the plugin can be told from them.
        let planes = |name: &str, count: usize, value: &dyn Fn(usize, usize) -> f64| {
            let mut all = Vec::with_capacity(count * points.len());
            (0..count).for_each(|plane| all.extend((0..points.len()).map(|i| value(plane, i))));
            guards.around(name, &all)
        };
        Self {
            gap: planes("gap", 1, &|_, i| points[i].gap),
            gap_rate: planes("gap_rate", 1, &|_, i| points[i].gap_rate),
            slip: planes("slip", 2, &|axis, i| points[i].slip[axis]),
            slip_rate: planes("slip_rate", 2, &|axis, i| points[i].slip_rate[axis]),
            area: planes("area", 1, &|_, i| points[i].area),
            history: planes("history", stride, &|plane, i| histories[i * stride + plane]),
            stride,
        }
    }

    /// Looks for writes into and around the states.
    fn look_at(&self, function: &str, guards: &Guards) {
        let Self { gap, gap_rate, slip, slip_rate, area, history, stride: _ } = self;
        let all = STATES.iter().zip([gap, gap_rate, slip, slip_rate, area, history]);
        all.for_each(|(name, array)| guards.look_at_input(function, name, array));
    }

    /// The batch of a call for some of the points.
    fn batch(&self, points: &[ContactPoint], begin: usize, end: usize) -> abi::ContactBatch {
        abi::ContactBatch {
            size: size_of::<abi::ContactBatch>(),
            begin,
            end,
            count: points.len(),
            gap: self.gap.as_ptr(),
            gap_rate: self.gap_rate.as_ptr(),
            slip: self.slip.as_ptr(),
            slip_rate: self.slip_rate.as_ptr(),
            area: self.area.as_ptr(),
            history: self.history.as_ptr(),
            history_stride: self.stride,
            time: points[0].time,
            dt: points[0].dt,
        }
    }
}
