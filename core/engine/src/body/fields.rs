//! Parameters of a material that differ from place to place: factors at places of the rest shape.

use super::fixing::Place;
use super::model::Model;
use super::skin::interpolate;
use pliant_mesh::geometry::{TriangleTree, closest_point};
use pliant_solver::Vec3;
use std::sync::Arc;

/// Factors of the parameters that a material lets differ, at every place of a body.
#[derive(Clone, Debug)]
pub struct Fields {
    /// For each such parameter what gives its factor; the layers multiply.
    planes: Vec<Vec<Layer>>,
    surface: FieldSurface,
}

/// The surface as it was handed in: a layer on it reaches through the depth, to what it is nearest to.
#[derive(Clone)]
pub struct FieldSurface {
    /// The placed model.
    pub model: Arc<Model>,
    /// A tree over its triangles.
    pub tree: Arc<TriangleTree>,
}

impl std::fmt::Debug for FieldSurface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} triangles", self.model.surface.triangles.len())
    }
}

/// What gives a factor.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// One factor within a box or ball.
    Place {
        /// Where.
        place: Place,
        /// The factor there; 1 elsewhere.
        factor: f64,
    },
    /// A factor of each triangle.
    Triangles(Vec<f64>),
    /// A factor of each vertex, geometric between.
    Vertices(Vec<f64>),
}

impl Layer {
    /// Least and greatest factor it may give.
    pub fn bounds(&self) -> [f64; 2] {
        let of = |all: &[f64]| all.iter().fold([1.0_f64, 1.0], |[low, high], f| [low.min(*f), high.max(*f)]);
        match self {
            Self::Place { factor, .. } => of(&[*factor]),
            Self::Triangles(all) | Self::Vertices(all) => of(all),
        }
    }
}

impl Fields {
    /// With the layers of each parameter that may differ, in the order of their planes.
    pub fn new(planes: Vec<Vec<Layer>>, surface: FieldSurface) -> Self {
        Self { planes, surface }
    }

    /// The factor of each parameter at a place of the rest shape (m).
    pub fn at(&self, place: Vec3) -> Vec<f64> {
        let is_on_surface = |layer: &Layer| !matches!(layer, Layer::Place { .. });
        let needs_surface = self.planes.iter().flatten().any(is_on_surface);
        let nearest = if needs_surface { self.nearest(place) } else { None };
        let factor = |layer: &Layer| match layer {
            Layer::Place { place: where_, factor } => {
                if where_.holds(u32::MAX, place) {
                    *factor
                } else {
                    1.0
                }
            }
            Layer::Triangles(all) => nearest.map_or(1.0, |(t, _)| all[t as usize]),
            Layer::Vertices(all) => nearest.map_or(1.0, |(t, bary)| {
                let corners = self.surface.model.surface.triangles[t as usize];
                libm::exp((0..3).map(|i| bary[i] * libm::log(all[corners[i] as usize])).sum())
            }),
        };
        self.planes.iter().map(|layers| layers.iter().map(factor).product()).collect()
    }

    /// How much stiffer or lighter one place may be than another: the product of the widest ranges of all parameters.
    pub fn spread(&self) -> f64 {
        self.planes.iter().flatten().map(|layer| layer.bounds()[1] / layer.bounds()[0]).product()
    }

    /// The triangle nearest to a place, the first of several, and the weights of its corners there.
    fn nearest(&self, place: Vec3) -> Option<(u32, Vec3)> {
        let FieldSurface { model, tree } = &self.surface;
        let size = model.surface.bounds().longest_edge();
        let mut reach = 0.02 * size;
        loop {
            let mut best: Option<(f64, u32, Vec3)> = None;
            tree.near(place, reach, |t| {
                let corners = model.surface.triangles[t as usize].map(|v| model.surface.points[v as usize]);
                let closest = closest_point(place, corners);
                let away = (closest.point - place).norm();
                if away <= reach && best.is_none_or(|(least, of, _)| (away, t) < (least, of)) {
                    best = Some((away, t, closest.bary));
                }
            });
            match best {
                Some((_, t, bary)) => return Some((t, bary)),
                None if reach >= 1e3 * size => return None,
                None => reach *= 2.0,
            }
        }
    }
}

/// The mean of three corners weighted alike.
pub(super) fn middle(corners: [Vec3; 3]) -> Vec3 {
    interpolate(corners, Vec3::repeat(1.0 / 3.0))
}
