//! Mirror symmetry of a model, exact to the last bit.
//!
//! The order of sums in assembly and solver is not symmetric, so the two halves of a symmetric model under mirrored hands differ by
//! rounding. Vertices are therefore paired with their mirror images, and both get the mean of their displacements.

use super::{Model, Skin};
use pliant_solver::Vec3;
use std::collections::HashMap;

/// Axes (x, y, z) along which a point is mirrored: those that are `true`.
pub type Axes = [bool; 3];

/// The vector with its components along `axes` negated.
pub fn mirrored(mut vector: Vec3, axes: Axes) -> Vec3 {
    (0..3).filter(|i| axes[*i]).for_each(|i| vector[i] = -vector[i]);
    vector
}

/// Vertices of a body paired with their mirror images, for each axis it is symmetric in.
#[derive(Debug, Default)]
pub struct Symmetry {
    planes: Vec<MirrorPlane>,
}

/// Pairs of vertices about one plane.
#[derive(Debug)]
struct MirrorPlane {
    axes: Axes,
    /// Mirror image of each vertex (n).
    partner: Vec<u32>,
}

/// Largest distance between a vertex and the mirror image of its partner, as a share of the diameter of the model about the centre.
const TOLERANCE: f64 = 1e-6;

impl Symmetry {
    /// Pairs the vertices of a model about the planes through `centre` (m) normal to each of `axes`. Returns the axes (0 to 2) along which
    /// the model is not symmetric as well; they are left out.
    pub fn new(model: &Model, centre: Vec3, axes: Axes) -> (Self, Vec<usize>) {
        let (mut found, mut missing) = (Self::default(), Vec::new());
        for axis in (0..3).filter(|i| axes[*i]) {
            let axes = std::array::from_fn(|i| i == axis);
            match partners(&model.surface.points, centre, axes) {
                Some(partner) => found.planes.push(MirrorPlane { axes, partner }),
                None => missing.push(axis),
            }
        }
        (found, missing)
    }

    /// Gives every vertex and its mirror image displacements that are mirror images of each other, to the last bit.
    pub fn apply(&self, model: &Model, skin: &mut Skin) {
        let placed = &model.surface.points;
        for MirrorPlane { axes, partner } in &self.planes {
            for (a, &b) in partner.iter().enumerate().filter(|(a, b)| *a <= **b as usize) {
                let b = b as usize;
                if [a, b].iter().any(|v| skin.x.get(*v).is_none()) || (skin.x[a] == placed[a] && skin.x[b] == placed[b])
                {
                    continue;
                }
                let mean = 0.5 * ((skin.x[a] - placed[a]) + mirrored(skin.x[b] - placed[b], *axes));
                skin.x[a] = placed[a] + mean;
                skin.x[b] = placed[b] + mirrored(mean, *axes);
                [a, b].iter().for_each(|v| skin.pages.mark(*v as u32));
            }
        }
    }
}

/// The vertex at the mirror image of each vertex; `None` if a vertex has none.
fn partners(points: &[Vec3], centre: Vec3, axes: Axes) -> Option<Vec<u32>> {
    let reach = points.iter().map(|p| (p - centre).amax()).fold(0.0, f64::max);
    let size = 2.0 * TOLERANCE * reach;
    if size == 0.0 {
        return None;
    }
    let key = |p: Vec3| <[i64; 3]>::from((p / size).map(|c| c.floor() as i64));
    let mut at: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for (v, p) in points.iter().enumerate() {
        at.entry(key(p - centre)).or_default().push(v as u32);
    }
    let nearest = |wanted: Vec3| {
        let [x, y, z] = key(wanted);
        let near = (0..27).flat_map(|i| at.get(&[x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1])).flatten();
        let away = |v: &u32| (points[*v as usize] - centre - wanted).norm();
        near.copied().filter(|v| away(v) <= size).min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)))
    };
    let partner: Vec<u32> = points.iter().map(|p| nearest(mirrored(p - centre, axes))).collect::<Option<_>>()?;
    // Vertices with equal positions, as on a seam, may have the same partner: such a model is not paired.
    let mutual = partner.iter().enumerate().all(|(a, &b)| partner[b as usize] as usize == a);
    mutual.then_some(partner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vertex_needs_a_mirror_image() {
        let points = [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 3.0, 0.0]].map(Vec3::from);
        let axes = [true, false, false];
        assert_eq!(partners(&points, Vec3::zeros(), axes), Some(vec![1, 0, 2]));
        assert_eq!(partners(&[points[0], points[2]], Vec3::zeros(), axes), None);
    }
}
