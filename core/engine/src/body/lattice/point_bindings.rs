//! In which cell each surface point is embedded, where that is not the one the grid names.
//!
//! A point lies in one cell, its containing cell. Beside a cut it may have to be embedded in another one, on its own side of the cut, at a
//! place of that cell.

use pliant_solver::Vec3;
use std::collections::HashMap;

/// Points that cuts have made, and points that are embedded in another cell than the one they lie in.
#[derive(Clone, Debug, Default)]
pub(super) struct PointBindings {
    /// Points that cuts have made, by containing cell.
    made: HashMap<u64, Vec<u32>>,
    /// Points embedded in a cell that does not contain them, by the cell in which they are embedded.
    moved_in: HashMap<u64, Vec<BoundPoint>>,
    /// The cell in which each of those points is embedded.
    cell_of: HashMap<u32, u64>,
    /// Rest positions at which points are embedded, m, where they differ from the model's or the model has none.
    places: HashMap<u32, Vec3>,
}

/// A surface point and the id of the cell that contains it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct BoundPoint {
    pub point: u32,
    pub containing: u64,
}

impl PointBindings {
    /// Adds a point that a cut has made in a cell, at a rest position (m).
    pub fn add(&mut self, point: u32, containing: u64, place: Vec3) {
        self.made.entry(containing).or_default().push(point);
        self.places.insert(point, place);
    }

    /// The bindings of the points that are `own`.
    pub fn of_part(&self, own: impl Fn(u32) -> bool) -> Self {
        let mut part = self.clone();
        part.made.values_mut().for_each(|points| points.retain(|point| own(*point)));
        part.moved_in.values_mut().for_each(|points| points.retain(|bound| own(bound.point)));
        part.cell_of.retain(|point, _| own(*point));
        part.places.retain(|point, _| own(*point));
        part
    }

    /// Points that lie in a cell or are embedded in it and that the grid does not list there.
    pub fn of_cell(&self, cell: u64) -> impl Iterator<Item = BoundPoint> + '_ {
        let made = self.made.get(&cell).into_iter().flatten();
        made.map(move |point| BoundPoint { point: *point, containing: cell })
            .chain(self.moved_in.get(&cell).into_iter().flatten().copied())
    }

    /// The cell that contains a point which is embedded in `cell`.
    pub fn containing(&self, point: u32, cell: u64) -> u64 {
        let others = self.cell_of.get(&point).and_then(|cell| self.moved_in.get(cell));
        others.into_iter().flatten().find(|other| other.point == point).map_or(cell, |other| other.containing)
    }

    /// Removes a point from the cell in which it is embedded, and returns this cell; `None` if that is its containing cell.
    pub fn remove(&mut self, point: u32) -> Option<u64> {
        let cell = self.cell_of.remove(&point)?;
        if let Some(points) = self.moved_in.get_mut(&cell) {
            points.retain(|other| other.point != point);
        }
        Some(cell)
    }

    /// Embeds a point in `cell` at a rest position (m).
    pub fn bind(&mut self, BoundPoint { point, containing }: BoundPoint, cell: u64, place: Vec3) {
        if cell != containing {
            self.moved_in.entry(cell).or_default().push(BoundPoint { point, containing });
            self.cell_of.insert(point, cell);
            self.places.insert(point, place);
        } else if self.made.get(&containing).is_some_and(|made| made.contains(&point)) {
            self.places.insert(point, place);
        } else {
            self.places.remove(&point);
        }
    }

    /// Rest position at which a point is embedded, m; `None` if it is the model's.
    pub fn place(&self, point: u32) -> Option<Vec3> {
        self.places.get(&point).copied()
    }
}
