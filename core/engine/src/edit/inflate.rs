//! Inflate and deflate: a pressure on the surface around the hand and its reaction on the hand.
//!
//! The force on a vertex is `p w A n / 3`, with the falloff w and the current area vectors A n of its triangles, so the pressure follows the
//! surface; constant over a closed surface, the forces add up to zero. The hand gets the negative sum of the forces.

use super::brush::{Brush, BrushShape};
use super::carried_place::CarriedPlace;
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::{Action, BodyPoint, EditKind, Step};
use crate::body::{Body, Discretization, EmbeddedPoint, LatticeError};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Applies a pressure to the surface around the hand.
pub(super) struct Pressure {
    name: &'static str,
    summary: &'static str,
    /// The kind that does the opposite.
    opposite: &'static Self,
    /// 1 outwards, -1 inwards
    sign: f64,
}

/// The edit kind `inflate`: pressure on the surface along its outward normals.
pub(super) static INFLATE: Pressure = Pressure {
    name: "inflate",
    summary: "Press the surface near the hand outwards along its normals.",
    opposite: &DEFLATE,
    sign: 1.0,
};
/// The edit kind `deflate`: pressure on the surface against its outward normals.
pub(super) static DEFLATE: Pressure = Pressure {
    name: "deflate",
    summary: "Press the surface near the hand inwards along its normals.",
    opposite: &INFLATE,
    sign: -1.0,
};

/// Default pressure, Pa.
const PRESSURE: f64 = 1000.0;

impl EditKind for Pressure {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn keys(&self) -> &'static [Key] {
        &[RADIUS, FALLOFF, Key { name: KeyName::Strength, default: "1 kPa", summary: "Pressure at the centre, Pa." }]
    }

    fn strength(&self) -> Option<Strength> {
        Some(Strength { unit: "Pa", default: PRESSURE, range: None })
    }

    fn opposite(&self) -> Option<&'static dyn EditKind> {
        Some(self.opposite)
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Box::new(Pressing {
            shape: BrushShape::of(edit, tool),
            pressure: self.sign * edit.strength_or(PRESSURE),
            place: CarriedPlace::default(),
            brush: Brush::default(),
            force: Vec::new(),
        })
    }
}

/// A pressure in progress.
struct Pressing {
    shape: BrushShape,
    /// Pressure, Pa; positive outwards.
    pressure: f64,
    /// Centre of the region under pressure.
    place: CarriedPlace,
    brush: Brush,
    /// Force on each node, N (n x 3).
    force: Vec<Vec3>,
}

impl Action for Pressing {
    fn contact(&self, _tool: &Tool) -> Option<BodyPoint> {
        self.place.at()
    }

    fn extra_region_radius(&self, edge: f64) -> f64 {
        self.shape.radius_at(edge)
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        (tool.proxy.touch, tool.proxy.position) = (None, step.hand.position);
        let region = |edge| self.shape.radius_at(edge);
        let Some(at) = self.place.follow(tool, step, contact, region)? else { return Ok(()) };
        let body = &mut step.bodies[at.body as usize];
        let EmbeddedPoint { now, settled } = body.embed_point(at.rest)?;
        tool.depth = (now - settled).norm();
        self.brush.cover(body, at.rest, self.shape)?;
        let radius = self.shape.radius_at(body.discretization.edge());
        let vertices = self.brush.vertices(body, settled, radius, self.shape.falloff)?;
        self.force.clear();
        self.force.resize(body.system.nodes.len(), Vec3::zeros());
        add_pressure(&self.brush, &vertices, body, self.pressure, &mut self.force)?;
        let total: Vec3 = self.force.iter().sum();
        let scale = tool.cap(total.norm());
        let springs = tool.springs_mut(at.body as usize);
        for (n, force) in self.force.iter().enumerate().filter(|(_, force)| **force != Vec3::zeros()) {
            springs.push(n as u32, scale * *force, [0.0; 9], [0.0; 9], body.system.nodes.x[n]);
        }
        Ok(())
    }

    fn release(&mut self) {
        self.place.release();
    }
}

/// Adds the nodal forces (N, n x 3) of a pressure (Pa) on vertices with weights, sorted by vertex.
fn add_pressure(
    brush: &Brush,
    vertices: &[(u32, f64)],
    body: &mut Body,
    pressure: f64,
    force: &mut [Vec3],
) -> Result<(), LatticeError> {
    let Body { discretization, model, skin, system, .. } = body;
    match discretization {
        Discretization::Sheet(sheet) => {
            sheet.embed(&system.nodes, skin);
            for &(v, weight) in vertices {
                force[sheet.node_of(v) as usize] += pressure * weight / 3.0 * model.area_around(v, &skin.x);
            }
        }
        Discretization::Lattice(lattice) => {
            let cells = brush.cells(lattice);
            lattice.forget_jets();
            for &cell in &cells {
                lattice.embed_cell(cell, &system.nodes, model, skin)?;
            }
            let (mut of_cells, mut places, mut loads) = (Vec::new(), Vec::new(), Vec::new());
            for &cell in &cells {
                let (points, weights) = lattice.weighted_points(cell, model)?;
                for (&v, weights) in points.iter().zip(weights) {
                    let Ok(at) = vertices.binary_search_by_key(&v, |(of, _)| *of) else { continue };
                    of_cells.push(Some(cell));
                    places.push(*weights);
                    loads.push(pressure * vertices[at].1 / 3.0 * model.area_around(v, &skin.x));
                }
            }
            lattice.distribute_forces(&of_cells, &places, &loads, |node, f| force[node as usize] += f);
        }
    }
    Ok(())
}
