//! Contact of a tool with the samples of a solid's surface by a law of a plugin: equilibrium of the massless tool between the law and the coupling.
//!
//! The tool ends a step where the tractions on it, at its own velocity, balance the spring to the hand. Newton's method finds that place with the law's
//! derivatives; friction is the secant of [`super::law`], so it never drives the tool.

use super::law::{LAW_MARGIN, LawContacts, LawForce, NearPoint};
use super::near::SurfacePoint;
use crate::shape::OrientedShape;
use nalgebra::Matrix3;
use pliant_host::{ContactLaw, HostError};
use pliant_solver::{StepTime, Vec3};
use std::sync::Arc;

/// Contacts of a tool with solids by a law; a tool touches one of them at a time.
pub struct LayerLaw {
    contacts: LawContacts,
    /// Index of the body that is touched.
    body: u32,
    /// Samples in contact at the beginning of the last step, by ascending number.
    last: Vec<Sample>,
    /// Position of the tool at the end of the last step, m; `None` if it was not there.
    tool: Option<Vec3>,
    /// Samples in contact in this step, by ascending number (buffer).
    now: Vec<Sample>,
}

/// A sample in contact.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Number of the sample on its body, the same in every step until a cut makes other samples.
    key: u32,
    /// Its position in the rest shape, m.
    rest: Vec3,
    /// Its position, m.
    point: Vec3,
    /// Its velocity, m/s.
    velocity: Vec3,
    /// Area of the undeformed surface it stands for, m^2.
    area: f64,
}

/// What the tool meets in a step.
pub struct LawStep<'a> {
    /// Index of the body.
    pub body: u32,
    /// Samples near the tool, of all bodies.
    pub samples: &'a [SurfacePoint],
    /// Shape of the tool.
    pub shape: &'a OrientedShape,
    /// Position of the hand, m.
    pub hand: Vec3,
    /// Stiffness of the coupling to the hand, N/m.
    pub coupling: f64,
    /// Mass of the nodes at the surface per area, kg/m^2.
    pub mass: f64,
    /// Start and length of the step, s.
    pub time: StepTime,
    /// Whether the step is explicit.
    pub is_explicit: bool,
}

/// Largest number of Newton steps to equilibrium.
const MAX_STEPS: usize = 20;
/// Largest depth of a sample, relative to the length scale of the tool: one that came past the tool's centre would be pushed to the other side.
const MAX_DEPTH: f64 = 0.5;
/// Largest step of Newton's method, and the one at which it ends, relative to the length scale of the tool.
const STEPS: [f64; 2] = [0.1, 1e-9];
/// Distance up to which samples belong to the search, relative to the length scale of the tool.
const MARGIN: f64 = 0.2;

impl LayerLaw {
    /// No contact yet.
    pub fn new(law: Arc<ContactLaw>) -> Self {
        Self { contacts: LawContacts::new(law), body: 0, last: Vec::new(), tool: None, now: Vec::new() }
    }

    /// Ends the contact.
    pub fn leave(&mut self) {
        self.contacts.clear_contacts();
        self.last.clear();
        self.tool = None;
    }

    /// Ends the contact of a tool that is now at `p` (m), from where it may meet a body in the next step.
    pub fn part(&mut self, p: Vec3) {
        self.leave();
        self.tool = Some(p);
    }

    /// Finds the equilibrium from the position `p` of the tool (m). Returns the tool's position, m.
    ///
    /// # Errors
    /// Returns the error of the law.
    pub fn balance(&mut self, step: &LawStep<'_>, mut p: Vec3) -> Result<Vec3, HostError> {
        self.begin(step, p)?;
        let scale = step.shape.shape().length_scale();
        for _ in 0..MAX_STEPS {
            self.press(step, p)?;
            let (force, slope) = self.force_on_tool(step, p);
            let change = slope.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * force);
            let (length, most) = (change.norm(), STEPS[0] * scale);
            p += if length > most { change * (most / length) } else { change };
            if length <= STEPS[1] * scale {
                break;
            }
        }
        let depths = self.now.iter().map(|sample| -step.shape.distance(sample.point - p));
        let excess = depths.fold(0.0, f64::max) - MAX_DEPTH * scale;
        if excess > 0.0 {
            let out = self.contacts.forces().map(|(near, _)| -near.normal).sum::<Vec3>();
            p += excess * out.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        }
        self.press(step, p)?;
        self.tool = Some(p);
        Ok(p)
    }

    /// Samples that are pushed: position in the rest shape (m), position (m), unit normal out of the tool, and the force on the body.
    pub fn pushes(&self) -> impl Iterator<Item = (Vec3, Vec3, Vec3, &LawForce)> {
        let each = self.now.iter().zip(self.contacts.forces());
        each.map(|(sample, (near, force))| (sample.rest, sample.point, near.normal, force))
    }

    /// Ends the last step, of the same length as this one, and lists the samples of this one.
    fn begin(&mut self, step: &LawStep<'_>, p: Vec3) -> Result<(), HostError> {
        let LawStep { time: StepTime { start, dt }, .. } = *step;
        if self.body != step.body {
            let tool = self.tool;
            self.leave();
            (self.body, self.tool) = (step.body, tool);
        }
        let margin = MARGIN * step.shape.shape().length_scale();
        let reach = self.contacts.law().reach() + margin + (p - self.tool.unwrap_or(p)).norm();
        self.now.clear();
        let near = step.samples.iter().filter(|s| s.body == step.body && step.shape.distance(s.point - p) < reach);
        self.now.extend(near.map(|s| Sample {
            key: s.sample,
            rest: s.rest,
            point: s.point,
            velocity: Vec3::zeros(),
            area: s.area,
        }));
        self.now.sort_unstable_by_key(|sample| sample.key);
        let same = |last: &Sample| self.now.binary_search_by_key(&last.key, |sample| sample.key).ok();
        if self.last.iter().any(|last| same(last).is_some_and(|at| self.now[at].rest != last.rest)) {
            self.leave(); // a cut has made other samples
        }
        // A sample that has left the search has not moved for the law; its contact ends.
        let moved = |i: usize| {
            let last = &self.last[i];
            let at = self.now.binary_search_by_key(&last.key, |sample| sample.key);
            let moved = at.map_or(Vec3::zeros(), |at| self.now[at].point - last.point);
            (moved, moved / dt)
        };
        self.contacts.advance(moved, StepTime { start: start - dt, dt })?;
        for i in 0..self.last.len() {
            if let Ok(at) = self.now.binary_search_by_key(&self.last[i].key, |sample| sample.key) {
                self.now[at].velocity = (self.now[at].point - self.last[i].point) / dt;
            }
        }
        let (tool, contacts) = (self.tool.unwrap_or(p), &mut self.contacts);
        contacts.is_explicit = step.is_explicit;
        contacts.margin = LAW_MARGIN * step.shape.shape().length_scale();
        contacts.begin(self.now.iter().map(|sample| near_point(sample, step, p, tool)));
        self.last.clone_from(&self.now);
        Ok(())
    }

    /// Computes the forces for a tool that ends the step at `p` (m).
    fn press(&mut self, step: &LawStep<'_>, p: Vec3) -> Result<(), HostError> {
        let tool = self.tool.unwrap_or(p);
        self.contacts.place(self.now.iter().map(|sample| near_point(sample, step, p, tool)));
        self.contacts.press(step.time)
    }

    /// Force on a tool that ends the step at `p` (m), of law and coupling, N, and its negative derivative by `p`, N/m.
    fn force_on_tool(&self, step: &LawStep<'_>, p: Vec3) -> (Vec3, Matrix3<f64>) {
        let mut force = step.coupling * (step.hand - p);
        let mut slope = Matrix3::from_diagonal_element(step.coupling);
        for (near, law) in self.contacts.forces() {
            force -= law.at(step.time.dt * near.velocity, near.velocity);
            slope += pliant_solver::matrix3(&law.stiffness) + pliant_solver::matrix3(&law.damping) / step.time.dt;
        }
        (force, slope)
    }
}

/// A sample as the law sees it, of a tool that ends the step at `p` (m) and was at `before` (m).
fn near_point(sample: &Sample, step: &LawStep<'_>, p: Vec3, before: Vec3) -> NearPoint {
    let offset = sample.point - p;
    NearPoint {
        key: sample.key,
        gap: step.shape.distance(offset),
        normal: step.shape.normal(offset).unwrap_or_else(Vec3::z),
        velocity: sample.velocity,
        drive: (p - before) / step.time.dt,
        area: sample.area,
        compliance: 1.0 / (step.mass * sample.area),
        mass: step.mass * sample.area,
    }
}
