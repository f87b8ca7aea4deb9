//! A lossless OBJ document: the original bytes with the parsed content.
//!
//! Only faces that a cut or new normals have changed are printed again. Writing copies the bytes and replaces the coordinates of moved vertices, so comments,
//! colours, quads, groups, line ends and unknown statements are preserved.

mod cursor;
mod error;
mod names;
mod normals;
mod number;
mod orient;
mod parse;
mod part;
mod patch;
mod subdivide;
#[cfg(test)]
mod tests;
mod weld;
mod write;

use std::path::{Path, PathBuf};

use crate::geometry::Vec3;
use crate::read::{MODEL_LIMIT, read_file};

pub use error::{ObjError, ObjProblem, WriteError};
pub use normals::{ShadedCorner, TurnedNormals};
pub use patch::Patch;
pub use weld::CUT_BORDERS;

/// An OBJ file with its parsed content. It has at least one vertex and one face.
#[derive(Clone, Debug)]
pub struct ObjDocument {
    name: PathBuf,
    bytes: Vec<u8>,
    parsed: Parsed,
    /// Vertices that faces no longer mean, each with the one in its place.
    welds: Vec<[u32; 2]>,
    /// Faces whose corners run the other way round than in the file, ascending.
    turned_over: Vec<u32>,
}

/// One corner of a face: indices from 0 into the document's positions, texture coordinates and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Index into [`ObjDocument::positions`].
    pub v: u32,
    vt: u32,
    vn: u32,
}

/// One `f` line.
#[derive(Clone, Copy, Debug)]
pub struct Face<'a> {
    /// Corners in the order of the file: at least 3, with distinct vertices.
    pub corners: &'a [Corner],
    /// Line in the file, from 1.
    pub line: u32,
    /// The group, object, material and smoothing in force at this line.
    pub attributes: Attributes,
}

/// Attributes of faces by `g`, `o`, `usemtl` and `s` lines, as indices into the document's tables of names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attributes {
    /// Index into [`ObjDocument::groups`]; `None` before the first `g`.
    pub group: Option<u32>,
    /// Index into [`ObjDocument::objects`]; `None` before the first `o`.
    pub object: Option<u32>,
    /// Index into [`ObjDocument::materials`]; `None` before the first `usemtl`.
    pub material: Option<u32>,
    /// Smoothing group; 0 is off.
    pub smoothing: u32,
}

/// Parsed content. Offsets and indices are `u32`, so a document must be smaller than 4 GiB.
#[derive(Clone, Debug, Default)]
struct Parsed {
    positions: Vec<Vec3>,         // file units (n x 3)
    position_at: Vec<u32>,        // byte offset of the v line (n)
    texcoords: Vec<[f64; 2]>,     // u, v (t x 2)
    normals: Vec<Vec3>,           // as in the file, any length (k x 3)
    normal_at: Vec<u32>,          // byte offset of the vn line (k)
    corners: Vec<Corner>,         // face after face (c)
    face_start: Vec<u32>,         // first corner of each face, then c (f + 1)
    face_line: Vec<u32>,          // from 1 (f)
    runs: Vec<(u32, Attributes)>, // first face of each run of equal attributes
    groups: Vec<String>,
    objects: Vec<String>,
    materials: Vec<String>,
    libraries: Vec<String>,
}

const NONE: u32 = u32::MAX; // an absent vt or vn, which takes less memory than Option<u32>

impl Corner {
    /// Index into [`ObjDocument::texcoords`]; `None` if the corner has none.
    pub fn vt(&self) -> Option<u32> {
        (self.vt != NONE).then_some(self.vt)
    }

    /// Index into [`ObjDocument::normals`]; `None` if the corner has none.
    pub fn vn(&self) -> Option<u32> {
        (self.vn != NONE).then_some(self.vn)
    }
}

impl ObjDocument {
    /// Reads the document at `path`.
    ///
    /// # Errors
    /// [`ObjError`] if the file cannot be read or [`ObjDocument::parse`] refuses it.
    pub fn read(path: &Path) -> Result<Self, ObjError> {
        let bytes = read_file(path, MODEL_LIMIT).map_err(|source| ObjError::Read { file: path.into(), source })?;
        Self::parse(bytes, path)
    }

    /// Parses the document in `bytes`; `name` is used in messages and to find material libraries in the same folder.
    ///
    /// # Errors
    /// [`ObjError`] with file, line, entity and token for numbers that are not finite, indices out of range, faces with fewer than 3 corners or a repeated vertex,
    /// documents without vertices or faces, and NUL bytes.
    pub fn parse(bytes: Vec<u8>, name: &Path) -> Result<Self, ObjError> {
        match parse::parse(&bytes) {
            Ok(parsed) => Ok(Self { name: name.into(), bytes, parsed, welds: Vec::new(), turned_over: Vec::new() }),
            Err((line, problem)) => Err(ObjError::Line { file: name.into(), line, problem }),
        }
    }

    /// The path given to [`ObjDocument::read`] or [`ObjDocument::parse`].
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// The original bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Vertex positions in the order of the `v` lines, file units (n x 3).
    pub fn positions(&self) -> &[Vec3] {
        &self.parsed.positions
    }

    /// Texture coordinates in the order of the `vt` lines (t x 2); a missing second one is 0.
    pub fn texcoords(&self) -> &[[f64; 2]] {
        &self.parsed.texcoords
    }

    /// Texture coordinates of a vertex as a corner of a face; `None` if that corner has none.
    pub fn texcoord_at(&self, face: u32, vertex: u32) -> Option<[f64; 2]> {
        let row = self.face(face as usize)?.corners.iter().find(|corner| corner.v == vertex)?.vt()?;
        self.texcoords().get(row as usize).copied()
    }

    /// Normals in the order of the `vn` lines, not normalised (k x 3).
    pub fn normals(&self) -> &[Vec3] {
        &self.parsed.normals
    }

    /// Number of faces, f.
    pub fn face_count(&self) -> usize {
        self.parsed.face_line.len()
    }

    /// The face with this index; `None` past the last.
    pub fn face(&self, index: usize) -> Option<Face<'_>> {
        let line = *self.parsed.face_line.get(index)?;
        let run = self.parsed.runs.partition_point(|&(first, _)| first as usize <= index);
        Some(Face { corners: self.corners(index), line, attributes: self.parsed.runs[run - 1].1 })
    }

    /// All faces in the order of the file.
    pub fn faces(&self) -> impl Iterator<Item = Face<'_>> {
        (0..self.face_count()).filter_map(|index| self.face(index))
    }

    /// Distinct names of `g` lines; a line with several groups counts as one name.
    pub fn groups(&self) -> &[String] {
        &self.parsed.groups
    }

    /// Distinct names of `o` lines.
    pub fn objects(&self) -> &[String] {
        &self.parsed.objects
    }

    /// Distinct names of `usemtl` lines.
    pub fn materials(&self) -> &[String] {
        &self.parsed.materials
    }

    /// Distinct arguments of `mtllib` lines.
    pub fn libraries(&self) -> &[String] {
        &self.parsed.libraries
    }

    /// Red, green and blue of vertex `index`, where its line has them behind the position (`v x y z r g b`); 0 to 1 as most programs write
    /// them, and not checked.
    pub fn colour_of_vertex(&self, index: usize) -> Option<[f64; 3]> {
        let at = *self.parsed.position_at.get(index)? as usize;
        let line = self.bytes[at..].split(|b| *b == b'\n' || *b == b'\r').next()?;
        let words = std::str::from_utf8(line).ok()?.split('#').next()?.split_ascii_whitespace();
        let numbers: Vec<f64> = words.skip(1).map(str::parse).collect::<Result<_, _>>().ok()?;
        match numbers[..] {
            [_, _, _, red, green, blue] => Some([red, green, blue]),
            _ => None,
        }
    }

    /// The line, from 1, of the vertex `index`; `None` past the last. The cost is linear in the file, so it is for messages only.
    pub fn line_of_vertex(&self, index: usize) -> Option<u32> {
        let at = *self.parsed.position_at.get(index)? as usize;
        Some(cursor::Cursor::new(&self.bytes).line_at(at))
    }

    /// Vertex and row of the normal at each corner of each face.
    pub fn shaded_faces(&self) -> Vec<Vec<ShadedCorner>> {
        (0..self.face_count()).map(|face| self.corners(face).iter().map(|c| [c.v, c.vn]).collect()).collect()
    }

    fn corners(&self, face: usize) -> &[Corner] {
        let [from, to] = [face, face + 1].map(|end| self.parsed.face_start[end] as usize);
        &self.parsed.corners[from..to]
    }
}
