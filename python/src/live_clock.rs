//! Steps by the clock, with hands that Python sends somewhere.
//!
//! A hand glides from place to place: between two targets every step has its own. When the simulation is slower than the clock, time is
//! given up rather than caught up with.

use super::live::{PUBLISH_PERIOD, Publisher, Shared, UsedPose, lock};
use pliant_engine::session::{HandPose, Session};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// The most wall-clock time that is caught up with; what is older is given up.
const MAX_BACKLOG: Duration = Duration::from_millis(50);

/// Steps the session by the clock, on the thread of a [`super::live::LiveThread`], with the hands of [`Shared`].
pub(super) struct ClockPlayer<'a> {
    session: &'a mut Session,
    shared: &'a Shared,
    publisher: Publisher<'a>,
    /// Where hands are, by tool.
    hands: BTreeMap<usize, HandPose>,
    lost: Duration,
}

impl<'a> ClockPlayer<'a> {
    pub(super) fn new(session: &'a mut Session, shared: &'a Shared) -> Self {
        let publisher = Publisher::new(shared);
        Self { session, shared, publisher, hands: BTreeMap::new(), lost: Duration::ZERO }
    }

    /// Steps until it is asked to end.
    pub(super) fn play(&mut self) {
        let dt = Duration::from_secs_f64(self.session.dt());
        let mut simulated = Instant::now();
        while !self.shared.is_stopped() {
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
            if count > 0 && self.publisher.is_due() {
                self.publish();
            }
            let wait = (simulated + dt).saturating_duration_since(Instant::now());
            std::thread::sleep(wait.min(PUBLISH_PERIOD));
        }
        self.publish();
    }

    fn publish(&mut self) {
        self.publisher.publish(self.session, self.lost.as_secs_f64(), None);
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
                        let time = self.session.time() + self.session.dt();
                        lock(&self.shared.used).push(UsedPose { time, tool, pose });
                    }
                    None => drop(self.hands.remove(&tool)),
                }
            }
            self.session.step();
        }
    }
}

/// The pose at a share of the way; buttons are those of the target at once.
fn glide(start: &HandPose, target: &HandPose, share: f64) -> HandPose {
    let rotation = start.rotation.try_slerp(&target.rotation, share, 1e-9).unwrap_or(target.rotation);
    HandPose { position: start.position.lerp(&target.position, share), rotation, buttons: target.buttons }
}
