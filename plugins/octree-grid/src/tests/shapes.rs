//! Surfaces to test with.

use crate::OctreeGrid;
use crate::vector::{Vector, add, norm, scale};
use pliant_plugin_api::{Grid, Params, SurfaceView, param};
use std::path::Path;

/// A triangle mesh of its own.
#[derive(Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) points: Vec<Vector>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub(crate) fn view(&self) -> SurfaceView<'_> {
        SurfaceView { points: &self.points, triangles: &self.triangles }
    }

    /// An octree-grid of this mesh with default parameters.
    pub(crate) fn grid(&self, level: u32) -> OctreeGrid {
        let mut grid = new("trilinear");
        grid.build(&self.view(), level).unwrap();
        grid
    }

    pub(crate) fn and(mut self, other: Self) -> Self {
        let offset = self.points.len() as u32;
        self.points.extend(other.points);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|p| p + offset)));
        self
    }

    pub(crate) fn inverted(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self
    }

    /// Without the triangles whose middle is in `hole`.
    pub(crate) fn without(mut self, hole: impl Fn(Vector) -> bool) -> Self {
        let middle =
            |t: &[u32; 3]| t.iter().fold([0.0; 3], |sum, &p| add(sum, scale(1.0 / 3.0, self.points[p as usize])));
        self.triangles.retain(|t| !hole(middle(t)));
        self
    }

    pub(crate) fn moved(mut self, by: Vector) -> Self {
        self.points.iter_mut().for_each(|p| *p = add(*p, by));
        self
    }
}

/// A grid before anything is built.
pub(crate) fn new(embedding: &str) -> OctreeGrid {
    let choice = ["trilinear", "paper-ratio"].iter().position(|e| *e == embedding).unwrap();
    OctreeGrid::new(&Params::new(OctreeGrid::INFO.params, &[param::Value::Number(choice as f64)])).unwrap()
}

/// A closed box from 0 to `size`, m, facing outwards.
pub(crate) fn cuboid(size: Vector) -> Mesh {
    let points = (0..8).map(|c| [0, 1, 2].map(|axis| size[axis] * f64::from(c >> axis & 1))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh { points, triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect() }
}

/// A closed sphere around 0: an octahedron divided `depth` times, facing outwards, with vertices on the axes.
pub(crate) fn sphere(radius: f64, depth: u32) -> Mesh {
    let corner = |c: usize| [0, 1, 2].map(|axis| if c % 3 == axis { if c < 3 { 1.0 } else { -1.0 } } else { 0.0 });
    let faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let mut faces: Vec<[Vector; 3]> = faces.iter().map(|f| f.map(corner)).collect();
    for _ in 0..depth {
        let divide = |[a, b, c]: [Vector; 3]| {
            let middle = |p, q| scale(1.0 / norm(add(p, q)), add(p, q));
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(divide).collect();
    }
    let points: Vec<Vector> = faces.iter().flatten().map(|&p| scale(radius, p)).collect();
    Mesh { triangles: (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(), points }
}

/// A flat sheet of `n` x `n` squares over [0, 1]^2 at z = 0, bent by `height`.
pub(crate) fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let place = |i: u32| f64::from(i) / f64::from(n);
    let points = (0..(n + 1) * (n + 1)).map(|p| (place(p % (n + 1)), place(p / (n + 1))));
    let square = |s: u32| {
        let a = s % n + (n + 1) * (s / n);
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    Mesh {
        points: points.map(|(x, y)| [x, y, height(x, y)]).collect(),
        triangles: (0..n * n).flat_map(square).collect(),
    }
}

/// A model of the shared folder; `None`, with a message, where the folder is not.
pub(crate) fn model(name: &str) -> Option<Mesh> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes").join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || words.next().unwrap().parse().unwrap();
                mesh.points.push([next(), next(), next()]);
            }
            Some("f") => {
                let face: Vec<u32> = words.map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect();
                mesh.triangles.extend((2..face.len()).map(|i| [face[0], face[i - 1], face[i]]));
            }
            _ => {}
        }
    }
    Some(mesh)
}
