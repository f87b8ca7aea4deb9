//! Contact by a law of a plugin: states of contact points, tractions, and a linear model of how these change within a step.
//!
//! The law is called in the state that the step would end in if the body went on at its velocity, and the tool ends where it does. Along the normal the
//! model is the tangent there, which is exact to second order. Along the surface it is a secant: from the traction without slip to the one with the
//! slip of that state, so whatever the slip is at the end, friction opposes it. A tangent of a friction that hardly grows with the speed would not.
//!
//! At each point a law that does not attract gives out no more energy along the normal than it has taken up there (passivity observer and controller: Hannaford and
//! Ryu 2002), so an error of the time step cannot make it a source.

pub use super::law_point::{LawForce, NearPoint};
use super::law_point::{LawPoint, PressStep};
use pliant_host::{ContactLaw, ContactStates, HostError, Tractions};
use pliant_solver::{StepTime, Vec3};
use std::sync::Arc;

/// Contacts of one tool with one body under a law.
pub struct LawContacts {
    law: Arc<ContactLaw>,
    /// Whether steps are explicit, so that friction may at most stop what slides.
    pub is_explicit: bool,
    /// Gap up to which a contact lasts beyond the law's reach, m.
    pub margin: f64,
    /// Contact points of this step, by ascending key.
    points: Vec<LawPoint>,
    /// Histories of `points`, one after the other.
    histories: Vec<f64>,
    /// Contact points of the last step, by ascending key.
    previous_points: Vec<LawPoint>,
    /// Histories of `previous_points`, one after the other.
    previous_histories: Vec<f64>,
    /// States of `points` (buffer).
    states: ContactStates,
    /// Tractions without slip, and with the slip at the end of the step (buffers).
    tractions: [Tractions; 2],
}

/// Largest number of slip rates at which a law is evaluated in a step.
const MAX_LAW_EVALUATIONS: usize = 8;
/// Gap, in length scales of the tool, up to which a contact lasts beyond the law's reach.
pub const LAW_MARGIN: f64 = 0.01;

impl LawContacts {
    /// No contacts yet.
    pub fn new(law: Arc<ContactLaw>) -> Self {
        Self {
            law,
            is_explicit: false,
            margin: 0.0,
            points: Vec::new(),
            histories: Vec::new(),
            previous_points: Vec::new(),
            previous_histories: Vec::new(),
            states: ContactStates::default(),
            tractions: Default::default(),
        }
    }

    /// The law, for contacts of another tip or body by the same one.
    pub fn shared_law(&self) -> Arc<ContactLaw> {
        Arc::clone(&self.law)
    }

    /// The law of the plugin that gives the tractions.
    pub fn law(&self) -> &ContactLaw {
        &self.law
    }

    /// Ends all contacts and discards their histories.
    pub fn clear_contacts(&mut self) {
        self.points.clear();
        self.histories.clear();
    }

    /// Contact normal of the point `key` in the last step; `None` if it was not in contact.
    pub fn normal_of(&self, key: u32) -> Option<Vec3> {
        find(&self.points, key).map(|at| self.points[at].near.normal)
    }

    /// Whether the law acts at a point in a step of `dt` (s): within its reach at the end of the step, or in contact up to the margin beyond it.
    pub fn is_near(&self, near: &NearPoint, dt: f64) -> bool {
        let end = near.gap + dt * near.velocity.dot(&near.normal);
        end < self.law.reach() || (near.gap < self.law.reach() + self.margin && find(&self.points, near.key).is_some())
    }

    /// Begins a step with these points, which have ascending keys. Other points are no longer in contact.
    pub fn begin(&mut self, near: impl Iterator<Item = NearPoint>) {
        std::mem::swap(&mut self.points, &mut self.previous_points);
        std::mem::swap(&mut self.histories, &mut self.previous_histories);
        self.points.clear();
        self.histories.clear();
        let stride = self.law.history_stride();
        for near in near {
            let history = |at: usize| &self.previous_histories[stride * at..stride * (at + 1)];
            let old = find(&self.previous_points, near.key).map(|at| (self.previous_points[at], history(at)));
            self.points.push(LawPoint::next(near, old.map(|(point, _)| point)));
            match old {
                Some((_, history)) => self.histories.extend_from_slice(history),
                None => self.histories.resize(self.histories.len() + stride, 0.0),
            }
        }
    }

    /// Moves the points to the states that `near` gives, in the order of the points: for a tool whose position is searched for.
    pub fn place(&mut self, near: impl Iterator<Item = NearPoint>) {
        self.points
            .iter_mut()
            .zip(near)
            .for_each(|(point, near)| *point = LawPoint { is_new: point.is_new, ..LawPoint::next(near, Some(*point)) });
    }

    /// Computes the force at each point of a step.
    ///
    /// # Errors
    /// Returns the error of the law.
    pub fn press(&mut self, time: StepTime) -> Result<(), HostError> {
        if self.points.is_empty() {
            return Ok(());
        }
        self.set_histories();
        self.evaluate_law(false, time)?;
        self.points.iter_mut().for_each(|point| point.expected = point.slip_rate(point.near.velocity));
        for evaluation in 0..MAX_LAW_EVALUATIONS {
            self.points.iter_mut().for_each(LawPoint::leave_rest);
            self.evaluate_law(true, time)?;
            let sliding = &self.tractions[1];
            let raise = |(i, point): (usize, &mut LawPoint)| point.raise_speed(i, sliding, time.dt);
            if evaluation + 1 == MAX_LAW_EVALUATIONS
                || self.points.iter_mut().enumerate().map(raise).filter(|raised| *raised).count() == 0
            {
                break;
            }
        }
        let [rest, sliding] = &self.tractions;
        let how = PressStep { is_passive: !self.law.is_adhesive(), is_explicit: self.is_explicit, dt: time.dt };
        for (i, point) in self.points.iter_mut().enumerate() {
            point.set_force(i, rest, sliding, how);
        }
        Ok(())
    }

    /// Evaluates the law for the tractions at the end of a step, without slip or at the expected slip rates.
    fn evaluate_law(&mut self, with_slip: bool, time: StepTime) -> Result<(), HostError> {
        for (i, point) in self.points.iter().enumerate() {
            let rate = if with_slip { point.expected } else { [0.0; 2] };
            let gap = point.near.gap + time.dt * point.near.velocity.dot(&point.near.normal);
            point.set_state(&mut self.states, i, gap, point.gap_rate(point.near.velocity), rate, time.dt);
        }
        self.law.tractions(&self.states, time.start, time.dt, &mut self.tractions[usize::from(with_slip)])
    }

    /// The points in contact and the force at each.
    pub fn forces(&self) -> impl Iterator<Item = (&NearPoint, &LawForce)> {
        self.points.iter().map(|point| (&point.near, &point.force))
    }

    /// Ends a step that was accepted: `ended` gives displacement (m) and velocity (m/s) of the body at each point, by its number.
    ///
    /// # Errors
    /// Returns the error of the law.
    pub fn advance(&mut self, ended: impl Fn(usize) -> (Vec3, Vec3), time: StepTime) -> Result<(), HostError> {
        if self.points.is_empty() {
            return Ok(());
        }
        self.set_histories();
        let stride = self.law.history_stride();
        for (i, point) in self.points.iter_mut().enumerate() {
            let (moved, velocity) = ended(i);
            let (gap_rate, rate) = (point.gap_rate(velocity), point.slip_rate(velocity));
            let force = point.force.at(moved, velocity);
            let push = force.dot(&point.near.normal);
            point.energy -= push * gap_rate * time.dt;
            point.friction = (force - push * point.near.normal).norm();
            let gap = point.near.gap + moved.dot(&point.near.normal);
            point.set_state(&mut self.states, i, gap, gap_rate, rate, time.dt);
            point.slip = [0, 1].map(|axis| point.slip[axis] + time.dt * rate[axis]);
        }
        self.law.advance(&mut self.states, time.start, time.dt)?;
        let count = self.points.len();
        for (i, value) in self.histories.iter_mut().enumerate() {
            *value = self.states.history[(i % stride) * count + i / stride];
        }
        // Points that a search keeps although they are apart begin anew when they meet.
        let apart = self.law.reach() + self.margin;
        for (i, point) in self.points.iter_mut().enumerate().filter(|(i, _)| self.states.gap[*i] > apart) {
            (point.slip, point.energy, point.friction) = ([0.0; 2], 0.0, 0.0);
            self.histories[stride * i..stride * (i + 1)].fill(0.0);
        }
        Ok(())
    }

    /// Writes the histories into the planes of the states.
    fn set_histories(&mut self) {
        let (count, stride) = (self.points.len(), self.law.history_stride());
        self.states.reset(count, stride);
        for (i, value) in self.histories.iter().enumerate() {
            self.states.history[(i % stride) * count + i / stride] = *value;
        }
    }
}

/// Index of the point with a key.
fn find(points: &[LawPoint], key: u32) -> Option<usize> {
    points.binary_search_by_key(&key, |point| point.near.key).ok()
}
