//! The connected parts of a whole lattice, active or not, and the lattice of some of them: of a part of a body that becomes a body of its own.

use super::fragments::{CellFragment, Fragments};
use super::{CellSource, Lattice, LatticeError, LatticeState};
use crate::body::grid_pool::PooledGrid;
use bytemuck::cast_slice;
use pliant_host::Region;
use pliant_mesh::DisjointSets;
use pliant_mesh::Surface;
use pliant_plugin_api::abi::Ball;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Component of a vertex that is embedded in no cell.
pub(in crate::body) const NO_COMPONENT: u32 = u32::MAX;

/// The connected components of all occupied cells of a lattice.
pub(in crate::body) struct LatticeComponents {
    /// Every occupied cell and fragment with its component, from 0.
    pub cells: Vec<(CellFragment, u32)>,
    /// Component in which each vertex is embedded, or [`NO_COMPONENT`] (n).
    pub of_vertex: Vec<u32>,
    /// Id of the cell in which each vertex is embedded, if it is (n).
    pub cell_of_vertex: Vec<u64>,
    /// Number of components.
    pub count: u32,
}

/// The cells of a part of a lattice.
pub(in crate::body) struct PartCells {
    own: HashSet<CellFragment>,
    /// Cells that no blade has cut and that are in other parts.
    absent: Vec<u64>,
}

/// A part of a lattice with its state.
pub(in crate::body) struct LatticePart {
    /// The lattice, without active nodes.
    pub lattice: Lattice,
    /// Its state, to be restored.
    pub state: LatticeState,
    /// New number of each active node of the whole, or `u32::MAX` for one of another part (n).
    pub node_number: Vec<u32>,
}

impl Lattice {
    /// The connected components of all occupied cells; `vertices` is the number of vertices of the model.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn components(&self, vertices: usize) -> Result<LatticeComponents, LatticeError> {
        let region = self.whole_region()?;
        let mut sets = DisjointSets::new(region.node_id.len());
        for corners in &region.cell_corners {
            corners[1..].iter().for_each(|node| sets.unite(corners[0], *node));
        }
        let mut number = HashMap::new();
        let mut components = LatticeComponents {
            cells: Vec::new(),
            of_vertex: vec![NO_COMPONENT; vertices],
            cell_of_vertex: vec![0; vertices],
            count: 0,
        };
        for (cell, corners) in region.cell_corners.iter().enumerate() {
            let next = number.len() as u32;
            let component = *number.entry(sets.find(corners[0])).or_insert(next);
            components.cells.push((fragment(&region, cell), component));
        }
        self.for_points(&region, |cell, point| {
            let (fragment, component) = components.cells[cell];
            components.of_vertex[point as usize] = component;
            components.cell_of_vertex[point as usize] = fragment.cell;
        })?;
        components.count = number.len() as u32;
        Ok(components)
    }

    /// All occupied cells and fragments with their nodes.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn whole_region(&self) -> Result<Region, LatticeError> {
        let all = [Ball { centre: self.facts.origin, radius: f64::INFINITY }];
        let mut region = Region::default();
        self.source.region(self.settings.level, 0, &all, &[], &mut region)?;
        if self.fragments.is_part() {
            let present: Vec<bool> = region.cell_id.iter().map(|id| !self.fragments.is_absent(*id)).collect();
            region.retain_cells(|cell| present[cell]);
        }
        if self.has_cuts() {
            let mut divided = Region::default();
            self.fragments.apply(&region, 0, &mut divided);
            region = divided;
        }
        Ok(region)
    }

    /// Calls `visit` with the cells of a region and each of the surface points that are embedded in them.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn for_points(&self, region: &Region, mut visit: impl FnMut(usize, u32)) -> Result<(), LatticeError> {
        let listed = self.source.points(self.settings.level)?;
        for (cell, [begin, end]) in region.cell_points.iter().enumerate() {
            let of_grid = &listed[*begin as usize..*end as usize];
            let points = self.fragments.points(fragment(region, cell)).unwrap_or(of_grid);
            points.iter().for_each(|point| visit(cell, *point));
        }
        Ok(())
    }

    /// Whether cuts since the last [`Lattice::follow`] have changed the active nodes, so that a call of it is due.
    pub(crate) fn is_outdated(&self) -> bool {
        self.needs_rebuild
    }

    /// Balls around contacts for which cells are active at present.
    pub(in crate::body) fn present_balls(&self) -> Vec<Ball> {
        self.contact_balls.clone()
    }

    /// The lattice of a part: the same cells of a grid that is built once more around `around`, the surface of the file of the whole, placed (m), and of these
    /// those of the part. `owns` tells of each vertex of the model whether it is in the part.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn part(
        &self,
        cells: &PartCells,
        around: &Arc<Surface>,
        owns: impl Fn(u32) -> bool,
    ) -> Result<Option<LatticePart>, LatticeError> {
        let Some(plugin) = self.source.plugin() else { return Ok(None) };
        let mut grid = plugin.reopen()?;
        grid.build(cast_slice(&around.points), &around.triangles, self.settings.level)?;
        let key = format!("{} in part", self.key);
        let source = CellSource::Grid(PooledGrid::new(key.clone(), grid, &Arc::default()));
        let mut lattice = Self::new(source, key, self.settings, self.families)?;
        lattice.most_cells = self.most_cells;
        (lattice.fields, lattice.fibres, lattice.stiffness) =
            (self.fields.clone(), self.fibres.clone(), self.stiffness);
        lattice.built_around = Some(Arc::clone(around));
        let own = |fragment: CellFragment| cells.own.contains(&fragment);
        let mut region = self.region.clone();
        let fragments: Vec<CellFragment> = (0..region.cell_id.len() as u32).map(|c| self.cell_fragment(c)).collect();
        let node_number = region.retain_cells(|cell| own(fragments[cell]));
        let kept = fragments.iter().copied().filter(|fragment| own(*fragment));
        for (number, fragment) in region.cell_fragment.iter_mut().zip(kept) {
            *number = Fragments::number_in_part(own, fragment) as u8;
        }
        let fragments = self.fragments.of_part(own, cells.absent.iter().copied());
        lattice.fragments = fragments.clone();
        let state = LatticeState {
            region,
            fragments,
            bindings: self.bindings.of_part(&owns),
            paint: self.paint.of_part(&owns),
            needs_rebuild: false,
            ..self.save()
        };
        Ok(Some(LatticePart { lattice, state, node_number }))
    }

    /// The surface that the grid was built around, placed (m); `None` if it is that of the model's file.
    pub(in crate::body) fn built_around(&self) -> Option<&Arc<Surface>> {
        self.built_around.as_ref()
    }

    /// Whether a blade has ever cut the cell of a fragment.
    fn is_cut_cell(&self, fragment: CellFragment) -> bool {
        self.fragments.contains(fragment.cell)
    }
}

/// A cell of a region as a fragment.
pub(super) fn fragment(region: &Region, cell: usize) -> CellFragment {
    CellFragment { cell: region.cell_id[cell], fragment: usize::from(region.cell_fragment[cell]) }
}

impl PartCells {
    /// The cells of `lattice` whose component is `own`.
    pub fn new(lattice: &Lattice, components: &LatticeComponents, own: impl Fn(u32) -> bool) -> Self {
        let (mut cells, mut absent) = (HashSet::new(), Vec::new());
        for &(fragment, component) in &components.cells {
            if own(component) {
                cells.insert(fragment);
            } else if !lattice.is_cut_cell(fragment) {
                absent.push(fragment.cell);
            }
        }
        Self { own: cells, absent }
    }
}
