//! The blade, its stroke, and the triangles it sweeps.

use robust::{Coord, Coord3D, orient2d, orient3d};

use super::error::{Refusal, Refused};
use pliant_mesh::geometry::Vec3;

/// The edge of a blade: a segment between two points of the rest shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blade {
    /// The end away from the handle, m.
    pub tip: Vec3,
    /// The end at the handle, m.
    pub heel: Vec3,
}

/// A cut in progress: the blade, and the vertices of the mesh that lie on it. It begins with [`Stroke::begin`], continues with every advance and
/// ends when it is dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    pub(super) blade: Blade,
    pub(super) seam: Vec<u32>,
    pub(super) travel: f64, // mean length of the paths of the blade's ends, m
}

/// A triangle swept by the blade's edge, with corners counter-clockwise seen from the left. Side 0 is the end of the previous strip.
#[derive(Clone, Debug)]
pub(super) struct Facet {
    pub corners: [Vec3; 3],
    pub normal: Vec3,           // unit, to the left
    pub texture: [[f64; 2]; 3], // distances along the blade and along its path, m
    across: [Vec3; 2],          // unit, along side 0 and to its left
    pub flat: [[f64; 2]; 3],    // corners in the frame of the facet, m
    pub front: usize,           // side where the strip continues
    pub continues: bool,        // whether side 0 is the end of a previous facet, not the beginning of the stroke
}

impl Stroke {
    /// Begins a stroke at this blade.
    ///
    /// # Errors
    /// [`Refused`] if a coordinate is not finite or beyond 1e9 m, or the blade has no length.
    pub fn begin(blade: Blade) -> Result<Self, Refused> {
        blade.check()?;
        Ok(Self { blade, seam: Vec::new(), travel: 0.0 })
    }

    /// The blade after the last advance.
    pub fn blade(&self) -> Blade {
        self.blade
    }

    /// The zero to two triangles swept from the last blade to `next`, between `parts` of both.
    pub(super) fn facets(&self, next: &Blade, parts: [Blade; 2]) -> Vec<Facet> {
        let [a, b, c, d] = [parts[0].tip, parts[0].heel, parts[1].heel, parts[1].tip];
        let (from, to) = (self.travel, self.travel + self.blade.way(next));
        let [at_a, at_b] = [a, b].map(|end| [(end - self.blade.tip).norm(), from]);
        let [at_c, at_d] = [c, d].map(|end| [(end - next.tip).norm(), to]);
        let near = Facet::new([a, b, c], [at_a, at_b, at_c], 2);
        let far = Facet::new([a, c, d], [at_a, at_c, at_d], 1);
        let mut facets: Vec<Facet> = [near, far].into_iter().flatten().collect();
        let began = self.travel > 0.0;
        facets.iter_mut().enumerate().for_each(|(at, facet)| facet.continues = began || at > 0);
        facets
    }
}

impl Blade {
    /// The blade moved by `by`, m.
    #[must_use]
    pub fn moved(&self, by: Vec3) -> Self {
        Self { tip: self.tip + by, heel: self.heel + by }
    }

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

    /// Mean distance that the two ends have to another blade, m.
    pub(super) fn way(&self, next: &Self) -> f64 {
        0.5 * ((next.tip - self.tip).norm() + (next.heel - self.heel).norm())
    }
}

impl Facet {
    /// A facet; `None` if its area vanishes, because the blade moved along itself or one end did not move.
    fn new(corners: [Vec3; 3], texture: [[f64; 2]; 3], front: usize) -> Option<Self> {
        let [a, b, c] = corners;
        let longest = longest_side(&corners);
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-6 * longest * longest)?;
        let along = (b - a).try_normalize(0.0)?;
        let across = [along, normal.cross(&along)];
        let mut facet = Self { corners, normal, texture, across, flat: [[0.0; 2]; 3], front, continues: false };
        facet.flat = corners.map(|corner| facet.flatten(corner));
        Some(facet)
    }

    /// Side of the plane a point is on, by an exact predicate: 1 left, -1 right, 0 on it.
    pub fn side(&self, point: Vec3) -> i8 {
        let [a, b, c, d] = [self.corners[0], self.corners[1], self.corners[2], point].map(coord);
        sign(-orient3d(a, b, c, d))
    }

    /// Signed distance of a point from the plane, m; positive on the left.
    pub fn height(&self, point: Vec3) -> f64 {
        (point - self.corners[0]).dot(&self.normal)
    }

    /// Coordinates of a point's projection in the frame of the facet, m.
    pub fn flatten(&self, point: Vec3) -> [f64; 2] {
        let from_corner = point - self.corners[0];
        self.across.map(|axis| from_corner.dot(&axis))
    }

    /// The point of the plane with these coordinates in the frame, m.
    pub fn lift(&self, flat: [f64; 2]) -> Vec3 {
        self.corners[0] + flat[0] * self.across[0] + flat[1] * self.across[1]
    }

    /// Ends of a side in the frame, m.
    pub fn rim(&self, side: usize) -> [[f64; 2]; 2] {
        [self.flat[side], self.flat[(side + 1) % 3]]
    }

    /// Distance of the longest side from the corner that is not on it, m.
    pub fn width(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a)).norm() / longest_side(&self.corners)
    }

    /// Texture coordinates of a point in the frame, m.
    pub fn texture_at(&self, flat: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.flat;
        let turn =
            |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let all = turn(a, b, c);
        let weights = [turn(b, c, flat) / all, turn(c, a, flat) / all, turn(a, b, flat) / all];
        [0, 1].map(|i| (0..3).map(|corner| weights[corner] * self.texture[corner][i]).sum())
    }
}

/// Length of the longest side of a triangle, m.
pub(super) fn longest_side([a, b, c]: &[Vec3; 3]) -> f64 {
    (b - a).norm().max((c - b).norm()).max((a - c).norm())
}

/// Side of the line from `a` to `b` that `c` is on, by an exact predicate: 1 left, -1 right, 0 on it.
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
