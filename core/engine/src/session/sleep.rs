//! Sleeping: a body at rest is not stepped until something acts on it, if the scene enables it.

use super::{EventKind, Session};
use pliant_solver::{Constraint, ContactConstraints, StepTime, Vec3};

/// Time for which a body must be slow before it falls asleep, s.
const SLOW_FOR: f64 = 0.1;

/// Sleep state of a body.
#[derive(Clone, Debug, Default)]
struct Rest {
    /// Time for which it has been slow and undisturbed, s.
    slow: f64,
    /// Bounding box of a sleeping body, m; `None` if it is awake.
    asleep: Option<[Vec3; 2]>,
}

/// Which bodies sleep.
pub(super) struct Sleep {
    /// Speed below which a body falls asleep, m/s; 0 for never.
    speed: f64,
    /// State of each body.
    rests: Vec<Rest>,
}

impl Sleep {
    /// All bodies awake.
    pub(super) fn new(speed: f64, bodies: usize) -> Self {
        Self { speed, rests: vec![Rest::default(); bodies] }
    }

    /// Whether a body sleeps.
    pub(super) fn is_asleep(&self, index: usize) -> bool {
        self.rests[index].asleep.is_some()
    }

    /// Speed below which a body falls asleep, m/s; 0 for never.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Adapts to another number of bodies; new ones are awake.
    pub(super) fn resize(&mut self, bodies: usize) {
        self.rests.resize_with(bodies, Rest::default);
    }

    /// Wakes a body.
    pub(super) fn wake(&mut self, index: usize) {
        self.rests[index] = Rest::default();
    }
}

impl Session {
    /// Whether a body sleeps in this step, after tips are placed and fixings prescribed. Wakes it if something acts on it.
    pub(super) fn sleeps(&mut self, index: usize, time: StepTime) -> bool {
        if self.sleep.speed <= 0.0 {
            return false;
        }
        if self.is_disturbed(index, time) {
            self.sleep.wake(index);
        }
        self.sleep.rests[index].asleep.is_some()
    }

    /// Records a step in which the fastest node moved at `fastest` (m/s); a body that has been slow long enough falls asleep.
    pub(super) fn rest(&mut self, index: usize, fastest: f64, StepTime { start: time, dt }: StepTime) {
        let rest = &mut self.sleep.rests[index];
        rest.slow = if fastest < self.sleep.speed { rest.slow + dt } else { 0.0 };
        if self.sleep.speed <= 0.0 || rest.slow < SLOW_FOR || rest.asleep.is_some() {
            return;
        }
        let (body, below) = (&mut self.bodies[index], self.sleep.speed);
        let nodes = &mut body.system.nodes;
        let start = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        let bounds = nodes.x.iter().fold(start, |[low, high], x| [low.inf(x), high.sup(x)]);
        rest.asleep = Some(bounds);
        nodes.v.fill(Vec3::zeros());
        self.integrators[index].forget_history();
        // The neighbour lists of tips are invalidated, because motion is not accumulated while the body sleeps.
        self.sheet_tips[index].invalidate();
        let name = &body.name;
        self.events.add(EventKind::Asleep, time + dt, || format!("body `{name}`: below {below} m/s for {SLOW_FOR} s"));
    }

    /// Whether a tool loads or is near a body, an obstacle moves near it, or one of its fixings moves.
    fn is_disturbed(&self, index: usize, time: StepTime) -> bool {
        let nodes = &self.bodies[index].system.nodes;
        let moves =
            |(p, c): (&Vec3, &Constraint)| !c.is_free() && p.norm_squared() >= self.sleep.speed * self.sleep.speed;
        let pulled = self.scratch.springs.iter().any(|springs| !springs.nodes.is_empty());
        pulled || nodes.prescribed.iter().zip(&nodes.constraint).any(moves) || self.is_near(index, time)
    }

    /// Whether a tip, or an obstacle that moves, could reach a sleeping body in two steps.
    fn is_near(&self, index: usize, time: StepTime) -> bool {
        let Some([low, high]) = self.sleep.rests[index].asleep else { return self.sheet_tips[index].is_active() };
        let edge = self.bodies[index].discretization.edge();
        let near_tip = self.sheet_tips[index].tips.iter().any(|tip| {
            let reach = tip.shape.shape().bounding_radius() + edge + 2.0 * self.clock.dt * tip.velocity.norm();
            (0..3).all(|c| tip.position[c] > low[c] - reach && tip.position[c] < high[c] + reach)
        });
        near_tip || self.obstacle_comes([low, high], edge, time)
    }
}
