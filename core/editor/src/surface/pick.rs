//! Picking: the first triangle a ray hits.

use super::ViewSurface;
use crate::hand::{PointerRay, SurfacePoint};
use pliant_mesh::geometry::{TriangleTree, meet};
use pliant_solver::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// Intersection of a ray with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle that is hit.
    pub triangle: u32,
    /// Barycentric coordinates of the point in the triangle, of its three corners.
    pub weights: Vec3,
    /// Distance along the ray, m.
    pub distance: f64,
    /// The point with its shading normal.
    pub at: SurfacePoint,
}

/// Ray queries on one surface. A triangle tree is built on a background thread; until it is ready, every triangle is tested.
///
/// During a stroke it is not updated, so that a hand following the surface does not follow the dent it makes.
pub struct Picker {
    tree: Option<TriangleTree>,
    pub(super) building: Option<JoinHandle<Option<TriangleTree>>>,
    cancel: Arc<AtomicBool>,
    /// Positions of the vertices in the tree, m (n x 3).
    positions: Vec<Vec3>,
    /// Triangles that changed while the tree was being built.
    waiting: Vec<u32>,
}

impl Picker {
    /// Starts building the tree of a surface.
    pub fn new(surface: &ViewSurface) -> Self {
        let positions: Vec<Vec3> = (0..surface.positions.len() as u32).map(|v| surface.place(v)).collect();
        let triangles: Vec<[u32; 3]> =
            surface.triangles.iter().map(|look| look.map_or([0; 3], |look| look.corners)).collect();
        let cancel = Arc::new(AtomicBool::new(false));
        let (of_thread, points) = (Arc::clone(&cancel), positions.clone());
        let build = move || {
            let is_needed = !of_thread.load(Ordering::Relaxed) && !triangles.is_empty();
            is_needed.then(|| TriangleTree::new(&points, &triangles))
        };
        let building = std::thread::Builder::new().name("picker".into()).spawn(build).ok();
        Self { tree: None, building, cancel, positions, waiting: Vec::new() }
    }

    /// Updates vertices that have moved and triangles that have changed (indices in any order).
    pub fn update(&mut self, surface: &ViewSurface, moved: &[u32], triangles: impl Iterator<Item = u32>) {
        self.positions.resize(surface.positions.len(), Vec3::zeros());
        let mut changed: Vec<u32> = triangles.collect();
        for &vertex in moved {
            self.positions[vertex as usize] = surface.place(vertex);
            changed.extend_from_slice(surface.around.of(vertex));
        }
        changed.sort_unstable();
        changed.dedup();
        self.waiting.append(&mut changed);
        self.apply_pending(surface);
    }

    /// Receives the tree from its thread once it is built, and applies the pending changes to it.
    fn apply_pending(&mut self, surface: &ViewSurface) {
        if self.tree.is_none() && self.building.as_ref().is_some_and(JoinHandle::is_finished) {
            self.tree = self.building.take().and_then(|thread| thread.join().ok()).flatten();
        }
        let Some(tree) = &mut self.tree else { return };
        self.waiting.sort_unstable();
        self.waiting.dedup();
        for triangle in self.waiting.drain(..) {
            match surface.triangles.get(triangle as usize).copied().flatten() {
                Some(look) => tree.set(triangle, look.corners.map(|v| self.positions[v as usize])),
                None => tree.remove(triangle),
            }
        }
    }

    /// The first triangle the ray hits within `reach` (m), from either side.
    pub fn pick(&mut self, surface: &ViewSurface, ray: &PointerRay, reach: f64) -> Option<Hit> {
        self.apply_pending(surface);
        let mut best: Option<(f64, u32, Vec3)> = None;
        let positions = &self.positions;
        let mut look_at = |triangle: u32| {
            let Some(look) = surface.triangles.get(triangle as usize).copied().flatten() else { return };
            let corners = look.corners.map(|v| positions.get(v as usize).copied().unwrap_or_default());
            if let Some((time, bary)) = meet(corners, ray.origin, ray.direction)
                && time <= reach
                && best.is_none_or(|(least, of, _)| (time, triangle) < (least, of))
            {
                best = Some((time, triangle, bary));
            }
        };
        match &self.tree {
            Some(tree) => tree.along(ray.origin, ray.origin + reach * ray.direction, &mut look_at),
            None => (0..surface.triangles.len() as u32).for_each(&mut look_at),
        }
        let (distance, triangle, weights) = best?;
        let (point, normal) = (ray.origin + distance * ray.direction, surface.normal_at(triangle, &weights)?);
        Some(Hit { triangle, weights, distance, at: SurfacePoint { point, normal } })
    }

    /// Whether the tree is ready.
    pub fn is_ready(&self) -> bool {
        self.tree.is_some()
    }
}

impl ViewSurface {
    /// The point of a triangle with these barycentric coordinates as the surface is now, with its shading normal; `None` where there is no such triangle any
    /// more. A point that was hit before is followed so while the surface moves.
    pub fn point_at(&self, triangle: u32, weights: &Vec3) -> Option<SurfacePoint> {
        let [a, b, c] = self.corner_places(triangle)?;
        let point = weights.x * a + weights.y * b + weights.z * c;
        Some(SurfacePoint { point, normal: self.normal_at(triangle, weights)? })
    }

    /// Unit shading normal at a point of a triangle; `None` if that is degenerate and so are its neighbours.
    fn normal_at(&self, triangle: u32, weights: &Vec3) -> Option<Vec3> {
        let corners = self.corners.get(triangle as usize)?;
        let of_corner = |corner: &u32| Vec3::from(self.normals[*corner as usize].map(f64::from));
        let normal: Vec3 = corners.iter().zip(weights.iter()).map(|(corner, share)| *share * of_corner(corner)).sum();
        normal.try_normalize(1e-9).or_else(|| self.cross(triangle).try_normalize(0.0))
    }
}

impl Drop for Picker {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}
