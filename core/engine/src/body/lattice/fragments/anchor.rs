//! The cell and fragment in which a point is embedded.
//!
//! Where a cut passes close to a face of a cell it leaves a slice that contains the centre of no voxel. A point in the slice is embedded
//! in a neighbouring cell, in the fragment on its own side of the cut; in its own cell it would follow the other side.

use super::voxels::SIDE;
use super::{CellFragment, CutCell, Fragments};
use pliant_solver::Vec3;
use std::collections::BTreeSet;

/// Where a point is embedded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// A fragment of the containing cell, or of one close by.
    pub fragment: CellFragment,
    /// The rest position, m, or the point of the cell nearest to it.
    pub place: Vec3,
}

/// Largest distance of the voxel of another cell, in voxels.
const MAX_DISTANCE: f64 = 3.0;
/// Distance from the faces of another cell at which a point is placed, in edges of a cell.
const FACE_MARGIN: f64 = 1e-9;

impl Fragments {
    /// Where a rest position (m) in the cell `id` is embedded.
    pub fn anchor(&self, id: u64, place: Vec3) -> Anchor {
        let own = |fragment: usize| Anchor { fragment: CellFragment { cell: id, fragment }, place };
        let Some(cell) = self.cells.get(&id) else { return own(0) };
        let size = self.edge / SIDE as f64;
        let nearest = cell.voxels.nearest_visible(self.edge, place);
        let mut best = nearest.map(|nearest| (nearest.distance_squared, own(nearest.fragment)));
        // A voxel more than one voxel away may be visible only past the end of the cut.
        if let Some((_, anchor)) = best.filter(|(distance_squared, _)| *distance_squared <= size * size) {
            return anchor;
        }
        for id in self.cells_around(id, cell) {
            let Some(other) = self.cells.get(&id) else { continue };
            for (voxel, point) in other.voxels.reference_points() {
                let distance_squared = (point - place).norm_squared();
                if distance_squared >= best.map_or((MAX_DISTANCE * size).powi(2), |(least, _)| least)
                    || cell.voxels.separates(place, point)
                    || other.voxels.separates(place, point)
                {
                    continue;
                }
                let fragment = CellFragment { cell: id, fragment: other.voxels.fragment(voxel) };
                best = Some((distance_squared, self.anchor_in(fragment, place)));
            }
        }
        match best {
            Some((_, anchor)) => anchor,
            None if cell.fragments.is_empty() => self.nearest_anchor(place).unwrap_or_else(|| own(0)),
            None => own(cell.voxels.fragment_at(self.edge, place)),
        }
    }

    /// The fragment of the cut cell with the reference voxel nearest to a rest position (m): for a position in a cell that is in another body.
    fn nearest_anchor(&self, place: Vec3) -> Option<Anchor> {
        let points = |(id, cell): (&u64, &CutCell)| {
            let of_cell = cell.voxels.reference_points();
            let distance = of_cell.map(|(voxel, point)| (voxel, (point - place).norm_squared()));
            let (voxel, distance) = distance.min_by(|a, b| a.1.total_cmp(&b.1))?;
            Some((distance, CellFragment { cell: *id, fragment: cell.voxels.fragment(voxel) }))
        };
        let nearest = self.cells.iter().filter_map(points).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, fragment)| self.anchor_in(fragment, place))
    }

    /// Embeds a rest position (m) in a given fragment, at the point of its cell nearest to it.
    pub fn anchor_in(&self, fragment: CellFragment, place: Vec3) -> Anchor {
        let within = |i: usize, _: usize| {
            let (low, margin) = (self.cells[&fragment.cell].reference[i], FACE_MARGIN * self.edge);
            place[i].clamp(low + margin, low + self.edge - margin)
        };
        Anchor { fragment, place: Vec3::from_fn(within) }
    }

    /// Whether two fragments share nodes; `None` where their cells have no corner in common.
    pub fn are_connected(&self, a: CellFragment, b: CellFragment) -> Option<bool> {
        if a.cell == b.cell {
            return Some(a.fragment == b.fragment);
        }
        let [one, other] = [a, b].map(|f| self.cells.get(&f.cell).and_then(|cell| cell.fragments.get(f.fragment)));
        let (one, other) = (one?, other?);
        let common =
            one.nodes.iter().flat_map(|x| other.nodes.iter().filter(|y| y.node == x.node).map(move |y| x == y));
        common.reduce(|any, same| any || same)
    }

    /// Ids of the cells at most two faces away.
    fn cells_around(&self, id: u64, cell: &CutCell) -> BTreeSet<u64> {
        let mut around: BTreeSet<u64> = cell.neighbours.into_iter().collect();
        for first in cell.neighbours.iter().filter_map(|id| self.cells.get(id)) {
            around.extend(first.neighbours);
        }
        around.remove(&id);
        around
    }
}
