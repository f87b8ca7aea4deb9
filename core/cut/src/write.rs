//! The cut model as a document.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::iter::zip;

use super::mesh::CutMesh;
use super::record::NONE;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::obj::{CUT_BORDERS, Patch, ShadedCorner, TurnedNormals, WriteError};
use pliant_mesh::{ObjDocument, Surface};

/// Group and material of cut surfaces, unless a name is given.
pub const MATERIAL: &str = "pliant_cut";

impl CutMesh {
    /// Writes the cut model with all of its triangles, see [`CutMesh::write_without`].
    ///
    /// # Errors
    /// Those of [`ObjDocument::write`].
    pub fn write(
        &self,
        document: &ObjDocument,
        points: &[Vec3],
        material: &str,
        out: &mut impl Write,
    ) -> Result<(), WriteError> {
        self.write_without(|_| false, document, points, material, out)
    }

    /// Writes the cut model without the triangles that have failed: of a face of which some have failed the others are written. Rows of vertices that nothing uses any more stay. `document` is the one the mesh was made from, `points` (n x 3, m) are the current positions of the vertices of
    /// [`CutMesh::surface`]. Normals rotate with the triangles that refer to them; a row whose corners rotate differently is duplicated.
    ///
    /// A mesh without cuts and displacements is written back byte for byte. Uncut faces keep their lines; cut faces become triangles with the
    /// same group, object, material and smoothing; cut surfaces get a group and a material of the name `material`. Where a surface without an inside was cut the
    /// comment [`CUT_BORDERS`] comes last.
    ///
    /// # Errors
    /// Those of [`ObjDocument::write`].
    pub fn write_without(
        &self,
        has_failed: impl Fn(u32) -> bool,
        document: &ObjDocument,
        points: &[Vec3],
        material: &str,
        out: &mut impl Write,
    ) -> Result<(), WriteError> {
        let chosen = Chosen { number: self.vertex_rows(), has_failed: &has_failed, is_divided: &|_| false };
        self.write_chosen(&chosen, document, points, material, out)
    }

    /// Writes what is chosen of the model, otherwise as [`CutMesh::write_without`].
    pub(super) fn write_chosen(
        &self,
        chosen: &Chosen<'_>,
        document: &ObjDocument,
        points: &[Vec3],
        material: &str,
        out: &mut impl Write,
    ) -> Result<(), WriteError> {
        let original = Surface::from_document(document);
        let count = original.points.len();
        same("document's v", original.points.len(), self.uncut.points)?;
        same("points", points.len(), self.surface.points.len())?;
        let own = self.placement.bring_back(&original.points, &self.surface.points[..count], points);
        let number = &chosen.number;
        let visible = zip(&points[count..], &number[count..]).filter(|(_, number)| **number != NONE);
        let new: Vec<Vec3> = visible.map(|(&point, _)| self.placement.apply_inverse(point)).collect();
        let turned = self.turned_normals(points);
        let (own_normals, new_normals) = turned.rows.split_at(self.uncut.normals);
        let new_normals = [new_normals, &turned.added].concat();
        let patch = Patch {
            positions: &new,
            colours: &[],
            texcoords: &self.texcoords[self.uncut.texcoords..],
            normals: &new_normals,
            faces: self.changed_faces(chosen, document, &original, &turned),
            added: (0..self.surface.triangles.len() as u32)
                .filter(|&t| self.is_cap(t) && !(chosen.has_failed)(t))
                .map(|t| self.rows(t, number, &turned))
                .collect(),
            name: material,
        };
        let has_slits = self.depth() > 0 && self.open_triangles() > 0 && !document.has_cut_borders();
        document.write_patched(&own, Some(own_normals), &patch, out)?;
        if has_slits {
            let ends_a_line = document.bytes().ends_with(b"\n");
            writeln!(out, "{}{CUT_BORDERS}", if ends_a_line { "" } else { "\n" })?;
        }
        Ok(())
    }

    /// Row of each vertex (n) in the file that [`CutMesh::write`] writes; `u32::MAX` for vertices that belong to lids alone, which have none.
    pub fn vertex_rows(&self) -> Vec<u32> {
        let mut number = vec![NONE; self.surface.points.len()];
        number[..self.uncut.points].fill(0);
        for triangle in (0..self.surface.triangles.len() as u32).filter(|&t| !self.is_lid(t)) {
            self.surface.triangles[triangle as usize].iter().for_each(|&vertex| number[vertex as usize] = 0);
        }
        let written = number.iter_mut().filter(|number| **number != NONE);
        written.enumerate().for_each(|(row, number)| *number = row as u32);
        number
    }

    /// Replacements of all changed faces, none for those that have failed. A face that only got copies of its vertices stays one face.
    fn changed_faces(
        &self,
        Chosen { number, has_failed, is_divided, .. }: &Chosen<'_>,
        document: &ObjDocument,
        original: &Surface,
        turned: &TurnedNormals,
    ) -> BTreeMap<u32, Vec<Vec<[u32; 3]>>> {
        let mut changed: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let before = original.triangles.len();
        for (number, (now, then)) in zip(&self.surface.triangles, &original.triangles).enumerate() {
            let is_parted = || self.shaded(number as u32).iter().any(|corner| turned.moved.contains_key(corner));
            if now != then || is_parted() {
                changed.insert(original.face_of[number], Vec::new());
            }
        }
        let split =
            (before as u32..self.surface.triangles.len() as u32).filter(|&t| !self.is_cap(t) && !self.is_lid(t));
        let split: BTreeSet<u32> = split.map(|t| self.surface.face_of[t as usize]).collect();
        changed.extend(split.iter().map(|&face| (face, Vec::new())));
        let of_file = zip(&self.surface.face_of, 0..).filter(|(_, t)| !self.is_cap(*t) && !self.is_lid(*t));
        let broken: BTreeSet<u32> = of_file.filter(|(_, t)| has_failed(*t)).map(|(face, _)| *face).collect();
        changed.extend(broken.iter().map(|&face| (face, Vec::new())));
        let divided = original.face_of.iter().filter(|face| is_divided(**face));
        changed.extend(divided.map(|&face| (face, Vec::new())));
        for (triangle, face) in self.surface.face_of.iter().enumerate() {
            if let Some(triangles) = changed.get_mut(face) {
                triangles.push(triangle as u32);
            }
        }
        let polygons = |(face, triangles): (u32, Vec<u32>)| {
            let whole = if split.contains(&face) || broken.contains(&face) || is_divided(face) {
                None
            } else {
                self.renamed(document, original, face, &triangles, number, turned)
            };
            let left = || triangles.iter().filter(|t| !has_failed(**t));
            let pieces = || left().map(|&t| self.rows(t, number, turned).to_vec()).collect();
            (face, whole.map_or_else(pieces, |polygon| vec![polygon]))
        };
        changed.into_iter().map(polygons).collect()
    }

    /// A face with the present vertices of its triangles; `None` if the triangles have different copies of one vertex.
    fn renamed(
        &self,
        document: &ObjDocument,
        original: &Surface,
        face: u32,
        triangles: &[u32],
        number: &[u32],
        turned: &TurnedNormals,
    ) -> Option<Vec<[u32; 3]>> {
        let mut name: BTreeMap<u32, u32> = BTreeMap::new();
        for &triangle in triangles {
            let (then, now) = (original.triangles[triangle as usize], self.surface.triangles[triangle as usize]);
            for (then, now) in zip(then, now) {
                if *name.entry(then).or_insert(now) != now {
                    return None;
                }
            }
        }
        let corners = document.face(face as usize)?.corners.iter();
        corners
            .map(|c| {
                let vertex = *name.get(&c.v)?;
                let row = row_of(turned, [vertex, c.vn().unwrap_or(NONE)]);
                Some([number[vertex as usize], c.vt().unwrap_or(NONE), row])
            })
            .collect()
    }

    /// Position, texture coordinate and normal of the corners of a triangle.
    fn rows(&self, triangle: u32, number: &[u32], turned: &TurnedNormals) -> [[u32; 3]; 3] {
        let (record, shaded) = (self.triangle(triangle), self.shaded(triangle));
        [0, 1, 2].map(|corner| {
            [number[record.corners[corner] as usize], record.texture[corner], row_of(turned, shaded[corner])]
        })
    }
}

/// What is written of a model.
pub(super) struct Chosen<'a> {
    /// Row of each vertex (n) in the file; [`NONE`] for one that is not written.
    pub number: Vec<u32>,
    /// Whether a triangle is left out.
    pub has_failed: &'a dyn Fn(u32) -> bool,
    /// Whether a face that no cut has divided is written as triangles.
    pub is_divided: &'a dyn Fn(u32) -> bool,
}

/// The row of a corner's normal.
fn row_of(turned: &TurnedNormals, corner: ShadedCorner) -> u32 {
    turned.moved.get(&corner).copied().unwrap_or(corner[1])
}

fn same(entity: &'static str, found: usize, expected: usize) -> Result<(), WriteError> {
    if found == expected { Ok(()) } else { Err(WriteError::Length { entity, found, expected }) }
}
