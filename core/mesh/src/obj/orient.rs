//! Faces that are turned over: their corners run the other way round than those of their neighbours, or than those of a body seen from outside.
//!
//! Such a model has no inside for whoever goes by the corners. The text of the file stays as it is: only the order in which faces name their corners changes, and what is
//! written in the place of a turned face is turned back.

use std::borrow::Cow;
use std::collections::HashMap;

use super::{ObjDocument, Patch};
use crate::geometry::Vec3;
use crate::{DisjointSets, Surface};

/// Number of a side without exactly one other beside it.
const NO_SIDE: u32 = u32::MAX;
/// Ratio of volume to area^(3/2) below which a component has no inside.
const LEAST_VOLUME: f64 = 1e-9;
/// Largest area of the holes of a body relative to its own, of which its volume still tells the outside.
const MOST_HOLES: f64 = 0.05;

/// A connected component of triangles, all turned as its first one is.
#[derive(Clone, Debug, Default)]
struct Component {
    triangles: Vec<u32>,
    /// Whether any way to turn its triangles agrees with all of their neighbours.
    is_orientable: bool,
    /// Area of the triangles that have to be turned for that, and of all, squared units.
    turned_area: f64,
    area: f64,
    /// Enclosed volume with these turned, cubed units.
    volume: f64,
    /// Lower and upper corner of its box, units.
    bounds: [Vec3; 2],
    /// Largest area that the holes can have, squared units.
    holes: f64,
}

impl Component {
    /// Whether it bounds a volume, but for small holes.
    fn is_closed(&self) -> bool {
        let has_volume = self.volume.abs() > LEAST_VOLUME * self.area * self.area.sqrt();
        has_volume && self.holes <= MOST_HOLES * self.area
    }
}

/// The triangles of a surface, and which of them are to be turned over.
struct Orientation<'a> {
    surface: &'a Surface,
    /// The side beside each side of a triangle (3 m).
    beside: Vec<u32>,
    is_turned: Vec<bool>,
}

impl ObjDocument {
    /// Faces, ascending, that have to be turned over for neighbours to agree and for closed parts to have their outside outside. `surface` is the surface of this document.
    ///
    /// Of an open part the smaller area is turned over. A closed part inside of another one, as a cavity, stays as most of its area is. Nothing is turned at edges of three and more
    /// triangles, and of parts with one side only.
    pub fn faces_turned_over(&self, surface: &Surface) -> Vec<u32> {
        let mut of = Orientation::new(surface);
        let components = of.components();
        let closed: Vec<usize> = (0..components.len()).filter(|c| components[*c].is_closed()).collect();
        for (number, component) in components.iter().enumerate() {
            if !component.is_orientable {
                component.triangles.iter().for_each(|t| of.is_turned[*t as usize] = false);
                continue;
            }
            let is_sound = component.turned_area == 0.0 && component.volume > 0.0;
            let has_outside =
                component.is_closed() && (is_sound || !of.is_inside_another(number, &components, &closed));
            let turns_all = match has_outside {
                true => component.volume < 0.0,
                false => 2.0 * component.turned_area > component.area,
            };
            if turns_all {
                component.triangles.iter().for_each(|t| of.is_turned[*t as usize] ^= true);
            }
        }
        let mut faces: Vec<u32> =
            surface.face_of.iter().zip(&of.is_turned).filter(|(_, turned)| **turned).map(|(face, _)| *face).collect();
        faces.dedup();
        faces
    }

    /// Turns faces (ascending) over: they name their corners the other way round, the first one first. The text stays.
    pub fn turn_over(&mut self, faces: &[u32]) {
        for &face in faces {
            let [from, to] = [face, face + 1].map(|end| self.parsed.face_start[end as usize] as usize);
            self.parsed.corners[from + 1..to].reverse();
        }
        self.turned_over.extend_from_slice(faces);
        self.turned_over.sort_unstable();
    }

    /// Faces that [`Self::turn_over`] has turned, ascending.
    pub fn turned_over(&self) -> &[u32] {
        &self.turned_over
    }

    /// Whether most faces are turned over, so that faces that are added to the file have to be as well.
    pub fn is_mostly_turned_over(&self) -> bool {
        2 * self.turned_over.len() > self.face_count()
    }

    pub(super) fn is_turned_over(&self, face: u32) -> bool {
        self.turned_over.binary_search(&face).is_ok()
    }

    /// A patch with corners as the file has them.
    pub(super) fn patch_of_file<'a, 'b>(&self, patch: &'a Patch<'b>) -> Cow<'a, Patch<'b>> {
        if self.turned_over.is_empty() {
            return Cow::Borrowed(patch);
        }
        let mut patch = patch.clone();
        for (_, polygons) in patch.faces.iter_mut().filter(|(face, _)| self.is_turned_over(**face)) {
            polygons.iter_mut().for_each(|polygon| polygon[1..].reverse());
        }
        if self.is_mostly_turned_over() {
            patch.added.iter_mut().for_each(|triangle| triangle[1..].reverse());
        }
        Cow::Owned(patch)
    }
}

impl<'a> Orientation<'a> {
    fn new(surface: &'a Surface) -> Self {
        let mut beside = vec![NO_SIDE; 3 * surface.triangles.len()];
        for (_, sides) in surface.edges().iter() {
            if let [a, b] = sides {
                let [a, b] = [a, b].map(|side| 3 * side.triangle + u32::from(side.corner));
                (beside[a as usize], beside[b as usize]) = (b, a);
            }
        }
        Self { surface, beside, is_turned: vec![false; surface.triangles.len()] }
    }

    /// Turns the triangles of each connected component as its first one is, and measures it.
    fn components(&mut self) -> Vec<Component> {
        let (points, face_of) = (&self.surface.points, &self.surface.face_of);
        let centre = self.surface.bounds().centre(); // avoids cancellation for models far from the origin
        let mut is_known = vec![false; self.is_turned.len()];
        let mut found = Vec::new();
        for seed in 0..self.is_turned.len() {
            if std::mem::replace(&mut is_known[seed], true) {
                continue;
            }
            let bounds = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
            let mut component =
                Component { triangles: vec![seed as u32], is_orientable: true, bounds, ..Component::default() };
            let (mut next, mut border) = (0, Vec::new());
            while let Some(&t) = component.triangles.get(next) {
                next += 1;
                let turned = self.is_turned[t as usize];
                let mut meet = |other: u32, is_turned: bool, component: &mut Component| {
                    if !std::mem::replace(&mut is_known[other as usize], true) {
                        self.is_turned[other as usize] = is_turned;
                        component.triangles.push(other);
                    }
                    component.is_orientable &= self.is_turned[other as usize] == is_turned;
                };
                for side in 3 * t..3 * t + 3 {
                    let [a, _] = ends(self.surface, side);
                    match self.beside[side as usize] {
                        NO_SIDE => border.push(side),
                        other => meet(other / 3, turned ^ (ends(self.surface, other)[0] == a), &mut component),
                    }
                }
                // The triangles of a polygon turn with it.
                let of_polygon = [t.wrapping_sub(1), t + 1].into_iter();
                for other in of_polygon.filter(|other| face_of.get(*other as usize) == Some(&face_of[t as usize])) {
                    meet(other, turned, &mut component);
                }
                let triangle = self.surface.triangles[t as usize];
                let cross = self.surface.cross(&triangle);
                let (area, volume) = (0.5 * cross.norm(), (points[triangle[0] as usize] - centre).dot(&cross) / 6.0);
                for point in triangle.map(|v| points[v as usize]) {
                    component.bounds = [component.bounds[0].inf(&point), component.bounds[1].sup(&point)];
                }
                component.area += area;
                component.turned_area += if turned { area } else { 0.0 };
                component.volume += if turned { -volume } else { volume };
            }
            component.holes = hole_area(self.surface, &border);
            found.push(component);
        }
        found
    }

    /// Whether a component is inside of another one that is closed.
    fn is_inside_another(&self, number: usize, components: &[Component], closed: &[usize]) -> bool {
        let at = |t: u32| self.surface.triangles[t as usize].map(|v| self.surface.points[v as usize]);
        let [point, ..] = at(components[number].triangles[0]);
        let is_in_box = |[low, high]: [Vec3; 2]| low.inf(&point) == low && high.sup(&point) == high;
        let angle = |t: &u32| {
            let angle = solid_angle(at(*t).map(|corner| corner - point));
            if self.is_turned[*t as usize] { -angle } else { angle }
        };
        let others = closed.iter().filter(|other| **other != number).map(|other| &components[*other]);
        let mut windings =
            others.filter(|other| is_in_box(other.bounds)).map(|other| other.triangles.iter().map(angle).sum::<f64>());
        // 4 pi inside, 0 outside, in between beside a hole.
        windings.any(|winding| winding.abs() > 2.0 * std::f64::consts::PI)
    }
}

/// Largest area of the holes with these border sides: of each a disk with a circumference of its length.
fn hole_area(surface: &Surface, border: &[u32]) -> f64 {
    let mut number: HashMap<u32, u32> = HashMap::new();
    let mut loops = DisjointSets::new(0);
    let ends: Vec<[u32; 2]> = border
        .iter()
        .map(|side| ends(surface, *side).map(|v| *number.entry(v).or_insert_with(|| loops.add())))
        .collect();
    ends.iter().for_each(|[a, b]| loops.unite(*a, *b));
    let mut lengths: HashMap<u32, f64> = HashMap::new();
    for (side, [first, _]) in border.iter().zip(ends) {
        let [a, b] = self::ends(surface, *side).map(|v| surface.points[v as usize]);
        *lengths.entry(loops.find(first)).or_default() += (a - b).norm();
    }
    let mut areas: Vec<f64> =
        lengths.into_values().map(|length| length * length / (4.0 * std::f64::consts::PI)).collect();
    areas.sort_unstable_by(f64::total_cmp); // a sum that does not depend on the order of a map
    areas.iter().sum()
}

/// First and last vertex of a side as the surface has it.
fn ends(surface: &Surface, side: u32) -> [u32; 2] {
    let triangle = surface.triangles[side as usize / 3];
    [0, 1].map(|end| triangle[(side as usize + end) % 3])
}

/// Signed solid angle of a triangle seen from the origin (van Oosterom and Strackee 1983), sr.
fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let [x, y, z] = [a.norm(), b.norm(), c.norm()];
    2.0 * libm::atan2(a.dot(&b.cross(&c)), x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Kind, check};
    use crate::generate;
    use crate::testing::{Random, document, models};

    /// A document with some faces turned over in its text.
    fn turned(whole: &ObjDocument, faces: &[u32]) -> ObjDocument {
        let mut other = whole.clone();
        other.turn_over(faces);
        // Written as parts are, face by face, and read as a file.
        other.turned_over.clear();
        let mut bytes = Vec::new();
        other.write_faces(&vec![true; whole.face_count()], &mut bytes).unwrap();
        document(std::str::from_utf8(&bytes).unwrap())
    }

    fn found(document: &ObjDocument) -> Vec<u32> {
        document.faces_turned_over(&Surface::from_document(document))
    }

    #[test]
    fn closed_models_have_their_outside_outside() {
        for seed in 0..3 {
            let random = &mut Random(seed);
            for model in
                models(4, seed).into_iter().filter(|model| model.closed && model.genus.is_some() && model.holes == 0)
            {
                let whole = model.document();
                assert_eq!(found(&whole), [0; 0], "{}: it is sound", model.name);
                let all: Vec<u32> = (0..whole.face_count() as u32).collect();
                let some: Vec<u32> = all.iter().copied().filter(|_| random.below(3) == 0).collect();
                for faces in [all, some] {
                    let mut other = turned(&whole, &faces);
                    assert_eq!(found(&other), faces, "{}", model.name);
                    let bytes = other.bytes().to_vec();
                    other.turn_over(&faces);
                    let volumes = [&other, &whole].map(|of| Surface::from_document(of).volume());
                    assert!((volumes[0] / volumes[1] - 1.0).abs() < 1e-9, "{}: {volumes:?}", model.name);
                    let mut written = Vec::new();
                    other.write_faces(&vec![true; other.face_count()], &mut written).unwrap();
                    assert!(written == bytes, "{}: the file stays", model.name);
                    let patch = Patch {
                        faces: (0..other.face_count()).map(|f| (f as u32, vec![polygon(&other, f)])).collect(),
                        ..Patch::default()
                    };
                    written.clear();
                    other.write_patched(other.positions(), None, &patch, &mut written).unwrap();
                    let again = document(std::str::from_utf8(&written).unwrap());
                    assert_eq!(found(&again), faces, "{}: what replaces a face is turned as it was", model.name);
                    let divided = other.subdivided().unwrap();
                    let as_file = document(std::str::from_utf8(divided.bytes()).unwrap());
                    assert_eq!(found(&divided), [0; 0], "{}", model.name);
                    assert_eq!(found(&as_file), divided.turned_over(), "{}", model.name);
                }
            }
        }
    }

    fn polygon(document: &ObjDocument, face: usize) -> Vec<[u32; 3]> {
        document.corners(face).iter().map(|c| [c.v, c.vt, c.vn]).collect()
    }

    #[test]
    fn small_holes_let_the_outside_be_known_and_large_ones_do_not() {
        for (degrees, is_known) in [(12.0_f64, true), (15.0, true), (60.0, false)] {
            let ball = generate::sphere(12, 0.1).unwrap();
            let height = 0.1 * degrees.to_radians().cos();
            let is_kept: Vec<bool> = ball
                .faces()
                .map(|face| face.corners.iter().any(|c| ball.positions()[c.v as usize].z < height - 1e-6))
                .collect();
            let mut bytes = Vec::new();
            ball.write_faces(&is_kept, &mut bytes).unwrap();
            let open = document(std::str::from_utf8(&bytes).unwrap());
            let all: Vec<u32> = (0..open.face_count() as u32).collect();
            assert!(check(&Surface::from_document(&open), &open).iter().any(|finding| finding.kind == Kind::Border));
            assert_eq!(found(&open), [0; 0], "{degrees}");
            assert_eq!(found(&turned(&open, &all)), if is_known { all } else { vec![] }, "{degrees}");
        }
    }

    #[test]
    fn the_smaller_area_of_a_sheet_is_turned_over() {
        let sheet = generate::grid([9, 7], [0.1, 0.08], generate::Pattern::Irregular).unwrap();
        let all: Vec<u32> = (0..sheet.face_count() as u32).collect();
        assert_eq!(found(&turned(&sheet, &all)), [0; 0], "a sheet has no outside");
        let some: Vec<u32> = all.iter().copied().filter(|face| face % 4 == 1).collect();
        assert_eq!(found(&turned(&sheet, &some)), some);
        let rest: Vec<u32> = all.into_iter().filter(|face| face % 4 != 1).collect();
        assert_eq!(found(&turned(&sheet, &rest)), some, "relative to the rest");
    }

    #[test]
    fn cavities_and_what_has_one_side_stay() {
        let joined = |outer: &ObjDocument, inner: &ObjDocument| {
            let (mut rows, mut faces) = (String::new(), String::new());
            for (of, first) in [(outer, 1), (inner, outer.positions().len() + 1)] {
                of.positions().iter().for_each(|p| rows += &format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z));
                for face in of.faces() {
                    let corners: String = face.corners.iter().map(|c| format!(" {}", c.v as usize + first)).collect();
                    faces += &format!("f{corners}\n");
                }
            }
            document(&(rows + &faces))
        };
        let [outer, inner] = [0.1, 0.05].map(|radius| generate::sphere(6, radius).unwrap());
        let faces: Vec<u32> = (0..inner.face_count() as u32).collect();
        let hollow = joined(&outer, &turned(&inner, &faces));
        assert_eq!(found(&hollow), [0; 0]);
        let bowl = turned(&outer, &(0..outer.face_count() as u32).collect::<Vec<_>>());
        let inside_out = joined(&bowl, &inner);
        assert_eq!(found(&inside_out).len(), outer.face_count(), "the outside of the two");
        // A strip with half a turn.
        let n = 8;
        let rows: String = (0..n)
            .flat_map(|i| {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
                [-0.2, 0.2].map(|w: f64| {
                    let r = 1.0 + w * (0.5 * angle).cos();
                    format!("v {} {} {}\n", r * angle.cos(), r * angle.sin(), w * (0.5 * angle).sin())
                })
            })
            .collect();
        let quads: String =
            (0..n - 1).map(|i| format!("f {} {} {} {}\n", 2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2)).collect();
        let strip = document(&format!("{rows}{quads}f {} 2 1 {}\n", 2 * n - 1, 2 * n));
        assert_eq!(found(&strip), [0; 0], "a strip with one side");
        assert!(check(&Surface::from_document(&strip), &strip).iter().any(|finding| finding.kind == Kind::Orientation));
    }
}
