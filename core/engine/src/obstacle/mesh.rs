//! Signed distance from a triangle mesh.
//!
//! The sign of a closed mesh is that of the angle-weighted pseudonormal of the closest vertex, edge or face, which is exact (Baerentzen and Aanaes
//! 2005). An open mesh has no inside: it is met from both sides at its thickness.

use super::surface::Nearest;
use pliant_mesh::geometry::{TriangleTree, closest_point};
use pliant_mesh::{EdgeTable, Surface};
use pliant_solver::Vec3;
use std::collections::HashMap;
use std::fmt;
use thiserror::Error;

/// A triangle mesh with its signed distance.
#[derive(Clone)]
pub struct MeshSurface {
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    tree: TriangleTree,
    /// Unit normals (t x 3).
    face_normal: Vec<Vec3>,
    /// Pseudonormals of the edges 01, 12, 20 (t x 3).
    edge_normal: Vec<[Vec3; 3]>,
    /// Pseudonormals of the vertices (n x 3).
    vertex_normal: Vec<Vec3>,
    /// Distance by which the surface is moved outwards, m.
    thickness: f64,
    is_closed: bool,
    bounds: [Vec3; 2],
}

/// Why a mesh cannot be an obstacle.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MeshSurfaceError {
    /// It has no triangle with an area.
    #[error("its mesh has no triangle with an area")]
    Empty,
    /// It is not closed and has no thickness.
    #[error(
        "its mesh is not closed ({borders} border edges, {others} edges with more than two faces or faces that are turned over); allowed is a closed \
         mesh, or a `thickness` at which it is met from both sides"
    )]
    Open {
        /// Number of edges with one face.
        borders: usize,
        /// Number of other edges whose faces do not bound an inside.
        others: usize,
    },
}

/// Distance from the surface below which the direction to the closest point is too inaccurate for a normal, relative to the size of the mesh.
const NEAR: f64 = 1e-9;

impl MeshSurface {
    /// The surface of a mesh placed in axes of the obstacle, moved outwards by `thickness` (m). The faces of a closed mesh may all be turned inside.
    ///
    /// # Errors
    /// A mesh without an area, or one that is open and has no thickness.
    pub fn new(surface: &Surface, thickness: f64) -> Result<Self, MeshSurfaceError> {
        let points = surface.points.clone();
        let cross = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            (b - a).cross(&(c - a))
        };
        let mut triangles: Vec<[u32; 3]> =
            surface.triangles.iter().copied().filter(|t| cross(t).norm() > 0.0).collect();
        if triangles.is_empty() {
            return Err(MeshSurfaceError::Empty);
        }
        let (borders, others) = defects(&surface.triangles);
        let is_closed = borders == 0 && others == 0;
        if !is_closed && thickness <= 0.0 {
            return Err(MeshSurfaceError::Open { borders, others });
        }
        if is_closed && surface.volume() < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let corners: Vec<Vec3> = triangles.iter().flatten().map(|&v| points[v as usize]).collect();
        let low = corners.iter().fold(Vec3::repeat(f64::INFINITY), |low, p| low.inf(p));
        let high = corners.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
        let margin = Vec3::repeat(thickness);
        let mut this = Self {
            tree: TriangleTree::new(&points, &triangles),
            face_normal: triangles.iter().map(|t| cross(t).normalize()).collect(),
            edge_normal: Vec::new(),
            vertex_normal: Vec::new(),
            points,
            triangles,
            thickness,
            is_closed,
            bounds: [low - margin, high + margin],
        };
        this.find_pseudonormals();
        Ok(this)
    }

    fn find_pseudonormals(&mut self) {
        let mut of_vertex = vec![Vec3::zeros(); self.points.len()];
        let mut of_edge: HashMap<[u32; 2], Vec3> = HashMap::new();
        for (t, normal) in self.triangles.iter().zip(&self.face_normal) {
            for i in 0..3 {
                let [a, b, c] = [t[i], t[(i + 1) % 3], t[(i + 2) % 3]];
                let [u, v] = [b, c].map(|other| self.points[other as usize] - self.points[a as usize]);
                of_vertex[a as usize] += libm::atan2(u.cross(&v).norm(), u.dot(&v)) * normal;
                *of_edge.entry([a.min(b), a.max(b)]).or_default() += normal;
            }
        }
        let side = |t: &[u32; 3], i: usize| of_edge[&[t[i].min(t[(i + 1) % 3]), t[i].max(t[(i + 1) % 3])]];
        self.edge_normal = self.triangles.iter().map(|t| [0, 1, 2].map(|i| side(t, i))).collect();
        self.vertex_normal = of_vertex;
    }

    /// Distance of a point (m) from the surface.
    pub fn nearest(&self, p: Vec3) -> Nearest {
        let mut best = (f64::INFINITY, u32::MAX);
        self.tree.near_within(p, f64::MAX, |t| {
            let found = closest_point(p, self.corners(t));
            let distance = (found.point - p).norm();
            if (distance, t) < best {
                best = (distance, t);
            }
            best.0
        });
        let (distance, t) = best;
        let found = closest_point(p, self.corners(t));
        let pseudonormal = self.pseudonormal(t, found.bary);
        let offset = p - found.point;
        let [low, high] = self.bounds;
        let is_near = distance <= NEAR * (high - low).norm();
        let is_inside = self.is_closed && offset.dot(&pseudonormal) < 0.0;
        let sign = if is_inside { -1.0 } else { 1.0 };
        let towards = if is_near { pseudonormal.try_normalize(0.0) } else { Some(sign / distance * offset) };
        Nearest { distance: sign * distance - self.thickness, normal: towards.unwrap_or(self.face_normal[t as usize]) }
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.points[v as usize])
    }

    /// Pseudonormal, not normalised, of the vertex, edge or face that a point of a triangle lies on.
    fn pseudonormal(&self, triangle: u32, bary: Vec3) -> Vec3 {
        let t = triangle as usize;
        match [0, 1, 2].map(|i| bary[i] > 0.0) {
            [true, false, false] => self.vertex_normal[self.triangles[t][0] as usize],
            [false, true, false] => self.vertex_normal[self.triangles[t][1] as usize],
            [false, false, true] => self.vertex_normal[self.triangles[t][2] as usize],
            [true, true, false] => self.edge_normal[t][0],
            [false, true, true] => self.edge_normal[t][1],
            [true, false, true] => self.edge_normal[t][2],
            _ => self.face_normal[t],
        }
    }

    /// Axis-aligned bounding box with the thickness: smallest and largest coordinates, m.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Whether it bounds an inside.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }
}

impl fmt::Debug for MeshSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MeshSurface of {} triangles, thickness {} m", self.triangles.len(), self.thickness)
    }
}

/// Numbers of edges with one triangle, and of other edges that are not crossed by one triangle in each direction.
fn defects(triangles: &[[u32; 3]]) -> (usize, usize) {
    let edges = EdgeTable::new(triangles);
    let (mut borders, mut others) = (0, 0);
    for edge in 0..edges.len() {
        let sides = edges.sides(edge);
        match sides {
            [_] => borders += 1,
            [a, b] if a.upward != b.upward => {}
            _ => others += 1,
        }
    }
    (borders, others)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::generate;
    use pliant_mesh::testing::{Random, scan};
    use pliant_mesh::{ObjDocument, geometry::cast};

    fn scanned(genus: u32, seed: u64) -> Surface {
        Surface::from_document(
            &ObjDocument::parse(scan(genus, 500, 0, seed).text.into_bytes(), "model.obj".as_ref()).unwrap(),
        )
    }

    /// Distance and sign against all triangles and the parity of a ray.
    #[test]
    fn distance_is_that_of_the_closest_triangle_and_its_sign_that_of_a_ray() {
        let mut random = Random(3);
        for seed in 0..6 {
            let surface = scanned(seed as u32 % 2, seed);
            let mesh = MeshSurface::new(&surface, 0.0).unwrap();
            assert!(mesh.is_closed());
            let bounds = surface.bounds();
            for _ in 0..300 {
                let p = bounds.centre() + 0.7 * random.vector().component_mul(&(bounds.max - bounds.min));
                let corners = surface.triangles.iter().map(|t| t.map(|v| surface.points[v as usize]));
                let least = corners.map(|c| (closest_point(p, c).point - p).norm()).fold(f64::INFINITY, f64::min);
                let Nearest { distance, normal } = mesh.nearest(p);
                assert!((distance.abs() - least).abs() < 1e-12, "{distance} {least}");
                let (mut crossings, mut from, way) = (0, p, random.direction());
                while let Some(hit) = cast(&surface.points, &surface.triangles, from, way) {
                    crossings += 1;
                    from += (hit.time + 1e-9) * way;
                }
                assert_eq!(distance < 0.0, crossings % 2 == 1, "{p:?}: {distance}, {crossings} crossings");
                // The normal is the gradient.
                let step = 1e-6 * bounds.longest_edge();
                let ahead = mesh.nearest(p + step * normal).distance;
                assert!(
                    distance.abs() < 10.0 * step || (ahead - distance - step).abs() < 1e-3 * step,
                    "{ahead} {distance}"
                );
            }
        }
    }

    #[test]
    fn faces_that_are_all_turned_inside_make_the_same_surface() {
        let outside = Surface::from_document(&generate::sphere(6, 0.05).unwrap());
        let mut inside = outside.clone();
        inside.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let [a, b] = [outside, inside].map(|surface| MeshSurface::new(&surface, 0.001).unwrap());
        for p in [Vec3::zeros(), Vec3::new(0.1, 0.02, 0.0), Vec3::new(0.0, 0.049, 0.0)] {
            assert!((a.nearest(p).distance - b.nearest(p).distance).abs() < 1e-15);
        }
        assert!((a.nearest(Vec3::new(0.1, 0.0, 0.0)).distance - 0.049).abs() < 1e-9, "0.05 m less its thickness");
        assert!(a.nearest(Vec3::zeros()).distance < -0.04);
    }

    #[test]
    fn an_open_mesh_needs_a_thickness_and_has_two_outsides() {
        let mut surface = Surface::from_document(&generate::sphere(6, 0.05).unwrap());
        surface.triangles.pop();
        assert_eq!(MeshSurface::new(&surface, 0.0).unwrap_err(), MeshSurfaceError::Open { borders: 3, others: 0 });
        let open = MeshSurface::new(&surface, 0.01).unwrap();
        let [within, beyond] = [Vec3::zeros(), Vec3::new(0.1, 0.0, 0.0)].map(|p| open.nearest(p).distance);
        assert!(within > 0.035 && (beyond - 0.04).abs() < 1e-9);
        assert!(open.nearest(Vec3::new(0.045, 0.0, 0.0)).distance < 0.0);
        surface.triangles.clear();
        assert_eq!(MeshSurface::new(&surface, 0.01).unwrap_err(), MeshSurfaceError::Empty);
    }
}
