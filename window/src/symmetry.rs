//! Mirror symmetry of strokes, as the picture shows it. The engine mirrors the hands.

use pliant_engine::body::{Axes, mirrored};
use pliant_solver::Vec3;

/// The planes in which strokes are mirrored: through one point, across some axes of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetry {
    /// Axes (x, y, z) that the planes lie across.
    pub axes: Axes,
    /// A point on all planes, m
    pub centre: Vec3,
}

/// Share of the model's size by which its middle may be off the origin for its own plane of symmetry to be sought there.
const CENTRED: f64 = 0.1;

impl Symmetry {
    /// The planes of a model with these least and greatest coordinates (m): through the origin, where modelers put a plane of symmetry, or through the
    /// middle of a model that stands elsewhere.
    pub fn of_model(axes: Axes, [low, high]: [Vec3; 2]) -> Self {
        let (middle, size) = (0.5 * (low + high), (high - low).max());
        Self { axes, centre: middle.map(|m| if m.abs() <= CENTRED * size { 0.0 } else { m }) }
    }

    /// The axes of each mirror image of a stroke: every combination of those of the planes.
    pub fn images(&self) -> impl Iterator<Item = Axes> + use<> {
        let axes = self.axes;
        let combinations = (1..8).map(|bits| std::array::from_fn(|axis| bits >> axis & 1 == 1));
        combinations.filter(move |image: &Axes| (0..3).all(|axis| axes[axis] || !image[axis]))
    }

    /// The mirror image of a point (m).
    pub fn point(&self, point: Vec3, image: Axes) -> Vec3 {
        self.centre + mirrored(point - self.centre, image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_centred_model_is_mirrored_at_the_origin_and_another_at_its_middle() {
        let bounds = [Vec3::new(-0.046, 0.25, -0.05), Vec3::new(0.054, 0.35, 0.05)];
        assert_eq!(Symmetry::of_model([true; 3], bounds).centre, Vec3::new(0.0, 0.3, 0.0));
    }

    #[test]
    fn there_is_an_image_for_every_combination_of_axes_and_each_is_its_own_inverse() {
        for bits in 0..8_u32 {
            let axes = std::array::from_fn(|axis| bits >> axis & 1 == 1);
            let symmetry = Symmetry { axes, centre: Vec3::new(0.02, 0.0, -0.3) };
            let point = Vec3::new(0.03, -0.04, 0.05);
            let mut places = vec![point];
            for image in symmetry.images() {
                let place = symmetry.point(point, image);
                assert!((symmetry.point(place, image) - point).norm() < 1e-15);
                assert!(places.iter().all(|other| (other - place).norm() > 1e-3), "{axes:?}: {image:?}");
                places.push(place);
            }
            assert_eq!(places.len(), 1 << bits.count_ones(), "{axes:?}");
        }
    }
}
