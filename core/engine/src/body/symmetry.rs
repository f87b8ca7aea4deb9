//! Mirror symmetry of a model: exact to the last bit in planes normal to axes of the scene, to rounding in others.
//!
//! The order of sums in assembly and solver is not symmetric, so the two halves of a symmetric model under mirrored hands differ by the tolerance of
//! the solver. Vertices are therefore paired with their mirror images, and both get the mean of their displacements. Vertices that one side alone was
//! moved at, before symmetry was switched on or by an edit without it, are left as they are.

use super::{Model, Reflection, Skin};
use pliant_solver::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// Vertices of a body paired with their mirror images, for each plane it is symmetric in.
#[derive(Debug, Default)]
pub struct Symmetry {
    /// Planes that it was asked for.
    key: Vec<SymmetryPlane>,
    planes: Vec<MirrorPlane>,
    /// Vertices that have another displacement than their mirror images (n). All images of one are in it, too.
    one_sided: Arc<Vec<bool>>,
    /// Whether an edit without symmetry is or was the last one: what it does is done to one side.
    is_paused: bool,
    /// Largest difference between the displacements of a vertex and of its mirror image that counts as an error of the solver, m.
    largest_error: f64,
}

/// A plane about which vertices are paired.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetryPlane {
    /// The reflection, in one plane.
    pub reflection: Reflection,
    /// A point on the plane, m.
    pub centre: Vec3,
}

/// The part of a [`Symmetry`] that changes, for undo.
#[derive(Clone, Debug)]
pub(super) struct SymmetryState {
    key: Vec<SymmetryPlane>,
    one_sided: Arc<Vec<bool>>,
    is_paused: bool,
}

/// Pairs of vertices about one plane.
#[derive(Debug)]
struct MirrorPlane {
    reflection: Reflection,
    /// Mirror image of each vertex (n).
    partner: Vec<u32>,
}

/// Largest distance between a vertex and the mirror image of its partner, as a share of the diameter of the model about the centre.
const TOLERANCE: f64 = 1e-6;
/// Largest difference of mirrored displacements that was not made on one side alone, as a share of the diameter of the model about the centre: what is
/// less is not seen.
const LARGEST_ERROR: f64 = 1e-4;

impl Symmetry {
    /// Pairs the vertices of a model about each of `wanted`. Returns the planes that the model is not symmetric in as well; they are left out. What is displaced on
    /// one side now stays so.
    pub fn new(model: &Model, skin: &Skin, wanted: &[SymmetryPlane]) -> (Self, Vec<SymmetryPlane>) {
        let points = &model.surface.points;
        let (mut planes, mut missing) = (Vec::new(), Vec::new());
        for &plane in wanted {
            let reflection = plane.reflection;
            match partners(points, model.document.welds(), plane.centre, reflection) {
                Some(partner) => planes.push(MirrorPlane { reflection, partner }),
                None => missing.push(plane),
            }
        }
        let mut found = Self {
            key: wanted.to_vec(),
            planes,
            one_sided: Arc::new(vec![false; points.len()]),
            is_paused: false,
            largest_error: LARGEST_ERROR
                * wanted.iter().map(|plane| diameter(points, plane.centre)).fold(0.0, f64::max),
        };
        found.find_one_sided(model, skin);
        (found, missing)
    }

    /// Adds the vertices that are displaced on one side alone to those that are left as they are.
    pub fn find_one_sided(&mut self, model: &Model, skin: &Skin) {
        let placed = &model.surface.points;
        let mut found = std::mem::take(&mut self.one_sided);
        let all = Arc::make_mut(&mut found);
        for MirrorPlane { reflection, partner } in &self.planes {
            for (a, b) in pairs(partner).filter(|(a, b)| is_there(skin, placed, *a, *b)) {
                let (own, other) = (skin.x[a] - placed[a], reflection.vector(skin.x[b] - placed[b]));
                if (own - other).norm() > self.largest_error {
                    (all[a], all[b]) = (true, true);
                }
            }
        }
        // One plane after the other, which gives all images where the planes are normal to each other, and as many rounds for those that are not.
        for MirrorPlane { partner, .. } in self.planes.iter().flat_map(|_| &self.planes) {
            for (a, b) in pairs(partner) {
                let either = all[a] || all[b];
                (all[a], all[b]) = (either, either);
            }
        }
        self.one_sided = found;
    }

    /// An edit begins that is mirrored or not.
    pub(crate) fn begin_edit(&mut self, is_mirrored: bool, model: &Model, skin: &Skin) {
        if std::mem::replace(&mut self.is_paused, !is_mirrored) && is_mirrored {
            self.find_one_sided(model, skin);
        }
    }

    /// What is to be kept for undo.
    pub(super) fn save(&self) -> SymmetryState {
        SymmetryState { key: self.key.clone(), one_sided: Arc::clone(&self.one_sided), is_paused: self.is_paused }
    }

    /// Goes back to a saved state; to what the present shape is like where that was saved with another symmetry or without.
    pub(super) fn restore(&mut self, state: Option<&SymmetryState>, model: &Model, skin: &Skin) {
        match state.filter(|state| state.key == self.key) {
            Some(state) => (self.one_sided, self.is_paused) = (Arc::clone(&state.one_sided), state.is_paused),
            None => {
                Arc::make_mut(&mut self.one_sided).fill(false);
                self.find_one_sided(model, skin);
            }
        }
    }

    /// Gives every vertex and its mirror image displacements that are mirror images of each other: to the last bit along axes of the scene, to
    /// rounding in other planes. Positions must be as the nodes have them, also of vertices that no active node moves: a mean of means depends on how often it is
    /// taken.
    pub fn apply(&self, model: &Model, skin: &mut Skin) {
        if self.is_paused {
            return;
        }
        let placed = &model.surface.points;
        for MirrorPlane { reflection, partner } in &self.planes {
            for (a, b) in pairs(partner).filter(|(a, _)| !self.one_sided[*a]) {
                if !is_there(skin, placed, a, b) {
                    continue;
                }
                let mean = 0.5 * ((skin.x[a] - placed[a]) + reflection.vector(skin.x[b] - placed[b]));
                for (v, to) in [(a, placed[a] + mean), (b, placed[b] + reflection.vector(mean))] {
                    if skin.x[v] != to {
                        skin.x[v] = to;
                        skin.pages.mark(v as u32);
                    }
                }
            }
        }
    }
}

/// Each pair of vertices once; a vertex on the plane is a pair with itself, and one that another replaces is in none.
fn pairs(partner: &[u32]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let paired = partner.iter().enumerate().filter(|(_, b)| **b != NO_PARTNER);
    paired.map(|(a, &b)| (a, b as usize)).filter(|(a, b)| a <= b)
}

/// Whether the vertices of a pair are on the surface and one of them is displaced.
fn is_there(skin: &Skin, placed: &[Vec3], a: usize, b: usize) -> bool {
    let is_present = [a, b].iter().all(|v| skin.x.get(*v).is_some());
    is_present && !(skin.x[a] == placed[a] && skin.x[b] == placed[b])
}

/// Edge of the smallest cube around `centre` that holds all points, m.
fn diameter(points: &[Vec3], centre: Vec3) -> f64 {
    2.0 * points.iter().map(|p| (p - centre).amax()).fold(0.0, f64::max)
}

/// Partner of a vertex that has none.
const NO_PARTNER: u32 = u32::MAX;

/// The vertex at the mirror image of each vertex, and [`NO_PARTNER`] of those that others replace; `None` if a vertex has none.
fn partners(points: &[Vec3], welds: &[[u32; 2]], centre: Vec3, reflection: Reflection) -> Option<Vec<u32>> {
    let size = TOLERANCE * diameter(points, centre);
    if size == 0.0 {
        return None;
    }
    let key = |p: Vec3| <[i64; 3]>::from((p / size).map(|c| c.floor() as i64));
    let mut is_replaced = vec![false; points.len()];
    welds.iter().for_each(|[vertex, _]| is_replaced[*vertex as usize] = true);
    let mut at: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for (v, p) in points.iter().enumerate().filter(|(v, _)| !is_replaced[*v]) {
        at.entry(key(p - centre)).or_default().push(v as u32);
    }
    let nearest = |wanted: Vec3| {
        let [x, y, z] = key(wanted);
        let near = (0..27).flat_map(|i| at.get(&[x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1])).flatten();
        let away = |v: &u32| (points[*v as usize] - centre - wanted).norm();
        near.copied().filter(|v| away(v) <= size).min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)))
    };
    let partner_of = |(p, is_replaced): (&Vec3, &bool)| match is_replaced {
        true => Some(NO_PARTNER),
        false => nearest(reflection.vector(p - centre)),
    };
    let partner: Vec<u32> = points.iter().zip(&is_replaced).map(partner_of).collect::<Option<_>>()?;
    // Vertices with equal positions, as on a seam, may have the same partner: such a model is not paired.
    let mutual = partner.iter().enumerate().all(|(a, &b)| b == NO_PARTNER || partner[b as usize] as usize == a);
    mutual.then_some(partner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last two vertices lie at one place, and the first of them replaces the other.
    #[test]
    fn a_vertex_that_another_replaces_is_in_no_pair() {
        let points = [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 3.0, 0.0], [0.0, 3.0, 0.0]].map(Vec3::from);
        let reflection = Reflection::Axes([true, false, false]);
        let partner = partners(&points, &[[3, 2]], Vec3::zeros(), reflection).expect("mirror images");
        assert_eq!(partner, [1, 0, 2, NO_PARTNER]);
        assert_eq!(pairs(&partner).collect::<Vec<_>>(), [(0, 1), (2, 2)]);
    }

    #[test]
    fn every_vertex_needs_a_mirror_image() {
        let points = [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 3.0, 0.0]].map(Vec3::from);
        let reflection = Reflection::Axes([true, false, false]);
        assert_eq!(partners(&points, &[], Vec3::zeros(), reflection), Some(vec![1, 0, 2]));
        assert_eq!(partners(&[points[0], points[2]], &[], Vec3::zeros(), reflection), None);
    }
}
