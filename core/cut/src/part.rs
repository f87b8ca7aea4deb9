//! A part of a mesh as a document of its own, with the same vertices.

use super::mesh::CutMesh;
use super::write::Chosen;
use pliant_mesh::obj::WriteError;
use pliant_mesh::{ObjDocument, Surface};
use std::collections::{BTreeSet, HashMap};

/// A part of a mesh, uncut.
pub struct MeshPart {
    /// The file of the model with all of its rows and those of cuts, and with the faces of the part.
    pub document: ObjDocument,
    /// The vertices of the whole, with their bits, and the triangles of the part in the order of the document, m.
    pub surface: Surface,
    /// Triangle of the whole that each of them is.
    pub triangle: Vec<u32>,
}

impl CutMesh {
    /// The part of the mesh whose triangles are `owned`, at rest. `document` is the one the mesh was made from. All vertices stay and keep their indices; lids
    /// are left out. Groups, materials and smoothing of the faces stay, caps get the group and material `material`.
    ///
    /// # Errors
    /// Those of [`ObjDocument::write`], and a document that cannot be read again.
    pub fn part(
        &self,
        document: &ObjDocument,
        owned: impl Fn(u32) -> bool,
        material: &str,
    ) -> Result<MeshPart, PartError> {
        let owned_triangles = || (0..self.surface.triangles.len() as u32).filter(|t| owned(*t) && !self.is_lid(*t));
        let has_failed = |t: u32| !owned(t);
        // A polygon that is triangulated otherwise is written as triangles: by rounding of copied corners, or where a quad that had two edges in common with it was cut,
        // so that the two no longer keep out of each other's diagonals.
        let mut divided: BTreeSet<u32> = BTreeSet::new();
        loop {
            let is_divided = |face: u32| divided.contains(&face);
            let number = (0..self.surface.points.len() as u32).collect();
            let chosen = Chosen { number, has_failed: &has_failed, is_divided: &is_divided };
            let mut bytes = Vec::new();
            self.write_chosen(&chosen, document, &self.surface.points, material, &mut bytes)?;
            let welds = document.welds();
            let mut document = ObjDocument::parse(bytes, document.name())?;
            document.weld(welds);
            let turned = self.turned_faces(&Surface::from_document(&document), owned_triangles());
            document.turn_over(&turned);
            let read = Surface::from_document(&document);
            let mut known: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
            owned_triangles().for_each(|t| known.entry(self.surface.triangles[t as usize]).or_default().push(t));
            known.values_mut().for_each(|same| same.reverse());
            let triangle: Vec<u32> =
                read.triangles.iter().filter_map(|corners| known.get_mut(corners).and_then(Vec::pop)).collect();
            let left: Vec<u32> = known.into_values().flatten().collect();
            if left.is_empty() && triangle.len() == read.triangles.len() {
                let points = self.surface.points.clone();
                let surface = Surface { points, ..read };
                return Ok(MeshPart { document, surface, triangle });
            }
            let faces: BTreeSet<u32> = left.iter().map(|t| self.surface.face_of[*t as usize]).collect();
            if faces.is_subset(&divided) {
                let (found, expected) = (read.triangles.len(), owned_triangles().count());
                return Err(PartError::Triangles { found, expected });
            }
            divided.extend(faces);
        }
    }
}

impl CutMesh {
    /// Faces, ascending, whose triangles run the other way round in `read`, the surface of a file, than the triangles `owned` of this mesh.
    fn turned_faces(&self, read: &Surface, owned: impl Iterator<Item = u32>) -> Vec<u32> {
        let ahead = |corners: [u32; 3]| {
            let first = (0..3).min_by_key(|corner| corners[*corner]).unwrap_or(0);
            [0, 1, 2].map(|step| corners[(first + step) % 3])
        };
        let known: BTreeSet<[u32; 3]> = owned.map(|t| ahead(self.surface.triangles[t as usize])).collect();
        let is_turned = |&[a, b, c]: &[u32; 3]| !known.contains(&ahead([a, b, c])) && known.contains(&ahead([a, c, b]));
        let mut faces: Vec<u32> =
            read.triangles.iter().zip(&read.face_of).filter(|(t, _)| is_turned(t)).map(|(_, face)| *face).collect();
        faces.dedup();
        faces
    }
}

/// Why a part of a mesh is no document of its own.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// A vertex or a normal cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// What was written cannot be read.
    #[error(transparent)]
    Read(#[from] pliant_mesh::ObjError),
    /// The faces that were written have other triangles.
    #[error("its faces have {found} triangles in a file of their own and {expected} in the model; allowed is the same")]
    Triangles {
        /// Number of triangles read.
        found: usize,
        /// Number of triangles of the part.
        expected: usize,
    },
}
