//! Edits that let the shape at rest flow under a tool that touches: what smooth, flatten, pinch, relax, grow and shrink share.
//!
//! The tool touches the body and feels it, as in a touch; while it does, the shape at rest around the contact moves with a velocity
//! that a [`Flow`] says, times the falloff. Velocities of surface points go to the nodes of their cells as weighted means, and inwards as
//! a harmonic function, so cells do not turn over; what a cell is too coarse for is left to the points themselves. The present shape follows
//! by the material's own forces.

use super::brush::{Brush, BrushShape};
use super::touch::Touching;
use super::{Action, ContactPlace, EmbeddedPlace, Step};
use crate::body::{Body, Discretization, LatticeError, Model, RestChange, Skin};
use crate::plan::Edit;
use crate::tool::Tool;
use nalgebra::UnitQuaternion;
use pliant_solver::Vec3;

/// s, between two changes of the shape at rest: rest data of every active element are made anew each time.
const INTERVAL: f64 = 8e-3;
/// Share of the way to its goal that a point goes in one change, at most: beyond a half, fairing no longer converges.
const MOST_SHARE: f64 = 0.5;
/// Rounds of the harmonic extension into the body.
const ROUNDS: usize = 12;

/// What a flow is told about the place it acts at.
pub(super) struct Place<'a> {
    /// m, the contact in the shape at rest
    pub centre: Vec3,
    /// Axes of the hand.
    pub hand: UnitQuaternion<f64>,
    /// Vertices of the region with their weights.
    pub vertices: &'a [(u32, f64)],
    /// Model of the body.
    pub model: &'a Model,
    /// Surface of the body.
    pub skin: &'a Skin,
}

impl Place<'_> {
    /// m, a vertex in the shape at rest
    pub fn at(&self, vertex: u32) -> Vec3 {
        self.skin.settled[vertex as usize]
    }

    /// m^2, the area of the triangles around a vertex, along its normal, in the shape at rest
    pub fn area(&self, vertex: u32) -> Vec3 {
        self.model.area_around(vertex, &self.skin.settled)
    }

    /// Unit normal of the region, by area and weight; z where it has none.
    pub fn normal(&self) -> Vec3 {
        let sum: Vec3 = self.vertices.iter().map(|&(v, weight)| weight * self.area(v)).sum();
        sum.try_normalize(0.0).unwrap_or_else(Vec3::z)
    }
}

/// How the shape at rest moves.
pub(super) enum Flow {
    /// m, the way of every vertex of the region to its goal; a vertex that has none stays.
    Surface(fn(&Place<'_>) -> Vec<Vec3>),
    /// m, the way of every node of the region to its goal.
    Nodes(fn(&Brush, &Body) -> Vec<Vec3>),
}

/// A flow under way.
pub(super) struct Flowing {
    shape: BrushShape,
    /// 1/s
    rate: f64,
    flow: Flow,
    touching: Touching,
    brush: Brush,
    change: RestChange,
    /// s, since the last change
    waited: f64,
}

impl Flowing {
    /// As an edit asks for it, with a rate of `default` (1/s) where it says nothing.
    pub fn begin(edit: &Edit, tool: &Tool, default: f64, flow: Flow) -> Box<dyn Action> {
        Box::new(Self {
            shape: BrushShape::of(edit, tool),
            rate: edit.strength.unwrap_or(default),
            flow,
            touching: Touching,
            brush: Brush::default(),
            change: RestChange::default(),
            waited: 0.0,
        })
    }

    /// Lets the shape at rest of a body flow around a place for `seconds`.
    fn flow(
        &mut self,
        body: &mut Body,
        at: Vec3,
        hand: UnitQuaternion<f64>,
        seconds: f64,
    ) -> Result<bool, LatticeError> {
        self.brush.cover(body, at, self.shape)?;
        if self.brush.is_empty() {
            return Ok(false);
        }
        let share = self.rate * seconds;
        // A goal is approached exponentially; implicitly, so no rate passes it.
        let share = (share / (1.0 + share)).min(MOST_SHARE);
        self.change.clear(body.system.nodes.len());
        match self.flow {
            Flow::Nodes(ways) => {
                let ways = ways(&self.brush, body);
                for ((&n, weight), way) in self.brush.nodes.iter().zip(&self.brush.weight).zip(ways) {
                    self.change.nodes[n as usize] = share * weight * way;
                }
            }
            Flow::Surface(ways) => self.flow_surface(body, at, hand, ways, share)?,
        }
        body.reshape(&mut self.change)?;
        Ok(true)
    }

    fn flow_surface(
        &mut self,
        body: &mut Body,
        at: Vec3,
        hand: UnitQuaternion<f64>,
        ways: fn(&Place<'_>) -> Vec<Vec3>,
        share: f64,
    ) -> Result<(), LatticeError> {
        let radius = self.shape.radius_at(body.discretization.edge());
        let centre = body.embed_point(at)?.1;
        let vertices = self.brush.vertices(body, centre, radius, self.shape.falloff)?;
        let place = Place { centre, hand, vertices: &vertices, model: &body.model, skin: &body.skin };
        let ways = ways(&place);
        let moves: Vec<(u32, Vec3)> =
            vertices.iter().zip(ways).map(|(&(v, weight), way)| (v, share * weight * way)).collect();
        spread(&self.brush, &moves, body, &mut self.change)
    }
}

/// Sets the change of the nodes that makes the surface points move, and what is left to the points.
fn spread(brush: &Brush, moves: &[(u32, Vec3)], body: &mut Body, change: &mut RestChange) -> Result<(), LatticeError> {
    let Body { discretization, model, .. } = body;
    let lattice = match discretization {
        Discretization::Sheet(sheet) => {
            moves.iter().for_each(|(v, d)| change.nodes[sheet.node_of(*v) as usize] = *d);
            return Ok(());
        }
        Discretization::Lattice(lattice) => lattice,
    };
    let count = change.nodes.len();
    let mut covered = vec![false; count];
    brush.nodes.iter().for_each(|n| covered[*n as usize] = true);
    let cells = &lattice.region().cell_corners;
    let near: Vec<(u32, [u32; 8])> =
        brush.cells(lattice).into_iter().map(|cell| (cell, cells[cell as usize])).collect();
    let mut total = vec![0.0; count];
    let find = |v: u32| moves.binary_search_by_key(&v, |(of, _)| *of).ok().map(|at| moves[at].1);
    for (cell, corners) in &near {
        let (points, weights) = lattice.weighted_points(*cell, model)?;
        for (&v, weights) in points.iter().zip(weights) {
            let d = find(v).unwrap_or_else(Vec3::zeros);
            for (&n, w) in corners.iter().zip(weights) {
                change.nodes[n as usize] += *w * d;
                total[n as usize] += *w;
            }
        }
    }
    let on_surface: Vec<bool> = total.iter().map(|t| *t > 0.0).collect();
    for (n, d) in change.nodes.iter_mut().enumerate() {
        *d = if on_surface[n] && covered[n] { *d / total[n] } else { Vec3::zeros() };
    }
    for _ in 0..ROUNDS {
        let (mut sums, mut counts) = (vec![Vec3::zeros(); count], vec![0.0; count]);
        for (_, corners) in &near {
            let mean = corners.iter().map(|n| change.nodes[*n as usize]).sum::<Vec3>() / 8.0;
            for &n in corners.iter().filter(|n| covered[**n as usize] && !on_surface[**n as usize]) {
                sums[n as usize] += mean;
                counts[n as usize] += 1.0;
            }
        }
        for n in (0..count).filter(|n| counts[*n] > 0.0) {
            change.nodes[n] = sums[n] / counts[n];
        }
    }
    for (cell, corners) in &near {
        let (points, weights) = lattice.weighted_points(*cell, model)?;
        for (&v, weights) in points.iter().zip(weights) {
            let Some(wanted) = find(v) else { continue };
            let carried: Vec3 = corners.iter().zip(weights).map(|(&n, w)| *w * change.nodes[n as usize]).sum();
            change.points.push((v, wanted - carried));
        }
    }
    Ok(())
}

impl Action for Flowing {
    fn contact(&self, tool: &Tool) -> Option<ContactPlace> {
        self.touching.contact(tool)
    }

    fn extra_radius(&self, edge: f64) -> f64 {
        self.shape.radius_at(edge)
    }

    fn is_fingertip(&self) -> bool {
        true
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPlace>,
    ) -> Result<(), LatticeError> {
        self.touching.follow(tool, step, contact)?;
        self.waited += step.time.dt;
        if self.waited < INTERVAL {
            return Ok(());
        }
        let seconds = std::mem::take(&mut self.waited);
        let at = match tool.proxy.touch {
            Some(touch) => Some(ContactPlace { body: touch.body, rest: touch.rest }),
            None => tool.sheet_below(step.bodies),
        };
        let Some(at) = at else { return Ok(()) };
        let body = &mut step.bodies[at.body as usize];
        tool.reshaped |= self.flow(body, at.rest, step.hand.rotation, seconds)?;
        Ok(())
    }
}
