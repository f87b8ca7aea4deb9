//! Corrects the part of the lattice in which surface points are embedded, after a cut.
//!
//! The fragment of a point follows from voxels, and where a cut grazes an edge or a thin place it can be on the wrong side. When the parts of
//! the lattice move apart, triangles are then stretched between them. The mesh is exact: a shell, a connected part of the surface, lies in
//! one part. So points in cut cells are embedded in the part that most of their shell lies in.

use super::fragments::CellFragment;
use super::parts::NO_COMPONENT;
use super::point_bindings::BoundPoint;
use super::{Lattice, LatticeError};
use crate::body::model::Model;
use crate::body::skin::{NOT_EMBEDDED, Skin};
use pliant_solver::Vec3;
use std::collections::{BTreeMap, BTreeSet, HashMap};

impl Lattice {
    /// Embeds points in cut cells anew, in the nearest cut cell of the part that most of their shell lies in. A shell that reaches into
    /// whole cells of another part is left: there the lattice is divided and the mesh is not.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn rebind_torn_triangles(&mut self, model: &Model, skin: &mut Skin) -> Result<(), LatticeError> {
        let part_of = self.parts();
        let part = |lattice: &Self, cell: u32| part_of[lattice.region.cell_corners[cell as usize][0] as usize];
        if !self.has_torn_triangles(model, skin, |cell| part(self, cell))? {
            return Ok(());
        }
        let embedding = |v: u32| {
            let cell = Some(skin.cell[v as usize]).filter(|cell| *cell != NOT_EMBEDDED)?;
            Some((part(self, cell), self.fragments.contains(self.region.cell_id[cell as usize])))
        };
        for (v, most) in torn_vertices(model, embedding) {
            if let Some(cell) = self.nearest_cut_cell(v, model, |cell| part(self, cell) == most) {
                self.rebind(v, cell, model, skin);
            }
        }
        Ok(())
    }

    /// Does what [`Lattice::rebind_torn_triangles`] does for a local region, whose parts may be connected outside of it: it looks at all cells. Nodes and elements
    /// change with the next [`Lattice::follow`].
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn rebind_torn_shells(&mut self, model: &Model) -> Result<(), LatticeError> {
        let components = self.components(model.surface.points.len())?;
        let embedding = |v: u32| {
            let component = Some(components.of_vertex[v as usize]).filter(|component| *component != NO_COMPONENT)?;
            Some((component, self.fragments.contains(components.cell_of_vertex[v as usize])))
        };
        let torn = torn_vertices(model, embedding);
        let middle: HashMap<u64, Vec3> = self.fragments.centres().collect();
        for &(v, most) in &torn {
            let place = self.binding_place(v, model.surface.points[v as usize]);
            let cut = components.cells.iter().filter(|(_, component)| *component == most);
            let near = cut.filter_map(|(at, _)| Some((*at, (middle.get(&at.cell)? - place).norm_squared())));
            if let Some((fragment, _)) = near.min_by(|a, b| a.1.total_cmp(&b.1)) {
                self.bind_to(v, fragment, components.cell_of_vertex[v as usize], place);
            }
        }
        self.needs_rebuild |= !torn.is_empty();
        Ok(())
    }

    /// Whether a triangle with a corner in a cut cell has corners in several parts; `part` gives the part of an active cell.
    fn has_torn_triangles(&self, model: &Model, skin: &Skin, part: impl Fn(u32) -> u32) -> Result<bool, LatticeError> {
        let is_torn = |t: u32| {
            let cells = model.surface.triangles[t as usize].map(|v| skin.cell[v as usize]);
            let mut parts = cells.into_iter().filter(|cell| *cell != NOT_EMBEDDED).map(&part);
            let first = parts.next();
            parts.any(|other| Some(other) != first)
        };
        for cell in self.active_cut_cells() {
            let mut around = self.points(cell)?.iter().flat_map(|v| model.around(*v));
            if around.any(|t| !model.is_lid(*t) && is_torn(*t)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Active cells that are fragments of cut ones.
    fn active_cut_cells(&self) -> impl Iterator<Item = u32> + '_ {
        let cells = self.region.cell_id.iter().enumerate();
        cells.filter(|(_, id)| self.fragments.contains(**id)).map(|(cell, _)| cell as u32)
    }

    /// The wanted cut cell whose centre is nearest to a vertex.
    fn nearest_cut_cell(&self, v: u32, model: &Model, is_wanted: impl Fn(u32) -> bool) -> Option<u32> {
        let place = self.binding_place(v, model.surface.points[v as usize]);
        let distance = |cell: &u32| {
            let corners = self.region.cell_corners[*cell as usize];
            (0.5 * (self.grid_rest(corners[0]) + self.grid_rest(corners[7])) - place).norm_squared()
        };
        self.active_cut_cells().filter(|cell| is_wanted(*cell)).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Embeds a vertex in another active cell.
    fn rebind(&mut self, v: u32, cell: u32, model: &Model, skin: &mut Skin) {
        let place = self.binding_place(v, model.surface.points[v as usize]);
        let old_cell = self.region.cell_id[skin.cell[v as usize] as usize];
        self.bind_to(v, self.cell_fragment(cell), old_cell, place);
        skin.cell[v as usize] = cell;
        let longest = &mut self.longest_edge_of[cell as usize];
        *longest = longest.max(model.longest_edge(v));
    }

    /// Embeds a vertex that is embedded in `old_cell` in another fragment, at a rest position (m).
    fn bind_to(&mut self, v: u32, fragment: CellFragment, old_cell: u64, place: Vec3) {
        let containing = self.bindings.containing(v, old_cell);
        let old_cell = self.bindings.remove(v).unwrap_or(old_cell);
        self.fragments.release_point(old_cell, v);
        let anchor = self.fragments.anchor_in(fragment, place);
        self.bind(BoundPoint { point: v, containing }, &anchor);
    }
}

/// Vertices in cut cells of another part of the lattice than most of their shell, each with that part. `embedding` gives the part in which a vertex is, and
/// whether its cell is cut. A shell that reaches into whole cells of another part is left there.
fn torn_vertices(model: &Model, embedding: impl Fn(u32) -> Option<(u32, bool)>) -> Vec<(u32, u32)> {
    // Corners of triangles by shell and part.
    let mut counts: BTreeMap<u32, BTreeMap<u32, usize>> = BTreeMap::new();
    // Shells and parts, where the shell has a corner in a whole cell of the part.
    let mut reaches_whole_cells: BTreeSet<(u32, u32)> = BTreeSet::new();
    // Vertices in cut cells, with their shells and parts.
    let mut candidates: BTreeMap<u32, (u32, u32)> = BTreeMap::new();
    let triangles = model.surface.triangles.iter().zip(model.surface.shells()).enumerate();
    for (_, (corners, shell)) in triangles.filter(|(t, _)| !model.is_lid(*t as u32)) {
        for &v in corners {
            let Some((part, is_cut)) = embedding(v) else { continue };
            *counts.entry(shell).or_default().entry(part).or_default() += 1;
            if is_cut {
                candidates.insert(v, (shell, part));
            } else {
                reaches_whole_cells.insert((shell, part));
            }
        }
    }
    let most = |shell: u32| counts[&shell].iter().max_by_key(|(_, count)| **count).map(|(part, _)| *part);
    let torn = candidates.into_iter().filter_map(|(v, (shell, own))| Some((v, shell, own, most(shell)?)));
    let torn = torn.filter(|(_, shell, own, most)| most != own && !reaches_whole_cells.contains(&(*shell, *own)));
    torn.map(|(v, _, _, most)| (v, most)).collect()
}
