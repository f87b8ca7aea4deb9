//! Which points of two surfaces a stitch may tie: those that face each other and are near each other.

use super::BodyCollisions;
use super::ties::TiePoint;
use crate::body::{Body, LatticeError};
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// Two points that a stitch may tie.
#[derive(Clone, Copy, Debug)]
pub struct StitchCandidate {
    /// The points, in the order of the bodies.
    pub points: [TiePoint; 2],
    /// Their present positions, m.
    pub positions: [Vec3; 2],
}

impl StitchCandidate {
    /// Displacement of the first point from the second, m.
    pub fn gap(&self) -> Vec3 {
        self.positions[0] - self.positions[1]
    }
}

/// A ball in which points are looked for.
#[derive(Clone, Copy, Debug)]
pub struct SearchBall {
    /// Centre of the ball, m.
    pub centre: Vec3,
    /// Radius of the ball, m.
    pub radius: f64,
}

/// Where points of two bodies are looked for.
#[derive(Clone, Copy, Debug)]
pub struct StitchSearch {
    /// A ball in which one of the two points is; `None` for everywhere.
    pub ball: Option<SearchBall>,
    /// Largest distance of two points, m.
    pub reach: f64,
    /// Least distance of points of the finer surface from each other, m: ties that are closer than nodes say the same twice, or contradict each other.
    pub spacing: f64,
}

/// Sine of the angle by which a point may lie behind the plane of the surface that it is stitched to.
const BEHIND: f64 = 0.2;
/// Depth by which it may lie behind in any case, in edges of the finer surface: surfaces that touch are a little within each other.
const WITHIN: f64 = 0.25;

/// A surface that is searched, at its present place.
struct Searched<'a> {
    body: &'a Body,
    /// Vertices of the surface, m.
    positions: Vec<Vec3>,
    triangles: Vec<SearchedTriangle>,
}

/// A triangle of a surface that is searched.
struct SearchedTriangle {
    /// Its vertices in the model.
    of_model: [u32; 3],
    /// Its vertices on the surface.
    of_surface: [u32; 3],
}

impl Searched<'_> {
    fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].of_surface.map(|v| self.positions[v as usize])
    }

    fn normal(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a))
    }

    fn is_solid(&self) -> bool {
        self.body.discretization.sheet().is_none()
    }
}

impl BodyCollisions {
    /// Points of the surfaces of two bodies that face each other and are near each other: vertices of the finer surface and the points of the other that are nearest to
    /// them, the nearest to the middle of the ball first.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn stitch_candidates(
        &mut self,
        [i, j]: [usize; 2],
        bodies: &mut [Body],
        search: StitchSearch,
    ) -> Result<Vec<StitchCandidate>, LatticeError> {
        for index in [i, j] {
            self.prepare(index, &mut bodies[index])?;
        }
        // Of surfaces alike the first counts as the finer one, whatever the rounding of their edges.
        let is_swapped = self.surfaces[i].edge > (1.0 + 1e-9) * self.surfaces[j].edge;
        let [fine, coarse] = if is_swapped { [j, i] } else { [i, j] };
        let [fine, coarse] = [fine, coarse].map(|index| self.searched(index, &bodies[index]));
        let within = WITHIN * self.surfaces[i].edge.min(self.surfaces[j].edge);
        let mut found = nearest_points(&fine, &coarse, search, within);
        if is_swapped {
            for candidate in &mut found {
                candidate.points.swap(0, 1);
                candidate.positions.swap(0, 1);
            }
        }
        Ok(found)
    }

    fn searched<'a>(&self, index: usize, body: &'a Body) -> Searched<'a> {
        let (surface, model) = (&self.surfaces[index], &body.model);
        let mut positions = Vec::new();
        surface.positions(&body.system.nodes.x, &mut positions);
        let visible = (0..model.surface.triangles.len() as u32)
            .filter(|t| !model.is_lid(*t) && !body.failed_triangles.contains(*t));
        let triangles = visible.filter_map(|t| {
            let corners = model.surface.triangles[t as usize];
            let [a, b, c] = corners.map(|v| surface.vertex_of(v));
            Some(SearchedTriangle { of_model: corners, of_surface: [a?, b?, c?] })
        });
        Searched { body, triangles: triangles.collect(), positions }
    }
}

/// Vertices of the finer surface with their nearest points on the other one.
fn nearest_points(
    fine: &Searched<'_>,
    coarse: &Searched<'_>,
    search: StitchSearch,
    within: f64,
) -> Vec<StitchCandidate> {
    let mut normals = vec![Vec3::zeros(); fine.positions.len()];
    let mut model_vertex = vec![u32::MAX; fine.positions.len()];
    for t in 0..fine.triangles.len() {
        let SearchedTriangle { of_model, of_surface } = fine.triangles[t];
        for (vertex, at) in of_model.into_iter().zip(of_surface) {
            normals[at as usize] += fine.normal(t);
            model_vertex[at as usize] = vertex;
        }
    }
    let away = |x: Vec3| search.ball.map_or(0.0, |ball| (x - ball.centre).norm());
    let is_inside = |x: Vec3, margin: f64| search.ball.is_none_or(|ball| away(x) <= ball.radius + margin);
    let mut vertices: Vec<usize> = (0..fine.positions.len())
        .filter(|v| model_vertex[*v] != u32::MAX && is_inside(fine.positions[*v], search.reach))
        .collect();
    vertices.sort_by(|a, b| away(fine.positions[*a]).total_cmp(&away(fine.positions[*b])).then(a.cmp(b)));
    let bounds = |x: &[Vec3; 3], reach: f64| {
        let [low, high] = x.iter().fold([x[0], x[0]], |[low, high], x| [low.inf(x), high.sup(x)]);
        [low.add_scalar(-reach), high.add_scalar(reach)]
    };
    let boxes: Vec<[Vec3; 2]> = (0..coarse.triangles.len()).map(|t| bounds(&coarse.corners(t), search.reach)).collect();
    let mut found: Vec<StitchCandidate> = Vec::new();
    for v in vertices {
        let p = fine.positions[v];
        if found.iter().any(|other| (other.positions[0] - p).norm() < search.spacing) {
            continue;
        }
        let mut best: Option<(f64, StitchCandidate)> = None;
        for (t, [low, high]) in boxes.iter().enumerate() {
            if (0..3).any(|c| p[c] < low[c] || p[c] > high[c]) {
                continue;
            }
            let closest = closest_point(p, coarse.corners(t));
            let distance = (p - closest.point).norm();
            let is_nearer = best.as_ref().is_none_or(|(least, _)| distance < *least);
            if distance > search.reach || !is_nearer || !faces(&normals[v], fine, coarse, t, p - closest.point, within)
            {
                continue;
            }
            let of_model = TiePoint { vertices: coarse.triangles[t].of_model, weights: closest.bary.into() };
            let points = [TiePoint::vertex(model_vertex[v]), of_model];
            best = Some((distance, StitchCandidate { points, positions: [p, closest.point] }));
        }
        let in_ball = |c: &StitchCandidate| c.positions.iter().any(|x| is_inside(*x, 0.0));
        found.extend(best.map(|(_, candidate)| candidate).filter(in_ball));
    }
    found
}

/// Whether a vertex with this normal, `apart` (m) from a triangle of the other surface, is in front of it, or at most `within` (m) behind it, and looks at it. A sheet looks both
/// ways.
fn faces(normal: &Vec3, fine: &Searched<'_>, coarse: &Searched<'_>, triangle: usize, apart: Vec3, within: f64) -> bool {
    let other = coarse.normal(triangle);
    let behind = (BEHIND * apart.norm()).max(within);
    let looks_at = |normal: &Vec3, way: Vec3| way.dot(normal) >= -behind * normal.norm();
    let both = !(fine.is_solid() && coarse.is_solid()) || normal.dot(&other) < 0.0;
    both && (!fine.is_solid() || looks_at(normal, -apart)) && (!coarse.is_solid() || looks_at(&other, apart))
}
