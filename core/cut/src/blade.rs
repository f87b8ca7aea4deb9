//! The blade, the stroke it makes, and the triangles it sweeps.

use robust::{Coord, Coord3D, orient2d, orient3d};

use super::error::{Refusal, Refused};
use pliant_mesh::geometry::Vec3;

/// Where a blade is: its edge is the segment between two points of the rest shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blade {
    /// The end that goes into a body first, m.
    pub tip: Vec3,
    /// The end at the handle, m.
    pub heel: Vec3,
}

/// A cut in the making: where the blade is, and which vertices of the mesh lie on it there. It begins where
/// [`Stroke::begin`] puts it, goes on with every advance, and ends when it is dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    pub(super) blade: Blade,
    pub(super) seam: Vec<u32>,
    pub(super) travel: f64, // m, way of the blade's middle so far
}

/// A triangle that the blade's edge sweeps, corners counter-clockwise seen from the left. Side 0 is where the strip before
/// it ended.
#[derive(Clone, Debug)]
pub(super) struct Facet {
    pub corners: [Vec3; 3],
    pub normal: Vec3,           // unit, to the left
    pub texture: [[f64; 2]; 3], // m, along the blade and along the way
    across: [Vec3; 2],          // unit, along side 0 and to its left
    pub flat: [[f64; 2]; 3],    // corners in the frame of the facet, m
    pub front: usize,           // side where the strip goes on
    pub goes_on: bool,          // side 0 is where a facet before it ended, not where the stroke begins
}

impl Stroke {
    /// A stroke that starts with the blade here.
    ///
    /// # Errors
    /// [`Refused`] when a coordinate is not finite or the blade has no length.
    pub fn begin(blade: Blade) -> Result<Self, Refused> {
        blade.check()?;
        Ok(Self { blade, seam: Vec::new(), travel: 0.0 })
    }

    /// Where the blade was after the last advance.
    pub fn blade(&self) -> Blade {
        self.blade
    }

    /// The triangles swept from here to `next`, none to two.
    pub(super) fn facets(&self, next: &Blade) -> Vec<Facet> {
        let [a, b, c, d] = [self.blade.tip, self.blade.heel, next.heel, next.tip];
        let (from, to) = (self.travel, self.travel + self.blade.way(next));
        let (deep, deeper) = (self.blade.length(), next.length());
        let near = Facet::new([a, b, c], [[0.0, from], [deep, from], [deeper, to]], 2);
        let far = Facet::new([a, c, d], [[0.0, from], [deeper, to], [0.0, to]], 1);
        let mut facets: Vec<Facet> = [near, far].into_iter().flatten().collect();
        let began = self.travel > 0.0;
        facets.iter_mut().enumerate().for_each(|(at, facet)| facet.goes_on = began || at > 0);
        facets
    }
}

impl Blade {
    pub(super) fn check(&self) -> Result<(), Refused> {
        let ends = [self.tip, self.heel];
        if let Some(value) = ends.iter().flatten().find(|value| value.is_nan() || value.abs() >= 1e9) {
            return Err(Refused { reason: Refusal::NotFinite, entity: "blade", value: *value });
        }
        let length = self.length();
        if length < 1e-9 {
            return Err(Refused { reason: Refusal::NoLength, entity: "blade", value: length });
        }
        Ok(())
    }

    pub(super) fn length(&self) -> f64 {
        (self.heel - self.tip).norm()
    }

    /// How far the blade's middle is moved, m.
    pub(super) fn way(&self, next: &Self) -> f64 {
        let middle = |blade: &Self| blade.tip.lerp(&blade.heel, 0.5);
        (middle(next) - middle(self)).norm()
    }
}

impl Facet {
    /// `None` without an area worth the name: the blade slid along itself, or one end stood still.
    fn new(corners: [Vec3; 3], texture: [[f64; 2]; 3], front: usize) -> Option<Self> {
        let [a, b, c] = corners;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-6 * longest * longest)?;
        let along = (b - a).try_normalize(0.0)?;
        let across = [along, normal.cross(&along)];
        let mut facet = Self { corners, normal, texture, across, flat: [[0.0; 2]; 3], front, goes_on: false };
        facet.flat = corners.map(|corner| facet.flatten(corner));
        Some(facet)
    }

    /// Side of the plane a point is on, without rounding: 1 left, -1 right, 0 on it.
    pub fn side(&self, point: Vec3) -> i8 {
        let [a, b, c, d] = [self.corners[0], self.corners[1], self.corners[2], point].map(coord);
        sign(-orient3d(a, b, c, d))
    }

    /// m, height of a point over the plane, above 0 on the left.
    pub fn height(&self, point: Vec3) -> f64 {
        (point - self.corners[0]).dot(&self.normal)
    }

    /// Place in the frame of the facet, m.
    pub fn flatten(&self, point: Vec3) -> [f64; 2] {
        let from_corner = point - self.corners[0];
        self.across.map(|axis| from_corner.dot(&axis))
    }

    /// The point of the plane at a place in the frame.
    pub fn lift(&self, flat: [f64; 2]) -> Vec3 {
        self.corners[0] + flat[0] * self.across[0] + flat[1] * self.across[1]
    }

    /// Ends of side `side` in the frame.
    pub fn rim(&self, side: usize) -> [[f64; 2]; 2] {
        [self.flat[side], self.flat[(side + 1) % 3]]
    }

    /// Texture coordinates of a place in the frame, m.
    pub fn texture_at(&self, flat: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.flat;
        let turn =
            |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let all = turn(a, b, c);
        let weights = [turn(b, c, flat) / all, turn(c, a, flat) / all, turn(a, b, flat) / all];
        [0, 1].map(|i| (0..3).map(|corner| weights[corner] * self.texture[corner][i]).sum())
    }
}

/// Side of the line from `a` to `b` that `c` is on, without rounding: 1 left, -1 right, 0 on it.
pub(super) fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> i8 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    sign(orient2d(a, b, c))
}

pub(super) fn coord(point: Vec3) -> Coord3D<f64> {
    Coord3D { x: point.x, y: point.y, z: point.z }
}

pub(super) fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}
