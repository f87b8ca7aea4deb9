//! Hands and a session in a time of their own: the haptic tick and the step, taken in turn, so that what a test sees does not
//! depend on the machine.

use crate::arm::{Arm, ArmModel, ArmState};
use pliant_engine::session::Session;
use pliant_live::{HapticDevice, Rescaling, Servo, SimulationPort};
use pliant_solver::Vec3;
use std::sync::{Arc, Mutex};

/// A session with arms in the place of its devices.
pub struct Bout {
    /// Session whose hands are the arms.
    pub session: Session,
    /// The haptic side.
    pub servo: Servo,
    /// The simulation's side.
    pub port: SimulationPort,
    /// In the order of the session's devices.
    pub arms: Vec<Arc<Mutex<ArmState>>>,
    tick: u64,
}

impl Bout {
    /// Takes the devices of a session out and puts arms in.
    pub fn new(session: Session, models: Vec<ArmModel>) -> Self {
        let (arms, states): (Vec<Arm>, _) = models.into_iter().map(Arm::new).unzip();
        let devices = arms.into_iter().map(|arm| Box::new(arm) as Box<dyn HapticDevice>);
        Self::with_devices(session, devices.collect(), states)
    }

    /// Takes the devices of a session out and puts these in, which move these arms.
    pub fn with_devices(
        mut session: Session,
        devices: Vec<Box<dyn HapticDevice>>,
        arms: Vec<Arc<Mutex<ArmState>>>,
    ) -> Self {
        drop(session.take_devices());
        session.drive_tips();
        let (servo, port) = Servo::new(&session, devices, None);
        Self { session, servo, port, arms, tick: 0 }
    }

    /// Time since the servo began, s.
    pub fn time(&self) -> f64 {
        self.tick as f64 / self.servo.rate()
    }

    /// `ticks` of the haptic side, with a step in every `every`-th; none where that is 0.
    pub fn run(&mut self, ticks: u64, every: u64) {
        for _ in 0..ticks {
            self.tick += 1;
            self.servo.tick((self.time() * 1e9).round() as u64);
            if every > 0 && self.tick.is_multiple_of(every) {
                self.port.step(&mut self.session, |_| {});
            }
        }
    }

    /// Goes on with another session: the devices stay, and tools begin where they touch.
    pub fn hand_over(&mut self, mut next: Session, rescalings: &[Option<Rescaling>]) {
        next.drive_tips();
        next.resume_touching(&self.session.touching_proxies());
        self.port = self.servo.hand_over(&next, rescalings);
        self.session = next;
    }

    /// `ticks` in which nobody does anything.
    pub fn skip(&mut self, ticks: u64) {
        self.tick += ticks;
    }

    /// A copy of what an arm is at.
    ///
    /// # Panics
    /// If a thread that had it panicked.
    pub fn arm(&self, index: usize) -> ArmState {
        self.arms[index].lock().expect("nobody panicked").clone()
    }

    /// Looks at every force an arm was told: finite, within the peak and the slew of a tick.
    ///
    /// # Panics
    /// If one is not.
    pub fn forces_are_safe(&self, index: usize, slew: f64) {
        let (forces, mut last) = (self.arm(index).forces, Vec3::zeros());
        assert!(forces.len() > 100, "{} forces", forces.len());
        for (tick, force) in forces.into_iter().enumerate() {
            let jump = (force - last).norm();
            assert!(force.norm() <= 3.3 + 1e-9, "tick {tick}: {force:?} N");
            // To zero, one may let go at once.
            assert!(
                jump <= slew / self.servo.rate() + 1e-9 || force == Vec3::zeros(),
                "tick {tick}: {last:?} to {force:?} N"
            );
            last = force;
        }
    }
}
