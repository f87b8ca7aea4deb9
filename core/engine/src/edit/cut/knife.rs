//! A knife: a straight edge that cuts bodies.
//!
//! The resistance to cutting is that of Griffith (1920): the fracture energy per area times the area the last advance cut per distance. The
//! blade moves forward only if the coupling pulls with more than this force, so it lags behind the hand by the force over the coupling's
//! stiffness. It moves freely through air and backwards through what it has cut; the cut faces constrain it sideways. It cuts in its heading
//! only: a blade that is drawn back and pushed in again continues where it stopped. The reaction acts on the body just ahead of the part of
//! the edge that is inside.

use super::sheet_intersection::SheetIntersection;
use crate::body::{Body, Discretization, Lattice, LatticeError};
use crate::tool::Hand;
use nalgebra::Matrix3;
use pliant_cut::{Blade, Refused, Stroke};
use pliant_solver::Vec3;

/// Geometry and fracture energies of a blade.
#[derive(Clone, Debug)]
pub struct BladeEdge {
    /// Length of the edge, from tip to heel, m.
    pub length: f64,
    /// Unit vector from tip to heel, in axes of the hand.
    pub direction: Vec3,
    /// Fracture energy per cut area of a solid, J/m^2.
    pub toughness: f64,
    /// Fracture energy per cut length of a sheet, N (J/m).
    pub tear: f64,
}

/// A blade in use.
pub struct Knife {
    /// Geometry and fracture energies.
    pub edge: BladeEdge,
    /// Position of the tip, m.
    pub tip: Vec3,
    /// The part of the edge inside of the first body it is in.
    pub inside: Option<Inside>,
    /// Cutting resistance, N.
    pub resistance: f64,
    /// For every body: its stroke, and the blade at the last attempt to advance (b).
    strokes: Vec<Option<(Stroke, Blade)>>,
    /// Unit vector of the cutting direction; `None` before the first cut.
    pub heading: Option<Vec3>,
    /// Whether it has been drawn back from where it stopped cutting.
    retracted: bool,
}

/// The part of a blade inside of a body.
#[derive(Clone, Debug)]
pub struct Inside {
    /// Index of the body.
    pub body: u32,
    /// Points along the edge, from tip to heel, in the rest shape, m (k x 3).
    pub points: Vec<Vec3>,
    /// Position of the tip in the rest shape, m; for a sheet, the tip minus the intersection of blade and sheet.
    tip: Vec3,
    /// Rotation from the rest shape to the current shape.
    rotation: Matrix3<f64>,
}

impl Inside {
    /// Moves a point of the rest shape ahead of the edge by one stride, to where nothing is cut yet. `point` and the cell `edge` are in m.
    pub fn ahead(&self, point: Vec3, heading: Option<Vec3>, edge: f64) -> Vec3 {
        heading.map_or(point, |heading| point + STRIDE * edge * (self.rotation.transpose() * heading))
    }
}

/// Result of one step of cutting.
#[derive(Clone, Copy, Debug, Default)]
pub struct CutStep {
    /// Number of advances that changed a mesh.
    pub advances: usize,
    /// Cut area of solids, m^2.
    pub area: f64,
    /// Cut length of sheets, m.
    pub length: f64,
    /// The last refused advance, with the index of its body.
    pub refused: Option<(usize, Refused)>,
}

/// Number of sample points along the edge.
pub(super) const SAMPLES: usize = 9;
/// Distance between advances, in cell edges: one voxel of a cut cell.
const STRIDE: f64 = 0.25;
/// Distance from the last advance, in strides, up to which a refused cut waits for the blade to move on.
const WAIT_STRIDES: f64 = 3.0;
/// Distance from the last advance, in strides, from which a refused cut is begun again at the present position.
const RESTART_STRIDES: f64 = 4.0;
/// Distance over which the heading turns to a new direction, m.
const TURN_LENGTH: f64 = 5e-3;
/// Largest last change of the fixed-point iteration, in cell edges.
const INVERSION_TOLERANCE: f64 = 0.05;
/// Fixed-point iterations from a current to a rest position.
const INVERSION_ITERATIONS: usize = 6;

impl Knife {
    /// A knife in no body, in a scene with `bodies` bodies.
    pub fn new(edge: BladeEdge, bodies: usize) -> Self {
        let strokes = (0..bodies).map(|_| None).collect();
        Self { edge, tip: Vec3::zeros(), inside: None, resistance: 0.0, strokes, heading: None, retracted: false }
    }

    /// Ends all strokes; the next cut begins a new one.
    pub fn lift(&mut self) {
        (self.inside, self.resistance, self.heading, self.retracted) = (None, 0.0, None, false);
        self.strokes.fill_with(|| None);
    }

    /// Moves the blade with the hand and cuts. `stiffness` (N/m) is that of the coupling; `last` advances by the unfinished stride too.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn cut(
        &mut self,
        hand: &Hand,
        stiffness: f64,
        bodies: &mut [Body],
        last: bool,
    ) -> Result<CutStep, LatticeError> {
        // Bodies that were split are more than at the beginning of the edit.
        self.strokes.resize_with(bodies.len(), || None);
        let along = hand.rotation * self.edge.direction;
        self.follow(hand, &along, stiffness, bodies)?;
        let mut step = CutStep::default();
        let was = self.inside.take();
        let (mut resistance, mut waits) = (None, false);
        for (index, body) in bodies.iter_mut().enumerate() {
            if body.cut.is_none() || body.frozen.is_some() {
                continue;
            }
            let last_point = was.as_ref().filter(|i| i.body as usize == index).map(|i| i.points[0]);
            let Some(rest) = self.at_rest(&along, body, last_point)? else {
                self.strokes[index] = None;
                continue;
            };
            if rest.in_gap {
                waits = true;
                continue;
            }
            let (blade, rotation) = (rest.blade, rest.rotation);
            if self.inside.is_none() && !rest.points.is_empty() {
                self.inside = Some(Inside { body: index as u32, points: rest.points, tip: rest.tip, rotation });
            }
            // When the blade leaves a body, no later advance would cut the unfinished stride.
            let leaves = self.heading.is_some() && self.inside.is_none();
            match self.advance(index, RotatedBlade { blade, rotation }, body, last || leaves) {
                Ok(None) => {}
                Ok(Some(advanced)) => {
                    step.advances += usize::from(advanced.has_cut);
                    step.area += advanced.area;
                    step.length += advanced.length;
                    resistance = Some(resistance.unwrap_or(0.0_f64).max(advanced.force));
                }
                Err(AdvanceError::Refused(refused)) => step.refused = Some((index, refused)),
                Err(AdvanceError::Failed(error)) => return Err(error),
            }
        }
        if self.inside.is_some() {
            self.resistance = resistance.unwrap_or(self.resistance);
        } else if self.heading.is_some() && !waits {
            self.lift();
        }
        Ok(step)
    }

    /// Moves the tip with the body and then towards the hand, against the cutting resistance.
    fn follow(&mut self, hand: &Hand, along: &Vec3, stiffness: f64, bodies: &[Body]) -> Result<(), LatticeError> {
        let (Some(inside), Some(heading)) = (&self.inside, self.heading) else {
            self.tip = hand.position;
            return Ok(());
        };
        let body = &bodies[inside.body as usize];
        if let Some(lattice) = body.discretization.lattice()
            && let Some(moved) = lattice.displacement_at(inside.tip, &body.system.nodes)?
        {
            self.tip = inside.tip + moved;
        }
        if let Discretization::Sheet(_) = &body.discretization {
            self.tip = body.embed_point(inside.points[0])?.now + inside.tip;
        }
        let gap = hand.position - self.tip;
        let slide = gap.dot(along) * along;
        let across = gap - slide;
        let heading = (heading - heading.dot(along) * along).try_normalize(1e-9).unwrap_or(heading);
        let ahead = across.dot(&heading);
        let held = if self.retracted { 0.0 } else { self.resistance / stiffness };
        let free = if ahead > 0.0 { (ahead - held).max(0.0) } else { ahead };
        let mut moved = slide + free * heading;
        if self.resistance == 0.0 {
            moved += across - ahead * heading;
        }
        self.tip += moved;
        let turned = heading.lerp(&across.try_normalize(0.0).unwrap_or(heading), (free / TURN_LENGTH).clamp(0.0, 1.0));
        self.heading = turned.try_normalize(0.0).filter(|_| free > 0.0).or(Some(heading));
        Ok(())
    }

    /// The blade in the rest shape of a body, with the sample points inside of its cells or the intersection with a sheet. Points in the gap
    /// between separated parts are inside of neither. `None` far from a sheet.
    fn at_rest(&self, along: &Vec3, body: &Body, last: Option<Vec3>) -> Result<Option<RestBlade>, LatticeError> {
        let mut points = Vec::new();
        let heel = self.tip + self.edge.length * along;
        let lattice = match &body.discretization {
            Discretization::Lattice(lattice) => lattice,
            Discretization::Sheet(sheet) => {
                let Some(met) = SheetIntersection::find(self.tip, heel, body, sheet, last) else { return Ok(None) };
                let tip = self.tip - body.embed_point(met.point)?.now;
                let points = if met.intersects { vec![met.point] } else { points };
                return Ok(Some(RestBlade {
                    blade: met.blade,
                    points,
                    tip,
                    in_gap: met.in_gap,
                    rotation: met.rotation,
                }));
            }
        };
        let (mut first, mut last, mut drift) = (None, Vec3::zeros(), None);
        for i in 0..SAMPLES {
            let s = self.edge.length * i as f64 / (SAMPLES - 1) as f64;
            let now = self.tip + s * along;
            // For a body that has moved far, the iteration starts from the mean displacement of its nodes.
            let mut moved = displacement_at(now, now, lattice, body)?;
            if moved.is_none() && lattice.is_whole() {
                let drift = *drift.get_or_insert_with(|| mean_displacement(lattice, body));
                moved = displacement_at(now, now - drift, lattice, body)?;
            }
            let point = moved.map_or(now, |u| now - u);
            if let Some(u) = moved {
                first.get_or_insert(u);
                last = u;
            }
            if lattice.is_occupied(point)? {
                points.push(point);
            }
        }
        let blade = Blade { tip: self.tip - first.unwrap_or_default(), heel: heel - last };
        Ok(Some(RestBlade { blade, points, tip: blade.tip, in_gap: false, rotation: Matrix3::identity() }))
    }

    /// Cuts up to the blade if it has moved by a stride since the last attempt, or at all if `last` is set. `None` if it has not.
    fn advance(
        &mut self,
        index: usize,
        blade: RotatedBlade,
        body: &mut Body,
        last: bool,
    ) -> Result<Option<Advanced>, AdvanceError> {
        let RotatedBlade { blade, rotation } = blade;
        let at_rest = |heading: Vec3| rotation.transpose() * heading;
        let Some((stroke, tried)) = &mut self.strokes[index] else {
            self.strokes[index] = Some((Stroke::begin(blade).map_err(AdvanceError::Refused)?, blade));
            return Ok(None);
        };
        let stride = STRIDE * body.discretization.edge();
        if let Some(heading) = self.heading {
            let progress = ahead(&stroke.blade(), &blade, &at_rest(heading));
            self.retracted = progress < -0.5 * stride;
            if progress <= 0.0 {
                return Ok(None);
            }
        }
        let is_due = travel(tried, &blade) >= stride || (last && travel(&stroke.blade(), &blade) > 0.0);
        if !is_due {
            return Ok(None);
        }
        // If the material of a sheet refuses the cut elements, the whole sheet is restored.
        let state = body.discretization.sheet().is_some().then(|| body.save());
        let Some(mesh) = &mut body.cut else { return Ok(None) };
        *tried = blade;
        let before = stroke.blade();
        let heading = self.heading.map_or_else(Vec3::zeros, at_rest);
        let advance = match mesh.advance(stroke, blade) {
            // A longer strip is often cut where this one would leave a sliver. A new stroke is beside the old one where the blade turns, and leaves a
            // neck between them.
            Err(_) if !last && travel(&before, &blade) < WAIT_STRIDES * stride => return Ok(None),
            advance => advance,
        };
        let advance = advance.or_else(|refused| {
            // If the stroke cannot continue from the end of its own cut, a new stroke starts 0.2 strides behind it, and if that fails too, at
            // the present position.
            let behind = before.moved(-0.2 * stride * heading);
            let mut again = Stroke::begin(behind)?;
            let advance = mesh.advance(&mut again, blade);
            if advance.is_ok() || travel(&before, &blade) > RESTART_STRIDES * stride {
                *stroke = if advance.is_ok() { again } else { Stroke::begin(blade)? };
            }
            advance.map_err(|_| refused)
        });
        let advance = advance.map_err(AdvanceError::Refused)?;
        let distance = travel(&before, &blade);
        let energy =
            if advance.area > 0.0 { self.edge.toughness * advance.area } else { self.edge.tear * advance.length };
        let has_cut = advance.has_cut();
        if has_cut {
            self.heading =
                self.heading.or_else(|| (rotation * midpoint_displacement(&before, &blade)).try_normalize(0.0));
            if let Err(error) = body.take_cut(&advance) {
                if let Some(state) = state {
                    body.restore(&state).map_err(AdvanceError::Failed)?;
                }
                return Err(AdvanceError::Failed(error));
            }
        }
        let force = if distance > 0.0 { energy / distance } else { 0.0 };
        Ok(Some(Advanced { force, area: advance.area, length: advance.length, has_cut }))
    }
}

/// Displacement of the material that is now at the position `now`, m, by fixed-point iteration from the rest position `from` (both in m); `None`
/// if there is no material.
fn displacement_at(now: Vec3, from: Vec3, lattice: &Lattice, body: &Body) -> Result<Option<Vec3>, LatticeError> {
    let (mut point, mut moved, mut gap) = (from, None, f64::INFINITY);
    for _ in 0..INVERSION_ITERATIONS {
        let Some(u) = lattice.displacement_at(point, &body.system.nodes)? else { break };
        let before: Option<Vec3> = moved.replace(u);
        point = now - u;
        gap = before.map_or(gap, |before| (u - before).iter().fold(0.0, |g, c| g.max(c.abs())));
    }
    Ok(moved.filter(|_| gap <= INVERSION_TOLERANCE * lattice.edge()))
}

/// Mean displacement of the nodes, m.
fn mean_displacement(lattice: &Lattice, body: &Body) -> Vec3 {
    let (nodes, rest) = (&body.system.nodes, &lattice.region().node_rest);
    let sum: Vec3 = nodes.x.iter().zip(rest).map(|(x, rest)| x - Vec3::from(*rest)).sum();
    sum / nodes.len().max(1) as f64
}

/// A blade in the rest shape of a body. Fields are those of [`Inside`].
struct RestBlade {
    blade: Blade,
    points: Vec<Vec3>,
    tip: Vec3,
    /// Whether the blade is in the gap of a cut sheet; the stroke then waits until the blade intersects the sheet again.
    in_gap: bool,
    rotation: Matrix3<f64>,
}

/// A blade mapped to the rest shape.
struct RotatedBlade {
    blade: Blade,
    /// Rotation from the rest shape to the current shape, at the blade.
    rotation: Matrix3<f64>,
}

/// A successful advance.
struct Advanced {
    /// Cutting resistance, N.
    force: f64,
    /// Cut area, m^2.
    area: f64,
    /// Cut length, m.
    length: f64,
    /// Whether the mesh changed.
    has_cut: bool,
}

/// Why an advance failed.
enum AdvanceError {
    /// The mesh refused it and is unchanged.
    Refused(Refused),
    /// A plugin failed.
    Failed(LatticeError),
}

/// Displacement of the midpoint of a blade along a unit vector, m.
fn ahead(from: &Blade, to: &Blade, heading: &Vec3) -> f64 {
    midpoint_displacement(from, to).dot(heading)
}

/// Displacement of the midpoint of a blade, m.
fn midpoint_displacement(from: &Blade, to: &Blade) -> Vec3 {
    let midpoint = |blade: &Blade| blade.tip.lerp(&blade.heel, 0.5);
    midpoint(to) - midpoint(from)
}

/// Larger one of the distances that the two ends of a blade have moved, m.
fn travel(from: &Blade, to: &Blade) -> f64 {
    let moved = |a: Vec3, b: Vec3| (b - a).norm();
    moved(from.tip, to.tip).max(moved(from.heel, to.heel))
}
