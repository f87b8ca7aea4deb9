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
/// Equal parts of a triangle, over those that its area and length ask for, from which on it is cut as a sliver. A triangle as high as a quarter
/// of its longest edge has as many.
const SLIVER_FACTOR: f64 = 4.0;
/// Parts that are collected before those that belong together are merged: 300 MB.
const MOST_COLLECTED: usize = 1 << 22;

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
        let mut most = MOST_COLLECTED;
        for triangle in &surface.triangles {
            cut(triangle.map(|v| surface.points[v as usize]), size, &mut parts);
            if parts.len() > most {
                // Many triangles lie in the same boxes, as in a model that covers itself.
                parts =
                    merge_all(parts).map(|(key, number, (middle, area))| Part { key, number, middle, area }).collect();
                most = most.max(2 * parts.len());
            }
        }
        let merged: Vec<(Vec3, Vec3)> = merge_all(parts).map(|(_, _, sample)| sample).collect();
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

/// The samples of all parts, by their keys, with the number of the first part of each.
fn merge_all(mut parts: Vec<Part>) -> impl Iterator<Item = ((i32, i32, i32, u8), u32, (Vec3, Vec3))> {
    parts.sort_unstable_by_key(|p| (p.key, p.number));
    let groups: Vec<_> =
        parts.chunk_by(|a, b| a.key == b.key).map(|group| (group[0].key, group[0].number, merge(group))).collect();
    groups.into_iter()
}

/// One sample of all parts of a box that look one way: its place, and its area along the normal.
fn merge(group: &[Part]) -> (Vec3, Vec3) {
    let weight = |p: &Part| p.area.norm();
    let total: f64 = group.iter().map(weight).sum();
    let middle: Vec3 = group.iter().map(|p| weight(p) / total * p.middle).sum();
    (middle, group.iter().map(|p| p.area).sum::<Vec3>())
}

/// Cuts a triangle into parts no longer than one and a half boxes of `size`, or than its longest edge by [`MOST_PARTS`]: equal ones, or, where they
/// would be much thinner than a box, strips and rows ([`cut_sliver`]). So the number of parts follows area and length.
fn cut(corners: [Vec3; 3], size: f64, out: &mut Vec<Part>) {
    let [a, b, c] = corners;
    let longest = longest_edge(&corners);
    let parts = ((longest / (1.5 * size)).ceil() as usize).clamp(1, MOST_PARTS);
    let whole = 0.5 * (b - a).cross(&(c - a));
    if whole.norm() == 0.0 {
        return;
    }
    let axis = whole.iamax();
    let side = 2 * axis as u8 + u8::from(whole[axis] < 0.0);
    let mut push = |middle: Vec3, area: Vec3| {
        let [x, y, z] = middle.map(|m| (m / size).floor() as i32).into();
        let number = out.len() as u32;
        out.push(Part { key: (x, y, z, side), number, middle, area });
    };
    let part_length = longest / parts as f64;
    let needed = 2.0 * whole.norm() / (part_length * part_length) + parts as f64;
    if (parts * parts) as f64 <= SLIVER_FACTOR * needed {
        let area = whole / (parts * parts) as f64;
        middles(parts).for_each(|bary| push(super::interpolate(corners, bary), area));
        return;
    }
    cut_sliver(corners, whole, parts, &mut push);
}

/// Length of the longest edge of a triangle, m.
fn longest_edge([a, b, c]: &[Vec3; 3]) -> f64 {
    (b - a).norm().max((c - b).norm()).max((a - c).norm())
}

/// Cuts a triangle of a vector area (m^2) across its longest edge into so many strips of equal width and those into rows as high as they are wide,
/// and hands over centroid and area of each part.
fn cut_sliver([a, b, c]: [Vec3; 3], area: Vec3, strips: usize, push: &mut impl FnMut(Vec3, Vec3)) {
    let edges = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
    // With the longest edge from a to b.
    let [a, b, c] = match (edges[0] >= edges[1], edges[0] >= edges[2], edges[1] >= edges[2]) {
        (true, true, _) => [a, b, c],
        (_, _, true) => [b, c, a],
        _ => [c, a, b],
    };
    let along = b - a;
    // Where the foot of the height is, from 0 at a to 1 at b.
    let foot = ((c - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    let height = c - a - foot * along;
    let rows = (height.norm() * strips as f64 / along.norm()).ceil().max(1.0);
    let at = |s: f64| if s < foot { s / foot } else { ((1.0 - s) / (1.0 - foot)).min(1.0) };
    let mut cuts: Vec<f64> = (0..=strips).map(|i| i as f64 / strips as f64).chain([foot]).collect();
    cuts.sort_unstable_by(f64::total_cmp);
    for pair in cuts.windows(2) {
        let ([from, to], width) = ([pair[0], pair[1]], pair[1] - pair[0]);
        // Heights of the triangle at both sides of the strip, over its height; from the inner side at the foot.
        let [h0, h1] = if to <= foot { [from / foot, to / foot] } else { [at(from), at(to)] };
        let sum = h0 + h1;
        let share = width * sum;
        if share.is_nan() || share <= 0.0 {
            continue;
        }
        let s = from + width * (h0 + 2.0 * h1) / (3.0 * sum);
        // Twice the height of the centroid of the strip.
        let h = 2.0 / 3.0 * (h0 * h0 + h0 * h1 + h1 * h1) / sum;
        for row in 0..rows as usize {
            let up = (row as f64 + 0.5) / rows * h;
            push(a + s * along + up * height, share / rows * area);
        }
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

    #[test]
    fn slivers_have_as_many_parts_as_their_length_asks_for() {
        let mut random = pliant_mesh::testing::Random(12);
        for _ in 0..300 {
            let (size, length) = (0.01, 0.05 + random.unit());
            let height = length * 10.0_f64.powf(-6.0 * random.unit());
            let along = (0.5 + random.unit()) * length;
            let (u, v) = (random.direction(), random.direction());
            let v = (v - v.dot(&u) * u).normalize();
            let corners = [Vec3::zeros(), length * u, along * u + height * v];
            let whole = 0.5 * (corners[1]).cross(&corners[2]);
            let mut parts = Vec::new();
            cut(corners, size, &mut parts);
            let longest = longest_edge(&corners);
            let (part, area) = (longest / (longest / (1.5 * size)).ceil().min(64.0), whole.norm());
            // Those of equal parts, up to the factor from which on they are strips.
            let most = SLIVER_FACTOR * (2.0 * area / (part * part) + longest / part) + 1.0;
            assert!((parts.len() as f64) <= most, "{} parts of {length} x {height}", parts.len());
            let total: Vec3 = parts.iter().map(|p| p.area).sum();
            let middle: Vec3 = parts.iter().map(|p| p.area.norm() / area * p.middle).sum();
            let centroid = corners.iter().sum::<Vec3>() / 3.0;
            assert!((total - whole).norm() < 1e-12 * area && (middle - centroid).norm() < 1e-12 * length);
        }
    }

    #[test]
    fn merging_on_the_way_changes_rounding_alone() {
        let mut random = pliant_mesh::testing::Random(5);
        let mut parts = Vec::new();
        for _ in 0..50 {
            let corners = [(); 3].map(|()| random.vector());
            cut(corners, 0.2, &mut parts);
        }
        let whole: Vec<_> = merge_all(parts.clone()).collect();
        let half = parts.len() / 2;
        let mut on_the_way: Vec<Part> = merge_all(parts[..half].to_vec())
            .map(|(key, number, (middle, area))| Part { key, number, middle, area })
            .collect();
        on_the_way.extend_from_slice(&parts[half..]);
        let again: Vec<_> = merge_all(on_the_way).collect();
        assert_eq!(whole.len(), again.len());
        for (a, b) in whole.iter().zip(&again) {
            // Normals of a box that differ make the weights of the halves differ a little; area is kept.
            assert!(a.0 == b.0 && (a.2.1 - b.2.1).norm() < 1e-12 && (a.2.0 - b.2.0).norm() < 0.1, "{a:?} {b:?}");
        }
    }
}
