//! A knife: a straight edge that cuts what it is moved through.
//!
//! The material holds the edge until the hand pulls with more than it takes to make new surface (Griffith 1920): energy of
//! an area of cut, times how much area the last advance made on its way. So the blade lags behind the hand by that force
//! over the stiffness of the coupling, moves freely through air and back through what it has cut, and is held sideways by the
//! faces it has parted. It cuts ahead only: one that is drawn back and pushed in again goes on where it stopped. What the
//! hand feels the body feels too, just ahead of the part of the edge that is inside.

use super::meeting::Meeting;
use crate::body::{Body, Discretization, Lattice, LatticeError};
use crate::tool::Hand;
use nalgebra::Matrix3;
use pliant_cut::{Blade, Refused, Stroke};
use pliant_solver::Vec3;

/// What a blade is.
#[derive(Clone, Debug)]
pub struct BladeEdge {
    /// m
    pub length: f64,
    /// Unit, from tip to heel, in the axes of the hand.
    pub direction: Vec3,
    /// J/m^2, of a new area of cut inside of a closed body
    pub toughness: f64,
    /// N, energy of a length of new edge of an open surface
    pub tear: f64,
}

/// A blade in use.
pub struct Knife {
    /// What it is.
    pub edge: BladeEdge,
    /// m, where its tip is held
    pub tip: Vec3,
    /// Places of one body it is in.
    pub inside: Option<Inside>,
    /// N, against moving on
    pub resistance: f64,
    /// In every body, and where the blade was when an advance was last tried
    strokes: Vec<Option<(Stroke, Blade)>>,
    /// Unit, which way it cuts
    pub heading: Option<Vec3>,
    /// Drawn back from where it stopped cutting.
    back: bool,
}

/// Where a blade is inside of a body.
#[derive(Clone, Debug)]
pub struct Inside {
    /// Index of the body.
    pub body: u32,
    /// m, rest places along the edge
    pub places: Vec<Vec3>,
    /// m, rest place of the tip, or on a sheet where the tip is from the place the blade goes through
    tip: Vec3,
    /// From the rest shape to now.
    turn: Matrix3<f64>,
}

impl Inside {
    /// m, a rest place along the edge, a little ahead of it: where nothing is cut yet
    pub fn ahead(&self, place: Vec3, heading: Option<Vec3>, edge: f64) -> Vec3 {
        heading.map_or(place, |heading| place + STRIDE * edge * (self.turn.transpose() * heading))
    }
}

/// What one step of cutting did.
#[derive(Clone, Copy, Debug, Default)]
pub struct CutStep {
    /// Advances that changed a mesh.
    pub advances: usize,
    /// m^2, of new cut surface
    pub area: f64,
    /// m, of new edge
    pub length: f64,
    /// An advance that was not made, and of which body.
    pub refused: Option<(usize, Refused)>,
}

/// Places looked at along the edge.
pub(super) const PLACES: usize = 9;
/// The blade is advanced when it has moved by this share of a cell's edge: a voxel of a cut cell.
const STRIDE: f64 = 0.25;
/// Strides it may be behind before a refused cut is given up and begun anew.
const PATIENCE: f64 = 4.0;
/// m, over which it turns into a new direction
const TURN: f64 = 5e-3;
/// Edges of a cell by which the last of them may still differ.
const STRAY: f64 = 0.05;
/// Fixed-point iterations from a deformed to a rest place.
const INVERSIONS: usize = 6;

impl Knife {
    /// In the air, in a scene of `bodies`.
    pub fn new(edge: BladeEdge, bodies: usize) -> Self {
        let strokes = (0..bodies).map(|_| None).collect();
        Self { edge, tip: Vec3::zeros(), inside: None, resistance: 0.0, strokes, heading: None, back: false }
    }

    /// Out of everything; the next cut begins anew.
    pub fn lift(&mut self) {
        (self.inside, self.resistance, self.heading, self.back) = (None, 0.0, None, false);
        self.strokes.fill_with(|| None);
    }

    /// Moves the blade with the hand and cuts; `stiffness` (N/m) is that of the coupling, `last` makes it cut what is left of
    /// a stride.
    ///
    /// # Errors
    /// What a grid says.
    pub fn cut(
        &mut self,
        hand: &Hand,
        stiffness: f64,
        bodies: &mut [Body],
        last: bool,
    ) -> Result<CutStep, LatticeError> {
        let along = hand.rotation * self.edge.direction;
        self.follow(hand, &along, stiffness, bodies)?;
        let mut step = CutStep::default();
        let was = self.inside.take();
        let (mut resistance, mut waits) = (None, false);
        for (index, body) in bodies.iter_mut().enumerate() {
            if body.cut.is_none() || body.frozen.is_some() {
                continue;
            }
            let last_place = was.as_ref().filter(|i| i.body as usize == index).map(|i| i.places[0]);
            let Some(seen) = self.at_rest(&along, body, last_place)? else {
                self.strokes[index] = None;
                continue;
            };
            if seen.in_gap {
                waits = true;
                continue;
            }
            let (blade, turn) = (seen.blade, seen.turn);
            if self.inside.is_none() && !seen.places.is_empty() {
                self.inside = Some(Inside { body: index as u32, places: seen.places, tip: seen.tip, turn });
            }
            // What is left of a stride when the blade leaves a sheet is not cut by a later one.
            let leaves = self.heading.is_some() && self.inside.is_none() && body.discretization.sheet().is_some();
            match self.advance(index, TurnedBlade { blade, turn }, body, last || leaves) {
                Ok(None) => {}
                Ok(Some(advanced)) => {
                    step.advances += usize::from(advanced.has_cut);
                    step.area += advanced.area;
                    step.length += advanced.length;
                    resistance = Some(resistance.unwrap_or(0.0_f64).max(advanced.force));
                }
                Err(Stopped::Refused(refused)) => step.refused = Some((index, refused)),
                Err(Stopped::Failed(error)) => return Err(error),
            }
        }
        if self.inside.is_some() {
            self.resistance = resistance.unwrap_or(self.resistance);
        } else if self.heading.is_some() && !waits {
            self.lift();
        }
        Ok(step)
    }

    /// Takes the tip where the hand pulls it and the material lets it.
    fn follow(&mut self, hand: &Hand, along: &Vec3, stiffness: f64, bodies: &[Body]) -> Result<(), LatticeError> {
        let (Some(inside), Some(heading)) = (&self.inside, self.heading) else {
            self.tip = hand.position;
            return Ok(());
        };
        let body = &bodies[inside.body as usize];
        if let Some(lattice) = body.discretization.lattice()
            && let Some(moved) = lattice.carried_by(inside.tip, &body.system.nodes)?
        {
            self.tip = inside.tip + moved;
        }
        if let Discretization::Sheet(_) = &body.discretization {
            let (now, _) = body.embed_point(inside.places[0])?;
            self.tip = now + inside.tip;
        }
        let gap = hand.position - self.tip;
        let slide = gap.dot(along) * along;
        let across = gap - slide;
        let heading = (heading - heading.dot(along) * along).try_normalize(1e-9).unwrap_or(heading);
        let ahead = across.dot(&heading);
        let held = if self.back { 0.0 } else { self.resistance / stiffness };
        let free = if ahead > 0.0 { (ahead - held).max(0.0) } else { ahead };
        let mut moved = slide + free * heading;
        if self.resistance == 0.0 {
            moved += across - ahead * heading;
        }
        self.tip += moved;
        let turned = heading.lerp(&across.try_normalize(0.0).unwrap_or(heading), (free / TURN).clamp(0.0, 1.0));
        self.heading = turned.try_normalize(0.0).filter(|_| free > 0.0).or(Some(heading));
        Ok(())
    }

    /// The blade in the rest shape of a body, and rest places along it that are inside of its cells, or where it goes through a
    /// sheet. A place in the gap between parts that have moved away is in neither. `None` far from a sheet.
    fn at_rest(&self, along: &Vec3, body: &Body, last: Option<Vec3>) -> Result<Option<Seen>, LatticeError> {
        let mut places = Vec::new();
        let heel = self.tip + self.edge.length * along;
        let lattice = match &body.discretization {
            Discretization::Lattice(lattice) => lattice,
            Discretization::Sheet(sheet) => {
                let Some(met) = Meeting::find(self.tip, heel, body, sheet, last) else { return Ok(None) };
                let (now, _) = body.embed_point(met.place)?;
                let tip = self.tip - now;
                let places = if met.through { vec![met.place] } else { places };
                return Ok(Some(Seen { blade: met.blade, places, tip, in_gap: met.in_gap, turn: met.turn }));
            }
        };
        let (mut first, mut last, mut drift) = (None, Vec3::zeros(), None);
        for i in 0..PLACES {
            let s = self.edge.length * i as f64 / (PLACES - 1) as f64;
            let now = self.tip + s * along;
            // A body that has gone far is where its nodes are on the whole.
            let mut moved = rest_of(now, now, lattice, body)?;
            if moved.is_none() && lattice.is_whole() {
                let drift = *drift.get_or_insert_with(|| mean_displacement(lattice, body));
                moved = rest_of(now, now - drift, lattice, body)?;
            }
            let place = moved.map_or(now, |u| now - u);
            if let Some(u) = moved {
                first.get_or_insert(u);
                last = u;
            }
            if lattice.part_at(place)?.is_some() {
                places.push(place);
            }
        }
        let blade = Blade { tip: self.tip - first.unwrap_or_default(), heel: heel - last };
        Ok(Some(Seen { blade, places, tip: blade.tip, in_gap: false, turn: Matrix3::identity() }))
    }

    /// Cuts up to where the blade is, if it has gone far enough.
    fn advance(
        &mut self,
        index: usize,
        blade: TurnedBlade,
        body: &mut Body,
        last: bool,
    ) -> Result<Option<Advanced>, Stopped> {
        let TurnedBlade { blade, turn } = blade;
        let at_rest = |heading: Vec3| turn.transpose() * heading;
        let Some((stroke, tried)) = &mut self.strokes[index] else {
            self.strokes[index] = Some((Stroke::begin(blade).map_err(Stopped::Refused)?, blade));
            return Ok(None);
        };
        let stride = STRIDE * body.discretization.edge();
        if let Some(heading) = self.heading {
            let gone = ahead(&stroke.blade(), &blade, &at_rest(heading));
            self.back = gone < -0.5 * stride;
            if gone <= 0.0 {
                return Ok(None);
            }
        }
        let due = way(tried, &blade) >= stride || (last && way(&stroke.blade(), &blade) > 0.0);
        if !due {
            return Ok(None);
        }
        // A sheet can only be taken back as a whole, should its material not take the pieces.
        let state = body.discretization.sheet().is_some().then(|| body.save());
        let Some(mesh) = &mut body.cut else { return Ok(None) };
        *tried = blade;
        let before = stroke.blade();
        let heading = self.heading.map_or_else(Vec3::zeros, at_rest);
        let advance = mesh.advance(stroke, blade).or_else(|refused| {
            // Where it cannot go on from the very edge of its own slit, it starts a little behind, and else where it is.
            let step = -0.2 * stride * heading;
            let behind = Blade { tip: before.tip + step, heel: before.heel + step };
            let mut again = Stroke::begin(behind)?;
            let advance = mesh.advance(&mut again, blade);
            if advance.is_ok() || way(&before, &blade) > PATIENCE * stride {
                *stroke = if advance.is_ok() { again } else { Stroke::begin(blade)? };
            }
            advance.map_err(|_| refused)
        });
        let advance = advance.map_err(Stopped::Refused)?;
        let way = way(&before, &blade);
        let force =
            if advance.area > 0.0 { self.edge.toughness * advance.area } else { self.edge.tear * advance.length };
        let has_cut = advance.has_cut();
        if has_cut {
            self.heading = self.heading.or_else(|| (turn * middle_way(&before, &blade)).try_normalize(0.0));
            if let Err(error) = body.take_cut(&advance) {
                if let Some(state) = state {
                    body.restore(&state).map_err(Stopped::Failed)?;
                }
                return Err(Stopped::Failed(error));
            }
        }
        let force = if way > 0.0 { force / way } else { 0.0 };
        Ok(Some(Advanced { force, area: advance.area, length: advance.length, has_cut }))
    }
}

/// m, how far the body has moved what is now at a place, sought from a rest place on; `None` in the air.
fn rest_of(now: Vec3, from: Vec3, lattice: &Lattice, body: &Body) -> Result<Option<Vec3>, LatticeError> {
    let (mut place, mut moved, mut gap) = (from, None, f64::INFINITY);
    for _ in 0..INVERSIONS {
        let Some(u) = lattice.carried_by(place, &body.system.nodes)? else { break };
        let before: Option<Vec3> = moved.replace(u);
        place = now - u;
        gap = before.map_or(gap, |before| (u - before).iter().fold(0.0, |g, c| g.max(c.abs())));
    }
    Ok(moved.filter(|_| gap <= STRAY * lattice.edge()))
}

fn mean_displacement(lattice: &Lattice, body: &Body) -> Vec3 {
    let (nodes, rest) = (&body.system.nodes, &lattice.region().node_rest);
    let sum: Vec3 = nodes.x.iter().zip(rest).map(|(x, rest)| x - Vec3::from(*rest)).sum();
    sum / nodes.len().max(1) as f64
}

/// A blade in the rest shape of a body.
struct Seen {
    blade: Blade,
    places: Vec<Vec3>,
    tip: Vec3,
    /// Of a sheet: the stroke waits at its end until the blade goes through the sheet again.
    in_gap: bool,
    turn: Matrix3<f64>,
}

/// A blade brought back to the rest shape.
struct TurnedBlade {
    blade: Blade,
    /// Rotation from the rest shape to the present one, where the blade is
    turn: Matrix3<f64>,
}

/// An advance that was made.
struct Advanced {
    /// N
    force: f64,
    area: f64,
    length: f64,
    has_cut: bool,
}

/// One that was not.
enum Stopped {
    Refused(Refused),
    Failed(LatticeError),
}

/// m, how far the middle of a blade has gone in a direction
fn ahead(from: &Blade, to: &Blade, heading: &Vec3) -> f64 {
    middle_way(from, to).dot(heading)
}

fn middle_way(from: &Blade, to: &Blade) -> Vec3 {
    let middle = |blade: &Blade| blade.tip.lerp(&blade.heel, 0.5);
    middle(to) - middle(from)
}

/// m, how far the end of a blade that went further has gone.
fn way(from: &Blade, to: &Blade) -> f64 {
    let moved = |a: Vec3, b: Vec3| (b - a).norm();
    moved(from.tip, to.tip).max(moved(from.heel, to.heel))
}
