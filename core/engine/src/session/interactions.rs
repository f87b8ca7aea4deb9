//! What acts on the bodies of a session beside their own forces: fingertips, obstacles, other bodies, seams and ties.

use super::body_contacts::BodyContacts;
use super::obstacles::Obstacles;
use super::seam_pairs::Seam;
use super::seams::Seams;
use super::ties::Ties;
use crate::contact::{self, SheetTips};
use pliant_solver::{Constraint, ContactConstraints, NoContacts, StepTime, Vec3};

/// Everything that bodies meet and are held together by.
pub(super) struct Interactions {
    /// Fingertips on each moving body; used for sheets.
    pub(super) tips: Vec<SheetTips>,
    /// Obstacles, and what bodies touch of them.
    pub(super) obstacles: Obstacles,
    /// Contact of bodies with each other.
    pub(super) body_contacts: BodyContacts,
    /// Seams within sheets.
    pub(super) seams: Seams,
    /// Ties of points of two bodies.
    pub(super) ties: Ties,
}

impl Interactions {
    /// Interactions of this number of moving bodies, without ties.
    pub(super) fn new(obstacles: Obstacles, body_contacts: BodyContacts, seams: Seams, bodies: usize) -> Self {
        let tips = (0..bodies).map(|_| SheetTips::default()).collect();
        Self { tips, obstacles, body_contacts, seams, ties: Ties::default() }
    }

    /// Forgets what follows from the nodes and the surface of a body, after a change of them.
    pub(super) fn changed(&mut self, body: usize) {
        self.seams.retry(body);
        self.body_contacts.changed(body);
        self.tips[body].invalidate();
        self.obstacles.surface_changed(body);
    }

    /// Adapts to other bodies, of which each is a part of the body of the scene in `roots`, or that body; those before number `kept` are as they were. `seams` are
    /// those of each body, in a scene with seams.
    pub(super) fn set_bodies(&mut self, roots: &[usize], kept: usize, seams: Option<Vec<Vec<Seam>>>) {
        self.tips.truncate(kept);
        self.tips.resize_with(roots.len(), SheetTips::default);
        self.obstacles.resize(roots.len());
        self.body_contacts.set_bodies(roots);
        if let Some(seams) = seams {
            self.seams.set_bodies(seams);
        }
    }

    /// Nodes of a body that obstacles or tips hold, each with what it may still do.
    pub(super) fn held(&self, body: usize) -> impl Iterator<Item = (u32, Constraint)> + '_ {
        let tips = self.tips[body].held().map(|node| (node, Constraint::Fixed));
        self.obstacles.held(body).chain(tips)
    }

    /// Whether a tip, or an obstacle that moves, could touch a sleeping body, with nodes at `x` (n x 3, m) in the box `bounds` (m) and edges of `edge` (m), in
    /// two steps.
    pub(super) fn may_reach(&mut self, body: usize, x: &[Vec3], bounds: [Vec3; 2], edge: f64, time: StepTime) -> bool {
        let [low, high] = bounds;
        let near_tip = self.tips[body].tips.iter().any(|tip| {
            let reach = tip.shape.shape().bounding_radius() + edge + 2.0 * time.dt * tip.velocity.norm();
            (0..3).all(|c| tip.position[c] > low[c] - reach && tip.position[c] < high[c] + reach)
        });
        // The box of a sheet is nearly empty: a tip in it may be far from the sheet.
        (near_tip && self.tips[body].may_touch(x, edge, time.dt)) || self.obstacles.come_near(bounds, edge, time)
    }

    /// Calls the step of a body with its contact constraints and, where `load_nodes` gives the number of its nodes, with the forces of other bodies on them,
    /// N (n x 3), or none.
    pub(super) fn step_in_contact<R>(
        &mut self,
        body: usize,
        load_nodes: Option<usize>,
        step: impl FnOnce(&mut (dyn ContactConstraints + Send), &[Vec3]) -> R,
    ) -> R {
        let forces = load_nodes.map_or(&[][..], |nodes| self.body_contacts.load(body, nodes));
        let tips = &mut self.tips[body];
        match self.obstacles.near_mut(body) {
            Some(obstacles) => step(&mut contact::BodyContacts { tips, obstacles }, forces),
            None if tips.tips.is_empty() => step(&mut NoContacts, forces),
            None => step(tips, forces),
        }
    }
}
