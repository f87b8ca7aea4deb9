//! A surface that follows its lattice without creases: an embedding with continuous first derivatives.
//!
//! Trilinear weights are continuous from cell to cell, their slopes are not: a dent then shows the grid as creases one cell apart. Here
//! each node has a displacement and its derivatives ([`Jet`]), fitted by moving least squares to the displacements of the nodes it shares
//! cells with; a cell interpolates the jets of its eight corners by cubic Hermite polynomials along each axis. Cells that share a face
//! share the jets on it, so value and slope are continuous across every face, at the boundary of the body and beside a cut alike.
//!
//! Weights of the fit are those of a quadratic B-spline: where all 27 nodes are there, slopes at nodes are the B-spline's, and values are
//! halfway between it and the nodes' own displacements. Where some are missing, the fit takes those there are. It has the eight terms of a
//! trilinear function, and a node always has one whole cell beside it, so the fit exists and is exact for affine motion everywhere. Only
//! nodes of cells that share the node are looked at: what is beyond a gap or on the other side of a cut has no part in it.

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

/// The jet of what does not move.
pub(super) const NO_JET: Jet = [[0.0; 8]; 3];

/// Adds one jet to another.
pub(super) fn add(to: &mut Jet, other: &Jet) {
    for (to, other) in to.iter_mut().zip(other) {
        for (to, other) in to.iter_mut().zip(other) {
            *to += other;
        }
    }
}

/// The embedding in the nodes of a region.
#[derive(Default)]
pub(super) struct SmoothEmbedding {
    fits: Fits,
    adjacency: Adjacency,
    /// Jets of what nodes have moved by since they were last at rest.
    moved: JetCache,
    /// Jets of the shapes that were kept, of each node; empty while none was.
    pub(super) kept: Vec<Jet>,
    loads: JetLoads,
}

impl SmoothEmbedding {
    /// Takes over another region; `kept` are the jets of the shapes that were kept.
    pub(super) fn list(&mut self, region: &Region, kept: Vec<Jet>) {
        self.adjacency.list(region, &mut self.fits);
        self.kept = kept;
        self.forget();
    }

    /// Declares jets outdated: nodes have moved.
    pub(super) fn forget(&mut self) {
        self.moved.forget(self.adjacency.len());
    }

    /// The jet at a node of the field that has the value `of(node)` (m) at each node.
    pub(super) fn jet(&self, region: &Region, node: u32, of: impl Fn(u32) -> Vec3) -> Jet {
        self.adjacency.jet(region, &self.fits, node, of)
    }

    /// Jets of a cell of the field that has the value `of(node)` (m) at each node.
    pub(super) fn cell_jets(&self, region: &Region, cell: usize, of: impl Fn(u32) -> Vec3) -> CellJets {
        let jets = region.cell_corners[cell].map(|node| self.jet(region, node, &of));
        CellJets::new(jets.each_ref())
    }

    /// Jets of a cell of what its nodes have moved by since they were last at rest.
    pub(super) fn moved_jets(&mut self, region: &Region, cell: usize, nodes: &Nodes) -> CellJets {
        let corners = region.cell_corners[cell];
        for node in corners {
            let (adjacency, fits) = (&self.adjacency, &self.fits);
            let of = |n: u32| nodes.x[n as usize] - nodes.rest[n as usize];
            self.moved.know(node, || adjacency.jet(region, fits, node, of));
        }
        CellJets::new(corners.each_ref().map(|node| self.moved.get(*node)))
    }

    /// Jets of a cell of the shapes that were kept.
    pub(super) fn kept_jets(&self, region: &Region, cell: usize) -> CellJets {
        let kept = |node: u32| self.kept.get(node as usize).unwrap_or(&NO_JET);
        CellJets::new(region.cell_corners[cell].map(kept))
    }
}
