//! Fragments of a part of a body that has become a body of its own.
//!
//! What is in other bodies counts as outside of this one: voxels there connect nothing, so no later cut or stitch sees them. Shares of cells, nodes and
//! their copies stay what they were, so the part has the masses and forces that it had.

use super::{CellFragment, Fragments};
use std::collections::HashSet;
use std::sync::Arc;

impl Fragments {
    /// The fragments of a part of the body: those that are `own`. `absent` are the cells without a cut that are in other bodies, besides those that
    /// already are.
    pub fn of_part(&self, own: impl Fn(CellFragment) -> bool, absent: impl Iterator<Item = u64>) -> Self {
        let mut part = self.clone();
        part.new_copies.clear();
        part.merged.clear();
        let mut cells: HashSet<u64> = self.absent.as_deref().cloned().unwrap_or_default();
        cells.extend(absent);
        part.absent = Some(Arc::new(cells));
        for (&id, cell) in &mut part.cells {
            let count = cell.fragments.len();
            let kept: Vec<bool> = (0..count).map(|fragment| own(CellFragment { cell: id, fragment })).collect();
            if kept.iter().all(|kept| *kept) {
                continue;
            }
            cell.voxels.keep(&kept);
            let mut kept = kept.iter();
            cell.fragments.retain(|_| kept.next().copied().unwrap_or(false));
        }
        part
    }

    /// Number that a fragment gets in the part of the fragments that are `own`.
    pub fn number_in_part(own: impl Fn(CellFragment) -> bool, CellFragment { cell, fragment }: CellFragment) -> usize {
        (0..fragment).filter(|fragment| own(CellFragment { cell, fragment: *fragment })).count()
    }

    /// Whether the body is a part of one that was split.
    pub fn is_part(&self) -> bool {
        self.absent.is_some()
    }

    /// Whether a cell without a cut is in another body.
    pub fn is_absent(&self, id: u64) -> bool {
        self.absent.as_ref().is_some_and(|absent| absent.contains(&id))
    }
}
