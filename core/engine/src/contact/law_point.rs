//! A contact point under a law: its state in a step, and the linear model of the law's force in it.

use pliant_host::{ContactStates, Tractions};
use pliant_solver::{Block, Vec3};

/// A point of a body's surface near a tool, at the beginning of a step.
#[derive(Clone, Copy, Debug)]
pub struct NearPoint {
    /// Identity of the point on the body, the same in every step.
    pub key: u32,
    /// Gap between the body as it is and the tool at the end of the step, m.
    pub gap: f64,
    /// Unit normal, from the tool to the body.
    pub normal: Vec3,
    /// Velocity of the body, m/s.
    pub velocity: Vec3,
    /// Velocity of the tool at the point, m/s.
    pub drive: Vec3,
    /// Area of the undeformed surface it stands for, m^2.
    pub area: f64,
    /// Inverse of the effective mass of the body along the normal, 1/kg; 0 where it is held.
    pub compliance: f64,
    /// Mass of the body at the point, kg.
    pub mass: f64,
}

/// Force on a body at a contact point: `force - stiffness (x - x0) - damping v`, x0 its position at the beginning of the step.
#[derive(Clone, Copy, Debug, Default)]
pub struct LawForce {
    /// Force at rest at x0, N.
    pub force: Vec3,
    /// Decrease of the force with the way of the point, N/m.
    pub stiffness: Block,
    /// Damping, N s/m.
    pub damping: Block,
}

/// What a contact point keeps from step to step, besides its history.
#[derive(Clone, Copy, Debug)]
pub(super) struct LawPoint {
    /// What is known of it in this step.
    pub near: NearPoint,
    /// First axis of the tangent plane; the second is `normal x axis`.
    pub axis: Vec3,
    /// Slip since the contact began, m.
    pub slip: [f64; 2],
    /// Energy it has taken up along the normal and not given out, J.
    pub energy: f64,
    /// Magnitude of the friction at the end of the last step, N.
    pub friction: f64,
    /// Slip rate that the law is asked for, m/s.
    pub expected: [f64; 2],
    /// Whether the contact begins in this step.
    pub is_new: bool,
    /// Force on the body in this step.
    pub force: LawForce,
}

/// How a force is made in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct PressStep {
    /// Whether a point gives out no more energy along the normal than it has taken up.
    pub is_passive: bool,
    /// Whether the step is explicit, so that friction at most stops what slides.
    pub is_explicit: bool,
    /// Length of the step, s.
    pub dt: f64,
}

/// Speed below which slip is not told from rest, m/s: at 10 nm/s the friction of a law that is regularised at smaller speeds is a damper.
const SLOWEST_SLIP: f64 = 1e-8;
/// Friction, relative to that of the last step, by which a point may bear more than the law gives.
const SMALL_FRICTION: f64 = 1e-3;
/// Halvings in the search for a push that gives out the energy that there is.
const BISECTIONS: usize = 30;

/// Length of a vector of the tangent plane.
fn norm([u, v]: [f64; 2]) -> f64 {
    (u * u + v * v).sqrt()
}

impl LawPoint {
    /// A point in contact, which was in contact before as `old` or is new.
    pub fn next(near: NearPoint, old: Option<Self>) -> Self {
        let n = near.normal;
        let along = |axis: Vec3| (axis - axis.dot(&n) * n).try_normalize(0.1);
        let least = n.iamin();
        let other = Vec3::from_fn(|i, _| if i == least { 1.0 } else { 0.0 });
        let axis = old.and_then(|old| along(old.axis)).or_else(|| along(other)).unwrap_or_else(Vec3::x);
        let (slip, energy, friction) = old.map_or(([0.0; 2], 0.0, 0.0), |old| (old.slip, old.energy, old.friction));
        let (expected, force) = ([0.0; 2], LawForce::default());
        Self { near, axis, slip, energy, friction, expected, is_new: old.is_none(), force }
    }

    /// Rate of the gap where the body has this velocity, m/s.
    pub fn gap_rate(&self, velocity: Vec3) -> f64 {
        (velocity - self.near.drive).dot(&self.near.normal)
    }

    /// The axes of the tangent plane.
    fn axes(&self) -> [Vec3; 2] {
        [self.axis, self.near.normal.cross(&self.axis)]
    }

    /// Velocity of the body along the tool, m/s.
    pub fn slip_rate(&self, velocity: Vec3) -> [f64; 2] {
        self.axes().map(|axis| (velocity - self.near.drive).dot(&axis))
    }

    /// Makes an expected slip rate below [`SLOWEST_SLIP`] that fast.
    pub fn leave_rest(&mut self) {
        let speed = norm(self.expected);
        if speed < SLOWEST_SLIP {
            let along = if speed > 0.0 { self.expected.map(|c| c / speed) } else { [1.0, 0.0] };
            self.expected = along.map(|c| c * SLOWEST_SLIP);
        }
    }

    /// Raises the expected slip rate of point number `i`, by a Newton step along it, where the body bore more friction in the last step than the law gives
    /// at that rate: what begins to slide would otherwise be held by the friction of slower slips. Not above the speed of the tool. Returns whether it
    /// was raised.
    pub fn raise_speed(&mut self, i: usize, sliding: &Tractions, dt: f64) -> bool {
        let (speed, count) = (norm(self.expected), sliding.normal.len());
        let along = self.expected.map(|c| c / speed);
        let drive = self.near.drive - self.near.drive.dot(&self.near.normal) * self.near.normal;
        let friction: f64 = (0..2).map(|a| -self.near.area * sliding.tangential[a * count + i] * along[a]).sum();
        let missing = self.friction - friction;
        if missing <= SMALL_FRICTION * self.friction || speed >= drive.norm() {
            return false;
        }
        let entry = |e: usize| {
            let [by_slip, by_rate] = [&sliding.tangential_by_slip, &sliding.tangential_by_slip_rate];
            by_rate[e * count + i] + dt * by_slip[e * count + i]
        };
        let slope: f64 = (0..4).map(|e| -self.near.area * entry(e) * along[e / 2] * along[e % 2]).sum();
        let step = missing / slope;
        let next = if step.is_finite() && step > 0.0 { (speed + step).min(drive.norm()) } else { drive.norm() };
        self.expected = along.map(|c| c * next);
        true
    }

    /// Writes the state of point number `i` at the end of a step of `dt` (s): gap (m), gap rate and slip rate (m/s).
    pub fn set_state(&self, states: &mut ContactStates, i: usize, gap: f64, gap_rate: f64, rate: [f64; 2], dt: f64) {
        let count = states.len();
        (states.gap[i], states.gap_rate[i], states.area[i]) = (gap, gap_rate, self.near.area);
        for axis in 0..2 {
            states.slip[axis * count + i] = self.slip[axis] + dt * rate[axis];
            states.slip_rate[axis * count + i] = rate[axis];
        }
    }

    /// Sets the force of point number `i` from the tractions without slip and with the expected slip.
    pub fn set_force(
        &mut self,
        i: usize,
        rest: &Tractions,
        sliding: &Tractions,
        PressStep { is_passive, is_explicit, dt }: PressStep,
    ) {
        let (NearPoint { gap, normal, velocity, drive, area, .. }, count) = (self.near, rest.normal.len());
        let towards = velocity.dot(&normal);
        let mut push = area * sliding.normal[i];
        let mut stiffness = area * (-sliding.normal_by_gap[i]).max(0.0);
        let mut damping = area * (-sliding.normal_by_gap_rate[i]).max(0.0);
        if self.is_new {
            // A tool that appears inside of a body pushes it out.
            let depth = -(gap + dt * drive.dot(&normal));
            self.energy = depth.max(0.0) * push.max(0.0);
        }
        let share = if is_passive { self.passive_share(push, stiffness, damping, is_explicit, dt) } else { 1.0 };
        (push, stiffness, damping) = (share * push, share * stiffness, share * damping);
        let rate @ [u, v] = self.expected;
        let at_rest = [0, 1].map(|a| area * rest.tangential[a * count + i]);
        let change = [0, 1].map(|a| area * sliding.tangential[a * count + i] - at_rest[a]);
        let whole = -(change[0] * u + change[1] * v) / (u * u + v * v);
        // An explicit step would turn a slip around that more than stops.
        let most = if is_explicit { self.near.mass / dt } else { f64::INFINITY };
        let drag = whole.clamp(0.0, most);
        let axes = self.axes();
        // What the change of friction has across the slip, as of a law that is not the same in all directions, does no work.
        let across: Vec3 = (0..2).map(|a| (change[a] + whole * rate[a]) * axes[a]).sum();
        let constant: Vec3 = (0..2).map(|a| at_rest[a] * axes[a]).sum();
        let along = drive - drive.dot(&normal) * normal;
        let at_x0 = push + (stiffness * dt + damping) * towards;
        let normal_block: Block = std::array::from_fn(|e| normal[e / 3] * normal[e % 3]);
        let block = |along_normal: f64, along_surface: f64| -> Block {
            std::array::from_fn(|e| {
                let identity = if e % 4 == 0 { along_surface } else { 0.0 };
                identity + (along_normal - along_surface) * normal_block[e]
            })
        };
        self.force = LawForce {
            force: at_x0 * normal + constant + across + drag * along,
            stiffness: block(stiffness, 0.0),
            damping: block(damping, drag),
        };
    }
}

impl LawPoint {
    /// Largest share, at most 1, of a push (N) with its stiffness (N/m) and damping (N s/m) that gives out no more energy in a step of `dt` (s) than the
    /// point has taken up, where nothing but the push moves its effective mass.
    fn passive_share(&self, push: f64, stiffness: f64, damping: f64, is_explicit: bool, dt: f64) -> f64 {
        let (gap_rate, budget) = (self.gap_rate(self.near.velocity), self.energy.max(0.0));
        // An explicit step pushes with the force at its start, which does not give way.
        let towards = self.near.velocity.dot(&self.near.normal);
        let push = if is_explicit { push + stiffness * dt * towards } else { push };
        let given = |share: f64| {
            let gives_way = self.near.compliance * dt * (damping + dt * stiffness);
            let resisted = if is_explicit { 1.0 } else { 1.0 + share * gives_way };
            let end = gap_rate + share * self.near.compliance * dt * push / resisted;
            share * push / resisted * (end * dt).max(0.0)
        };
        if given(1.0) <= budget {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if given(middle) <= budget { low = middle } else { high = middle }
        }
        low
    }
}

impl LawForce {
    /// The force where the body has moved by `moved` (m) since the beginning of the step and has this velocity (m/s), N.
    pub fn at(&self, moved: Vec3, velocity: Vec3) -> Vec3 {
        let times = pliant_solver::matrix3;
        self.force - times(&self.stiffness) * moved - times(&self.damping) * velocity
    }
}
