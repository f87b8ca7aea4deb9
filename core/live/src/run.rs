//! A live session: its threads, from their start to their end.

use super::deadline::Pacer;
use super::exchange::{Exchange, Samples};
use super::footing::Footing;
use super::haptic::Haptic;
use super::picture::{Display, Viewer};
use super::servo::servo;
use super::summary::{DeviceCounts, HandSummary, LiveSummary};
use super::thread::{self, Clock, Ended, Shared};
use super::watchdog::Watchdog;
use pliant_engine::session::{EventKind, Session};
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{JoinHandle, sleep};
use std::time::Duration;

/// What the caller decides.
#[derive(Default)]
pub struct LiveSettings {
    /// Hz, of the haptic loop; by default that of the fastest device, up to 4 kHz
    pub rate: Option<f64>,
    /// Who looks, if anybody does.
    pub viewer: Option<Box<dyn Viewer>>,
}

/// ns, that the first tick is waited for
const FIRST: u64 = 500_000_000;

/// A session under way. The simulation is the caller's thread; dropping this stops the devices and ends the others, also
/// while a panic goes by.
pub struct Live {
    clock: Clock,
    shared: Arc<Shared>,
    haptic: Option<JoinHandle<Ended>>,
    watchdog: Watchdog,
    exchange: Exchange,
    display: Option<Display>,
    pacer: Pacer,
    rate: f64,
    began: u64,
    steps: u64,
    dt: f64,
    told: Vec<bool>,
    /// Of the devices, in their order.
    names: Vec<String>,
}

impl Live {
    /// Takes a session's devices and starts.
    ///
    /// # Errors
    /// A system that gives no threads.
    pub fn start(session: &mut Session, settings: LiveSettings) -> io::Result<Self> {
        let missing = |index: usize| io::Error::other(format!("device {index} is not open"));
        let taken = session.take_devices().into_iter().enumerate();
        let devices = taken.map(|(i, device)| device.map(|d| Box::new(d) as Box<dyn Haptic>).ok_or_else(|| missing(i)));
        let devices = devices.collect::<io::Result<Vec<_>>>()?;
        Self::start_with(session, devices, settings)
    }

    /// The same with devices of the caller's, in the order of the session's.
    ///
    /// # Errors
    /// As for [`Live::start`].
    pub fn start_with(
        session: &mut Session,
        devices: Vec<Box<dyn Haptic>>,
        settings: LiveSettings,
    ) -> io::Result<Self> {
        session.lead_tips();
        let told = vec![false; devices.len()];
        let names = session.devices.iter().map(|slot| slot.name.clone()).collect();
        let (servo, exchange) = servo(session, devices, settings.rate);
        let display = settings.viewer.map(Display::start).transpose()?;
        let (rate, shared, clock) = (servo.rate(), Arc::new(Shared::default()), Clock::start());
        let watchdog = Watchdog::start(servo.stoppers(), Arc::clone(&shared))?;
        let haptic = Some(thread::start(servo, clock, Arc::clone(&shared))?);
        // The first step has a hand: nobody waits for another from here on.
        while shared.beats.load(Ordering::Relaxed) < 2 && clock.now() < FIRST {
            sleep(Duration::from_millis(1));
        }
        let (began, dt) = (clock.now(), session.dt());
        let pacer = Pacer::new(began, dt);
        Ok(Self { clock, shared, haptic, watchdog, exchange, display, pacer, rate, began, steps: 0, dt, told, names })
    }

    /// s, wall clock, since the start
    pub fn seconds(&self) -> f64 {
        (self.clock.now() - self.began) as f64 * 1e-9
    }

    /// Whether the haptic thread is still there.
    pub fn is_alive(&self) -> bool {
        self.haptic.as_ref().is_some_and(|haptic| !haptic.is_finished())
    }

    /// Waits until a step is due, and takes it under the newest hands, which it gives.
    pub fn step(&mut self, session: &mut Session) -> &Samples {
        while let Some(wait) = self.pacer.wait(self.clock.now()) {
            sleep(Duration::from_nanos(wait));
        }
        self.steps += 1;
        let samples = self.exchange.step(session);
        let now = session.time();
        for (index, (told, lost)) in self.told.iter_mut().zip(&samples.lost).enumerate() {
            if let (false, Some((call, status))) = (*told, lost) {
                *told = true;
                let name = session.devices[index].name.clone();
                session
                    .events
                    .add(EventKind::DeviceLost, now, || format!("device `{name}`: {call}: {}", status.meaning()));
            }
        }
        if let Some(display) = &mut self.display {
            display.take(session, self.clock.now());
        }
        samples
    }

    /// Stops the devices and says how it went.
    pub fn finish(mut self) -> LiveSummary {
        let seconds = self.seconds();
        let watchdog = self.watchdog.end();
        let ended = self.haptic.take().map(JoinHandle::join).and_then(Result::ok);
        let mut summary = LiveSummary {
            seconds,
            rate: self.rate,
            footing: Footing::default(),
            took: None,
            ticks: 0,
            missed: 0,
            period: None,
            lateness: None,
            latency: None,
            contact_age: None,
            lost: self.pacer.lost as f64 * 1e-9,
            kept: self.steps as f64 * self.dt / seconds,
            watchdog,
            panicked: true,
            hands: Vec::new(),
            devices: DeviceCounts::new(),
        };
        if let Some(ended) = ended {
            (summary.footing, summary.took) = (ended.footing, ended.took);
            (summary.ticks, summary.missed, summary.panicked) = (ended.ticks, ended.missed, ended.panicked);
            (summary.period, summary.lateness) = (ended.period.spread(), ended.lateness.spread());
            (summary.latency, summary.contact_age) = (ended.latency.spread(), ended.servo.age.spread());
            summary.hands = ended.servo.tools.iter().map(hand).collect();
            let counted = self.names.iter().cloned().zip(ended.servo.counters());
            let counted = counted.filter(|(_, counters)| !counters.is_empty());
            summary.devices = counted.map(|(name, counters)| (name, counters.into_iter().collect())).collect();
        }
        summary
    }
}

fn hand(tool: &super::servo::ServoTool) -> HandSummary {
    let changed = tool.safety.counts().map(|(cause, count)| (cause.name(), count)).collect();
    let (dropped, slowed) = (tool.hand.dropped, tool.hand.slowed);
    HandSummary { tool: tool.name.clone(), changed, dropped, slowed, energy: tool.safety.energy() }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(haptic) = self.haptic.take() {
            // What it gives back is dropped here, on the thread that opened the devices.
            drop(haptic.join());
        }
    }
}
