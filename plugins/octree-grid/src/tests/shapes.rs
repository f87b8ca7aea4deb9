//! Surfaces for tests.

use crate::OctreeGrid;
use pliant_mesh::{ObjDocument, Surface};
use pliant_plugin_api::lanes::Vec3;
use pliant_plugin_api::{Grid, Params, SurfaceView, param};

/// A triangle mesh.
#[derive(Clone, Default)]
pub(crate) struct Mesh {
    /// Positions of the points, m.
    pub(crate) points: Vec<[f64; 3]>,
    /// Points of each triangle.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The triangles of a document.
    pub(crate) fn of(document: &ObjDocument) -> Self {
        let surface = Surface::from_document(document);
        Self { points: surface.points.into_iter().map(Into::into).collect(), triangles: surface.triangles }
    }

    /// The mesh as a grid takes it.
    pub(crate) fn view(&self) -> SurfaceView<'_> {
        SurfaceView { points: &self.points, triangles: &self.triangles }
    }

    /// An octree-grid of this mesh with default parameters.
    pub(crate) fn grid(&self, level: u32) -> OctreeGrid {
        let mut grid = new("trilinear");
        grid.build(&self.view(), level).unwrap();
        grid
    }

    /// Both meshes as one.
    pub(crate) fn and(mut self, other: Self) -> Self {
        let offset = self.points.len() as u32;
        self.points.extend(other.points);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|p| p + offset)));
        self
    }

    /// The mesh with its triangles facing the other way.
    pub(crate) fn inverted(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self
    }

    /// The mesh without the triangles whose centroid is in `hole`.
    pub(crate) fn without(mut self, hole: impl Fn(Vec3) -> bool) -> Self {
        let centroid =
            |t: &[u32; 3]| t.iter().fold(Vec3::default(), |sum, &p| sum + Vec3(self.points[p as usize]) * (1.0 / 3.0));
        self.triangles.retain(|t| !hole(centroid(t)));
        self
    }

    /// The mesh translated by a vector, m.
    pub(crate) fn moved(mut self, by: [f64; 3]) -> Self {
        self.points.iter_mut().for_each(|p| *p = (Vec3(*p) + Vec3(by)).0);
        self
    }
}

/// A grid with an embedding, not built yet.
pub(crate) fn new(embedding: &str) -> OctreeGrid {
    let choice = ["trilinear", "paper-ratio"].iter().position(|e| *e == embedding).unwrap();
    OctreeGrid::new(&Params::new(OctreeGrid::INFO.params, &[param::Value::Number(choice as f64)])).unwrap()
}

/// A closed box from 0 to `size`, m, facing outwards.
pub(crate) fn cuboid(size: [f64; 3]) -> Mesh {
    let points = (0..8).map(|c| [0, 1, 2].map(|axis| size[axis] * f64::from(c >> axis & 1))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh { points, triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect() }
}

/// A closed sphere around the origin: an octahedron subdivided `depth` times, facing outwards, with vertices on the axes. Triangles have
/// vertices of their own.
pub(crate) fn sphere(radius: f64, depth: u32) -> Mesh {
    let sign = |c: usize| if c < 3 { 1.0 } else { -1.0 };
    let corner = |c: usize| Vec3([0, 1, 2].map(|axis| if c % 3 == axis { sign(c) } else { 0.0 }));
    let faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let mut faces: Vec<[Vec3; 3]> = faces.iter().map(|f| f.map(corner)).collect();
    for _ in 0..depth {
        let divide = |[a, b, c]: [Vec3; 3]| {
            let middle = |p: Vec3, q: Vec3| (p + q) * (1.0 / (p + q).norm());
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(divide).collect();
    }
    let points = faces.iter().flatten().map(|&p| (p * radius).0).collect();
    Mesh { triangles: (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(), points }
}

/// A sheet of `n` x `n` squares over [0, 1]^2 with z = `height`(x, y).
pub(crate) fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let coordinate = |i: u32| f64::from(i) / f64::from(n);
    let points = (0..(n + 1) * (n + 1)).map(|p| (coordinate(p % (n + 1)), coordinate(p / (n + 1))));
    let square = |s: u32| {
        let a = s % n + (n + 1) * (s / n);
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    Mesh {
        points: points.map(|(x, y)| [x, y, height(x, y)]).collect(),
        triangles: (0..n * n).flat_map(square).collect(),
    }
}
