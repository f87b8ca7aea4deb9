//! Contact of a tip with a sheet by springs: for vertices too far apart for constraints, and for comparison.
//!
//! With the augmented Lagrangian method (Hestenes 1969, Powell 1969; one iteration per step) a tip is in contact with the points of triangles,
//! edges and vertices whose distance from it is a local minimum; a multiplier accumulates the force of each from step to step, so the remaining
//! depth converges to zero. With the penalty method each vertex inside the tip gets a spring force in proportion to its depth. Friction is a
//! tangential spring that slides according to Coulomb's law.

use super::fingertip::Tip;
use super::neighbour_list::NeighbourList;
use super::sheet_law::SheetLaw;
use super::sums::NodeSums;
use pliant_host::{ContactLaw, HostError};
use pliant_mesh::geometry::{Closest, closest_point};
use pliant_solver::{Block, NodeSprings, Nodes, StepTime, Vec3, matrix3};
use std::sync::Arc;

/// Contact method of a soft tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SoftMethod {
    /// Augmented Lagrangian method on triangles, edges and vertices; the depth converges to zero.
    AugmentedLagrangian,
    /// Penalty method at vertices; the force is in proportion to the depth, or that of a contact law.
    Penalty,
}

/// A tip of one tool on one sheet.
pub struct SoftTip {
    method: SoftMethod,
    /// Whether multipliers are kept from step to step; a sheet between two tips needs this off, as their multipliers would grow without bound.
    pub keeps_multipliers: bool,
    /// Triangles near the tip.
    near: NeighbourList,
    /// Points within the margin (buffer).
    candidates: Vec<Candidate>,
    /// Whether each candidate is a local minimum of the distance (buffer).
    is_minimum: Vec<bool>,
    /// Contact points of this step.
    contacts: Vec<ContactPoint>,
    /// Contact points of the last step.
    previous: Vec<ContactPoint>,
    sums: NodeSums,
    /// Contacts by a law, in the place of springs of the tool's stiffness.
    law: Option<SheetLaw>,
}

/// Parameters of a soft tip in a step.
#[derive(Clone, Copy, Debug)]
pub struct SoftPress {
    /// Stiffness of its springs, N/m.
    pub stiffness: f64,
    /// Largest displacement of a node of the sheet since the last step, m.
    pub moved: f64,
    /// Start and length of the step, s.
    pub time: StepTime,
    /// Whether the step is explicit.
    pub is_explicit: bool,
}

/// A tip at one position of its path through a step.
#[derive(Clone, Copy)]
struct PathSample {
    /// Centre of the tip, m.
    centre: Vec3,
    /// Stiffness of the contact springs, N/m.
    stiffness: f64,
    /// Displacement of the tip in the step, m.
    drive: Vec3,
    /// Length of the step, s.
    dt: f64,
}

/// A point of a sheet that may be in contact.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Nodes of the triangle; three times the same node for a vertex.
    corners: [u32; 3],
    /// Barycentric coordinates in the triangle: weights of its three corners, sum 1.
    bary: Vec3,
    /// Position of the point, m.
    point: Vec3,
    /// Signed distance from the tip, m.
    distance: f64,
}

/// A contact point. The force on it is `force - stiffness (x - point) - damping v`.
#[derive(Clone, Copy, Debug)]
struct ContactPoint {
    /// Nodes of the triangle; three times the same node for a vertex.
    corners: [u32; 3],
    /// Barycentric coordinates in the triangle: weights of its three corners, sum 1.
    bary: Vec3,
    /// Position at the beginning of the step, m.
    point: Vec3,
    /// Unit outward normal of the tip.
    normal: Vec3,
    /// Force at rest at `point`, N.
    force: Vec3,
    /// Stiffness, N/m.
    stiffness: Block,
    /// Damping, N s/m.
    damping: Block,
    /// Multiplier: the accumulated normal force, N.
    multiplier: f64,
    /// Whether it sticks; otherwise it slides.
    sticks: bool,
    /// Largest friction force, N.
    friction_limit: f64,
    /// Velocity of the tip relative to the sheet along it, at the beginning of the step, m/s.
    slip: Vec3,
}

/// Largest distance, in length scales of the tip, between contact points of two steps that are matched.
const MATCH_DISTANCE: f64 = 0.5;
/// Largest fraction of the spring force that is added to the multiplier in a step.
const MULTIPLIER_GAIN: f64 = 0.25;
/// Largest distance, in length scales of the tip, at which a contact keeps its multiplier after separation.
const GAP: f64 = 0.1;
/// Largest radius for the speed of a rotating tip's surface, m; without it an infinite plane would have infinite speed.
const MAX_RADIUS: f64 = 1.0;
/// Distances that differ by less than this, in length scales of the tip, count as equal.
const TIE: f64 = 1e-9;

impl SoftTip {
    /// A tip without contacts.
    pub fn new(method: SoftMethod) -> Self {
        Self {
            method,
            keeps_multipliers: true,
            near: NeighbourList::default(),
            candidates: Vec::new(),
            is_minimum: Vec::new(),
            contacts: Vec::new(),
            previous: Vec::new(),
            sums: NodeSums::default(),
            law: None,
        }
    }

    /// A tip without contacts whose force is that of a contact law at the vertices.
    pub fn with_law(law: Arc<ContactLaw>) -> Self {
        Self { law: Some(SheetLaw::new(law)), ..Self::new(SoftMethod::Penalty) }
    }

    /// A tip with the same method and contact law, without contacts.
    #[must_use]
    pub fn with_same_method(&self) -> Self {
        match &self.law {
            Some(law) => Self::with_law(law.law()),
            None => Self::new(self.method),
        }
    }

    /// Drops all contacts and invalidates the neighbour list, as after a change of the body's nodes.
    pub fn invalidate(&mut self) {
        self.near.invalidate();
        self.law.iter_mut().for_each(SheetLaw::invalidate);
        self.leave();
    }

    /// Drops all contacts.
    pub fn leave(&mut self) {
        self.contacts.clear();
        self.law.iter_mut().for_each(SheetLaw::leave);
    }

    /// Marks the areas around nodes as outdated, as where triangles have failed.
    pub fn invalidate_areas(&mut self) {
        self.law.iter_mut().for_each(SheetLaw::invalidate);
    }

    /// Areas of the undeformed sheet around each node, m^2 (n), if a contact law needs them and they are outdated: empty, to be filled.
    pub fn outdated_areas(&mut self) -> Option<&mut Vec<f64>> {
        self.law.as_mut().and_then(SheetLaw::outdated_areas)
    }

    /// Number of contact points in the last step.
    pub fn contacts(&self) -> usize {
        self.contacts.len()
    }

    /// Contacts after the nodes have moved: unit outward normal of the tip, normal force (N) and tangential velocity of the sheet relative to the
    /// tip (m/s).
    pub fn presses<'a>(&'a self, tip: &'a Tip, nodes: &'a Nodes) -> impl Iterator<Item = (Vec3, f64, Vec3)> + 'a {
        self.contacts.iter().map(|contact| {
            let v = interpolate_at(&nodes.v, contact.corners, contact.bary);
            let slip = v - tip.velocity_at(contact.point);
            let push = (contact.force_at(&nodes.x) - matrix3(&contact.damping) * v).dot(&contact.normal);
            (contact.normal, push.max(0.0), slip - slip.dot(&contact.normal) * contact.normal)
        })
    }

    /// Energy dissipated by friction at sliding contacts in a step of `dt` (s), after the nodes have moved, J.
    pub fn friction_work(&self, tip: &Tip, nodes: &Nodes, dt: f64) -> f64 {
        let kinetic_coefficient = self.contacts.iter().filter(|contact| !contact.sticks);
        let lost = kinetic_coefficient.map(|contact| {
            let slip = interpolate_at(&nodes.v, contact.corners, contact.bary) - tip.velocity_at(contact.point);
            -contact.friction_at(nodes).dot(&slip) * dt
        });
        lost.sum()
    }

    /// Finds the contacts of `tip` with the `count` triangles of a sheet, whose nodes `triangles` returns, `None` for one that has failed, and writes their
    /// springs to `out`.
    ///
    /// # Errors
    /// Returns the error of the contact law.
    pub fn press(
        &mut self,
        tip: &Tip,
        triangles: impl Fn(u32) -> Option<[u32; 3]>,
        count: u32,
        nodes: &Nodes,
        press: SoftPress,
        out: &mut NodeSprings,
    ) -> Result<(), HostError> {
        let SoftPress { stiffness, moved, time, is_explicit } = press;
        let dt = time.dt;
        std::mem::swap(&mut self.contacts, &mut self.previous);
        self.contacts.clear();
        let drive = tip.velocity * dt;
        let shape = tip.shape.shape();
        let turned =
            if shape.is_round() { 0.0 } else { dt * tip.spin.norm() * shape.bounding_radius().min(MAX_RADIUS) };
        let travel = drive.norm();
        // A law acts where a vertex comes to within the step.
        let ahead = self.law.as_ref().map_or(0.0, |law| law.reach(moved));
        if let Some(reach) = self.near.refresh(tip.position, shape, moved, travel + ahead) {
            let within = |t: &u32| {
                let Some(corners) = triangles(*t) else { return false };
                let d = closest_point(tip.position, corners.map(|n| nodes.x[n as usize])).point - tip.position;
                d.norm_squared() <= reach * reach
            };
            self.near.list.extend((0..count).filter(within));
        }
        // The path of a fast tip is sampled every half length scale, so that it cannot pass through the sheet.
        let samples = (2.0 * (travel + turned) / tip.length_scale()).ceil().clamp(1.0, 1000.0);
        for sample in 1..=samples as u32 {
            let centre = tip.position + (f64::from(sample) / samples - 1.0) * drive;
            let margin = if self.previous.is_empty() { 0.0 } else { GAP * tip.length_scale() };
            self.find(tip, centre, margin.max(ahead), &triangles, &nodes.x);
            if let Some(law) = &mut self.law {
                let vertices = self.candidates.iter().map(|candidate| (candidate.corners[0], candidate.point));
                law.find(tip, centre, vertices, nodes, dt);
                if law.is_near() {
                    break;
                }
            } else if !self.candidates.is_empty() {
                let sample = PathSample { centre, stiffness, drive, dt };
                self.compute_forces(tip, &sample, nodes);
                break;
            }
        }
        self.press_by_law(tip, nodes, time, is_explicit)?;
        self.write_springs(nodes, out);
        Ok(())
    }

    /// Computes the forces of the contact law, if there is one, at the points it has found.
    fn press_by_law(&mut self, tip: &Tip, nodes: &Nodes, time: StepTime, is_explicit: bool) -> Result<(), HostError> {
        let Some(law) = &mut self.law else { return Ok(()) };
        for (near, force) in law.press(time, is_explicit)? {
            let slip = near.velocity - tip.velocity_at(nodes.x[near.key as usize]);
            self.contacts.push(ContactPoint {
                corners: [near.key; 3],
                bary: Vec3::new(1.0, 0.0, 0.0),
                point: nodes.x[near.key as usize],
                normal: near.normal,
                force: force.force,
                stiffness: force.stiffness,
                damping: force.damping,
                multiplier: 0.0,
                sticks: false,
                friction_limit: f64::INFINITY,
                slip: slip - slip.dot(&near.normal) * near.normal,
            });
        }
        Ok(())
    }

    /// Updates the histories of a contact law after the nodes have moved in a step.
    ///
    /// # Errors
    /// Returns the error of the contact law.
    pub fn advance_law(&mut self, nodes: &Nodes, time: StepTime) -> Result<(), HostError> {
        let (contacts, Some(law)) = (&self.contacts, &mut self.law) else { return Ok(()) };
        let ended = |i: usize| {
            let node = contacts[i].corners[0] as usize;
            (nodes.x[node] - contacts[i].point, nodes.v[node])
        };
        law.advance(ended, time)
    }

    /// Lists the points within `margin` (m) of a tip at `centre` (m).
    fn find(&mut self, tip: &Tip, centre: Vec3, margin: f64, triangles: &impl Fn(u32) -> Option<[u32; 3]>, x: &[Vec3]) {
        self.candidates.clear();
        let mut add = |corners: [u32; 3], Closest { point, bary }| {
            let distance = tip.shape.distance(point - centre);
            if distance < margin {
                self.candidates.push(Candidate { corners, bary, point, distance });
            }
        };
        for corners in self.near.list.iter().filter_map(|t| triangles(*t)) {
            match self.method {
                SoftMethod::AugmentedLagrangian => {
                    add(corners, tip.shape.closest_on_triangle(centre, corners.map(|n| x[n as usize])));
                }
                SoftMethod::Penalty => corners
                    .into_iter()
                    .for_each(|n| add([n; 3], Closest { point: x[n as usize], bary: Vec3::new(1.0, 0.0, 0.0) })),
            }
        }
        match self.method {
            SoftMethod::AugmentedLagrangian => self.retain_local_minima(TIE * tip.length_scale()),
            SoftMethod::Penalty => {
                self.candidates.sort_unstable_by_key(|f| f.corners[0]);
                self.candidates.dedup_by_key(|f| f.corners[0]);
            }
        }
    }

    /// Removes duplicates on shared edges and vertices, and points that are not local minima: an adjacent triangle comes closer. Distances that
    /// differ by at most `tie` (m) count as equal.
    fn retain_local_minima(&mut self, tie: f64) {
        let all = &self.candidates;
        let is_part = |f: &Candidate, g: &Candidate| {
            let mut of = f.corners.iter().zip(&f.bary).filter(|(_, w)| **w > 0.0);
            of.all(|(n, _)| g.corners.contains(n))
        };
        self.is_minimum.clear();
        self.is_minimum.extend((0..all.len()).map(|i| {
            let f = &all[i];
            let beats = |(j, g): (usize, &Candidate)| {
                let same = (g.distance - f.distance).abs() <= tie;
                j != i && is_part(f, g) && if same { j < i } else { g.distance < f.distance }
            };
            !all.iter().enumerate().any(beats)
        }));
        let mut is_minimum = self.is_minimum.iter();
        self.candidates.retain(|_| *is_minimum.next().expect("one for each"));
    }

    /// Computes the contact force at each candidate.
    fn compute_forces(&mut self, tip: &Tip, sample: &PathSample, nodes: &Nodes) {
        let PathSample { centre, stiffness: k, drive, dt } = *sample;
        for candidate in &self.candidates {
            let mut normal = tip.shape.normal(candidate.point - centre).unwrap_or_else(Vec3::z);
            let old = self.previous.iter().filter_map(|contact| {
                let d = interpolate_at(&nodes.x, contact.corners, contact.bary) - candidate.point;
                let away = d.norm();
                (away <= MATCH_DISTANCE * tip.length_scale()).then_some((away, contact))
            });
            let old = old.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, contact)| contact);
            if old.is_some_and(|contact| contact.normal.dot(&normal) < 0.0) {
                normal = -normal; // the sheet has passed the centre; it is still pushed to the side it came from
            }
            let depth = tip.depth(candidate.point, normal);
            let speed = tip.velocity_at(candidate.point);
            let approach = speed - interpolate_at(&nodes.v, candidate.corners, candidate.bary);
            // Critical damping for the effective mass at this point. The gain of the multiplier is limited so that this damping keeps it stable;
            // where nodes are held it is zero, as what they leave of the depth would be added up for ever.
            let compliance = normal_compliance(candidate, normal, nodes);
            let drag = if compliance > 0.0 { (k / compliance).sqrt() } else { 0.0 };
            let gain = MULTIPLIER_GAIN.min(0.5 * dt * (k * compliance).sqrt());
            let kept = self.method == SoftMethod::AugmentedLagrangian && self.keeps_multipliers;
            let multiplier = if kept { old.map_or(0.0, |contact| contact.multiplier) } else { 0.0 };
            let push = multiplier + k * depth + drag * approach.dot(&normal);
            if push <= 0.0 || (old.is_none() && depth <= 0.0) {
                continue;
            }
            let multiplier = (multiplier + gain * k * depth).max(0.0);
            let tangent = |v: Vec3| v - v.dot(&normal) * normal;
            let slip = tangent(approach);
            let friction = old.map_or(Vec3::zeros(), |contact| tangent(contact.last_friction(nodes)));
            let trial = friction + k * dt * slip;
            let trial_norm = trial.norm();
            let stuck = old.is_none_or(|contact| contact.sticks);
            let limit = push * if stuck { tip.friction.static_coefficient } else { tip.friction.kinetic_coefficient };
            let sticks = trial_norm <= limit;
            let kinetic = tip.friction.kinetic_coefficient * push;
            let projector: Block = std::array::from_fn(|e| normal[e / 3] * normal[e % 3]);
            let tangential_projector: Block =
                std::array::from_fn(|e| if e % 4 == 0 { 1.0 - projector[e] } else { -projector[e] });
            let (tangential, stiffness, damping) = if sticks {
                let all = std::array::from_fn(|e| if e % 4 == 0 { k } else { 0.0 });
                (friction + k * tangent(drive), all, projector.map(|c| drag * c))
            } else {
                // Friction follows the slip at the end of the step, as that of a damper: a constant force would turn the slip of a light sheet
                // around in a step, the more so the longer the step is, and give it energy. A slip that goes on changing as it did in the last
                // step meets the force of Coulomb's law.
                let change = old.map_or(Vec3::zeros(), |contact| slip - tangent(contact.slip));
                let expected = trial + k * dt * change;
                let share = kinetic / expected.norm().max(0.5 * trial_norm);
                let along = share * k * dt;
                (
                    share * (friction + k * dt * tangent(speed)),
                    projector.map(|c| k * c),
                    std::array::from_fn(|e| drag * projector[e] + along * tangential_projector[e]),
                )
            };
            let Candidate { corners, bary, point, .. } = *candidate;
            // `force` is that on a sheet at rest; `damping` adds the part that depends on the velocity of the sheet.
            let at_rest = push + drag * (speed - approach).dot(&normal);
            let force = tangential + at_rest * normal;
            self.contacts.push(ContactPoint {
                corners,
                bary,
                point,
                normal,
                force,
                stiffness,
                damping,
                multiplier,
                sticks,
                friction_limit: if sticks { limit } else { kinetic },
                slip,
            });
        }
    }

    /// Distributes the contact forces to the nodes, beside the springs that an edit has attached.
    fn write_springs(&mut self, nodes: &Nodes, out: &mut NodeSprings) {
        self.sums.begin(nodes.len());
        self.sums.add_all(out);
        for contact in &self.contacts {
            for (node, weight) in contact.corners.into_iter().zip(&contact.bary).filter(|(_, w)| **w > 0.0) {
                self.sums.add(node, *weight, contact.force, &contact.stiffness, &contact.damping);
            }
        }
        self.sums.drain_into(1.0, &nodes.x, out);
    }
}

impl ContactPoint {
    /// Force on the sheet with its nodes at `x` (n x 3, m), without damping, N.
    fn force_at(&self, x: &[Vec3]) -> Vec3 {
        let moved = interpolate_at(x, self.corners, self.bary) - self.point;
        self.force - matrix3(&self.stiffness) * moved
    }

    /// Friction on the sheet, N.
    fn friction_at(&self, nodes: &Nodes) -> Vec3 {
        let v = interpolate_at(&nodes.v, self.corners, self.bary);
        let force = self.force_at(&nodes.x) - matrix3(&self.damping) * v;
        force - force.dot(&self.normal) * self.normal
    }

    /// Friction on the sheet from which the next step goes on, N: of a contact that slides as much as Coulomb's law says.
    fn last_friction(&self, nodes: &Nodes) -> Vec3 {
        let friction = self.friction_at(nodes);
        let norm = friction.norm();
        let is_limited = norm > self.friction_limit || (!self.sticks && norm > 0.0);
        if is_limited { friction * (self.friction_limit / norm) } else { friction }
    }
}

/// Inverse of the effective mass of a candidate along `normal`, 1/kg; 0 where its nodes are held.
fn normal_compliance(candidate: &Candidate, normal: Vec3, nodes: &Nodes) -> f64 {
    let each = candidate.corners.iter().zip(&candidate.bary).map(|(n, w)| {
        let node = *n as usize;
        w * w * nodes.constraint[node].filter(normal).norm_squared() / nodes.mass[node]
    });
    each.sum()
}

/// Interpolates a field at a point of a triangle.
fn interpolate_at(of: &[Vec3], corners: [u32; 3], bary: Vec3) -> Vec3 {
    (0..3).map(|i| bary[i] * of[corners[i] as usize]).sum()
}
