//! The voxels of one cell, and which of them hang together.

use super::crossing::{Plane, are_apart, crosses, meets};
use super::places::Places;
use pliant_solver::Vec3;

/// Voxels along the edge of a cell.
pub(super) const SIDE: usize = 4;
pub(super) const COUNT: usize = SIDE * SIDE * SIDE;

/// Links between voxels, and the fragments they make.
#[derive(Clone, Debug)]
pub(super) struct Voxels {
    /// Bit v of axis a: voxel v is joined to the next along that axis, which for the last is in the next cell.
    joined: [u64; 3],
    /// Bit v: the body is in voxel v. The others join nothing.
    solid: u64,
    /// Where links begin and end.
    places: Box<Places>,
    fragment: [u8; COUNT],
    /// The fragments before the last labelling.
    before: [u8; COUNT],
    /// Voxels of each fragment.
    sizes: Vec<u8>,
    /// Bit v: voxel v was too small a part and is with another. No place goes by it.
    merged: u64,
    /// Where the blade has passed, m.
    blade: Vec<[Vec3; 3]>,
}

/// Voxels that are last along each axis, rising.
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

/// Place of a voxel along each axis.
pub(super) fn index(voxel: usize) -> [usize; 3] {
    [voxel % SIDE, voxel / SIDE % SIDE, voxel / (SIDE * SIDE)]
}

/// The next voxel along an axis, within the cell.
pub(super) fn next(voxel: usize, axis: usize) -> Option<usize> {
    (index(voxel)[axis] + 1 < SIDE).then(|| voxel + SIDE.pow(axis as u32))
}

impl Voxels {
    /// Uncut; bit v of `solid` tells whether the body is in voxel v. A cell without a solid voxel is solid throughout.
    pub(super) fn new(solid: u64, places: Places) -> Self {
        let solid = if solid == 0 { u64::MAX } else { solid };
        Self {
            joined: [u64::MAX; 3],
            solid,
            places: Box::new(places),
            fragment: [0; COUNT],
            before: [0; COUNT],
            sizes: vec![solid.count_ones() as u8],
            merged: 0,
            blade: Vec::new(),
        }
    }

    /// Cuts the links a triangle passes through.
    pub(super) fn cut(&mut self, triangle: &[Vec3; 3]) {
        self.blade.push(*triangle);
        // Most links have both ends on one side of it: each end is asked once, not for every link it has.
        let plane = Plane::new(triangle);
        let above =
            |places: &[Vec3]| places.iter().rev().fold(0_u64, |bits, p| bits << 1 | u64::from(plane.is_above(p)));
        let own = above(&self.places.own);
        for axis in 0..3 {
            let far_above = above(&self.places.far[axis]);
            let mut far = 0;
            for voxel in 0..COUNT {
                let (to, to_above) = if let Some(other) = next(voxel, axis) {
                    (self.places.own[other], own >> other & 1)
                } else if let Some(place) = self.places.far[axis].get(far) {
                    far += 1;
                    (*place, far_above >> (far - 1) & 1)
                } else {
                    continue;
                };
                let is_asked = self.joined[axis] >> voxel & 1 == 1 && own >> voxel & 1 != to_above;
                let from = self.places.own[voxel];
                if is_asked && !are_apart(&from, &to, triangle) && meets(from, to, triangle) {
                    self.joined[axis] &= !(1 << voxel);
                }
            }
        }
    }

    /// Finds the fragments.
    pub(super) fn label(&mut self) {
        let mut root: [u8; COUNT] = std::array::from_fn(|v| v as u8);
        fn find(root: &mut [u8; COUNT], v: usize) -> usize {
            let up = root[v] as usize;
            if up == v {
                return v;
            }
            let top = find(root, up);
            root[v] = top as u8;
            top
        }
        for voxel in 0..COUNT {
            for axis in 0..3 {
                if let Some(other) = next(voxel, axis)
                    && self.is_joined(voxel, axis)
                    && self.is_solid(other)
                {
                    let (a, b) = (find(&mut root, voxel), find(&mut root, other));
                    root[a.max(b)] = a.min(b) as u8;
                }
            }
        }
        self.sizes.clear();
        self.merged = 0;
        let mut label = [u8::MAX; COUNT];
        let solid = self.solid;
        let is_solid = |voxel: &usize| solid >> voxel & 1 == 1;
        for voxel in (0..COUNT).filter(is_solid) {
            let top = find(&mut root, voxel);
            if label[top] == u8::MAX {
                label[top] = self.sizes.len() as u8;
                self.sizes.push(0);
            }
            self.fragment[voxel] = label[top];
            self.sizes[label[top] as usize] += 1;
        }
        // What is outside of the body goes with what is nearest.
        for voxel in (0..COUNT).filter(|v| !is_solid(v)) {
            let away = |other: usize| -> usize {
                index(voxel).iter().zip(index(other)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
            };
            let nearest = (0..COUNT).filter(is_solid).min_by_key(|v| away(*v));
            self.fragment[voxel] = nearest.map_or(0, |v| self.fragment[v]);
        }
    }

    /// Gives the voxels of `small` fragments to the others, each to that of the nearest voxel.
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
            let away = |other: &usize| -> usize {
                index(voxel).iter().zip(index(*other)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
            };
            let solid = |other: &usize| self.is_solid(*other);
            let nearest = (0..COUNT).filter(solid).filter(stays).min_by_key(away).unwrap_or(0);
            self.fragment[voxel] = number[old[if stays(&voxel) { voxel } else { nearest }] as usize];
            self.merged |= u64::from(!stays(&voxel)) << voxel;
            if self.is_solid(voxel) {
                self.sizes[self.fragment[voxel] as usize] += 1;
            }
        }
    }

    /// Voxels of a fragment.
    pub(super) fn size(&self, fragment: usize) -> u32 {
        u32::from(self.sizes[fragment])
    }

    /// Fragments there are.
    pub(super) fn count(&self) -> usize {
        self.sizes.len()
    }

    /// Of the cell's volume.
    pub(super) fn share(&self, fragment: usize) -> f64 {
        f64::from(self.sizes[fragment]) / f64::from(self.solid.count_ones())
    }

    /// The fragment of a voxel.
    pub(super) fn fragment(&self, voxel: usize) -> usize {
        self.fragment[voxel] as usize
    }

    /// What was found last is what was before, from now on.
    pub(super) fn settle(&mut self) {
        self.before = self.fragment;
    }

    /// The fragment a voxel belonged to before the last labelling.
    pub(super) fn was(&self, voxel: usize) -> usize {
        self.before[voxel] as usize
    }

    /// The first voxel of a fragment.
    pub(super) fn first(&self, fragment: usize) -> usize {
        (0..COUNT).find(|v| self.is_solid(*v) && self.fragment(*v) == fragment).unwrap_or(0)
    }

    /// Whether the body is in a voxel.
    pub(super) fn is_solid(&self, voxel: usize) -> bool {
        self.solid >> voxel & 1 == 1
    }

    /// Whether a voxel is joined to the next along an axis, in this cell or the next.
    pub(super) fn is_joined(&self, voxel: usize, axis: usize) -> bool {
        self.is_solid(voxel) && self.joined[axis] >> voxel & 1 == 1
    }

    /// (voxel of this cell, voxel of the next cell along `axis`, whether they are joined), for the 16 of the common face.
    pub(super) fn face(&self, axis: usize) -> impl Iterator<Item = (usize, usize, bool)> + '_ {
        LAST[axis].iter().map(move |&v| (v, v - (SIDE - 1) * SIDE.pow(axis as u32), self.is_joined(v, axis)))
    }

    /// The fragment a place belongs to: that of the nearest voxel the blade does not part it from, or just the nearest.
    pub(super) fn fragment_at(&self, edge: f64, place: Vec3) -> usize {
        if self.sizes.len() == 1 {
            return 0;
        }
        let nearest = || (0..COUNT).min_by(|a, b| self.away(*a, place).total_cmp(&self.away(*b, place)));
        self.reached(edge, place)
            .map_or_else(|| nearest().map_or(0, |voxel| self.fragment(voxel)), |(fragment, _)| fragment)
    }

    /// The fragment of the nearest voxel that the blade does not part a place from, if there is one close by; and how far
    /// away it is, m^2.
    pub(super) fn reached(&self, edge: f64, place: Vec3) -> Option<(usize, f64)> {
        if self.blade.is_empty() && self.sizes.len() == 1 {
            return Some((0, 0.0));
        }
        let size = edge / SIDE as f64;
        let mut left = self.solid & !self.merged;
        // Nearest first: one or two of them are asked, whatever the number of triangles.
        loop {
            let of_left =
                (0..COUNT).filter(|voxel| left >> voxel & 1 == 1).map(|voxel| (self.away(voxel, place), voxel));
            let (away, voxel) = of_left.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if away >= 4.0 * size * size {
                return None;
            }
            if !self.parts(place, self.places.own[voxel]) {
                return Some((self.fragment(voxel), away));
            }
            left &= !(1 << voxel);
        }
    }

    /// Whether the blade has passed between two places.
    pub(super) fn parts(&self, from: Vec3, to: Vec3) -> bool {
        self.blade.iter().any(|triangle| crosses(from, to, triangle))
    }

    /// Voxels that places can go by, with their own places, m.
    pub(super) fn whole(&self) -> impl Iterator<Item = (usize, Vec3)> + '_ {
        let left = self.solid & !self.merged;
        (0..COUNT).filter(move |voxel| left >> voxel & 1 == 1).map(|voxel| (voxel, self.places.own[voxel]))
    }

    fn away(&self, voxel: usize, place: Vec3) -> f64 {
        (self.places.own[voxel] - place).norm_squared()
    }
}

pub(super) fn middle(reference: Vec3, size: f64, voxel: usize) -> Vec3 {
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
        let mut voxels = Voxels::new(u64::MAX, Places::middles(Vec3::zeros(), 1.0));
        triangles.iter().for_each(|t| voxels.cut(t));
        voxels.label();
        voxels
    }

    #[test]
    fn a_wall_through_a_cell_parts_it_by_its_place() {
        for (at, shares) in [(0.3, [0.25, 0.75]), (0.5, [0.5, 0.5]), (0.6, [0.5, 0.5])] {
            let voxels = cut(&wall(at, 1.5));
            assert_eq!(voxels.count(), 2);
            assert_eq!([voxels.share(0), voxels.share(1)], shares);
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(0.01, 0.5, 0.5)), 0);
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(0.99, 0.5, 0.5)), 1);
            // Right beside the wall, in a voxel whose middle is on its other side.
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
    fn two_walls_make_three_parts_and_a_wall_on_the_face_parts_the_neighbour() {
        assert_eq!(cut(&[wall(0.3, 1.5), wall(0.8, 1.5)].concat()).count(), 3);
        let voxels = cut(&wall(1.0, 1.5));
        assert_eq!(voxels.count(), 1);
        assert!(voxels.face(0).all(|(_, _, joined)| !joined) && voxels.face(1).all(|(_, _, joined)| joined));
    }

    #[test]
    fn only_what_is_solid_joins() {
        let plates = (0..COUNT).filter(|v| [0, 3].contains(&index(*v)[0])).fold(0, |solid, v| solid | 1 << v);
        for (solid, count) in [(plates, 2), (u64::MAX, 1)] {
            let mut voxels = Voxels::new(solid, Places::middles(Vec3::zeros(), 1.0));
            voxels.label();
            assert_eq!(voxels.count(), count);
            assert_eq!(voxels.share(0), 1.0 / count as f64);
            assert_eq!(voxels.fragment_at(1.0, Vec3::new(0.95, 0.5, 0.5)), count - 1);
        }
    }
}
