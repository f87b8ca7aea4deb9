//! The voxels of one cut cell: which are connected, and the fragments they form.

use super::crossing::{Plane, are_apart, crosses, line_meets};
use super::voxel_points::VoxelPoints;
use pliant_mesh::DisjointSets;
use pliant_solver::Vec3;

/// Voxels along the edge of a cell.
pub(super) const SIDE: usize = 4;
/// Voxels of a cell, numbered with x fastest.
pub(super) const COUNT: usize = SIDE * SIDE * SIDE;

/// Links between the voxels of a cell, and the fragments that follow from them.
#[derive(Clone, Debug)]
pub(super) struct Voxels {
    /// Bit v of axis a: voxel v is linked with the next one along that axis, which for the last is in the next cell.
    linked: [u64; 3],
    /// Bit v: the body occupies voxel v. Links of other voxels do not count.
    solid: u64,
    /// Ends of the links.
    points: Box<VoxelPoints>,
    fragment: [u8; COUNT],
    /// The fragments at the last [`Voxels::store_labels`].
    previous: [u8; COUNT],
    /// Number of solid voxels of each fragment.
    sizes: Vec<u8>,
    /// Number of voxels that the body occupied before parts of it became bodies of their own.
    occupied: u32,
    /// Bit v: voxel v belonged to a sliver and was merged with another fragment. It is no reference for points.
    merged: u64,
    /// Triangles that the blade has swept near the cell, m.
    blade: Vec<[Vec3; 3]>,
}

/// The link between the last voxel of a cell along an axis and the first one of the next cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceLink {
    /// Voxel of this cell.
    pub voxel: usize,
    /// Voxel of the next cell.
    pub neighbour: usize,
    /// Whether this voxel is solid and linked.
    pub is_connected: bool,
}

/// A visible voxel near a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NearestVoxel {
    pub fragment: usize,
    /// Square of the distance from the point to the voxel, m^2.
    pub distance_squared: f64,
}

/// Voxels that are last along each axis, ascending.
const LAST: [[usize; SIDE * SIDE]; 3] = {
    let mut last = [[0; SIDE * SIDE]; 3];
    let mut i = 0;
    while i < SIDE * SIDE {
        let (low, high) = (i % SIDE, i / SIDE);
        let end = SIDE - 1;
        last[0][i] = end + SIDE * i;
        last[1][i] = low + SIDE * end + SIDE * SIDE * high;
        last[2][i] = i + SIDE * SIDE * end;
        i += 1;
    }
    last
};

/// Index of a voxel along each axis.
pub(super) fn index(voxel: usize) -> [usize; 3] {
    [voxel % SIDE, voxel / SIDE % SIDE, voxel / (SIDE * SIDE)]
}

/// The next voxel of the cell along an axis; `None` for the last.
pub(super) fn next(voxel: usize, axis: usize) -> Option<usize> {
    (index(voxel)[axis] + 1 < SIDE).then(|| voxel + SIDE.pow(axis as u32))
}

/// The voxel at the other end of a cell along an axis, of one that is first or last.
pub(super) fn opposite(voxel: usize, axis: usize) -> usize {
    let step = (SIDE - 1) * SIDE.pow(axis as u32);
    if index(voxel)[axis] == 0 { voxel + step } else { voxel - step }
}

/// Squared distance between the centres of two voxels, in voxels.
pub(super) fn distance_squared(a: usize, b: usize) -> usize {
    index(a).iter().zip(index(b)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
}

impl Voxels {
    /// The voxels of an uncut cell; bit v of `solid` tells whether the body occupies voxel v. A cell without a solid voxel counts as solid.
    pub(super) fn new(solid: u64, points: VoxelPoints) -> Self {
        let solid = if solid == 0 { u64::MAX } else { solid };
        Self {
            linked: [u64::MAX; 3],
            solid,
            points: Box::new(points),
            fragment: [0; COUNT],
            previous: [0; COUNT],
            sizes: vec![solid.count_ones() as u8],
            occupied: solid.count_ones(),
            merged: 0,
            blade: Vec::new(),
        }
    }

    /// The voxels of a cell of which the body occupies nothing: all of it is in another body.
    pub(super) fn absent(points: VoxelPoints) -> Self {
        let mut voxels = Self::new(u64::MAX, points);
        (voxels.solid, voxels.sizes) = (0, Vec::new());
        voxels
    }

    /// Removes the fragments that are not `kept` (by number) from the body: what is left keeps its share of the cell, and is numbered in its order.
    pub(super) fn keep(&mut self, kept: &[bool]) {
        let removed = (0..COUNT).filter(|v| self.is_solid(*v) && !kept[self.fragment(*v)]);
        self.solid &= !removed.fold(0, |bits, v| bits | 1 << v);
        self.merged &= self.solid;
        let mut number = vec![0_u8; kept.len()];
        let numbers = number.iter_mut().zip(kept).filter(|(_, kept)| **kept);
        numbers.zip(0..).for_each(|((number, _), new)| *number = new);
        let mut sizes = kept.iter();
        self.sizes.retain(|_| sizes.next().copied().unwrap_or(false));
        let old = self.fragment;
        for voxel in 0..COUNT {
            let solid = (0..COUNT).filter(|other| self.is_solid(*other));
            let nearest = if self.is_solid(voxel) {
                Some(voxel)
            } else {
                solid.min_by_key(|other| distance_squared(voxel, *other))
            };
            self.fragment[voxel] = nearest.map_or(0, |nearest| number[usize::from(old[nearest])]);
        }
        self.store_labels();
    }

    /// Removes the links that a triangle crosses.
    pub(super) fn cut(&mut self, triangle: &[Vec3; 3]) {
        self.blade.push(*triangle);
        // The side of each point is computed once, not once for each of its links; most links have both ends on one side.
        let plane = Plane::new(triangle);
        let above =
            |points: &[Vec3]| points.iter().rev().fold(0_u64, |bits, p| bits << 1 | u64::from(plane.is_above(p)));
        let own = above(&self.points.own);
        for axis in 0..3 {
            let beyond_above = above(&self.points.beyond[axis]);
            let mut beyond = 0;
            for voxel in 0..COUNT {
                let (to, to_above) = if let Some(other) = next(voxel, axis) {
                    (self.points.own[other], own >> other & 1)
                } else if let Some(point) = self.points.beyond[axis].get(beyond) {
                    beyond += 1;
                    (*point, beyond_above >> (beyond - 1) & 1)
                } else {
                    continue;
                };
                let may_cross = self.linked[axis] >> voxel & 1 == 1 && own >> voxel & 1 != to_above;
                let from = self.points.own[voxel];
                if may_cross && !are_apart(&from, &to, triangle) && line_meets(from, to, triangle) {
                    self.linked[axis] &= !(1 << voxel);
                }
            }
        }
    }

    /// The points of all voxels, m.
    pub(super) fn points(&self) -> &[Vec3; COUNT] {
        &self.points.own
    }

    /// Removes the link of a voxel with the next one along an axis.
    pub(super) fn part(&mut self, voxel: usize, axis: usize) {
        self.linked[axis] &= !(1 << voxel);
    }

    /// Links again the voxels that were parted within `radius` (m) of a rest position (m). Returns whether there were any.
    pub(super) fn heal(&mut self, centre: Vec3, radius: f64) -> bool {
        let mut has_healed = false;
        for axis in 0..3 {
            let mut beyond = self.points.beyond[axis].iter();
            for voxel in 0..COUNT {
                let other = next(voxel, axis).map(|other| self.points.own[other]);
                let Some(to) = other.or_else(|| beyond.next().copied()) else { continue };
                let middle = 0.5 * (self.points.own[voxel] + to);
                if self.linked[axis] >> voxel & 1 == 0 && (middle - centre).norm() <= radius {
                    self.linked[axis] |= 1 << voxel;
                    has_healed = true;
                }
            }
        }
        if has_healed && self.linked == [u64::MAX; 3] {
            self.blade.clear();
        }
        has_healed
    }

    /// Labels the connected sets of solid voxels as fragments, in the order of their first voxels.
    pub(super) fn label(&mut self) {
        let mut sets = DisjointSets::new(COUNT);
        for voxel in 0..COUNT {
            for axis in 0..3 {
                if let Some(other) = next(voxel, axis)
                    && self.is_connected(voxel, axis)
                    && self.is_solid(other)
                {
                    sets.unite(voxel as u32, other as u32);
                }
            }
        }
        self.sizes.clear();
        self.merged = 0;
        let mut label = [u8::MAX; COUNT];
        let solid = self.solid;
        let is_solid = |voxel: &usize| solid >> voxel & 1 == 1;
        for voxel in (0..COUNT).filter(is_solid) {
            let root = sets.find(voxel as u32) as usize;
            if label[root] == u8::MAX {
                label[root] = self.sizes.len() as u8;
                self.sizes.push(0);
            }
            self.fragment[voxel] = label[root];
            self.sizes[label[root] as usize] += 1;
        }
        // A voxel outside of the body gets the fragment of the nearest solid one.
        for voxel in (0..COUNT).filter(|v| !is_solid(v)) {
            let nearest = (0..COUNT).filter(is_solid).min_by_key(|v| distance_squared(voxel, *v));
            self.fragment[voxel] = nearest.map_or(0, |v| self.fragment[v]);
        }
    }

    /// Merges `small` fragments with the others: each of their voxels gets the fragment of the nearest solid voxel of another one.
    pub(super) fn merge(&mut self, small: &[bool]) {
        let old = self.fragment;
        let stays = |voxel: &usize| !small[old[*voxel] as usize];
        let mut number = vec![0_u8; small.len()];
        let mut count = 0;
        for (f, _) in small.iter().enumerate().filter(|(_, small)| !**small) {
            number[f] = count;
            count += 1;
        }
        self.sizes = vec![0; usize::from(count)];
        for voxel in 0..COUNT {
            let is_solid = |other: &usize| self.is_solid(*other);
            let candidates = (0..COUNT).filter(is_solid).filter(stays);
            let nearest = candidates.min_by_key(|other| distance_squared(voxel, *other)).unwrap_or(0);
            self.fragment[voxel] = number[old[if stays(&voxel) { voxel } else { nearest }] as usize];
            self.merged |= u64::from(!stays(&voxel)) << voxel;
            if self.is_solid(voxel) {
                self.sizes[self.fragment[voxel] as usize] += 1;
            }
        }
    }

    /// Number of solid voxels of a fragment.
    pub(super) fn size(&self, fragment: usize) -> u32 {
        u32::from(self.sizes[fragment])
    }

    /// Number of fragments.
    pub(super) fn count(&self) -> usize {
        self.sizes.len()
    }

    /// Share of a fragment in the volume of the cell that was solid before any part became another body, 0 to 1.
    pub(super) fn share(&self, fragment: usize) -> f64 {
        f64::from(self.sizes[fragment]) / f64::from(self.occupied)
    }

    /// The fragment of a voxel.
    pub(super) fn fragment(&self, voxel: usize) -> usize {
        self.fragment[voxel] as usize
    }

    /// Stores the present fragments for [`Voxels::previous_fragment`].
    pub(super) fn store_labels(&mut self) {
        self.previous = self.fragment;
    }

    /// The fragment of a voxel at the last [`Voxels::store_labels`].
    pub(super) fn previous_fragment(&self, voxel: usize) -> usize {
        self.previous[voxel] as usize
    }

    /// Whether a voxel belonged to a sliver.
    pub(super) fn is_merged(&self, voxel: usize) -> bool {
        self.merged >> voxel & 1 == 1
    }

    /// The first solid voxel of a fragment.
    pub(super) fn first(&self, fragment: usize) -> usize {
        (0..COUNT).find(|v| self.is_solid(*v) && self.fragment(*v) == fragment).unwrap_or(0)
    }

    /// Whether the body occupies a voxel.
    pub(super) fn is_solid(&self, voxel: usize) -> bool {
        self.solid >> voxel & 1 == 1
    }

    /// Whether a voxel is solid and linked with the next one along an axis, in this cell or the next.
    pub(super) fn is_connected(&self, voxel: usize, axis: usize) -> bool {
        self.is_solid(voxel) && self.linked[axis] >> voxel & 1 == 1
    }

    /// The 16 links through the face to the next cell along an axis.
    pub(super) fn face(&self, axis: usize) -> impl Iterator<Item = FaceLink> + '_ {
        LAST[axis].iter().map(move |&voxel| FaceLink {
            voxel,
            neighbour: opposite(voxel, axis),
            is_connected: self.is_connected(voxel, axis),
        })
    }

    /// The fragment that contains a point (m): that of the nearest visible voxel, else of the nearest one. `edge` is that of the cell (m).
    pub(super) fn fragment_at(&self, edge: f64, point: Vec3) -> usize {
        if self.sizes.len() == 1 {
            return 0;
        }
        let nearest = || (0..COUNT).min_by(|a, b| self.distance_to(*a, point).total_cmp(&self.distance_to(*b, point)));
        self.nearest_visible(edge, point)
            .map_or_else(|| nearest().map_or(0, |voxel| self.fragment(voxel)), |nearest| nearest.fragment)
    }

    /// The nearest reference voxel within two voxels of a point (m) that the blade does not separate from it.
    pub(super) fn nearest_visible(&self, edge: f64, point: Vec3) -> Option<NearestVoxel> {
        if self.blade.is_empty() && self.sizes.len() == 1 {
            return Some(NearestVoxel { fragment: 0, distance_squared: 0.0 });
        }
        let size = edge / SIDE as f64;
        let mut left = self.references();
        // Nearest first, so that only one or two are tested against all triangles.
        loop {
            let distances =
                (0..COUNT).filter(|voxel| left >> voxel & 1 == 1).map(|voxel| (self.distance_to(voxel, point), voxel));
            let (distance_squared, voxel) = distances.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if distance_squared >= 4.0 * size * size {
                return None;
            }
            if !self.separates(point, self.points.own[voxel]) {
                return Some(NearestVoxel { fragment: self.fragment(voxel), distance_squared });
            }
            left &= !(1 << voxel);
        }
    }

    /// Whether the blade has passed between two points.
    pub(super) fn separates(&self, from: Vec3, to: Vec3) -> bool {
        self.blade.iter().any(|triangle| crosses(from, to, triangle))
    }

    /// Reference voxels and their points, m.
    pub(super) fn reference_points(&self) -> impl Iterator<Item = (usize, Vec3)> + '_ {
        let references = self.references();
        (0..COUNT).filter(move |voxel| references >> voxel & 1 == 1).map(|voxel| (voxel, self.points.own[voxel]))
    }

    /// Voxels whose fragment decides for points near them, as bits: solid ones that were not merged.
    fn references(&self) -> u64 {
        self.solid & !self.merged
    }

    /// Squared distance of a voxel's point from a point, m^2.
    fn distance_to(&self, voxel: usize, point: Vec3) -> f64 {
        (self.points.own[voxel] - point).norm_squared()
    }
}

/// Centre of a voxel of `size` (m) in a cell with least corner `reference` (m).
pub(super) fn centre(reference: Vec3, size: f64, voxel: usize) -> Vec3 {
    let at = index(voxel);
    Vec3::from_fn(|i, _| reference[i] + (at[i] as f64 + 0.5) * size)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square across the unit cell at x = `at`, up to y = `to`.
    fn wall(at: f64, to: f64) -> [[Vec3; 3]; 2] {
        let corner = |y: f64, z: f64| Vec3::new(at, y, z);
        let (low, high) = (-0.5, 1.5);
        [[corner(low, low), corner(to, low), corner(to, high)], [corner(low, low), corner(to, high), corner(low, high)]]
    }

    fn cut(triangles: &[[Vec3; 3]]) -> Voxels {
        let mut voxels = Voxels::new(u64::MAX, VoxelPoints::centres(Vec3::zeros(), 1.0));
        triangles.iter().for_each(|t| voxels.cut(t));
        voxels.label();
        voxels
    }

    #[test]
    fn a_wall_divides_a_cell_by_its_position() {
        for (at, shares) in [(0.3, [0.25, 0.75]), (0.5, [0.5, 0.5]), (0.6, [0.5, 0.5])] {
            let voxels = cut(&wall(at, 1.5));
            assert_eq!(voxels.count(), 2);
            assert_eq!([voxels.share(0), voxels.share(1)], shares);
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(0.01, 0.5, 0.5)), 0);
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(0.99, 0.5, 0.5)), 1);
            // Right beside the wall, in a voxel whose centre is on its other side.
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(at - 1e-3, 0.5, 0.5)), 0);
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(at + 1e-3, 0.5, 0.5)), 1);
        }
    }

    #[test]
    fn a_wall_that_ends_inside_leaves_the_cell_whole() {
        assert_eq!(cut(&wall(0.3, 0.6)).count(), 1);
        let crossed = [wall(0.3, 1.5), wall(0.3, 1.5)].concat();
        assert_eq!(cut(&crossed).count(), 2, "the same cut twice is one");
    }

    #[test]
    fn two_walls_make_three_fragments_and_a_wall_on_a_face_cuts_the_links_through_it() {
        assert_eq!(cut(&[wall(0.3, 1.5), wall(0.8, 1.5)].concat()).count(), 3);
        let voxels = cut(&wall(1.0, 1.5));
        assert_eq!(voxels.count(), 1);
        assert!(voxels.face(0).all(|link| !link.is_connected) && voxels.face(1).all(|link| link.is_connected));
    }

    #[test]
    fn only_solid_voxels_connect() {
        let plates = (0..COUNT).filter(|v| [0, 3].contains(&index(*v)[0])).fold(0, |solid, v| solid | 1 << v);
        for (solid, count) in [(plates, 2), (u64::MAX, 1)] {
            let mut voxels = Voxels::new(solid, VoxelPoints::centres(Vec3::zeros(), 1.0));
            voxels.label();
            assert_eq!(voxels.count(), count);
            assert_eq!(voxels.share(0), 1.0 / count as f64);
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(0.95, 0.5, 0.5)), count - 1);
        }
    }
}
