//! A grid hierarchy around a surface, and the local lattice of nodes that carries it (Qi, Zhu and Fan 2019, section 4).
//!
//! Level n divides the box of the surface into 2^(n-1) cubes per axis; those that the surface touches or encloses are
//! the body. The host asks for the region around a contact at any level, and moves the surface with the corners of its
//! cells. Two things differ from the paper: only occupied cells carry nodes (its box lattice fills the air with
//! springs), and the default embedding is trilinear (its own rule is `embedding = "paper-ratio"`).
//!
//! Ids are linear, x fastest: cell `i + m (j + m k)` with `m` cells per axis, node the same with `m + 1`. All levels
//! share one list of points, those that triangles use; every cell of every level has its points in one range of it.

mod cells;
mod crossings;
mod embedding;
mod lattice;
mod links;
mod overlap;
mod points;
mod region;
mod shape;
mod states;
#[cfg(test)]
mod tests;
mod tree;
mod vector;

use crate::cells::Cells;
use crate::embedding::{Embedding, Seat};
use crate::tree::Tree;
use pliant_plugin_api::abi::{Cell, Level, NO_CELL};
use pliant_plugin_api::export_plugins;
use pliant_plugin_api::{AsGrid, Fault, Grid, Info, Location, Param, Params, RegionRequest, RegionSink, SurfaceView};

export_plugins!(AsGrid<OctreeGrid>);

/// The hierarchy of one body.
pub struct OctreeGrid {
    embedding: Embedding,
    tree: Option<Tree>,
}

impl OctreeGrid {
    fn built(&self, level: u32) -> Result<(&Tree, &Cells), Fault> {
        let tree = self.tree.as_ref().ok_or(Fault::bad_argument("no surface was built"))?;
        let cells = tree.level(level).ok_or_else(|| {
            Fault::bad_argument(format!("level {level} was not built: there are 1 to {}", tree.finest()))
        })?;
        Ok((tree, cells))
    }

    /// [`OctreeGrid::built`] for *real time*: its reason is not made but given.
    fn carrying(&self, level: u32) -> Result<&Cells, Fault> {
        let cells = self.tree.as_ref().and_then(|tree| tree.level(level));
        cells.ok_or(Fault::bad_argument("places were asked for in a level that was not built"))
    }

    /// [`OctreeGrid::carrying`] where [`Grid::place`] is offered.
    fn placing(&self, level: u32) -> Result<&Cells, Fault> {
        if self.is_nonlinear() {
            self.carrying(level)
        } else {
            Err(Fault::unsupported("the embedding is linear: use the weights"))
        }
    }
}

impl Grid for OctreeGrid {
    const INFO: Info = Info {
        id: c"octree-grid",
        name: c"Octree grid",
        version: c"0.1.0",
        summary: c"cubes of an octree that a surface touches or encloses (Qi, Zhu and Fan 2019)",
        params: &[Param::choice(
            c"embedding",
            c"trilinear|paper-ratio",
            c"how the surface follows its cells: exact for affine motion, or as the paper prints it",
        )],
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let embedding = [Embedding::Trilinear, Embedding::PaperRatio].get(params.choice("embedding")).copied();
        let embedding = embedding.ok_or(Fault::bad_argument("embedding is neither trilinear nor paper-ratio"))?;
        Ok(Self { embedding, tree: None })
    }

    fn build(&mut self, surface: &SurfaceView<'_>, level: u32) -> Result<(), Fault> {
        self.tree = Some(Tree::build(surface, level)?);
        Ok(())
    }

    fn level(&self, level: u32) -> Result<Level, Fault> {
        let (_, cells) = self.built(level)?;
        let lattice = &cells.lattice;
        Ok(Level {
            size: size_of::<Level>(),
            level,
            cells_per_axis: lattice.cells,
            edge: lattice.edge,
            origin: lattice.origin,
            surface_cells: cells.surface,
            inside_cells: cells.inside,
            nodes: cells.nodes,
        })
    }

    fn cell(&self, level: u32, id: u64) -> Result<Cell, Fault> {
        let (tree, cells) = self.built(level)?;
        tree.cell(cells, id)
    }

    fn locate(&self, level: u32, point: [f64; 3]) -> Result<Location, Fault> {
        let lattice = &self.built(level)?.1.lattice;
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Fault::bad_argument(format!("point to locate is not finite: {point:?}")));
        }
        let place = lattice.in_cells(point);
        let index = lattice.cell_of(place);
        let local = [0, 1, 2].map(|axis| (place[axis] - f64::from(index[axis])).clamp(0.0, 1.0));
        Ok(Location { cell: lattice.id(index), local })
    }

    fn points(&self, level: u32) -> Result<&[u32], Fault> {
        Ok(self.built(level)?.0.points.indices())
    }

    fn region(&self, request: &RegionRequest<'_>, out: &mut RegionSink<'_>) -> Result<(), Fault> {
        let (tree, cells) = self.built(request.level)?;
        region::region(tree, cells, request, out)
    }

    fn weights(&self, level: u32, places: &[[f64; 3]], ids: &mut [u64], weights: &mut [[f64; 8]]) -> Result<(), Fault> {
        let cells = self.carrying(level)?;
        for ((place, id), weights) in places.iter().zip(ids).zip(weights) {
            let seat = Seat::find(cells, *place)?;
            (*id, *weights) = seat.map_or((NO_CELL, [0.0; 8]), |s| (cells.lattice.id(s.cell), s.weights()));
        }
        Ok(())
    }

    fn place(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        corners: &[[[f64; 3]; 8]],
        places: &mut [[f64; 3]],
    ) -> Result<(), Fault> {
        let cells = self.placing(level)?;
        for ((rest, corners), place) in rest.iter().zip(corners).zip(places) {
            *place = Seat::of(cells, *rest)?.ratio(corners);
        }
        Ok(())
    }

    fn pull_back(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        corners: &[[[f64; 3]; 8]],
        loads: &[[f64; 3]],
        corner_loads: &mut [[[f64; 3]; 8]],
    ) -> Result<(), Fault> {
        let cells = self.placing(level)?;
        for (((rest, corners), load), corner_loads) in rest.iter().zip(corners).zip(loads).zip(corner_loads) {
            Seat::of(cells, *rest)?.ratio_transposed(corners, *load, corner_loads);
        }
        Ok(())
    }

    fn is_nonlinear(&self) -> bool {
        self.embedding == Embedding::PaperRatio
    }
}
