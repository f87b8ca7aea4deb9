//! Probes: quantities of a scene that are measured during a run.

use pliant_engine::plan::Probe;
use pliant_engine::probe::Reading;
use pliant_engine::session::{Frame, Session};
use pliant_mesh::geometry::Vec3;
use serde::Serialize;

/// The result of a probe.
#[derive(Clone, Debug, Serialize)]
pub struct ProbeResult {
    /// Name in the scene.
    pub name: String,
    /// Measured value, SI.
    pub value: f64,
    /// Time of the measurement in the run, s.
    pub time: f64,
    /// Value the scene expects, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<f64>,
    /// `|value - expected| / |expected|`, or the absolute difference where zero is expected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Largest allowed error, in the unit of `error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Whether the error is within the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub passed: Option<bool>,
    /// Source of the expected value.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub source: String,
}

/// Reads the probes of a scene during a run.
pub(crate) struct ProbeReader {
    /// The probes in the order of the scene.
    readings: Vec<ProbeState>,
}

/// One probe and its value so far.
struct ProbeState {
    /// The probe of the plan.
    probe: Probe,
    /// Vertex of the rest surface nearest to the probe's point; 0 without a point.
    vertex: usize,
    /// Value, SI; `None` before the first measurement of a component, which may be negative.
    value: Option<f64>,
    /// Time at which `value` was measured, s.
    time: f64,
    /// Whether the time of the probe has passed.
    done: bool,
}

impl ProbeState {
    /// Whether the probe must be read after this step: its time has come, the run ends, or it measures the largest value.
    fn is_due(&self, frame: &Frame, last: bool) -> bool {
        self.probe.greatest || last || frame.time >= self.probe.time * (1.0 - 1e-12)
    }
}

impl ProbeReader {
    /// Finds the vertices of the probes of a session.
    pub(crate) fn new(session: &Session) -> Self {
        let reading = |probe: &Probe| {
            let vertex = match (probe.at, session.body_of_scene(probe.of)) {
                (Some(at), Some(body)) => {
                    let distance = |p: &Vec3| (p - at).norm_squared();
                    let points = body.model.surface.points.iter().enumerate();
                    points.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map_or(0, |(v, _)| v)
                }
                _ => 0,
            };
            let value = probe.direction.is_none().then_some(0.0);
            ProbeState { probe: probe.clone(), vertex, value, time: 0.0, done: false }
        };
        Self { readings: session.plan().probes.iter().map(reading).collect() }
    }

    /// Whether [`ProbeReader::read`] needs an up-to-date surface at this time (s). `last`: no step comes after it.
    pub(crate) fn needs_surface(&self, time: f64, last: bool) -> bool {
        let of_surface = |r: &&ProbeState| r.probe.quantity.needs_surface && !r.done;
        self.readings.iter().filter(of_surface).any(|r| r.probe.greatest || last || time >= r.probe.time)
    }

    /// Reads every probe after a step. `last`: no step comes after it.
    pub(crate) fn read(&mut self, session: &Session, frame: &Frame, last: bool) {
        for reading in self.readings.iter_mut().filter(|r| !r.done) {
            let quantity = reading.probe.quantity;
            if quantity.is_costly && !reading.is_due(frame, last) {
                continue;
            }
            let (of, vertex) = (reading.probe.of, reading.vertex);
            let part = reading.probe.part;
            let value = quantity.value(&Reading { session, frame, of, part, vertex }, reading.probe.direction);
            if !reading.probe.greatest || reading.value.is_none_or(|most| value > most) || !value.is_finite() {
                (reading.value, reading.time) = (Some(value), frame.time);
            }
            reading.done = frame.time >= reading.probe.time * (1.0 - 1e-12);
        }
    }

    /// The results, in the order of the scene.
    pub(crate) fn results(&self) -> Vec<ProbeResult> {
        let result = |r: &ProbeState| {
            let value = r.value.unwrap_or(0.0);
            let error = r.probe.expected.map(|expected| {
                let difference = (value - expected).abs();
                if expected == 0.0 { difference } else { difference / expected.abs() }
            });
            ProbeResult {
                name: r.probe.name.clone(),
                value,
                time: r.time,
                expected: r.probe.expected,
                error,
                tolerance: error.map(|_| r.probe.tolerance),
                // False for NaN: the probe fails.
                passed: error.map(|e| e <= r.probe.tolerance),
                source: r.probe.source.clone(),
            }
        };
        self.readings.iter().map(result).collect()
    }
}
