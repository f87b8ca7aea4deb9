//! Points of the surface that a cut has left with a part of the lattice their surface does not hang on.
//!
//! Which part of a cell carries a point is told in voxels, and where a cut grazes an edge or a thin place it can be the wrong one. When
//! the parts then move apart, triangles are drawn from one to the other. The mesh is exact: what hangs together in it goes with one part. Of
//! a shell that several parts carry, points in cut cells therefore go with the part that carries most of it.

use super::{Lattice, LatticeError};
use crate::body::model::Model;
use crate::body::skin::{NOT_CARRIED, Skin};
use std::collections::{BTreeMap, BTreeSet};

/// A connected part of the surface and a part of the lattice.
type Pair = (u32, u32);

impl Lattice {
    /// Binds strays to the nearest cut cell of the part that carries the most of their shell. A smaller share that reaches into whole
    /// cells is no stray: there the lattice is parted and the mesh is not.
    ///
    /// # Errors
    /// What the grid says.
    pub(super) fn rebind_strays(&mut self, model: &Model, skin: &mut Skin) -> Result<(), LatticeError> {
        let part_of = self.parts();
        let part = |lattice: &Self, cell: u32| part_of[lattice.region.cell_corners[cell as usize][0] as usize];
        if !self.has_torn_triangles(model, skin, |cell| part(self, cell))? {
            return Ok(());
        }
        let mut counts: BTreeMap<u32, BTreeMap<u32, usize>> = BTreeMap::new();
        let mut reaches_whole_cells: BTreeSet<Pair> = BTreeSet::new();
        let mut members: BTreeSet<(u32, u32)> = BTreeSet::new(); // vertices in cut cells, with their shells
        let triangles = model.surface.triangles.iter().zip(model.surface.shells()).enumerate();
        for (_, (corners, shell)) in triangles.filter(|(t, _)| !model.is_lid(*t as u32)) {
            for &v in corners {
                let cell = skin.cell[v as usize];
                if cell == NOT_CARRIED {
                    continue;
                }
                let of = part(self, cell);
                *counts.entry(shell).or_default().entry(of).or_default() += 1;
                if self.fragments.has(self.region.cell_id[cell as usize]) {
                    members.insert((v, shell));
                } else {
                    reaches_whole_cells.insert((shell, of));
                }
            }
        }
        for (v, shell) in members {
            let of = &counts[&shell];
            let most = of.iter().max_by_key(|(_, count)| **count).map(|(part, _)| *part);
            let own = part(self, skin.cell[v as usize]);
            let Some(most) = most.filter(|most| *most != own && !reaches_whole_cells.contains(&(shell, own))) else {
                continue;
            };
            if let Some(cell) = self.nearest_cut_cell(v, model, |cell| part(self, cell) == most) {
                self.rebind(v, cell, model, skin);
            }
        }
        Ok(())
    }

    /// Whether corners of a triangle with one in a cut cell go with several parts.
    fn has_torn_triangles(&self, model: &Model, skin: &Skin, part: impl Fn(u32) -> u32) -> Result<bool, LatticeError> {
        let is_torn = |t: u32| {
            let cells = model.surface.triangles[t as usize].map(|v| skin.cell[v as usize]);
            let mut parts = cells.into_iter().filter(|cell| *cell != NOT_CARRIED).map(&part);
            let first = parts.next();
            parts.any(|other| Some(other) != first)
        };
        for cell in self.cut_region_cells() {
            let mut around = self.points(cell)?.iter().flat_map(|v| model.around(*v));
            if around.any(|t| !model.is_lid(*t) && is_torn(*t)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Cells of the region that are parts of cut ones.
    fn cut_region_cells(&self) -> impl Iterator<Item = u32> + '_ {
        let cells = self.region.cell_id.iter().enumerate();
        cells.filter(|(_, id)| self.fragments.has(**id)).map(|(cell, _)| cell as u32)
    }

    fn nearest_cut_cell(&self, v: u32, model: &Model, is_wanted: impl Fn(u32) -> bool) -> Option<u32> {
        let place = self.bound_at(v, model.surface.points[v as usize]);
        let away = |cell: &u32| {
            let corners = self.region.cell_corners[*cell as usize];
            (0.5 * (self.grid_rest(corners[0]) + self.grid_rest(corners[7])) - place).norm_squared()
        };
        self.cut_region_cells().filter(|cell| is_wanted(*cell)).min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    /// Has a cell of the region carry a point.
    fn rebind(&mut self, v: u32, cell: u32, model: &Model, skin: &mut Skin) {
        let place = self.bound_at(v, model.surface.points[v as usize]);
        let from = self.region.cell_id[skin.cell[v as usize] as usize];
        let own = self.bound.own(v, from);
        let host = self.bound.leave(v).unwrap_or(from);
        self.fragments.release_point(host, v);
        let at = cell as usize;
        let there = (self.region.cell_id[at], self.region.cell_fragment[at] as usize);
        let anchor = self.fragments.anchor_in(there, place);
        self.fragments.bind(&anchor, v);
        self.bound.bind(v, own, anchor.cell, anchor.place);
        skin.cell[v as usize] = cell;
        self.edge_of[at] = self.edge_of[at].max(model.longest_edge(v));
    }
}
