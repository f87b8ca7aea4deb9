//! A blade has passed: which cells are parted, and which part carries each point of the surface.

use super::fragments::Inner;
use super::mend::Hosts;
use super::{Lattice, LatticeError};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

impl Lattice {
    /// Takes in what a blade has swept, as triangles in the rest shape (m). `new` are the points of the surface the cut has
    /// made; `side` gives a rest place beside a point, on its own side of the cut, `neighbours` the points it shares a triangle
    /// with; `inner` knows where the body is. The cells
    /// change with the next [`Lattice::follow`]. Gives the ids of those whose parts or points are others now.
    ///
    /// # Errors
    /// What the grid says.
    pub fn cut(
        &mut self,
        swept: &[[Vec3; 3]],
        new: impl Iterator<Item = u32>,
        side: impl Fn(u32) -> Vec3,
        neighbours: impl Fn(u32) -> Vec<u32>,
        inner: &impl Inner,
    ) -> Result<Vec<u64>, LatticeError> {
        let level = self.settings.level;
        let mut changed = self.fragments.cut(&self.grid, level, swept, inner)?;
        for point in new {
            let place = side(point);
            let id = self.cut_cell_of(place)?;
            self.bound.make(point, id, place);
            changed.push(id);
        }
        changed.sort_unstable();
        changed.dedup();
        let mut points: Vec<(u32, u64)> = Vec::new();
        for &id in &changed {
            let facts = self.grid.cell(level, id)?;
            let own = &self.grid.points(level)?[facts.point_begin..facts.point_end];
            points.extend(own.iter().map(|point| (*point, id)));
            points.extend(self.bound.of(id));
            self.fragments.release(id);
        }
        points.sort_unstable();
        points.dedup();
        let (mut hosts, mut owns) = (Hosts::new(), BTreeMap::new());
        for (point, own) in points {
            if let Some(host) = self.bound.leave(point) {
                self.fragments.release_point(host, point);
            }
            let anchor = self.fragments.anchor(own, side(point));
            self.fragments.bind(&anchor, point);
            self.bound.bind(point, own, anchor.cell, anchor.place);
            hosts.insert(point, (anchor.cell, anchor.fragment));
            owns.insert(point, own);
        }
        self.mend(hosts, &owns, side, neighbours);
        self.stale = true;
        Ok(changed)
    }

    /// Ids of the cells a blade has come near, rising.
    pub fn cut_cells(&self) -> impl Iterator<Item = u64> + '_ {
        self.fragments.ids()
    }

    /// Whether a cell is one of them.
    pub fn is_cut(&self, id: u64) -> bool {
        self.fragments.has(id)
    }

    /// The cell of a rest place, and the part of it the place is on; `None` beside all occupied cells.
    ///
    /// # Errors
    /// What the grid says.
    pub fn part_at(&self, place: Vec3) -> Result<Option<(u64, u8)>, LatticeError> {
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
        Ok((id[0] != abi::NO_CELL).then(|| (id[0], self.fragments.fragment_at(id[0], place) as u8)))
    }

    /// The same, and a place of that cell to carry it by: in a slice of a cell too thin to be a part, it is the next cell's.
    ///
    /// # Errors
    /// What the grid says.
    pub fn anchor_at(&self, place: Vec3) -> Result<Option<(u64, u8, Vec3)>, LatticeError> {
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
        let anchor = |id: u64| {
            let anchor = self.fragments.anchor(id, place);
            (anchor.cell, anchor.fragment as u8, anchor.place)
        };
        Ok((id[0] != abi::NO_CELL).then(|| anchor(id[0])))
    }

    /// The cut cell a place belongs to; the nearest where it lies beside all of them.
    fn cut_cell_of(&self, place: Vec3) -> Result<u64, LatticeError> {
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
        if self.fragments.has(id[0]) {
            return Ok(id[0]);
        }
        let away = |middle: Vec3| (middle - place).norm_squared();
        let cells = self.fragments.middles();
        Ok(cells.min_by(|a, b| away(a.1).total_cmp(&away(b.1))).map_or(id[0], |(id, _)| id))
    }

    /// Rest place by which a surface point is bound: its own, or for one that a cut has made or moved a place beside it.
    pub(super) fn bound_at(&self, point: u32, own: Vec3) -> Vec3 {
        self.bound.place(point).unwrap_or(own)
    }

    /// Parts of active cells that hang together: for each active node, the number of its part.
    pub fn parts(&self) -> Vec<u32> {
        let mut root: Vec<u32> = (0..self.region.node_id.len() as u32).collect();
        fn find(root: &mut [u32], mut at: u32) -> u32 {
            while root[at as usize] != at {
                root[at as usize] = root[root[at as usize] as usize];
                at = root[at as usize];
            }
            at
        }
        for corners in &self.region.cell_corners {
            for &n in &corners[1..] {
                let (a, b) = (find(&mut root, corners[0]), find(&mut root, n));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        let tops: Vec<u32> = (0..root.len() as u32).map(|n| find(&mut root, n)).collect();
        let mut number = vec![u32::MAX; root.len()];
        let mut count = 0;
        for &top in &tops {
            if number[top as usize] == u32::MAX {
                number[top as usize] = count;
                count += 1;
            }
        }
        tops.iter().map(|top| number[*top as usize]).collect()
    }
}
