//! Models as people bring them: scans, quads, many parts, holes, borders, non-manifold edges, plates and tubes.
//!
//! All are made from a seed, at any size, and are written as OBJ text with random attributes. They are not beautiful: noise, uneven
//! triangles and odd files are the point.

use super::attributes::{Attributes, write};
use super::shape::Shape;
use super::{Random, document};
use crate::ObjDocument;
use crate::geometry::Vec3;

/// A model and what is known of it.
#[derive(Clone, Debug)]
pub struct TestModel {
    /// What kind of model it is, for messages.
    pub name: String,
    /// The OBJ file.
    pub text: String,
    /// Connected parts of the surface.
    pub shells: usize,
    /// Whether every part bounds a volume, but for small holes.
    pub closed: bool,
    /// Small holes: what is left when all faces around a vertex are missing.
    pub holes: usize,
    /// Handles of all parts together; `None` where a part has a border that is no small hole, or is not a manifold.
    pub genus: Option<usize>,
}

impl TestModel {
    fn new(name: &str, shape: &Shape, random: &mut Random) -> Self {
        let (scale, offset) = (random.pick(&[0.1, 1.0, 50.0]), random.vector());
        let reach = shape.points.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        let placed = shape.clone().map(|p| scale * (p / reach + offset)).compact();
        let text = write(&placed, Attributes::random(random), random);
        Self { name: name.into(), text, shells: 1, closed: true, holes: 0, genus: Some(0) }
    }

    /// The model, parsed.
    pub fn document(&self) -> ObjDocument {
        document(&self.text)
    }
}

/// A block with `genus` holes through it, `cells` voxels to a block: closed, of quads, about the origin.
fn block(genus: u32, cells: u32) -> Shape {
    let n = cells as i32;
    if genus == 0 {
        return Shape::of_voxels([n, n + n / 3, n], |_| true);
    }
    let is_hole = move |[i, j, _]: [i32; 3]| (i / n) % 2 == 1 && j / n == 1;
    Shape::of_voxels([(2 * genus as i32 + 1) * n, 3 * n, n], move |at| !is_hole(at))
}

/// A rounded, bent body with the given number of handles: closed, of quads.
fn body(genus: u32, cells: u32, random: &mut Random) -> Shape {
    block(genus, cells).smooth(2 + cells / 3).warp(random)
}

/// A noisy closed surface of about `triangles` triangles with `genus` handles, as a scanner makes it, with up to `holes` small holes.
pub fn scan(genus: u32, triangles: u32, holes: usize, seed: u64) -> TestModel {
    let random = &mut Random(seed);
    // Squares of the block's sides: 2 (1 + 4/3 + 4/3) of a body without handles, with them 2 (6 g + 3 - g) + 2 (2 g + 4) + 4 g.
    let squares = if genus == 0 { 22.0 / 3.0 } else { f64::from(18 * genus + 14) };
    let cells = (f64::from(triangles) / 2.0 / squares).sqrt().round().max(2.0) as u32;
    let shape = body(genus, cells, random).roughen(0.08, random).split(1.0, random);
    let before = shape.faces.len();
    let shape = shape.punch(holes, random);
    let holes = if shape.faces.len() < before { holes } else { 0 };
    TestModel { holes, genus: Some(genus as usize), ..TestModel::new(&format!("scan-{genus}"), &shape, random) }
}

/// One model of every kind, `cells` voxels across a part.
///
/// # Panics
/// If `cells` is less than 4.
pub fn models(cells: u32, seed: u64) -> Vec<TestModel> {
    assert!(cells >= 4, "{cells} cells");
    let random = &mut Random(seed);
    let triangles = 15 * cells * cells;
    let mut models: Vec<_> = (0..4).map(|genus| scan(genus, triangles, 0, random.next_u64())).collect();
    models.push(TestModel { name: "scan-with-holes".into(), ..scan(0, 2 * triangles, 2, random.next_u64()) });

    let quads = body(0, cells, random);
    models.push(TestModel::new("quads", &quads, random));
    let mixed = body(1, cells.div_ceil(2), random).split(0.3, random);
    models.push(TestModel { genus: Some(1), ..TestModel::new("quads-and-triangles", &mixed, random) });

    let edge = 0.3; // of a voxel: a plate is one voxel thick
    let plate =
        Shape::of_voxels([3 * cells as i32, 2 * cells as i32, 1], |_| true).map(|p| Vec3::new(p.x, p.y, edge * p.z));
    models.push(TestModel::new("plate", &plate.warp(random).split(0.5, random), random));
    models.push(TestModel { genus: Some(1), ..TestModel::new("tube", &tube(cells).split(0.5, random), random) });

    let open = Shape::sheet(2 * cells, cells).warp(random).roughen(0.08, random).split(0.7, random);
    models.push(TestModel { closed: false, genus: None, ..TestModel::new("open", &open, random) });
    models.push(parts(cells, random));
    models.push(non_manifold(cells, random));
    models
}

/// A pipe of square walls, one voxel thick, bent to a quarter of a circle.
fn tube(cells: u32) -> Shape {
    let (wide, long) = (cells as i32, 4 * cells as i32);
    let wall = move |i: i32| i == 0 || i == wide - 1;
    let pipe = Shape::of_voxels([wide, wide, long], move |[i, j, _]| wall(i) || wall(j));
    let radius = f64::from(long) / std::f64::consts::FRAC_PI_2;
    pipe.map(|p| {
        let (sin, cos) = libm::sincos(p.z / radius);
        Vec3::new((radius + p.x) * cos - radius, p.y, (radius + p.x) * sin)
    })
}

/// Seven parts: bodies of several sizes, apart, inside one another and through one another, and an open sheet.
fn parts(cells: u32, random: &mut Random) -> TestModel {
    let mut all = Shape::default();
    for i in 0..6 {
        let small = body(u32::from(i == 3), cells.div_ceil(if i < 2 { 1 } else { 2 }), random).split(0.5, random);
        // The second body lies inside of the first, the third goes through it, the others are scattered.
        let (scale, far) = [(1.0, 0.0), (0.4, 0.0), (1.0, 0.5), (1.0, 3.0), (1.0, 3.0), (1.0, 3.0)][i];
        let away = random.direction() * far * f64::from(cells);
        all.add(small.map(|p| scale * p + away));
    }
    let lifted = f64::from(cells);
    all.add(Shape::sheet(cells, cells).map(|p| Vec3::new(p.x, p.y, p.z + 2.0 * lifted)));
    TestModel { shells: 7, closed: false, genus: None, ..TestModel::new("many-parts", &all, random) }
}

/// A body with a fin on one of its edges, and a second body that shares one vertex with the first.
fn non_manifold(cells: u32, random: &mut Random) -> TestModel {
    let mut all = body(0, cells, random).split(0.5, random);
    let (highest, top) = all.points.iter().enumerate().max_by(|a, b| a.1[2].total_cmp(&b.1[2])).expect("points");
    let (highest, top) = (highest as u32, *top);
    let first = all.points.len() as u32;
    let second = body(0, cells.div_ceil(2), random);
    let (lowest, bottom) = second.points.iter().enumerate().min_by(|a, b| a.1[2].total_cmp(&b.1[2])).expect("points");
    let (lowest, bottom) = (lowest as u32, *bottom);
    all.add(second.map(|p| p - bottom + top));
    all.faces.iter_mut().flatten().filter(|v| **v == first + lowest).for_each(|v| *v = highest);

    let [a, b] = [all.faces[0][0], all.faces[0][1]];
    let outward = 1.5 * all.points[a as usize];
    all.points.push(outward);
    all.faces.push(vec![a, b, all.points.len() as u32 - 1]);
    all.part.push(2);
    TestModel { shells: 1, closed: false, genus: None, ..TestModel::new("non-manifold", &all, random) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Kind;
    use crate::{Surface, check};

    fn count(surface: &Surface, document: &ObjDocument, kind: Kind) -> usize {
        check(surface, document).iter().filter(|finding| finding.kind == kind).map(|finding| finding.count).sum()
    }

    #[test]
    fn every_model_is_what_it_says() {
        for (cells, seed) in [(4, 1), (7, 2), (10, 3)] {
            for model in models(cells, seed) {
                let (name, document) = (&model.name, model.document());
                let surface = Surface::from_document(&document);
                let of = |kind| count(&surface, &document, kind);
                for kind in [Kind::ZeroArea, Kind::Duplicate, Kind::ZeroEdge, Kind::Orientation, Kind::UnusedVertex] {
                    assert_eq!(of(kind), 0, "{name} {cells}: {kind:?}");
                }
                assert_eq!(of(Kind::NonManifold) > 0, name == "non-manifold", "{name} {cells}");
                assert_eq!(of(Kind::Border) > 0, model.holes > 0 || !model.closed, "{name} {cells}");
                let shells = surface.shells().iter().max().map_or(0, |last| last + 1) as usize;
                assert_eq!(shells, model.shells, "{name} {cells}");
                if let Some(genus) = model.genus {
                    // Euler and Poincare: V - E + F = 2 (shells - genus) - holes.
                    let [v, e, f] = [surface.points.len(), surface.edges().len(), surface.triangles.len()];
                    let euler = (v + f) as i64 - e as i64;
                    let expected = 2 * (model.shells as i64 - genus as i64) - model.holes as i64;
                    assert_eq!(euler, expected, "{name} {cells}");
                }
                if model.closed && model.holes == 0 {
                    let volume: f64 = surface
                        .triangles
                        .iter()
                        .map(|t| {
                            let [a, b, c] = t.map(|v| surface.points[v as usize]);
                            a.dot(&b.cross(&c)) / 6.0
                        })
                        .sum();
                    assert!(volume > 0.0, "{name} {cells}: faces look outwards");
                }
            }
        }
    }

    #[test]
    fn a_seed_gives_the_same_model_and_another_another() {
        let text = |seed| models(5, seed).into_iter().map(|model| model.text).collect::<Vec<_>>();
        assert_eq!(text(1), text(1));
        assert!(text(1).iter().zip(&text(2)).all(|(a, b)| a != b));
    }

    #[test]
    fn a_scan_has_about_as_many_triangles_as_asked_for() {
        for genus in 0..4 {
            for asked in [2_000, 20_000] {
                let found = scan(genus, asked, 0, 1).document().face_count() as f64 / f64::from(asked);
                assert!((0.7..1.4).contains(&found), "{genus}: {found} of {asked}");
            }
        }
    }

    /// All attributes together: every line a file can hold appears in some model.
    #[test]
    fn attributes_vary() {
        let all: String = (0..4).flat_map(|seed| models(4, seed)).map(|model| model.text).collect();
        for part in ["\nvt ", "\nvn ", "\ng ", "\no ", "usemtl", "mtllib", "\n#", "\r\n", "f -", "//", " # a face"] {
            assert!(all.contains(part), "{part:?}");
        }
    }
}
