//! The area that a blade sweeps during an edit, by which sheets are cut at its end: all layers at once, in the shape that they have then.

use super::body_stroke::travel;
use super::sweep::{Swept, between};
use crate::body::{Body, Discretization, LatticeError};
use pliant_cut::{Blade, Refused, Stroke};
use pliant_solver::Vec3;

/// Blades at the samples of a hand.
#[derive(Default)]
pub struct SweptArea {
    /// Blades at some distance from each other.
    blades: Vec<Blade>,
    /// The newest blade, where it is another one than the last of these.
    newest: Option<Blade>,
}

/// Distance from the last blade up to which one is left out unless it is the newest, in lengths of the blade.
const SPACING: f64 = 1e-3;
/// Distance from a strip within which a blade lies in it, in radii of the sheet.
const IN_STRIP: f64 = 1e-3;
/// Distance of an end of a blade outside of a sheet from the foot of its middle, in radii of the sheet: a strip between two blades that are turned by up to
/// 60 degrees against each other has the whole sheet between its ends.
const OUTSIDE: f64 = 2.0;
/// Least cosine between the two blades of a strip.
const LEAST_COSINE: f64 = 0.5;
/// Height of a triangle in the place of a strip, in radii of the sheet or distances of its far side; half of its base is twice as many radii.
const FAR: f64 = 4.0;
/// Length of its third side relative to the others: so short that nothing is between.
const POINT: f64 = 1e-8;
/// How many times a strip that is refused is halved.
const HALVINGS: u32 = 3;

impl SweptArea {
    /// Adds the blade at the next sample of a hand.
    pub fn add(&mut self, blade: Blade) {
        let spacing = SPACING * (blade.heel - blade.tip).norm();
        let is_far = self.blades.last().is_none_or(|last| travel(last, &blade) > spacing);
        if is_far {
            self.blades.push(blade);
        }
        self.newest = (!is_far).then_some(blade);
    }

    /// Forgets all blades.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Cuts a sheet by the area. Returns what was cut, and the last strip that the mesh refused. A sheet whose material refuses the cut
    /// elements is as it was.
    ///
    /// # Errors
    /// Returns the error of the material plugin.
    pub fn cut(&self, body: &mut Body) -> Result<(Swept, Option<Refused>), LatticeError> {
        let Discretization::Sheet(sheet) = &body.discretization else { return Ok(Default::default()) };
        let now = |(v, skin): (usize, &Vec3)| sheet.position(v as u32, &body.system.nodes).unwrap_or(*skin);
        let points: Vec<Vec3> = body.skin.x.iter().enumerate().map(now).collect();
        let ball = Around::of(&points);
        let blades: Vec<Reaching> = self.blades.iter().chain(&self.newest).map(|blade| ball.reaching(blade)).collect();
        let bends = straight_strips(&blades, IN_STRIP * ball.radius);
        let triangle = if let [from, to] = bends[..] { ball.triangle(&points, from, to) } else { None };
        let strips: Vec<Blade> = bends.iter().map(|bend| bend.blade).collect();
        let before = body.save();
        let mut cut = LayerCut { points, swept: Swept::default() };
        let result = match triangle.map(|triangle| cut.along(body, &triangle, 0)) {
            None | Some(Ok(Some(_))) => cut.along(body, &strips, HALVINGS),
            Some(done) => done,
        };
        if result.is_err() {
            body.restore(&before)?;
        }
        result.map(|refused| (cut.swept, refused))
    }
}

/// The ball around a sheet.
struct Around {
    centre: Vec3,
    /// m
    radius: f64,
}

/// A blade whose ends outside of a sheet are as far outside as straight strips need.
struct Reaching {
    blade: Blade,
    /// Tip and heel of the hand's blade, m.
    given: [Vec3; 2],
    /// Whether they are within the ball around the sheet.
    is_inside: [bool; 2],
    /// Whether it leads all through that ball, or past it from one end to the other.
    spans: bool,
}

impl Around {
    fn of(points: &[Vec3]) -> Self {
        let first = points.first().copied().unwrap_or_default();
        let [low, high] = points.iter().fold([first; 2], |[low, high], x| [low.inf(x), high.sup(x)]);
        Self { centre: low.lerp(&high, 0.5), radius: 0.5 * (high - low).norm() }
    }

    fn reaching(&self, blade: &Blade) -> Reaching {
        let (foot, along) = self.foot(blade);
        let given = [blade.tip, blade.heel];
        let is_inside = given.map(|end| (end - self.centre).norm() <= self.radius);
        let far = OUTSIDE * self.radius * along;
        // A blade whose end is outside may still point away from the sheet.
        let ends = [(0, -1.0), (1, 1.0)].map(|(end, side)| {
            let is_beyond = !is_inside[end] && side * (given[end] - foot).dot(&along) > 0.0;
            (if is_beyond { foot + side * far } else { given[end] }, is_beyond)
        });
        let [(tip, before), (heel, after)] = ends;
        Reaching { blade: Blade { tip, heel }, given, is_inside, spans: before && after }
    }

    /// The strip between two blades as one triangle: from one of them to a blade of hardly any length beyond the sheet, so that no side between two triangles
    /// goes through the sheet. `None` where neither blade is beside the sheet, or one does not span it. `points` are the vertices, m.
    fn triangle(&self, points: &[Vec3], from: &Reaching, to: &Reaching) -> Option<[Blade; 2]> {
        if !from.spans || !to.spans {
            return None;
        }
        [(from, to), (to, from)].into_iter().find_map(|(base, other)| {
            let [(foot, along), (end, _)] = [base, other].map(|of| self.foot(&of.blade));
            let across = (end - foot - (end - foot).dot(&along) * along).try_normalize(0.0)?;
            let edge = (other.blade.heel - other.blade.tip).normalize();
            let beyond = (across - across.dot(&edge) * edge).try_normalize(0.0)?;
            if points.iter().any(|x| (x - end).dot(&beyond) >= 0.0) {
                return None;
            }
            let height = FAR * self.radius.max((self.centre - foot).dot(&across) + self.radius);
            let half = 2.0 * FAR * self.radius * along;
            let (apex, point) = (foot + height * across, POINT * (height + half.norm()) * along);
            Some([Blade { tip: foot - half, heel: foot + half }, Blade { tip: apex - point, heel: apex + point }])
        })
    }

    /// The place on a blade's line that is nearest to the middle, and the unit vector from tip to heel.
    fn foot(&self, blade: &Blade) -> (Vec3, Vec3) {
        let along = (blade.heel - blade.tip).normalize();
        (blade.tip + (self.centre - blade.tip).dot(&along) * along, along)
    }
}

/// The blades between which straight strips lead past all of these within a distance (m). What goes back within the last strip is left out.
fn straight_strips(blades: &[Reaching], distance: f64) -> Vec<&Reaching> {
    let mut bends: Vec<usize> = blades.first().map(|_| 0).into_iter().collect();
    let mut last = 0;
    for next in 1..blades.len() {
        let &from = bends.last().expect("the first");
        let strip = |to: usize| [&blades[from], &blades[to]];
        if last > from && is_in_strip(strip(last), &blades[next], distance) {
            continue;
        }
        let is_straight = (from + 1..=last).all(|passed| is_in_strip(strip(next), &blades[passed], distance));
        if !is_straight {
            bends.push(last);
        }
        last = next;
    }
    if last > 0 {
        bends.push(last);
    }
    bends.into_iter().map(|at| &blades[at]).collect()
}

/// Whether the area between two blades contains a third one but for a distance (m). How far ends outside of the sheet reach does not matter.
fn is_in_strip([from, to]: [&Reaching; 2], passed: &Reaching, distance: f64) -> bool {
    let along = |of: &Reaching| (of.blade.heel - of.blade.tip).normalize();
    let middle = |of: &Reaching| of.blade.tip.lerp(&of.blade.heel, 0.5);
    let start = middle(from);
    let Some(normal) = along(from).cross(&(middle(to) - start)).try_normalize(0.0) else { return false };
    let is_in_plane = |x: Vec3| (x - start).dot(&normal).abs() <= distance;
    // Each end is between where it was and where it comes to. One within the sheet is on the straight way.
    let is_between = |end: usize| {
        let way = to.given[end] - from.given[end];
        let share = (passed.given[end] - from.given[end]).dot(&way) / way.norm_squared();
        let off_way = (from.given[end] + share * way - passed.given[end]).norm();
        way.norm() <= distance || (0.0..=1.0).contains(&share) && (!passed.is_inside[end] || off_way <= distance)
    };
    along(from).dot(&along(to)) >= LEAST_COSINE
        && [to, passed].into_iter().flat_map(|of| [of.blade.tip, of.blade.heel]).all(is_in_plane)
        && (0..2).all(is_between)
}

/// A cut through all layers of a sheet.
struct LayerCut {
    /// Positions of the vertices, m.
    points: Vec<Vec3>,
    swept: Swept,
}

impl LayerCut {
    /// Cuts from blade to blade, each time in up to two to the power of `halvings` strips. Returns why the mesh refuses the last one.
    fn along(&mut self, body: &mut Body, blades: &[Blade], halvings: u32) -> Result<Option<Refused>, LatticeError> {
        let Some((Ok(mut stroke), others)) =
            blades.split_first().map(|(first, others)| (Stroke::begin(*first), others))
        else {
            return Ok(None);
        };
        others.iter().try_fold(None, |_, to| self.sweep(body, &mut stroke, *to, halvings))
    }

    /// Cuts up to a blade.
    fn sweep(
        &mut self,
        body: &mut Body,
        stroke: &mut Stroke,
        to: Blade,
        halvings: u32,
    ) -> Result<Option<Refused>, LatticeError> {
        let Some(mesh) = &mut body.cut else { return Ok(None) };
        match mesh.advance_in_shape(&mut self.points, stroke, to) {
            Ok(advance) => self.swept.take(body, &advance).map(|()| None),
            Err(refused) if halvings == 0 => Ok(Some(refused)),
            Err(_) => {
                let middle = between(&stroke.blade(), &to, 0.5);
                self.sweep(body, stroke, middle, halvings - 1)?;
                self.sweep(body, stroke, to, halvings - 1)
            }
        }
    }
}
