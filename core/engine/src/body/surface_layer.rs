//! The layer of a body under the side of its surface that faces a tool: where a stroke over the surface paints.
//!
//! The side is made of the triangles in a ball that are connected to its centre across edges and whose normals are less than 90 degrees from the
//! normal there. So the back of a thin part, and what lies behind a gap, are not of it, however near they are. A triangle is turned like its
//! neighbour before it is compared, for sheets need not be oriented.

use super::model::Model;
use super::painted_factors::PaintBall;
use super::skin::{Skin, nearest_triangle};
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;
use std::collections::{BTreeMap, HashMap};

/// How deep a stroke of paint goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PaintDepth {
    /// Everything connected in the ball of the stroke.
    #[default]
    Through,
    /// A layer of this thickness, m, 0 or more, under the side of the surface that faces the tool; of a solid one cell at least.
    Layer(f64),
}

impl PaintDepth {
    /// Thickness of the layer, m; `None` through the depth.
    pub(super) fn layer(self) -> Option<f64> {
        match self {
            Self::Through => None,
            Self::Layer(thickness) => Some(thickness),
        }
    }
}

/// A layer under the side of a surface that faces a tool.
pub(super) struct SurfaceLayer<'a> {
    model: &'a Model,
    skin: &'a Skin,
    /// Triangles of the side, each with the factor, 1 or -1, that turns its normal out.
    side: BTreeMap<u32, f64>,
    /// Depth to which the layer extends below the surface, m.
    thickness: f64,
}

impl<'a> SurfaceLayer<'a> {
    /// The layer of this `thickness` (m) around the point of the surface nearest to the centre of a ball, within the ball. `corners_of` names the
    /// corners of a triangle by numbers that neighbours share.
    pub fn new(
        model: &'a Model,
        skin: &'a Skin,
        ball: PaintBall<'_>,
        thickness: f64,
        corners_of: impl Fn(u32) -> [u32; 3],
    ) -> Self {
        let PaintBall { centre, radius, .. } = ball;
        let mut layer = Self { model, skin, side: BTreeMap::new(), thickness };
        let Some(first) = nearest_triangle(&skin.tree, model, &skin.settled, centre, radius, 64.0 * radius) else {
            return layer;
        };
        let (first, mut near) = (first.triangle, Vec::new());
        skin.tree.near(centre, radius, |triangle| near.push(triangle));
        near.sort_unstable();
        let mut sides: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        for &triangle in near.iter().filter(|t| !model.is_lid(**t)) {
            for [a, b] in edges(corners_of(triangle)) {
                sides.entry([a.min(b), a.max(b)]).or_default().push(triangle);
            }
        }
        let facing = layer.normal(first);
        layer.side.insert(first, 1.0);
        let mut open = vec![first];
        while let Some(triangle) = open.pop() {
            let turn = layer.side[&triangle];
            for [a, b] in edges(corners_of(triangle)) {
                for &other in sides.get(&[a.min(b), a.max(b)]).into_iter().flatten() {
                    // Neighbours that are oriented alike go along their common edge in opposite directions.
                    let is_alike = !edges(corners_of(other)).contains(&[a, b]);
                    let turn = if is_alike { turn } else { -turn };
                    if !layer.side.contains_key(&other) && turn * layer.normal(other).dot(&facing) > 0.0 {
                        layer.side.insert(other, turn);
                        open.push(other);
                    }
                }
            }
        }
        layer
    }

    /// Whether a triangle is of the side that faces the tool.
    pub fn has(&self, triangle: u32) -> bool {
        self.side.contains_key(&triangle)
    }

    /// The point of the side (m) over the middle (m) of a cell with this edge (m), if the cell is of the layer: its middle is at most as deep
    /// as the layer is thick, or the surface passes through it.
    pub fn point_over(&self, middle: Vec3, edge: f64) -> Option<Vec3> {
        let reach = self.thickness.max(0.5 * edge * f64::sqrt(3.0));
        let mut best: Option<(f64, u32, Vec3)> = None;
        self.skin.tree.near(middle, reach, |triangle| {
            if !self.has(triangle) {
                return;
            }
            let point = closest_point(middle, self.corners(triangle)).point;
            let distance = (point - middle).norm();
            if best.is_none_or(|(least, of, _)| (distance, triangle) < (least, of)) {
                best = Some((distance, triangle, point));
            }
        });
        let (distance, triangle, point) = best?;
        let normal = self.side[&triangle] * self.normal(triangle);
        // Half of a cell's extent along the normal of a plane.
        let half = 0.5 * edge * normal.lp_norm(1) / normal.norm();
        let is_below = (point - middle).dot(&normal) >= 0.0;
        let most = if is_below { self.thickness.max(half) } else { half };
        (distance <= most).then_some(point)
    }

    /// Corners of a triangle in the present rest shape, m.
    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.model.surface.triangles[triangle as usize].map(|v| self.skin.settled[v as usize])
    }

    /// Normal of a triangle in the present rest shape; its length is twice the area, m^2.
    fn normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a))
    }
}

/// The directed edges of a triangle.
fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
