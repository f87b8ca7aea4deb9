//! Sleeping: a body at rest is not stepped until something acts on it, if the scene enables it.

use super::{EventKind, Session, StiffnessState};
use crate::body::Body;
use pliant_solver::{Constraint, ContactConstraints, Nodes, StepTime, Vec3};

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

    /// Records a step of `dt` (s) in which the fastest node of a body moved at `fastest` (m/s). Returns whether the body falls asleep: it has been slow long
    /// enough. Its nodes are then stopped.
    pub(super) fn rest(&mut self, index: usize, nodes: &mut Nodes, fastest: f64, dt: f64) -> bool {
        let rest = &mut self.rests[index];
        rest.slow = if fastest < self.speed { rest.slow + dt } else { 0.0 };
        if self.speed <= 0.0 || rest.slow < SLOW_FOR || rest.asleep.is_some() {
            return false;
        }
        let start = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        rest.asleep = Some(nodes.x.iter().fold(start, |[low, high], x| [low.inf(x), high.sup(x)]));
        nodes.v.fill(Vec3::zeros());
        true
    }

    /// Whether a node is prescribed to move so fast that its body does not sleep.
    fn is_moved(&self, nodes: &Nodes) -> bool {
        let moves = |(p, c): (&Vec3, &Constraint)| !c.is_free() && p.norm_squared() >= self.speed * self.speed;
        nodes.prescribed.iter().zip(&nodes.constraint).any(moves)
    }
}

impl Session {
    /// Whether nothing moves and nothing is on its way to: each body that is simulated as a whole sleeps, which the scene must enable, and local regions
    /// are left, or sleep where something is pinned or painted; no edit is under way, and the stiffness is the one that was asked for. A body in quarantine is at rest.
    pub fn is_at_rest(&self) -> bool {
        let StiffnessState { now, wanted, .. } = self.motion.stiffness;
        // A local region that sleeps is still to be left, by which its surface moves by rounding, but for one that pins or paint keep.
        let stands = |(index, body): (usize, &Body)| {
            let stays = body.discretization.is_whole() || !body.tints().is_empty();
            let sleeps = stays && self.motion.stands(index, body);
            body.system.nodes.is_empty() || body.frozen.is_some() || sleeps
        };
        now == wanted && self.edits_under_way() == 0 && self.bodies.iter().enumerate().all(stands)
    }

    /// Whether a body sleeps in this step, after tips are placed and fixings prescribed. Wakes it if something acts on it.
    pub(super) fn sleeps(&mut self, index: usize, time: StepTime) -> bool {
        if self.motion.sleep.speed <= 0.0 {
            return false;
        }
        if self.is_disturbed(index, time) {
            self.motion.sleep.wake(index);
        }
        self.motion.sleep.is_asleep(index)
    }

    /// Records a step in which the fastest node moved at `fastest` (m/s); a body that has been slow long enough falls asleep.
    pub(super) fn rest(&mut self, index: usize, fastest: f64, StepTime { start: time, dt }: StepTime) {
        let Body { name, system, .. } = &mut self.bodies[index];
        if !self.motion.sleep.rest(index, &mut system.nodes, fastest, dt) {
            return;
        }
        self.motion.integrators[index].forget_history();
        // The neighbour lists of tips are invalidated, because motion is not accumulated while the body sleeps.
        self.interactions.tips[index].invalidate();
        let below = self.motion.sleep.speed;
        self.events.add(EventKind::Asleep, time + dt, || format!("body `{name}`: below {below} m/s for {SLOW_FOR} s"));
    }

    /// Whether a tool loads or is near a body, an obstacle moves near it, or one of its fixings moves.
    fn is_disturbed(&mut self, index: usize, time: StepTime) -> bool {
        let (body, sleep) = (&self.bodies[index], &self.motion.sleep);
        if self.motion.loads.is_loaded() || sleep.is_moved(&body.system.nodes) {
            return true;
        }
        match sleep.rests[index].asleep {
            Some(bounds) => {
                self.interactions.may_reach(index, &body.system.nodes.x, bounds, body.discretization.edge(), time)
            }
            None => self.interactions.tips[index].is_active(),
        }
    }
}
