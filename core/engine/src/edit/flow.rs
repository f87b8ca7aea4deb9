//! Plastic flow of the rest shape under a touching tool: the common part of smooth, flatten, pinch, relax, grow and shrink.
//!
//! The tool touches the body as in the edit `touch`. Meanwhile the rest shape around the contact moves towards its goal, given by a
//! [`GoalDisplacement`] of goal displacements, at a rate times the falloff. Displacements of surface points are transferred to the nodes of their cells as weighted
//! means and extended to the interior as a harmonic function, so that cells do not invert; the remainder that cells are too coarse for is added to
//! the surface points. The current shape follows by the elastic forces.

use super::brush::{Brush, BrushShape};
use super::touch_stroke::{BodyChange, ChangingTouch, Due};
use super::{Action, Step};
use crate::body::{Body, Discretization, LatticeError, Model, Moves, RestChange, Skin, Unresolved, limit_folds};
use crate::contact::normal_of;
use crate::plan::Edit;
use crate::tool::Tool;
use nalgebra::UnitQuaternion;
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// Largest fraction of the goal displacement in one change: above 1/2 fairing does not converge.
const MAX_FRACTION: f64 = 0.5;
/// Jacobi sweeps of the harmonic extension into the interior.
const EXTENSION_SWEEPS: usize = 12;

/// The surface region under the brush.
pub(super) struct BrushRegion<'a> {
    /// Contact point in the rest shape, m.
    pub centre: Vec3,
    /// Rotation from axes of the hand to those of the scene.
    pub hand: UnitQuaternion<f64>,
    /// Vertices of the region with their falloff, ascending.
    pub vertices: &'a [(u32, f64)],
    /// Model of the body.
    pub model: &'a Model,
    /// Surface of the body.
    pub skin: &'a Skin,
}

impl BrushRegion<'_> {
    /// Rest position of a vertex, m.
    pub fn rest(&self, vertex: u32) -> Vec3 {
        self.skin.settled[vertex as usize]
    }

    /// Sum of the area vectors of the triangles around a vertex in the rest shape, m^2.
    pub fn area(&self, vertex: u32) -> Vec3 {
        self.model.area_around(vertex, &self.skin.settled)
    }

    /// Unit mean normal of the region, weighted by area and falloff; z if it is undefined.
    pub fn normal(&self) -> Vec3 {
        let sum: Vec3 = self.vertices.iter().map(|&(v, weight)| weight * self.area(v)).sum();
        sum.try_normalize(0.0).unwrap_or_else(Vec3::z)
    }

    /// Whether each vertex (k) is on the side that is touched: less than 90 degrees from the mean normal of those that are less than that from the triangle at the
    /// contact. What lies behind a thin part is not.
    fn is_touched_side(&self) -> Vec<bool> {
        let triangles = self.vertices.iter().flat_map(|(v, _)| self.model.around(*v));
        let corners = triangles.map(|t| self.model.surface.triangles[*t as usize].map(|v| self.rest(v)));
        let distance = |corners: &[Vec3; 3]| (closest_point(self.centre, *corners).point - self.centre).norm_squared();
        let touched = corners.map(|corners| (distance(&corners), corners)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, touched)) = touched else { return vec![true; self.vertices.len()] };
        let areas: Vec<Vec3> = self.vertices.iter().map(|&(v, _)| self.area(v)).collect();
        let (first, weighted) = (normal_of(touched), self.vertices.iter().zip(&areas));
        let facing = weighted.filter(|(_, area)| area.dot(&first) > 0.0);
        let mean: Vec3 = facing.map(|((_, weight), area)| *weight * area).sum();
        areas.iter().map(|area| area.dot(&mean) > 0.0).collect()
    }
}

/// Displacement of the rest shape to its goal.
pub(super) enum GoalDisplacement {
    /// Displacement of every vertex of the region, m (k x 3); zero if it has no goal.
    Surface(fn(&BrushRegion<'_>) -> Vec<Vec3>),
    /// The same of the vertices on the side that is touched; others move with their cells.
    Side(fn(&BrushRegion<'_>) -> Vec<Vec3>),
    /// Displacement of every node of the brush, m (k x 3).
    Nodes(fn(&Brush, &Body) -> Vec<Vec3>),
}

/// Where a brush is.
struct Brushed {
    /// Contact point in the rest shape, m.
    at: Vec3,
    /// Rotation from axes of the hand to those of the scene.
    hand: UnitQuaternion<f64>,
    shape: BrushShape,
}

/// A flow of the rest shape in progress.
pub(super) struct RestShapeFlow {
    /// Rate at which the goal is approached, 1/s.
    rate: f64,
    goal: GoalDisplacement,
    brush: Brush,
    /// Change of the rest shape (buffer).
    change: RestChange,
}

impl RestShapeFlow {
    /// Begins an edit towards `goal`, with the rate `default` (1/s) unless the edit has a `strength`.
    pub fn begin(edit: &Edit, tool: &Tool, default: f64, goal: GoalDisplacement) -> Box<dyn Action> {
        let rate = edit.strength_or(default);
        let flow = Self { rate, goal, brush: Brush::default(), change: RestChange::default() };
        ChangingTouch::begin(BrushShape::of(edit, tool), flow)
    }

    /// Moves the surface of the rest shape by a fraction of its goal displacements.
    fn flow_surface(
        &mut self,
        body: &mut Body,
        Brushed { at, hand, shape }: Brushed,
        goal: fn(&BrushRegion<'_>) -> Vec<Vec3>,
        fraction: f64,
    ) -> Result<(), LatticeError> {
        let radius = shape.radius_at(body.discretization.edge());
        let centre = body.embed_point(at)?.settled;
        let mut vertices = self.brush.vertices(body, centre, radius, shape.falloff)?;
        let mut carried = Vec::new();
        let Body { model, skin, .. } = &*body;
        if let GoalDisplacement::Side(_) = self.goal {
            let region = BrushRegion { centre, hand, vertices: &vertices, model, skin };
            let mut sides = region.is_touched_side().into_iter();
            carried = vertices.extract_if(.., |_| sides.next() == Some(false)).map(|(v, _)| v).collect();
        }
        let region = BrushRegion { centre, hand, vertices: &vertices, model, skin };
        let displacements = goal(&region);
        let mut moves: Moves =
            vertices.iter().zip(displacements).map(|(&(v, weight), d)| (v, fraction * weight * d)).collect();
        // Nodes take the mean of what the surface does, which goes no farther than where it folds.
        limit_folds(&body.model, &body.skin.settled, &body.skin.cell, &mut moves, Unresolved::Stop);
        transfer(&self.brush, &moves, &carried, body, &mut self.change)
    }
}

/// Transfers displacements of surface vertices (ascending) to the nodes of the brush, and the remainder to the surface points. Those that are `carried`
/// (ascending) have no displacement of their own.
fn transfer(
    brush: &Brush,
    moves: &[(u32, Vec3)],
    carried: &[u32],
    body: &mut Body,
    change: &mut RestChange,
) -> Result<(), LatticeError> {
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
    let cells = brush.cells(lattice).into_iter();
    let near: Vec<(u32, Vec<u32>)> = cells.map(|cell| (cell, lattice.distinct_corners(cell).to_vec())).collect();
    let mut total = vec![0.0; count];
    let find = |v: u32| moves.binary_search_by_key(&v, |(of, _)| *of).ok().map(|at| moves[at].1);
    for (cell, corners) in &near {
        let (points, weights) = lattice.weighted_points(*cell, model)?;
        for (&v, weights) in points.iter().zip(weights).filter(|(v, _)| carried.binary_search(v).is_err()) {
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
    for _ in 0..EXTENSION_SWEEPS {
        let (mut sums, mut counts) = (vec![Vec3::zeros(); count], vec![0.0; count]);
        for (_, corners) in &near {
            let mean = corners.iter().map(|n| change.nodes[*n as usize]).sum::<Vec3>() / corners.len() as f64;
            for &n in corners.iter().filter(|n| covered[**n as usize] && !on_surface[**n as usize]) {
                sums[n as usize] += mean;
                counts[n as usize] += 1.0;
            }
        }
        for n in (0..count).filter(|n| counts[*n] > 0.0) {
            change.nodes[n] = sums[n] / counts[n];
        }
    }
    let mut by = Vec::new();
    for (cell, _) in &near {
        by.clear();
        lattice.displace_points(*cell, &change.nodes, model, &mut by)?;
        for (&v, by) in lattice.points(*cell)?.iter().zip(&by) {
            let Some(wanted) = find(v) else { continue };
            change.points.push((v, wanted - by));
        }
    }
    Ok(())
}

impl BodyChange for RestShapeFlow {
    fn change(
        &mut self,
        _tool: &mut Tool,
        step: &mut Step<'_>,
        shape: BrushShape,
        Due { at, seconds }: Due,
    ) -> Result<bool, LatticeError> {
        let hand = step.hand.rotation;
        let body = &mut step.bodies[at.body as usize];
        self.brush.cover(body, at.rest, shape)?;
        if self.brush.is_empty() {
            return Ok(false);
        }
        let approach = self.rate * seconds;
        // One backward Euler step of the exponential approach, which overshoots the goal at no rate.
        let fraction = (approach / (1.0 + approach)).min(MAX_FRACTION);
        self.change.clear(body.system.nodes.len());
        match self.goal {
            GoalDisplacement::Nodes(goal) => {
                let displacements = goal(&self.brush, body);
                for ((&n, weight), d) in self.brush.nodes.iter().zip(&self.brush.weight).zip(displacements) {
                    self.change.nodes[n as usize] = fraction * weight * d;
                }
            }
            GoalDisplacement::Surface(goal) | GoalDisplacement::Side(goal) => {
                self.flow_surface(body, Brushed { at: at.rest, hand, shape }, goal, fraction)?
            }
        }
        body.reshape(&mut self.change)?;
        Ok(true)
    }
}
