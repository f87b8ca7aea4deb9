//! A session that goes on by the clock on a thread of its own, while Python does other things.
//!
//! Hands go in and the newest positions come out; nothing of Python is needed in between, so a user interface that draws sixty frames a
//! second neither waits for steps nor makes them wait. Either the clock paces the steps and all hands are Python's (`live_clock`), or a haptic device
//! has one of them (`live_device`).

use super::failure::{Failure, Kind, contained};
use super::live_clock::ClockPlayer;
use super::live_device::{KeptDevice, Lead, LedHand, play_with_device};
use super::model::Found;
use super::open_session::Open;
use super::painting::Painting;
use pliant_editor::DeviceWish;
use pliant_engine::session::{EventKind, HandPose, Session, ToolFrame};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two copies of positions for a viewer: a frame at 60 Hz, halved so that one is never a whole frame old.
pub(super) const PUBLISH_PERIOD: Duration = Duration::from_millis(8);

/// What a viewer is shown.
#[derive(Clone, Default)]
pub struct View {
    /// Counts views; 0 before the first.
    pub number: u64,
    /// Simulated time of the view, s.
    pub time: f64,
    /// s, simulated time that was given up
    pub lost_time: f64,
    /// m (n x 3) of each body that moves
    pub positions: Vec<Vec<[f32; 3]>>,
    /// Number of visible triangles of each body, without lids over holes and failed ones. Another number says that the body was cut or broke.
    pub triangles: Vec<usize>,
    /// What strokes have pinned and painted on each body.
    pub paintings: Vec<Arc<Painting>>,
    /// At the end of the last step.
    pub tools: Vec<ToolFrame>,
    /// The hand that a device has, or had until it was lost.
    pub hand: Option<LedHand>,
}

/// A pose of a hand in one step, as it was used.
#[derive(Clone, Copy, Debug)]
pub struct UsedPose {
    /// s, the end of the step
    pub time: f64,
    /// Index of the tool.
    pub tool: usize,
    /// Where it was.
    pub pose: HandPose,
}

/// State that the thread of the session and the caller share.
#[derive(Default)]
pub(super) struct Shared {
    /// Index of the tool whose hand a device has, with the plugin of the device; `None` if all hands are Python's.
    led: Option<(usize, String)>,
    /// Where hands are to go, by tool; `None`: away.
    pub(super) targets: Mutex<BTreeMap<usize, Option<HandPose>>>,
    /// What is asked of the device that has a hand.
    pub(super) wish: Mutex<Option<DeviceWish>>,
    /// Poses that steps have used and nobody has taken.
    pub(super) used: Mutex<Vec<UsedPose>>,
    view: Mutex<View>,
    pub(super) stop: AtomicBool,
    /// Whether the device that has a hand stays open when the thread ends.
    pub(super) keeps_device: AtomicBool,
    /// Told when a view is there or the thread ends.
    news: Condvar,
}

impl Shared {
    /// Whether the thread is asked to end.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// What the thread leaves.
pub struct Ended {
    /// The session that is played.
    pub open: Open,
    /// Why it ended by itself, if it did.
    pub done: Result<(), Failure>,
    /// The device that had a hand, if it is kept.
    pub device: Option<KeptDevice>,
}

/// A session under way; dropping it ends the thread.
pub struct LiveThread {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Ended>>,
    /// The process that started it: a fork of it has no such thread.
    process: u32,
}

impl LiveThread {
    /// Starts a session, whose hand a device has with `lead`.
    pub fn start(open: Open, lead: Option<Lead>) -> Result<Self, (Box<Open>, Failure)> {
        let shared = Arc::new(Shared {
            led: lead.as_ref().map(|lead| (lead.tool, lead.name.clone())),
            wish: Mutex::new(lead.as_ref().map(|lead| lead.wish)),
            ..Shared::default()
        });
        let theirs = Arc::clone(&shared);
        // Handed over through a cell, so that it comes back if there is no thread.
        let cell = Arc::new(Mutex::new(Some(open)));
        let taken = Arc::clone(&cell);
        let started = std::thread::Builder::new().name("pliant-live".into()).spawn(move || {
            let mut open = lock(&taken).take().expect("it was put there before the thread began");
            let session = &mut open.opened.session;
            let done = contained(|| match lead {
                Some(lead) => play_with_device(session, lead, &theirs),
                None => {
                    ClockPlayer::new(session, &theirs).play();
                    Ok(None)
                }
            });
            theirs.stop.store(true, Ordering::Relaxed);
            theirs.news.notify_all();
            match done {
                Ok(device) => Ended { open, done: Ok(()), device },
                Err(failure) => Ended { open, done: Err(failure), device: None },
            }
        });
        match started {
            Ok(thread) => Ok(Self { shared, thread: Some(thread), process: std::process::id() }),
            Err(error) => {
                let open = lock(&cell).take().expect("there is no thread that took it");
                Err((Box::new(open), Failure::new(Kind::File, format!("the system gives no thread: {error}"))))
            }
        }
    }

    /// Sends the hand of a tool somewhere, or away.
    ///
    /// # Errors
    /// A device has the hand.
    pub fn go(&self, tool: usize, pose: Option<HandPose>) -> Result<(), Failure> {
        // A device has its hand before the first view says so.
        let is_lost = || lock(&self.shared.view).hand.as_ref().is_some_and(|hand| hand.lost.is_some());
        if let Some((_, device)) = self.shared.led.as_ref().filter(|(led, _)| *led == tool && !is_lost()) {
            let text = format!(
                "device `{device}` has this hand; allowed is to move it once the device is lost or the session stopped"
            );
            return Err(Failure::new(Kind::Busy, text));
        }
        lock(&self.shared.targets).insert(tool, pose);
        Ok(())
    }

    /// Changes what is asked of the device that has a hand.
    pub fn guide(&self, change: impl FnOnce(&mut DeviceWish)) {
        if let Some(wish) = lock(&self.shared.wish).as_mut() {
            change(wish);
        }
    }

    /// Takes the poses that steps have used since the last call.
    pub fn take_poses(&self) -> Vec<UsedPose> {
        std::mem::take(&mut lock(&self.shared.used))
    }

    /// The newest view, waited for up to `patience` if it is not newer than the one of number `seen`.
    pub fn with_view<R>(&self, seen: u64, patience: Duration, read: impl FnOnce(&View) -> R) -> R {
        let view = lock(&self.shared.view);
        let is_old = |view: &mut View| view.number <= seen && !self.shared.is_stopped();
        let (view, _) =
            self.shared.news.wait_timeout_while(view, patience, is_old).unwrap_or_else(PoisonError::into_inner);
        read(&view)
    }

    /// Whether the thread still goes on: it ends by itself after a fault.
    pub fn is_alive(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// Has a device that has a hand stay open when the thread is ended by [`LiveThread::stop`].
    pub fn keep_device(&self) {
        self.shared.keeps_device.store(true, Ordering::Relaxed);
    }

    /// Ends the thread and gives the session back, with the poses of its hands that nobody has taken.
    pub fn stop(mut self) -> Result<(Ended, Vec<UsedPose>), Failure> {
        if self.process != std::process::id() {
            let text = format!(
                "the session goes on in process {}; allowed is to stop it there, not in a fork of it",
                self.process
            );
            return Err(Failure::new(Kind::Closed, text));
        }
        self.shared.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("ended here only");
        let ended = thread.join();
        let ended = ended.map_err(|_| Failure::new(Kind::Panic, "the thread of the session ended with a fault"))?;
        Ok((ended, self.take_poses()))
    }
}

impl Drop for LiveThread {
    fn drop(&mut self) {
        if self.process != std::process::id() {
            // After a fork the thread is the parent's: waiting for it here would not end.
            std::mem::forget(self.thread.take());
            return;
        }
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// Shows viewers what the thread has.
pub(super) struct Publisher<'a> {
    shared: &'a Shared,
    number: u64,
    last: Option<Instant>,
    /// Number of visible triangles of each body, and the changes of surfaces that were counted with it.
    triangles: Vec<usize>,
    counted: Option<[u64; 4]>,
    /// What strokes have pinned and painted on each body, and the changes of it that were counted then.
    paintings: Vec<(Option<u64>, Arc<Painting>)>,
}

impl<'a> Publisher<'a> {
    /// Of a thread that has shown nothing yet.
    pub(super) fn new(shared: &'a Shared) -> Self {
        Self { shared, number: 0, last: None, triangles: Vec::new(), counted: None, paintings: Vec::new() }
    }

    /// Whether it is time for another view.
    pub(super) fn is_due(&self) -> bool {
        self.last.is_none_or(|at| at.elapsed() >= PUBLISH_PERIOD)
    }

    /// Counts visible triangles, where a cut, a stitch, a failure or the history has changed surfaces since the last count.
    fn count_triangles(&mut self, session: &Session) {
        let all: usize = session.bodies.iter().map(|body| body.model.surface.triangles.len()).sum();
        let events = [EventKind::ElementsFailed, EventKind::History].map(|kind| session.events.count(kind));
        let changes = [all as u64, session.cuts().advances as u64, events[0], events[1]];
        if self.counted.replace(changes) == Some(changes) {
            return;
        }
        self.triangles.clear();
        let bodies = session.bodies.iter().enumerate();
        self.triangles.extend(bodies.map(|(index, body)| Found::Moving(index, body).triangles().count()));
    }

    /// Lists pins and paint of the bodies where they have changed since the last list. A body whose grid fails keeps the list before.
    fn list_paintings(&mut self, session: &Session) {
        if self.paintings.len() != session.bodies.len() {
            // A split, or its undo: others have the numbers.
            self.paintings.clear();
            self.paintings.resize_with(session.bodies.len(), || (None, Arc::default()));
        }
        for (body, (changes, painting)) in session.bodies.iter().zip(&mut self.paintings) {
            let now = Some(body.paint_changes());
            if std::mem::replace(changes, now) == now {
                continue;
            }
            if let Ok(new) = Painting::of(body) {
                *painting = Arc::new(new);
            }
        }
    }

    /// Shows the session as it is, with the simulated time that was given up (s) and the hand that a device has.
    pub(super) fn publish(&mut self, session: &mut Session, lost_time: f64, hand: Option<LedHand>) {
        session.update_surface();
        self.count_triangles(session);
        self.list_paintings(session);
        self.number += 1;
        let mut view = lock(&self.shared.view);
        (view.number, view.time, view.lost_time) = (self.number, session.time(), lost_time);
        view.tools.clone_from(&session.frame().tools);
        view.hand = hand;
        let bodies = &session.bodies;
        view.triangles.clone_from(&self.triangles);
        view.paintings.clear();
        view.paintings.extend(self.paintings.iter().map(|(_, painting)| Arc::clone(painting)));
        view.positions.resize_with(bodies.len(), Vec::new);
        for (to, body) in view.positions.iter_mut().zip(bodies) {
            to.clear();
            to.extend(body.skin.x.iter().map(|x| [x.x as f32, x.y as f32, x.z as f32]));
        }
        drop(view);
        self.shared.news.notify_all();
        self.last = Some(Instant::now());
    }
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
