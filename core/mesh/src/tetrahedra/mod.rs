//! Tetrahedral meshes of files: nodes, tetrahedra and groups, and the surface they bound.
//!
//! Formats are those that finite element codes exchange: Gmsh `.msh` 2 and 4.1, text and binary, legacy VTK `.vtk`, and its XML `.vtu`. The readers are ours. Of the
//! crates there are, `mshio` reads version 4.1 alone and skips the names of groups, `vtkio` stops at binary and text without lines in its errors, and a finite
//! element mesh wants an error that names the file, the line and the element. XML, base64 and zlib are those of `roxmltree`, `base64` and `flate2`.

mod assemble;
mod boundary;
mod data;
#[cfg(test)]
mod data_tests;
mod error;
mod groups;
mod index;
mod msh;
mod msh2;
mod msh4;
mod notes;
mod quadratic;
mod raw;
#[cfg(test)]
mod tests;
mod vtk;
mod vtk_data;
mod vtu;
mod vtu_array;
mod words;
mod write;

pub use boundary::{FACES, NO_NEIGHBOUR, neighbours};
pub use data::{DataPlace, MeshData};
pub use error::{TetMeshError, TetMeshProblem};
pub use groups::Group;
pub use notes::Note;
pub use quadratic::PARTS;

use crate::ObjDocument;
use crate::geometry::Vec3;
use crate::read::{MODEL_LIMIT, read_file};
use std::path::{Path, PathBuf};

/// A tetrahedral mesh: the nodes and tetrahedra of a file, without those nodes that no tetrahedron has.
#[derive(Clone, Debug)]
pub struct TetMesh {
    name: PathBuf,
    /// Positions of the nodes in the order of the file, file units (n x 3).
    pub points: Vec<Vec3>,
    /// Number of each node in the file: its tag in a `.msh`, its place from 0 in a `.vtk` (n).
    pub node_number: Vec<u64>,
    /// Nodes of each linear tetrahedron, with a positive volume: the last three are counter-clockwise seen from the first (m x 4). In a mesh of quadratic
    /// tetrahedra the eight parts of each, those at its corners first.
    pub tetrahedra: Vec<[u32; 4]>,
    /// Nodes of each quadratic tetrahedron, whose map from barycentric coordinates to positions is not folded: the corners, in the same order, and the middles of
    /// edges 01, 12, 02, 03, 13 and 23, as in a `.vtk` (q x 10). Empty for a mesh of linear tetrahedra.
    pub quadratic: Vec<[u32; 10]>,
    /// Whether an edge of a quadratic tetrahedron is curved, or its node is not in the middle.
    pub is_curved: bool,
    /// Number of each element in the file: its tag in a `.msh`, its place from 0 in a `.vtk` (m, or q).
    pub element_number: Vec<u64>,
    /// Named parts of the mesh, in the order of their dimensions and tags.
    pub groups: Vec<Group>,
    /// Numbers that the file gives at nodes and elements, in its order.
    pub data: Vec<MeshData>,
    /// What the file holds besides, and what was changed of it.
    pub notes: Vec<Note>,
    /// Corners of the boundary, counter-clockwise seen from outside, as nodes, in the order of their tetrahedra (b x 3).
    boundary: Vec<[u32; 3]>,
    /// Nodes of the boundary, ascending: the vertices of [`TetMesh::surface`].
    vertices: Vec<u32>,
}

impl TetMesh {
    /// Whether a file name has the ending of a tetrahedral mesh, `.msh`, `.vtk` or `.vtu`, in small or large letters.
    pub fn is_name(name: &str) -> bool {
        let ending = Path::new(name).extension().map(|ending| ending.to_ascii_lowercase());
        ending.is_some_and(|ending| ["msh", "vtk", "vtu"].iter().any(|known| ending == *known))
    }

    /// Reads the mesh at `path`, a regular file of at most [`MODEL_LIMIT`] bytes.
    ///
    /// # Errors
    /// [`TetMeshError`] if the file cannot be read or [`TetMesh::parse`] refuses it.
    pub fn read(path: &Path) -> Result<Self, TetMeshError> {
        let bytes = read_file(path, MODEL_LIMIT).map_err(|source| TetMeshError::Read { file: path.into(), source })?;
        Self::parse(&bytes, path)
    }

    /// Parses the mesh in `bytes`; its first line tells the format, and `name` is used in messages.
    ///
    /// # Errors
    /// [`TetMeshError`] with file, line, entity and value for a format that is not read, numbers that are not finite, nodes that are not there, cells with a volume
    /// other than tetrahedra of four or of ten nodes, both beside each other, flat or folded tetrahedra, and tetrahedra that overlap or do not fit together.
    pub fn parse(bytes: &[u8], name: &Path) -> Result<Self, TetMeshError> {
        let mut parsed = match bytes {
            _ if bytes.starts_with(b"# vtk") => vtk::parse(bytes),
            _ if vtu::is_xml(bytes) => vtu::parse(bytes),
            _ => msh::parse(bytes),
        };
        if let Ok(raw) = &mut parsed {
            data::RawData::find_lines(&mut raw.data, bytes);
        }
        let at_line =
            |(at, problem)| TetMeshError::Line { file: name.into(), line: words::line_at(bytes, at), problem };
        parsed.and_then(assemble::assemble).map(|mesh| Self { name: name.into(), ..mesh }).map_err(at_line)
    }

    /// The path given to [`TetMesh::read`] or [`TetMesh::parse`].
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Nodes of the boundary, ascending; vertex k of [`TetMesh::surface`] is the k-th.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The boundary as an OBJ document in file units: its faces are counter-clockwise seen from outside, under `g` lines with the names of their groups.
    ///
    /// # Errors
    /// [`TetMeshError`] for a boundary that is too large for an OBJ document.
    pub fn surface(&self) -> Result<ObjDocument, TetMeshError> {
        boundary::document(self)
    }

    /// The group with a name; `None` if there is none.
    pub fn group(&self, name: &str) -> Option<&Group> {
        self.groups.iter().find(|group| group.name == name)
    }

    /// Number of elements that the file has.
    pub fn elements(&self) -> usize {
        self.element_number.len()
    }

    /// Names of all groups with their kinds, for messages.
    pub fn list_groups(&self) -> String {
        let all: Vec<String> = self.groups.iter().map(|group| format!("`{}` ({})", group.name, group.kind())).collect();
        if all.is_empty() { "none: the file has no physical groups".into() } else { all.join(", ") }
    }

    /// Six times the volume of a tetrahedron with corners at `points`, in cubed units of the points; negative if it is inverted.
    pub fn six_volumes(points: &[Vec3], [a, b, c, d]: [u32; 4]) -> f64 {
        let [a, b, c, d] = [a, b, c, d].map(|node| points[node as usize]);
        (b - a).dot(&(c - a).cross(&(d - a)))
    }
}
