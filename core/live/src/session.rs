//! A live session and its threads.

use crate::deadline::Pacer;
use crate::device::HapticDevice;
use crate::guided::Rescaling;
use crate::handover::Handover;
use crate::haptic_thread::{Clock, HapticResult, ThreadSignals, start};
use crate::realtime::RealtimeStatus;
use crate::servo::Servo;
use crate::servo_session::{ServoSession, ServoTool};
use crate::snapshots::{DeviceLoss, HandSamples, SimulationPort};
use crate::summary::{DeviceCounts, HandSummary, LiveSummary};
use crate::view::ViewWriter;
use crate::watchdog::Watchdog;
use pliant_engine::session::{EventKind, Session, TouchingProxy};
use pliant_engine::tool::Frame;
use pliant_host::DeviceInfo;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{JoinHandle, sleep};
use std::time::Duration;

/// Options of a live session.
#[derive(Default)]
pub struct LiveSettings {
    /// Rate of the haptic loop, Hz; by default that of the fastest device, up to 4 kHz.
    pub rate: Option<f64>,
    /// Receives frames of the session; `None` without a viewer.
    pub view: Option<ViewWriter>,
}

/// Timing of a running session.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LiveGauges {
    /// Wall-clock time since the start, s.
    pub seconds: f64,
    /// Number of steps the simulation has taken.
    pub steps: u64,
    /// Simulated time that was skipped because the simulation was too slow, s.
    pub lost_time: f64,
    /// Number of ticks of the haptic thread.
    pub ticks: u64,
    /// Number of missed deadlines: ticks not finished before the next one was due.
    pub missed: u64,
    /// Largest lateness of a tick's beginning since the last call, s.
    pub worst_lateness: f64,
}

/// Largest waiting time for the first tick, ns.
const FIRST_TICK_TIMEOUT: u64 = 500_000_000;

/// Time between two looks at whether the haptic thread has taken a session.
const HANDOVER_POLL: Duration = Duration::from_micros(100);

/// A session in real time. The simulation runs on the caller's thread. Dropping it stops the devices and ends the other threads, also during a panic.
pub struct LiveSession {
    clock: Clock,
    signals: Arc<ThreadSignals>,
    haptic: Option<JoinHandle<HapticResult>>,
    watchdog: Watchdog,
    port: SimulationPort,
    view: Option<ViewWriter>,
    pacer: Pacer,
    rate: f64,
    /// Time of the first step, ns.
    began: u64,
    steps: u64,
    dt: f64,
    /// Whether the loss of each device has been reported.
    reported: Vec<bool>,
    /// Names of the devices in their order.
    names: Vec<String>,
    /// Limits of the devices in their order.
    infos: Vec<DeviceInfo>,
    /// Frames of the devices in their order.
    frames: Vec<Frame>,
    handover: Arc<Handover>,
}

impl LiveSession {
    /// Starts a session in real time with its own devices, which move to the haptic thread.
    ///
    /// # Errors
    /// Returns an error if a device is not open or the system cannot create threads.
    pub fn start(session: &mut Session, settings: LiveSettings) -> io::Result<Self> {
        let missing = |index: usize| io::Error::other(format!("device {index} is not open"));
        let taken = session.take_devices().into_iter().enumerate();
        let devices =
            taken.map(|(i, device)| device.map(|d| Box::new(d) as Box<dyn HapticDevice>).ok_or_else(|| missing(i)));
        let devices = devices.collect::<io::Result<Vec<_>>>()?;
        Self::start_with_devices(session, devices, settings)
    }

    /// Starts a session in real time with other devices, in the order of the session's.
    ///
    /// # Errors
    /// Returns the error of the system if it cannot create threads.
    pub fn start_with_devices(
        session: &mut Session,
        devices: Vec<Box<dyn HapticDevice>>,
        settings: LiveSettings,
    ) -> io::Result<Self> {
        session.drive_tips();
        let reported = vec![false; devices.len()];
        let names = session.devices.iter().map(|slot| slot.name.clone()).collect();
        let infos = devices.iter().map(|device| device.device_info()).collect();
        let (servo, port) = Servo::new(session, devices, settings.rate);
        let (view, handover) = (settings.view, Arc::clone(&servo.handover));
        let (rate, signals, clock) = (servo.rate(), Arc::new(ThreadSignals::default()), Clock::start());
        let watchdog = Watchdog::start(servo.stop_handles(), Arc::clone(&signals))?;
        let haptic = Some(start(servo, clock, Arc::clone(&signals))?);
        // Waits for the first tick, so that the first step has poses. From here on no thread waits for another.
        while signals.ticks_begun.load(Ordering::Relaxed) < 2 && clock.now() < FIRST_TICK_TIMEOUT {
            sleep(Duration::from_millis(1));
        }
        let (began, dt) = (clock.now(), session.dt());
        let pacer = Pacer::new(began, dt);
        Ok(Self {
            clock,
            signals,
            haptic,
            watchdog,
            port,
            view,
            pacer,
            rate,
            began,
            steps: 0,
            dt,
            reported,
            names,
            infos,
            frames: frames_of(session),
            handover,
        })
    }

    /// Goes on with another session, whose devices are those of this one: they stay open, the haptic thread never stops, and forces go on from the last
    /// ones within their limits. Tools begin where proxies of the same name touch. `rescalings` has a new scale for each device that gets one. Steps and
    /// times begin anew; ticks go on.
    ///
    /// # Errors
    /// Gives the live session back where the devices cannot be those of the other session: it has another number of them or other frames, or the haptic
    /// thread has ended.
    pub fn hand_over(
        mut self,
        next: &mut Session,
        touching: &[TouchingProxy],
        rescalings: &[Option<Rescaling>],
        view: Option<ViewWriter>,
    ) -> Result<Self, Box<Self>> {
        if frames_of(next) != self.frames || !self.is_alive() {
            return Err(Box::new(self));
        }
        next.drive_tips();
        next.resume_touching(touching);
        let (servo, port) = ServoSession::rescaled(next, &self.infos, rescalings);
        for (info, rescaling) in self.infos.iter_mut().zip(rescalings) {
            *info = rescaling.map_or(*info, |rescaling| rescaling.info);
        }
        self.handover.offer(Box::new(servo));
        while self.handover.is_offered() && self.is_alive() {
            sleep(HANDOVER_POLL);
        }
        drop(self.handover.clear());
        // The tick after the one that took it has poses.
        let (ticks, limit) = (self.signals.ticks_begun.load(Ordering::Relaxed), self.clock.now() + FIRST_TICK_TIMEOUT);
        while self.signals.ticks_begun.load(Ordering::Relaxed) < ticks + 2 && self.clock.now() < limit {
            sleep(HANDOVER_POLL);
        }
        self.names = next.devices.iter().map(|slot| slot.name.clone()).collect();
        (self.port, self.view, self.steps, self.dt) = (port, view, 0, next.dt());
        self.began = self.clock.now();
        self.pacer = Pacer::new(self.began, self.dt);
        Ok(self)
    }

    /// Wall-clock time since the start, s.
    pub fn seconds(&self) -> f64 {
        (self.clock.now() - self.began) as f64 * 1e-9
    }

    /// Timing so far.
    pub fn gauges(&self) -> LiveGauges {
        LiveGauges {
            seconds: self.seconds(),
            steps: self.steps,
            lost_time: self.pacer.lost as f64 * 1e-9,
            ticks: self.signals.ticks_begun.load(Ordering::Relaxed),
            missed: self.signals.missed.load(Ordering::Relaxed),
            worst_lateness: self.signals.worst_lateness.swap(0, Ordering::Relaxed) as f64 * 1e-9,
        }
    }

    /// Whether the haptic thread still runs.
    pub fn is_alive(&self) -> bool {
        self.haptic.as_ref().is_some_and(|haptic| !haptic.is_finished())
    }

    /// Waits until a step is due and takes it with the newest poses. Returns the snapshot of those poses.
    pub fn step(&mut self, session: &mut Session) -> &HandSamples {
        self.step_after(session, |_| {})
    }

    /// As [`LiveSession::step`], and calls `prepare` between reading the poses and the step: what a program asks for before it has a hand press a button is then done before the
    /// step with that button.
    pub fn step_after(&mut self, session: &mut Session, prepare: impl FnOnce(&mut Session)) -> &HandSamples {
        while let Some(wait) = self.pacer.poll(self.clock.now()) {
            sleep(Duration::from_nanos(wait));
        }
        self.steps += 1;
        let samples = self.port.step(session, prepare);
        let now = session.time();
        for (index, (reported, loss)) in self.reported.iter_mut().zip(&samples.losses).enumerate() {
            if let (false, Some(DeviceLoss { call, status })) = (*reported, loss) {
                *reported = true;
                let name = session.devices[index].name.clone();
                session
                    .events
                    .add(EventKind::DeviceLost, now, || format!("device `{name}`: {call}: {}", status.meaning()));
            }
        }
        if let Some(view) = &mut self.view {
            view.publish_if_due(session, self.clock.now());
        }
        samples
    }

    /// Stops the devices, ends the threads and summarises the session.
    pub fn finish(mut self) -> LiveSummary {
        let seconds = self.seconds();
        let watchdog_trips = self.watchdog.end();
        let ended = self.haptic.take().map(JoinHandle::join).and_then(Result::ok);
        let mut summary = LiveSummary {
            seconds,
            rate: self.rate,
            realtime: RealtimeStatus::default(),
            thread_usage: None,
            ticks: 0,
            missed: 0,
            period: None,
            lateness: None,
            latency: None,
            contact_age: None,
            lost_time: self.pacer.lost as f64 * 1e-9,
            real_time_factor: self.steps as f64 * self.dt / seconds,
            watchdog_trips,
            panicked: true,
            hands: Vec::new(),
            devices: DeviceCounts::new(),
        };
        if let Some(ended) = ended {
            (summary.realtime, summary.thread_usage) = (ended.realtime, ended.usage);
            (summary.ticks, summary.missed, summary.panicked) = (ended.ticks, ended.missed, ended.panicked);
            (summary.period, summary.lateness) = (ended.period.percentiles(), ended.lateness.percentiles());
            (summary.latency, summary.contact_age) =
                (ended.latency.percentiles(), ended.servo.contact_age.percentiles());
            summary.hands = ended.servo.session.tools.iter().map(summarize_hand).collect();
            let counters = self.names.iter().cloned().zip(ended.servo.counters());
            let counters = counters.filter(|(_, counters)| !counters.is_empty());
            summary.devices = counters.map(|(name, counters)| (name, counters.into_iter().collect())).collect();
        }
        summary
    }
}

fn frames_of(session: &Session) -> Vec<Frame> {
    session.devices.iter().map(|slot| slot.frame).collect()
}

/// Force safety and samples of one tool's hand.
fn summarize_hand(tool: &ServoTool) -> HandSummary {
    HandSummary {
        tool: tool.name.clone(),
        safety_counts: tool.safety.counts().map(|(cause, count)| (cause.name(), count)).collect(),
        dropped_samples: tool.hand.dropped,
        speed_limited_samples: tool.hand.slowed,
        energy: tool.safety.energy(),
    }
}

impl Drop for LiveSession {
    fn drop(&mut self) {
        self.signals.stop.store(true, Ordering::Relaxed);
        if let Some(haptic) = self.haptic.take() {
            // The servo and its devices are dropped here, on the thread that opened them.
            drop(haptic.join());
        }
    }
}
