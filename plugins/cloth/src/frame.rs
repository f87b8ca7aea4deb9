//! The corotated frame of a triangle, and the strain in it.
//!
//! `F = T L`: T (3 x 2) has orthonormal columns, L (2 x 2) is the stretch. That leaves one number free, the rotation of T about the
//! normal, which a condition `K : L = 0` fixes: L is symmetric (polar decomposition, the default: Etzmuss, Keckeisen and Strasser
//! 2003), or the first edge keeps its direction (Tripicchio, D'Avella and Ruffaldi 2022), which is cheaper and depends on the order of
//! the corners. The strain is `sym(L) - I`.
//!
//! With `A = T^T dF` and J the rotation by 90 degrees, T rotates about the normal by the spin `w = K:A / K:JL`, and L changes by
//! `A - w J L`. This is the whole first derivative, so forces made with it are the gradient of the energy. Without w, as often seen,
//! they are the gradient for isotropic sheets only.

use crate::vector::{Mat2, Vec2, Vec3, Voigt, perpendicular};
use pliant_plugin_api::lanes::Real;

/// Area over rest area below which a triangle counts as collapsed.
const COLLAPSED: f64 = 1e-6;

/// The condition that fixes the rotation of the frame about the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameRule {
    /// L is symmetric.
    Polar,
    /// The first edge keeps its direction.
    Edge,
}

/// The frame of a deformed triangle.
pub(crate) struct Frame<T = f64> {
    /// The columns of T: directions of warp and weft in space.
    pub(crate) axes: [Vec3<T>; 2],
    /// Unit normal of the triangle.
    pub(crate) normal: Vec3<T>,
    /// L in `F = T L`.
    pub(crate) stretch: Mat2<T>,
    /// K of the condition `K : L = 0`.
    condition: Mat2<T>,
    /// `1 / K:JL`
    inverse_k_jl: T,
}

impl Frame {
    /// A frame along the longest column of F. A line or a point has no normal, so any direction perpendicular to it is taken.
    #[cold]
    fn collapsed(rule: FrameRule, f: [Vec3; 2], third: Vec2) -> Self {
        let longest = if f[0].dot(f[0]) >= f[1].dot(f[1]) { f[0] } else { f[1] };
        let norm = longest.norm();
        let e = if norm > f64::MIN_POSITIVE { longest * (1.0 / norm) } else { Vec3([1.0, 0.0, 0.0]) };
        let along = [e.dot(f[0]), e.dot(f[1])];
        let norm = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let v = if norm > f64::MIN_POSITIVE { [along[0] / norm, along[1] / norm] } else { [1.0, 0.0] };
        let left = perpendicular(e);
        let axes = [e * v[0] + left * -v[1], e * v[1] + left * v[0]];
        let stretch = match rule {
            FrameRule::Polar => [[norm * v[0] * v[0], norm * v[0] * v[1]], [norm * v[0] * v[1], norm * v[1] * v[1]]],
            FrameRule::Edge => [0, 1].map(|i| [axes[i].dot(f[0]), axes[i].dot(f[1])]),
        };
        let condition = condition(rule, third);
        Self { axes, normal: e.cross(left), stretch, condition, inverse_k_jl: inverse_k_jl(&condition, &stretch) }
    }
}

/// Number of values of a frame, for selecting between two frames per lane.
const VALUES: usize = 18;

impl<T: Real> Frame<T> {
    /// From the columns of a deformation gradient; `third` is the shape function gradient of the last corner, which is perpendicular
    /// to the first edge.
    #[inline(always)]
    pub(crate) fn new(rule: FrameRule, f: [Vec3<T>; 2], third: Vec2<T>) -> Self {
        let regular = Self::regular(rule, f, third);
        if !f[0].cross(f[1]).norm().any_below(COLLAPSED) {
            return regular;
        }
        Self::from_values(Self::with_collapsed_lanes(rule, f, third))
    }

    /// The frame where some lanes have collapsed. The other lanes get the values [`Frame::regular`] gives, so that an element's
    /// result does not depend on its neighbours in the register.
    #[cold]
    fn with_collapsed_lanes(rule: FrameRule, f: [Vec3<T>; 2], third: Vec2<T>) -> [T; VALUES] {
        let mut input = [third[0]; VALUES];
        input[..3].copy_from_slice(&f[0].0);
        input[3..6].copy_from_slice(&f[1].0);
        input[6..8].copy_from_slice(&third);
        let collapsed = T::map_lanes(input, |v| {
            let f = [Vec3([v[0], v[1], v[2]]), Vec3([v[3], v[4], v[5]])];
            Frame::collapsed(rule, f, [v[6], v[7]]).values()
        });
        let (area, mut values) = (f[0].cross(f[1]).norm(), Self::regular(rule, f, third).values());
        for i in 0..VALUES {
            values[i] = area.if_less(area.splat(COLLAPSED), collapsed[i], values[i]);
        }
        values
    }

    /// Inverse of [`Frame::values`].
    #[inline(always)]
    fn from_values(v: [T; VALUES]) -> Self {
        Self {
            axes: [Vec3([v[0], v[1], v[2]]), Vec3([v[3], v[4], v[5]])],
            normal: Vec3([v[6], v[7], v[8]]),
            stretch: [[v[9], v[10]], [v[11], v[12]]],
            condition: [[v[13], v[14]], [v[15], v[16]]],
            inverse_k_jl: v[17],
        }
    }

    /// All numbers of the frame in one array.
    fn values(&self) -> [T; VALUES] {
        let Self { axes: [t, u], normal: n, stretch: [l, m], condition: [k, j], inverse_k_jl } = self;
        let mut values = [t[0]; VALUES];
        for (i, vector) in [t, u, n].into_iter().enumerate() {
            values[3 * i..3 * i + 3].copy_from_slice(&vector.0);
        }
        for (i, row) in [l, m, k, j].into_iter().enumerate() {
            values[9 + 2 * i..11 + 2 * i].copy_from_slice(row);
        }
        values[17] = *inverse_k_jl;
        values
    }

    /// The frame of a triangle that has not collapsed.
    #[inline(always)]
    fn regular(rule: FrameRule, f: [Vec3<T>; 2], third: Vec2<T>) -> Self {
        let area = f[0].cross(f[1]);
        let d = area.norm();
        let condition = condition(rule, third);
        match rule {
            FrameRule::Polar => {
                let (a, b, c) = (f[0].dot(f[0]), f[0].dot(f[1]), f[1].dot(f[1]));
                let trace = (a + c + d * 2.0).sqrt();
                // One division in the place of two: multiplications are cheaper.
                let inverse_product = d.splat(1.0) / (d * trace);
                let (inverse_d, inverse_trace) = (inverse_product * trace, inverse_product * d);
                // L = (F^T F + d I) / trace is the square root of F^T F, with det L = d.
                let l = [[(a + d) * inverse_trace, b * inverse_trace], [b * inverse_trace, (c + d) * inverse_trace]];
                let (p, q, r) = (l[1][1] * inverse_d, -l[0][1] * inverse_d, l[0][0] * inverse_d);
                let axes = [f[0] * p + f[1] * q, f[0] * q + f[1] * r];
                Self { axes, normal: area * inverse_d, stretch: l, condition, inverse_k_jl: inverse_trace }
            }
            FrameRule::Edge => {
                let EdgeDirections { along: u, left: v } = edge_directions(third);
                let edge = f[0] * u[0] + f[1] * u[1];
                let (e, normal) = (edge * (d.splat(1.0) / edge.norm()), area * (d.splat(1.0) / d));
                let left = normal.cross(e);
                let axes = [e * u[0] + left * v[0], e * u[1] + left * v[1]];
                let [t, w] = axes;
                let stretch = [[t.dot(f[0]), t.dot(f[1])], [w.dot(f[0]), w.dot(f[1])]];
                Self { axes, normal, stretch, condition, inverse_k_jl: inverse_k_jl(&condition, &stretch) }
            }
        }
    }

    /// Strain `sym(L) - I`.
    #[inline(always)]
    pub(crate) fn strain(&self) -> Voigt<T> {
        let l = &self.stretch;
        let one = l[0][0].splat(1.0);
        [l[0][0] - one, l[1][1] - one, l[0][1] + l[1][0]]
    }

    /// Minus the derivative of the strain by the spin at fixed F, `sym(J L)`.
    #[inline(always)]
    pub(crate) fn spin_strain(&self) -> Voigt<T> {
        let l = &self.stretch;
        [-l[1][0], l[0][1], l[0][0] - l[1][1]]
    }

    /// The spin as a function of A: `w = spin_gradient : A`.
    #[inline(always)]
    pub(crate) fn spin_gradient(&self) -> Mat2<T> {
        let (k, inverse) = (&self.condition, self.inverse_k_jl);
        [[k[0][0] * inverse, k[0][1] * inverse], [k[1][0] * inverse, k[1][1] * inverse]]
    }

    /// `K / K:J` as (11, 22, 12), for the second derivative.
    #[inline(always)]
    pub(crate) fn normalised_condition(&self) -> Voigt<T> {
        let k = &self.condition;
        let k_j = k[1][0] - k[0][1];
        [k[0][0] / k_j, k[1][1] / k_j, (k[0][1] + k[1][0]) * 0.5 / k_j]
    }
}

/// `1 / K:JL`, bounded where a triangle has collapsed to a point and has no rotation.
#[inline(always)]
fn inverse_k_jl<T: Real>(k: &Mat2<T>, l: &Mat2<T>) -> T {
    let k_jl = k[1][0] * l[0][0] + k[1][1] * l[0][1] - k[0][0] * l[1][0] - k[0][1] * l[1][1];
    let least = k_jl.splat(COLLAPSED);
    k_jl.splat(1.0) / k_jl.abs().if_less(least, least, k_jl)
}

/// Unit vectors in the sheet along the first edge and to its left.
struct EdgeDirections<T> {
    along: Vec2<T>,
    left: Vec2<T>,
}

/// From the shape function gradient of the last corner, which points to the left of the first edge.
#[inline(always)]
fn edge_directions<T: Real>(third: Vec2<T>) -> EdgeDirections<T> {
    let norm = (third[0] * third[0] + third[1] * third[1]).sqrt();
    let left = [third[0] / norm, third[1] / norm];
    EdgeDirections { along: [left[1], -left[0]], left }
}

/// The condition K of a rule; `third` is the shape function gradient of the last corner.
#[inline(always)]
fn condition<T: Real>(rule: FrameRule, third: Vec2<T>) -> Mat2<T> {
    match rule {
        FrameRule::Polar => {
            let (zero, one) = (third[0].splat(0.0), third[0].splat(1.0));
            [[zero, -one], [one, zero]]
        }
        FrameRule::Edge => {
            let EdgeDirections { along: u, left: v } = edge_directions(third);
            [[v[0] * u[0], v[0] * u[1]], [v[1] * u[0], v[1] * u[1]]]
        }
    }
}
