//! What is measured in a run, and what it should be.

use pliant_engine::session::Session;
use pliant_solver::{StepTime, V3, dot};
use serde::Deserialize;

/// Quantities there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// m, mean displacement along `axis`, at the end
    Displacement,
    /// m, length of what the mean displacement is off from the vector `axis`, at the end
    Distance,
    /// Mean place along `axis` over mean place along `over`, at the end
    Ratio,
    /// N, sum along `axis` of what it takes to hold the nodes, at the end
    Reaction,
    /// J, at the end
    ElasticEnergy,
    /// N, on the first tool, at the end
    Force,
    /// m, of the first tool, at the end
    Depth,
    /// s, between passages of `centre` (m) in one direction along `axis`, after `after` (s)
    Period,
    /// Share of the amplitude along `axis` about `centre` (m) that a period leaves, after `after` (s)
    Decay,
}

/// A quantity of the nodes of the first body, or of the first tool.
#[derive(Clone, Debug, Deserialize)]
pub struct Measure {
    /// What.
    pub kind: Quantity,
    /// m, least and greatest corner of a box around the rest places of the nodes it is of
    #[serde(default)]
    pub within: [V3; 2],
    /// A direction, made a unit vector.
    #[serde(default)]
    pub axis: V3,
    /// Another.
    #[serde(default)]
    pub over: V3,
    /// m
    #[serde(default)]
    pub centre: f64,
    /// s
    #[serde(default)]
    pub after: f64,
}

/// A measure and what it should be.
#[derive(Clone, Debug, Deserialize)]
pub struct Wanted {
    /// What.
    #[serde(flatten)]
    pub measure: Measure,
    /// SI
    pub expected: f64,
    /// What the error is relative to; by default the expected value.
    pub scale: Option<f64>,
}

/// Reads one measure through a run.
pub(super) struct Reader {
    measure: Measure,
    /// Nodes of the first body within.
    nodes: Vec<usize>,
    /// (s, m)
    signal: Vec<(f64, f64)>,
}

impl Reader {
    pub(super) fn new(measure: &Measure, session: &Session) -> Self {
        let [low, high] = measure.within;
        let inside = |p: &V3| (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]);
        let rest = session.bodies.first().map_or(&[][..], |body| &body.system.nodes.rest);
        let nodes = (0..rest.len()).filter(|i| inside(&rest[*i])).collect();
        Self { measure: measure.clone(), nodes, signal: Vec::new() }
    }

    /// After a step.
    pub(super) fn step(&mut self, session: &Session) {
        if matches!(self.measure.kind, Quantity::Period | Quantity::Decay) {
            self.signal.push((session.time(), dot(self.mean(session, true), unit(self.measure.axis))));
        }
    }

    /// m, the mean of what the nodes within have moved, or of where they are.
    fn mean(&self, session: &Session, moved: bool) -> V3 {
        let nodes = &session.bodies[0].system.nodes;
        let mut sum = [0.0; 3];
        for &i in &self.nodes {
            for c in 0..3 {
                sum[c] += nodes.x[i][c] - if moved { nodes.rest[i][c] } else { 0.0 };
            }
        }
        sum.map(|s| s / self.nodes.len() as f64)
    }

    /// Not a number where there was nothing to measure.
    pub(super) fn value(&self, session: &mut Session) -> f64 {
        let Measure { kind, axis, over, centre, after, .. } = self.measure;
        match kind {
            Quantity::Displacement => dot(self.mean(session, true), unit(axis)),
            Quantity::Distance => {
                let u = self.mean(session, true);
                (0..3).map(|i| (u[i] - axis[i]).powi(2)).sum::<f64>().sqrt()
            }
            Quantity::Ratio => {
                let x = self.mean(session, false);
                dot(x, unit(axis)) / dot(x, unit(over))
            }
            Quantity::Reaction => {
                let reaction = session.reactions(0);
                self.nodes.iter().map(|&i| dot(reaction[i], unit(axis))).sum()
            }
            Quantity::ElasticEnergy => {
                let time = StepTime { start: session.time(), dt: session.dt() };
                session.bodies[0].system.energy(time).unwrap_or(f64::NAN)
            }
            Quantity::Force => session.frame().tools.first().map_or(f64::NAN, |t| dot(t.force, t.force).sqrt()),
            Quantity::Depth => session.frame().tools.first().map_or(f64::NAN, |t| t.depth),
            Quantity::Period => period(&self.signal, centre, after),
            Quantity::Decay => decay(&self.signal, centre, after),
        }
    }
}

fn unit(axis: V3) -> V3 {
    let length = dot(axis, axis).sqrt();
    axis.map(|c| c / length)
}

/// Mean time between upward passages of `centre`.
fn period(signal: &[(f64, f64)], centre: f64, after: f64) -> f64 {
    let late = signal.iter().position(|s| s.0 >= after).unwrap_or(signal.len());
    let up = signal[late..].windows(2).filter(|w| w[0].1 < centre && w[1].1 >= centre);
    let passages: Vec<f64> = up.map(|w| w[0].0 + (w[1].0 - w[0].0) * (centre - w[0].1) / (w[1].1 - w[0].1)).collect();
    match passages[..] {
        [first, .., last] => (last - first) / (passages.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// Share of the amplitude a period leaves, from the first extreme to the last that is not lost in rounding.
fn decay(signal: &[(f64, f64)], centre: f64, after: f64) -> f64 {
    let late = signal.iter().position(|s| s.0 >= after).unwrap_or(signal.len());
    let away: Vec<f64> = signal[late..].iter().map(|s| (s.1 - centre).abs()).collect();
    // Height of the parabola through the three samples around an extreme.
    let top = |w: &[f64]| w[1] + (w[0] - w[2]).powi(2) / (8.0 * (2.0 * w[1] - w[0] - w[2])).max(f64::MIN_POSITIVE);
    let tops: Vec<f64> = away.windows(3).filter(|w| w[0] < w[1] && w[1] >= w[2]).map(top).collect();
    let floor = tops.first().map_or(0.0, |t| 1e-6 * t);
    let seen: Vec<f64> = tops.into_iter().take_while(|t| *t > floor).collect();
    match seen[..] {
        [first, .., last] => (last / first).powf(2.0 / (seen.len() - 1) as f64),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
