//! Warnings: parts of a scene that have no effect, or probably an unintended one.
//!
//! Warnings about models and selections are found when the scene is opened; those about edits follow from their statistics, so
//! [`Session::warnings`] can be called at any time. A warning changes no result.

use super::overlap::OverlapDetection;
use super::{Session, ToolSlot};
use crate::body::Body;
use serde::Serialize;
use std::fmt;

/// Code of a warning; docs/warnings.md lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WarningCode {
    /// Bounding boxes of two bodies that do not meet began to overlap during the run.
    BodiesMeet,
    /// Two bodies overlap at the start, and pass through each other.
    BodiesOverlap,
    /// The edges of a sheet are longer than an obstacle is wide.
    CoarseSheet,
    /// A pin, unpin, paint or stitch touched a body and changed nothing of it.
    ChangesNothing,
    /// Vertices of borders lie at one place and are apart.
    CoincidentBorders,
    /// An edit cut nothing.
    CutsNothing,
    /// A material finds elements of a body doubtful.
    DoubtfulElements,
    /// A tetrahedral mesh has something that its user may not expect.
    DoubtfulMesh,
    /// The scene gives no size of a model, and one metre per file unit does not fit the tool.
    DoubtfulUnits,
    /// The session runs on fewer threads than were asked for.
    FewerThreads,
    /// A `fixed` selects no node.
    FixesNothing,
    /// No body met an obstacle.
    MeetsNothing,
    /// A material takes fibre directions, and the scene gives none.
    NoFibres,
    /// The hand felt no force during an edit, which changed nothing.
    NoForce,
    /// A touch pressed a body but moved none of its vertices.
    MovesNoVertex,
    /// Parts of models were to be files, and every model is in one part.
    OnePart,
    /// A blade cuts a body that is not closed and has no interior.
    OpenBody,
    /// A material gave a warning that is not about its elements.
    PluginWarning,
    /// The radius of an edit is smaller than the cells of a body resolve.
    SmallRadius,
    /// A grid was asked for continuous slopes, which its body cannot have.
    SmoothIgnored,
    /// A body starts inside of an obstacle.
    StartsInside,
}

impl WarningCode {
    /// Spelling of the code in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::BodiesMeet => "bodies-meet",
            Self::BodiesOverlap => "bodies-overlap",
            Self::CoarseSheet => "coarse-sheet",
            Self::ChangesNothing => "changes-nothing",
            Self::CoincidentBorders => "coincident-borders",
            Self::CutsNothing => "cuts-nothing",
            Self::DoubtfulElements => "doubtful-elements",
            Self::DoubtfulMesh => "doubtful-mesh",
            Self::DoubtfulUnits => "doubtful-units",
            Self::FewerThreads => "fewer-threads",
            Self::FixesNothing => "fixes-nothing",
            Self::MeetsNothing => "meets-nothing",
            Self::NoFibres => "no-fibres",
            Self::NoForce => "no-force",
            Self::MovesNoVertex => "moves-no-vertex",
            Self::OnePart => "one-part",
            Self::OpenBody => "open-body",
            Self::PluginWarning => "plugin-warning",
            Self::SmallRadius => "small-radius",
            Self::SmoothIgnored => "smooth-ignored",
            Self::StartsInside => "starts-inside",
        }
    }
}

/// A part of the scene that has no effect, or probably an unintended one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// Code of the warning.
    pub code: WarningCode,
    /// Location in the scene: file, line and column; the file alone for a default.
    #[serde(rename = "where")]
    pub place: String,
    /// Description of the finding and of the remedy.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}] {}: {}", self.code.name(), self.place, self.message)
    }
}

/// Statistics of an edit.
#[derive(Clone, Copy, Debug, Default)]
struct EditTally {
    /// Number of steps in which it was active with a hand.
    steps: u64,
    /// Number of advances of its blade, in time spans that have ended.
    advances: usize,
    /// Whether it has changed a body, in time spans that have ended.
    has_changed: bool,
    /// Largest force on the hand, N.
    force: f64,
    /// Largest depth on a body with a lattice, m.
    depth: f64,
    /// Whether a vertex near the tool followed the surface.
    is_shown: bool,
    /// The body it pressed.
    body: Option<u32>,
}

/// Fraction of the depth of a dent by which a vertex near the tool must move for the dent to be visible.
const MIN_VISIBLE: f64 = 0.05;

/// Warnings of a session, and what they are found from.
pub(super) struct Warnings {
    /// Those of opening the scene.
    pub(super) opening: Vec<Warning>,
    /// Name of the scene's file, for warnings that belong to no line of it.
    pub(super) scene_file: String,
    /// Statistics of each edit of the plan.
    tallies: Vec<EditTally>,
    pub(super) overlaps: OverlapDetection,
    /// Location of the material of each moving body.
    pub(super) material_places: Vec<String>,
}

impl Warnings {
    /// None yet, for this number of edits of a scene in this file.
    pub(super) fn new(scene_file: String, edits: usize) -> Self {
        Self {
            opening: Vec::new(),
            scene_file,
            tallies: vec![EditTally::default(); edits],
            overlaps: OverlapDetection::default(),
            material_places: Vec::new(),
        }
    }

    /// Adapts to other bodies, of which each is a part of the body of the scene in `roots`, or that body; those before number `kept` are as they were.
    pub(super) fn set_bodies(&mut self, roots: &[usize], kept: usize) {
        self.material_places.truncate(kept);
        for &root in &roots[kept..] {
            self.material_places.push(self.material_places[root].clone());
        }
    }

    /// Adds a step of a tool to the statistics of its edit; `force` (N) is the force on the hand.
    pub(super) fn tally(&mut self, slot: &ToolSlot, bodies: &[Body], force: f64) {
        let Some(edit) = slot.edit.filter(|_| slot.hand.present) else { return };
        let tally = &mut self.tallies[edit];
        tally.steps += 1;
        tally.force = tally.force.max(force);
        let Some(touch) = slot.tool.proxy.touch.filter(|_| slot.tool.depth > tally.depth) else { return };
        let body = &bodies[touch.body as usize];
        if body.discretization.lattice().is_none() {
            return;
        }
        (tally.depth, tally.body) = (slot.tool.depth, Some(touch.body));
        if tally.is_shown {
            return;
        }
        let Ok(centre) = body.embed_point(touch.rest).map(|point| point.settled) else { return };
        let (model, least) = (&body.model, MIN_VISIBLE * tally.depth);
        body.skin.tree.near(centre, slot.tool.proxy.shape.extra_region_radius(), |triangle| {
            for v in model.surface.triangles[triangle as usize] {
                let moved = || body.embed_point(model.surface.points[v as usize]);
                tally.is_shown = tally.is_shown || moved().is_ok_and(|p| (p.now - p.settled).norm() >= least);
            }
        });
    }

    /// Adds what an edit has done to the statistics of its time spans that have ended: advances of its blade, and whether it has changed a body.
    pub(super) fn tally_ended(&mut self, edit: usize, advances: usize, has_changed: bool) {
        self.tallies[edit].advances += advances;
        self.tallies[edit].has_changed |= has_changed;
    }
}

impl Session {
    /// All warnings so far: first those of opening the scene, then those of edits and bodies; each code and location once.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut all = self.warnings.opening.clone();
        all.extend(self.warnings.overlaps.warnings.iter().cloned());
        all.extend(self.warn_materials());
        all.extend(self.interactions.obstacles.warn_unmet(self.steps()));
        all.extend(self.warn_threads());
        for (index, (edit, tally)) in self.plan.edits.iter().zip(&self.warnings.tallies).enumerate() {
            let Some((code, message)) = self.warn_edit(index, *tally) else { continue };
            if !all.iter().any(|known| known.code == code && known.place == edit.place) {
                all.push(Warning { code, place: edit.place.clone(), message });
            }
        }
        all
    }

    /// What materials find doubtful about the elements of their bodies, of a local region those it last had, and other warnings they gave.
    fn warn_materials(&self) -> impl Iterator<Item = Warning> + '_ {
        let bodies = self.bodies.iter().zip(&self.warnings.material_places);
        bodies.flat_map(|(body, place)| {
            let (name, material) = (&body.name, &body.system.material);
            let warnings = [
                (WarningCode::DoubtfulElements, material.element_warning()),
                (WarningCode::PluginWarning, material.last_warning()),
            ];
            warnings.into_iter().filter_map(move |(code, text)| {
                let message = format!("material `{}` of body `{name}`: {}", material.name(), text?);
                Some(Warning { code, place: place.clone(), message })
            })
        })
    }

    /// A warning if the session runs on one thread because the system refused to create others, or on fewer than were asked for because there are not
    /// as many processors.
    fn warn_threads(&self) -> Option<Warning> {
        let (asked, threads) = (self.motion.workers.asked, self.motion.pool().threads());
        let message = if self.motion.pool().is_refused() {
            format!(
                "the system gave no more threads, so the session runs on 1 instead of {asked} and takes longer; results are the same; \
                 ask for fewer with `--threads`, or raise the limit of processes (`ulimit -u`, `pids.max` of a container)"
            )
        } else if asked > threads {
            format!(
                "{asked} threads are asked for and there are {threads} processors, so the session runs on {threads}: more would wait for each \
                 other; results are the same; allowed is up to {threads}, or 0 for all"
            )
        } else {
            return None;
        };
        Some(Warning { code: WarningCode::FewerThreads, place: self.warnings.scene_file.clone(), message })
    }

    /// The warning that follows from the statistics of an edit.
    fn warn_edit(&self, index: usize, tally: EditTally) -> Option<(WarningCode, String)> {
        let edit = &self.plan.edits[index];
        let tool = &self.tools[edit.tool].tool.name;
        if tally.steps == 0 {
            return None;
        }
        if edit.kind.cuts() {
            let running: usize = self.tools.iter().filter(|slot| slot.edit == Some(index)).map(|s| s.advances).sum();
            return (tally.advances + running == 0).then(|| {
                let text = format!(
                    "the cut of tool `{tool}` cut nothing: in {} steps its blade went through no surface, or along an earlier cut within \
                     0.4 of a cell; move the path or make the blade longer",
                    tally.steps
                );
                (WarningCode::CutsNothing, text)
            });
        }
        let name = edit.kind.name();
        let running = self.tools.iter().any(|slot| slot.edit == Some(index) && slot.tool.changed_body);
        let has_changed = tally.has_changed || running;
        if tally.force == 0.0 && !has_changed {
            let text = format!(
                "the {name} of tool `{tool}` met nothing: the largest force in {} steps is 0 N; move the path towards a body",
                tally.steps
            );
            return Some((WarningCode::NoForce, text));
        }
        if edit.kind.changes_body() && !has_changed {
            let text = format!(
                "the {name} of tool `{tool}` touched a body and changed nothing of it in {} steps; give it a larger `radius`, a longer time, or \
                 something to act on",
                tally.steps
            );
            return Some((WarningCode::ChangesNothing, text));
        }
        let body = &self.bodies.get(tally.body? as usize)?.name;
        (!tally.is_shown && tally.depth > 0.0 && edit.kind.only_presses()).then(|| {
            let text = format!(
                "the {name} of tool `{tool}` pressed body `{body}` {:.3} mm deep and moved no vertex near the tool: its triangles are too \
                 large to show a dent; give the body `subdivide = \"auto\"`",
                1e3 * tally.depth
            );
            (WarningCode::MovesNoVertex, text)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_code_is_the_one_it_is_written_as() {
        use WarningCode::*;
        for code in [
            BodiesMeet,
            BodiesOverlap,
            CoarseSheet,
            CutsNothing,
            DoubtfulUnits,
            FixesNothing,
            MeetsNothing,
            NoForce,
            MovesNoVertex,
            OpenBody,
            PluginWarning,
            SmallRadius,
            SmoothIgnored,
            StartsInside,
        ] {
            assert_eq!(serde_json::to_value(code).unwrap(), code.name());
        }
    }
}
