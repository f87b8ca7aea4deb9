//! Hinges that act on each other: bending of thin shells in the mixed form of Hellan (1967), Herrmann (1967) and Johnson
//! (1973), in which moments are constant in each triangle and agree across edges only in what they do along the edge.
//!
//! The material gives the strain of each hinge and the compliance of each triangle; here `G m = s` is solved for the moments
//! m, so that the energy is s . m / 2. G couples a hinge to the four others of its two triangles and is well conditioned: no
//! eigenvalue of the Jacobi-scaled matrix lies outside those of the single triangles. So a fixed Chebyshev polynomial in G
//! takes the place of its inverse: one linear map, the same in every call, whose energy and forces belong together exactly.

use super::chunk::Chunk;
use super::elements::ElementSet;
use super::hinge::add_outer;
use super::pool::Pool;
use super::system::Nodes;
use super::{Block, Constraint, StandIn, V3, axpy};
use crate::host::{HostError, Material};
use nalgebra::Matrix3;
use pliant_plugin_api::abi;

/// The coupled hinges of a body.
#[derive(Debug, Default)]
pub struct Coupled {
    /// Hinge of each triangle's sides 01, 12, 20, or `u32::MAX` (t x 3).
    pub sides: Vec<[u32; 3]>,
    /// G without its diagonal, over that of the row: a hinge's partners in its two triangles, itself with 0 where there are
    /// less (h x 4)
    column: Vec<[u32; 4]>,
    value: Vec<[f64; 4]>,
    /// m/N
    diagonal: Vec<f64>,
    /// m/N, of a diagonal matrix that is nowhere above G
    least: Vec<f64>,
    /// Least and greatest eigenvalue of the scaled matrix, at the widest.
    spectrum: [f64; 2],
    iterations: usize,
    /// Plane 0 strain, m; 1 to 12 its gradient.
    planes: Vec<f64>,
    /// N
    moment: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    next: Vec<f64>,
}

/// Relative accuracy of the polynomial inverse.
const ACCURACY: f64 = 1e-4;
/// Terms of it, at most: slivers ask for more than is worth it.
const MOST: usize = 200;
/// What stands for the inverse of G in a matrix is at least this over its diagonal, and more where slivers ask for it: at least
/// half the exact stiffness, as a step of backward Euler that is linearised once needs.
const STAND_IN: f64 = 2.2;
/// Hinges in a piece of work for a thread.
const PIECE: usize = 1024;
/// Planes of a hinge.
const PLANES: usize = 13;

/// Whether a set is of hinges that are coupled.
pub fn is_coupled_hinges(set: &ElementSet) -> bool {
    set.request().kind == abi::HINGE && set.has(abi::IS_COUPLED)
}

fn is_coupled_triangles(set: &ElementSet) -> bool {
    set.request().kind == abi::TRIANGLE && set.has(abi::IS_COUPLED)
}

impl Coupled {
    /// After nodes or elements have changed.
    ///
    /// # Errors
    /// What the material says.
    pub fn prepare(&mut self, material: &Material, sets: &[ElementSet], nodes: &Nodes) -> Result<(), HostError> {
        let hinges = sets.iter().find(|set| is_coupled_hinges(set)).map_or(0, ElementSet::count);
        let Some(triangles) = sets.iter().find(|set| is_coupled_triangles(set)) else { return Ok(()) };
        let count = triangles.count();
        let mut compliance = vec![0.0; 6 * count];
        let whole = Chunk { range: 0..count, window: 0..nodes.len() };
        if count > 0 {
            material.compliance(&triangles.call(&whole, nodes, &nodes.v, (0.0, 0.0)), &mut compliance)?;
        }
        self.diagonal = vec![0.0; hinges];
        self.least = vec![0.0; hinges];
        self.spectrum = [1.0, 1.0];
        let mut entries: Vec<(u32, u32, f64)> = Vec::new();
        for (t, corners) in triangles.nodes().chunks_exact(3).enumerate() {
            // A triangle that is held altogether does not bend.
            if corners.iter().all(|n| nodes.constraint[*n as usize] == Constraint::Fixed) {
                continue;
            }
            let c = |plane: usize| compliance[plane * count + t];
            let g = [[c(0), c(1), c(2)], [c(1), c(3), c(4)], [c(2), c(4), c(5)]];
            let sides = self.sides[t];
            let inner: Vec<usize> = (0..3).filter(|i| sides[*i] != u32::MAX).collect();
            for &i in &inner {
                self.diagonal[sides[i] as usize] += g[i][i];
                for &j in inner.iter().filter(|j| **j != i) {
                    entries.push((sides[i], sides[j], g[i][j]));
                }
            }
            let bounds = scaled_spectrum(&g, &inner);
            inner.iter().for_each(|&i| self.least[sides[i] as usize] += bounds[0] * g[i][i]);
            self.spectrum = [self.spectrum[0].min(bounds[0]), self.spectrum[1].max(bounds[1])];
        }
        entries.sort_by_key(|(i, j, _)| (*i, *j));
        self.column = (0..hinges as u32).map(|h| [h; 4]).collect();
        self.value = vec![[0.0; 4]; hinges];
        for partners in entries.chunk_by(|a, b| a.0 == b.0) {
            for (at, (hinge, partner, g)) in partners.iter().enumerate() {
                let hinge = *hinge as usize;
                (self.column[hinge][at], self.value[hinge][at]) = (*partner, g / self.diagonal[hinge]);
            }
        }
        // A hinge between two triangles that are held has no compliance at all, and no moment.
        let [low, high] = self.spectrum;
        let rate = ((high / low).sqrt() - 1.0) / ((high / low).sqrt() + 1.0);
        let needed = if rate > 0.0 { (0.5 * ACCURACY).ln() / rate.ln() } else { 1.0 };
        self.iterations = (needed.ceil() as usize).clamp(1, MOST);
        self.planes = vec![0.0; PLANES * hinges];
        self.moment = vec![0.0; hinges];
        self.residual = vec![0.0; hinges];
        self.step = vec![0.0; hinges];
        self.next = vec![0.0; hinges];
        Ok(())
    }

    /// Finds strains and their gradients, and the moments that belong to them.
    fn load(
        &mut self,
        pool: &Pool,
        material: &Material,
        set: &ElementSet,
        nodes: &Nodes,
        time: (f64, f64),
    ) -> Result<(), HostError> {
        for chunk in set.schedule.chunks() {
            material.strain(&set.call(chunk, nodes, &nodes.v, time), &mut self.planes)?;
        }
        self.solve(pool);
        Ok(())
    }

    /// `m = p(G) s`, by Chebyshev's iteration from zero on the rows over their diagonal.
    fn solve(&mut self, pool: &Pool) {
        let [low, high] = self.spectrum;
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let diagonal = &self.diagonal;
        for ((residual, strain), diagonal) in self.residual.iter_mut().zip(&self.planes).zip(diagonal) {
            *residual = if *diagonal > 0.0 { strain / diagonal } else { 0.0 };
        }
        self.moment.fill(0.0);
        let mut alpha = 1.0 / centre;
        for k in 0..self.iterations {
            let beta = match k {
                0 => 0.0,
                1 => 0.5 * (half * alpha).powi(2),
                _ => (0.5 * half * alpha).powi(2),
            };
            if k > 0 {
                alpha = 1.0 / (centre - beta / alpha);
            }
            // One pass: the next step needs the residual of this one, which needs this step of the partners.
            let (step, column, value) = (&self.step, &self.column, &self.value);
            let parts = (&mut self.residual[..], (&mut self.moment[..], &mut self.next[..]));
            pool.pieces(parts, PIECE, &|first, (residual, (moment, next))| {
                let (column, value) = (&column[first..], &value[first..]);
                for i in 0..residual.len() {
                    if k > 0 {
                        let [a, b, c, d] = column[i].map(|j| step[j as usize]);
                        let v = value[i];
                        residual[i] -= step[first + i] + ((v[0] * a + v[1] * b) + (v[2] * c + v[3] * d));
                    }
                    next[i] = alpha * residual[i] + if k > 0 { beta * step[first + i] } else { 0.0 };
                    moment[i] += next[i];
                }
            });
            std::mem::swap(&mut self.step, &mut self.next);
        }
    }

    #[inline(always)]
    fn gradient(&self, hinge: usize, corner: usize) -> V3 {
        let n = self.moment.len();
        let at = (1 + 3 * corner) * n + hinge;
        [self.planes[at], self.planes[at + n], self.planes[at + 2 * n]]
    }

    /// Adds `-m ds/dx`, N (n x 3).
    ///
    /// # Errors
    /// What the material says.
    pub fn forces(
        &mut self,
        pool: &Pool,
        material: &Material,
        set: &ElementSet,
        nodes: &Nodes,
        time: (f64, f64),
        force: &mut [V3],
    ) -> Result<(), HostError> {
        self.load(pool, material, set, nodes, time)?;
        let this = &*self;
        set.schedule.run(pool, force, &|node| node, &|chunk, window| {
            for hinge in chunk.range.clone() {
                for (corner, &node) in set.nodes()[4 * hinge..4 * hinge + 4].iter().enumerate() {
                    let f = &mut window[node as usize - chunk.window.start];
                    *f = axpy(*f, -this.moment[hinge], this.gradient(hinge, corner));
                }
            }
            Ok(())
        })
    }

    /// J
    ///
    /// # Errors
    /// What the material says.
    pub fn energy(
        &mut self,
        pool: &Pool,
        material: &Material,
        set: &ElementSet,
        nodes: &Nodes,
        time: (f64, f64),
    ) -> Result<f64, HostError> {
        self.load(pool, material, set, nodes, time)?;
        Ok(0.5 * self.moment.iter().zip(&self.planes).map(|(m, s)| m * s).sum::<f64>())
    }

    /// Adds `factor` times a stand-in for the stiffness: the diagonal of G in the place of G, and no geometric part. With
    /// `is_loaded`, at the strains [`Coupled::forces`] has just found.
    ///
    /// # Errors
    /// What the material says.
    pub fn tangent(
        &mut self,
        pool: &Pool,
        material: &Material,
        (set, nodes, time): (&ElementSet, &Nodes, (f64, f64)),
        (factor, which, is_loaded): (f64, StandIn, bool),
        (bound, blocks): (&(impl Fn(usize) -> usize + Sync), &mut [Block]),
    ) -> Result<(), HostError> {
        if !is_loaded {
            for chunk in set.schedule.chunks() {
                material.strain(&set.call(chunk, nodes, &nodes.v, time), &mut self.planes)?;
            }
        }
        let this = &*self;
        set.schedule.run(pool, blocks, bound, &|chunk, blocks| {
            let first = bound(chunk.window.start);
            for hinge in chunk.range.clone() {
                let (diagonal, most) = (this.diagonal[hinge], 1.0 / this.least[hinge]);
                let stand_in = match which {
                    StandIn::Searched => STAND_IN / diagonal,
                    StandIn::Half => (STAND_IN / diagonal).max(0.5 * most),
                    StandIn::Certain => most,
                };
                let k = if diagonal > 0.0 { factor * stand_in } else { 0.0 };
                let g = [0, 1, 2, 3].map(|corner| this.gradient(hinge, corner));
                add_outer(&set.slots[10 * hinge..10 * hinge + 10], &g, k, first, blocks);
            }
            Ok(())
        })
    }
}

/// Least and greatest eigenvalue of the rows and columns `inner` of `g`, scaled by its diagonal.
fn scaled_spectrum(g: &[[f64; 3]; 3], inner: &[usize]) -> [f64; 2] {
    let mut scaled = Matrix3::identity();
    for &i in inner {
        for &j in inner {
            scaled[(i, j)] = g[i][j] / (g[i][i] * g[j][j]).sqrt();
        }
    }
    let eigenvalues = scaled.symmetric_eigenvalues();
    [eigenvalues.min().max(1e-6), eigenvalues.max()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polynomial_is_the_inverse_to_its_accuracy() {
        // A chain of hinges, each coupled to the next.
        let n = 40;
        let mut coupled = Coupled { diagonal: vec![2.0; n], spectrum: [0.3, 1.7], ..Coupled::default() };
        for i in 0..n {
            let (mut column, mut value) = ([i as u32; 4], [0.0; 4]);
            for (at, j) in [i.checked_sub(1), (i + 1 < n).then_some(i + 1)].into_iter().flatten().enumerate() {
                (column[at], value[at]) = (j as u32, 0.35);
            }
            coupled.column.push(column);
            coupled.value.push(value);
        }
        coupled.iterations = 30;
        coupled.planes = (0..PLANES * n).map(|i| ((i * i) as f64).sin()).collect();
        let zeros = || vec![0.0; n];
        (coupled.moment, coupled.residual, coupled.step, coupled.next) = (zeros(), zeros(), zeros(), zeros());
        coupled.solve(&Pool::new(1));
        for i in 0..n {
            let beside = |j: Option<usize>| j.and_then(|j| coupled.moment.get(j)).map_or(0.0, |m| 0.7 * m);
            let back = 2.0 * coupled.moment[i] + beside(i.checked_sub(1)) + beside(Some(i + 1));
            assert!((back - coupled.planes[i]).abs() < 1e-5, "{i}: {back} {}", coupled.planes[i]);
        }
    }
}
