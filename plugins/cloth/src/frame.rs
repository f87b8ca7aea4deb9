//! The frame that turns with a triangle, and the strain in it.
//!
//! `F = T L`: T (3 x 2) has unit columns at right angles, L (2 x 2) is the stretch. One number is free, the turn of T about the
//! normal, and a condition `K : L = 0` fixes it: L symmetric (polar, the default: Etzmuss, Keckeisen and Strasser 2003), or
//! the first edge keeping its direction (Tripicchio, D'Avella and Ruffaldi 2022), which is cheaper and depends on the order of
//! the corners. The strain is `sym(L) - I`.
//!
//! With `A = T^T dF`, T turns by `w = K:A / K:JL` about the normal, and L changes by `A - w J L`. That is the whole first
//! derivative, so forces made with it are the slope of the energy; leaving w out, as is often done, is right for isotropic
//! sheets only.

use crate::small::{M2, V2, V3, across, cross, dot, length, mixed, scaled};
use pliant_plugin_api::lanes::Real;

/// Below this area over area at rest a triangle counts as collapsed.
const COLLAPSED: f64 = 1e-6;

/// Which condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    Polar,
    Edge,
}

pub(crate) struct Frame<T = f64> {
    /// The columns of T: where warp and weft point, in space.
    pub(crate) axes: [V3<T>; 2],
    pub(crate) normal: V3<T>,
    /// L
    pub(crate) stretch: M2<T>,
    /// K
    condition: M2<T>,
    /// `1 / K:JL`
    turning: T,
}

impl Frame {
    /// Any frame along what length is left: the normal of a line or a point is nobody's.
    #[cold]
    fn collapsed(rule: Rule, f: [V3; 2], third: V2) -> Self {
        let longest = if dot(f[0], f[0]) >= dot(f[1], f[1]) { f[0] } else { f[1] };
        let size = length(longest);
        let e = if size > f64::MIN_POSITIVE { scaled(longest, 1.0 / size) } else { [1.0, 0.0, 0.0] };
        let rest = [dot(e, f[0]), dot(e, f[1])];
        let size = (rest[0] * rest[0] + rest[1] * rest[1]).sqrt();
        let v = if size > f64::MIN_POSITIVE { [rest[0] / size, rest[1] / size] } else { [1.0, 0.0] };
        let left = across(e);
        let axes = [mixed(v[0], e, -v[1], left), mixed(v[1], e, v[0], left)];
        let stretch = match rule {
            Rule::Polar => [[size * v[0] * v[0], size * v[0] * v[1]], [size * v[0] * v[1], size * v[1] * v[1]]],
            Rule::Edge => [0, 1].map(|i| [dot(axes[i], f[0]), dot(axes[i], f[1])]),
        };
        let condition = condition(rule, third);
        Self { axes, normal: cross(e, left), stretch, condition, turning: turning(&condition, &stretch) }
    }
}

/// Numbers in a frame.
const VALUES: usize = 18;

impl<T: Real> Frame<T> {
    /// Of a deformation gradient's columns; `third` is the gradient of the last corner's weight, across the first edge.
    #[inline(always)]
    pub(crate) fn new(rule: Rule, f: [V3<T>; 2], third: V2<T>) -> Self {
        let regular = Self::regular(rule, f, third);
        if !length(cross(f[0], f[1])).any_below(COLLAPSED) {
            return regular;
        }
        Self::of(Self::one_by_one(rule, f, third))
    }

    /// The same where some have collapsed. Others are as they would be beside any: their numbers do not depend on who is near.
    #[cold]
    fn one_by_one(rule: Rule, f: [V3<T>; 2], third: V2<T>) -> [T; VALUES] {
        let mut given = [third[0]; VALUES];
        given[..3].copy_from_slice(&f[0]);
        given[3..6].copy_from_slice(&f[1]);
        given[6..8].copy_from_slice(&third);
        let collapsed = T::map_lanes(given, |v| {
            Frame::collapsed(rule, [[v[0], v[1], v[2]], [v[3], v[4], v[5]]], [v[6], v[7]]).values()
        });
        let (size, mut v) = (length(cross(f[0], f[1])), Self::regular(rule, f, third).values());
        for i in 0..VALUES {
            v[i] = size.if_less(size.splat(COLLAPSED), collapsed[i], v[i]);
        }
        v
    }

    #[inline(always)]
    fn of(v: [T; VALUES]) -> Self {
        Self {
            axes: [[v[0], v[1], v[2]], [v[3], v[4], v[5]]],
            normal: [v[6], v[7], v[8]],
            stretch: [[v[9], v[10]], [v[11], v[12]]],
            condition: [[v[13], v[14]], [v[15], v[16]]],
            turning: v[17],
        }
    }

    /// All of it in a row.
    fn values(&self) -> [T; VALUES] {
        let Self { axes: [t, u], normal: n, stretch: [l, m], condition: [k, j], turning } = self;
        let mut values = [t[0]; VALUES];
        for (at, vector) in [t, u, n].into_iter().enumerate() {
            values[3 * at..3 * at + 3].copy_from_slice(vector);
        }
        for (at, row) in [l, m, k, j].into_iter().enumerate() {
            values[9 + 2 * at..11 + 2 * at].copy_from_slice(row);
        }
        values[17] = *turning;
        values
    }

    #[inline(always)]
    fn regular(rule: Rule, f: [V3<T>; 2], third: V2<T>) -> Self {
        let area = cross(f[0], f[1]);
        let d = length(area);
        let condition = condition(rule, third);
        match rule {
            Rule::Polar => {
                let (a, b, c) = (dot(f[0], f[0]), dot(f[0], f[1]), dot(f[1], f[1]));
                let trace = (a + c + d * 2.0).sqrt();
                // One division for two: products take less.
                let both = d.splat(1.0) / (d * trace);
                let (inverse, over) = (both * trace, both * d);
                let s = [[(a + d) * over, b * over], [b * over, (c + d) * over]];
                // The inverse of a 2 x 2 matrix, with det S = d.
                let (p, q, r) = (s[1][1] * inverse, -s[0][1] * inverse, s[0][0] * inverse);
                let axes = [mixed(p, f[0], q, f[1]), mixed(q, f[0], r, f[1])];
                Self { axes, normal: scaled(area, inverse), stretch: s, condition, turning: over }
            }
            Rule::Edge => {
                let (u, v) = edge(third);
                let along = mixed(u[0], f[0], u[1], f[1]);
                let (e, normal) = (scaled(along, d.splat(1.0) / length(along)), scaled(area, d.splat(1.0) / d));
                let left = cross(normal, e);
                let axes = [mixed(u[0], e, v[0], left), mixed(u[1], e, v[1], left)];
                let [t, u] = axes;
                let stretch = [[dot(t, f[0]), dot(t, f[1])], [dot(u, f[0]), dot(u, f[1])]];
                Self { axes, normal, stretch, condition, turning: turning(&condition, &stretch) }
            }
        }
    }

    /// (11, 22, gamma)
    #[inline(always)]
    pub(crate) fn strain(&self) -> [T; 3] {
        let l = &self.stretch;
        let one = l[0][0].splat(1.0);
        [l[0][0] - one, l[1][1] - one, l[0][1] + l[1][0]]
    }

    /// What the strain would change by for a turn of the frame alone: `sym(J L)`.
    #[inline(always)]
    pub(crate) fn turned_strain(&self) -> [T; 3] {
        let l = &self.stretch;
        [-l[1][0], l[0][1], l[0][0] - l[1][1]]
    }

    /// w as a function of A: `w = turn : A`.
    #[inline(always)]
    pub(crate) fn turn(&self) -> M2<T> {
        let (k, inverse) = (&self.condition, self.turning);
        [[k[0][0] * inverse, k[0][1] * inverse], [k[1][0] * inverse, k[1][1] * inverse]]
    }

    /// K as (11, 22, 12), over `K : J`; for the second derivative.
    #[inline(always)]
    pub(crate) fn condition(&self) -> [T; 3] {
        let k = &self.condition;
        let size = k[1][0] - k[0][1];
        [k[0][0] / size, k[1][1] / size, (k[0][1] + k[1][0]) * 0.5 / size]
    }
}

/// `1 / K:JL`
#[inline(always)]
fn turning<T: Real>(k: &M2<T>, l: &M2<T>) -> T {
    let size = k[1][0] * l[0][0] + k[1][1] * l[0][1] - k[0][0] * l[1][0] - k[0][1] * l[1][1];
    // A triangle drawn together to a point has no direction to turn.
    let least = size.splat(COLLAPSED);
    size.splat(1.0) / size.abs().if_less(least, least, size)
}

/// The direction of the first edge in the sheet, and the one to its left.
#[inline(always)]
fn edge<T: Real>(third: V2<T>) -> (V2<T>, V2<T>) {
    let size = (third[0] * third[0] + third[1] * third[1]).sqrt();
    let v = [third[0] / size, third[1] / size];
    ([v[1], -v[0]], v)
}

#[inline(always)]
fn condition<T: Real>(rule: Rule, third: V2<T>) -> M2<T> {
    match rule {
        Rule::Polar => {
            let (zero, one) = (third[0].splat(0.0), third[0].splat(1.0));
            [[zero, -one], [one, zero]]
        }
        Rule::Edge => {
            let (u, v) = edge(third);
            [[v[0] * u[0], v[0] * u[1]], [v[1] * u[0], v[1] * u[1]]]
        }
    }
}
