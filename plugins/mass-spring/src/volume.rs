//! Volume resistance: what keeps the cells of a lattice from collapsing.
//!
//! Central springs resist the shortening of edges and diagonals, not the loss of volume. A lattice of them that is squeezed by more than
//! about a third folds, and the force of a deep touch falls the more the finer the cells are. Each tetrahedron of a cell therefore
//! has an energy of its volume ratio J = V / V0, per rest volume, with t = 1 - J - [`START`], a = [`ONSET`] and the modulus kappa:
//!
//! ```text
//! psi = 0                                               t <= 0
//! psi = kappa t^4 / (12 a^2)                        0 < t <= a
//! psi = kappa (t^2 / 2 - 2 a t / 3 + a^2 / 4)       a < t
//! ```
//!
//! It is zero up to a loss that springs bear without folding, so the lattice keeps the Young's modulus, the Poisson's ratio and, in touches of
//! moderate depth, the forces of its springs. The second
//! derivative is at most kappa, which bounds the step of explicit integration, and psi grows on through inversion (J < 0).

use pliant_plugin_api::lanes::{MAX_LANES, Real, Vec3, Wide};
use pliant_plugin_api::solids::{CORNER_PAIRS, ElementBlocks, gather};
use pliant_plugin_api::{BlockScalar, Blocks, Elements, NodeVectors};
use pulp::{Simd, WithSimd};

/// Loss of volume from which on there is resistance.
pub const START: f64 = 0.1;
/// Loss of volume beyond [`START`] from which on the resistance is linear in it.
pub const ONSET: f64 = 0.15;
/// Doubles of rest data per tetrahedron: six times its rest volume (m^3), and kappa times that volume (J).
pub const STRIDE: usize = 2;

/// The tetrahedra of a call.
#[derive(Clone, Copy)]
pub struct Tetrahedra<'a> {
    nodes: &'a [[u32; 4]],
    /// Positions of all nodes, m.
    x: &'a [[f64; 3]],
    /// Six times the rest volume, m^3.
    six_volumes: &'a [f64],
    /// Modulus times rest volume, J.
    scale: &'a [f64],
}

/// Rest data of a tetrahedron with these rest positions (m), of which `share` belongs to the body, for a modulus kappa (Pa); `None` where
/// the volume is not positive.
pub fn rest_data(x: [Vec3; 4], share: f64, kappa: f64) -> Option<[f64; STRIDE]> {
    let six_volumes = six_volumes(x);
    let is_valid = six_volumes.is_finite() && six_volumes > 0.0 && share > 0.0;
    is_valid.then(|| [six_volumes, kappa * share * six_volumes / 6.0])
}

/// Six times the volume of a tetrahedron, m^3; negative when it is inverted.
#[inline(always)]
fn six_volumes<T: Real>(x: [Vec3<T>; 4]) -> T {
    (x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0]))
}

/// The derivative of six times the volume by each corner's position, m^2.
#[inline(always)]
fn gradients<T: Real>(x: [Vec3<T>; 4]) -> [Vec3<T>; 4] {
    let (b, c, d) = (x[1] - x[0], x[2] - x[0], x[3] - x[0]);
    let (gb, gc, gd) = (c.cross(d), d.cross(b), b.cross(c));
    [-(gb + gc + gd), gb, gc, gd]
}

/// `-psi' / kappa` of a loss of volume `t`: at least 0.
#[inline(always)]
fn pressure<T: Real>(t: T) -> T {
    let lost = (t - t.splat(START)).max(t.splat(0.0));
    lost.if_less(t.splat(ONSET), lost * lost * lost * (1.0 / (3.0 * ONSET * ONSET)), lost - t.splat(2.0 / 3.0 * ONSET))
}

/// `psi'' / kappa` of a loss of volume `t`: between 0 and 1.
#[inline(always)]
fn stiffness<T: Real>(t: T) -> T {
    let lost = (t - t.splat(START)).max(t.splat(0.0)) * (1.0 / ONSET);
    lost.if_less(t.splat(1.0), lost * lost, t.splat(1.0))
}

impl<'a> Tetrahedra<'a> {
    /// The tetrahedra of a call.
    pub fn new(elements: &'a Elements<'_>) -> Self {
        Self {
            nodes: elements.corners(),
            x: elements.x(),
            six_volumes: elements.rest_data(0),
            scale: elements.rest_data(1),
        }
    }

    /// Sum of the energies, J.
    pub fn energy(&self) -> f64 {
        let energy = |(e, nodes): (usize, &[u32; 4])| {
            let six = six_volumes(nodes.map(|n| Vec3(self.x[n as usize])));
            let t = ((self.six_volumes[e] - six) / self.six_volumes[e] - START).max(0.0);
            let psi = if t < ONSET {
                t.powi(4) / (12.0 * ONSET * ONSET)
            } else {
                0.5 * t * t - 2.0 / 3.0 * ONSET * t + 0.25 * ONSET * ONSET
            };
            self.scale[e] * psi
        };
        self.nodes.iter().enumerate().map(energy).sum()
    }

    /// Losses of volume of tetrahedra `e, e + 1, ..`; `None` where none is squeezed enough to resist.
    #[inline(always)]
    fn losses<S: Simd>(&self, simd: S, e: usize) -> Option<Losses<S>> {
        let x = gather(simd, self.nodes, e, self.x);
        let rest = Wide::load_clamped(simd, self.six_volumes, e);
        let inverse = rest.splat(1.0) / rest;
        let t = (rest - six_volumes(x)) * inverse;
        let squeezed = Squeezed::new(t, self.nodes.len() - e);
        (!squeezed.is_empty()).then_some(Losses { x, t, inverse, squeezed })
    }
}

/// Losses of volume of a few tetrahedra.
struct Losses<S: Simd> {
    /// Positions of the corners, m.
    x: [Vec3<Wide<S>>; 4],
    /// Loss of volume over the rest volume.
    t: Wide<S>,
    /// One over six times the rest volume, 1/m^3.
    inverse: Wide<S>,
    /// Lanes that resist.
    squeezed: Squeezed,
}

/// The lanes whose tetrahedron has lost more volume than [`START`]. The others add nothing, whatever lanes they share a register with.
#[derive(Clone, Copy)]
struct Squeezed(u8);

impl Squeezed {
    /// The lanes among the first `count` whose loss of volume `t` exceeds [`START`]. NaN counts too, so that it reaches the result.
    #[inline(always)]
    fn new<S: Simd>(t: Wide<S>, count: usize) -> Self {
        let (t, mut lanes) = (t.to_array(), 0);
        for lane in 0..S::F64_LANES.min(count) {
            lanes |= u8::from(t[lane] > START || t[lane].is_nan()) << lane;
        }
        Self(lanes)
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl Iterator for Squeezed {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < MAX_LANES).then_some(lane)
    }
}

/// Adds the forces of a call's tetrahedra, N.
pub struct Forces<'a, 'b> {
    pub tetrahedra: Tetrahedra<'a>,
    pub out: &'a mut NodeVectors<'b>,
}

impl WithSimd for Forces<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { tetrahedra, out } = self;
        let nodes = tetrahedra.nodes;
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let Some(Losses { x, t, inverse, squeezed }) = tetrahedra.losses(simd, e) else { continue };
            let (g, factor) = (gradients(x), pressure(t) * Wide::load_clamped(simd, tetrahedra.scale, e) * inverse);
            let mut forces = [[[0.0; MAX_LANES]; 3]; 4];
            for corner in 0..4 {
                for i in 0..3 {
                    forces[corner][i] = (g[corner][i] * factor).to_array();
                }
            }
            for lane in squeezed {
                for corner in 0..4 {
                    let [x, y, z] = &forces[corner];
                    out.add(nodes[e + lane][corner], [x[lane], y[lane], z[lane]]);
                }
            }
        }
    }
}

/// For each corner but the first, the stiffness (N/m) of an isotropic spring to the first one; together they bound what a `pressure` (N/m^2,
/// over a sixth of the rest volume) does by turning the faces.
#[inline(always)]
fn turning_bounds<T: Real>(x: [Vec3<T>; 4], pressure: T) -> [T; 3] {
    let [a, b, c] = [1, 2, 3].map(|corner| (x[corner] - x[0]).norm());
    [pressure * (b + c), pressure * (a + c), pressure * (a + b)]
}

/// Adds `factor` times the stiffness of a call's tetrahedra. The part that changes direction, `psi' d2J/dx2`, is indefinite. An upper bound
/// takes its place, so that the matrix is positive semi-definite and not softer than the derivative of the force: with d the displacement
/// of a corner from that of the first and e the edge between them, `2 det(d1, d2, e3) <= |e3| (|d1|^2 + |d2|^2)` and so on.
pub struct Stiffness<'a, 'b, T> {
    pub tetrahedra: Tetrahedra<'a>,
    pub factor: f64,
    pub out: &'a mut Blocks<'b, T>,
}

impl<T: BlockScalar> WithSimd for Stiffness<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { tetrahedra, factor, out } = self;
        let (nodes, mut blocks) = (tetrahedra.nodes, ElementBlocks::<T>::default());
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let Some(Losses { x, t, inverse, squeezed }) = tetrahedra.losses(simd, e) else { continue };
            let scale = Wide::load_clamped(simd, tetrahedra.scale, e) * inverse * factor;
            let (k, bound) = (stiffness(t) * scale * inverse, turning_bounds(x, pressure(t) * scale));
            let g = gradients(x);
            for (a, b) in CORNER_PAIRS {
                if a == b && !T::HAS_DIAGONAL_BLOCKS {
                    continue;
                }
                let isotropic = match (a, b) {
                    (0, 0) => Some(bound[0] + bound[1] + bound[2]),
                    (0, b) => Some(-bound[b - 1]),
                    (a, b) if a == b => Some(bound[a - 1]),
                    _ => None,
                };
                let mut block = [g[a]; 3];
                for i in 0..3 {
                    for j in 0..3 {
                        let entry = g[a][i] * g[b][j] * k;
                        block[i][j] = isotropic.filter(|_| i == j).map_or(entry, |isotropic| entry + isotropic);
                    }
                }
                blocks.set(a, b, &block);
            }
            blocks.add_to(out, e, squeezed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Losses of volume on both sides of where the law changes.
    const LOSSES: [f64; 8] =
        [-0.5, START - 1e-9, START + 1e-9, 0.2, START + ONSET - 1e-9, START + ONSET + 1e-9, 0.7, 1.4];

    fn psi(t: f64) -> f64 {
        let x = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0 - t]];
        let nodes = [[0, 1, 2, 3]];
        let tetrahedra = Tetrahedra { nodes: &nodes, x: &x, six_volumes: &[1.0], scale: &[1.0] };
        tetrahedra.energy()
    }

    #[test]
    fn pressure_and_stiffness_are_the_derivatives_of_the_energy() {
        let h = 1e-5;
        for t in LOSSES {
            let slope = (psi(t + h) - psi(t - h)) / (2.0 * h);
            let curvature = (pressure(t + h) - pressure(t - h)) / (2.0 * h);
            // The third derivative jumps by 2/a where the law changes: differences are of first order across it.
            assert!((slope - pressure(t)).abs() <= 2.0 * h / ONSET, "{t}: {slope} {}", pressure(t));
            assert!((curvature - stiffness(t)).abs() <= 2.0 * h / ONSET, "{t}: {curvature} {}", stiffness(t));
        }
    }

    #[test]
    fn nothing_is_added_at_rest_or_in_tension_and_stiffness_is_at_most_one() {
        assert_eq!((psi(0.0), pressure(0.0), stiffness(0.0)), (0.0, 0.0, 0.0));
        assert_eq!((psi(-0.3), pressure(-0.3), stiffness(-0.3)), (0.0, 0.0, 0.0));
        assert!(LOSSES.iter().all(|t| (0.0..=1.0).contains(&stiffness(*t))));
    }
}
