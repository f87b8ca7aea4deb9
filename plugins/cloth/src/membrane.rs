//! Energy, forces and stiffness of a triangle in its plane: `area / 2 e : C : e`.
//!
//! Two strains: that of the frame (`sym(L) - I`), or Green's, `(F^T F - I) / 2`, which sees no false stretch of the yarns in
//! shear and softens in compression.

use crate::frame::{Frame, Rule};
use crate::small::{M2, V2, V3, dot, mixed, times};
use crate::tension::relaxed;
use crate::tensor::Tensor;
use crate::triangle::{Linear, Triangle, positive};
use pliant_plugin_api::lanes::Real;

/// Which strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Strain {
    Frame(Rule),
    Green,
}

/// What the sheet is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Membrane {
    pub(crate) strain: Strain,
    pub(crate) tensor: Tensor,
    /// s, viscosity over stiffness
    pub(crate) damping: f64,
    /// Share of compression that stays: 1 of a sheet that does not wrinkle, 0 of one that gives way.
    pub(crate) compression: f64,
    /// Whether the matrix goes without its negative part.
    pub(crate) project: bool,
}

/// Least area over area at rest for which tension is divided by it; in the matrix only.
const THIN: f64 = 1e-3;

impl Membrane {
    /// J/m^2
    pub(crate) fn energy(&self, shape: &Triangle, f: [V3; 2]) -> f64 {
        let e = match self.strain {
            Strain::Frame(rule) => Frame::new(rule, f, shape.gradient[2]).strain(),
            Strain::Green => green(f),
        };
        let [_, _, _, energy] = self.elastic(e);
        energy
    }

    /// Stress (11, 22, 12), N/m, and energy, J/m^2: of the whole tensor, less what wrinkles take.
    #[inline(always)]
    fn elastic<T: Real>(&self, e: [T; 3]) -> [T; 4] {
        let q = self.tensor.stress(e);
        let whole = [q[0], q[1], q[2], contracted(e, q) * 0.5];
        let kept = self.compression;
        if kept == 1.0 {
            return whole;
        }
        let [e11, e22, gamma] = e;
        let relaxed = T::map_lanes([e11, e22, gamma, e11], |[a, b, c, _]| {
            let (q, energy) = relaxed(&self.tensor, [a, b, c]);
            [q[0], q[1], q[2], energy]
        });
        let (a, b, lost) = (whole, relaxed, 1.0 - kept);
        [a[0] * kept + b[0] * lost, a[1] * kept + b[1] * lost, a[2] * kept + b[2] * lost, a[3] * kept + b[3] * lost]
    }

    /// Stress, N/m, with the viscous one of the rate of strain, where there is one.
    #[inline(always)]
    fn moving<T: Real>(&self, e: [T; 3], rate: Option<[T; 3]>) -> [T; 3] {
        let [a, b, c, _] = self.elastic(e);
        let Some(rate) = rate else { return [a, b, c] };
        let viscous = times(self.tensor.stress(rate), self.damping);
        [a + viscous[0], b + viscous[1], c + viscous[2]]
    }

    /// First Piola-Kirchhoff stress by columns, N/m, with the viscous one of the rate of F, where there is one.
    #[inline(always)]
    pub(crate) fn stress<T: Real>(&self, shape: &Triangle<T>, f: [V3<T>; 2], rate: Option<[V3<T>; 2]>) -> [V3<T>; 2] {
        match self.strain {
            Strain::Frame(rule) => {
                let frame = Frame::new(rule, f, shape.gradient[2]);
                let turned = frame.turned_strain();
                let turn = frame.turn();
                let [t, u] = frame.axes;
                let speed = rate.map(|rate| {
                    let a = [[dot(t, rate[0]), dot(t, rate[1])], [dot(u, rate[0]), dot(u, rate[1])]];
                    let w = turn[0][0] * a[0][0] + turn[0][1] * a[0][1] + turn[1][0] * a[1][0] + turn[1][1] * a[1][1];
                    [a[0][0] - w * turned[0], a[1][1] - w * turned[1], a[0][1] + a[1][0] - w * turned[2]]
                });
                let q = self.moving(frame.strain(), speed);
                let p = local(q, contracted(q, turned), turn);
                [mixed(p[0][0], t, p[1][0], u), mixed(p[0][1], t, p[1][1], u)]
            }
            Strain::Green => {
                let speed = rate.map(|rate| {
                    let cross = dot(f[0], rate[1]) + dot(f[1], rate[0]);
                    [dot(f[0], rate[0]), dot(f[1], rate[1]), cross]
                });
                let q = self.moving(green(f), speed);
                [mixed(q[0], f[0], q[2], f[1]), mixed(q[2], f[0], q[1], f[1])]
            }
        }
    }

    /// `stiffness` K + `damping` C, before the area.
    ///
    /// K is the exact second derivative if not `project`, but for wrinkles, which only soften it. With it, tension alone resists
    /// turning out of the plane, and the turn of the frame gets at least what keeps the rest positive: never softer than exact.
    #[inline(always)]
    pub(crate) fn linear<T: Real>(
        &self,
        shape: &Triangle<T>,
        f: [V3<T>; 2],
        (stiffness, damping): (f64, f64),
    ) -> Linear<T> {
        let tensor = &self.tensor;
        let size = stiffness + damping * self.damping;
        let (zero, one) = (f[0][0].splat(0.0), f[0][0].splat(1.0));
        let inner = [tensor.c11, tensor.c22, tensor.c12, tensor.shear];
        let inner = [
            zero.splat(size * inner[0]),
            zero.splat(size * inner[1]),
            zero.splat(size * inner[2]),
            zero.splat(size * inner[3]),
        ];
        let [_, b, c] = shape.gradient;
        match self.strain {
            Strain::Green => {
                let [s11, s22, s12, _] = self.elastic(green(f));
                let s = [s11, s22, s12];
                let tension = times(if self.project { positive(s) } else { s }, stiffness);
                // A step along a column of F changes the strain by the weight's gradient.
                let rows = [
                    [[b[0], zero], [zero, b[1]], [b[1], b[0]], [zero; 2]],
                    [[c[0], zero], [zero, c[1]], [c[1], c[0]], [zero; 2]],
                ];
                Linear { axes: f, rows, inner, turn: [zero; 4], tension, turning: [one, one, one, zero, zero, zero] }
            }
            Strain::Frame(rule) => {
                let frame = Frame::new(rule, f, shape.gradient[2]);
                let (turned, turn) = (frame.turned_strain(), frame.turn());
                let rows = [local_rows(b, turned, turn), local_rows(c, turned, turn)];
                let [q11, q22, q12, _] = self.elastic(frame.strain());
                let q = [q11, q22, q12];
                let l = &frame.stretch;
                let p = local(q, contracted(q, turned), turn);
                let k = frame.condition();
                let trace = p[0][0] + p[1][1];
                let m = [-p[1][0] - trace * k[0], p[0][1] - trace * k[1], (p[0][0] - p[1][1]) * 0.5 - trace * k[2]];
                let own = q[0] * l[0][0] + q[1] * l[1][1] + q[2] * (l[0][1] + l[1][0]);
                let own = if self.project { own.max(tensor.compliant(m, m)) } else { own };
                let s = second(l, &p);
                let tension = times(if self.project { positive(s) } else { s }, stiffness);
                let n = frame.normal;
                let turning = [n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1], n[0] * n[2], n[1] * n[2]];
                let turn = [m[0] * stiffness, m[1] * stiffness, m[2] * stiffness, own * stiffness];
                Linear { axes: frame.axes, rows, inner, turn, tension, turning }
            }
        }
    }
}

/// Change of (11, 22, gamma) and of the frame's turn, for a step of a corner along the frame's axes.
#[inline(always)]
fn local_rows<T: Real>(g: V2<T>, turned: [T; 3], turn: M2<T>) -> [V2<T>; 4] {
    let w = [turn[0][0] * g[0] + turn[0][1] * g[1], turn[1][0] * g[0] + turn[1][1] * g[1]];
    [
        [g[0] - turned[0] * w[0], -(turned[0] * w[1])],
        [-(turned[1] * w[0]), g[1] - turned[1] * w[1]],
        [g[1] - turned[2] * w[0], g[0] - turned[2] * w[1]],
        w,
    ]
}

/// (11, 22, gamma)
#[inline(always)]
fn green<T: Real>(f: [V3<T>; 2]) -> [T; 3] {
    let one = f[0][0].splat(1.0);
    [(dot(f[0], f[0]) - one) * 0.5, (dot(f[1], f[1]) - one) * 0.5, dot(f[0], f[1])]
}

#[inline(always)]
fn contracted<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// First Piola-Kirchhoff stress in the frame, from the frame's stress and what a turn of the frame takes.
#[inline(always)]
fn local<T: Real>(q: [T; 3], taken: T, turn: M2<T>) -> M2<T> {
    [[q[0] - taken * turn[0][0], q[2] - taken * turn[0][1]], [q[2] - taken * turn[1][0], q[1] - taken * turn[1][1]]]
}

/// Second Piola-Kirchhoff stress L^-1 P, (11, 22, 12).
#[inline(always)]
fn second<T: Real>(l: &M2<T>, p: &M2<T>) -> [T; 3] {
    let det = l[0][0] * l[1][1] - l[0][1] * l[1][0];
    let over = det.splat(1.0) / det.max(det.splat(THIN));
    let [[a, b], [c, d]] = [[l[1][1], -l[0][1]], [-l[1][0], l[0][0]]];
    let (s11, s12) = ((a * p[0][0] + b * p[1][0]) * over, a * p[0][1] + b * p[1][1]);
    let (s21, s22) = (c * p[0][0] + d * p[1][0], (c * p[0][1] + d * p[1][1]) * over);
    [s11, s22, (s12 + s21) * 0.5 * over]
}
