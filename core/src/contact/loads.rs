//! Loads on places of a body, and how they change as the body moves there.

use crate::body::{Body, Carrier, LatticeError};
use crate::step::{Block, NodeSprings, Nodes, V3, axpy};

/// Loads on rest places.
#[derive(Debug, Default)]
pub struct PlaceLoads {
    /// m, rest places (s x 3)
    pub places: Vec<V3>,
    /// N (s x 3)
    pub force: Vec<V3>,
    /// N/m (s blocks)
    pub stiffness: Vec<Block>,
    /// N s/m (s blocks)
    pub damping: Vec<Block>,
    sums: Sums,
}

/// Sums by node, dense, and which nodes have one.
#[derive(Debug, Default)]
struct Sums {
    force: Vec<V3>,
    stiffness: Vec<Block>,
    damping: Vec<Block>,
    seen: Vec<bool>,
    touched: Vec<u32>,
    weights: Vec<[f64; 8]>,
}

impl PlaceLoads {
    /// No loads; keeps its buffers.
    pub fn clear(&mut self) {
        self.places.clear();
        self.force.clear();
        self.stiffness.clear();
        self.damping.clear();
    }

    /// One more.
    pub fn push(&mut self, place: V3, force: V3, stiffness: Block, damping: Block) {
        self.places.push(place);
        self.force.push(force);
        self.stiffness.push(stiffness);
        self.damping.push(damping);
    }

    /// Gives the loads to the nodes of a body, by the transpose of the embedding. Places beside the active cells are left out and the
    /// others take their share, so that the whole load arrives.
    ///
    /// # Errors
    /// What the grid says.
    pub fn attach(&mut self, body: &mut Body, out: &mut NodeSprings) -> Result<(), LatticeError> {
        let Body { carrier, model, skin, system, .. } = body;
        let nodes = &system.nodes;
        let sums = &mut self.sums;
        sums.begin(nodes.len());
        let lattice = match carrier {
            Carrier::Lattice(lattice) => lattice,
            Carrier::Sheet(sheet) => {
                for (i, place) in self.places.iter().enumerate() {
                    let Some((triangle, bary)) = sheet.seat(*place, model, skin) else { continue };
                    for (node, weight) in sheet.nodes_of(model, triangle).into_iter().zip(bary) {
                        sums.add(node, weight, self.force[i], &self.stiffness[i], &self.damping[i]);
                    }
                }
                let wanted = self.force.iter().fold([0.0; 3], |sum, f| axpy(sum, 1.0, *f));
                sums.give(wanted, nodes, out);
                return Ok(());
            }
        };
        if lattice.grid.is_nonlinear() {
            lattice.pull_back(&self.places, &self.force, nodes, |node, f| {
                let at = sums.touch(node).0;
                *at = axpy(*at, 1.0, f);
            })?;
        } else {
            let (force, stiffness, damping) = (&self.force, &self.stiffness, &self.damping);
            let mut weights = std::mem::take(&mut sums.weights);
            lattice.stencils(&self.places, &mut weights, |place, node, weight| {
                sums.add(node, weight, force[place], &stiffness[place], &damping[place]);
            })?;
            sums.weights = weights;
        }
        let wanted = self.force.iter().fold([0.0; 3], |sum, f| axpy(sum, 1.0, *f));
        sums.give(wanted, nodes, out);
        Ok(())
    }
}

impl Sums {
    fn begin(&mut self, nodes: usize) {
        if self.force.len() < nodes {
            self.force.resize(nodes, [0.0; 3]);
            self.stiffness.resize(nodes, [0.0; 9]);
            self.damping.resize(nodes, [0.0; 9]);
            self.seen.resize(nodes, false);
        }
        self.touched.clear();
    }

    fn touch(&mut self, node: u32) -> (&mut V3, &mut Block, &mut Block) {
        let n = node as usize;
        if !self.seen[n] {
            self.seen[n] = true;
            self.touched.push(node);
        }
        (&mut self.force[n], &mut self.stiffness[n], &mut self.damping[n])
    }

    fn add(&mut self, node: u32, weight: f64, force: V3, stiffness: &Block, damping: &Block) {
        let (f, k, c) = self.touch(node);
        *f = axpy(*f, weight, force);
        for e in 0..9 {
            k[e] += weight * stiffness[e];
            c[e] += weight * damping[e];
        }
    }

    /// Empties the sums into `out`, scaled so that they come to `wanted`.
    fn give(&mut self, wanted: V3, nodes: &Nodes, out: &mut NodeSprings) {
        let size = |f: V3| f.iter().map(|c| c * c).sum::<f64>().sqrt();
        let arrived = self.touched.iter().fold([0.0; 3], |sum, &n| axpy(sum, 1.0, self.force[n as usize]));
        let scale = if size(arrived) > 0.0 { size(wanted) / size(arrived) } else { 1.0 };
        self.touched.sort_unstable();
        out.clear();
        for &node in &self.touched {
            let n = node as usize;
            let force = std::mem::take(&mut self.force[n]).map(|f| scale * f);
            let (stiffness, damping) = (std::mem::take(&mut self.stiffness[n]), std::mem::take(&mut self.damping[n]));
            self.seen[n] = false;
            out.push(node, force, stiffness, damping, nodes.x[n]);
        }
    }
}
