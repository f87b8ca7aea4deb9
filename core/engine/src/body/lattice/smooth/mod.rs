//! An embedding of the surface with continuous first derivatives (C1): Hermite interpolation of jets.
//!
//! Trilinear weights are continuous from cell to cell, their slopes are not: a dent then shows the grid as creases one cell apart. Here
//! each node has a displacement and its derivatives ([`Jet`]), fitted by moving least squares (Lancaster and Salkauskas 1981) to the
//! displacements of the nodes it shares cells with; a cell interpolates the jets of its eight corners by cubic Hermite polynomials along each
//! axis. Cells that share a face share the jets on it, so value and slope are continuous across every face, at the boundary of the body and
//! beside a cut alike.
//!
//! The fit has the weights of a quadratic B-spline: at a node with all 27 neighbours, slopes are the B-spline's, and the value is halfway
//! between it and the node's own displacement. Elsewhere the fit uses the neighbours that exist. It has the eight terms of a trilinear
//! function, and every node is a corner of at least one cell, so the fit exists and is exact for affine motion. Neighbours are nodes of cells
//! that share the node: nodes across a gap or a cut have no influence.

mod adjacency;
mod fit;
mod hermite;
mod jets;
mod loads;

use adjacency::Adjacency;
use fit::Fits;
pub(super) use hermite::{interpolate, weights};
pub(super) use jets::CellJets;
use jets::JetCache;
use loads::JetLoads;
use pliant_host::Region;
use pliant_solver::{Nodes, Vec3};

/// Displacement at a node and its derivatives by x, y, xy, z, xz, yz and xyz, in edges of a cell, for each component: m (3 x 8).
pub(super) type Jet = [[f64; 8]; 3];

/// The jet of a zero displacement field.
pub(super) const NO_JET: Jet = [[0.0; 8]; 3];

/// Adds one jet to another.
pub(super) fn add(to: &mut Jet, other: &Jet) {
    for (to, other) in to.iter_mut().zip(other) {
        for (to, other) in to.iter_mut().zip(other) {
            *to += other;
        }
    }
}

/// The embedding of a surface in the nodes of a region.
#[derive(Default)]
pub(super) struct SmoothEmbedding {
    fits: Fits,
    adjacency: Adjacency,
    /// Jets of the present displacements from the rest shape.
    displacement: JetCache,
    /// Jets of the displacement of the rest shape from that of the file (n); empty while there is none.
    pub(super) rest_jets: Vec<Jet>,
    loads: JetLoads,
}

impl SmoothEmbedding {
    /// Prepares for another region, with the jets of its rest shape (n, or empty).
    pub(super) fn list(&mut self, region: &Region, rest_jets: Vec<Jet>) {
        self.adjacency.list(region, &mut self.fits);
        self.rest_jets = rest_jets;
        self.forget();
    }

    /// Marks the jets of the present displacements as outdated, after nodes have moved.
    pub(super) fn forget(&mut self) {
        self.displacement.forget(self.adjacency.len());
    }

    /// The jet at a node of the field that has the value `of(node)` (m) at each node.
    pub(super) fn jet(&self, region: &Region, node: u32, of: impl Fn(u32) -> Vec3) -> Jet {
        self.adjacency.jet(region, &self.fits, node, of)
    }

    /// Jets at the corners of a cell of the field that has the value `of(node)` (m) at each node.
    pub(super) fn cell_jets(&self, region: &Region, cell: usize, of: impl Fn(u32) -> Vec3) -> CellJets {
        let jets = region.cell_corners[cell].map(|node| self.jet(region, node, &of));
        CellJets::new(jets.each_ref())
    }

    /// Jets at the corners of a cell of the present displacements from the rest shape.
    pub(super) fn displacement_jets(&mut self, region: &Region, cell: usize, nodes: &Nodes) -> CellJets {
        let corners = region.cell_corners[cell];
        for node in corners {
            let (adjacency, fits) = (&self.adjacency, &self.fits);
            let of = |n: u32| nodes.x[n as usize] - nodes.rest[n as usize];
            self.displacement.update(node, || adjacency.jet(region, fits, node, of));
        }
        CellJets::new(corners.each_ref().map(|node| self.displacement.get(*node)))
    }

    /// Jets at the corners of a cell of the displacement of the rest shape from that of the file.
    pub(super) fn rest_jets_of(&self, region: &Region, cell: usize) -> CellJets {
        let jet = |node: u32| self.rest_jets.get(node as usize).unwrap_or(&NO_JET);
        CellJets::new(region.cell_corners[cell].map(jet))
    }
}
