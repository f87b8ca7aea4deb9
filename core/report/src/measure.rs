//! Quantities that are measured in a run, and their expected values.

use pliant_engine::session::Session;
use pliant_solver::{StepTime, Vec3};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The quantities that can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Quantity {
    /// Mean displacement along `axis` at the end, m.
    Displacement,
    /// Distance of the mean displacement from the vector `axis` (m) at the end, m.
    Distance,
    /// Mean position along `axis` over mean position along `over` at the end.
    Ratio,
    /// Sum of the reactions along `axis` at the end, N.
    Reaction,
    /// Elastic energy at the end, J.
    ElasticEnergy,
    /// Force on the first tool at the end, N.
    Force,
    /// Indentation depth of the first tool at the end, m.
    Depth,
    /// Torque on the first tool about `axis`, over the turn of sections about it for each metre along `over`, at the end, N m^2: the rigidity of a bar that
    /// the tool twists (`over` is `axis`) or bends.
    Rigidity,
    /// Mean time between upward passages of the mean displacement along `axis` through `centre` (m), after `after` (s); s.
    Period,
    /// Ratio of the amplitudes along `axis` about `centre` (m) of one period and the one before, after `after` (s).
    Decay,
}

/// A quantity of nodes of the first body, or of the first tool.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Measure {
    #[serde(rename = "kind")]
    pub(crate) quantity: Quantity,
    /// Box around the rest positions of the measured nodes: smallest and largest coordinates, m (2 x 3).
    #[serde(default, rename = "within")]
    pub(crate) node_box: [[f64; 3]; 2],
    /// A direction, normalised, or the vector of a distance, m.
    #[serde(default)]
    pub(crate) axis: [f64; 3],
    /// The direction of the denominator of a ratio, normalised.
    #[serde(default, rename = "over")]
    pub(crate) denominator_axis: [f64; 3],
    /// Displacement about which a signal oscillates, m.
    #[serde(default)]
    pub(crate) centre: f64,
    /// Time from which a signal is evaluated, s.
    #[serde(default)]
    pub(crate) after: f64,
}

/// A measure and its expected value.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct ExpectedMeasure {
    #[serde(flatten)]
    pub(crate) measure: Measure,
    /// Expected value, SI.
    pub(crate) expected: f64,
    /// Value that the error is relative to; by default the expected value.
    pub(crate) scale: Option<f64>,
}

/// Reads one measure during a run.
pub(crate) struct MeasureReader {
    measure: Measure,
    /// Indices of the measured nodes of the first body.
    nodes: Vec<usize>,
    /// Time (s) and mean displacement along the axis (m) after each step, for a period or a decay.
    signal: Vec<(f64, f64)>,
}

impl MeasureReader {
    /// Finds the measured nodes of an opened session.
    pub(crate) fn new(measure: &Measure, session: &Session) -> Self {
        let [low, high] = measure.node_box;
        let inside = |p: &Vec3| (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]);
        let rest = session.bodies.first().map_or(&[][..], |body| &body.system.nodes.rest);
        let nodes = (0..rest.len()).filter(|i| inside(&rest[*i])).collect();
        Self { measure: measure.clone(), nodes, signal: Vec::new() }
    }

    /// Reads the session after a step.
    pub(crate) fn step(&mut self, session: &Session) {
        if matches!(self.measure.quantity, Quantity::Period | Quantity::Decay) {
            self.signal.push((session.time(), self.mean_displacement(session).dot(&unit(self.measure.axis))));
        }
    }

    /// Mean displacement of the measured nodes, m.
    fn mean_displacement(&self, session: &Session) -> Vec3 {
        let nodes = &session.bodies[0].system.nodes;
        self.mean(|i| nodes.x[i] - nodes.rest[i])
    }

    /// Mean position of the measured nodes, m.
    fn mean_position(&self, session: &Session) -> Vec3 {
        let nodes = &session.bodies[0].system.nodes;
        self.mean(|i| nodes.x[i])
    }

    /// Turn about `axis` of sections across `denominator_axis`, for each metre along it, rad/m: the slope of the best line through the turns of all
    /// sections of measured nodes.
    fn turn_rate(&self, session: &Session) -> f64 {
        let (axis, along) = (unit(self.measure.axis), unit(self.measure.denominator_axis));
        let nodes = &session.bodies[0].system.nodes;
        let mut sections: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        for &i in &self.nodes {
            sections.entry((nodes.rest[i].dot(&along) / SECTION).round() as i64).or_default().push(i);
        }
        let turns = sections.iter().map(|(place, section)| {
            let mean = |x: &[Vec3]| section.iter().map(|&i| x[i]).sum::<Vec3>() / section.len() as f64;
            let (from, to) = (mean(&nodes.rest), mean(&nodes.x));
            let (mut sine, mut cosine) = (0.0, 0.0);
            for &i in section {
                let (a, b) = (reject(nodes.rest[i] - from, &axis), reject(nodes.x[i] - to, &axis));
                sine += axis.dot(&a.cross(&b));
                cosine += a.dot(&b);
            }
            (*place as f64 * SECTION, sine.atan2(cosine))
        });
        slope(&turns.collect::<Vec<_>>())
    }

    /// The mean of a vector over the measured nodes, given by node.
    fn mean(&self, vector: impl Fn(usize) -> Vec3) -> Vec3 {
        let sum: Vec3 = self.nodes.iter().map(|&i| vector(i)).sum();
        sum / self.nodes.len() as f64
    }

    /// The value at the end of a run, SI; NaN if there is nothing to measure.
    pub(crate) fn value(&self, session: &mut Session) -> f64 {
        let Measure { quantity, axis, denominator_axis, centre, after, .. } = self.measure;
        match quantity {
            Quantity::Displacement => self.mean_displacement(session).dot(&unit(axis)),
            Quantity::Distance => (self.mean_displacement(session) - Vec3::from(axis)).norm(),
            Quantity::Ratio => {
                let x = self.mean_position(session);
                x.dot(&unit(axis)) / x.dot(&unit(denominator_axis))
            }
            Quantity::Reaction => {
                let reaction = session.reactions(0);
                self.nodes.iter().map(|&i| reaction[i].dot(&unit(axis))).sum()
            }
            Quantity::ElasticEnergy => {
                let time = StepTime { start: session.time(), dt: session.dt() };
                session.bodies[0].system.energy(time).unwrap_or(f64::NAN)
            }
            Quantity::Force => session.frame().tools.first().map_or(f64::NAN, |t| t.force.norm()),
            Quantity::Depth => session.frame().tools.first().map_or(f64::NAN, |t| t.depth),
            Quantity::Rigidity => {
                let torque = session.frame().tools.first().map_or(f64::NAN, |t| t.torque.dot(&unit(axis)).abs());
                torque / self.turn_rate(session).abs()
            }
            Quantity::Period => period(&self.signal, centre, after),
            Quantity::Decay => decay(&self.signal, centre, after),
        }
    }
}

/// Nodes whose places along a bar differ by less belong to one section, m.
const SECTION: f64 = 1e-6;

/// The part of a vector across a unit vector.
fn reject(vector: Vec3, axis: &Vec3) -> Vec3 {
    vector - axis * vector.dot(axis)
}

/// Slope of the line that fits points best; NaN with fewer than two places.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let (mut above, mut below) = (0.0, 0.0);
    for point in points {
        above += (point.0 - x) * (point.1 - y);
        below += (point.0 - x).powi(2);
    }
    above / below
}

/// The unit vector along `axis`.
fn unit(axis: [f64; 3]) -> Vec3 {
    Vec3::from(axis).normalize()
}

/// Mean time (s) between upward passages of a signal (s, m) through `centre` (m), from the time `after` (s) on; NaN with fewer than two.
fn period(signal: &[(f64, f64)], centre: f64, after: f64) -> f64 {
    let late = signal.iter().position(|s| s.0 >= after).unwrap_or(signal.len());
    let up = signal[late..].windows(2).filter(|w| w[0].1 < centre && w[1].1 >= centre);
    let passages: Vec<f64> = up.map(|w| w[0].0 + (w[1].0 - w[0].0) * (centre - w[0].1) / (w[1].1 - w[0].1)).collect();
    match passages[..] {
        [first, .., last] => (last - first) / (passages.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// Ratio of the amplitudes of one period and the one before, from the first extreme of a signal (s, m) about `centre` (m) to the last
/// that rounding does not hide, from the time `after` (s) on; NaN with fewer than two.
fn decay(signal: &[(f64, f64)], centre: f64, after: f64) -> f64 {
    let late = signal.iter().position(|s| s.0 >= after).unwrap_or(signal.len());
    let away: Vec<f64> = signal[late..].iter().map(|s| (s.1 - centre).abs()).collect();
    // Height of the parabola through the three samples around an extreme.
    let peak = |w: &[f64]| w[1] + (w[0] - w[2]).powi(2) / (8.0 * (2.0 * w[1] - w[0] - w[2])).max(f64::MIN_POSITIVE);
    let peaks: Vec<f64> = away.windows(3).filter(|w| w[0] < w[1] && w[1] >= w[2]).map(peak).collect();
    let floor = peaks.first().map_or(0.0, |t| 1e-6 * t);
    let seen: Vec<f64> = peaks.into_iter().take_while(|t| *t > floor).collect();
    match seen[..] {
        [first, .., last] => (last / first).powf(2.0 / (seen.len() - 1) as f64),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_a_line_and_of_the_best_one() {
        let line: Vec<_> = (0..7).map(|i| (0.1 * f64::from(i) - 3.0, 2.0 - 0.7 * f64::from(i))).collect();
        assert!((slope(&line) + 7.0).abs() < 1e-12);
        assert!((slope(&[(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)]) - 0.5).abs() < 1e-12);
        assert!(slope(&[(1.0, 3.0)]).is_nan() && slope(&[]).is_nan());
    }

    #[test]
    fn period_and_decay_of_a_known_signal() {
        let (w, rate) = (7.0_f64, 0.4);
        let at = |i: u32| f64::from(i) * 1e-3;
        let signal: Vec<_> = (0..8000).map(at).map(|t| (t, 0.3 + (-rate * t).exp() * (w * t).cos())).collect();
        let turn = 2.0 * std::f64::consts::PI / w;
        assert!((period(&signal, 0.3, 0.1) / turn - 1.0).abs() < 1e-5);
        assert!((decay(&signal, 0.3, 0.1) / (-rate * turn).exp() - 1.0).abs() < 1e-4);
        assert!(period(&signal[..10], 0.3, 0.0).is_nan());
    }
}
