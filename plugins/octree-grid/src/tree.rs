//! All levels around one surface.
//!
//! No node is stored as such: what the paper keeps in each (pointers to parent and children, reference point, centre,
//! edge) follows from its id, and is computed when it is asked for.

use crate::cells::Cells;
use crate::lattice::Lattice;
use crate::points::Points;
use crate::shape::{Shape, used};
use crate::states::{EMPTY, coarser, finest};
use pliant_plugin_api::{Fault, SurfaceView, abi};

/// Bytes for each cube of the finest level: three while classifying, or where the body fills the box one beside the
/// three that are stored, and what the levels above add.
const BYTES_PER_CELL: f64 = 5.0;
/// Bytes; it is the level, and not the surface, that is refused above it.
const MOST_BYTES: f64 = (1_u64 << 30) as f64;

/// Levels 1 to `levels.len()` and the points in their cells.
pub(crate) struct Tree {
    levels: Vec<Cells>,
    pub(crate) points: Points,
}

impl Tree {
    pub(crate) fn build(surface: &SurfaceView<'_>, level: u32) -> Result<Self, Fault> {
        // A level above 21 is as bad as that one, and fits no number.
        let cells = |level: u32| 8_u64.pow(level.clamp(1, 21) - 1);
        let gigabytes = |level: u32| BYTES_PER_CELL * cells(level) as f64 / MOST_BYTES;
        let most = (1..).take_while(|&level| gigabytes(level) <= 1.0).count() as u32;
        if !(1..=most).contains(&level) {
            let size = format!("{:.1} GiB or more for {} cells", gigabytes(level), cells(level));
            return Err(Fault::bad_argument(format!("level {level} needs {size}: allowed are 1 to {most}, for 1 GiB")));
        }
        let used = used(surface)?;
        let corners = surface.points.iter().zip(&used).filter(|(_, used)| **used).map(|(point, _)| point);
        let root = Lattice::root(corners)?;
        let lattice = root.at(level);
        let shape = Shape::new(surface, &lattice);
        let points = Points::new(&shape, &used, &lattice);
        let mut states = finest(&shape, &lattice);
        let mut levels = Vec::new();
        for level in (1..=level).rev() {
            let lattice = root.at(level);
            let above = if level > 1 { coarser(&states, lattice.cells / 2) } else { Vec::new() };
            levels.push(Cells::new(lattice, std::mem::replace(&mut states, above)));
        }
        levels.reverse();
        Ok(Self { levels, points })
    }

    pub(crate) fn finest(&self) -> u32 {
        self.levels.len() as u32
    }

    pub(crate) fn level(&self, level: u32) -> Option<&Cells> {
        self.levels.get((level as usize).checked_sub(1)?)
    }

    /// One node of the tree; `id` of any cube of the level, occupied or not.
    pub(crate) fn cell(&self, cells: &Cells, id: u64) -> Result<abi::Cell, Fault> {
        let lattice = &cells.lattice;
        if id >= lattice.count() {
            let (level, last) = (lattice.level, lattice.count() - 1);
            return Err(Fault::bad_argument(format!("cell {id} of level {level}: ids are 0 to {last}")));
        }
        let index = lattice.index(id);
        let occupied = |level: u32, index| match self.level(level) {
            Some(cells) if cells.state(index) != EMPTY => cells.lattice.id(index),
            _ => abi::NO_CELL,
        };
        let child = |c: u32| [0, 1, 2].map(|axis| 2 * index[axis] + (c >> axis & 1));
        let reference = lattice.corner(index);
        let points = self.points.range(lattice.level, index);
        Ok(abi::Cell {
            size: size_of::<abi::Cell>(),
            id,
            parent: occupied(lattice.level - 1, index.map(|i| i / 2)),
            children: [0, 1, 2, 3, 4, 5, 6, 7].map(|c| occupied(lattice.level + 1, child(c))),
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
