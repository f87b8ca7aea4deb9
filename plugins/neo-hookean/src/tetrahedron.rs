//! A tetrahedron with linear shape functions: one deformation gradient.

use crate::energy::Curvature;
use crate::matrix::{M3, cofactors, determinant, dot, product, product_transposed, times, transposed};
use pliant_plugin_api::Elements;

/// Values of rest data of an element: the gradients of the last three corners' weights, then its volume.
pub(crate) const STRIDE: usize = 10;

/// The rest shape of one.
pub(crate) struct Tetrahedron {
    /// 1/m, gradient of each corner's weight (4 x 3)
    pub(crate) gradient: [[f64; 3]; 4],
    /// m^3
    pub(crate) volume: f64,
}

impl Tetrahedron {
    /// From the rest places of its corners, m; `None` where it has no volume.
    pub(crate) fn new(x: [[f64; 3]; 4], share: f64) -> Option<Self> {
        let edges = [1, 2, 3].map(|a| [0, 1, 2].map(|i| x[a][i] - x[0][i]));
        let six = determinant(&edges);
        if !(six.is_finite() && six > 0.0 && share > 0.0) {
            return None;
        }
        // Edges as rows: the inverse has the gradients as columns, and its transpose is cofactors over determinant.
        let gradients = cofactors(&edges).map(|row| row.map(|c| c / six));
        Some(Self::whole(gradients, share * six / 6.0))
    }

    #[inline(always)]
    fn whole([b, c, d]: M3, volume: f64) -> Self {
        let a = [0, 1, 2].map(|i| -(b[i] + c[i] + d[i]));
        Self { gradient: [a, b, c, d], volume }
    }

    /// As values of rest data.
    pub(crate) fn values(&self) -> [f64; STRIDE] {
        let g = &self.gradient;
        std::array::from_fn(|s| if s < 9 { g[1 + s / 3][s % 3] } else { self.volume })
    }

    /// Back from planes of rest data.
    #[inline(always)]
    pub(crate) fn read(planes: &[&[f64]; STRIDE], e: usize) -> Self {
        let at = |s: usize| planes[s][e];
        let gradients = [0, 3, 6].map(|s| [at(s), at(s + 1), at(s + 2)]);
        Self::whole(gradients, at(9))
    }

    /// `sum_a p_a gradient_a^T`: of positions the deformation gradient, of velocities its rate.
    #[inline(always)]
    pub(crate) fn derivative(&self, p: [[f64; 3]; 4]) -> M3 {
        let [a, b, c] = [1, 2, 3].map(|k| [p[k][0] - p[0][0], p[k][1] - p[0][1], p[k][2] - p[0][2]]);
        let [_, g, h, k] = self.gradient;
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[i] * g[j] + b[i] * h[j] + c[i] * k[j]))
    }

    /// Blocks (a, b), a <= b, of volume times a curvature, N/m: given to `out` with their number.
    pub(crate) fn stiffness(&self, scale: f64, c: &Curvature, mut out: impl FnMut(usize, M3)) {
        let factor = scale * self.volume;
        let g = self.gradient.map(|g| [0, 1, 2].map(|j| dot(g, [c.v[0][j], c.v[1][j], c.v[2][j]])));
        let mut pair = 0;
        for a in 0..4 {
            for b in a..4 {
                let mut k = [[0.0; 3]; 3];
                for i in 0..3 {
                    for j in 0..3 {
                        if i == j {
                            k[i][i] += c.scaling[i][i] * g[a][i] * g[b][i];
                        } else {
                            k[i][j] += c.scaling[i][j] * g[a][i] * g[b][j] + c.other[i][j] * g[a][j] * g[b][i];
                            k[i][i] += c.own[i][j] * g[a][j] * g[b][j];
                        }
                    }
                }
                let k = k.map(|row| row.map(|v| factor * v));
                out(pair, product(&c.u, &product_transposed(&k, &c.u)));
                pair += 1;
            }
        }
    }

    /// The same of a viscosity that acts on the rate of Green's strain, N s/m: with shear `eta` and dilation `zeta`, Pa s.
    pub(crate) fn viscosity(&self, f: &M3, (eta, zeta): (f64, f64), mut out: impl FnMut(usize, M3)) {
        let (eta, zeta) = (eta * self.volume, zeta * self.volume);
        let g = self.gradient;
        let fg = g.map(|g| times(f, g));
        let ff = product_transposed(f, f);
        let mut pair = 0;
        for a in 0..4 {
            for b in a..4 {
                let gg = dot(g[a], g[b]);
                let block =
                    |i: usize, j: usize| eta * (ff[i][j] * gg + fg[b][i] * fg[a][j]) + zeta * fg[a][i] * fg[b][j];
                out(pair, [0, 1, 2].map(|i| [0, 1, 2].map(|j| block(i, j))));
                pair += 1;
            }
        }
    }
}

/// Stress of that viscosity, Pa: `F (2 eta E' + zeta tr(E') I)`, with `E'` the rate of Green's strain.
#[inline(always)]
pub(crate) fn viscous_stress(f: &M3, rate: &M3, (eta, zeta): (f64, f64)) -> M3 {
    let (ft, rt) = (transposed(f), transposed(rate));
    let strain = [0, 1, 2].map(|i| [0, 1, 2].map(|j| 0.5 * (dot(ft[i], rt[j]) + dot(rt[i], ft[j]))));
    let pressure = zeta * (strain[0][0] + strain[1][1] + strain[2][2]);
    let mut stress = strain.map(|row| row.map(|c| 2.0 * eta * c));
    (0..3).for_each(|i| stress[i][i] += pressure);
    product(f, &stress)
}

/// Values of the corners of an element.
#[inline(always)]
pub(crate) fn corners(nodes: [u32; 4], of: &[[f64; 3]]) -> [[f64; 3]; 4] {
    nodes.map(|n| of[n as usize])
}

/// Planes of rest data of a call.
pub(crate) fn planes<'a>(at: &Elements<'a>) -> [&'a [f64]; STRIDE] {
    std::array::from_fn(|s| at.rest_data(s))
}
