//! A triangle mesh that can be cut.

use super::lids;
use super::record::{Journal, NONE, OPEN, Origin, Triangle};
use super::snap::{SHEET_SNAPS, SNAPS, SnapTolerances};
use super::solid::{self, Body};
use pliant_mesh::geometry::{TriangleTree, Vec3, meet};
use pliant_mesh::{ObjDocument, Placement, Surface};

/// A mesh that can be cut, advance by advance, with undo.
///
/// Vertices and triangles have the indices of the [`Surface`] it was made from, followed by lids and what cuts add; the first piece of a divided
/// triangle keeps its index. No index becomes invalid, and unchanged triangles keep theirs.
pub struct CutMesh {
    pub(super) surface: Surface,
    /// Next half-edge of the same edge; the half-edge itself on a border (m x 3). Half-edge 3 t + c leads from corner c of triangle t to its next
    /// corner.
    pub(super) links: Vec<[u32; 3]>,
    pub(super) texture: Vec<[u32; 3]>, // row of `texcoords` at each corner, or `NONE` (m x 3)
    pub(super) shading: Vec<[u32; 3]>, // row of `normals` at each corner, or `NONE` (m x 3)
    pub(super) body: Vec<u32>,         // closed body of each triangle, or `OPEN` (m)
    pub(super) texcoords: Vec<[f64; 2]>,
    pub(super) normals: Vec<Vec3>, // in axes of the file
    pub(super) origins: Vec<Origin>,
    pub(super) bodies: Vec<Body>,
    pub(super) tree: TriangleTree,
    pub(super) placement: Placement,
    pub(super) uncut: UncutCounts,
    pub(super) journal: Journal,
    pub(super) snaps: [SnapTolerances; 3], // tried in this order
}

/// The mesh before any cut.
pub(super) struct UncutCounts {
    pub points: usize,
    pub faces: usize,
    pub texcoords: usize,
    pub normals: usize,
    pub reach: f64, // length of a ray that ends outside from every point of the mesh, m
}

/// Largest number of half-edges of an edge. More of them mean a broken ring of links, which every check refuses.
const MAX_HALF_EDGES: usize = 256;

impl CutMesh {
    /// The triangles of a document with their placement, uncut.
    pub fn new(document: &ObjDocument, placement: &Placement) -> Self {
        Self::build(document, Surface::from_document(document).placed(placement), placement, true)
    }

    /// The triangles of a document at the places and with the corners of `surface` (m), which may differ from the document's by rounding; uncut. As a sheet or as
    /// the surface of a solid.
    pub fn of_surface(document: &ObjDocument, surface: Surface, placement: &Placement, is_sheet: bool) -> Self {
        let mesh = Self::build(document, surface, placement, !is_sheet);
        if is_sheet { Self { snaps: SHEET_SNAPS, ..mesh } } else { mesh }
    }

    /// The same as a sheet: nothing is enclosed and no hole is closed. Its triangles are elements, so a cut snaps to vertices over a larger
    /// distance.
    pub fn sheet(document: &ObjDocument, placement: &Placement) -> Self {
        Self::of_surface(document, Surface::from_document(document).placed(placement), placement, true)
    }

    /// Number of triangles that bound no volume and are cut as an open surface. Lids count like the component they close.
    pub fn open_triangles(&self) -> usize {
        self.body.iter().filter(|body| **body == OPEN).count()
    }

    /// Whether a triangle bounds no volume and is cut as an open surface.
    pub fn is_open(&self, triangle: u32) -> bool {
        self.body[triangle as usize] == OPEN
    }

    /// Number of edges with one triangle, without those that lids close.
    pub fn border_edges(&self) -> usize {
        let halves = self.links.iter().enumerate();
        halves.map(|(t, links)| (0..3).filter(|c| links[*c] as usize == 3 * t + c).count()).sum()
    }

    fn build(document: &ObjDocument, mut surface: Surface, placement: &Placement, encloses: bool) -> Self {
        let mut links = link(&surface);
        let mut lids = if encloses { lids::find(&surface, &links) } else { Vec::new() };
        let (mut texture, mut shading) = corner_rows(document, &surface);
        if !lids.is_empty() {
            surface.triangles.append(&mut lids);
            let count = surface.triangles.len();
            surface.face_of.resize(count, document.face_count() as u32 + 1);
            texture.resize(count, [NONE; 3]);
            shading.resize(count, [NONE; 3]);
            links = link(&surface);
        }
        let (body, bodies) =
            if encloses { solid::find(&surface, &links) } else { (vec![OPEN; surface.triangles.len()], Vec::new()) };
        Self {
            tree: TriangleTree::new(&surface.points, &surface.triangles),
            texcoords: document.texcoords().to_vec(),
            normals: document.normals().to_vec(),
            origins: Vec::new(),
            placement: *placement,
            journal: Journal::default(),
            uncut: UncutCounts {
                points: surface.points.len(),
                faces: document.face_count(),
                texcoords: document.texcoords().len(),
                normals: document.normals().len(),
                reach: solid::reach(&surface),
            },
            snaps: SNAPS,
            surface,
            links,
            texture,
            shading,
            body,
            bodies,
        }
    }

    /// Rest positions, triangles, and the document's face of each triangle: the number of faces for a triangle of a cap, one more for a triangle
    /// of a lid.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Origin of a vertex.
    pub fn origin(&self, vertex: u32) -> Origin {
        match (vertex as usize).checked_sub(self.uncut.points) {
            Some(new) => self.origins.get(new).copied().unwrap_or(Origin::Original),
            None => Origin::Original,
        }
    }

    /// Rows of texture coordinates: those of the document, then those of cuts. On a cut surface they are the distances along the blade and along
    /// its path, m.
    pub fn texcoords(&self) -> &[[f64; 2]] {
        &self.texcoords
    }

    /// Rows of normals in axes of the file: those of the document, then those of cuts.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Rows of texture coordinates and of normals at the corners of a triangle; `u32::MAX` without one.
    pub fn corner_rows(&self, triangle: u32) -> ([u32; 3], [u32; 3]) {
        (self.texture[triangle as usize], self.shading[triangle as usize])
    }

    /// Whether a triangle is part of the cut surface inside a body.
    pub fn is_cap(&self, triangle: u32) -> bool {
        self.surface.face_of[triangle as usize] as usize == self.uncut.faces
    }

    /// Whether a triangle is part of a lid, which closes a hole for cuts and is never written.
    pub fn is_lid(&self, triangle: u32) -> bool {
        self.surface.face_of[triangle as usize] as usize > self.uncut.faces
    }

    /// The neighbours of a triangle across its sides, first that from corner 0 to corner 1. On a border it is the triangle itself, on a
    /// non-manifold edge one of several.
    pub fn neighbours(&self, triangle: u32) -> [u32; 3] {
        self.links[triangle as usize].map(|half| half / 3)
    }

    /// Whether a segment intersects the mesh. Ends are in m.
    pub fn is_crossed(&self, from: Vec3, to: Vec3) -> bool {
        let way = to - from;
        let mut crossed = false;
        self.tree.along(from, to, |t| crossed |= meet(self.corners_of(t), from, way).is_some_and(|(s, _)| s <= 1.0));
        crossed
    }

    pub(super) fn point(&self, vertex: u32) -> Vec3 {
        self.surface.points[vertex as usize]
    }

    pub(super) fn corners_of(&self, triangle: u32) -> [Vec3; 3] {
        self.surface.triangles[triangle as usize].map(|vertex| self.surface.points[vertex as usize])
    }

    pub(super) fn tail(&self, half: u32) -> u32 {
        self.surface.triangles[half as usize / 3][half as usize % 3]
    }

    pub(super) fn head(&self, half: u32) -> u32 {
        self.surface.triangles[half as usize / 3][(half as usize + 1) % 3]
    }

    pub(super) fn link_of(&self, half: u32) -> u32 {
        self.links[half as usize / 3][half as usize % 3]
    }

    /// All half-edges of the edge of `half`, itself first.
    pub(super) fn around(&self, half: u32) -> impl Iterator<Item = u32> + '_ {
        let following = move |at: &u32| Some(self.link_of(*at)).filter(|&next| next != half);
        std::iter::successors(Some(half), following).take(MAX_HALF_EDGES)
    }

    pub(super) fn triangle(&self, triangle: u32) -> Triangle {
        let t = triangle as usize;
        Triangle {
            corners: self.surface.triangles[t],
            links: self.links[t],
            texture: self.texture[t],
            shading: self.shading[t],
            face: self.surface.face_of[t],
            body: self.body[t],
        }
    }

    /// Normal of a triangle; its length is twice the area, m^2.
    pub(super) fn cross(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.corners_of(triangle);
        (b - a).cross(&(c - a))
    }
}

/// Texture and normal rows of the corners of each triangle.
fn corner_rows(document: &ObjDocument, surface: &Surface) -> (Vec<[u32; 3]>, Vec<[u32; 3]>) {
    let mut rows = (Vec::with_capacity(surface.triangles.len()), Vec::with_capacity(surface.triangles.len()));
    let mut known = (u32::MAX, &[][..]);
    for (triangle, &face) in surface.triangles.iter().zip(&surface.face_of) {
        if known.0 != face {
            known = (face, document.face(face as usize).map_or(&[][..], |face| face.corners));
        }
        let corner = triangle.map(|vertex| known.1.iter().find(|corner| corner.v == vertex));
        rows.0.push(corner.map(|corner| corner.and_then(|corner| corner.vt()).unwrap_or(NONE)));
        rows.1.push(corner.map(|corner| corner.and_then(|corner| corner.vn()).unwrap_or(NONE)));
    }
    rows
}

fn link(surface: &Surface) -> Vec<[u32; 3]> {
    let mut links = vec![[0; 3]; surface.triangles.len()];
    for (_, sides) in surface.edges().iter() {
        for (at, side) in sides.iter().enumerate() {
            let next = sides[(at + 1) % sides.len()];
            links[side.triangle as usize][usize::from(side.corner)] = 3 * next.triangle + u32::from(next.corner);
        }
    }
    links
}
