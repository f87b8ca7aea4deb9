//! Step limits of the bodies of a session, and the number of substeps that keeps them.

use super::EditCost;
use crate::scene::TimeScene;
use pliant_solver::{Frequencies, Scheme, StepLimit};
use serde::Serialize;

/// Cost of a step of a body with a tool, measured when the session was opened.
#[derive(Clone, Debug, Serialize)]
pub struct StepCost {
    /// Name in the scene.
    pub body: String,
    /// Number of active nodes: around one contact, or of the whole body.
    pub nodes: usize,
    /// Number of active elements.
    pub elements: usize,
    /// Time of all substeps, s; for implicit schemes that of forces and assembly, without solver iterations.
    pub seconds: f64,
}

/// Scheme, frequencies of the bodies, and how many substeps are allowed.
pub(super) struct StepLimits {
    /// Integration scheme of all bodies.
    pub(super) scheme: Scheme,
    /// Frequencies of each body without tools.
    pub(super) frequencies: Vec<Frequencies>,
    /// Frequencies of each body in contact with a tool, if there are tools.
    pub(super) planned: Vec<Frequencies>,
    /// Cost of a step of each body with a tool.
    pub(super) costs: Vec<StepCost>,
    /// Cost of a step of each body under each edit of the scene.
    pub(super) edit_costs: Vec<EditCost>,
    /// Largest number of substeps in a step.
    pub(super) max_substeps: usize,
    /// Whether steps over the limit are allowed and not divided.
    pub(super) is_forced: bool,
}

impl StepLimits {
    /// Limits without bodies yet, with the settings of a scene.
    pub(super) fn new(time: &TimeScene) -> Self {
        Self {
            scheme: Scheme::SymplecticEuler,
            frequencies: Vec::new(),
            planned: Vec::new(),
            costs: Vec::new(),
            edit_costs: Vec::new(),
            max_substeps: *time.most_substeps.get_ref() as usize,
            is_forced: time.force_unstable,
        }
    }

    /// Forgets the bodies from number `count` on.
    pub(super) fn truncate(&mut self, count: usize) {
        self.frequencies.truncate(count);
        self.planned.truncate(count);
        self.costs.truncate(count);
    }

    /// Adds a body with the limits of the body number `root`, of which it is a part: no mode of a part is faster than the fastest one of the whole.
    pub(super) fn push_like(&mut self, root: usize, name: &str) {
        self.frequencies.push(self.frequencies[root]);
        self.planned.push(self.planned[root]);
        self.costs.push(StepCost { body: name.to_owned(), ..self.costs[root].clone() });
    }

    /// Largest step for which `scheme` is stable for every body, s; `None` without a limit.
    pub(super) fn limit(&self, scheme: Scheme) -> Option<f64> {
        least(self.planned.iter().map(|f| f.limit(scheme)))
    }

    /// As [`StepLimits::limit`], with Gershgorin's upper bound of the frequencies: surely stable, and smaller than necessary.
    pub(super) fn certain_limit(&self, scheme: Scheme) -> Option<f64> {
        least(self.planned.iter().map(|f| Frequencies { stiffness: f.bound, ..*f }.limit(scheme)))
    }

    /// Number of substeps that keep a body with these frequencies stable; 1 where the scheme has no limit.
    pub(super) fn needed_substeps(&self, frequencies: &Frequencies, dt: f64) -> usize {
        match frequencies.limit(self.scheme) {
            StepLimit::At(limit) if limit > 0.0 => (dt / limit).ceil() as usize,
            StepLimit::At(_) | StepLimit::None => 1,
        }
    }

    /// Whether the allowed substeps of steps of `dt` (s) keep every body stable in contact with a tool if it is stiffer by this factor.
    pub(super) fn allow_stiffness(&self, factor: f64, dt: f64) -> bool {
        let keeps = |planned: &Frequencies| self.needed_substeps(&planned.stiffened(factor), dt) <= self.max_substeps;
        self.is_forced || self.planned.iter().all(keeps)
    }
}

fn least(limits: impl Iterator<Item = StepLimit>) -> Option<f64> {
    let at = |limit| if let StepLimit::At(at) = limit { Some(at) } else { None };
    limits.filter_map(at).reduce(f64::min)
}
