//! Checks of the invariants of a cut, over the whole mesh and from its triangles alone.

use crate::mesh::CutMesh;
use crate::record::OPEN;
use pliant_mesh::Surface;
use pliant_mesh::geometry::Vec3;

/// Quantities that no cut changes.
pub struct Sums {
    area: f64,
    volume: f64,
    branches: bool,
    turned: bool,
    used: Vec<bool>,
}

impl Sums {
    pub fn new(mesh: &CutMesh) -> Self {
        let table = mesh.surface().edges();
        let branches = table.iter().any(|(_, sides)| sides.len() > 2);
        let turned = table.iter().any(|(_, sides)| sides.len() == 2 && sides[0].upward == sides[1].upward);
        Self { area: skin(mesh), volume: volume(mesh), branches, turned, used: used(mesh.surface()) }
    }

    /// Panics if an invariant is violated.
    pub fn check(&self, mesh: &CutMesh) {
        let surface = mesh.surface();
        let area = skin(mesh);
        assert!((area - self.area).abs() <= 1e-12 * self.area, "area {area}, was {}", self.area);
        let volume = volume(mesh);
        let size = self.area.powf(1.5);
        assert!(
            (volume - self.volume).abs() <= 1e-9 * self.volume.abs() + 1e-13 * size,
            "volume {volume}, was {}",
            self.volume
        );
        let mut wall = Vec3::zeros();
        let mut wall_area = 0.0;
        for triangle in (0..surface.triangles.len() as u32).filter(|&triangle| mesh.is_cap(triangle)) {
            wall += mesh.cross(triangle);
            wall_area += mesh.cross(triangle).norm();
        }
        assert!(wall.norm() <= 1e-12 * wall_area, "walls do not face each other: {wall:?} of {wall_area}");
        for (vertices, sides) in surface.edges().iter() {
            assert!(self.branches || sides.len() <= 2, "{} faces on edge {vertices:?}", sides.len());
            if sides.len() == 2 && !self.turned && !self.branches {
                assert_ne!(sides[0].upward, sides[1].upward, "orientation at {vertices:?}");
            }
            let half = |side: &pliant_mesh::edges::Side| 3 * side.triangle + u32::from(side.corner);
            let mut known: Vec<u32> = sides.iter().map(half).collect();
            let mut linked: Vec<u32> = mesh.around(known[0]).collect();
            known.sort_unstable();
            linked.sort_unstable();
            assert_eq!(known, linked, "links at {vertices:?}");
            if mesh.body[sides[0].triangle as usize] != OPEN {
                assert_eq!(sides.len(), 2, "a body is open at {vertices:?}");
            }
        }
        let mut whole = self.used.clone();
        whole.resize(surface.points.len(), true);
        assert_eq!(used(surface), whole, "a vertex without triangle");
        for (number, triangle) in surface.triangles.iter().enumerate() {
            let cross = mesh.cross(number as u32).norm();
            assert!(cross > 0.0 || number < self.used.len(), "triangle {number} {triangle:?} has no area");
        }
        assert_eq!(surface.face_of.len(), surface.triangles.len());
    }
}

/// Euler characteristic: vertices minus edges plus faces.
pub fn euler(surface: &Surface) -> i64 {
    let vertices = used(surface).iter().filter(|used| **used).count() as i64;
    vertices - surface.edges().len() as i64 + surface.triangles.len() as i64
}

/// Area without walls.
fn skin(mesh: &CutMesh) -> f64 {
    let triangles = 0..mesh.surface().triangles.len() as u32;
    triangles.filter(|&triangle| !mesh.is_cap(triangle)).map(|triangle| 0.5 * mesh.cross(triangle).norm()).sum()
}

fn volume(mesh: &CutMesh) -> f64 {
    let origin = mesh.surface().bounds().centre();
    let bodies = (0..mesh.surface().triangles.len()).filter(|&triangle| mesh.body[triangle] != OPEN);
    let cone = |triangle: usize| {
        (mesh.point(mesh.surface().triangles[triangle][0]) - origin).dot(&mesh.cross(triangle as u32)) / 6.0
    };
    bodies.map(cone).sum()
}

fn used(surface: &Surface) -> Vec<bool> {
    let mut used = vec![false; surface.points.len()];
    surface.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
    used
}
