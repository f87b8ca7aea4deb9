//! Samples of the surface of a solid for contact: points with an area and a normal, about three along the edge of a cell.
//!
//! They are made once from the surface of the file. Triangles are divided into pieces of a third of a cell; pieces whose centroids lie in
//! one box of that size, with normals nearest to the same axis direction, are merged into one sample. So the cost of a contact depends on
//! the grid and not on the number of triangles.

use bytemuck::cast_slice;

use super::{CellFragment, Lattice, LatticeError, Model, Skin};
use crate::contact::{SKIN_DEPTH, depth_on_side, inward};
use pliant_mesh::Surface;
use pliant_solver::Vec3;
use std::collections::BTreeMap;
use std::ops::Range;

/// Samples of a surface, sorted by the cell of the working level in which they are embedded.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// Rest positions, m (s x 3).
    pub place: Vec<Vec3>,
    /// Area of the surface that each sample stands for, m^2 (s).
    pub area: Vec<f64>,
    /// Unit normals in the rest shape, outward (s x 3).
    pub normal: Vec<Vec3>,
    /// Ids of the cells that have samples, ascending (c).
    cells: Vec<u64>,
    /// First sample of each of these cells, and the number of samples before any cut (c + 1).
    starts: Vec<u32>,
    /// Samples of the fragments of cut cells. They are made again after each cut and appended.
    recut: BTreeMap<CellFragment, Range<usize>>,
    /// Number of samples before any cut.
    uncut: usize,
}

/// Samples along the edge of a cell.
const PER_EDGE: f64 = 3.0;
/// Largest number of pieces along the edge of a triangle.
const MAX_PIECES: usize = 64;
/// Ratio of the number of equal pieces to the number that area and length need from which on a triangle is divided as a sliver. A triangle
/// whose height is a quarter of its longest edge reaches it.
const SLIVER_FACTOR: f64 = 4.0;
/// Number of pieces at which those collected so far are merged: about 300 MB.
pub(crate) const MAX_COLLECTED: usize = 1 << 22;

/// A piece of a triangle.
#[derive(Clone, Copy)]
struct Piece {
    key: PieceKey,
    /// Ascending in the order of the triangles; it fixes the order of sums.
    number: u32,
    /// Centroid of the piece at rest, m.
    centroid: Vec3,
    /// Area vector, m^2.
    area: Vec3,
}

/// Pieces with equal keys are merged.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct PieceKey {
    /// Index of the box that contains the centroid.
    box_index: [i32; 3],
    /// Axis direction nearest to the normal: twice the axis, plus 1 for the negative direction.
    side: u8,
}

/// A sample before it is stored.
#[derive(Clone, Copy)]
struct Sample {
    /// Rest position of the sample, m.
    place: Vec3,
    /// Area vector, m^2.
    area: Vec3,
}

impl Samples {
    /// Samples the surface of a body that is embedded in a lattice.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn new(surface: &Surface, lattice: &Lattice) -> Result<Self, LatticeError> {
        let corners = surface.triangles.iter().map(|triangle| triangle.map(|v| surface.points[v as usize]));
        let merged = collect(corners, lattice);
        let places: Vec<Vec3> = merged.iter().map(|m| m.centroid).collect();
        Self::in_cells(&merged, &places, lattice)
    }

    /// Samples triangles (corners, m) of a body whose elements have failed in part, each in the cell under it.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn of_broken(
        triangles: impl Iterator<Item = [Vec3; 3]>,
        lattice: &Lattice,
    ) -> Result<Self, LatticeError> {
        let merged = collect(triangles, lattice);
        let under = |m: &Piece| inward(m.centroid, m.area, SKIN_DEPTH * lattice.edge());
        let places: Vec<Vec3> = merged.iter().map(under).collect();
        Self::in_cells(&merged, &places, lattice)
    }

    /// Sorts samples by the cells in which they are, looked up at `places` (m).
    fn in_cells(merged: &[Piece], places: &[Vec3], lattice: &Lattice) -> Result<Self, LatticeError> {
        let (mut cells, mut weights) = (vec![0; places.len()], vec![[0.0; 8]; places.len()]);
        lattice.source.weights(lattice.settings.level, cast_slice(places), &mut cells, &mut weights)?;
        let mut order: Vec<u32> = (0..places.len() as u32).collect();
        order.sort_by_key(|&i| cells[i as usize]);
        let mut samples = Self::default();
        for &i in &order {
            let id = cells[i as usize];
            if id == pliant_plugin_api::abi::NO_CELL {
                continue; // the centroid of pieces of a bent surface may lie outside of all cells; samples beside it stand in for it
            }
            if samples.cells.last() != Some(&id) {
                samples.cells.push(id);
                samples.starts.push(samples.place.len() as u32);
            }
            samples.push(Sample { place: merged[i as usize].centroid, area: merged[i as usize].area });
        }
        samples.starts.push(samples.place.len() as u32);
        samples.uncut = samples.place.len();
        Ok(samples)
    }

    fn push(&mut self, sample: Sample) {
        let size = sample.area.norm();
        self.place.push(sample.place);
        self.area.push(size);
        self.normal.push(sample.area / size);
    }

    /// Removes the samples that cuts have added.
    pub fn forget_cuts(&mut self) {
        self.recut.clear();
        self.place.truncate(self.uncut);
        self.area.truncate(self.uncut);
        self.normal.truncate(self.uncut);
    }

    /// Samples the surface in `cells` (ids, ascending) that a blade has cut again, fragment by fragment.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
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
            // Tetrahedra are not cut.
            let Some(grid) = lattice.source.plugin() else { continue };
            let centre = Vec3::from(grid.cell(lattice.settings.level, id)?.centre);
            let offset = lattice.rest_offset_at(centre)?;
            skin.tree.near(centre + offset, 0.5 * edge + offset.norm(), |t| triangles.push(t));
        }
        triangles.sort_unstable();
        triangles.dedup();
        let (mut pieces, mut depths) = (Vec::new(), Vec::new());
        for &t in &triangles {
            divide(model.surface.triangles[t as usize].map(|v| model.surface.points[v as usize]), size, &mut pieces);
            depths.resize(pieces.len(), depth_on_side(model, t) * edge);
        }
        let mut anchored: Vec<(CellFragment, Piece)> = Vec::new();
        for (piece, depth) in pieces.into_iter().zip(depths) {
            let inside = inward(piece.centroid, piece.area, depth);
            if let Some(anchor) = lattice.anchor_at(inside)?.filter(|a| cells.binary_search(&a.fragment.cell).is_ok()) {
                anchored.push((anchor.fragment, Piece { centroid: anchor.place, ..piece }));
            }
        }
        anchored.sort_unstable_by_key(|(fragment, piece)| (*fragment, piece.key, piece.number));
        self.recut.retain(|fragment, _| cells.binary_search(&fragment.cell).is_err());
        for fragment in anchored.chunk_by(|a, b| a.0 == b.0) {
            let first = self.place.len();
            for group in fragment.chunk_by(|a, b| a.1.key == b.1.key) {
                let group: Vec<Piece> = group.iter().map(|(_, piece)| *piece).collect();
                self.push(merge(&group));
            }
            self.recut.insert(fragment[0].0, first..self.place.len());
        }
        Ok(())
    }

    /// Samples embedded in a fragment of a cell, as a range of the lists. `is_cut` tells whether a blade has come near the cell; an uncut
    /// cell is one fragment.
    pub fn of_fragment(&self, fragment: CellFragment, is_cut: bool) -> Range<usize> {
        if is_cut {
            return self.recut.get(&fragment).cloned().unwrap_or(0..0);
        }
        match self.cells.binary_search(&fragment.cell) {
            Ok(at) => self.starts[at] as usize..self.starts[at + 1] as usize,
            Err(_) => 0..0,
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.place.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.place.is_empty()
    }
}

/// Divides triangles (corners, m) into pieces and merges them.
fn collect(triangles: impl Iterator<Item = [Vec3; 3]>, lattice: &Lattice) -> Vec<Piece> {
    let size = lattice.edge() / PER_EDGE;
    let mut pieces: Vec<Piece> = Vec::with_capacity(triangles.size_hint().0);
    let mut limit = MAX_COLLECTED;
    for corners in triangles {
        divide(corners, size, &mut pieces);
        if pieces.len() > limit {
            pieces = merge_all(pieces);
            limit = limit.max(2 * pieces.len());
        }
    }
    merge_all(pieces)
}

/// Merges pieces with equal keys; a merged piece has the number of its first.
fn merge_all(mut pieces: Vec<Piece>) -> Vec<Piece> {
    pieces.sort_unstable_by_key(|p| (p.key, p.number));
    let groups = pieces.chunk_by(|a, b| a.key == b.key).map(|group| {
        let Sample { place: centroid, area } = merge(group);
        Piece { key: group[0].key, number: group[0].number, centroid, area }
    });
    groups.collect()
}

/// The sample that stands for pieces: their centroid and the sum of their area vectors.
fn merge(group: &[Piece]) -> Sample {
    let weight = |p: &Piece| p.area.norm();
    let total: f64 = group.iter().map(weight).sum();
    let place: Vec3 = group.iter().map(|p| weight(p) / total * p.centroid).sum();
    Sample { place, area: group.iter().map(|p| p.area).sum::<Vec3>() }
}

/// Divides a triangle (m) into pieces no longer than 1.5 boxes of `size` (m), with at most [`MAX_PIECES`] along its longest edge: congruent
/// ones, or, where these would be much thinner than a box, strips and rows ([`divide_sliver`]). So the number of pieces grows with area and
/// length alone.
fn divide(corners: [Vec3; 3], size: f64, out: &mut Vec<Piece>) {
    let [a, b, c] = corners;
    let longest = longest_edge(&corners);
    let pieces = ((longest / (1.5 * size)).ceil() as usize).clamp(1, MAX_PIECES);
    let whole = 0.5 * (b - a).cross(&(c - a));
    if whole.norm() == 0.0 {
        return;
    }
    let axis = whole.iamax();
    let side = 2 * axis as u8 + u8::from(whole[axis] < 0.0);
    let mut push = |centroid: Vec3, area: Vec3| {
        let box_index = centroid.map(|m| (m / size).floor() as i32).into();
        let number = out.len() as u32;
        out.push(Piece { key: PieceKey { box_index, side }, number, centroid, area });
    };
    let piece_length = longest / pieces as f64;
    let needed = 2.0 * whole.norm() / (piece_length * piece_length) + pieces as f64;
    if (pieces * pieces) as f64 <= SLIVER_FACTOR * needed {
        let area = whole / (pieces * pieces) as f64;
        centroids(pieces).for_each(|bary| push(super::interpolate(corners, bary), area));
        return;
    }
    divide_sliver(corners, whole, pieces, &mut push);
}

/// Length of the longest edge of a triangle, m.
fn longest_edge([a, b, c]: &[Vec3; 3]) -> f64 {
    (b - a).norm().max((c - b).norm()).max((a - c).norm())
}

/// Divides a triangle with area vector `area` (m^2) into `strips` of equal width across its longest edge, and each strip into rows about as
/// high as it is wide. Calls `push` with centroid (m) and area vector (m^2) of each piece.
fn divide_sliver([a, b, c]: [Vec3; 3], area: Vec3, strips: usize, push: &mut impl FnMut(Vec3, Vec3)) {
    let edges = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
    // Renamed so that the longest edge goes from a to b.
    let [a, b, c] = match (edges[0] >= edges[1], edges[0] >= edges[2], edges[1] >= edges[2]) {
        (true, true, _) => [a, b, c],
        (_, _, true) => [b, c, a],
        _ => [c, a, b],
    };
    let along = b - a;
    // Foot of the height from c, 0 at a and 1 at b.
    let foot = ((c - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    let height = c - a - foot * along;
    let rows = (height.norm() * strips as f64 / along.norm()).ceil().max(1.0);
    let at = |s: f64| if s < foot { s / foot } else { ((1.0 - s) / (1.0 - foot)).min(1.0) };
    let mut cuts: Vec<f64> = (0..=strips).map(|i| i as f64 / strips as f64).chain([foot]).collect();
    cuts.sort_unstable_by(f64::total_cmp);
    for pair in cuts.windows(2) {
        let ([from, to], width) = ([pair[0], pair[1]], pair[1] - pair[0]);
        // Heights of the triangle at both sides of the strip, relative to the height over the foot.
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

/// Barycentric coordinates of the centroids of the `n * n` congruent triangles into which a triangle is divided, `n` along an edge.
fn centroids(divisions: usize) -> impl Iterator<Item = Vec3> {
    let n = divisions as f64;
    (0..divisions).flat_map(move |i| {
        (0..divisions - i).flat_map(move |j| {
            let point = move |shift: f64| {
                let (u, v) = ((i as f64 + shift) / n, (j as f64 + shift) / n);
                Vec3::new(1.0 - u - v, u, v)
            };
            let inverted = (i + j + 1 < divisions).then(|| point(2.0 / 3.0));
            std::iter::once(point(1.0 / 3.0)).chain(inverted)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centroids_of_the_pieces_average_to_that_of_the_triangle() {
        for parts in 1..6 {
            let list: Vec<Vec3> = centroids(parts).collect();
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
        divide([Vec3::zeros(), Vec3::x(), Vec3::new(0.0, 2.0, 0.0)], 0.1, &mut parts);
        let total: Vec3 = parts.iter().map(|p| p.area).sum();
        assert!((total[2] - 1.0).abs() < 1e-12 && total[0] == 0.0 && parts.iter().all(|p| p.key.side == 4));
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
            divide(corners, size, &mut parts);
            let longest = longest_edge(&corners);
            let (part, area) = (longest / (longest / (1.5 * size)).ceil().min(64.0), whole.norm());
            // The number of congruent pieces, up to the factor above which strips are used.
            let most = SLIVER_FACTOR * (2.0 * area / (part * part) + longest / part) + 1.0;
            assert!((parts.len() as f64) <= most, "{} parts of {length} x {height}", parts.len());
            let total: Vec3 = parts.iter().map(|p| p.area).sum();
            let middle: Vec3 = parts.iter().map(|p| p.area.norm() / area * p.centroid).sum();
            let centroid = corners.iter().sum::<Vec3>() / 3.0;
            assert!((total - whole).norm() < 1e-12 * area && (middle - centroid).norm() < 1e-12 * length);
        }
    }

    #[test]
    fn merging_early_changes_only_rounding() {
        let mut random = pliant_mesh::testing::Random(5);
        let mut parts = Vec::new();
        for _ in 0..50 {
            let corners = [(); 3].map(|()| random.vector());
            divide(corners, 0.2, &mut parts);
        }
        let whole = merge_all(parts.clone());
        let half = parts.len() / 2;
        let mut partly_merged = merge_all(parts[..half].to_vec());
        partly_merged.extend_from_slice(&parts[half..]);
        let again = merge_all(partly_merged);
        assert_eq!(whole.len(), again.len());
        for (a, b) in whole.iter().zip(&again) {
            // Where normals in a box differ, the halves are weighted a little differently; area is exact.
            let (area, place) = ((a.area - b.area).norm(), (a.centroid - b.centroid).norm());
            assert!(a.key == b.key && area < 1e-12 && place < 0.1, "{area} {place}");
        }
    }
}
