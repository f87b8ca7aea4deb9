//! Fields of material parameters: factors of a parameter as functions of the rest position.

use super::fixing::Place;
use super::model::Model;
use super::skin::nearest_triangle;
use pliant_mesh::GreyImage;
use pliant_mesh::geometry::TriangleTree;
use pliant_solver::Vec3;
use std::sync::Arc;

/// Factors of those parameters of a material that may vary over a body.
#[derive(Clone, Debug)]
pub struct Fields {
    /// Layers of each parameter that may vary; their factors multiply.
    planes: Vec<Vec<Layer>>,
    surface: FieldSurface,
}

/// The surface on which layers of triangles and vertices are given. Inside of the body the nearest point of the surface counts.
#[derive(Clone)]
pub struct FieldSurface {
    /// The placed model, without cuts.
    pub model: Arc<Model>,
    /// A tree over its triangles.
    pub tree: Arc<TriangleTree>,
}

impl FieldSurface {
    /// Whether a point of the rest shape (m) lies in one of some tetrahedra of the model; `is_inside` tells it of each.
    pub(super) fn is_in(&self, is_inside: &[bool], point: Vec3) -> bool {
        let cell = self.model.tetrahedra.as_ref().and_then(|cells| cells.locate(point));
        cell.is_some_and(|(cell, _)| is_inside[cell as usize])
    }
}

impl std::fmt::Debug for FieldSurface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} triangles", self.model.surface.triangles.len())
    }
}

/// A factor of one parameter as a function of the rest position.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// A constant factor within a box or ball.
    Place {
        /// The box or ball.
        place: Place,
        /// The factor within it; 1 elsewhere.
        factor: f64,
    },
    /// A factor for each triangle of the surface.
    Triangles(Vec<f64>),
    /// A factor for each tetrahedron of the model.
    Cells(Vec<f64>),
    /// A factor for each node of the tetrahedra of the model, linear within them.
    Nodes(Vec<f64>),
    /// A constant factor within some tetrahedra of the model.
    Tetrahedra {
        /// Whether each tetrahedron is one of them.
        is_inside: Vec<bool>,
        /// The factor within them; 1 elsewhere.
        factor: f64,
    },
    /// A factor for each vertex of the surface, interpolated geometrically within triangles.
    Vertices(Vec<f64>),
    /// A factor by the grey value at the texture coordinates of each triangle.
    Texture {
        /// Grey values over the unit square of the texture coordinates.
        image: GreyImage,
        /// Texture coordinates of the corners of each triangle (m x 3).
        corners: Vec<[[f64; 2]; 3]>,
        /// Factors of black and white, geometric between.
        range: [f64; 2],
    },
}

impl Layer {
    /// Least and greatest factor of the layer, 1 included.
    pub fn bounds(&self) -> [f64; 2] {
        let of = |all: &[f64]| all.iter().fold([1.0_f64, 1.0], |[low, high], f| [low.min(*f), high.max(*f)]);
        match self {
            Self::Place { factor, .. } | Self::Tetrahedra { factor, .. } => of(&[*factor]),
            Self::Triangles(all) | Self::Vertices(all) | Self::Cells(all) | Self::Nodes(all) => of(all),
            Self::Texture { image, range, .. } => of(&image.range().map(|grey| factor_at(*range, grey))),
        }
    }
}

impl Fields {
    /// Fields of parameters; `planes` has the layers of each, in the order in which the material declares parameters that may vary.
    pub fn new(planes: Vec<Vec<Layer>>, surface: FieldSurface) -> Self {
        Self { planes, surface }
    }

    /// The factor of each parameter at a point of the rest shape (m), in the order of the planes.
    pub fn at(&self, point: Vec3) -> Vec<f64> {
        let is_on_surface =
            |layer: &Layer| matches!(layer, Layer::Triangles(_) | Layer::Vertices(_) | Layer::Texture { .. });
        let is_in_cells = |layer: &Layer| matches!(layer, Layer::Cells(_) | Layer::Nodes(_));
        let FieldSurface { model, tree } = &self.surface;
        let nearest = self.planes.iter().flatten().any(is_on_surface).then(|| {
            let size = model.surface.bounds().longest_edge();
            nearest_triangle(tree, model, &model.surface.points, point, 0.02 * size, 1e3 * size)
        });
        let nearest = nearest.flatten();
        let cells = model.tetrahedra.as_ref().filter(|_| self.planes.iter().flatten().any(is_in_cells));
        let located = cells.and_then(|cells| cells.locate(point).map(|(cell, bary)| (cells, cell as usize, bary)));
        let factor = |layer: &Layer| match layer {
            Layer::Place { place, factor } if place.contains(u32::MAX, point) => *factor,
            Layer::Place { .. } => 1.0,
            Layer::Tetrahedra { is_inside, factor } if self.surface.is_in(is_inside, point) => *factor,
            Layer::Tetrahedra { .. } => 1.0,
            Layer::Cells(all) => located.map_or(1.0, |(_, cell, _)| all[cell]),
            Layer::Nodes(all) => located.map_or(1.0, |(cells, cell, bary)| {
                let corners = cells.mesh().tetrahedra[cell].map(|node| all[node as usize]);
                let [least, most] =
                    corners.iter().fold([f64::INFINITY, 0.0], |[low, high], f| [f.min(low), f.max(high)]);
                // A point may be a little outside of all tetrahedra.
                (0..4).map(|i| bary[i] * corners[i]).sum::<f64>().clamp(least, most)
            }),
            Layer::Triangles(all) => nearest.map_or(1.0, |nearest| all[nearest.triangle as usize]),
            Layer::Vertices(all) => nearest.map_or(1.0, |nearest| {
                let corners = model.surface.triangles[nearest.triangle as usize];
                libm::exp((0..3).map(|i| nearest.bary[i] * libm::log(all[corners[i] as usize])).sum())
            }),
            Layer::Texture { image, corners, range } => nearest.map_or(1.0, |nearest| {
                let corners = corners[nearest.triangle as usize];
                let at = [0, 1].map(|axis| (0..3).map(|i| nearest.bary[i] * corners[i][axis]).sum());
                factor_at(*range, image.sample(at))
            }),
        };
        self.planes.iter().map(|layers| layers.iter().map(factor).product()).collect()
    }

    /// Upper bound of the ratio of stiffness or density between two points: the product over all layers of greatest over least factor.
    pub fn spread(&self) -> f64 {
        self.planes.iter().flatten().map(|layer| layer.bounds()[1] / layer.bounds()[0]).product()
    }
}

/// The factor at a grey value, 0 to 1: interpolated geometrically between the factors at 0 and 1.
pub fn factor_at([low, high]: [f64; 2], value: f64) -> f64 {
    low * libm::exp(value * libm::log(high / low))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::testing::{Random, document, grey_png};
    use pliant_mesh::{Placement, Surface};

    /// A plate of 1 x 1 x 0.2 with its middle in the origin, whose texture coordinates are `base + x du + y dv` on all faces.
    fn plate(base: [f64; 2], du: [f64; 2], dv: [f64; 2]) -> Arc<Model> {
        let mut text = String::new();
        for i in 0..8 {
            let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(|side| f64::from(side) - 0.5);
            let [u, v] = [0, 1].map(|i| base[i] + x * du[i] + y * dv[i]);
            text += &format!("v {x} {y} {}\nvt {u} {v}\n", 0.2 * z);
        }
        for face in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [2, 4, 8, 6], [4, 3, 7, 8], [3, 1, 5, 7]] {
            text += &format!("f {0}/{0} {1}/{1} {2}/{2} {3}/{3}\n", face[0], face[1], face[2], face[3]);
        }
        Arc::new(Model::new(document(&text), Placement::default()))
    }

    #[test]
    fn a_texture_gives_its_value_above_and_below_and_through_the_depth() {
        let mut random = Random(3);
        for _ in 0..20 {
            let mut number = |scale: f64| scale * (2.0 * random.unit() - 1.0);
            let (base, du, dv) = ([number(2.0), number(2.0)], [number(1.0), number(1.0)], [number(1.0), number(1.0)]);
            let range = [0.2 + number(0.1).abs(), 5.0 + number(3.0)];
            let values: Vec<u8> = (0..63).map(|_| (128.0 + number(127.0)) as u8).collect();
            let image = pliant_mesh::GreyImage::parse(&grey_png(9, 7, &values)).expect("an image");
            let model = plate(base, du, dv);
            let Surface { triangles, face_of, .. } = &model.surface;
            let corners = |(corners, face): (&[u32; 3], &u32)| {
                corners.map(|vertex| model.document.texcoord_at(*face, vertex).expect("coordinates"))
            };
            let corners = triangles.iter().zip(face_of).map(corners).collect();
            let layer = Layer::Texture { image: image.clone(), corners, range };
            let [least, most] = layer.bounds();
            let surface = FieldSurface { model: Arc::clone(&model), tree: Arc::new(model.tree()) };
            let fields = Fields::new(vec![vec![layer]], surface);
            for _ in 0..50 {
                // Nearer to the large faces than to the others.
                let place = Vec3::new(number(0.4), number(0.4), number(0.09));
                let at = [0, 1].map(|i| base[i] + place.x * du[i] + place.y * dv[i]);
                let (found, exact) = (fields.at(place)[0], range[0] * (range[1] / range[0]).powf(image.sample(at)));
                assert!((found / exact - 1.0).abs() < 1e-9, "{place:?}: {found}, exact {exact}");
                assert!(least <= found && found <= most, "{found} of {least} to {most}");
            }
        }
    }
}
