//! How well the simulation keeps time, over the last second.

use pliant_live::LiveGauges;
use serde::Serialize;

/// How well the simulation keeps time, and how large it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gauges {
    /// Simulated time over wall-clock time; 1 is real time.
    pub real_time_factor: f64,
    /// s, median of the wall-clock time of a step
    pub step_median: f64,
    /// s, 99th percentile of the wall-clock time of a step
    pub step_p99: f64,
    /// s, simulated time of a step
    pub dt: f64,
    /// Hz, ticks of the haptic thread
    pub haptic_rate: f64,
    /// s, the latest beginning of a tick
    pub lateness: f64,
    /// Ticks not finished before the next was due, since the start.
    pub missed: u64,
    /// Nodes that are simulated.
    pub nodes: usize,
    /// Elements that are simulated.
    pub elements: usize,
    /// Bytes of the largest parts of the session.
    pub bytes: usize,
}

/// Times of one thing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StepTimes {
    /// Median of the durations, s.
    pub median: f64,
    /// 99th percentile of the durations, s.
    pub p99: f64,
    /// How many there were.
    pub count: usize,
}

impl StepTimes {
    /// Of a list (s), which is sorted.
    pub fn of(list: &mut [f64]) -> Self {
        list.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            let place = (list.len() as f64 * share).ceil() as usize;
            list.get(place.saturating_sub(1)).copied().unwrap_or_default()
        };
        Self { median: at(0.5), p99: at(0.99), count: list.len() }
    }
}

/// Real-time factor below which the picture is slow motion that is seen.
const SLOW: f64 = 0.9;

impl Gauges {
    /// Whether simulation is slower than time.
    pub fn is_slow(&self) -> bool {
        self.real_time_factor > 0.0 && self.real_time_factor < SLOW
    }
}

/// Steps of a session whose times are kept for its end: a quarter of an hour of 1 ms.
const REMEMBERED: usize = 1_000_000;
impl Gauges {
    /// Whether steps are quick enough, and other programs keep the processors from them.
    pub fn is_held_up(&self) -> bool {
        self.is_slow() && self.step_median < IDLE_SHARE * self.dt
    }
}

/// Share of real time that steps may take by themselves while a slow simulation is still put down to other programs.
const IDLE_SHARE: f64 = 0.6;

/// s, over which gauges are averaged
const WINDOW: f64 = 1.0;

/// Collects what gauges are made of.
pub(super) struct GaugeWindow {
    /// s, wall-clock time of the steps in the present window
    steps: Vec<f64>,
    /// s, of all steps, up to [`REMEMBERED`]
    all: Vec<f64>,
    before: LiveGauges,
    lateness: f64,
    gauges: Gauges,
}

impl GaugeWindow {
    pub(super) fn new(dt: f64) -> Self {
        let gauges = Gauges { dt, ..Gauges::default() };
        Self { steps: Vec::new(), all: Vec::new(), before: LiveGauges::default(), lateness: 0.0, gauges }
    }

    /// Takes the wall-clock time (s) of a step.
    pub(super) fn step(&mut self, seconds: f64) {
        self.steps.push(seconds);
        if self.all.len() < REMEMBERED {
            self.all.push(seconds);
        }
    }

    /// Takes over the gauges of the session; figures change once a second.
    pub(super) fn update(&mut self, now: LiveGauges) {
        self.lateness = self.lateness.max(now.worst_lateness);
        let passed = now.seconds - self.before.seconds;
        if passed < WINDOW {
            return;
        }
        let steps = (now.steps - self.before.steps) as f64;
        self.gauges.real_time_factor = steps * self.gauges.dt / passed;
        self.gauges.haptic_rate = (now.ticks - self.before.ticks) as f64 / passed;
        (self.gauges.lateness, self.gauges.missed) = (self.lateness, now.missed);
        let times = StepTimes::of(&mut self.steps);
        (self.gauges.step_median, self.gauges.step_p99) = (times.median, times.p99);
        self.steps.clear();
        (self.before, self.lateness) = (now, 0.0);
    }

    /// Takes the size of what is simulated.
    pub(super) fn size(&mut self, nodes: usize, elements: usize, bytes: usize) {
        (self.gauges.nodes, self.gauges.elements, self.gauges.bytes) = (nodes, elements, bytes);
    }

    /// Times of all steps so far.
    pub(super) fn all(mut self) -> StepTimes {
        StepTimes::of(&mut self.all)
    }

    pub(super) fn gauges(&self) -> Gauges {
        self.gauges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_last_second() {
        let mut window = GaugeWindow::new(1e-3);
        let after = |seconds: f64, steps: u64, worst_lateness: f64| LiveGauges {
            seconds,
            steps,
            ticks: 2 * steps,
            worst_lateness,
            ..LiveGauges::default()
        };
        (1..=200).for_each(|ms| window.step(f64::from(ms) * 1e-3));
        window.update(after(0.4, 100, 3e-4));
        assert_eq!(window.gauges().real_time_factor, 0.0, "not yet");
        window.update(after(1.0, 500, 1e-4));
        let gauges = window.gauges();
        assert!((gauges.real_time_factor - 0.5).abs() < 1e-12 && gauges.is_slow() && !gauges.is_held_up());
        assert!(Gauges { step_median: 2e-4, ..gauges }.is_held_up());
        assert_eq!((gauges.step_median, gauges.step_p99, gauges.lateness), (0.1, 0.198, 3e-4));
        assert!((gauges.haptic_rate - 1000.0).abs() < 1e-9);
        window.update(after(2.0, 1500, 0.0));
        assert!(!window.gauges().is_slow() && window.gauges().lateness == 0.0);
    }
}
