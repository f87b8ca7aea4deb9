//! A simulated arm with a hand on it, for loops that are closed: mass and friction of the arm, encoders that count, a hand that
//! is a spring and a damper between the arm and where it wants to be. It moves in the time it is read at, not the clock's.

use pliant_host::{DeviceInfo, EffectorOutput, Pose};
use pliant_live::{HapticDevice, StopDevice};
use pliant_plugin_api::abi::{POSE_VALID, Status};
use pliant_solver::Vec3;
use std::sync::{Arc, Mutex};

/// s, of a step of the arm's own motion
const STEP: f64 = 2e-5;

/// What does not change.
#[derive(Clone)]
pub struct ArmModel {
    /// Rate of the servo loop, Hz.
    pub rate: f64,
    /// kg, arm and hand
    pub mass: f64,
    /// N s/m, of the arm
    pub damping: f64,
    /// Least way that the encoders tell, m.
    pub resolution: f64,
    /// Largest force, N.
    pub peak_force: f64,
    /// Largest force that the arm can render for any time, N.
    pub continuous_force: f64,
    /// Stiffness of the spring between the hand and the arm, N/m.
    pub grip_stiffness: f64,
    /// Damping between the hand and the arm, N s/m.
    pub grip_damping: f64,
    /// m, where the hand wants to be at a time (s)
    pub target: Arc<dyn Fn(f64) -> Vec3 + Send + Sync>,
    /// m, of the next sample alone: a sensor's glitch
    pub glitch: Arc<Mutex<Option<Vec3>>>,
}

/// What a test may look at.
#[derive(Clone, Debug, Default)]
pub struct ArmState {
    /// Position of the tip, m.
    pub position: Vec3,
    /// Velocity of the tip, m/s.
    pub velocity: Vec3,
    /// Force that is rendered, N.
    pub force: Vec3,
    /// Time until which the force holds, ns.
    pub valid_until: u64,
    /// J, the rendered force has given so far
    pub given: f64,
    /// N, every force it was told to render
    pub forces: Vec<Vec3>,
    /// Whether it was stopped.
    pub stopped: bool,
    time: f64,
}

/// A desktop arm of 3.3 N.
pub struct Arm {
    model: ArmModel,
    state: Arc<Mutex<ArmState>>,
}

impl ArmModel {
    /// 45 g on 0.2 N s/m with 0.055 mm counts at 1 kHz (assumptions, but for the counts), led along a path by a soft hand.
    pub fn desktop(target: impl Fn(f64) -> Vec3 + Send + Sync + 'static) -> Self {
        Self {
            rate: 1000.0,
            mass: 0.045,
            damping: 0.2,
            resolution: 5.5e-5,
            peak_force: 3.3,
            continuous_force: 0.88,
            grip_stiffness: 300.0,
            grip_damping: 3.0,
            target: Arc::new(target),
            glitch: Arc::default(),
        }
    }
}

impl Arm {
    /// At rest where the hand wants to be.
    pub fn new(model: ArmModel) -> (Self, Arc<Mutex<ArmState>>) {
        let position = (model.target)(0.0);
        let state = Arc::new(Mutex::new(ArmState { position, ..ArmState::default() }));
        (Self { model, state: Arc::clone(&state) }, state)
    }
}

/// As the border asks, in the place of a lock that could be poisoned.
fn state(of: &Mutex<ArmState>) -> std::sync::MutexGuard<'_, ArmState> {
    of.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

impl ArmState {
    fn go_to(&mut self, model: &ArmModel, time: f64) {
        while self.time < time {
            let h = STEP.min(time - self.time);
            let force = if self.time * 1e9 <= self.valid_until as f64 { self.force } else { Vec3::zeros() };
            let away = (model.target)(self.time) - self.position;
            let (k, d) = (model.grip_stiffness, model.grip_damping + model.damping);
            // Implicit in the damping, so that any damping is borne.
            let pushed = force + k * away;
            let velocity = (self.velocity + h / model.mass * pushed).map(|v| v / (1.0 + h * d / model.mass));
            let before = self.position;
            self.position += h * velocity;
            self.velocity = velocity;
            self.given += force.dot(&(self.position - before));
            self.time += h;
            if time - self.time < 1e-12 {
                self.time = time;
            }
        }
    }
}

impl HapticDevice for Arm {
    fn device_info(&self) -> DeviceInfo {
        DeviceInfo {
            effectors: 1,
            buttons: 1,
            driven_axes: 3,
            rate: self.model.rate,
            peak_force: self.model.peak_force,
            continuous_force: self.model.continuous_force,
            stiffness: 700.0,
            damping: 5.0,
            resolution: self.model.resolution,
            workspace: [-0.1, -0.1, -0.1, 0.1, 0.1, 0.1],
            ..DeviceInfo::default()
        }
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let mut state = state(&self.state);
        state.go_to(&self.model, time as f64 * 1e-9);
        let step = self.model.resolution;
        let counted = if step > 0.0 { state.position.map(|c| (c / step).floor() * step) } else { state.position };
        let glitch = self.model.glitch.lock().ok().and_then(|mut glitch| glitch.take());
        let position = glitch.map_or(counted, |aside| counted + aside);
        poses.fill(Pose { time_ns: time, flags: POSE_VALID, position: position.into(), ..Pose::default() });
        Status::OK
    }

    fn write(&mut self, _: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        let mut state = state(&self.state);
        (state.force, state.valid_until) = (outputs[0].force.into(), outputs[0].valid_until);
        state.forces.push(outputs[0].force.into());
        Status::OK
    }

    fn stop_handle(&self) -> StopDevice {
        let of_arm = Arc::clone(&self.state);
        Box::new(move || {
            let mut state = state(&of_arm);
            (state.force, state.stopped) = (Vec3::zeros(), true);
        })
    }
}
