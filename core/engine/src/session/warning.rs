//! Warnings: parts of a scene that have no effect, or probably an unintended one.
//!
//! Warnings about models and selections are found when the scene is opened; those about edits follow from their statistics, so
//! [`Session::warnings`] can be called at any time. A warning changes no result.

use super::Session;
use crate::body::Body;
use pliant_mesh::geometry::Vec3;
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
    /// An edit cut nothing.
    CutsNothing,
    /// A material finds elements of a body doubtful.
    DoubtfulElements,
    /// A tetrahedral mesh has something that its user may not expect.
    DoubtfulMesh,
    /// The scene gives no size of a model, and one metre per file unit does not fit the tool.
    DoubtfulUnits,
    /// The system gave no threads besides the first.
    FewerThreads,
    /// A `fixed` selects no node.
    FixesNothing,
    /// No body met an obstacle.
    MeetsNothing,
    /// A material takes fibre directions, and the scene gives none.
    NoFibres,
    /// The hand felt no force during an edit.
    NoForce,
    /// A touch pressed a body but moved none of its vertices.
    MovesNoVertex,
    /// Parts of models were to be files, and every model is in one part.
    OnePart,
    /// A blade cuts a body that is not closed and has no interior.
    OpenBody,
    /// A material gave a warning that is not about its elements.
    PluginWarning,
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
pub(super) struct EditTally {
    /// Number of steps in which it was active with a hand.
    steps: u64,
    /// Number of advances of its blade, in time spans that have ended.
    pub(super) advances: usize,
    /// Whether it has changed a body, in time spans that have ended.
    pub(super) has_changed: bool,
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
    pub(super) tallies: Vec<EditTally>,
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
}

impl Session {
    /// All warnings so far: first those of opening the scene, then those of edits and bodies; each code and location once.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut all = self.warnings.opening.clone();
        all.extend(self.warnings.overlaps.warnings.iter().cloned());
        all.extend(self.warn_materials());
        all.extend(self.unmet_obstacles());
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
            let told = [
                (WarningCode::DoubtfulElements, material.element_warning()),
                (WarningCode::PluginWarning, material.last_warning()),
            ];
            told.into_iter().filter_map(move |(code, text)| {
                let message = format!("material `{}` of body `{name}`: {}", material.name(), text?);
                Some(Warning { code, place: place.clone(), message })
            })
        })
    }

    /// A warning if the session runs on one thread because the system refused to create others.
    fn warn_threads(&self) -> Option<Warning> {
        let asked = self.workers.asked;
        self.workers.all.is_refused().then(|| Warning {
            code: WarningCode::FewerThreads,
            place: self.warnings.scene_file.clone(),
            message: format!(
                "the system gave no more threads, so the session runs on 1 instead of {asked} and takes longer; results are the same; \
                 ask for fewer with `--threads`, or raise the limit of processes (`ulimit -u`, `pids.max` of a container)"
            ),
        })
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
                    "the cut of tool `{tool}` cut nothing: in {} steps its blade went through no surface; move the path or make \
                     the blade longer",
                    tally.steps
                );
                (WarningCode::CutsNothing, text)
            });
        }
        let name = edit.kind.name();
        if tally.force == 0.0 && !edit.kind.changes_body() {
            let text = format!(
                "the {name} of tool `{tool}` met nothing: the largest force in {} steps is 0 N; move the path towards a body",
                tally.steps
            );
            return Some((WarningCode::NoForce, text));
        }
        let running = self.tools.iter().any(|slot| slot.edit == Some(index) && slot.tool.changed_body);
        if edit.kind.changes_body() && tally.force > 0.0 && !tally.has_changed && !running {
            let text = format!(
                "the {name} of tool `{tool}` touched a body and changed nothing of it in {} steps; give it a larger `radius`, a longer time, or \
                 something to act on",
                tally.steps
            );
            return Some((WarningCode::ChangesNothing, text));
        }
        let body = &self.bodies.get(tally.body? as usize)?.name;
        (!tally.is_shown && tally.depth > 0.0 && edit.kind.name() == "touch").then(|| {
            let text = format!(
                "the {name} of tool `{tool}` pressed body `{body}` {:.3} mm deep and moved no vertex near the tool: its triangles are too \
                 large to show a dent; give the body `subdivide = \"auto\"`",
                1e3 * tally.depth
            );
            (WarningCode::MovesNoVertex, text)
        })
    }

    /// Adds a step of a tool to the statistics of its edit; `force` (N) is the force on the hand.
    pub(super) fn tally(&mut self, tool: usize, force: f64) {
        let slot = &self.tools[tool];
        let Some(edit) = slot.edit.filter(|_| slot.hand.present) else { return };
        let tally = &mut self.warnings.tallies[edit];
        tally.steps += 1;
        tally.force = tally.force.max(force);
        let Some(touch) = slot.tool.proxy.touch.filter(|_| slot.tool.depth > tally.depth) else { return };
        let body = &self.bodies[touch.body as usize];
        if body.discretization.lattice().is_none() {
            return;
        }
        (tally.depth, tally.body) = (slot.tool.depth, Some(touch.body));
        if tally.is_shown {
            return;
        }
        let Ok(centre) = body.embed_point(touch.rest).map(|point| point.settled) else { return };
        let (model, least) = (&body.model, MIN_VISIBLE * tally.depth);
        let mut is_shown = false;
        body.skin.tree.near(centre, slot.tool.proxy.shape.extra_region_radius(), |triangle| {
            for v in model.surface.triangles[triangle as usize] {
                let moved = || body.embed_point(model.surface.points[v as usize]);
                is_shown = is_shown || moved().is_ok_and(|p| (p.now - p.settled).norm() >= least);
            }
        });
        self.warnings.tallies[edit].is_shown = is_shown;
    }
}

/// An axis-aligned box of a body, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extents {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
}

impl Extents {
    /// The smallest box that contains `points` and `self`.
    fn with<'a>(self, points: impl Iterator<Item = &'a Vec3>) -> Self {
        points.fold(self, |all, p| Self { min: all.min.inf(p), max: all.max.sup(p) })
    }

    /// Whether the interiors of two boxes intersect.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|i| self.min[i].max(other.min[i]) < self.max[i].min(other.max[i]))
    }
}

/// A body of the scene, as tracked by [`OverlapDetection`].
pub(super) struct Extended {
    pub(super) name: String,
    /// Location in the scene.
    pub(super) place: String,
    /// Index among the moving bodies; `None` if it does not move.
    pub(super) moving: Option<usize>,
    /// Bounding box of the rest shape, m.
    pub(super) rest: Extents,
    /// Bounding box at the last test, m.
    pub(super) extents: Extents,
    /// Bounding box at the test before the last one, m.
    pub(super) before: Extents,
}

/// The present bounding box of a body: its box at rest, with each face displaced like the outermost nodes. The box of the nodes of a lattice would be too
/// large, because cells extend beyond the surface.
fn moved_extents(body: &Body, rest: Extents) -> Extents {
    let (x, at_rest) = (&body.system.nodes.x, &body.system.nodes.rest);
    let (Some(now), Some(before)) = (x.first(), at_rest.first()) else { return rest };
    let now = Extents { min: *now, max: *now }.with(x.iter());
    let before = Extents { min: *before, max: *before }.with(at_rest.iter());
    let moved = Extents { min: rest.min + now.min - before.min, max: rest.max + now.max - before.max };
    // Outside of a local region the body is at rest.
    if body.discretization.is_whole() { moved } else { rest.with([moved.min, moved.max].iter()) }
}

/// Why two bodies do not meet.
const WHY: &str = "not both have `meets = true`";

/// Number of steps between tests of the boxes; the boxes are swept over that interval.
const TEST_INTERVAL: u64 = 16;

/// Detection of bodies whose bounding boxes begin to overlap.
#[derive(Default)]
pub(super) struct OverlapDetection {
    bodies: Vec<Extended>,
    /// Pairs that are known to overlap.
    known: Vec<[usize; 2]>,
    warnings: Vec<Warning>,
}

impl OverlapDetection {
    /// Starts with the bodies of a scene, in its order, and returns the warnings for those that overlap. Two moving bodies for which `is_handled` holds are left out:
    /// they meet, or a warning says that they do not.
    pub(super) fn new(bodies: Vec<Extended>, is_handled: impl Fn(usize, usize) -> bool) -> (Self, Vec<Warning>) {
        let mut known = Vec::new();
        for (j, b) in bodies.iter().enumerate() {
            let meets = |a: &Extended| matches!((a.moving, b.moving), (Some(a), Some(b)) if is_handled(a, b));
            known.extend((0..j).filter(|i| meets(&bodies[*i])).map(|i| [i, j]));
        }
        let mut meetings = Self { bodies, known, ..Self::default() };
        let at_start = meetings.test(WarningCode::BodiesOverlap, 0.0);
        (meetings, at_start)
    }

    /// Warnings for pairs whose swept boxes overlap now for the first time.
    fn test(&mut self, code: WarningCode, time: f64) -> Vec<Warning> {
        let swept = |i: usize| {
            let Extended { extents, before, .. } = &self.bodies[i];
            extents.with([before.min, before.max].iter())
        };
        let mut found = Vec::new();
        for j in 0..self.bodies.len() {
            for i in 0..j {
                if self.known.contains(&[i, j]) || !swept(i).overlaps(&swept(j)) {
                    continue;
                }
                self.known.push([i, j]);
                let [a, b] = [&self.bodies[i], &self.bodies[j]];
                let message = match code {
                    WarningCode::BodiesOverlap => format!(
                        "the boxes of bodies `{}` and `{}` overlap at the start, and {WHY}, so they pass through each other; let both meet (`meets = true`), move one \
                         of them, or make them one model",
                        a.name, b.name
                    ),
                    _ => format!(
                        "the boxes of bodies `{}` and `{}` came together by {time:.4} s, and {WHY}, so they pass through each other; let both meet (`meets = true`)",
                        a.name, b.name
                    ),
                };
                found.push(Warning { code, place: b.place.clone(), message });
            }
        }
        found
    }
}

impl Session {
    /// Tests whether boxes have begun to overlap since the last test.
    pub(super) fn detect_overlaps(&mut self) {
        let count = self.warnings.overlaps.bodies.len();
        if count < 2
            || !self.clock.steps.is_multiple_of(TEST_INTERVAL)
            || self.warnings.overlaps.known.len() == count * (count - 1) / 2
        {
            return;
        }
        for extended in &mut self.warnings.overlaps.bodies {
            extended.before = extended.extents;
            let Some(body) = extended.moving.and_then(|index| self.bodies.get(index)) else { continue };
            extended.extents = moved_extents(body, extended.rest);
        }
        let time = self.time();
        let found = self.warnings.overlaps.test(WarningCode::BodiesMeet, time);
        self.warnings.overlaps.warnings.extend(found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(name: &str, at: f64) -> Extended {
        let extents = Extents { min: Vec3::repeat(at), max: Vec3::repeat(at + 1.0) };
        Extended { name: name.into(), place: name.into(), moving: None, rest: extents, extents, before: extents }
    }

    #[test]
    fn touching_boxes_do_not_overlap_and_a_pair_is_reported_once() {
        let (mut meetings, told) =
            OverlapDetection::new(vec![body("a", 0.0), body("b", 1.0), body("c", 1.5)], |_, _| false);
        assert_eq!(told.len(), 1, "b and c alone: {told:?}");
        // It sweeps over both others between two tests.
        meetings.bodies[0].extents = body("a", 9.0).extents;
        assert_eq!(meetings.test(WarningCode::BodiesMeet, 0.1).len(), 2);
        assert!(meetings.test(WarningCode::BodiesMeet, 0.2).is_empty());
    }

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
            SmoothIgnored,
            StartsInside,
        ] {
            assert_eq!(serde_json::to_value(code).unwrap(), code.name());
        }
    }
}
