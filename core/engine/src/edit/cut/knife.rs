//! A knife: a straight edge that cuts bodies.
//!
//! The resistance to cutting is that of Griffith (1920): the fracture energy per area times the area the last advance cut per distance. The
//! blade moves forward only if the coupling pulls with more than this force, so it lags behind the hand by the force over the coupling's
//! stiffness. It moves freely through air and backwards through what it has cut; the cut faces constrain it sideways. It cuts in its heading
//! only: a blade that is drawn back and pushed in again continues where it stopped. The reaction acts on the body just ahead of the part of
//! the edge that is inside.

use super::SheetLayers;
use super::body_stroke::{BodyStroke, travel};
use super::cut_step::{AdvanceError, Advanced, CutStep};
use super::rest_blade::BladeLine;
use super::sweep::{SweepTarget, Swept};
use super::swept_area::SweptArea;
use crate::body::{Body, Discretization, Lattice, LatticeError};
use crate::tool::Hand;
use nalgebra::{Matrix3, UnitQuaternion};
use pliant_cut::Blade;
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

impl BladeEdge {
    /// The edge in a hand with this position (m) and rotation.
    fn at(&self, position: Vec3, rotation: UnitQuaternion<f64>) -> Blade {
        Blade { tip: position, heel: position + self.length * (rotation * self.direction) }
    }
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
    /// For every body: the swept area in it (b).
    pub(super) strokes: Vec<Option<BodyStroke>>,
    /// Unit vector of the cutting direction; `None` before the first cut.
    pub heading: Option<Vec3>,
    /// Whether it has been drawn back from where it stopped cutting.
    retracted: bool,
    /// Whether it has taken its first step since it was lifted.
    has_begun: bool,
    /// The area that it sweeps, if that cuts all layers of sheets at the end.
    area: Option<SweptArea>,
}

/// The part of a blade inside of a body.
#[derive(Clone, Debug)]
pub struct Inside {
    /// Index of the body.
    pub body: u32,
    /// Points along the edge, from tip to heel, in the rest shape, m (k x 3).
    pub points: Vec<Vec3>,
    /// The tip minus the mean displacement of the material ahead of the edge, m; for a sheet, the tip minus the intersection of blade and sheet.
    pub tip: Vec3,
    /// Unit vector of the cutting direction when these points were found; `None` before the first cut.
    heading: Option<Vec3>,
    /// Rotation from the rest shape to the current shape.
    pub rotation: Matrix3<f64>,
}

impl Inside {
    /// Mean displacement of the material just ahead of the edge, on which the hand's pull acts, m; `None` if none is there.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    fn displacement(&self, body: &Body, lattice: &Lattice) -> Result<Option<Vec3>, LatticeError> {
        let (mut sum, mut count) = (Vec3::zeros(), 0.0);
        for point in &self.points {
            let ahead = self.ahead(*point, self.heading, lattice.edge());
            if let Some(moved) = lattice.displacement_at(ahead, &body.system.nodes)? {
                (sum, count) = (sum + moved, count + 1.0);
            }
        }
        Ok((count > 0.0).then(|| sum / count))
    }

    /// Moves a point of the rest shape ahead of the edge by one stride, to where nothing is cut yet. `point` and the cell `edge` are in m.
    pub fn ahead(&self, point: Vec3, heading: Option<Vec3>, edge: f64) -> Vec3 {
        heading.map_or(point, |heading| point + STRIDE * edge * (self.rotation.transpose() * heading))
    }
}

/// Distance between advances, in cell edges: one voxel of a cut cell.
pub const STRIDE: f64 = 0.25;
/// Volume below which a part is a crumb, in cells: a lattice has no part of its own for less.
const CRUMB: f64 = 0.5;
/// Distance over which the heading turns to a new direction, m.
const TURN_LENGTH: f64 = 5e-3;

impl Knife {
    /// A knife in no body, in a scene with `bodies` bodies.
    pub fn new(edge: BladeEdge, bodies: usize, layers: SheetLayers) -> Self {
        let strokes = (0..bodies).map(|_| None).collect();
        Self {
            edge,
            tip: Vec3::zeros(),
            inside: None,
            resistance: 0.0,
            strokes,
            heading: None,
            retracted: false,
            has_begun: false,
            area: (layers == SheetLayers::All).then(SweptArea::default),
        }
    }

    /// Ends all strokes; the next cut begins a new one.
    pub fn lift(&mut self) {
        self.leave();
        self.has_begun = false;
        self.strokes.fill_with(|| None);
        self.area.iter_mut().for_each(SweptArea::clear);
    }

    /// The blade is in no body, and goes with the hand. What it sweeps goes on from there.
    pub(super) fn leave(&mut self) {
        (self.inside, self.resistance, self.heading, self.retracted) = (None, 0.0, None, false);
    }

    /// Moves the blade with the hand and cuts. `stiffness` (N/m) is that of the coupling; `last` advances by the unfinished stride too, and
    /// finishes what was drawn.
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
        if !std::mem::replace(&mut self.has_begun, true) {
            self.begin(hand, bodies)?;
        }
        let mut step = self.cut_to_hand(hand, stiffness, bodies, last)?;
        if last {
            self.finish(hand, stiffness, bodies, &mut step)?;
        }
        self.area.iter_mut().for_each(|area| area.add(self.edge.at(hand.position, hand.rotation)));
        Ok(step)
    }

    /// Cuts all layers of sheets by the area that the blade has swept, if that is asked for: at the end of the edit, whether or not the hand is still there.
    ///
    /// # Errors
    /// Returns the error of the material plugin.
    pub fn cut_layers(&self, bodies: &mut [Body], step: &mut CutStep) -> Result<(), LatticeError> {
        let Some(area) = &self.area else { return Ok(()) };
        for (index, body) in bodies.iter_mut().enumerate() {
            if body.cut.is_none() || body.frozen.is_some() || body.discretization.sheet().is_none() {
                continue;
            }
            let (swept, refused) = area.cut(body)?;
            step.advances += usize::from(swept.has_cut);
            step.length += swept.length;
            step.refused = refused.map(|refused| (index, refused)).or(step.refused);
        }
        Ok(())
    }

    /// Begins the swept area where the hand was in the step before: a button is pressed somewhere between two samples, and a fast hand goes far
    /// from one to the next.
    fn begin(&mut self, hand: &Hand, bodies: &[Body]) -> Result<(), LatticeError> {
        let Some(before) = hand.before else { return Ok(()) };
        self.tip = before.position;
        self.area.iter_mut().for_each(|area| area.add(self.edge.at(before.position, before.rotation)));
        let line = self.line(&(before.rotation * self.edge.direction));
        for (stroke, body) in self.strokes.iter_mut().zip(bodies) {
            if body.cut.is_some()
                && body.discretization.lattice().is_some()
                && let Some(rest) = line.at_rest(body, None, false)?
            {
                *stroke = BodyStroke::begin(rest.blade, body).ok();
            }
        }
        Ok(())
    }

    /// The edge in the direction `along`, from the tip to the heel.
    pub(super) fn line(&self, along: &Vec3) -> BladeLine {
        BladeLine { tip: self.tip, along: *along, length: self.edge.length }
    }

    fn cut_to_hand(
        &mut self,
        hand: &Hand,
        stiffness: f64,
        bodies: &mut [Body],
        last: bool,
    ) -> Result<CutStep, LatticeError> {
        let along = hand.rotation * self.edge.direction;
        self.move_with_body(bodies)?;
        self.pull(hand, &along, stiffness);
        let mut step = CutStep::default();
        let was = self.inside.take();
        let (mut resistance, mut waits) = (None, false);
        for (index, body) in bodies.iter_mut().enumerate() {
            let is_swept = self.area.is_some() && body.discretization.sheet().is_some();
            if body.cut.is_none() || body.frozen.is_some() || is_swept {
                continue;
            }
            let last_point = was.as_ref().filter(|i| i.body as usize == index).map(|i| i.points[0]);
            let Some(rest) = self.line(&along).at_rest(body, last_point, self.heading.is_some())? else {
                self.strokes[index] = None;
                continue;
            };
            if rest.in_gap {
                waits = true;
                continue;
            }
            let (blade, rotation) = (rest.blade, rest.rotation);
            if self.inside.is_none() && !rest.points.is_empty() {
                let (body_index, heading) = (index as u32, self.heading);
                let mut inside = Inside { body: body_index, points: rest.points, tip: rest.tip, heading, rotation };
                if let Some(lattice) = body.discretization.lattice()
                    && let Some(moved) = inside.displacement(body, lattice)?
                {
                    inside.tip = self.tip - moved;
                }
                self.inside = Some(inside);
            }
            // When the blade leaves a body, no later advance would cut the unfinished stride.
            let leaves = self.heading.is_some() && self.inside.is_none();
            let advanced = self.advance(index, RotatedBlade { blade, rotation }, body, last || leaves);
            if let Some(force) = step.add(index, advanced)? {
                resistance = Some(resistance.unwrap_or(0.0_f64).max(force));
            }
        }
        if self.inside.is_some() {
            self.resistance = resistance.unwrap_or(self.resistance);
        } else if self.heading.is_some() && !waits {
            for (stroke, body) in self.strokes.iter_mut().zip(&*bodies) {
                // A sheet is met in another place next time, which may be one of another layer.
                if body.discretization.sheet().is_some() {
                    *stroke = None;
                }
                // Drawn back, the blade has gone where it had cut.
                if self.retracted {
                    *stroke = stroke.as_ref().and_then(|stroke| BodyStroke::begin(stroke.mapped, body).ok());
                }
            }
            self.leave();
        }
        Ok(step)
    }

    /// Moves the tip with the body that the blade is in. The ends of the blade may be outside: it is what is inside that carries it.
    fn move_with_body(&mut self, bodies: &[Body]) -> Result<(), LatticeError> {
        let (Some(inside), Some(_)) = (&self.inside, self.heading) else { return Ok(()) };
        let body = &bodies[inside.body as usize];
        if let Some(lattice) = body.discretization.lattice()
            && let Some(moved) = inside.displacement(body, lattice)?
        {
            self.tip = inside.tip + moved;
        }
        if let Discretization::Sheet(_) = &body.discretization {
            self.tip = body.embed_point(inside.points[0])?.now + inside.tip;
        }
        Ok(())
    }

    /// Moves the tip towards the hand, against the cutting resistance.
    pub(super) fn pull(&mut self, hand: &Hand, along: &Vec3, stiffness: f64) {
        let (Some(_), Some(heading)) = (&self.inside, self.heading) else {
            self.tip = hand.position;
            return;
        };
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
    }

    /// Cuts up to the blade if it has moved by a stride since the last attempt, or at all if `last` is set. `None` if it has not.
    pub(super) fn advance(
        &mut self,
        index: usize,
        blade: RotatedBlade,
        body: &mut Body,
        last: bool,
    ) -> Result<Option<Advanced>, AdvanceError> {
        let RotatedBlade { blade, rotation } = blade;
        let Some(stroke) = &mut self.strokes[index] else {
            self.strokes[index] = Some(BodyStroke::begin(blade, body).map_err(AdvanceError::Refused)?);
            return Ok(None);
        };
        stroke.mapped = blade;
        let stride = STRIDE * body.discretization.edge();
        let before = stroke.stroke.blade();
        let heading = self.heading.map(|heading| rotation.transpose() * heading);
        if let Some(heading) = heading {
            let progress = stroke.middle.way(&before, &blade).dot(&heading);
            self.retracted = progress < -0.5 * stride;
            if progress <= 0.0 {
                return Ok(None);
            }
        }
        if !stroke.is_due(&blade, stride, last) {
            return Ok(None);
        }
        stroke.tried = blade;
        let target = SweepTarget { blade, stride, heading: heading.unwrap_or_default(), last };
        stroke.begin_section(body);
        let Some(swept) = stroke.sweep(body, &target)? else {
            // The mesh has refused it for now.
            stroke.note_refusal(&before);
            return Ok(None);
        };
        let distance = travel(&before, &stroke.stroke.blade());
        if swept.has_cut {
            stroke.extend_section(body, &blade);
            stroke.way += distance;
            self.heading = self.heading.or_else(|| (rotation * stroke.middle.way(&before, &blade)).try_normalize(0.0));
        }
        let Swept { area, length, has_cut } = swept;
        let energy = if area > 0.0 { self.edge.toughness * area } else { self.edge.tear * length };
        let force = if distance > 0.0 { energy / distance } else { 0.0 };
        Ok(Some(Advanced { force, area, length, has_cut }))
    }
}

/// Volume below which a part is a crumb, m^3, where advances have a distance of `stride` (m).
pub(super) fn crumb_volume(stride: f64) -> f64 {
    CRUMB * (stride / STRIDE).powi(3)
}

/// A blade mapped to the rest shape.
pub(super) struct RotatedBlade {
    pub blade: Blade,
    /// Rotation from the rest shape to the current shape, at the blade.
    pub rotation: Matrix3<f64>,
}
