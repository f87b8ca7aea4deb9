//! Subdivision of a document: the same shape with four times the faces.

use std::collections::{BTreeMap, HashMap};

use super::{NONE, ObjDocument, ObjError, Patch};
use crate::geometry::Vec3;
use crate::triangulate::{is_convex, triangulate};

/// Rows of one kind that a subdivision adds: middles of two rows, and of the four of a quad.
struct NewRows<T> {
    first: u32,
    rows: Vec<T>,
    between: HashMap<[u32; 2], u32>,
}

impl<T> NewRows<T> {
    fn new(known: usize) -> Self {
        Self { first: known as u32, rows: Vec::new(), between: HashMap::new() }
    }

    /// The row between two rows: one of them if they are the same, none if one is missing.
    fn middle(&mut self, [a, b]: [u32; 2], make: impl FnOnce() -> T) -> u32 {
        if a == NONE || b == NONE {
            return NONE;
        }
        if a == b {
            return a;
        }
        let next = self.first + self.rows.len() as u32;
        let (row, is_new) = match self.between.entry([a.min(b), a.max(b)]) {
            std::collections::hash_map::Entry::Occupied(known) => (*known.get(), false),
            std::collections::hash_map::Entry::Vacant(free) => (*free.insert(next), true),
        };
        if is_new {
            self.rows.push(make());
        }
        row
    }

    /// A row of the quad whose rows are `of`: one of them if all are the same, none if one is missing.
    fn centre(&mut self, of: [u32; 4], make: impl FnOnce() -> T) -> u32 {
        if of.contains(&NONE) {
            return NONE;
        }
        if of.iter().all(|row| *row == of[0]) {
            return of[0];
        }
        self.rows.push(make());
        self.first + self.rows.len() as u32 - 1
    }
}

/// The rows of a document with those that a subdivision adds.
struct Subdivision<'a> {
    document: &'a ObjDocument,
    positions: NewRows<Vec3>,
    /// Whether every vertex has a colour.
    is_coloured: bool,
    colours: Vec<[f64; 3]>,
    texcoords: NewRows<[f64; 2]>,
    normals: NewRows<Vec3>,
}

impl ObjDocument {
    /// Divides every face into four: a triangle at the middles of its sides, a convex quad at these and its centre. Polygons with more corners, and
    /// quads that are not convex, are triangulated first. Vertices keep their places and indices, and new ones have the mean of what their neighbours
    /// have: colours, texture coordinates, unit normals. Groups, objects, materials and smoothing stay, as do all other lines.
    ///
    /// # Errors
    /// [`ObjError`] if the result has 4 GiB and more.
    pub fn subdivided(&self) -> Result<Self, ObjError> {
        let mut of = Subdivision {
            document: self,
            positions: NewRows::new(self.positions().len()),
            is_coloured: (0..self.positions().len()).all(|vertex| self.colour_of_vertex(vertex).is_some()),
            colours: Vec::new(),
            texcoords: NewRows::new(self.texcoords().len()),
            normals: NewRows::new(self.normals().len()),
        };
        let (mut faces, mut turned_over, mut count) = (BTreeMap::new(), Vec::new(), 0);
        for face in 0..self.face_count() as u32 {
            let pieces = of.face(face as usize);
            let numbers = count..count + pieces.len() as u32;
            count = numbers.end;
            turned_over.extend(numbers.filter(|_| self.is_turned_over(face)));
            faces.insert(face, pieces);
        }
        let patch = Patch {
            positions: &of.positions.rows,
            colours: &of.colours,
            texcoords: &of.texcoords.rows,
            normals: &of.normals.rows,
            faces,
            ..Patch::default()
        };
        let mut bytes = Vec::with_capacity(4 * self.bytes().len());
        let written = self.write_patched(self.positions(), None, &patch, &mut bytes);
        written.map_err(|source| ObjError::Read { file: self.name().into(), source: std::io::Error::other(source) })?;
        let mut divided = Self::parse(bytes, self.name())?;
        divided.weld(&self.welds);
        divided.turn_over(&turned_over);
        Ok(divided)
    }

    /// Number of faces of [`Self::subdivided`].
    pub fn faces_subdivided(&self) -> usize {
        let pieces = |face: usize| match self.corners(face).len() {
            3 => 4,
            4 if self.is_convex_quad(face) => 4,
            corners => 4 * (corners - 2),
        };
        (0..self.face_count()).map(pieces).sum()
    }

    /// Whether a face is a quad that is divided as a whole.
    fn is_convex_quad(&self, face: usize) -> bool {
        match self.corners(face) {
            [a, b, c, d] => is_convex(&[a, b, c, d].map(|corner| self.positions()[corner.v as usize])),
            _ => false,
        }
    }

    /// The longest side of a face, file units.
    pub fn longest_side(&self) -> f64 {
        let sides = |face: usize| {
            let corners = self.corners(face);
            let next = corners.iter().cycle().skip(1);
            let length = |(a, b): (&super::Corner, &super::Corner)| {
                (self.positions()[a.v as usize] - self.positions()[b.v as usize]).norm()
            };
            corners.iter().zip(next).map(length).fold(0.0, f64::max)
        };
        (0..self.face_count()).map(sides).fold(0.0, f64::max)
    }
}

impl Subdivision<'_> {
    /// The pieces of a face.
    fn face(&mut self, face: usize) -> Vec<Vec<[u32; 3]>> {
        let corners: Vec<[u32; 3]> = self.document.corners(face).iter().map(|c| [c.v, c.vt, c.vn]).collect();
        if let &[a, b, c, d] = &corners[..]
            && self.document.is_convex_quad(face)
        {
            return self.quad([a, b, c, d]);
        }
        let places: Vec<Vec3> = corners.iter().map(|c| self.document.positions()[c[0] as usize]).collect();
        let mut pieces = Vec::new();
        triangulate(&places, &mut pieces);
        pieces.into_iter().flat_map(|piece| self.triangle(piece.map(|corner| corners[corner]))).collect()
    }

    fn triangle(&mut self, [a, b, c]: [[u32; 3]; 3]) -> [Vec<[u32; 3]>; 4] {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|pair| self.middle(pair));
        [vec![a, ab, ca], vec![ab, b, bc], vec![ca, bc, c], vec![ab, bc, ca]]
    }

    fn quad(&mut self, corners: [[u32; 3]; 4]) -> Vec<Vec<[u32; 3]>> {
        let side = |i: usize| [corners[i], corners[(i + 1) % 4]];
        let middles = [0, 1, 2, 3].map(|i| self.middle(side(i)));
        let centre = self.centre(corners);
        (0..4).map(|i| vec![corners[i], middles[i], centre, middles[(i + 3) % 4]]).collect()
    }

    /// The corner between two corners.
    fn middle(&mut self, [a, b]: [[u32; 3]; 2]) -> [u32; 3] {
        let document = self.document;
        let pair = |kind: usize| [a[kind], b[kind]];
        let known = self.positions.rows.len();
        let v = self.positions.middle(pair(0), || mean(&pair(0).map(|row| document.positions()[row as usize])));
        if self.positions.rows.len() > known {
            self.colour(&pair(0));
        }
        let vt =
            self.texcoords.middle(pair(1), || mean_texcoord(&pair(1).map(|row| document.texcoords()[row as usize])));
        let vn = self.normals.middle(pair(2), || mean_normal(&pair(2).map(|row| document.normals()[row as usize])));
        [v, vt, vn]
    }

    /// The corner in the middle of a quad.
    fn centre(&mut self, corners: [[u32; 3]; 4]) -> [u32; 3] {
        let document = self.document;
        let [v, vt, vn] = [0, 1, 2].map(|kind| corners.map(|corner| corner[kind]));
        let place = || mean(&v.map(|row| document.positions()[row as usize]));
        let at = self.positions.centre(v, place);
        self.colour(&v);
        let texcoord = || mean_texcoord(&vt.map(|row| document.texcoords()[row as usize]));
        let normal = || mean_normal(&vn.map(|row| document.normals()[row as usize]));
        [at, self.texcoords.centre(vt, texcoord), self.normals.centre(vn, normal)]
    }

    /// Adds the mean colour of vertices of the document, if they have colours.
    fn colour(&mut self, of: &[u32]) {
        if self.is_coloured {
            let each = of.iter().filter_map(|vertex| self.document.colour_of_vertex(*vertex as usize));
            let sum = each.fold([0.0; 3], |sum: [f64; 3], colour| std::array::from_fn(|c| sum[c] + colour[c]));
            self.colours.push(sum.map(|c| c / of.len() as f64));
        }
    }
}

fn mean(of: &[Vec3]) -> Vec3 {
    of.iter().sum::<Vec3>() / of.len() as f64
}

fn mean_texcoord(of: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|c| of.iter().map(|row| row[c]).sum::<f64>() / of.len() as f64)
}

/// Mean direction; the first one where directions cancel.
fn mean_normal(of: &[Vec3]) -> Vec3 {
    let sum: Vec3 = of.iter().map(|n| n.try_normalize(0.0).unwrap_or(*n)).sum();
    sum.try_normalize(1e-12).unwrap_or(of[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{document, models};
    use crate::{Surface, check};

    #[test]
    fn models_keep_their_shape_and_what_their_faces_have() {
        for model in models(8, 5) {
            let coarse = document(&model.text);
            let fine = coarse.subdivided().unwrap();
            let what = &model.name;
            assert_eq!(fine.face_count(), coarse.faces_subdivided(), "{what}");
            assert_eq!(&fine.positions()[..coarse.positions().len()], coarse.positions(), "{what}");
            let [before, after] = [&coarse, &fine].map(Surface::from_document);
            // Only quads that are not flat change, to the mean of both ways to split them.
            let flat = coarse.faces().all(|face| face.corners.len() == 3);
            let tolerance = if flat { 1e-12 } else { 0.02 };
            let [area_before, area_after]: [f64; 2] = [&before, &after].map(|surface| surface.areas().iter().sum());
            assert!((area_after / area_before - 1.0).abs() < tolerance, "{what}: {area_before} {area_after}");
            // Defects of a face are those of its pieces, so there are none where there were none.
            if check(&before, &coarse).is_empty() {
                assert_eq!(check(&after, &fine), [], "{what}");
            }
            assert!(fine.longest_side() < 0.75 * coarse.longest_side() || coarse.faces().any(|f| f.corners.len() > 4));
            let mut at = 0;
            for face in coarse.faces() {
                let pieces = if face.corners.len() < 5 { 4 } else { 4 * (face.corners.len() - 2) };
                for piece in (at..at + pieces).map(|i| fine.face(i).unwrap()) {
                    assert_eq!(piece.attributes, face.attributes, "{what}");
                    let has = |corner: &super::super::Corner| (corner.vt().is_some(), corner.vn().is_some());
                    assert!(piece.corners.iter().all(|c| has(c) == has(&face.corners[0])), "{what}");
                }
                at += pieces;
            }
        }
    }

    #[test]
    fn new_vertices_have_the_mean_of_their_neighbours() {
        let text = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 2 0 0 0 1 0\nv 2 2 0 0 0 1\nv 0 2 0 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\ng top\nusemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
        let fine = document(text).subdivided().unwrap();
        assert_eq!(fine.face_count(), 4);
        let centre = fine.positions().iter().position(|p| *p == Vec3::new(1.0, 1.0, 0.0)).unwrap();
        assert_eq!(fine.colour_of_vertex(centre), Some([0.5, 0.5, 0.5]));
        assert!(fine.texcoords().contains(&[0.5, 0.5]) && fine.texcoords().len() == 9);
        assert_eq!(fine.normals().len(), 1, "a normal that all corners share stays one");
        assert_eq!((fine.groups(), fine.materials()), (&["top".to_owned()][..], &["red".to_owned()][..]));
    }

    #[test]
    fn a_quad_that_is_not_convex_is_not_turned_over() {
        // An arrow head.
        let coarse = document("v 0 0 0\nv 2 2 0\nv 0 1 0\nv -2 2 0\nf 1 2 3 4\n");
        let fine = coarse.subdivided().unwrap();
        assert_eq!(fine.face_count(), coarse.faces_subdivided());
        let surface = Surface::from_document(&fine);
        assert_eq!(fine.face_count(), 8, "it is cut into two triangles, which are divided");
        let up = surface.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| surface.point(v));
            (b - a).cross(&(c - a)).z
        });
        assert!(up.clone().all(|area| area > 0.0), "{:?}", up.collect::<Vec<_>>());
        assert!((surface.areas().iter().sum::<f64>() - 2.0).abs() < 1e-12);
    }
}
