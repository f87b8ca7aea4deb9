//! Painting of a body: nodes that strokes have pinned, and factors of its material's parameters.

use super::painted_factors::{FactorChange, PaintBall, PaintStroke, PaintedFactors};
use super::surface_layer::{PaintDepth, SurfaceLayer};
use super::{Body, Discretization, Lattice, LatticeError};
use crate::edit::BrushShape;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

impl Body {
    /// Holds the nodes within `radius` (m) of a point of the rest shape (m) where they are; on a lattice all nodes that the surface within the radius
    /// depends on. Returns whether any was not pinned before.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn pin(&mut self, point: Vec3, radius: f64) -> Result<bool, LatticeError> {
        self.change_pins(point, radius, true)
    }

    /// Frees pinned nodes within `radius` (m) of a point of the rest shape (m). Nodes that the scene fixes stay fixed. Returns whether any was freed.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn unpin(&mut self, point: Vec3, radius: f64) -> Result<bool, LatticeError> {
        self.change_pins(point, radius, false)
    }

    fn change_pins(&mut self, point: Vec3, radius: f64, pins: bool) -> Result<bool, LatticeError> {
        let nodes = self.connected_nodes(point, radius)?;
        let ball = PaintBall { centre: self.embed_point(point)?.settled, radius, nodes: &nodes };
        let has_changed = match &mut self.discretization {
            Discretization::Lattice(lattice) => lattice.change_pins(ball, &self.skin.settled, pins)?,
            Discretization::Sheet(sheet) => sheet.change_pins(ball.nodes, &mut self.system.nodes, pins),
        };
        if has_changed {
            self.update_tints()?;
        }
        Ok(has_changed)
    }

    /// Moves the factor of a parameter around a point of the rest shape (m) towards a goal, as far as [`Body::most_stiffening`] allows, through the
    /// depth or in a layer under the side of the surface that faces the tool. Shape, motion and history stay; masses follow. Returns whether any factor
    /// has changed.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn paint(
        &mut self,
        point: Vec3,
        shape: BrushShape,
        depth: PaintDepth,
        change: FactorChange,
    ) -> Result<bool, LatticeError> {
        let radius = shape.radius_at(self.discretization.edge());
        let nodes = self.connected_nodes(point, radius)?;
        let ball = PaintBall { centre: self.embed_point(point)?.settled, radius, nodes: &nodes };
        let goal = self.painted().allowed_goal(&self.params, change, self.most_stiffening);
        let (change, planes) = (FactorChange { goal, ..change }, self.params.len());
        let corners = |t: u32| match &self.discretization {
            Discretization::Lattice(_) => self.model.surface.triangles[t as usize],
            Discretization::Sheet(sheet) => sheet.nodes_of(&self.model, t),
        };
        let layer = depth.layer().map(|depth| SurfaceLayer::new(&self.model, &self.skin, ball, depth, corners));
        let stroke = PaintStroke { ball, layer, falloff: shape.falloff, change };
        let has_changed = match &mut self.discretization {
            Discretization::Lattice(lattice) => lattice.paint(&stroke, planes, &mut self.system)?,
            Discretization::Sheet(sheet) => sheet.paint(&stroke, planes, &self.model, &mut self.system)?,
        };
        if has_changed {
            self.update_tints()?;
        }
        Ok(has_changed)
    }

    /// Nodes within `radius` (m) of a point of the rest shape (m) that hang together with it, ascending.
    fn connected_nodes(&self, point: Vec3, radius: f64) -> Result<Vec<u32>, LatticeError> {
        let mut near = Vec::new();
        self.nodes_within(point, radius, &mut near)?;
        Ok(near.into_iter().map(|(node, _)| node).collect())
    }

    /// The painted factors, by cell or triangle.
    pub(super) fn painted(&self) -> &PaintedFactors {
        match &self.discretization {
            Discretization::Lattice(lattice) => lattice.painted(),
            Discretization::Sheet(sheet) => sheet.painted(),
        }
    }

    /// Stiffness of the elastic layer per area around a point of the rest shape (m), N/m^3: as much stiffer than [`Body::layer_stiffness`] as the
    /// cell there has been painted.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn layer_stiffness_at(&self, point: Vec3) -> Result<f64, LatticeError> {
        let factor = match &self.discretization {
            Discretization::Lattice(lattice) if !lattice.painted().is_empty() => {
                lattice.cell_of(point)?.map_or(1.0, |cell| self.layer_factor(lattice, cell as u32))
            }
            Discretization::Lattice(_) | Discretization::Sheet(_) => 1.0,
        };
        Ok(factor * self.layer_stiffness)
    }

    /// Factor of the stiffness of the elastic layer over an active cell: that of the painted parameter `young`.
    pub fn layer_factor(&self, lattice: &Lattice, cell: u32) -> f64 {
        let painted = lattice.painted();
        if painted.is_empty() {
            return 1.0;
        }
        let plane = self.params.iter().position(|key| key == "young");
        let factors = painted.get(lattice.region().cell_id[cell as usize]);
        plane.zip(factors).map_or(1.0, |(plane, factors)| factors[plane])
    }

    /// Factor of a parameter that strokes have painted, at each vertex where it is not 1, ascending: on a lattice that of its cell, on a sheet the geometric mean
    /// of the triangles around it.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn painted_vertices_of(&self, param: &str) -> Result<Vec<(u32, f64)>, LatticeError> {
        let painted = self.painted();
        let Some(plane) = self.params.iter().position(|key| key == param) else { return Ok(Vec::new()) };
        let log = |factors: &[f64]| libm::log(factors[plane]);
        // Sum of the logarithms, and number, of the factors at a vertex.
        let mut of_vertex: BTreeMap<u32, (f64, u32)> = BTreeMap::new();
        let mut add = |vertex: u32, log: f64| {
            let (sum, count) = of_vertex.entry(vertex).or_default();
            (*sum, *count) = (*sum + log, *count + 1);
        };
        match &self.discretization {
            _ if painted.is_empty() => {}
            Discretization::Lattice(lattice) => {
                let mut cells: Vec<(u64, f64)> =
                    painted.elements().map(|(cell, factors)| (cell, log(factors))).collect();
                cells.sort_unstable_by_key(|(cell, _)| *cell);
                for (cell, log) in cells {
                    lattice.for_points_of_cell(cell, |vertex| add(vertex, log))?;
                }
            }
            Discretization::Sheet(_) => {
                for (triangle, corners) in (0..).zip(&self.model.surface.triangles) {
                    let log = painted.get(triangle).map_or(0.0, log);
                    corners.iter().for_each(|vertex| add(*vertex, log));
                }
            }
        }
        let means = of_vertex.into_iter().map(|(vertex, (sum, count))| (vertex, libm::exp(sum / f64::from(count))));
        Ok(means.filter(|(_, factor)| *factor != 1.0).collect())
    }

    /// Upper bound of the ratio by which painting has raised stiffness over mass of any part, 1 or more.
    pub fn painted_stiffening(&self) -> f64 {
        self.painted().stiffening(&self.params)
    }

    /// Whether a vertex is pinned: it does not move.
    pub fn is_pinned(&self, vertex: u32) -> bool {
        match &self.discretization {
            Discretization::Lattice(lattice) => lattice.is_pinned(vertex),
            Discretization::Sheet(sheet) => sheet.is_pinned(vertex),
        }
    }

    /// Pinned vertices, ascending.
    pub fn pinned_vertices(&self) -> Box<dyn Iterator<Item = u32> + '_> {
        match &self.discretization {
            Discretization::Lattice(lattice) => Box::new(lattice.pinned_points()),
            Discretization::Sheet(sheet) => Box::new(sheet.pinned_vertices()),
        }
    }
}
