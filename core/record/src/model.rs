//! The deformed model as a file.

use crate::atomic::{AtomicFile, error_at};
use pliant_engine::body::{Body, CutMesh, FailedTriangles};
use pliant_mesh::geometry::{Vec3, closest_point};
use pliant_mesh::obj::{Corner, Patch, WriteError};
use pliant_mesh::{ObjDocument, Placement, Surface};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

/// Group and material of faces that failed elements have exposed, where no cut of the scene names a material.
const EXPOSED: &str = "fracture";
/// Row of a vertex that the file does not have.
pub(crate) const NO_ROW: u32 = u32::MAX;

/// Writes the OBJ document of a body with its deformed surface to a file. See [`ModelShape::write`].
///
/// # Errors
/// Fails for a vertex that cannot be written and with the error of the file system, each with the path.
pub fn write_model(body: &Body, cap_material: &str, path: &Path) -> io::Result<()> {
    ModelShape::of(body).write_file(cap_material, path)
}

/// Writes the OBJ document of a body with its deformed surface. See [`ModelShape::write`].
///
/// # Errors
/// Fails for a vertex that cannot be written and with the errors of `out`.
pub fn write_model_to(body: &Body, cap_material: &str, out: &mut impl Write) -> io::Result<()> {
    ModelShape::of(body).write(cap_material, out)
}

/// Writes the tetrahedral mesh of a body as a VTK file, with the displacement of its nodes in file units, and which elements have failed, if
/// any; nothing for another body.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_tetrahedra_to(body: &Body, out: &mut impl Write) -> io::Result<()> {
    let Some(cells) = &body.model.tetrahedra else { return Ok(()) };
    let failed = body.system.sets.iter().find(|set| set.failed_count() > 0).map(|set| set.failed());
    cells.mesh().write_vtk(&cells.displacements(&body.system.nodes.x, &body.model.placement), failed, out)
}

/// Inputs from which a deformed model is written.
#[derive(Clone, Copy)]
pub struct ModelShape<'a> {
    /// The file of the model.
    pub document: &'a ObjDocument,
    /// Placement of the model in the scene.
    pub placement: Placement,
    /// Positions of the vertices at rest, m (n x 3).
    pub original: &'a [Vec3],
    /// Present positions of the vertices, m (n x 3).
    pub present: &'a [Vec3],
    /// Triangles that have failed, which are not written.
    pub failed_triangles: &'a FailedTriangles,
    /// The mesh, if a blade has cut it.
    pub cut: Option<&'a CutMesh>,
    /// Whether it is a part of a body that was split: vertices that no face uses are those of other parts, and are left out.
    pub is_part: bool,
}

/// Pieces of triangles of the document, with the vertices and texture coordinates that the document lacks.
#[derive(Default)]
struct Pieces {
    /// Polygons as rows of positions, texture coordinates and normals, each with its face.
    faces: Vec<(u32, Vec<[u32; 3]>)>,
    /// Vertices of the body that are new rows, in their order.
    new: Vec<u32>,
    /// New texture coordinates.
    texcoords: Vec<[f64; 2]>,
}

/// A written model.
pub(crate) struct WrittenModel {
    /// Text of the file.
    pub bytes: Vec<u8>,
    /// Row of each vertex of the body in the file, from 0; [`NO_ROW`] for a vertex that the file does not have.
    pub row_of: Vec<u32>,
}

impl<'a> ModelShape<'a> {
    /// The shape of a body as it is now.
    pub fn of(body: &'a Body) -> Self {
        let model = &body.model;
        Self {
            document: &model.document,
            placement: model.placement,
            original: &model.surface.points,
            present: &body.skin.x,
            failed_triangles: &body.failed_triangles,
            cut: body.cut.as_deref().filter(|mesh| mesh.depth() > 0),
            is_part: model.is_part(),
        }
    }

    /// Writes the OBJ document to a file. See [`ModelShape::write`].
    ///
    /// # Errors
    /// Fails for a vertex that cannot be written and with the error of the file system, each with the path.
    pub fn write_file(&self, cap_material: &str, path: &Path) -> io::Result<()> {
        let mut file = AtomicFile::create(path)?;
        self.write(cap_material, &mut file).map_err(|error| error_at(path, error))?;
        file.finish()
    }

    /// Writes the OBJ document. Lines of vertices that have not moved, and all other lines, stay byte for byte; normals rotate with the faces
    /// around them. Of faces with triangles that have failed the others are written as triangles,
    /// and vertices that nothing uses any more are left out. Faces that a cut has made inside of the body, or that elements which have failed have brought to light, get the OBJ
    /// material `cap_material`, or `fracture` if that is empty; those of failed elements come last, with their vertices before them.
    ///
    /// # Errors
    /// Fails for a vertex that cannot be written and with the errors of `out`.
    pub fn write(&self, cap_material: &str, out: &mut impl Write) -> io::Result<()> {
        let exposed = self.failed_triangles.exposed();
        if !exposed.triangles().is_empty() {
            return out.write_all(&self.written(cap_material)?.bytes);
        }
        if self.failed_triangles.is_empty() && !self.is_part {
            return self.write_whole(cap_material, out);
        }
        let document = self.without_failed(cap_material)?;
        document.write_faces(&vec![!self.has_nothing_left(); document.face_count()], out)
    }

    /// Writes the OBJ document as [`ModelShape::write`], and tells where the vertices are in it.
    ///
    /// # Errors
    /// Fails for a vertex that cannot be written.
    pub(crate) fn written(&self, cap_material: &str) -> io::Result<WrittenModel> {
        let mut row_of = match self.cut {
            Some(mesh) => mesh.vertex_rows(),
            None => (0..self.present.len() as u32).collect(),
        };
        row_of.resize(self.present.len(), NO_ROW);
        self.pieces()
            .new
            .iter()
            .zip(self.document.positions().len() as u32..)
            .for_each(|(v, row)| row_of[*v as usize] = row);
        let mut bytes = Vec::new();
        let is_whole = self.failed_triangles.is_empty() && !self.is_part;
        if is_whole && self.failed_triangles.exposed().triangles().is_empty() {
            self.write_whole(cap_material, &mut bytes)?;
            return Ok(WrittenModel { bytes, row_of });
        }
        let document = self.without_failed(cap_material)?;
        let is_kept = vec![!self.has_nothing_left(); document.face_count()];
        document.write_faces(&is_kept, &mut bytes)?;
        let kept = document.kept_vertices(&is_kept);
        let rows = kept.iter().filter(|row| **row != NO_ROW).count() as u32;
        row_of.iter_mut().for_each(|row| *row = kept.get(*row as usize).copied().unwrap_or(NO_ROW));
        self.write_exposed(cap_material, rows, &mut row_of, &mut bytes)?;
        Ok(WrittenModel { bytes, row_of })
    }

    /// Appends the faces that failed elements have exposed, with those of their vertices that the file lacks. The file has `rows` vertices; `row_of` receives
    /// the rows of the new ones.
    fn write_exposed(&self, cap_material: &str, rows: u32, row_of: &mut [u32], out: &mut Vec<u8>) -> io::Result<()> {
        let exposed = self.failed_triangles.exposed();
        // Pieces of faces of the document have been written with them.
        let is_written = |of: &Option<u32>| self.cut.is_none() && of.is_some();
        let triangles = exposed.triangles().iter().zip(exposed.pieces_of()).filter(|(_, of)| !is_written(of));
        let triangles: Vec<[u32; 3]> = triangles.map(|(corners, _)| *corners).collect();
        if triangles.is_empty() {
            return Ok(());
        }
        if out.last().is_some_and(|last| *last != b'\n') {
            out.push(b'\n');
        }
        let mut next = rows;
        for &vertex in triangles.iter().flatten() {
            if row_of[vertex as usize] == NO_ROW {
                let point = self.placement.apply_inverse(self.present[vertex as usize]);
                writeln!(out, "v {:?} {:?} {:?}", point.x, point.y, point.z)?;
                row_of[vertex as usize] = next;
                next += 1;
            }
        }
        let name = if cap_material.is_empty() { EXPOSED } else { cap_material };
        write!(out, "g {name}\nusemtl {name}\n")?;
        for corners in &triangles {
            let [mut b, mut c] = [corners[1], corners[2]];
            if self.document.is_mostly_turned_over() {
                (b, c) = (c, b);
            }
            let corners = [corners[0], b, c];
            let [a, b, c] = corners.map(|vertex| row_of[vertex as usize] + 1);
            writeln!(out, "f {a} {b} {c}")?;
        }
        Ok(())
    }

    /// The written document with all rows, without failed triangles.
    fn without_failed(&self, cap_material: &str) -> io::Result<ObjDocument> {
        let mut bytes = Vec::new();
        self.write_whole(cap_material, &mut bytes)?;
        let mut document = ObjDocument::parse(bytes, Path::new("model.obj")).map_err(io::Error::other)?;
        document.weld(self.document.welds());
        Ok(document)
    }

    /// Whether all triangles of the file, or of the cut mesh, have failed, and no piece of one is left.
    fn has_nothing_left(&self) -> bool {
        if self.failed_triangles.is_empty() {
            return false;
        }
        let failed = |t: usize| self.failed_triangles.contains(t as u32);
        match self.cut {
            Some(mesh) => (0..mesh.surface().triangles.len()).all(|t| failed(t) || mesh.is_lid(t as u32)),
            None => {
                let no_piece = self.failed_triangles.exposed().pieces_of().iter().all(Option::is_none);
                no_piece && (0..Surface::from_document(self.document).triangles.len()).all(failed)
            }
        }
    }

    /// The intact triangles of each face of the document that has failed ones, by face. A corner of a triangle is its rows of positions, texture coordinates
    /// and normals.
    fn broken_faces(&self) -> BTreeMap<u32, Vec<Vec<[u32; 3]>>> {
        let mut broken = BTreeMap::new();
        if self.failed_triangles.is_empty() || self.has_nothing_left() {
            return broken;
        }
        let surface = Surface::from_document(self.document);
        let of_face = || surface.face_of.iter().zip(0..);
        for (face, _) in of_face().filter(|(_, triangle)| self.failed_triangles.contains(*triangle)) {
            broken.insert(*face, Vec::new());
        }
        for (face, triangle) in of_face().filter(|(_, triangle)| !self.failed_triangles.contains(*triangle)) {
            let Some(pieces) = broken.get_mut(face) else { continue };
            let corners = self.document.face(*face as usize).map_or(&[][..], |face| face.corners);
            let rows = |v: u32| {
                let corner = corners.iter().find(|corner| corner.v == v);
                let row = |of: fn(&Corner) -> Option<u32>| corner.and_then(of).unwrap_or(NO_ROW);
                [v, row(Corner::vt), row(Corner::vn)]
            };
            pieces.push(surface.triangles[triangle as usize].map(rows).to_vec());
        }
        broken
    }

    /// Pieces of triangles of the document that were partly on failed elements; none after a cut.
    fn pieces(&self) -> Pieces {
        let mut pieces = Pieces::default();
        let exposed = self.failed_triangles.exposed();
        if self.cut.is_some() || exposed.pieces_of().iter().all(Option::is_none) {
            return pieces;
        }
        let surface = Surface::from_document(self.document);
        let (rows, texture_rows) = (self.document.positions().len() as u32, self.document.texcoords().len() as u32);
        let (mut row_of, mut texture_of) = (BTreeMap::new(), BTreeMap::new());
        for (corners, of) in exposed.triangles().iter().zip(exposed.pieces_of()) {
            let Some(of) = *of else { continue };
            let (face, whole) = (surface.face_of[of as usize], surface.triangles[of as usize]);
            let given = self.document.face(face as usize).map_or(&[][..], |face| face.corners);
            let texture = whole.map(|v| given.iter().find(|corner| corner.v == v).and_then(Corner::vt));
            let at = |v: u32| self.original[v as usize];
            let polygon = corners.map(|v| {
                if v < rows {
                    let corner = whole.iter().position(|corner| *corner == v);
                    return [v, corner.and_then(|corner| texture[corner]).unwrap_or(NO_ROW), NO_ROW];
                }
                let row = *row_of.entry(v).or_insert_with(|| {
                    pieces.new.push(v);
                    rows + pieces.new.len() as u32 - 1
                });
                let [Some(a), Some(b), Some(c)] = texture else { return [row, NO_ROW, NO_ROW] };
                // By face, for a seam of the texture may go along an edge.
                let texture_row = *texture_of.entry((v, of)).or_insert_with(|| {
                    let bary = closest_point(at(v), whole.map(at)).bary;
                    let uv = [a, b, c].map(|row| self.document.texcoords()[row as usize]);
                    let mean = [0, 1].map(|axis| (0..3).map(|i| bary[i] * uv[i][axis]).sum());
                    pieces.texcoords.push(mean);
                    texture_rows + pieces.texcoords.len() as u32 - 1
                });
                [row, texture_row, NO_ROW]
            });
            let has_texture = polygon.iter().all(|corner| corner[1] != NO_ROW);
            let polygon = polygon.map(|[v, vt, vn]| [v, if has_texture { vt } else { NO_ROW }, vn]);
            pieces.faces.push((face, polygon.to_vec()));
        }
        pieces
    }

    /// Writes the document with all rows, and without triangles that have failed.
    fn write_whole(&self, cap_material: &str, out: &mut impl Write) -> io::Result<()> {
        let other = |error: WriteError| io::Error::other(error.to_string());
        let Self { document, placement, original, present, failed_triangles, cut, is_part: _ } = *self;
        // A document has faces: those of one of which nothing is left are left out when it is read again.
        let is_empty = self.has_nothing_left();
        if let Some(mesh) = cut {
            return mesh
                .write_without(
                    |t| !is_empty && failed_triangles.contains(t),
                    document,
                    &present[..mesh.surface().points.len()],
                    cap_material,
                    out,
                )
                .map_err(other);
        }
        let points = placement.bring_back(document.positions(), original, present);
        let (mut faces, pieces) = (self.broken_faces(), self.pieces());
        for (face, polygon) in pieces.faces {
            faces.entry(face).or_default().push(polygon);
        }
        let positions: Vec<Vec3> = pieces.new.iter().map(|v| placement.apply_inverse(present[*v as usize])).collect();
        let patch = Patch { faces, positions: &positions, texcoords: &pieces.texcoords, ..Patch::default() };
        document.write_deformed_patched(&points, patch, out).map_err(other)
    }
}
