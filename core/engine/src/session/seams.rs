//! Seams of sheets that a scene closes from its start, as of a sewing pattern: pairs of vertices that are near enough become one node, the others
//! are drawn together first, by equal and opposite springs.
//!
//! What is left to join follows from the nodes alone, not from what was joined before.

use super::event::{EventKind, Events};
use super::opening::Opening;
use super::seam_pairs::{Seam, gap, pairs};
use super::{Session, SessionError};
use crate::body::{Body, Discretization, Model};
use crate::contact::NodeSums;
use crate::scene::{BodyScene, SeamScene};
use crate::tool::diagonal;
use pliant_solver::{NodeSprings, StepTime};
use std::collections::BTreeSet;
use toml::Spanned;

/// Seams of all bodies.
#[derive(Default)]
pub(super) struct Seams {
    /// Seams of each body; empty where the scene has none.
    of_body: Vec<Vec<Seam>>,
    /// Number of pairs that each body had apart in the last step.
    open: Vec<usize>,
    /// Bodies whose material has refused a join: nothing more is joined in them until their nodes change.
    refused: BTreeSet<usize>,
    /// Body and number of each seam that an event says to be open.
    reported: BTreeSet<(usize, usize)>,
    sums: NodeSums,
}

/// Stiffness of the spring of a pair, over its lighter mass and the square of the step: of implicit steps, which are stable with any, so that inertia hardly
/// delays a seam; and of explicit ones, far below their limit of stability.
const STIFFNESS: [f64; 2] = [100.0, 0.1];
/// Time after which a seam that is still open is reported, s beyond its `time`.
const LATE: f64 = 0.1;

impl Seams {
    /// The seams of each moving body; none where the scene has none at all.
    pub fn new(of_body: Vec<Vec<Seam>>) -> Self {
        let mut seams = Self::default();
        seams.set_bodies(of_body);
        seams
    }

    /// The seams of each of other bodies.
    pub fn set_bodies(&mut self, of_body: Vec<Vec<Seam>>) {
        self.open = of_body.iter().map(|seams| seams.iter().map(|seam| seam.pairs.len()).sum()).collect();
        self.of_body = of_body;
        self.refused.clear();
    }

    /// The seams of each body; empty where the scene has none.
    pub fn of_bodies(&self) -> &[Vec<Seam>] {
        &self.of_body
    }

    /// Joins again what a body has refused to join, after a change of its nodes.
    pub fn retry(&mut self, body: usize) {
        self.refused.remove(&body);
    }

    /// Joins nothing more in a body until [`Seams::retry`].
    fn refuse(&mut self, body: usize) {
        self.refused.insert(body);
    }

    /// Number of pairs of a body that were apart in the last step.
    fn open_pairs(&self, body: usize) -> usize {
        self.open.get(body).copied().unwrap_or(0)
    }

    /// The pairs of nodes of a body that are near enough to be joined now, lower number first; each node is in one pair at most.
    fn near_pairs(&mut self, index: usize, body: &Body) -> Vec<[u32; 2]> {
        let is_idle = self.of_body[index].is_empty() || self.refused.contains(&index);
        let (Discretization::Sheet(sheet), false) = (&body.discretization, is_idle || body.frozen.is_some()) else {
            return Vec::new();
        };
        let nodes = &body.system.nodes;
        let most = Body::join_distance(sheet.edge());
        let (mut open, mut near, mut used) = (0, Vec::new(), BTreeSet::new());
        for pair in self.of_body[index].iter().flat_map(|seam| &seam.pairs) {
            let [a, b] = pair.map(|v| sheet.node_of(v));
            if a == b || !sheet.may_weld([a, b], nodes) {
                continue;
            }
            open += 1;
            let is_near = (nodes.x[a as usize] - nodes.x[b as usize]).norm() <= most;
            // A node that has just become one of two is joined further in the next step.
            if is_near && !used.contains(&a) && !used.contains(&b) {
                used.extend([a, b]);
                near.push([a.min(b), a.max(b)]);
            }
        }
        self.open[index] = open;
        near
    }

    /// Sets `springs` to those that draw the open pairs of a body together in a step, of an explicit scheme in this number of substeps. Events say which
    /// seams are open for too long.
    pub(super) fn draw(
        &mut self,
        index: usize,
        body: &Body,
        explicit_substeps: Option<usize>,
        time: StepTime,
        springs: &mut NodeSprings,
        events: &mut Events,
    ) {
        springs.clear();
        if self.open_pairs(index) == 0 || self.refused.contains(&index) {
            return;
        }
        let Discretization::Sheet(sheet) = &body.discretization else { return };
        let (nodes, explicit) = (&body.system.nodes, usize::from(explicit_substeps.is_some()));
        let substeps = explicit_substeps.unwrap_or(1).max(1) as f64;
        let none = [0.0; 9];
        self.sums.begin(nodes.len());
        let mut open = 0;
        for (number, seam) in self.of_body[index].iter().enumerate() {
            let left = (seam.time - time.start).max(time.dt);
            let (mut apart, mut widest) = (0, 0.0_f64);
            for pair in &seam.pairs {
                let [a, b] = pair.map(|v| sheet.node_of(v));
                if a == b || !sheet.may_weld([a, b], nodes) {
                    continue;
                }
                let gap = nodes.x[b as usize] - nodes.x[a as usize];
                let light = nodes.mass[a as usize].min(nodes.mass[b as usize]);
                // The whole gap is left to the time that is left.
                let share = time.dt / left;
                let stiffness = 0.5 * STIFFNESS[explicit] * light * (substeps / time.dt).powi(2);
                let force = share * stiffness * gap;
                let block = diagonal(stiffness);
                self.sums.add(a, 1.0, force, &block, &none);
                self.sums.add(b, 1.0, -force, &block, &none);
                (apart, widest) = (apart + 1, widest.max(gap.norm()));
            }
            open += apart;
            let is_late = apart > 0 && time.start > seam.time + LATE;
            if is_late && self.reported.insert((index, number)) {
                let (place, name) = (&seam.place, &body.name);
                events.add(EventKind::Message, time.start, || {
                    format!("{place}: body `{name}`: {apart} pairs of this seam are still up to {widest:.4} m apart: what holds them is stronger")
                });
            }
        }
        self.sums.drain_into(1.0, &nodes.x, springs);
        self.open[index] = open;
    }
}

impl Opening<'_> {
    /// The seams of a body.
    ///
    /// # Errors
    /// Those of [`pairs`]; a seam of a solid; vertices that are apart without a `time`.
    pub(super) fn seams(
        &self,
        scene: &BodyScene,
        model: &Model,
        discretization: &Discretization,
    ) -> Result<Vec<Seam>, SessionError> {
        let seam = |spanned: &Spanned<SeamScene>| -> Result<Seam, SessionError> {
            let wrong = |text: String| self.source.error(spanned.span(), text);
            let name = scene.name.get_ref();
            let Discretization::Sheet(sheet) = discretization else {
                return Err(wrong(format!("`stitch` of body `{name}`, a solid; allowed is a body with `sheet`")).into());
            };
            let pairs = pairs(spanned, self.source, model)?;
            let time = spanned.get_ref().time.as_ref().map_or(0.0, |time| time.get_ref().si);
            if let Some(given) = spanned.get_ref().time.as_ref().filter(|_| time < 0.0) {
                let text = format!("time of a seam is {time} s; allowed is 0 or more");
                return Err(self.source.error(given.span(), text).into());
            }
            let most = Body::join_distance(sheet.edge());
            if let Some([a, b]) = pairs.iter().find(|pair| time == 0.0 && gap(model, **pair) > most) {
                let text = format!(
                    "vertices {a} and {b} of a seam of body `{name}` are {:.4} m apart; allowed is up to {most:.4} m, a quarter of an edge, or a \
                     `time` in which they are drawn together",
                    gap(model, [*a, *b])
                );
                return Err(wrong(text).into());
            }
            Ok(Seam { pairs, time, place: wrong(String::new()).place() })
        };
        scene.stitch.iter().map(seam).collect()
    }
}

impl Session {
    /// Joins what is near enough of the seams of all bodies.
    pub(super) fn close_seams(&mut self, time: f64) {
        for index in 0..self.interactions.seams.of_bodies().len() {
            let near = self.interactions.seams.near_pairs(index, &self.bodies[index]);
            if near.is_empty() {
                continue;
            }
            self.editing.layers.assign(&self.bodies);
            match self.bodies[index].join_nodes(&near) {
                Ok(()) => {
                    self.changed(index);
                    self.fix_layers(time);
                }
                Err(error) => {
                    self.interactions.seams.refuse(index);
                    let name = &self.bodies[index].name;
                    self.events.add(EventKind::Message, time, || {
                        format!("body `{name}`: its seams stay as they are: {error}")
                    });
                }
            }
        }
    }

    /// Number of pairs of vertices of a body's seams that are not joined yet.
    pub fn open_seam_pairs(&self, body: usize) -> usize {
        self.interactions.seams.open_pairs(body)
    }
}
