//! Keeps rest shapes sound: no cell of one may be inverted or flat.
//!
//! A material cannot take an inverted element for one at rest, and one that is nearly flat has a frequency no step can follow. Nodes of
//! such cells therefore give up their own displacement from the last rest shape and take the mean of their neighbours', as often as it takes and
//! no more: what was pressed in stays. Where that does not mend every cell, the cells around are included; what is left after that is moved
//! back towards the last rest shape, which is sound, by bisection. So a repair always succeeds. A change of the rest shape itself is limited
//! instead: nodes of cells it would make unsound stay.

use super::Lattice;
use pliant_plugin_api::CELL_TETRAHEDRA;
use pliant_solver::{Nodes, Vec3};

/// Smallest volume of a tetrahedron, relative to that of the undeformed grid. Frequencies of an element grow with the inverse of its
/// height: this keeps them within twenty times those of the undeformed one.
const SMALLEST_VOLUME: f64 = 0.05;
/// Rounds of sweeps before the shape is moved back towards rest; the repaired part is widened between them.
const ROUNDS: usize = 6;
/// Gauss-Seidel sweeps over the repaired nodes in a round, at most.
const SWEEPS: usize = 40;
/// Halvings of the interval in which the largest sound displacement lies.
const HALVINGS: usize = 20;

/// What a repair of a shape changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repair {
    /// Number of cells that were inverted or flat.
    pub cells: usize,
    /// m, the rest position in the grid of a node of the first of these cells
    pub place: Vec3,
    /// m, the largest distance by which a node was moved
    pub moved: f64,
}

impl Lattice {
    /// Moves nodes so that every tetrahedron of every active cell has at least a twentieth of its undeformed volume. Changes nothing and
    /// gives `None` where that is so already.
    pub fn untangle(&self, nodes: &mut Nodes) -> Option<Repair> {
        let bad = self.tangled_cells(&nodes.x);
        let place = self.grid_rest(self.region.cell_corners[*bad.first()? as usize][0]);
        let before = nodes.x.clone();
        if !self.smooth_displacements(nodes, &bad) {
            self.move_back(nodes);
        }
        let moved = before.iter().zip(&nodes.x).map(|(a, b)| (b - a).norm()).fold(0.0, f64::max);
        Some(Repair { cells: bad.len(), place, moved })
    }

    /// Takes back the change (m, n x 3) of every node of a cell that would be inverted or flat with it, until no cell is.
    pub(in crate::body) fn limit_change(&self, change: &mut [Vec3], rest: &[Vec3]) {
        let changed = |change: &[Vec3], cell: u32| {
            self.region.cell_corners[cell as usize].iter().any(|&n| change[n as usize] != Vec3::zeros())
        };
        // A node that stays may make a neighbouring cell unsound. Each round makes nodes stay, so the rounds end.
        loop {
            let x: Vec<Vec3> = rest.iter().zip(change.iter()).map(|(x, d)| x + d).collect();
            let mut bad = self.tangled_cells(&x);
            bad.retain(|&cell| changed(change, cell));
            if bad.is_empty() {
                return;
            }
            for node in bad.iter().flat_map(|&cell| self.region.cell_corners[cell as usize]) {
                change[node as usize] = Vec3::zeros();
            }
        }
    }

    /// Active cells with an inverted or flat tetrahedron, for nodes at `x`.
    fn tangled_cells(&self, x: &[Vec3]) -> Vec<u32> {
        (0..self.region.cell_corners.len() as u32).filter(|&cell| self.is_tangled(cell, x)).collect()
    }

    fn is_tangled(&self, cell: u32, x: &[Vec3]) -> bool {
        let corners = self.region.cell_corners[cell as usize];
        CELL_TETRAHEDRA[self.cell_parity(cell)].iter().any(|tetrahedron| {
            let nodes = tetrahedron.map(|corner| corners[corner as usize]);
            let undeformed = signed_volume(nodes.map(|node| self.grid_rest(node)));
            let volume = signed_volume(nodes.map(|node| x[node as usize]));
            volume < SMALLEST_VOLUME * undeformed || volume.is_nan()
        })
    }

    /// Gives the nodes of `bad` cells the mean of their neighbours' displacements, sweep by sweep, until every cell is sound; a sweep more would
    /// smooth away what was pressed in. Cells that become unsound on the way are included, and after every [`SWEEPS`] sweeps the nodes around.
    /// Gives whether every cell is sound then.
    fn smooth_displacements(&self, nodes: &mut Nodes, bad: &[u32]) -> bool {
        let neighbours = self.neighbours(nodes.len());
        let mut is_repaired = vec![false; nodes.len()];
        let mut bad = bad.to_vec();
        for sweep in 0..ROUNDS * SWEEPS {
            let widens = sweep > 0 && sweep % SWEEPS == 0;
            for node in bad.iter().flat_map(|&cell| self.region.cell_corners[cell as usize]) {
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
            bad = self.tangled_cells(&nodes.x);
            if bad.is_empty() {
                return true;
            }
        }
        false
    }

    /// Scales all displacements from the last rest shape by the largest factor at which every cell is sound.
    fn move_back(&self, nodes: &mut Nodes) {
        let moved: Vec<Vec3> = nodes.x.iter().zip(&nodes.rest).map(|(x, rest)| x - rest).collect();
        let is_finite = moved.iter().all(|u| u.iter().all(|c| c.is_finite()));
        let scaled = |factor: f64| -> Vec<Vec3> {
            let at = |(rest, u): (&Vec3, &Vec3)| if factor > 0.0 { rest + factor * u } else { *rest };
            nodes.rest.iter().zip(&moved).map(at).collect()
        };
        let (mut sound, mut tangled) = (0.0, if is_finite { 1.0 } else { 0.0 });
        for _ in 0..HALVINGS {
            let factor = 0.5 * (sound + tangled);
            let is_sound = self.tangled_cells(&scaled(factor)).is_empty();
            (sound, tangled) = if is_sound { (factor, tangled) } else { (sound, factor) };
        }
        nodes.x = scaled(sound);
    }

    /// For each node, the nodes it shares an edge of a cell with.
    fn neighbours(&self, count: usize) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::new(); count];
        for corners in &self.region.cell_corners {
            for (corner, &node) in corners.iter().enumerate() {
                neighbours[node as usize].extend([1, 2, 4].map(|axis| corners[corner ^ axis]));
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
