//! Which voxels of a cell a body is in, and a place in each that is in the body.
//!
//! A cut goes through the body and no further. So links are looked at between places inside of it: the middle of a voxel, or
//! where that is outside the point of the surface closest to it, moved in a little.

use super::Inner;
use super::crossing::plane_meets_box;
use super::voxels::{COUNT, SIDE, index, middle, next};
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// How far inside of the surface, in voxels.
const INSIDE: f64 = 1e-3;

/// Places of the voxels of one cell, m.
#[derive(Clone, Debug)]
pub(super) struct Places {
    pub own: [Vec3; COUNT],
    /// Of the voxels of the next cell along each axis, beside this one's last; in the order of those.
    pub far: [[Vec3; SIDE * SIDE]; 3],
}

impl Places {
    /// The middles of all voxels.
    pub fn middles(reference: Vec3, edge: f64) -> Self {
        let size = edge / SIDE as f64;
        Self { own: std::array::from_fn(|v| middle(reference, size, v)), far: beyond(reference, size) }
    }

    /// Moves the middles of rim voxels that are outside of `inner` into it, and gives the voxels it is in.
    pub fn fit(&mut self, centre: Vec3, edge: f64, inner: &impl Inner) -> u64 {
        let size = edge / SIDE as f64;
        let triangles = inner.near(centre, 0.5 * edge + size);
        let mut rim = 0;
        let mut own = self.own;
        for (voxel, place) in own.iter_mut().enumerate() {
            if fit(place, size, &triangles) {
                rim |= 1 << voxel;
            }
        }
        let solid = fill(rim, |voxel| inner.has(self.own[voxel]));
        self.own = own;
        self.far.iter_mut().flatten().for_each(|place| _ = fit(place, size, &triangles));
        solid
    }
}

fn beyond(reference: Vec3, size: f64) -> [[Vec3; SIDE * SIDE]; 3] {
    [0, 1, 2].map(|axis| {
        let mut last = (0..COUNT).filter(|v| index(*v)[axis] == SIDE - 1);
        std::array::from_fn(|_| {
            let mut place = middle(reference, size, last.next().unwrap_or(0));
            place[axis] += size;
            place
        })
    })
}

/// Moves the middle of a voxel into the body if the surface passes through the voxel and the middle is outside. Gives
/// whether it passes.
fn fit(place: &mut Vec3, size: f64, triangles: &[[Vec3; 3]]) -> bool {
    let mut closest: Option<(f64, Vec3, Vec3)> = None;
    for triangle in triangles.iter().filter(|t| plane_meets_box(t, *place, 0.5 * size)) {
        let point = closest_point(*place, *triangle).point;
        let away = *place - point;
        if closest.is_none_or(|(least, ..)| away.norm_squared() < least) {
            let [a, b, c] = triangle;
            closest =
                Some((away.norm_squared(), point, (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()));
        }
    }
    let Some((_, point, normal)) = closest else { return false };
    if (*place - point).dot(&normal) > 0.0 {
        *place = point - INSIDE * size * normal;
    }
    true
}

/// Adds to the rim the voxels within: those beside it are inside or outside by groups that hang together.
fn fill(rim: u64, inside: impl Fn(usize) -> bool) -> u64 {
    let (mut solid, mut seen) = (rim, rim);
    let mut waiting = Vec::new();
    while seen != u64::MAX {
        let seed = (!seen).trailing_zeros() as usize;
        let mut group = 0_u64;
        waiting.push(seed);
        seen |= 1 << seed;
        while let Some(voxel) = waiting.pop() {
            group |= 1 << voxel;
            for axis in 0..3 {
                let before = (index(voxel)[axis] > 0).then(|| voxel - SIDE.pow(axis as u32));
                for other in next(voxel, axis).into_iter().chain(before) {
                    if seen >> other & 1 == 0 {
                        seen |= 1 << other;
                        waiting.push(other);
                    }
                }
            }
        }
        if inside(seed) {
            solid |= group;
        }
    }
    solid
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The half-space z < 0.3 of a unit cell.
    struct Half;

    impl Inner for Half {
        fn near(&self, _: Vec3, _: f64) -> Vec<[Vec3; 3]> {
            vec![[Vec3::new(-9.0, -9.0, 0.3), Vec3::new(9.0, -9.0, 0.3), Vec3::new(0.0, 20.0, 0.3)]]
        }

        fn has(&self, place: Vec3) -> bool {
            place[2] < 0.3
        }
    }

    #[test]
    fn places_are_inside_and_voxels_outside_are_left_out() {
        let mut places = Places::middles(Vec3::zeros(), 1.0);
        let solid = places.fit(Vec3::repeat(0.5), 1.0, &Half);
        assert_eq!(solid.count_ones(), 32, "two layers: one inside, one the surface passes through");
        for voxel in (0..COUNT).filter(|v| solid >> v & 1 == 1) {
            assert!(places.own[voxel][2] < 0.3, "{:?}", places.own[voxel]);
        }
        assert!(places.far[0].iter().all(|p| (p[0] - 1.125).abs() < 1e-12));
    }
}
