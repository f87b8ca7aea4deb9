//! Warnings: parts of a scene that are used and have no effect, or not the one they look like.
//!
//! Those that models and selections give are found when the scene is opened; those of edits follow from what each edit has come to, so
//! [`Session::warnings`] can be asked at any time. A warning changes no result.

use super::Session;
use crate::body::Body;
use pliant_mesh::geometry::Vec3;
use serde::Serialize;
use std::fmt;

/// What a warning is about; docs/warnings.md lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WarningCode {
    /// Boxes of two bodies came together during the run: bodies do not meet each other.
    BodiesMeet,
    /// Boxes of two bodies overlap at the start: bodies do not meet each other.
    BodiesOverlap,
    /// An edit cut nothing.
    CutsNothing,
    /// No size is given, and a metre for a unit of the file does not suit the tool.
    DoubtfulUnits,
    /// A `fixed` that holds no node.
    FixesNothing,
    /// An edit in which the hand felt no force.
    NoForce,
    /// A touch that pressed a body and moved none of its vertices.
    MovesNoVertex,
    /// A blade meets a body that is not closed, so what it cuts has no inside.
    OpenBody,
}

impl WarningCode {
    /// The code as files and messages have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::BodiesMeet => "bodies-meet",
            Self::BodiesOverlap => "bodies-overlap",
            Self::CutsNothing => "cuts-nothing",
            Self::DoubtfulUnits => "doubtful-units",
            Self::FixesNothing => "fixes-nothing",
            Self::NoForce => "no-force",
            Self::MovesNoVertex => "moves-no-vertex",
            Self::OpenBody => "open-body",
        }
    }
}

/// A part of the scene that has no effect, or not the one it looks like.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// What it is about.
    pub code: WarningCode,
    /// Where in the scene: file, line and column, or the file alone where the line is a default.
    #[serde(rename = "where")]
    pub place: String,
    /// What was found, and what to do.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}] {}: {}", self.code.name(), self.place, self.message)
    }
}

/// What an edit has come to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EditTally {
    /// Steps it was under way with a hand.
    steps: u64,
    /// Advances of its blade, of spans that have ended.
    pub(super) advances: usize,
    /// N, largest force
    force: f64,
    /// m, largest depth on a body that a lattice carries
    depth: f64,
    /// Whether a vertex followed the surface there.
    is_shown: bool,
    /// The body it pressed.
    body: Option<u32>,
}

/// Share of the depth of a dent that a vertex near the tool must follow for the mesh to show the dent.
const SHOWN: f64 = 0.05;

impl Session {
    /// Warnings so far: those of opening the scene first, then those of edits and bodies, each code and place once.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut all = self.opening_warnings.clone();
        all.extend(self.meetings.warnings.iter().cloned());
        for (index, (edit, tally)) in self.plan.edits.iter().zip(&self.tallies).enumerate() {
            let Some((code, message)) = self.judge_edit(index, *tally) else { continue };
            if !all.iter().any(|known| known.code == code && known.place == edit.place) {
                all.push(Warning { code, place: edit.place.clone(), message });
            }
        }
        all
    }

    /// What is wrong with what an edit has come to.
    fn judge_edit(&self, index: usize, tally: EditTally) -> Option<(WarningCode, String)> {
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
        if tally.force == 0.0 && !edit.kind.changes_rest_shape() {
            let text = format!(
                "the {name} of tool `{tool}` met nothing: the largest force in {} steps is 0 N; move the path towards a body",
                tally.steps
            );
            return Some((WarningCode::NoForce, text));
        }
        let body = &self.bodies.get(tally.body? as usize)?.name;
        (!tally.is_shown && tally.depth > 0.0 && edit.kind.name() == "touch").then(|| {
            let text = format!(
                "the {name} of tool `{tool}` pressed body `{body}` {:.3} mm deep and moved no vertex near the tool: its triangles are too \
                 large to show a dent; subdivide the model before it is used",
                1e3 * tally.depth
            );
            (WarningCode::MovesNoVertex, text)
        })
    }

    /// Adds a step of a tool to the tally of its edit; `force` (N) is what the hand feels.
    pub(super) fn tally(&mut self, tool: usize, force: f64) {
        let slot = &self.tools[tool];
        let Some(edit) = slot.edit.filter(|_| slot.hand.present) else { return };
        let tally = &mut self.tallies[edit];
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
        let Ok((_, centre)) = body.embed_point(touch.rest) else { return };
        let (model, least) = (&body.model, SHOWN * tally.depth);
        let mut is_shown = false;
        body.skin.tree.near(centre, slot.tool.proxy.shape.extra_region_radius(), |triangle| {
            for v in model.surface.triangles[triangle as usize] {
                let moved = || body.embed_point(model.surface.points[v as usize]);
                is_shown = is_shown || moved().is_ok_and(|(now, settled)| (now - settled).norm() >= least);
            }
        });
        self.tallies[edit].is_shown = is_shown;
    }
}

/// An axis-aligned box of a body, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extents {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
}

impl Extents {
    /// The smallest that has all of `points` and of `self`.
    fn with<'a>(self, points: impl Iterator<Item = &'a Vec3>) -> Self {
        points.fold(self, |all, p| Self { min: all.min.inf(p), max: all.max.sup(p) })
    }

    /// Whether the insides of two boxes have a point in common.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|i| self.min[i].max(other.min[i]) < self.max[i].min(other.max[i]))
    }
}

/// A body of the scene, as [`Meetings`] follows it.
pub(super) struct Extended {
    pub(super) name: String,
    /// Where the scene has it.
    pub(super) place: String,
    /// Its index among the bodies that move.
    pub(super) moving: Option<usize>,
    /// m, its box in the rest shape
    pub(super) rest: Extents,
    /// m, its box when it was last looked at
    pub(super) extents: Extents,
    /// m, its box at the look before that
    pub(super) before: Extents,
}

/// The box of a body now: its box at rest, each face moved as the outermost nodes there have. Cells of a lattice reach beyond the surface, so
/// the box of the nodes themselves is too large.
fn moved_extents(body: &Body, rest: Extents) -> Extents {
    let (x, at_rest) = (&body.system.nodes.x, &body.system.nodes.rest);
    let (Some(now), Some(before)) = (x.first(), at_rest.first()) else { return rest };
    let now = Extents { min: *now, max: *now }.with(x.iter());
    let before = Extents { min: *before, max: *before }.with(at_rest.iter());
    let moved = Extents { min: rest.min + now.min - before.min, max: rest.max + now.max - before.max };
    // Of a local region only a part has nodes; the rest of the body stays.
    if body.discretization.is_whole() { moved } else { rest.with([moved.min, moved.max].iter()) }
}

/// Steps between two looks at the boxes; what a box sweeps over between them counts too.
const LOOK_EVERY: u64 = 16;

/// Which bodies have come together, by their boxes.
#[derive(Default)]
pub(super) struct Meetings {
    bodies: Vec<Extended>,
    /// Pairs that are known to be together.
    known: Vec<[usize; 2]>,
    warnings: Vec<Warning>,
}

impl Meetings {
    /// Begins with the bodies of a scene, in its order; gives the warnings of those that overlap.
    pub(super) fn new(bodies: Vec<Extended>) -> (Self, Vec<Warning>) {
        let mut meetings = Self { bodies, ..Self::default() };
        let at_start = meetings.look(WarningCode::BodiesOverlap, 0.0);
        (meetings, at_start)
    }

    /// Warnings of pairs whose swept boxes overlap now and did not before.
    fn look(&mut self, code: WarningCode, time: f64) -> Vec<Warning> {
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
                        "the boxes of bodies `{}` and `{}` overlap at the start: bodies meet tools and not each other, so they pass through \
                         each other; move one of them, or make them one model",
                        a.name, b.name
                    ),
                    _ => format!(
                        "the boxes of bodies `{}` and `{}` came together by {time:.4} s: bodies meet tools and not each other, so they \
                         pass through each other",
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
    /// Looks whether bodies have come together since the last look.
    pub(super) fn watch_meetings(&mut self) {
        let count = self.meetings.bodies.len();
        if count < 2 || !self.steps.is_multiple_of(LOOK_EVERY) || self.meetings.known.len() == count * (count - 1) / 2 {
            return;
        }
        for extended in &mut self.meetings.bodies {
            extended.before = extended.extents;
            let Some(body) = extended.moving.and_then(|index| self.bodies.get(index)) else { continue };
            extended.extents = moved_extents(body, extended.rest);
        }
        let time = self.time();
        let found = self.meetings.look(WarningCode::BodiesMeet, time);
        self.meetings.warnings.extend(found);
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
    fn boxes_that_touch_do_not_overlap_and_a_pair_is_told_once() {
        let (mut meetings, told) = Meetings::new(vec![body("a", 0.0), body("b", 1.0), body("c", 1.5)]);
        assert_eq!(told.len(), 1, "b and c alone: {told:?}");
        // It passes over both others between two looks.
        meetings.bodies[0].extents = body("a", 9.0).extents;
        assert_eq!(meetings.look(WarningCode::BodiesMeet, 0.1).len(), 2);
        assert!(meetings.look(WarningCode::BodiesMeet, 0.2).is_empty());
    }

    #[test]
    fn the_name_of_a_code_is_the_one_it_is_written_as() {
        use WarningCode::*;
        for code in
            [BodiesMeet, BodiesOverlap, CutsNothing, DoubtfulUnits, FixesNothing, NoForce, MovesNoVertex, OpenBody]
        {
            assert_eq!(serde_json::to_value(code).unwrap(), code.name());
        }
    }
}
