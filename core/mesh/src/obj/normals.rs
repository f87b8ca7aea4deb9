//! Normals of a deformed surface.
//!
//! The normals of a file carry information that the faces do not (smoothing, hard edges), so they are rotated with the surface instead of computed again. A row
//! that several corners share is duplicated if they rotate differently.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{Matrix3, UnitQuaternion};

use super::write::same_bits;
use crate::geometry::Vec3;

/// A corner of a face: its vertex, and the row of its normal, or `u32::MAX` for none.
pub type ShadedCorner = [u32; 2];

/// A use of a row of normals by a corner; ordered by row, then by vertex.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Naming {
    row: u32,
    vertex: u32,
    face: u32,
    /// Index of the corner in its face.
    place: u32,
}

/// Rows of normals after a deformation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TurnedNormals {
    /// The rotated original rows (k x 3).
    pub rows: Vec<Vec3>,
    /// Additional rows for corners that shared a row and rotate differently.
    pub added: Vec<Vec3>,
    /// Corners that use another row than before.
    pub moved: BTreeMap<ShadedCorner, u32>,
}

impl TurnedNormals {
    /// Rotates `normals` (k x 3, any length) with the faces that use them, whose vertices moved from `rest` to `deformed` (n x 3).
    ///
    /// At each vertex, one deformation gradient is fitted by least squares to the edges and normals of the faces that use a row. The row is multiplied by its cofactor
    /// matrix, which is exact for linear deformations, and rescaled to its length. It keeps every bit if no such face has a moved vertex.
    pub fn new(normals: &[Vec3], faces: &[Vec<ShadedCorner>], rest: &[Vec3], deformed: &[Vec3]) -> Self {
        let is_moved = |v: u32| !same_bits(&rest[v as usize], &deformed[v as usize]);
        let moved: Vec<bool> = faces.iter().map(|face| face.iter().any(|c| is_moved(c[0]))).collect();
        let mut corners: Vec<Naming> = Vec::new();
        for (f, face) in faces.iter().enumerate() {
            let shaded = face.iter().enumerate().filter(|(_, corner)| corner[1] != super::NONE);
            corners.extend(shaded.map(|(at, &[vertex, row])| Naming { row, vertex, face: f as u32, place: at as u32 }));
        }
        corners.sort_unstable();
        let mut turned = Self { rows: normals.to_vec(), ..Self::default() };
        for of_row in corners.chunk_by(|a, b| a.row == b.row) {
            if of_row.iter().any(|corner| moved[corner.face as usize]) {
                turned.turn_row(of_row, &moved, |corners| fan(corners, faces, rest, deformed));
            }
        }
        turned
    }

    /// Rotates one row at each vertex. The original row is kept for corners that do not rotate, otherwise for the first vertex.
    fn turn_row(&mut self, of_row: &[Naming], moved: &[bool], fan: impl Fn(&[Naming]) -> Fan) {
        let row = of_row[0].row;
        let normal = self.rows[row as usize];
        let mut known: HashMap<[i64; 3], u32> = HashMap::new();
        if of_row.iter().any(|corner| !moved[corner.face as usize]) {
            known.insert(rounded(normal), row);
        }
        for at_vertex in of_row.chunk_by(|a, b| a.vertex == b.vertex) {
            if !at_vertex.iter().any(|corner| moved[corner.face as usize]) {
                known.entry(rounded(normal)).or_insert(row);
                continue;
            }
            let now = fan(at_vertex).turn(normal);
            let next = self.rows.len() as u32 + self.added.len() as u32;
            let is_first = known.is_empty();
            let new = *known.entry(rounded(now)).or_insert(if is_first { row } else { next });
            if is_first {
                self.rows[row as usize] = now;
            } else if new == next {
                self.added.push(now);
            }
            if new != row {
                self.moved.insert([at_vertex[0].vertex, row], new);
            }
        }
    }
}

/// Key of a normal: normals that agree to a millionth of their length share a row.
fn rounded(normal: Vec3) -> [i64; 3] {
    let length = normal.norm().max(f64::MIN_POSITIVE);
    normal.map(|c| (1e6 * c / length).round() as i64).into()
}

/// Sums over the faces at a vertex that share a normal.
#[derive(Default)]
struct Fan {
    /// Sums of `e eT` and `e' eT` over the edges from the vertex.
    rest: Matrix3<f64>,
    deformed: Matrix3<f64>,
    /// Sums of the area-weighted normals of the faces, at rest and deformed.
    normals: [Vec3; 2],
}

fn fan(corners: &[Naming], faces: &[Vec<ShadedCorner>], rest: &[Vec3], deformed: &[Vec3]) -> Fan {
    let mut fan = Fan::default();
    for corner in corners {
        let (v, face, at) = (corner.vertex, &faces[corner.face as usize], corner.place as usize);
        let count = face.len();
        for neighbour in [face[(at + 1) % count][0], face[(at + count - 1) % count][0]] {
            let [e, now] = [rest, deformed].map(|x| x[neighbour as usize] - x[v as usize]);
            fan.rest += e * e.transpose();
            fan.deformed += now * e.transpose();
        }
        fan.normals[0] += vector_area(face, rest);
        fan.normals[1] += vector_area(face, deformed);
    }
    fan
}

impl Fan {
    /// A normal after the deformation, with the same length.
    fn turn(&self, normal: Vec3) -> Vec3 {
        let [from, to] = self.normals;
        self.cofactors()
            .and_then(|cofactors| (cofactors * normal).try_normalize(1e-9 * normal.norm()))
            .map_or_else(|| turn(normal, &from, &to), |direction| normal.norm() * direction)
    }

    /// Cofactor matrix of the deformation gradient, up to a factor; `None` if the edges do not determine it.
    fn cofactors(&self) -> Option<Matrix3<f64>> {
        let [from, to] = self.normals.map(|n| n.try_normalize(0.0));
        let (from, to) = (from?, to?);
        let scale = self.rest.trace();
        let rest = (self.rest + scale * from * from.transpose()) / scale;
        let gradient = (self.deformed + scale * to * from.transpose()) / scale * rest.try_inverse()?;
        let [a, b, c] = [0, 1, 2].map(|i| gradient.column(i).into_owned());
        Some(Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)]))
    }
}

fn turn(normal: Vec3, from: &Vec3, to: &Vec3) -> Vec3 {
    match UnitQuaternion::rotation_between(from, to) {
        Some(rotation) => rotation * normal,
        None => normal.map(|value| -value), // half a turn, whose axis is undefined
    }
}

/// Normal of a polygon by Newell's method; its length is proportional to the area.
fn vector_area(corners: &[ShadedCorner], positions: &[Vec3]) -> Vec3 {
    let at = |corner: &ShadedCorner| positions[corner[0] as usize];
    let origin = at(&corners[0]);
    let spokes = corners[1..].windows(2).map(|pair| (at(&pair[0]) - origin).cross(&(at(&pair[1]) - origin)));
    0.5 * spokes.sum::<Vec3>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ObjDocument;
    use crate::testing::{Random, document};

    /// The rows of a document whose vertices went to `deformed`.
    fn turned(document: &ObjDocument, deformed: &[Vec3]) -> TurnedNormals {
        TurnedNormals::new(document.normals(), &document.shaded_faces(), document.positions(), deformed)
    }

    /// Two squares side by side in z = 0, each with a normal of its own, and one normal nobody names.
    const TILES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvn 0 0 2\nvn 0.6 0 0.8\nvn 1 1 1\n\
        f 1//1 2//1 3//1 4//1\nf 2//2 5//2 6//2 3//2\n";

    #[test]
    fn a_normal_turns_with_its_faces_and_keeps_its_length() {
        let document = document(TILES);
        let rest = document.positions();
        let mut deformed = rest.to_vec();
        for (vertex, x) in [(1, 0.0), (4, 0.0), (2, 0.0), (5, 0.0)] {
            deformed[vertex] = Vec3::new(x, rest[vertex][1], -rest[vertex][0]); // a quarter turn about y: z to x
        }
        let turned = turned(&document, &deformed).rows;
        let near = |a: Vec3, b: Vec3| (a - b).norm() < 1e-14;
        assert!(near(turned[0], Vec3::new(2.0, 0.0, 0.0)), "{turned:?}");
        assert!(near(turned[1], Vec3::new(0.8, 0.0, -0.6)), "{turned:?}");
        assert_eq!(turned[2], Vec3::repeat(1.0));
    }

    #[test]
    fn normals_of_untouched_faces_stay_bit_for_bit() {
        let document = document(TILES);
        let mut deformed = document.positions().to_vec();
        deformed[4][2] = 0.5;
        let turned = turned(&document, &deformed).rows;
        assert_eq!(turned[0], document.normals()[0]);
        assert_ne!(turned[1], document.normals()[1]);
    }

    #[test]
    fn turned_over_or_crushed_faces_give_finite_normals() {
        let document = document(TILES);
        let rest = document.positions();
        let over: Vec<_> = rest.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
        assert_eq!(turned(&document, &over).rows[0], Vec3::new(0.0, 0.0, -2.0));
        let crushed = vec![Vec3::zeros(); rest.len()];
        assert_eq!(turned(&document, &crushed).rows, document.normals());
    }

    /// A cube of `n` x `n` squares a side with one row for each side.
    fn cube(n: usize) -> String {
        let mut text = String::new();
        let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
                    let mut p = Vec3::zeros();
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, at(i), at(j));
                    text += &format!("v {} {} {}\n", p.x, p.y, p.z);
                }
                let mut normal = Vec3::zeros();
                normal[axis] = sign;
                text += &format!("vn {} {} {}\n", normal.x, normal.y, normal.z);
            }
        }
        for side in 0..6 {
            let v = |i: usize, j: usize| side * (n + 1) * (n + 1) + i * (n + 1) + j + 1;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let mut round = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
                if side % 2 == 0 {
                    round.reverse();
                }
                text += &format!("f{}\n", round.map(|v| format!(" {v}//{}", side + 1)).concat());
            }
        }
        text
    }

    #[test]
    fn normals_of_any_linear_map_are_its_cofactors_times_those_at_rest() {
        let document = document(&cube(4));
        for seed in 0..20 {
            let random = &mut Random(seed);
            let f =
                Matrix3::identity() + 0.6 * Matrix3::from_columns(&[random.vector(), random.vector(), random.vector()]);
            if f.determinant() < 0.1 {
                continue;
            }
            let deformed: Vec<Vec3> = document.positions().iter().map(|x| f * x).collect();
            let turned = turned(&document, &deformed);
            assert!(turned.added.is_empty() && turned.moved.is_empty(), "each side stays flat");
            let cofactors = f.determinant() * f.try_inverse().unwrap().transpose();
            for (now, rest) in turned.rows.iter().zip(document.normals()) {
                assert!((now - (cofactors * rest).normalize()).norm() < 1e-9, "{seed}: {now:?}");
            }
        }
    }

    #[test]
    fn a_dent_in_a_side_with_one_row_parts_it_and_leaves_all_other_corners() {
        // z = 1 goes to z = 1 - depth (1 - x2/a2)(1 - y2/a2) inside of a square.
        let document = document(&cube(40));
        let rest = document.positions();
        let (a, depth) = (0.6, 0.2);
        let inside = |p: &Vec3| p.z == 1.0 && p.x.abs() < a - 1e-9 && p.y.abs() < a - 1e-9;
        let fall = |x: f64| 1.0 - x * x / (a * a);
        let dent = |p: &Vec3| if inside(p) { *p - depth * fall(p.x) * fall(p.y) * Vec3::z() } else { *p };
        let deformed: Vec<Vec3> = rest.iter().map(dent).collect();
        let turned = turned(&document, &deformed);
        assert_eq!(&turned.rows, document.normals(), "some corners of each row stay");
        let all: Vec<Vec3> = turned.rows.iter().chain(&turned.added).copied().collect();
        let mut compared = 0;
        for corner in document.shaded_faces().into_iter().flatten() {
            let [v, row] = corner;
            let p = rest[v as usize];
            let now = all[turned.moved.get(&corner).map_or(row, |new| *new) as usize];
            let far = 2.5 / 40.0 * 2.0;
            if p.z < 1.0 || p.x.abs() > a + far || p.y.abs() > a + far {
                assert_eq!(now, document.normals()[row as usize]);
            } else if p.x.abs() < a - far && p.y.abs() < a - far {
                let slope = |x: f64, y: f64| depth * 2.0 * x / (a * a) * fall(y);
                let exact = Vec3::new(-slope(p.x, p.y), -slope(p.y, p.x), 1.0).normalize();
                assert!(now.angle(&exact).to_degrees() < 1.0, "{p:?}: {now:?}, not {exact:?}");
                compared += 1;
            }
        }
        assert!(compared > 1000);
    }

    #[test]
    fn parted_rows_come_back_from_the_file_and_other_faces_keep_their_lines() {
        let interleaved = cube(6) + "v 5 5 5\nvn 0 1 0\n";
        for text in [cube(6), interleaved.clone(), cube(6).replace('\n', "\r\n"), interleaved.replace('\n', "\r\n")] {
            let document = document(&text);
            let mut deformed = document.positions().to_vec();
            let at = deformed.iter().position(|p| p.z == 1.0 && p.xy().norm() < 0.4).unwrap();
            deformed[at].z = 0.7;
            let turned = turned(&document, &deformed);
            let mut out = Vec::new();
            document.write_deformed(&deformed, &mut out).unwrap();
            let back = ObjDocument::parse(out.clone(), "back.obj".as_ref()).unwrap();
            assert_eq!(back.normals(), [&turned.rows[..], &turned.added].concat());
            let named = |document: &ObjDocument| -> Vec<ShadedCorner> {
                let mut named: Vec<_> = document.shaded_faces().into_iter().flatten().collect();
                named.sort_unstable();
                named
            };
            let mut wanted = named(&document);
            wanted.iter_mut().for_each(|corner| corner[1] = turned.moved.get(corner).copied().unwrap_or(corner[1]));
            wanted.sort_unstable();
            assert_eq!(named(&back), wanted);
            // The lines of faces that name no parted corner are there as they were.
            let parted = |face: &&Vec<ShadedCorner>| face.iter().any(|corner| turned.moved.contains_key(corner));
            let parted = document.shaded_faces().iter().filter(parted).count();
            let lines = String::from_utf8(out).unwrap();
            assert!(
                !text.contains('\r') || (!lines.contains("\r\r") && lines.replace("\r\n", "").find('\n').is_none())
            );
            let kept = text.lines().filter(|line| lines.lines().any(|other| other == *line)).count();
            assert!((4..=16).contains(&parted) && text.lines().count() - kept == 1 + parted);
        }
    }
}
