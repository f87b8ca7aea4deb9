//! Nodes around a place, as far as the material leads without leaving a ball.

use super::{Body, Discretization, Lattice, LatticeError, Model, Sheet, Skin};
use pliant_solver::{Nodes, Vec3};

impl Body {
    /// Nodes within `radius` (m) of a rest place in the shape at rest, each with its distance from it (m), by ascending number. Only those that
    /// cells or triangles inside of the ball join to the place: what is near in space alone stays out.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn nodes_within(&self, place: Vec3, radius: f64, out: &mut Vec<(u32, f64)>) -> Result<(), LatticeError> {
        out.clear();
        let (_, centre) = self.embed_point(place)?;
        let nodes = &self.system.nodes;
        let distance: Vec<f64> = nodes.rest.iter().map(|x| (x - centre).norm()).collect();
        let inside = |node: u32| distance[node as usize] <= radius;
        let mut seen = match &self.discretization {
            Discretization::Lattice(lattice) => within_lattice(lattice, place, nodes, inside)?,
            Discretization::Sheet(sheet) => within_sheet(sheet, centre, &self.model, &self.skin, inside),
        };
        seen.sort_unstable();
        out.extend(seen.into_iter().map(|node| (node, distance[node as usize])));
        Ok(())
    }
}

/// Nodes of the cells that cells inside of the ball join to the cell that carries a place.
fn within_lattice(
    lattice: &Lattice,
    place: Vec3,
    nodes: &Nodes,
    inside: impl Fn(u32) -> bool + Copy,
) -> Result<Vec<u32>, LatticeError> {
    let cells = &lattice.region().cell_corners;
    let Some(first) = lattice.cell_of(place)? else { return Ok(Vec::new()) };
    let mut groups = Groups::new(nodes.rest.len());
    for corners in cells {
        let within = || corners.iter().copied().filter(|&n| inside(n));
        if let Some(first) = within().next() {
            within().for_each(|n| groups.join(first, n));
        }
    }
    Ok(groups.of(cells[first].iter().copied().filter(|&n| inside(n)), inside))
}

/// Nodes of the vertices that triangles inside of the ball join to the triangle nearest to a place.
fn within_sheet(
    sheet: &Sheet,
    centre: Vec3,
    model: &Model,
    skin: &Skin,
    inside: impl Fn(u32) -> bool + Copy,
) -> Vec<u32> {
    let Some((first, _)) = sheet.seat(centre, model, skin) else { return Vec::new() };
    let mut groups = Groups::new(sheet.vertex_count());
    for triangle in (0..model.surface.triangles.len() as u32).filter(|t| !model.is_lid(*t)) {
        let corners = sheet.nodes_of(model, triangle);
        let within = || corners.into_iter().filter(|&n| inside(n));
        if let Some(first) = within().next() {
            within().for_each(|n| groups.join(first, n));
        }
    }
    groups.of(sheet.nodes_of(model, first).into_iter().filter(|&n| inside(n)), inside)
}

/// Disjoint groups of nodes (union-find).
struct Groups(Vec<u32>);

impl Groups {
    fn new(nodes: usize) -> Self {
        Self((0..nodes as u32).collect())
    }

    fn root(&mut self, mut node: u32) -> u32 {
        while self.0[node as usize] != node {
            let up = self.0[self.0[node as usize] as usize];
            self.0[node as usize] = up;
            node = up;
        }
        node
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// Every node inside that is in a group with one of `some`.
    fn of(mut self, some: impl Iterator<Item = u32>, inside: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut wanted: Vec<u32> = some.map(|n| self.root(n)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let all = 0..self.0.len() as u32;
        all.filter(|&n| inside(n) && wanted.binary_search(&self.root(n)).is_ok()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_what_joins_lead_to() {
        let mut groups = Groups::new(6);
        groups.join(5, 3);
        groups.join(3, 1);
        groups.join(0, 2);
        assert_eq!(groups.of([5].into_iter(), |_| true), [1, 3, 5]);
    }
}
