//! Which voxels of a cell the body occupies, and a point of the body in each.
//!
//! A cut divides the body, not the space beside it. So whether a blade passes between two voxels is tested between points inside of the
//! body: the centre of a voxel, or, where the centre is outside, the nearest point of the surface, moved inwards a little.

use super::BodyInterior;
use super::crossing::plane_meets_box;
use super::voxels::{COUNT, SIDE, centre, index, next};
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// Depth below the surface of a moved point, in voxels.
const INSIDE: f64 = 1e-3;

/// A point for each voxel of one cell, m.
#[derive(Clone, Debug)]
pub(super) struct VoxelPoints {
    pub own: [Vec3; COUNT],
    /// Points of the voxels just beyond this cell's last along each axis, in the order of these.
    pub beyond: [[Vec3; SIDE * SIDE]; 3],
}

impl VoxelPoints {
    /// The centres of all voxels of a cell with least corner `reference` and edge `edge`, m.
    pub fn centres(reference: Vec3, edge: f64) -> Self {
        let size = edge / SIDE as f64;
        Self { own: std::array::from_fn(|v| centre(reference, size, v)), beyond: centres_beyond(reference, size) }
    }

    /// Moves the points of voxels on the surface into the body. Returns the voxels that the body occupies, as bits. `cell_centre` is the
    /// centre of the cell (m).
    pub fn move_inside(&mut self, cell_centre: Vec3, edge: f64, interior: &impl BodyInterior) -> u64 {
        let size = edge / SIDE as f64;
        let triangles = interior.triangles_near(cell_centre, 0.5 * edge + size);
        let mut on_surface = 0;
        let mut own = self.own;
        for (voxel, point) in own.iter_mut().enumerate() {
            if move_inside(point, size, &triangles) {
                on_surface |= 1 << voxel;
            }
        }
        let solid = add_interior(on_surface, |voxel| interior.contains(self.own[voxel]));
        self.own = own;
        self.beyond.iter_mut().flatten().for_each(|point| _ = move_inside(point, size, &triangles));
        solid
    }
}

fn centres_beyond(reference: Vec3, size: f64) -> [[Vec3; SIDE * SIDE]; 3] {
    [0, 1, 2].map(|axis| {
        let mut last = (0..COUNT).filter(|v| index(*v)[axis] == SIDE - 1);
        std::array::from_fn(|_| {
            let mut point = centre(reference, size, last.next().unwrap_or(0));
            point[axis] += size;
            point
        })
    })
}

/// Moves the centre of a voxel of `size` (m) into the body if the surface passes through the voxel and the centre is outside. Returns whether
/// the surface passes.
fn move_inside(point: &mut Vec3, size: f64, triangles: &[[Vec3; 3]]) -> bool {
    // Squared distance, nearest point and normal of the nearest triangle.
    let mut nearest: Option<(f64, Vec3, Vec3)> = None;
    for triangle in triangles.iter().filter(|t| plane_meets_box(t, *point, 0.5 * size)) {
        let closest = closest_point(*point, *triangle).point;
        let distance_squared = (*point - closest).norm_squared();
        if nearest.is_none_or(|(least, ..)| distance_squared < least) {
            let [a, b, c] = triangle;
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
            nearest = Some((distance_squared, closest, normal));
        }
    }
    let Some((_, closest, normal)) = nearest else { return false };
    if (*point - closest).dot(&normal) > 0.0 {
        *point = closest - INSIDE * size * normal;
    }
    true
}

/// Adds the interior voxels to those on the surface. Voxels between which no surface voxel lies are all inside or all outside, so one of
/// each connected group is tested.
fn add_interior(on_surface: u64, is_inside: impl Fn(usize) -> bool) -> u64 {
    let (mut solid, mut visited) = (on_surface, on_surface);
    let mut stack = Vec::new();
    while visited != u64::MAX {
        let seed = (!visited).trailing_zeros() as usize;
        let mut group = 0_u64;
        stack.push(seed);
        visited |= 1 << seed;
        while let Some(voxel) = stack.pop() {
            group |= 1 << voxel;
            for axis in 0..3 {
                let previous = (index(voxel)[axis] > 0).then(|| voxel - SIDE.pow(axis as u32));
                for other in next(voxel, axis).into_iter().chain(previous) {
                    if visited >> other & 1 == 0 {
                        visited |= 1 << other;
                        stack.push(other);
                    }
                }
            }
        }
        if is_inside(seed) {
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

    impl BodyInterior for Half {
        fn triangles_near(&self, _: Vec3, _: f64) -> Vec<[Vec3; 3]> {
            vec![[Vec3::new(-9.0, -9.0, 0.3), Vec3::new(9.0, -9.0, 0.3), Vec3::new(0.0, 20.0, 0.3)]]
        }

        fn contains(&self, point: Vec3) -> bool {
            point[2] < 0.3
        }
    }

    #[test]
    fn points_are_inside_and_voxels_outside_are_not_solid() {
        let mut points = VoxelPoints::centres(Vec3::zeros(), 1.0);
        let solid = points.move_inside(Vec3::repeat(0.5), 1.0, &Half);
        assert_eq!(solid.count_ones(), 32, "two layers: one inside, one the surface passes through");
        for voxel in (0..COUNT).filter(|v| solid >> v & 1 == 1) {
            assert!(points.own[voxel][2] < 0.3, "{:?}", points.own[voxel]);
        }
        assert!(points.beyond[0].iter().all(|p| (p[0] - 1.125).abs() < 1e-12));
    }
}
