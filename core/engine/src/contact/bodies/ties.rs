//! Ties of points of two bodies: rows of the implicit solve of contact ([`super::dual`]) that hold in every direction, with the impulses that this takes.

use super::contact::{ContactData, FeatureKey};
use super::{BodyCollisions, Member, THICKNESS};
use crate::body::{Body, LatticeError, Model};
use pliant_solver::Vec3;

/// A point on the surface of a body: three vertices of its model, with weights that add up to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiePoint {
    /// The vertices; those without a weight may repeat another.
    pub vertices: [u32; 3],
    /// Weights of the vertices.
    pub weights: [f64; 3],
}

impl TiePoint {
    /// The point at a vertex of the model.
    pub fn vertex(vertex: u32) -> Self {
        Self { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// Whether it is on the surface of a model: its vertices belong to one triangle. A cut through that triangle takes it away.
    pub fn is_on(&self, model: &Model) -> bool {
        let surface = &model.surface;
        let has_all = |t: &u32| self.vertices.iter().all(|v| surface.triangles[*t as usize].contains(v));
        model.around(self.vertices[0]).iter().any(has_all)
    }
}

/// Two points of two bodies that are tied in a step.
#[derive(Clone, Copy, Debug)]
pub struct TieRow {
    /// Number of the tie, which stays from step to step.
    pub number: u32,
    /// Places of the bodies among the members.
    pub members: [usize; 2],
    /// The tied points on the surfaces of these bodies.
    pub points: [TiePoint; 2],
    /// Part of the displacement of the first point from the second, as it is at the start of the step, that is left at its end; `None` for the displacement `gap`.
    pub share: Option<f64>,
    /// Displacement of the first point from the second at the end of the step, m.
    pub gap: Vec3,
    /// Largest impulse in the step, N s; infinite for one that holds whatever comes.
    pub most: f64,
}

impl BodyCollisions {
    /// Ties two points of members in the step.
    pub fn add_tie(&mut self, tie: TieRow) {
        self.ties.push(tie);
    }

    /// Present displacement (m) of a point of the surface of one body from a point of that of another; `None` where one is on no simulated part.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn gap(
        &mut self,
        [i, j]: [usize; 2],
        points: [TiePoint; 2],
        bodies: &mut [Body],
    ) -> Result<Option<Vec3>, LatticeError> {
        let mut places = [Vec3::zeros(); 2];
        for (place, (index, point)) in places.iter_mut().zip([i, j].into_iter().zip(points)) {
            self.prepare(index, &mut bodies[index])?;
            let Some(at) = self.place_of(index, point, &bodies[index].system.nodes.x) else { return Ok(None) };
            *place = at;
        }
        Ok(Some(places[0] - places[1]))
    }

    /// Position (m) of a point of a surface for nodes at `x` (m); `None` where the surface has none of its vertices.
    pub fn place_of(&self, body: usize, point: TiePoint, x: &[Vec3]) -> Option<Vec3> {
        let surface = &self.surfaces[body];
        let mut sum = Vec3::zeros();
        for (vertex, weight) in point.vertices.into_iter().zip(point.weights) {
            sum += weight * surface.position(surface.vertex_of(vertex)?, x);
        }
        Some(sum)
    }

    /// Adds the rows of the ties to the implicit solve of a step of `dt` (s).
    pub(super) fn add_tie_rows(&mut self, dt: f64) {
        let ties = std::mem::take(&mut self.ties);
        let mut carriers = std::mem::take(&mut self.carriers);
        for tie in &ties {
            carriers.clear();
            let Some([start, end, velocity]) = self.gather(tie, &mut carriers) else { continue };
            let wanted = tie.share.map_or(tie.gap, |share| share * start);
            let members = tie.members.map(|at| self.members[at]);
            let edge = members.iter().fold(f64::INFINITY, |least, m| self.surfaces[m.body as usize].edge.min(least));
            let data = ContactData {
                bound: 0.0,
                friction: [0.0; 2],
                thickness: THICKNESS * edge,
                bodies: members.map(|member| member.body),
                key: FeatureKey::Tie(tie.number),
            };
            // Impulses change positions by what they change velocities in the step.
            let bounds = velocity + (wanted - end) / dt;
            self.set.add_tie(&carriers, &self.nodes, data, tie.most, bounds);
        }
        (self.ties, self.carriers) = (ties, carriers);
    }

    /// Collects the nodes that carry a tie, with the weights of the second point negated. Returns the displacements of the first point from the second at the start and
    /// at the end of the step (m) and their relative velocity (m/s); `None` where a point is on no simulated part.
    fn gather(&self, tie: &TieRow, carriers: &mut Vec<(u32, f64)>) -> Option<[Vec3; 3]> {
        let mut sums = [Vec3::zeros(); 3];
        for (side, (at, point)) in tie.members.into_iter().zip(tie.points).enumerate() {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let Member { body, node: first, .. } = self.members[at];
            let surface = &self.surfaces[body as usize];
            for (vertex, weight) in point.vertices.into_iter().zip(point.weights).filter(|(_, w)| *w != 0.0) {
                let vertex = surface.vertex_of(vertex)?;
                let share = sign * weight;
                let nodes = first as usize..;
                sums[0] += share * surface.position(vertex, &self.nodes.start[nodes.clone()]);
                sums[1] += share * surface.position(vertex, &self.nodes.x[nodes]);
                for (node, weight) in surface.carriers(vertex) {
                    let node = first + node;
                    sums[2] += share * weight * self.nodes.v[node as usize];
                    match carriers.iter_mut().find(|(other, _)| *other == node) {
                        Some((_, sum)) => *sum += share * weight,
                        None => carriers.push((node, share * weight)),
                    }
                }
            }
        }
        Some(sums)
    }
}
