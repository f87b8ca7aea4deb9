//! Nodes within a ball that are connected through elements inside of the ball.

use super::{Body, Discretization, LatticeError};
use pliant_mesh::DisjointSets;
use pliant_solver::Vec3;

impl Body {
    /// Lists the nodes within `radius` (m) of a point of the rest shape, by ascending number, each with its distance from it (m). A node
    /// counts only if cells or triangles inside of the ball connect it with the point: the other side of a gap or of a cut is left out.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn nodes_within(&self, point: Vec3, radius: f64, out: &mut Vec<(u32, f64)>) -> Result<(), LatticeError> {
        out.clear();
        let centre = self.embed_point(point)?.settled;
        let nodes = &self.system.nodes;
        let distance: Vec<f64> = nodes.rest.iter().map(|x| (x - centre).norm()).collect();
        let is_inside = |node: u32| distance[node as usize] <= radius;
        let connected = match &self.discretization {
            Discretization::Lattice(lattice) => {
                let Some(first) = lattice.cell_of(point)? else { return Ok(()) };
                let cells = &lattice.region().cell_corners;
                connected_nodes(cells.iter().copied(), cells[first], nodes.rest.len(), is_inside)
            }
            Discretization::Sheet(sheet) => {
                let Some(nearest) = sheet.nearest_triangle(centre, &self.model, &self.skin) else { return Ok(()) };
                let triangles = (0..self.model.surface.triangles.len() as u32).filter(|t| !self.model.is_lid(*t));
                let elements = triangles.map(|t| sheet.nodes_of(&self.model, t));
                let first = sheet.nodes_of(&self.model, nearest.triangle);
                connected_nodes(elements, first, sheet.vertex_count(), is_inside)
            }
        };
        out.extend(connected.into_iter().map(|node| (node, distance[node as usize])));
        Ok(())
    }
}

/// Nodes inside, ascending, that elements connect with corners of the element `first` through nodes inside. Nodes are 0 to `count` - 1.
fn connected_nodes<const CORNERS: usize>(
    elements: impl Iterator<Item = [u32; CORNERS]>,
    first: [u32; CORNERS],
    count: usize,
    is_inside: impl Fn(u32) -> bool + Copy,
) -> Vec<u32> {
    let mut sets = DisjointSets::new(count);
    for corners in elements {
        let inside = || corners.into_iter().filter(|&n| is_inside(n));
        if let Some(first) = inside().next() {
            inside().for_each(|n| sets.unite(first, n));
        }
    }
    let mut roots: Vec<u32> = first.into_iter().filter(|&n| is_inside(n)).map(|n| sets.find(n)).collect();
    roots.sort_unstable();
    roots.dedup();
    (0..count as u32).filter(|&n| is_inside(n) && roots.binary_search(&sets.find(n)).is_ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_nodes_connected_through_nodes_inside_are_listed() {
        let edges = [[5, 3], [3, 1], [0, 2], [1, 4], [4, 0]];
        let listed = connected_nodes(edges.into_iter(), [5, 3], 6, |node| node != 4);
        assert_eq!(listed, [1, 3, 5], "node 4 is outside, so 0 and 2 are not connected");
    }
}
