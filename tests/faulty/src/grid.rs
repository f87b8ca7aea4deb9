//! A grid of one level that occupies the whole bounding box of the surface.

use crate::{AFTER, fault, info};
use pliant_plugin_api::abi::{self, Cell, Level};
use pliant_plugin_api::{Fault, Grid, Info, Location, Param, Params, RegionRequest, RegionSink, SurfaceView};

/// A grid with the fault `F` (see [`fault`]), whose cells all belong to the body.
pub struct BoxGrid<const F: u8> {
    /// Cells along each axis.
    cells: u32,
    /// Corner with the least coordinates, m.
    origin: [f64; 3],
    /// Length of a cell's edge, m.
    edge: f64,
    /// Surface points, sorted by cell.
    points: Vec<u32>,
    /// Where the points of each cell begin in `points`; one more than there are cells.
    start: Vec<u32>,
}

impl<const F: u8> BoxGrid<F> {
    /// Index of a cell or node from its indices along the axes, with `count` of them along each axis, x fastest.
    fn index(count: u32, [i, j, k]: [u32; 3]) -> u32 {
        i + count * (j + count * k)
    }

    /// Indices along the axes of every cell or node, in the order of [`Self::index`].
    fn all(count: u32) -> impl Iterator<Item = [u32; 3]> {
        (0..count.pow(3)).map(move |i| [i % count, i / count % count, i / count / count])
    }

    /// Node at a corner of the cell `at`.
    fn corner(at: [u32; 3], corner: u32) -> [u32; 3] {
        [at[0] + (corner & 1), at[1] + (corner >> 1 & 1), at[2] + (corner >> 2)]
    }

    /// Cell of a point, clamped to the grid, and coordinates in it.
    fn locate_cell(&self, point: [f64; 3]) -> ([u32; 3], [f64; 3]) {
        let local: [f64; 3] = std::array::from_fn(|i| (point[i] - self.origin[i]) / self.edge);
        let cell = local.map(|c| (c.max(0.0) as u32).min(self.cells - 1));
        (cell, std::array::from_fn(|i| (local[i] - f64::from(cell[i])).clamp(0.0, 1.0)))
    }

    /// Lists links along edges and face diagonals.
    fn links(&self, families: u32, out: &mut RegionSink<'_>) {
        let n = self.cells + 1;
        let steps = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1]];
        for at in Self::all(n) {
            for step in steps {
                let to = [at[0] + step[0], at[1] + step[1], at[2] + step[2]];
                let family = if step.iter().sum::<u32>() == 1 { abi::STRUCTURAL } else { abi::SHEAR };
                if to.iter().all(|c| *c < n) && families & family != 0 {
                    out.link([Self::index(n, at), Self::index(n, to)], family, 1.0);
                }
            }
        }
        if F == fault::LINK_TO_NOWHERE {
            out.link([0, 1 << 30], abi::STRUCTURAL, 1.0);
        }
    }
}

impl<const F: u8> Grid for BoxGrid<F> {
    const INFO: Info = info(
        match F {
            fault::PANIC => c"panics-in-build",
            fault::NAN => c"weights-not-a-number",
            fault::REFUSES => c"refuses-in-build",
            fault::DESCENDING_IDS => c"descending-ids",
            fault::LINK_TO_NOWHERE => c"link-to-nowhere",
            fault::WEIGHTS_TOO_LARGE => c"weights-too-large",
            fault::WEIGHTS_SWAPPED => c"weights-swapped",
            fault::PULLS_BACK_MORE => c"pulls-back-more",
            fault::CELLS_DISTORTED => c"cells-distorted",
            fault::REGION_OUTSIDE => c"region-outside",
            fault::HIDES_SURFACE => c"hides-surface",
            fault::WEIGHTS_PAST => c"weights-past",
            _ => c"sound-brick",
        },
        const { &[AFTER] as &[Param] },
    );

    fn new(_: &Params<'_>) -> Result<Self, Fault> {
        Ok(Self { cells: 0, origin: [0.0; 3], edge: 0.0, points: Vec::new(), start: Vec::new() })
    }

    fn build(&mut self, surface: &SurfaceView<'_>, level: u32) -> Result<(), Fault> {
        assert!(F != fault::PANIC, "panicked on purpose, in build");
        if F == fault::REFUSES {
            return Err(Fault::io("refused on purpose"));
        }
        let bound =
            |i: usize, pick: fn(f64, f64) -> f64| surface.points.iter().map(|p| p[i]).reduce(pick).unwrap_or(0.0);
        self.origin = std::array::from_fn(|i| bound(i, f64::min) - 1e-6);
        let longest = (0..3).map(|i| bound(i, f64::max) + 1e-6 - self.origin[i]).fold(0.0, f64::max);
        self.cells = 1 << (level.clamp(1, 6) - 1);
        self.edge = longest / f64::from(self.cells);
        let cell_of = |v: &u32| Self::index(self.cells, self.locate_cell(surface.points[*v as usize]).0);
        let mut points: Vec<u32> = (0..surface.points.len() as u32).collect();
        points.sort_by_key(cell_of);
        let begin = |cell: u32| points.partition_point(|v| cell_of(v) < cell) as u32;
        self.start = (0..=self.cells.pow(3)).map(begin).collect();
        self.points = points;
        Ok(())
    }

    fn level(&self, level: u32) -> Result<Level, Fault> {
        let (size, cells, n) = (size_of::<Level>(), u64::from(self.cells), u64::from(self.cells) + 1);
        let (surface_cells, inside_cells, nodes) = (cells.pow(3), 0, n.pow(3));
        let (cells_per_axis, edge, origin) = (self.cells, self.edge, self.origin);
        Ok(Level { size, level, cells_per_axis, edge, origin, surface_cells, inside_cells, nodes })
    }

    fn cell(&self, _: u32, _: u64) -> Result<Cell, Fault> {
        Err(Fault::unsupported("a brick has no tree"))
    }

    fn locate(&self, _: u32, point: [f64; 3]) -> Result<Location, Fault> {
        let (cell, local) = self.locate_cell(point);
        Ok(Location { cell: u64::from(Self::index(self.cells, cell)), local })
    }

    fn points(&self, _: u32) -> Result<&[u32], Fault> {
        Ok(&self.points)
    }

    fn region(&self, request: &RegionRequest<'_>, out: &mut RegionSink<'_>) -> Result<(), Fault> {
        let (m, n) = (self.cells, self.cells + 1);
        for (id, at) in Self::all(n).enumerate() {
            let around: u32 = at.iter().map(|&c| if c == 0 || c == m { 1 } else { 2 }).product();
            let rest = std::array::from_fn(|i| self.origin[i] + self.edge * f64::from(at[i]));
            out.node(id as u64, rest, self.edge.powi(3) * f64::from(around) / 8.0, false);
        }
        if F == fault::REGION_OUTSIDE && request.balls.iter().any(|b| b.radius.is_finite()) {
            out.node(u64::from(n.pow(3)), self.origin.map(|c| c - self.edge), 1e-9, false);
        }
        if F == fault::DESCENDING_IDS {
            out.node(0, self.origin, 1e-9, false);
        }
        let state = if F == fault::HIDES_SURFACE { abi::CELL_INSIDE } else { abi::CELL_SURFACE };
        for (id, at) in Self::all(m).enumerate() {
            let mut corners: [u32; 8] = std::array::from_fn(|c| Self::index(n, Self::corner(at, c as u32)));
            if F == fault::CELLS_DISTORTED && self.start[id] == self.start[id + 1] {
                corners.swap(2, 3); // no surface point lies in this cell, so no other case notices
            }
            out.cell(id as u64, corners, [self.start[id], self.start[id + 1]], state);
        }
        self.links(request.families, out);
        Ok(())
    }

    fn weights(
        &self,
        _: u32,
        positions: &[[f64; 3]],
        cells: &mut [u64],
        weights: &mut [[f64; 8]],
    ) -> Result<(), Fault> {
        if F == fault::WEIGHTS_PAST {
            let behind = weights.as_mut_ptr().wrapping_add(weights.len()).cast();
            crate::write_same(behind);
        }
        for ((position, cell), weights) in positions.iter().zip(cells).zip(weights) {
            let (at, local) = self.locate_cell(*position);
            *cell = u64::from(Self::index(self.cells, at));
            let share = |corner: usize, i: usize| if corner >> i & 1 == 1 { local[i] } else { 1.0 - local[i] };
            *weights = std::array::from_fn(|corner| (0..3).map(|i| share(corner, i)).product());
            match F {
                fault::NAN => *weights = [f64::NAN; 8],
                fault::WEIGHTS_TOO_LARGE => *weights = weights.map(|w| 1.01 * w),
                fault::WEIGHTS_SWAPPED => weights.swap(1, 2),
                _ => {}
            }
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
        for ((rest, corners), position) in rest.iter().zip(corners).zip(positions) {
            let (mut cell, mut w) = ([0], [[0.0; 8]]);
            self.weights(level, &[*rest], &mut cell, &mut w)?;
            *position = [0, 1, 2].map(|i| (0..8).map(|c| w[0][c] * corners[c][i]).sum());
        }
        Ok(())
    }

    fn pull_back(
        &self,
        level: u32,
        rest: &[[f64; 3]],
        _: &[[[f64; 3]; 8]],
        loads: &[[f64; 3]],
        corner_loads: &mut [[[f64; 3]; 8]],
    ) -> Result<(), Fault> {
        for ((rest, load), sum) in rest.iter().zip(loads).zip(corner_loads) {
            let (mut cell, mut w) = ([0], [[0.0; 8]]);
            self.weights(level, &[*rest], &mut cell, &mut w)?;
            (0..8).for_each(|c| (0..3).for_each(|i| sum[c][i] += 1.01 * w[0][c] * load[i]));
        }
        Ok(())
    }

    /// `place` is linear, but with this fault the host is told to use it.
    fn is_nonlinear(&self) -> bool {
        F == fault::PULLS_BACK_MORE
    }
}
