//! The surface of a body as a ball feels it: points with an area and a normal, as fine as the grid can follow and no finer.
//!
//! Made once from the model as it was handed in. Triangles are cut into parts of a third of a cell; parts that fall into one
//! box of that size and look the same way become one sample. So a contact costs the same on a model of a thousand triangles
//! and on one of a million.

use bytemuck::cast_slice;

use super::{Lattice, LatticeError, Model, Skin};
use pliant_mesh::Surface;
use pliant_solver::Vec3;
use std::collections::BTreeMap;
use std::ops::Range;

/// Samples, sorted by the cell of the working level that carries them.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// m, rest places (s x 3)
    pub place: Vec<Vec3>,
    /// Area, m^2 (s).
    pub area: Vec<f64>,
    /// Unit, in the rest shape (s x 3)
    pub normal: Vec<Vec3>,
    /// Ids of the cells that have samples, rising, and where theirs begin (c + 1).
    cells: Vec<u64>,
    starts: Vec<u32>,
    /// Those of the parts of cut cells, made anew after each cut and put behind the others.
    recut: BTreeMap<(u64, u8), Range<usize>>,
    /// Before any cut.
    uncut: usize,
}

/// Samples along the edge of a cell.
const PER_EDGE: f64 = 3.0;
/// Parts along an edge of a triangle, at most.
const MOST_PARTS: usize = 64;

/// How far inside of the surface the place of a sample in a cut cell is, in edges of a cell: enough to tell on which side
/// of the cut it is.
const INSIDE: f64 = 1e-6;

/// What falls into one box and looks one way.
#[derive(Clone, Copy)]
struct Part {
    /// Box, then which axis the normal is closest to, and its sign.
    key: (i32, i32, i32, u8),
    /// Keeps the order of sums.
    number: u32,
    middle: Vec3,
    /// Area along the normal, m^2.
    area: Vec3,
}

impl Samples {
    /// Samples the surface a lattice carries.
    ///
    /// # Errors
    /// A grid that fails.
    pub fn new(surface: &Surface, lattice: &Lattice) -> Result<Self, LatticeError> {
        let size = lattice.edge() / PER_EDGE;
        let mut parts: Vec<Part> = Vec::with_capacity(surface.triangles.len());
        for triangle in &surface.triangles {
            cut(triangle.map(|v| surface.points[v as usize]), size, &mut parts);
        }
        parts.sort_unstable_by_key(|p| (p.key, p.number));
        let merged: Vec<(Vec3, Vec3)> = parts.chunk_by(|a, b| a.key == b.key).map(merge).collect();
        let places: Vec<Vec3> = merged.iter().map(|m| m.0).collect();
        let (mut cells, mut weights) = (vec![0; places.len()], vec![[0.0; 8]; places.len()]);
        lattice.grid.weights(lattice.settings.level, cast_slice(&places), &mut cells, &mut weights)?;
        let mut order: Vec<u32> = (0..places.len() as u32).collect();
        order.sort_by_key(|&i| cells[i as usize]);
        let mut samples = Self::default();
        for &i in &order {
            let (id, area) = (cells[i as usize], merged[i as usize].1);
            if id == pliant_plugin_api::abi::NO_CELL {
                continue; // the middle of a bent part may lie beside the body; its neighbours stand for it
            }
            if samples.cells.last() != Some(&id) {
                samples.cells.push(id);
                samples.starts.push(samples.place.len() as u32);
            }
            samples.push(places[i as usize], area);
        }
        samples.starts.push(samples.place.len() as u32);
        samples.uncut = samples.place.len();
        Ok(samples)
    }

    fn push(&mut self, place: Vec3, area: Vec3) {
        let size = area.norm();
        self.place.push(place);
        self.area.push(size);
        self.normal.push(area / size);
    }

    /// Forgets all cuts.
    pub fn mend(&mut self) {
        self.recut.clear();
        self.place.truncate(self.uncut);
        self.area.truncate(self.uncut);
        self.normal.truncate(self.uncut);
    }

    /// Samples `cells` (ids, rising) that a blade has parted, each part by itself.
    ///
    /// # Errors
    /// A grid that fails.
    pub fn take_cut(
        &mut self,
        cells: &[u64],
        model: &Model,
        skin: &Skin,
        lattice: &Lattice,
    ) -> Result<(), LatticeError> {
        let (edge, size) = (lattice.edge(), lattice.edge() / PER_EDGE);
        let mut triangles = Vec::new();
        for &id in cells {
            let centre = Vec3::from(lattice.grid.cell(lattice.settings.level, id)?.centre);
            let kept = lattice.kept_at(centre)?;
            skin.tree.near(centre + kept, 0.5 * edge + kept.norm(), |t| triangles.push(t));
        }
        triangles.sort_unstable();
        triangles.dedup();
        let mut parts = Vec::new();
        for &t in &triangles {
            cut(model.surface.triangles[t as usize].map(|v| model.surface.points[v as usize]), size, &mut parts);
        }
        let mut of_cells: Vec<((u64, u8), Part)> = Vec::new();
        for part in parts {
            let inward = INSIDE * edge / part.area.norm();
            let place = part.middle - inward * part.area;
            if let Some((id, part_of, place)) =
                lattice.anchor_at(place)?.filter(|(id, ..)| cells.binary_search(id).is_ok())
            {
                of_cells.push(((id, part_of), Part { middle: place, ..part }));
            }
        }
        of_cells.sort_unstable_by_key(|(key, p)| (*key, p.key, p.number));
        for id in cells {
            let known: Vec<(u64, u8)> = self.recut.range((*id, 0)..=(*id, u8::MAX)).map(|(key, _)| *key).collect();
            known.iter().for_each(|key| _ = self.recut.remove(key));
        }
        for of_cell in of_cells.chunk_by(|a, b| a.0 == b.0) {
            let first = self.place.len();
            for group in of_cell.chunk_by(|a, b| a.1.key == b.1.key) {
                let group: Vec<Part> = group.iter().map(|(_, part)| *part).collect();
                let (place, area) = merge(&group);
                self.push(place, area);
            }
            self.recut.insert(of_cell[0].0, first..self.place.len());
        }
        Ok(())
    }

    /// Those carried by a part of a cell; `cut` says whether a blade has come near it.
    pub fn of_cell(&self, id: u64, part: u8, cut: bool) -> Range<usize> {
        if cut {
            return self.recut.get(&(id, part)).cloned().unwrap_or(0..0);
        }
        match self.cells.binary_search(&id) {
            Ok(at) => self.starts[at] as usize..self.starts[at + 1] as usize,
            Err(_) => 0..0,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.place.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.place.is_empty()
    }
}

/// One sample of all parts of a box that look one way: its place, and its area along the normal.
fn merge(group: &[Part]) -> (Vec3, Vec3) {
    let weight = |p: &Part| p.area.norm();
    let total: f64 = group.iter().map(weight).sum();
    let middle: Vec3 = group.iter().map(|p| weight(p) / total * p.middle).sum();
    (middle, group.iter().map(|p| p.area).sum::<Vec3>())
}

/// Cuts a triangle into equal parts no longer than one and a half boxes of `size`.
fn cut(corners: [Vec3; 3], size: f64, out: &mut Vec<Part>) {
    let [a, b, c] = corners;
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let parts = ((longest / (1.5 * size)).ceil() as usize).clamp(1, MOST_PARTS);
    let whole = 0.5 * (b - a).cross(&(c - a));
    if whole.norm() == 0.0 {
        return;
    }
    let area = whole / (parts * parts) as f64;
    let axis = whole.iamax();
    let side = 2 * axis as u8 + u8::from(whole[axis] < 0.0);
    for bary in middles(parts) {
        let middle = super::interpolate(corners, bary);
        let [x, y, z] = middle.map(|m| (m / size).floor() as i32).into();
        let number = out.len() as u32;
        out.push(Part { key: (x, y, z, side), number, middle, area });
    }
}

/// Weights of the middles of the `parts * parts` equal triangles a triangle can be cut into.
fn middles(parts: usize) -> impl Iterator<Item = Vec3> {
    let n = parts as f64;
    (0..parts).flat_map(move |i| {
        (0..parts - i).flat_map(move |j| {
            let point = move |shift: f64| {
                let (u, v) = ((i as f64 + shift) / n, (j as f64 + shift) / n);
                Vec3::new(1.0 - u - v, u, v)
            };
            let inverted = (i + j + 1 < parts).then(|| point(2.0 / 3.0));
            std::iter::once(point(1.0 / 3.0)).chain(inverted)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_triangle_are_all_there_and_their_middles_average_to_its_own() {
        for parts in 1..6 {
            let list: Vec<Vec3> = middles(parts).collect();
            assert_eq!(list.len(), parts * parts);
            for c in 0..3 {
                let mean = list.iter().map(|b| b[c]).sum::<f64>() / list.len() as f64;
                assert!((mean - 1.0 / 3.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn cutting_keeps_the_area_and_its_direction() {
        let mut parts = Vec::new();
        cut([Vec3::zeros(), Vec3::x(), Vec3::new(0.0, 2.0, 0.0)], 0.1, &mut parts);
        let total: Vec3 = parts.iter().map(|p| p.area).sum();
        assert!((total[2] - 1.0).abs() < 1e-12 && total[0] == 0.0 && parts.iter().all(|p| p.key.3 == 4));
    }
}
