//! The model of a body: its document, its surface at rest in metres, and the triangles around each vertex.

use super::lattice::TetrahedralCells;
use super::pages::PageStamps;
use pliant_mesh::geometry::TriangleTree;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{Finding, ObjDocument, Placement, Surface, TetMesh, check};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// How often the faces of a model's file were divided into four, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subdivision {
    /// Number of times.
    pub levels: u32,
    /// Reason, for people.
    pub why: String,
}

/// A model placed in the scene. It changes when a blade cuts it, not when the body deforms.
#[derive(Clone)]
pub struct Model {
    /// The OBJ document, in units of the file; of a tetrahedral mesh its boundary.
    pub document: ObjDocument,
    /// Scale and translation from units of the file to metres of the scene.
    pub placement: Placement,
    /// The surface in the rest shape of the file, with cuts, m.
    pub surface: Surface,
    /// Defects of the mesh in the file.
    pub findings: Vec<Finding>,
    /// What the scene's `subdivide` came to.
    pub subdivision: Option<Subdivision>,
    /// The tetrahedra of the file, whose boundary the document is; `None` for a file of a surface.
    pub tetrahedra: Option<Arc<TetrahedralCells>>,
    /// Triangles around vertex v of the file: `around[start[v]..start[v + 1]]`.
    start: Vec<u32>,
    around: Vec<u32>,
    /// Pages of triangles that have changed, for viewers.
    pub pages: PageStamps,
    /// Triangles around vertices that a cut has made or changed; they replace those of `around`.
    recut: HashMap<u32, Vec<u32>>,
    /// The longest edge at each vertex (n), m.
    longest_edge: Vec<f32>,
    /// Faces that are caps, of a part of a body that was split; `None` for a body that is whole.
    part: Option<Arc<HashSet<u32>>>,
}

impl Model {
    /// Triangulates a document, checks it and places it in the scene.
    pub fn new(document: ObjDocument, placement: Placement) -> Self {
        let surface = Surface::from_document(&document);
        let findings = check(&surface, &document);
        let surface = surface.placed(&placement);
        Self::of_surface(document, placement, surface, findings)
    }

    /// The model of a document whose triangles, placed in the scene, are `surface` (m).
    fn of_surface(document: ObjDocument, placement: Placement, surface: Surface, findings: Vec<Finding>) -> Self {
        let n = surface.points.len();
        let mut start = vec![0_u32; n + 1];
        for &v in surface.triangles.iter().flatten() {
            start[v as usize + 1] += 1;
        }
        for v in 0..n {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut around = vec![0; surface.triangles.len() * 3];
        let mut longest_edge = vec![0.0_f32; n];
        for (t, corners) in surface.triangles.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (corners[i] as usize, corners[(i + 1) % 3] as usize);
                around[next[a] as usize] = t as u32;
                next[a] += 1;
                let edge = distance(surface.points[a], surface.points[b]) as f32;
                longest_edge[a] = longest_edge[a].max(edge);
                longest_edge[b] = longest_edge[b].max(edge);
            }
        }
        Self {
            document,
            placement,
            surface,
            findings,
            subdivision: None,
            tetrahedra: None,
            start,
            around,
            pages: PageStamps::default(),
            recut: HashMap::new(),
            longest_edge,
            part: None,
        }
    }

    /// The model of a part of a cut body that becomes a body of its own: `document` has all vertices of the whole at rest, `surface` (m) the triangles of the
    /// part, and `caps` are the faces that cuts have made.
    pub(super) fn of_part(&self, document: ObjDocument, surface: Surface, caps: HashSet<u32>) -> Self {
        let mut model = Self::of_surface(document, self.placement, surface, self.findings.clone());
        model.subdivision.clone_from(&self.subdivision);
        model.part = Some(Arc::new(caps));
        model.pages.clone_from(&self.pages);
        model
    }

    /// Whether it is a part of a body that was split: its document has vertices that are in other bodies.
    pub fn is_part(&self) -> bool {
        self.part.is_some()
    }

    /// Whether a face of the document is one that a cut made before the body was split.
    pub fn is_cap_face(&self, face: u32) -> bool {
        self.part.as_ref().is_some_and(|caps| caps.contains(&face))
    }

    /// Whether a triangle is on a face that a cut has made.
    pub fn is_cap(&self, triangle: u32) -> bool {
        let face = self.surface.face_of[triangle as usize];
        self.is_cap_face(face) || face as usize == self.document.face_count()
    }

    /// The model of a tetrahedral mesh, whose boundary is `document`, placed in the scene.
    pub fn of_tetrahedra(mesh: TetMesh, document: ObjDocument, placement: Placement) -> Self {
        let mut model = Self::new(document, placement);
        model.tetrahedra = Some(Arc::new(TetrahedralCells::new(mesh, &placement, &model.surface)));
        model
    }

    /// Triangles around a vertex.
    pub fn around(&self, vertex: u32) -> &[u32] {
        if let Some(list) = self.recut.get(&vertex) {
            return list;
        }
        match self.start.get(vertex as usize + 1) {
            Some(&end) => &self.around[self.start[vertex as usize] as usize..end as usize],
            None => &[], // a vertex whose triangles are all lids
        }
    }

    /// Sum of the area vectors of the triangles around a vertex, m^2, with vertices at `points` (m, n x 3). It points along the vertex
    /// normal.
    pub fn area_around(&self, vertex: u32, points: &[Vec3]) -> Vec3 {
        let each = self.around(vertex).iter().filter(|t| !self.is_lid(**t));
        let corners = each.map(|&t| self.surface.triangles[t as usize].map(|v| points[v as usize]));
        corners.map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a))).sum()
    }

    /// The longest edge at a vertex, m.
    pub fn longest_edge(&self, vertex: u32) -> f64 {
        f64::from(self.longest_edge[vertex as usize])
    }

    /// Adopts a surface that a blade has changed: `changed` lists the triangles that exist before and after and have other corners;
    /// vertices and triangles at the end are added or removed.
    pub fn take_cut(&mut self, surface: &Surface, changed: &[u32]) {
        let (known, count) = (self.surface.triangles.len(), surface.triangles.len());
        let stays = |t: &u32| (*t as usize) < known.min(count);
        for t in changed.iter().copied().filter(stays) {
            self.disconnect(t);
        }
        self.truncate(self.surface.points.len().min(surface.points.len()), count);
        let points = self.surface.points.len();
        self.add_points(&surface.points[points..]);
        for t in changed.iter().copied().filter(stays) {
            self.surface.triangles[t as usize] = surface.triangles[t as usize];
            self.surface.face_of[t as usize] = surface.face_of[t as usize];
        }
        let first = self.surface.triangles.len();
        self.surface.triangles.extend_from_slice(&surface.triangles[first..]);
        self.surface.face_of.extend_from_slice(&surface.face_of[first..]);
        changed.iter().copied().filter(stays).chain(first as u32..count as u32).for_each(|t| self.connect(t));
    }

    /// Removes all vertices but the first `points` and all triangles but the first `count`; triangles that stay have vertices that stay.
    pub(super) fn truncate(&mut self, points: usize, count: usize) {
        for t in count as u32..self.surface.triangles.len() as u32 {
            self.disconnect(t);
        }
        self.surface.points.truncate(points);
        self.longest_edge.truncate(points);
        self.recut.retain(|v, _| (*v as usize) < points);
        self.surface.triangles.truncate(count);
        self.surface.face_of.truncate(count);
    }

    /// Adds vertices at `points` (m), and triangles that are in no face of the file and not on its surface, as caps are.
    pub(super) fn add_inner(&mut self, points: &[Vec3], triangles: &[[u32; 3]]) {
        let first = self.surface.triangles.len() as u32;
        self.add_points(points);
        self.surface.triangles.extend_from_slice(triangles);
        self.surface.face_of.resize(self.surface.triangles.len(), self.document.face_count() as u32);
        (first..self.surface.triangles.len() as u32).for_each(|t| self.connect(t));
    }

    /// Finds the longest edges at vertices anew, after triangles around them have gone.
    pub(super) fn measure_edges(&mut self, vertices: impl Iterator<Item = u32>) {
        for v in vertices {
            let points = &self.surface.points;
            let around = self.around(v).iter().flat_map(|t| self.surface.triangles[*t as usize]);
            let edges = around.map(|other| distance(points[v as usize], points[other as usize]) as f32);
            self.longest_edge[v as usize] = edges.fold(0.0, f32::max);
        }
    }

    fn add_points(&mut self, points: &[Vec3]) {
        self.surface.points.extend_from_slice(points);
        self.longest_edge.resize(self.surface.points.len(), 0.0);
    }

    /// Removes a triangle from those around its corners.
    fn disconnect(&mut self, triangle: u32) {
        for v in self.surface.triangles[triangle as usize] {
            self.around_mut(v).retain(|other| *other != triangle);
        }
    }

    /// Adds a triangle to those around its corners, and marks it for viewers.
    fn connect(&mut self, triangle: u32) {
        self.pages.mark(triangle);
        if self.is_lid(triangle) {
            return;
        }
        let corners = self.surface.triangles[triangle as usize];
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let list = self.around_mut(a);
            if let Err(place) = list.binary_search(&triangle) {
                list.insert(place, triangle);
            }
            let edge = distance(self.surface.points[a as usize], self.surface.points[b as usize]) as f32;
            for v in [a, b] {
                let longest = &mut self.longest_edge[v as usize];
                *longest = longest.max(edge);
            }
        }
    }

    /// Whether a triangle is a lid, which closes a hole for cutting; it is neither drawn nor touched.
    pub fn is_lid(&self, triangle: u32) -> bool {
        self.surface.face_of[triangle as usize] as usize > self.document.face_count()
    }

    fn around_mut(&mut self, vertex: u32) -> &mut Vec<u32> {
        let (start, around) = (&self.start, &self.around);
        self.recut.entry(vertex).or_insert_with(|| match start.get(vertex as usize + 1) {
            Some(&end) => around[start[vertex as usize] as usize..end as usize].to_vec(),
            None => Vec::new(),
        })
    }

    /// A bounding volume tree over the triangles of `surface`.
    pub fn tree(&self) -> TriangleTree {
        TriangleTree::new(&self.surface.points, &self.surface.triangles)
    }

    /// Estimate of the memory, bytes: the largest arrays.
    pub fn bytes(&self) -> usize {
        let s = &self.surface;
        let tetrahedra = self.tetrahedra.as_ref().map_or(0, |cells| cells.bytes());
        tetrahedra + self.document.bytes().len() + s.points.len() * (24 + 8) + s.triangles.len() * (12 + 4 + 12)
    }
}

fn distance(a: Vec3, b: Vec3) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
