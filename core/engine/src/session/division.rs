//! Parts of a body become bodies of their own, and one again when that is undone.
//!
//! The largest part has the place of the whole among the bodies, its name, and what names it: probes, tools, devices. The others come last. A body that is not
//! among the bodies of the session at present, because it was split or because its splitting was undone, is kept aside: undo and redo exchange bodies.

use super::Session;
use super::event::EventKind;
use super::seam_pairs::Seam;
use crate::body::{Body, Discretization, DivideError, Division, Lattice};
use std::collections::BTreeMap;

/// Bodies that have been split and their parts.
pub(super) struct DividedBodies {
    /// Bodies that are not among those of the session at present, by number.
    aside: BTreeMap<u32, Body>,
    /// Body of the scene that each body with a number is a part of, as an index among the moving bodies.
    root: Vec<usize>,
    /// Seams of each body that is a part or has been split, by number.
    seams: BTreeMap<u32, Vec<Seam>>,
}

impl DividedBodies {
    /// None yet, in a scene with this number of moving bodies.
    pub(super) fn new(bodies: usize) -> Self {
        Self { aside: BTreeMap::new(), root: (0..bodies).collect(), seams: BTreeMap::new() }
    }

    /// Bodies that are kept aside.
    pub(super) fn aside_mut(&mut self) -> impl Iterator<Item = &mut Body> {
        self.aside.values_mut()
    }
}

/// Why a body of a session is not split.
#[derive(Debug, thiserror::Error)]
pub enum SplitError {
    /// The session has no such body.
    #[error("no moving body {body}; allowed is an index below {count}")]
    NoBody {
        /// The index that was given.
        body: usize,
        /// Number of moving bodies.
        count: usize,
    },
    /// The body stands still.
    #[error("body `{name}` stands still: {why}; allowed is a body that moves")]
    Frozen {
        /// Name of the body.
        name: String,
        /// Why it stands still.
        why: String,
    },
    /// The body cannot be divided.
    #[error("body `{name}` is not split: {error}")]
    Divide {
        /// Name of the body.
        name: String,
        /// Reason why it cannot be divided.
        error: DivideError,
    },
}

impl Session {
    /// Makes parts of the moving body `body` bodies of their own: with their positions, velocities, rest shapes, pins, paint and histories. Active edits end.
    /// [`Session::undo`] makes them one again. Returns the indices of the bodies it is now: the largest part, or what is left, has the index of the whole.
    ///
    /// # Errors
    /// A body that is not there, stands still or cannot be divided; it is then as it was. An event says so too.
    pub fn split(&mut self, body: usize, division: Division) -> Result<Vec<usize>, SplitError> {
        let touching = self.touching_proxies();
        self.end_edits();
        self.remember_now();
        let split = self.divide(body, division);
        self.resume_touching(&touching);
        if split.is_err() && self.editing.history.kept {
            self.editing.history.forget_last();
        }
        if let Err(error) = &split {
            let time = self.time();
            self.events.add(EventKind::SplitRefused, time, || error.to_string());
        }
        split
    }

    /// Makes each part of the bodies that a blade has cut a body of its own.
    pub(super) fn split_cut_bodies(&mut self) {
        let time = self.time();
        for index in 0..self.bodies.len() {
            if self.bodies[index].cut.as_ref().is_none_or(|mesh| mesh.depth() == 0) {
                continue;
            }
            if let Err(error) = self.divide(index, Division::EachPart) {
                self.events.add(EventKind::SplitRefused, time, || error.to_string());
            }
        }
    }

    fn divide(&mut self, index: usize, division: Division) -> Result<Vec<usize>, SplitError> {
        let (count, time) = (self.bodies.len(), self.time());
        let Some(body) = self.bodies.get_mut(index) else { return Err(SplitError::NoBody { body: index, count }) };
        let name = body.name.clone();
        if let Some(why) = &body.frozen {
            return Err(SplitError::Frozen { name, why: why.clone() });
        }
        let was_mirrored = body.symmetry.is_some();
        let was_outdated = body.discretization.lattice().is_some_and(Lattice::is_outdated);
        let divided = body.divided(division, &self.plan.cap_material);
        if divided.is_err() && was_outdated {
            // It has followed a cut before it was found to be in one part.
            self.changed(index);
        }
        let mut parts = divided.map_err(|error| SplitError::Divide { name: name.clone(), error })?;
        self.editing.layers.assign(&self.bodies);
        let (whole, root) = (self.bodies[index].number, self.editing.divided.root[self.bodies[index].number as usize]);
        let seams = self.interactions.seams.of_bodies().get(index).cloned().unwrap_or_default();
        let mut numbers: Vec<u32> = self.bodies.iter().map(|body| body.number).collect();
        let mut indices = vec![index];
        for (place, part) in parts.iter_mut().enumerate() {
            part.number = self.editing.divided.root.len() as u32;
            self.editing.divided.root.push(root);
            self.editing.divided.seams.insert(part.number, seams_of_part(&seams, part));
            if place == 0 {
                numbers[index] = part.number;
            } else {
                indices.push(numbers.len());
                numbers.push(part.number);
                part.name = self.free_name(&name, place);
            }
        }
        self.editing.divided.seams.insert(whole, seams);
        self.interactions.ties.divide(whole, &parts);
        let names: Vec<String> = parts.iter().map(|part| format!("`{}`", part.name)).collect();
        self.editing.divided.aside.extend(parts.into_iter().map(|part| (part.number, part)));
        self.show_bodies(numbers.into_iter());
        self.fix_layers(time);
        let lost = if was_mirrored {
            "; vertices are no longer mirrored to the bit, as the parts have no mirror image"
        } else {
            ""
        };
        self.events.add(EventKind::Split, time, || {
            format!("body `{name}` is now {} bodies: {}{lost}", names.len(), names.join(", "))
        });
        Ok(indices)
    }

    /// A name for the part number `place` (from 1) of a body that no other body has.
    fn free_name(&self, whole: &str, place: usize) -> String {
        let present = self.bodies.iter().map(|body| body.name.as_str());
        let taken: Vec<&str> = present
            .chain(self.standing.iter().map(|(name, _)| name.as_str()))
            .chain(self.editing.divided.aside.values().map(|body| body.name.as_str()))
            .collect();
        let mut names = (place + 1..).map(|number| format!("{whole}-{number}"));
        names.find(|name| !taken.contains(&name.as_str())).unwrap_or_default()
    }

    /// Whether the session has a body with this number, present or aside.
    pub(super) fn has_body(&self, number: u32) -> bool {
        self.editing.divided.aside.contains_key(&number) || self.bodies.iter().any(|body| body.number == number)
    }

    /// Makes the bodies with these numbers, all of which there are, those of the session; the others are put aside. What belongs to the nodes of a body that has
    /// changed is forgotten.
    pub(super) fn show_bodies(&mut self, numbers: impl ExactSizeIterator<Item = u32> + Clone) {
        if self.bodies.iter().map(|body| body.number).eq(numbers.clone()) {
            return;
        }
        let before: Vec<u32> = self.bodies.iter().map(|body| body.number).collect();
        if !self.interactions.seams.of_bodies().is_empty() {
            for (number, seams) in before.iter().zip(self.interactions.seams.of_bodies()) {
                self.editing.divided.seams.entry(*number).or_insert_with(|| seams.clone());
            }
        }
        self.editing.divided.aside.extend(self.bodies.drain(..).map(|body| (body.number, body)));
        for (index, number) in numbers.enumerate() {
            let Some(mut body) = self.editing.divided.aside.remove(&number) else { continue };
            if let Some(other) = before.get(index).and_then(|before| self.editing.divided.aside.get(before)) {
                body.take_place_of(other);
            }
            self.bodies.push(body);
        }
        self.fit_bodies(&before);
        let is_other = |index: &usize| before.get(*index) != Some(&self.bodies[*index].number);
        let others: Vec<usize> = (0..self.bodies.len()).filter(is_other).collect();
        others.into_iter().for_each(|index| self.changed(index));
        for slot in &mut self.tools {
            slot.tool.release(&slot.hand);
            slot.slid_from = None;
        }
    }

    /// Gives every body what the session keeps for each: a part has the settings of the body of the scene that it was a part of. `before` are the numbers of the
    /// bodies that these were kept for so far.
    fn fit_bodies(&mut self, before: &[u32]) {
        let roots: Vec<usize> =
            self.bodies.iter().map(|body| self.editing.divided.root[body.number as usize]).collect();
        let (count, scene) = (roots.len(), roots.iter().max().map_or(0, |last| last + 1));
        let is_same = |index: usize| before.get(index) == Some(&self.bodies[index].number);
        // From the first body that is another one on; those of the scene have had theirs since it was opened.
        let kept = (scene..count).find(|index| !is_same(*index)).unwrap_or(count);
        self.motion.set_bodies(&self.bodies, &roots, kept);
        let seams_of = |body: &Body| self.editing.divided.seams.get(&body.number).cloned().unwrap_or_default();
        let has_seams = !self.interactions.seams.of_bodies().is_empty();
        let seams = has_seams.then(|| self.bodies.iter().map(seams_of).collect());
        self.interactions.set_bodies(&roots, kept, seams);
        self.warnings.set_bodies(&roots, kept);
        self.tools.iter_mut().for_each(|slot| slot.set_bodies(&roots, kept));
        self.guard.resumes_at = None;
    }
}

/// The pairs of seams both of whose vertices a part has.
fn seams_of_part(seams: &[Seam], part: &Body) -> Vec<Seam> {
    let Discretization::Sheet(_) = &part.discretization else { return Vec::new() };
    let has = |vertex: &u32| !part.model.around(*vertex).is_empty();
    let of_part = |seam: &Seam| {
        let pairs = seam.pairs.iter().copied().filter(|pair| pair.iter().all(has)).collect();
        Seam { pairs, ..seam.clone() }
    };
    seams.iter().map(of_part).collect()
}
