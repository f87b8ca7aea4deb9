//! Bounding boxes of the surface embedded in a cell, for broad-phase contact search.

use super::Lattice;
use pliant_solver::{Nodes, Vec3};

/// Bound of the sum of the negative weights with which nodes move a point. The largest at random points of random bodies is 0.17.
pub(super) const NEGATIVE_WEIGHTS: f64 = 0.25;

/// Least and greatest displacement from the grid, m, by component, of each node and those it shares a cell with. Empty where the surface
/// follows the corners of its own cell alone.
#[derive(Default)]
pub struct NodeBounds(Vec<[Vec3; 2]>);

impl NodeBounds {
    /// Computes the bounds for the present positions of the nodes.
    pub fn list(&mut self, lattice: &Lattice, nodes: &Nodes) {
        self.0.clear();
        if lattice.smooth.is_none() {
            return;
        }
        let empty = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        self.0.resize(nodes.len(), empty);
        for (cell, corners) in lattice.region.cell_corners.iter().enumerate() {
            let [low, high] = span(lattice.displacements(cell as u32, nodes));
            for &n in corners {
                let [least, greatest] = &mut self.0[n as usize];
                (*least, *greatest) = (least.inf(&low), greatest.sup(&high));
            }
        }
    }

    /// Least and greatest coordinates, m, of all points that may be embedded in an active cell.
    pub fn of_cell(&self, cell: u32, lattice: &Lattice, nodes: &Nodes) -> [Vec3; 2] {
        let corners = lattice.region.cell_corners[cell as usize];
        if self.0.is_empty() {
            return span(lattice.corners(cell, &nodes.x));
        }
        let bounds = corners.map(|n| self.0[n as usize]);
        let (low, high) = (span(bounds.map(|b| b[0]))[0], span(bounds.map(|b| b[1]))[1]);
        let beyond = NEGATIVE_WEIGHTS * (high - low);
        let least = lattice.grid_rest(corners[0]);
        [least + low - beyond, least.add_scalar(lattice.facts.edge) + high + beyond]
    }
}

/// Least and greatest coordinates.
fn span(points: [Vec3; 8]) -> [Vec3; 2] {
    points[1..].iter().fold([points[0]; 2], |[low, high], p| [low.inf(p), high.sup(p)])
}

#[cfg(test)]
mod tests {
    use super::super::smooth::{SmoothEmbedding, weights};
    use super::*;
    use pliant_host::Region;
    use pliant_mesh::testing::Random;

    /// A cell and those of its 26 neighbours that are in `cells`, as a region.
    fn region(cells: u32) -> (Region, usize) {
        let mut region = Region::default();
        let (mut numbers, mut middle) = ([u32::MAX; 64], 0);
        for cell in (0..27).filter(|cell| cells >> cell & 1 == 1 || *cell == 13) {
            if cell == 13 {
                middle = region.cell_corners.len();
            }
            region.cell_corners.push(std::array::from_fn(|corner| {
                let at =
                    cell % 3 + (corner & 1) + 4 * (cell / 3 % 3 + (corner >> 1 & 1)) + 16 * (cell / 9 + (corner >> 2));
                if numbers[at] == u32::MAX {
                    numbers[at] = region.node_id.len() as u32;
                    region.node_id.push(at as u64);
                    region.node_border.push(0);
                }
                numbers[at]
            }));
        }
        (region, middle)
    }

    #[test]
    fn weights_of_nodes_sum_to_one_and_few_are_negative() {
        let random = &mut Random(5);
        let (mut smooth, mut most) = (SmoothEmbedding::default(), 0.0_f64);
        for _ in 0..4000 {
            let share = random.unit();
            let cells = (0..27).map(|cell| u32::from(random.unit() < share) << cell).sum();
            let (region, middle) = region(cells);
            smooth.list(&region, Vec::new());
            for _ in 0..20 {
                let t: [f64; 3] = std::array::from_fn(|_| random.unit());
                let along = |corner: usize, axis: usize| if corner >> axis & 1 == 1 { t[axis] } else { 1.0 - t[axis] };
                let trilinear = std::array::from_fn(|corner| (0..3).map(|axis| along(corner, axis)).product());
                smooth.add_load(&region, middle, &weights(&trilinear), Vec3::x());
                let mut by_node = vec![0.0; region.node_id.len()];
                smooth.pull_back(&region, |node, f| by_node[node as usize] += f[0]);
                assert!((by_node.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                most = most.max(-by_node.iter().filter(|w| **w < 0.0).sum::<f64>());
            }
        }
        assert!(most > 0.0 && most < NEGATIVE_WEIGHTS, "{most}");
    }
}
