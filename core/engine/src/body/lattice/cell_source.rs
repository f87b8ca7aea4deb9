//! Where the cells of a lattice come from: cubes of a grid plugin, or the tetrahedra of a file.

use super::LatticeError;
use super::tetrahedral_cells::TetrahedralCells;
use crate::body::grid_pool::PooledGrid;
use pliant_host::{Grid, HostError, Region};
use pliant_plugin_api::CELL_TETRAHEDRA;
use pliant_plugin_api::abi::{Ball, Level};
use pliant_solver::Vec3;
use std::sync::Arc;

/// Where the cells of a lattice come from.
pub enum CellSource {
    /// Cubes of a grid plugin that was built around the surface.
    Grid(PooledGrid),
    /// Tetrahedra of a file.
    Tetrahedra(Arc<TetrahedralCells>),
}

/// A tetrahedron as a part of its cell: its first four corners.
const WHOLE_CELL: [[u8; 4]; 1] = [[0, 1, 2, 3]];

impl CellSource {
    /// The grid plugin; `None` for tetrahedra of a file.
    pub fn plugin(&self) -> Option<&Grid> {
        match self {
            Self::Grid(grid) => Some(grid),
            Self::Tetrahedra(_) => None,
        }
    }

    /// The tetrahedra of a file; `None` for a grid plugin.
    pub fn tetrahedra(&self) -> Option<&Arc<TetrahedralCells>> {
        match self {
            Self::Grid(_) => None,
            Self::Tetrahedra(cells) => Some(cells),
        }
    }

    /// Name of the kind of source, for messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Grid(_) => "grid",
            Self::Tetrahedra(_) => "tetrahedral mesh",
        }
    }

    /// Name for messages: the id of the grid plugin, or what stands in its place.
    pub fn name(&self) -> &str {
        self.plugin().map_or("its tetrahedra", |grid| grid.info().id.as_str())
    }

    /// Origin, edge, and numbers of cells and nodes of a level; tetrahedra have one, whose edge is their mean edge.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn level(&self, level: u32) -> Result<Level, HostError> {
        match self {
            Self::Grid(grid) => grid.level(level),
            Self::Tetrahedra(cells) => Ok(cells.facts()),
        }
    }

    /// Surface points, sorted by cell.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn points(&self, level: u32) -> Result<&[u32], HostError> {
        match self {
            Self::Grid(grid) => grid.points(level),
            Self::Tetrahedra(cells) => Ok(cells.points()),
        }
    }

    /// Surface points in the cell with this id.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn points_of(&self, level: u32, id: u64) -> Result<&[u32], HostError> {
        match self {
            Self::Grid(grid) => {
                let facts = grid.cell(level, id)?;
                Ok(&grid.points(level)?[facts.point_begin..facts.point_end])
            }
            Self::Tetrahedra(cells) => Ok(cells.points_of(id as u32)),
        }
    }

    /// Fills `out` with the cells that the balls touch and those listed (ids, ascending), their nodes, and of a grid the links of `families`.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn region(
        &self,
        level: u32,
        families: u32,
        balls: &[Ball],
        listed: &[u64],
        out: &mut Region,
    ) -> Result<(), HostError> {
        match self {
            Self::Grid(grid) => grid.region(level, families, balls, listed, out),
            Self::Tetrahedra(cells) => {
                cells.region(balls, listed, out);
                Ok(())
            }
        }
    }

    /// Cell and weights of its corners for each rest position (m, p x 3).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn weights(
        &self,
        level: u32,
        positions: &[[f64; 3]],
        cells: &mut [u64],
        weights: &mut [[f64; 8]],
    ) -> Result<(), HostError> {
        match self {
            Self::Grid(grid) => grid.weights(level, positions, cells, weights),
            Self::Tetrahedra(of) => {
                of.weights(positions, cells, weights);
                Ok(())
            }
        }
    }

    /// The grid plugin, if its embedding is not linear: it places points itself.
    pub fn nonlinear(&self) -> Option<&Grid> {
        self.plugin().filter(|grid| grid.is_nonlinear())
    }

    /// Whether the embedding is not linear.
    pub fn is_nonlinear(&self) -> bool {
        self.nonlinear().is_some()
    }

    /// Tetrahedra of an active cell of `region`, by its corners: five of a cube, whose two mirrored divisions alternate so that the diagonals of common faces match.
    pub(super) fn tetrahedra_of(&self, region: &Region, facts: &Level, cell: u32) -> &'static [[u8; 4]] {
        let Self::Grid(_) = self else { return &WHOLE_CELL };
        let least = region.node_rest[region.cell_corners[cell as usize][0] as usize];
        let index = |i: usize| ((least[i] - facts.origin[i]) / facts.edge).round() as i64;
        &CELL_TETRAHEDRA[((index(0) + index(1) + index(2)) & 1) as usize]
    }

    /// Ids, ascending, of the cells that have a node at one of these rest positions (m), and possibly of others beside them.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn cells_around(
        &self,
        facts: &Level,
        nodes: impl Iterator<Item = Vec3>,
    ) -> Result<Vec<u64>, LatticeError> {
        let mut ids: Vec<u64> = Vec::new();
        match self {
            Self::Tetrahedra(cells) => nodes.for_each(|node| cells.cells_at(node, |cell| ids.push(cell.into()))),
            Self::Grid(grid) => {
                let reach = 0.25 * facts.edge;
                let towards =
                    |corner: usize| Vec3::from_fn(|axis, _| if corner >> axis & 1 == 1 { reach } else { -reach });
                // A point in each of the cells around each node.
                let points: Vec<[f64; 3]> =
                    nodes.flat_map(|place| (0..8).map(move |corner| (place + towards(corner)).into())).collect();
                let mut weights = vec![[0.0; 8]; points.len()];
                ids.resize(points.len(), pliant_plugin_api::abi::NO_CELL);
                grid.weights(facts.level, &points, &mut ids, &mut weights)?;
                ids.retain(|cell| *cell != pliant_plugin_api::abi::NO_CELL);
            }
        }
        ids.sort_unstable();
        ids.dedup();
        Ok(ids)
    }
}
