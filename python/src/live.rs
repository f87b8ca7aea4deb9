//! A session that goes on by the clock on a thread of its own, while Python does other things.
//!
//! Hands go in and the newest positions come out; nothing of Python is needed in between, so a user interface that draws sixty frames a
//! second neither waits for steps nor makes them wait. A hand glides from place to place: between two targets every step has
//! its own. When the simulation is slower than the clock, time is given up rather than caught up with.

use super::failure::{Failure, Kind, contained};
use super::open_session::Open;
use pliant_engine::session::{HandPose, Session, ToolFrame};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two copies of positions for a viewer: a frame at 60 Hz, halved so that one is never a whole frame old.
const PUBLISH_PERIOD: Duration = Duration::from_millis(8);
/// The most wall-clock time that is caught up with; what is older is given up.
const MAX_BACKLOG: Duration = Duration::from_millis(50);

/// What a viewer is shown.
#[derive(Clone, Default)]
pub struct View {
    /// Counts views; 0 before the first.
    pub number: u64,
    /// s, simulated
    pub time: f64,
    /// s, simulated time that was given up
    pub lost_time: f64,
    /// m (n x 3) of each body that moves
    pub positions: Vec<Vec<[f32; 3]>>,
    /// Triangles of each body; another number says that it was cut.
    pub triangles: Vec<usize>,
    /// At the end of the last step.
    pub tools: Vec<ToolFrame>,
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

/// Both ends' state.
#[derive(Default)]
struct Shared {
    /// Where hands are to go, by tool; `None`: away.
    targets: Mutex<BTreeMap<usize, Option<HandPose>>>,
    view: Mutex<View>,
    stop: AtomicBool,
    /// Told when a view is there or the thread ends.
    news: Condvar,
}

/// What the thread leaves.
pub struct Ended {
    /// The session that is played.
    pub open: Open,
    /// Poses its hands had, step by step.
    pub used: Vec<UsedPose>,
    /// Why it ended by itself, if it did.
    pub done: Result<(), Failure>,
}

/// A session under way; dropping it ends the thread.
pub struct LiveThread {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Ended>>,
}

impl LiveThread {
    /// Starts a session.
    pub fn start(open: Open) -> Result<Self, (Box<Open>, Failure)> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        // Handed over through a cell, so that it comes back if there is no thread.
        let cell = Arc::new(Mutex::new(Some(open)));
        let taken = Arc::clone(&cell);
        let started = std::thread::Builder::new().name("pliant-live".into()).spawn(move || {
            let mut open = lock(&taken).take().expect("it was put there before the thread began");
            let mut used = Vec::new();
            let done = contained(|| {
                Player::new(&mut open.opened.session, &theirs, &mut used).play();
                Ok(())
            });
            theirs.stop.store(true, Ordering::Relaxed);
            theirs.news.notify_all();
            Ended { open, used, done }
        });
        match started {
            Ok(thread) => Ok(Self { shared, thread: Some(thread) }),
            Err(error) => {
                let open = lock(&cell).take().expect("there is no thread that took it");
                Err((Box::new(open), Failure::new(Kind::File, format!("the system gives no thread: {error}"))))
            }
        }
    }

    /// Sends the hand of a tool somewhere, or away.
    pub fn go(&self, tool: usize, pose: Option<HandPose>) {
        lock(&self.shared.targets).insert(tool, pose);
    }

    /// The newest view, waited for up to `patience` if it is not newer than the one of number `seen`.
    pub fn with_view<R>(&self, seen: u64, patience: Duration, read: impl FnOnce(&View) -> R) -> R {
        let view = lock(&self.shared.view);
        let is_old = |view: &mut View| view.number <= seen && !self.shared.stop.load(Ordering::Relaxed);
        let (view, _) =
            self.shared.news.wait_timeout_while(view, patience, is_old).unwrap_or_else(PoisonError::into_inner);
        read(&view)
    }

    /// Whether the thread still goes on: it ends by itself after a fault.
    pub fn is_alive(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// Ends the thread and gives the session back, with the poses its hands had.
    pub fn stop(mut self) -> Result<Ended, Failure> {
        self.shared.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("ended here only");
        thread.join().map_err(|_| Failure::new(Kind::Panic, "the thread of the session ended with a fault"))
    }
}

impl Drop for LiveThread {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// The thread's side.
struct Player<'a> {
    session: &'a mut Session,
    shared: &'a Shared,
    used: &'a mut Vec<UsedPose>,
    /// Where hands are, by tool.
    hands: BTreeMap<usize, HandPose>,
    number: u64,
    lost: Duration,
}

impl<'a> Player<'a> {
    fn new(session: &'a mut Session, shared: &'a Shared, used: &'a mut Vec<UsedPose>) -> Self {
        Self { session, shared, used, hands: BTreeMap::new(), number: 0, lost: Duration::ZERO }
    }

    fn play(&mut self) {
        let dt = Duration::from_secs_f64(self.session.dt());
        let mut simulated = Instant::now();
        let mut published = None;
        while !self.shared.stop.load(Ordering::Relaxed) {
            let now = Instant::now();
            if let Some(over) = now.checked_duration_since(simulated + MAX_BACKLOG) {
                self.lost += over;
                simulated += over;
            }
            let behind = now.saturating_duration_since(simulated);
            let count =
                (behind.as_nanos() / dt.as_nanos().max(1)).min(PUBLISH_PERIOD.as_nanos() / dt.as_nanos().max(1) + 1);
            if count > 0 {
                self.step(count as u32);
                simulated += dt * count as u32;
            }
            if count > 0 && published.is_none_or(|at: Instant| at.elapsed() >= PUBLISH_PERIOD) {
                self.publish();
                published = Some(Instant::now());
            }
            let wait = (simulated + dt).saturating_duration_since(Instant::now());
            std::thread::sleep(wait.min(PUBLISH_PERIOD));
        }
        self.publish();
    }

    /// Takes `count` steps, in which hands glide to their targets.
    fn step(&mut self, count: u32) {
        let targets = lock(&self.shared.targets).clone();
        let starts = self.hands.clone();
        for step in 1..=count {
            for (&tool, target) in &targets {
                let pose = target.map(|target| match starts.get(&tool) {
                    Some(start) => glide(start, &target, f64::from(step) / f64::from(count)),
                    None => target,
                });
                self.session.place_hand(tool, pose);
                match pose {
                    Some(pose) => {
                        self.hands.insert(tool, pose);
                        self.used.push(UsedPose { time: self.session.time() + self.session.dt(), tool, pose });
                    }
                    None => drop(self.hands.remove(&tool)),
                }
            }
            self.session.step();
        }
    }

    fn publish(&mut self) {
        self.session.update_surface();
        self.number += 1;
        let mut view = lock(&self.shared.view);
        (view.number, view.time, view.lost_time) = (self.number, self.session.time(), self.lost.as_secs_f64());
        view.tools.clone_from(&self.session.frame().tools);
        let bodies = &self.session.bodies;
        view.triangles.clear();
        view.triangles.extend(bodies.iter().map(|body| body.model.surface.triangles.len()));
        view.positions.resize_with(bodies.len(), Vec::new);
        for (to, body) in view.positions.iter_mut().zip(bodies) {
            to.clear();
            to.extend(body.skin.x.iter().map(|x| [x.x as f32, x.y as f32, x.z as f32]));
        }
        drop(view);
        self.shared.news.notify_all();
    }
}

/// The pose at a share of the way; buttons are those of the target at once.
fn glide(start: &HandPose, target: &HandPose, share: f64) -> HandPose {
    let rotation = start.rotation.try_slerp(&target.rotation, share, 1e-9).unwrap_or(target.rotation);
    HandPose { position: start.position.lerp(&target.position, share), rotation, buttons: target.buttons }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
