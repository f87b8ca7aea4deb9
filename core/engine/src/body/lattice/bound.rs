//! Which cell carries a point of the surface, where that is not simply the one it lies in.

use pliant_solver::Vec3;
use std::collections::HashMap;

/// Points that a cut has made, and points that another cell than their own carries.
#[derive(Clone, Debug, Default)]
pub(super) struct Bound {
    /// Points that cuts have made, by the cell they lie in.
    made: HashMap<u64, Vec<u32>>,
    /// Points that a cell carries for another: the point and the cell it lies in.
    guests: HashMap<u64, Vec<(u32, u64)>>,
    /// The cell that carries a guest.
    host: HashMap<u32, u64>,
    /// m, where points are bound that have no place of their own in the grid.
    places: HashMap<u32, Vec3>,
}

impl Bound {
    /// Takes in a point that a cut has made in a cell.
    pub fn make(&mut self, point: u32, cell: u64, place: Vec3) {
        self.made.entry(cell).or_default().push(point);
        self.places.insert(point, place);
    }

    /// Points besides the grid's own that lie in a cell or are carried by it, each with the cell it lies in.
    pub fn of(&self, cell: u64) -> impl Iterator<Item = (u32, u64)> + '_ {
        let made = self.made.get(&cell).into_iter().flatten().map(move |point| (*point, cell));
        made.chain(self.guests.get(&cell).into_iter().flatten().copied())
    }

    /// The cell a point lies in that `discretization` carries.
    pub fn own(&self, point: u32, discretization: u64) -> u64 {
        let guests = self.host.get(&point).and_then(|host| self.guests.get(host));
        guests.into_iter().flatten().find(|(other, _)| *other == point).map_or(discretization, |(_, own)| *own)
    }

    /// Takes a guest from its host, which it gives.
    pub fn leave(&mut self, point: u32) -> Option<u64> {
        let host = self.host.remove(&point)?;
        if let Some(guests) = self.guests.get_mut(&host) {
            guests.retain(|(other, _)| *other != point);
        }
        Some(host)
    }

    /// Binds a point of the cell `own` at a place of `cell`.
    pub fn bind(&mut self, point: u32, own: u64, cell: u64, place: Vec3) {
        if cell != own {
            self.guests.entry(cell).or_default().push((point, own));
            self.host.insert(point, cell);
            self.places.insert(point, place);
        } else if self.made.get(&own).is_some_and(|made| made.contains(&point)) {
            self.places.insert(point, place);
        } else {
            self.places.remove(&point);
        }
    }

    /// m, where a point is bound, if not in its own place.
    pub fn place(&self, point: u32) -> Option<Vec3> {
        self.places.get(&point).copied()
    }
}
