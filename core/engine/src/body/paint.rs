//! Painting of a body: nodes that strokes have pinned, and factors of its material's parameters.

use super::painted_factors::{FactorChange, PaintBall, PaintedFactors};
use super::{Body, Discretization, LatticeError};
use crate::edit::BrushShape;
use pliant_solver::Vec3;

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
        match &mut self.discretization {
            Discretization::Lattice(lattice) => lattice.change_pins(ball, &self.skin.settled, pins),
            Discretization::Sheet(sheet) => Ok(sheet.change_pins(ball.nodes, &mut self.system.nodes, pins)),
        }
    }

    /// Moves the factor of a parameter around a point of the rest shape (m) towards a goal, as far as [`Body::most_stiffening`] allows. Shape, motion
    /// and history stay; masses follow. Returns whether any factor has changed.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn paint(&mut self, point: Vec3, shape: BrushShape, change: FactorChange) -> Result<bool, LatticeError> {
        let radius = shape.radius_at(self.discretization.edge());
        let nodes = self.connected_nodes(point, radius)?;
        let ball = PaintBall { centre: self.embed_point(point)?.settled, radius, nodes: &nodes };
        let goal = self.painted().allowed_goal(&self.params, change, self.most_stiffening);
        let (change, planes) = (FactorChange { goal, ..change }, self.params.len());
        let weight = |distance: f64| shape.falloff.weight(distance / radius);
        match &mut self.discretization {
            Discretization::Lattice(lattice) => lattice.paint(ball, weight, change, planes, &mut self.system),
            Discretization::Sheet(sheet) => sheet.paint(ball, weight, change, planes, &self.model, &mut self.system),
        }
    }

    /// Nodes within `radius` (m) of a point of the rest shape (m) that hang together with it, ascending.
    fn connected_nodes(&self, point: Vec3, radius: f64) -> Result<Vec<u32>, LatticeError> {
        let mut near = Vec::new();
        self.nodes_within(point, radius, &mut near)?;
        Ok(near.into_iter().map(|(node, _)| node).collect())
    }

    /// The painted factors, by cell or triangle.
    fn painted(&self) -> &PaintedFactors {
        match &self.discretization {
            Discretization::Lattice(lattice) => lattice.painted(),
            Discretization::Sheet(sheet) => sheet.painted(),
        }
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

    /// Painted factor of a parameter, by its index in [`Body::params`], at each vertex: of its cell, or the largest change of the triangles around it. Only
    /// vertices with a factor other than 1, ascending.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn painted_vertices(&self, plane: usize) -> Result<Vec<(u32, f64)>, LatticeError> {
        let mut all: Vec<(u32, f64)> = Vec::new();
        for element in self.painted().elements() {
            let factor = self.painted().get(element).map_or(1.0, |factors| factors[plane]);
            match &self.discretization {
                _ if factor == 1.0 => {}
                Discretization::Lattice(lattice) => lattice.for_points_of_cell(element, |v| all.push((v, factor)))?,
                Discretization::Sheet(_) => {
                    let corners = self.model.surface.triangles.get(element as usize);
                    all.extend(corners.into_iter().flatten().map(|v| (*v, factor)));
                }
            }
        }
        // The largest change first within each vertex.
        let change = |factor: f64| libm::log2(factor).abs();
        all.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(change(b.1).total_cmp(&change(a.1))).then(a.1.total_cmp(&b.1)));
        all.dedup_by_key(|(vertex, _)| *vertex);
        Ok(all)
    }
}
