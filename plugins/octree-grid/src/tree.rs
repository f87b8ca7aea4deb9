//! The octree: all levels around one surface.
//!
//! No tree node is stored. What the paper stores in each (pointers to parent and children, reference point, centre, edge) follows from the
//! id and is computed on request.

use crate::cells::Cells;
use crate::lattice::Lattice;
use crate::points::Points;
use crate::scaled_surface::{ScaledSurface, used_points};
use crate::states::{EMPTY, classify, coarsen};
use pliant_plugin_api::{Fault, SurfaceView, abi};

/// Bytes per cube of the finest level, an upper bound: three during classification, or one and the three that are stored where the body
/// fills its box; and the coarser levels.
const BYTES_PER_CELL: f64 = 5.0;
/// Memory above which a level is refused, bytes.
const MAX_BYTES: f64 = (1_u64 << 30) as f64;

/// All levels, and the surface points sorted by cell.
pub(crate) struct Tree {
    /// Level 1 first.
    levels: Vec<Cells>,
    pub(crate) points: Points,
}

impl Tree {
    /// Builds levels 1 to `level` around a surface.
    ///
    /// # Errors
    /// A level that needs too much memory, or an unusable surface.
    pub(crate) fn build(surface: &SurfaceView<'_>, level: u32) -> Result<Self, Fault> {
        // The cells of level 22 do not fit into 64 bits.
        let cells = |level: u32| 8_u64.pow(level.clamp(1, 21) - 1);
        let gigabytes = |level: u32| BYTES_PER_CELL * cells(level) as f64 / MAX_BYTES;
        let finest_allowed = (1..).take_while(|&level| gigabytes(level) <= 1.0).count() as u32;
        if !(1..=finest_allowed).contains(&level) {
            let size = format!("{:.1} GiB or more for {} cells", gigabytes(level), cells(level));
            let allowed = format!("allowed are 1 to {finest_allowed}, for 1 GiB");
            return Err(Fault::bad_argument(format!("level {level} needs {size}: {allowed}")));
        }
        let used = used_points(surface)?;
        let corners = surface.points.iter().zip(&used).filter(|(_, used)| **used).map(|(point, _)| point);
        let root = Lattice::root(corners)?;
        let lattice = root.at_level(level);
        let scaled = ScaledSurface::new(surface, &lattice);
        let points = Points::new(&scaled, &used, &lattice);
        let mut states = classify(&scaled, &lattice);
        let mut levels = Vec::new();
        for level in (1..=level).rev() {
            let lattice = root.at_level(level);
            let coarse = if level > 1 { coarsen(&states, lattice.cells / 2) } else { Vec::new() };
            levels.push(Cells::new(lattice, std::mem::replace(&mut states, coarse)));
        }
        levels.reverse();
        Ok(Self { levels, points })
    }

    /// The finest level.
    pub(crate) fn finest(&self) -> u32 {
        self.levels.len() as u32
    }

    /// One level, if it was built.
    pub(crate) fn level(&self, level: u32) -> Option<&Cells> {
        self.levels.get((level as usize).checked_sub(1)?)
    }

    /// Describes a cell, occupied or not.
    pub(crate) fn cell(&self, cells: &Cells, id: u64) -> Result<abi::Cell, Fault> {
        let lattice = &cells.lattice;
        if id >= lattice.count() {
            let (level, last) = (lattice.level, lattice.count() - 1);
            return Err(Fault::bad_argument(format!("cell {id} of level {level}: ids are 0 to {last}")));
        }
        let index = lattice.index(id);
        let occupied_id = |level: u32, index| match self.level(level) {
            Some(cells) if cells.state(index) != EMPTY => cells.lattice.id(index),
            _ => abi::NO_CELL,
        };
        let child = |c: u32| [0, 1, 2].map(|axis| 2 * index[axis] + (c >> axis & 1));
        let reference = lattice.corner(index);
        let points = self.points.range(lattice.level, index);
        Ok(abi::Cell {
            size: size_of::<abi::Cell>(),
            id,
            parent: occupied_id(lattice.level - 1, index.map(|i| i / 2)),
            children: [0, 1, 2, 3, 4, 5, 6, 7].map(|c| occupied_id(lattice.level + 1, child(c))),
            index,
            state: u32::from(cells.state(index)),
            reference,
            centre: reference.map(|x| x + 0.5 * lattice.edge),
            edge: lattice.edge,
            point_begin: points.start,
            point_end: points.end,
        })
    }
}
