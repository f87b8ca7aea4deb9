//! An octree of cubic cells around a surface, and the local lattice of nodes in which the surface is embedded (Qi, Zhu and Fan 2019,
//! section 4).
//!
//! Level n divides the bounding cube of the surface into 2^(n-1) cells per axis; the body consists of the cells that the surface touches
//! or encloses. The host requests the region around a contact at any level, and moves the surface with the corners of its cells.
//! There are two differences from the paper: only occupied cells have nodes (the paper's box lattice fills the air with springs), and
//! the default embedding is trilinear (the paper's rule is `embedding = "paper-ratio"`).
//!
//! Ids are linear, x fastest: a cell has the id `i + m (j + m k)` with m cells per axis, a node the same with m + 1. All levels share one
//! list of the points that triangles use; the points of every cell of every level are one range of it.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod cells;
mod crossings;
mod embedding;
mod lattice;
mod links;
mod overlap;
mod points;
mod region;
mod scaled_surface;
mod states;
#[cfg(test)]
mod tests;
mod tree;

use crate::cells::Cells;
use crate::embedding::{EmbeddedPoint, Embedding};
use crate::tree::Tree;
use pliant_plugin_api::abi::{Cell, Level, NO_CELL};
use pliant_plugin_api::export_plugins;
use pliant_plugin_api::lanes::Vec3;
use pliant_plugin_api::{AsGrid, Fault, Grid, Info, Location, Param, Params, RegionRequest, RegionSink, SurfaceView};

export_plugins!(AsGrid<OctreeGrid>);

/// The octree of one body.
pub struct OctreeGrid {
    embedding: Embedding,
    /// Set by `build`.
    tree: Option<Tree>,
}

impl OctreeGrid {
    /// The octree and one of its levels.
    fn tree_and_level(&self, level: u32) -> Result<(&Tree, &Cells), Fault> {
        let tree = self.tree.as_ref().ok_or(Fault::bad_argument("no surface was built"))?;
        let cells = tree.level(level).ok_or_else(|| {
            Fault::bad_argument(format!("level {level} was not built; built are 1 to {}", tree.finest()))
        })?;
        Ok((tree, cells))
    }

    /// One level, for *real time* functions: the fault does not allocate.
    fn level_in_step(&self, level: u32) -> Result<&Cells, Fault> {
        let cells = self.tree.as_ref().and_then(|tree| tree.level(level));
        cells.ok_or(Fault::bad_argument("an embedding was asked for in a level that was not built"))
    }

    /// [`OctreeGrid::level_in_step`] for the nonlinear embedding; unsupported with the linear one.
    fn nonlinear_level(&self, level: u32) -> Result<&Cells, Fault> {
        if self.is_nonlinear() {
            self.level_in_step(level)
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
        summary: c"cubic cells of an octree that a surface touches or encloses (Qi, Zhu and Fan 2019)",
        params: &[Param::choice(
            c"embedding",
            c"trilinear|paper-ratio",
            c"how the surface follows its cells: trilinear, exact for affine motion; or the rule of the paper",
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
        let (_, cells) = self.tree_and_level(level)?;
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
        let (tree, cells) = self.tree_and_level(level)?;
        tree.cell(cells, id)
    }

    fn locate(&self, level: u32, point: [f64; 3]) -> Result<Location, Fault> {
        let lattice = &self.tree_and_level(level)?.1.lattice;
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Fault::bad_argument(format!("point to locate is not finite: {point:?}")));
        }
        let scaled = lattice.in_cells(point);
        let index = lattice.cell_of(scaled);
        let local = [0, 1, 2].map(|axis| (scaled[axis] - f64::from(index[axis])).clamp(0.0, 1.0));
        Ok(Location { cell: lattice.id(index), local })
    }

    fn points(&self, level: u32) -> Result<&[u32], Fault> {
        Ok(self.tree_and_level(level)?.0.points.indices())
    }

    fn region(&self, request: &RegionRequest<'_>, out: &mut RegionSink<'_>) -> Result<(), Fault> {
        let (tree, cells) = self.tree_and_level(request.level)?;
        region::list_region(tree, cells, request, out)
    }

    fn weights(
        &self,
        level: u32,
        positions: &[[f64; 3]],
        ids: &mut [u64],
        weights: &mut [[f64; 8]],
    ) -> Result<(), Fault> {
        let cells = self.level_in_step(level)?;
        for ((position, id), weights) in positions.iter().zip(ids).zip(weights) {
            let point = EmbeddedPoint::find(cells, *position)?;
            (*id, *weights) = point.map_or((NO_CELL, [0.0; 8]), |p| (cells.lattice.id(p.cell), p.weights()));
        }
        Ok(())
    }

    fn place(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        corners: &[[[f64; 3]; 8]],
        positions: &mut [[f64; 3]],
    ) -> Result<(), Fault> {
        let cells = self.nonlinear_level(level)?;
        for ((rest, corners), position) in rest.iter().zip(corners).zip(positions) {
            *position = EmbeddedPoint::new(cells, *rest)?.ratio_position(&corners.map(Vec3)).0;
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
        let cells = self.nonlinear_level(level)?;
        for (((rest, corners), load), corner_loads) in rest.iter().zip(corners).zip(loads).zip(corner_loads) {
            EmbeddedPoint::new(cells, *rest)?.add_ratio_loads(&corners.map(Vec3), Vec3(*load), corner_loads);
        }
        Ok(())
    }

    fn is_nonlinear(&self) -> bool {
        self.embedding == Embedding::PaperRatio
    }
}
