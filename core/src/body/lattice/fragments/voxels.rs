//! The voxels of one cell, and which of them hang together.

use crate::step::{V3, axpy, dot};
use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

/// Voxels along the edge of a cell.
pub(super) const SIDE: usize = 4;
const COUNT: usize = SIDE * SIDE * SIDE;

/// Links between voxels, and the fragments they make.
#[derive(Clone, Debug)]
pub(super) struct Voxels {
    /// Bit v of axis a: voxel v is joined to the next along that axis, which for the last is in the next cell.
    joined: [u64; 3],
    fragment: [u8; COUNT],
    /// The fragments before the last labelling.
    before: [u8; COUNT],
    /// Voxels of each fragment.
    sizes: Vec<u8>,
    /// Where the blade has passed, m.
    blade: Vec<[V3; 3]>,
}

impl Default for Voxels {
    fn default() -> Self {
        Self {
            joined: [u64::MAX; 3],
            fragment: [0; COUNT],
            before: [0; COUNT],
            sizes: vec![COUNT as u8],
            blade: Vec::new(),
        }
    }
}

/// Place of a voxel along each axis.
fn index(voxel: usize) -> [usize; 3] {
    [voxel % SIDE, voxel / SIDE % SIDE, voxel / (SIDE * SIDE)]
}

/// The next voxel along an axis, within the cell.
fn next(voxel: usize, axis: usize) -> Option<usize> {
    (index(voxel)[axis] + 1 < SIDE).then(|| voxel + SIDE.pow(axis as u32))
}

impl Voxels {
    /// Cuts the links a triangle passes through.
    pub(super) fn cut(&mut self, reference: V3, edge: f64, triangle: &[V3; 3]) {
        let size = edge / SIDE as f64;
        self.blade.push(*triangle);
        for voxel in 0..COUNT {
            let from = middle(reference, size, voxel);
            for axis in 0..3 {
                let mut to = from;
                to[axis] += size;
                if self.joined[axis] >> voxel & 1 == 1 && crosses(from, to, triangle) {
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
                {
                    let (a, b) = (find(&mut root, voxel), find(&mut root, other));
                    root[a.max(b)] = a.min(b) as u8;
                }
            }
        }
        self.sizes.clear();
        let mut label = [u8::MAX; COUNT];
        for voxel in 0..COUNT {
            let top = find(&mut root, voxel);
            if label[top] == u8::MAX {
                label[top] = self.sizes.len() as u8;
                self.sizes.push(0);
            }
            self.fragment[voxel] = label[top];
            self.sizes[label[top] as usize] += 1;
        }
    }

    /// Fragments there are.
    pub(super) fn count(&self) -> usize {
        self.sizes.len()
    }

    /// Of the cell's volume.
    pub(super) fn share(&self, fragment: usize) -> f64 {
        f64::from(self.sizes[fragment]) / COUNT as f64
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
        self.fragment.iter().position(|f| *f as usize == fragment).unwrap_or(0)
    }

    fn is_joined(&self, voxel: usize, axis: usize) -> bool {
        self.joined[axis] >> voxel & 1 == 1
    }

    /// (voxel of this cell, voxel of the next cell along `axis`, whether they are joined), for the 16 of the common face.
    pub(super) fn face(&self, axis: usize) -> impl Iterator<Item = (usize, usize, bool)> + '_ {
        let last = (0..COUNT).filter(move |v| index(*v)[axis] == SIDE - 1);
        last.map(move |v| (v, v - (SIDE - 1) * SIDE.pow(axis as u32), self.is_joined(v, axis)))
    }

    /// The fragment a place belongs to: that of the nearest voxel the blade does not part it from.
    pub(super) fn fragment_at(&self, reference: V3, edge: f64, place: V3) -> usize {
        if self.sizes.len() == 1 {
            return 0;
        }
        let size = edge / SIDE as f64;
        let away = |voxel: usize| {
            let d = axpy(middle(reference, size, voxel), -1.0, place);
            dot(d, d)
        };
        let parted = |voxel: usize| self.blade.iter().any(|t| crosses(place, middle(reference, size, voxel), t));
        // Nearest first: one or two of them are asked, whatever the number of triangles.
        let mut order: [u8; COUNT] = std::array::from_fn(|v| v as u8);
        order.sort_unstable_by(|a, b| away(*a as usize).total_cmp(&away(*b as usize)).then(a.cmp(b)));
        let within = order.iter().map(|v| *v as usize).take_while(|v| away(*v) < 4.0 * size * size);
        let free = within.into_iter().find(|v| !parted(*v));
        self.fragment[free.unwrap_or(order[0] as usize)] as usize
    }
}

fn middle(reference: V3, size: f64, voxel: usize) -> V3 {
    let at = index(voxel);
    std::array::from_fn(|i| reference[i] + (at[i] as f64 + 0.5) * size)
}

/// Whether a segment passes through a triangle, edges included: decided exactly.
pub(super) fn crosses(from: V3, to: V3, [a, b, c]: &[V3; 3]) -> bool {
    let coord = |p: &V3| Coord3D { x: p[0], y: p[1], z: p[2] };
    let side = |p: &V3, q: &V3, r: &V3, s: &V3| orient3d(coord(p), coord(q), coord(r), coord(s));
    let (start, end) = (side(a, b, c, &from), side(a, b, c, &to));
    // A middle on the blade itself counts as on its positive side, from wherever it is looked at.
    if (start >= 0.0) == (end >= 0.0) {
        return false;
    }
    let turns = [side(&from, &to, a, b), side(&from, &to, b, c), side(&from, &to, c, a)];
    turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0)
}

/// Whether the plane of a triangle meets a cube, and the boxes of both meet: never no where they touch.
pub(super) fn plane_meets_box(triangle: &[V3; 3], middle: V3, half: f64) -> bool {
    for i in 0..3 {
        let low = triangle.iter().fold(f64::INFINITY, |m, p| m.min(p[i]));
        let high = triangle.iter().fold(-f64::INFINITY, |m, p| m.max(p[i]));
        if low > middle[i] + half || high < middle[i] - half {
            return false;
        }
    }
    let [a, b, c] = triangle.map(Vector3::from);
    let normal: V3 = (b - a).cross(&(c - a)).into();
    let distance = dot(normal, axpy(middle, -1.0, triangle[0])).abs();
    distance <= half * (normal[0].abs() + normal[1].abs() + normal[2].abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square across the unit cell at x = `at`, up to y = `to`.
    fn wall(at: f64, to: f64) -> [[V3; 3]; 2] {
        let corner = |y: f64, z: f64| [at, y, z];
        let (low, high) = (-0.5, 1.5);
        [[corner(low, low), corner(to, low), corner(to, high)], [corner(low, low), corner(to, high), corner(low, high)]]
    }

    fn cut(triangles: &[[V3; 3]]) -> Voxels {
        let mut voxels = Voxels::default();
        triangles.iter().for_each(|t| voxels.cut([0.0; 3], 1.0, t));
        voxels.label();
        voxels
    }

    #[test]
    fn a_wall_through_a_cell_parts_it_by_its_place() {
        for (at, shares) in [(0.3, [0.25, 0.75]), (0.5, [0.5, 0.5]), (0.6, [0.5, 0.5])] {
            let voxels = cut(&wall(at, 1.5));
            assert_eq!(voxels.count(), 2);
            assert_eq!([voxels.share(0), voxels.share(1)], shares);
            assert_eq!(voxels.fragment_at([0.0; 3], 1.0, [0.01, 0.5, 0.5]), 0);
            assert_eq!(voxels.fragment_at([0.0; 3], 1.0, [0.99, 0.5, 0.5]), 1);
            // Right beside the wall, in a voxel whose middle is on its other side.
            assert_eq!(voxels.fragment_at([0.0; 3], 1.0, [at - 1e-3, 0.5, 0.5]), 0);
            assert_eq!(voxels.fragment_at([0.0; 3], 1.0, [at + 1e-3, 0.5, 0.5]), 1);
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
    fn crossings_are_the_same_from_both_ends() {
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for (p, q, expected) in [
            ([0.2, 0.2, -1.0], [0.2, 0.2, 1.0], true),
            ([0.2, 0.2, 0.0], [0.2, 0.2, 1.0], true),
            ([0.2, 0.2, 0.0], [0.2, 0.2, -1.0], false),
            ([0.8, 0.8, -1.0], [0.8, 0.8, 1.0], false),
        ] {
            assert_eq!(crosses(p, q, &triangle), expected);
            assert_eq!(crosses(q, p, &triangle), expected);
        }
    }
}
