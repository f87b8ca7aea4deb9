//! Repairs shapes that become rest shapes: no tetrahedron of a cell may be inverted or nearly flat ("tangled").
//!
//! A material cannot use an inverted element as a rest shape, and a nearly flat one has a frequency that no step resolves. Displacements of
//! the nodes of tangled cells are therefore smoothed by Gauss-Seidel sweeps of the Laplacian, no more than needed, so that the dent remains.
//! If that fails, the neighbouring nodes are included; if that fails as well, all displacements are scaled down by bisection towards the last
//! rest shape, which is not tangled. So a repair always succeeds. A change of the rest shape by an edit is limited instead: nodes of cells
//! that it would tangle do not move.

use super::fragments::NodeKey;
use super::{Lattice, LatticeError, RestOffsets};
use pliant_host::Region;
use pliant_solver::{Nodes, Vec3};

/// Smallest volume of a tetrahedron, relative to that in the undeformed grid. The frequency of an element grows with the inverse of its
/// height: this keeps it within twenty times that of the undeformed one.
const MIN_VOLUME: f64 = 0.05;
/// Rounds of sweeps before all displacements are scaled down; after each, the neighbours of the repaired nodes are included.
const ROUNDS: usize = 6;
/// Gauss-Seidel sweeps over the repaired nodes in one round.
const SWEEPS: usize = 40;
/// Bisection steps for the largest factor of the displacements.
const BISECTIONS: usize = 20;

/// Report of a repair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repair {
    /// Number of tangled cells.
    pub cells: usize,
    /// Position in the undeformed grid of a node of the first of these cells, m.
    pub place: Vec3,
    /// Largest displacement of a node by the repair, m.
    pub moved: f64,
}

impl Lattice {
    /// Moves nodes until every tetrahedron of every active cell has at least 5 % of its undeformed volume. Returns `None`, and changes
    /// nothing, if all have it already.
    pub fn untangle(&self, nodes: &mut Nodes) -> Option<Repair> {
        let tangled = self.tangled_cells(&nodes.x);
        let place = self.grid_rest(self.region.cell_corners[*tangled.first()? as usize][0]);
        let before = nodes.x.clone();
        if !self.smooth_displacements(nodes, &tangled) {
            self.scale_displacements(nodes);
        }
        let moved = before.iter().zip(&nodes.x).map(|(a, b)| (b - a).norm()).fold(0.0, f64::max);
        Some(Repair { cells: tangled.len(), place, moved })
    }

    /// Sets to zero the change (m, n x 3) of the nodes of every cell that it would tangle, until it tangles none.
    pub(in crate::body) fn limit_change(&self, change: &mut [Vec3], rest: &[Vec3]) {
        let changed = |change: &[Vec3], cell: u32| {
            self.region.cell_corners[cell as usize].iter().any(|&n| change[n as usize] != Vec3::zeros())
        };
        // A node that stops moving may tangle a neighbouring cell. Every round stops some, so the loop ends.
        loop {
            let x: Vec<Vec3> = rest.iter().zip(change.iter()).map(|(x, d)| x + d).collect();
            let mut tangled = self.tangled_cells(&x);
            tangled.retain(|&cell| changed(change, cell));
            if tangled.is_empty() {
                return;
            }
            for node in tangled.iter().flat_map(|&cell| self.region.cell_corners[cell as usize]) {
                change[node as usize] = Vec3::zeros();
            }
        }
    }

    /// Active cells with an inverted or flat tetrahedron, for nodes at `x` (m, n x 3).
    fn tangled_cells(&self, x: &[Vec3]) -> Vec<u32> {
        (0..self.region.cell_corners.len() as u32).filter(|&cell| self.is_tangled(cell, x)).collect()
    }

    fn is_tangled(&self, cell: u32, x: &[Vec3]) -> bool {
        self.is_cell_tangled(&self.region, cell, x)
    }

    /// Whether a cell of `region` has an inverted or flat tetrahedron, for the nodes of that region at `x` (m, n x 3).
    fn is_cell_tangled(&self, region: &Region, cell: u32, x: &[Vec3]) -> bool {
        let corners = region.cell_corners[cell as usize];
        self.source.tetrahedra_of(region, &self.facts, cell).iter().any(|tetrahedron| {
            let nodes = tetrahedron.map(|corner| corners[corner as usize]);
            let undeformed = signed_volume(nodes.map(|node| region.node_rest[node as usize].into()));
            let volume = signed_volume(nodes.map(|node| x[node as usize]));
            volume < MIN_VOLUME * undeformed || volume.is_nan()
        })
    }

    /// Places (m, in the undeformed grid) of the cells that other offsets of the rest positions would tangle, among the cells around `changed`
    /// nodes (m, likewise), active or not.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn tangled_at_rest(
        &self,
        offsets: &RestOffsets,
        changed: impl Iterator<Item = Vec3>,
    ) -> Result<Vec<Vec3>, LatticeError> {
        let cells = self.source.cells_around(&self.facts, changed)?;
        let (mut region, mut whole) = (Region::default(), Region::default());
        self.source.region(self.settings.level, self.families, &[], &cells, &mut whole)?;
        if self.has_cuts() {
            self.fragments.apply(&whole, self.families, &mut region);
        } else {
            region = whole;
        }
        let keys = region.node_id.iter().zip(&region.node_copy).map(|(&node, &copy)| NodeKey { node, copy });
        let displacement = |key| offsets.get(&key).map_or_else(Vec3::zeros, |offset| offset.displacement);
        let x: Vec<Vec3> = keys.zip(&region.node_rest).map(|(key, at)| Vec3::from(*at) + displacement(key)).collect();
        let place = |cell: usize| Vec3::from(region.node_rest[region.cell_corners[cell][0] as usize]);
        let tangled = (0..region.cell_corners.len()).filter(|cell| self.is_cell_tangled(&region, *cell as u32, &x));
        Ok(tangled.map(place).collect())
    }

    /// Sets the displacements of the free nodes of `tangled` cells to the mean of their neighbours', sweep by sweep, until no cell is tangled.
    /// Cells that become tangled on the way are included, and after every [`SWEEPS`] sweeps the neighbouring nodes. Returns whether it
    /// succeeded.
    fn smooth_displacements(&self, nodes: &mut Nodes, tangled: &[u32]) -> bool {
        let neighbours = self.neighbours(nodes.len());
        let mut is_repaired = vec![false; nodes.len()];
        let mut tangled = tangled.to_vec();
        for sweep in 0..ROUNDS * SWEEPS {
            let widens = sweep > 0 && sweep % SWEEPS == 0;
            for node in tangled.iter().flat_map(|&cell| self.region.cell_corners[cell as usize]) {
                is_repaired[node as usize] = true;
                if widens {
                    neighbours[node as usize].iter().for_each(|&around| is_repaired[around as usize] = true);
                }
            }
            for i in (0..nodes.len()).filter(|&i| is_repaired[i] && nodes.constraint[i].is_free()) {
                let around = &neighbours[i];
                let sum: Vec3 = around.iter().map(|&n| nodes.x[n as usize] - nodes.rest[n as usize]).sum();
                nodes.x[i] = nodes.rest[i] + sum / around.len() as f64;
            }
            tangled = self.tangled_cells(&nodes.x);
            if tangled.is_empty() {
                return true;
            }
        }
        false
    }

    /// Scales all displacements from the last rest shape by the largest factor at which no cell is tangled.
    fn scale_displacements(&self, nodes: &mut Nodes) {
        let moved: Vec<Vec3> = nodes.x.iter().zip(&nodes.rest).map(|(x, rest)| x - rest).collect();
        let is_finite = moved.iter().all(|u| u.iter().all(|c| c.is_finite()));
        let scaled = |factor: f64| -> Vec<Vec3> {
            let at = |(rest, u): (&Vec3, &Vec3)| if factor > 0.0 { rest + factor * u } else { *rest };
            nodes.rest.iter().zip(&moved).map(at).collect()
        };
        let (mut sound, mut tangled) = (0.0, if is_finite { 1.0 } else { 0.0 });
        for _ in 0..BISECTIONS {
            let factor = 0.5 * (sound + tangled);
            let is_sound = self.tangled_cells(&scaled(factor)).is_empty();
            (sound, tangled) = if is_sound { (factor, tangled) } else { (sound, factor) };
        }
        nodes.x = scaled(sound);
    }

    /// The nodes that each node shares an edge of a cell with (n).
    fn neighbours(&self, count: usize) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::new(); count];
        let is_cube = self.source.plugin().is_some();
        for corners in &self.region.cell_corners {
            for (corner, &node) in corners.iter().enumerate() {
                if is_cube {
                    neighbours[node as usize].extend([1, 2, 4].map(|axis| corners[corner ^ axis]));
                } else {
                    neighbours[node as usize].extend(corners.iter().filter(|other| **other != node));
                }
            }
        }
        for around in &mut neighbours {
            around.sort_unstable();
            around.dedup();
        }
        neighbours
    }
}

/// Six times the signed volume of a tetrahedron, m^3.
fn signed_volume([a, b, c, d]: [Vec3; 4]) -> f64 {
    (b - a).dot(&(c - a).cross(&(d - a)))
}
