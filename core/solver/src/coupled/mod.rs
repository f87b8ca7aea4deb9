//! Coupled hinges: bending of thin shells in the mixed form of Hellan (1967), Herrmann (1967) and Johnson
//! (1973), in which moments are constant in each triangle and only their normal component is continuous across edges.
//!
//! The material gives the strain of each hinge and the compliance of each triangle; here `G m = s` is solved for the moments
//! m, so that the energy is s . m / 2. G couples a hinge to the four others of its two triangles and is well conditioned: no
//! eigenvalue of the Jacobi-scaled matrix lies outside those of the single triangles, and where triangles differ, the least is well
//! above theirs ([`self::least_eigenvalue`]). So a fixed Chebyshev polynomial in G takes the place of its inverse: one linear map, the
//! same in every call, whose energy and forces belong together exactly, but for rounding where a step asks for fewer digits.

mod chebyshev;
mod least_eigenvalue;

use super::algebra::Vec3;
use super::constraint::Constraint;
use super::elements::ElementSet;
use super::elements::chunk::Chunk;
use super::hinge_assembly::{self, AHEAD, BlocksMut, GROUP, Hinges, Precision};
use super::nodes::Nodes;
use super::system::SystemState;
use super::system_scales::{HessianApproximation, SystemScales};
use super::threads::Pool;
use crate::force_model::{ForceError, ForceModel, StepTime};
use chebyshev::Chebyshev;
use least_eigenvalue::least_eigenvalue;
use nalgebra::Matrix3;
use pliant_plugin_api::PlanesMut;
use pliant_plugin_api::lanes::vector_unit;
use pliant_plugin_api::{abi, prefetch};
use std::ops::Range;

/// The coupled hinges of a body, with the matrix G between them.
#[derive(Debug, Default)]
pub struct CoupledHinges {
    /// Hinge of each triangle's sides 01, 12, 20, or `u32::MAX` for none (t x 3).
    pub sides: Vec<[u32; 3]>,
    /// A polynomial in G that replaces its inverse.
    inverse: Chebyshev,
    /// Approximate stiffness of each hinge, [`INVERSE_FACTOR`] over the diagonal of G, N/m; 0 for a hinge without compliance (h).
    mean_stiffness: Vec<f64>,
    /// Upper bound of the stiffness of each hinge, from a diagonal lower bound of G, N/m (h).
    stiffness_bound: Vec<f64>,
    /// Plane 0: strain of each hinge, m; planes 1 to 12: its gradient by corner and axis (13 x h).
    planes: Vec<f64>,
    /// Moment of each hinge, N (h).
    moment: Vec<f64>,
}

/// Relative accuracy of the polynomial inverse.
const ACCURACY: f64 = 1e-4;
/// Largest number of terms of the polynomial. Slivers may need more; accuracy is given up there.
const MAX_TERMS: usize = 200;
/// Number of terms up to which no better bound of the spectrum is computed.
const FEW_TERMS: usize = 16;
/// Safety factor on the least eigenvalue found.
const EIGENVALUE_MARGIN: f64 = 0.9;
/// The inverse of G is approximated in a matrix by this factor over the diagonal of G, or by half the upper bound of the stiffness where that
/// is more, as beside slivers: a step of backward Euler that is linearised once is stable with at least half the exact stiffness.
const INVERSE_FACTOR: f64 = 2.2;
/// Numbers of a hinge: its strain and the twelve components of its gradient.
const PLANES: usize = 13;
/// Fewest hinges of a chunk of work.
const CHUNK: usize = 256;

/// Whether a set consists of coupled hinges.
pub fn is_coupled_hinges(set: &ElementSet) -> bool {
    set.request().kind == abi::HINGE && set.has(abi::IS_COUPLED)
}

/// Whether a set consists of the triangles that give coupled hinges their compliance.
fn is_coupled_triangles(set: &ElementSet) -> bool {
    set.request().kind == abi::TRIANGLE && set.has(abi::IS_COUPLED)
}

/// Number of terms at which the polynomial has the accuracy [`ACCURACY`], for eigenvalues between `low` and `high`.
fn terms([low, high]: [f64; 2]) -> usize {
    let root = (high / low).sqrt();
    let rate = (root - 1.0) / (root + 1.0);
    if rate > 0.0 { (libm::log(0.5 * ACCURACY) / libm::log(rate)).ceil().max(1.0) as usize } else { 1 }
}

impl CoupledHinges {
    /// Computes G and the polynomial. Call it after nodes or elements have changed.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn prepare(&mut self, material: &dyn ForceModel, sets: &[ElementSet], nodes: &Nodes) -> Result<(), ForceError> {
        let hinges = sets.iter().find(|set| is_coupled_hinges(set)).map_or(0, ElementSet::count);
        let Some(triangles) = sets.iter().find(|set| is_coupled_triangles(set)) else { return Ok(()) };
        let count = triangles.count();
        let mut compliance = vec![0.0; 6 * count];
        let whole = Chunk { range: 0..count, window: 0..nodes.len() };
        if count > 0 {
            material.compliance(&triangles.call(&whole, nodes, &nodes.v, StepTime::default()), &mut compliance)?;
        }
        // Diagonal of G and of its lower bound, m/N.
        let (mut diagonal, mut lower_bound) = (vec![0.0; hinges], vec![0.0; hinges]);
        // Bounds of the eigenvalues of the scaled matrix.
        let mut spectrum = [1.0_f64, 1.0];
        let mut entries: Vec<(u32, u32, f64)> = Vec::new();
        // Start vector near the eigenvector of the least eigenvalue: those of the triangles over their least eigenvalues.
        let mut near = vec![0.0; hinges];
        for (t, corners) in triangles.nodes().chunks_exact(3).enumerate() {
            // A triangle whose corners are all fixed does not bend.
            if corners.iter().all(|n| nodes.constraint[*n as usize] == Constraint::Fixed) {
                continue;
            }
            let c = |plane: usize| compliance[plane * count + t];
            let g = [[c(0), c(1), c(2)], [c(1), c(3), c(4)], [c(2), c(4), c(5)]];
            let sides = self.sides[t];
            let inner: Vec<usize> = (0..3).filter(|i| sides[*i] != u32::MAX).collect();
            for &i in &inner {
                diagonal[sides[i] as usize] += g[i][i];
                for &j in inner.iter().filter(|j| **j != i) {
                    entries.push((sides[i], sides[j], g[i][j]));
                }
            }
            let ScaledSpectrum { bounds, least_vector } = scaled_spectrum(&g, &inner);
            for &i in &inner {
                lower_bound[sides[i] as usize] += bounds[0] * g[i][i];
                near[sides[i] as usize] += least_vector[i] / (bounds[0] * g[i][i].sqrt());
            }
            spectrum = [spectrum[0].min(bounds[0]), spectrum[1].max(bounds[1])];
        }
        entries.sort_by_key(|(i, j, _)| (*i, *j));
        // Bounds from single triangles are far too wide where triangles differ. If an eigenvalue is a little below the estimate, the polynomial
        // is less accurate there and still positive. A hinge between two fixed triangles has no compliance and no moment.
        if terms(spectrum) > FEW_TERMS {
            let found = least_eigenvalue(&diagonal, &entries, near);
            spectrum[0] = found.map_or(spectrum[0], |found| spectrum[0].max(EIGENVALUE_MARGIN * found));
        }
        let terms = terms(spectrum).min(MAX_TERMS);
        self.inverse = Chebyshev::new(&diagonal, &entries, spectrum, terms);
        let over = |of: f64, all: &[f64]| all.iter().map(|c| if *c > 0.0 { of / c } else { 0.0 }).collect();
        (self.mean_stiffness, self.stiffness_bound) = (over(INVERSE_FACTOR, &diagonal), over(1.0, &lower_bound));
        self.planes = vec![0.0; PLANES * hinges];
        self.moment = vec![0.0; hinges];
        Ok(())
    }

    /// Computes the strain of each hinge and its gradient.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn update_strains(&mut self, pool: &Pool, state: SystemState<'_>) -> Result<(), ForceError> {
        let SystemState { material, sets, nodes, time } = state;
        let Some(set) = sets.iter().find(|set| is_coupled_hinges(set)) else { return Ok(()) };
        par_planes(pool, set.halvings(pool), PlanesMut::new(&mut self.planes, PLANES), &|planes| {
            let whole = Chunk { range: planes.range(), window: 0..nodes.len() };
            material.strain(&set.call(&whole, nodes, &nodes.v, time), planes)
        })
    }

    /// Computes strains, their gradients and the moments `G^-1 s`; moments in single precision if `single`.
    fn update_moments(&mut self, pool: &Pool, state: SystemState<'_>, single: bool) -> Result<(), ForceError> {
        self.update_strains(pool, state)?;
        let strain = &self.planes[..self.moment.len()];
        self.inverse.apply(pool, strain, &mut self.moment, single);
        Ok(())
    }

    /// Adds `-m ds/dx`, N, to `force` (n x 3), with moments in single precision if `single`.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn forces(
        &mut self,
        pool: &Pool,
        state: SystemState<'_>,
        force: &mut [Vec3],
        single: bool,
    ) -> Result<(), ForceError> {
        let Some(set) = state.sets.iter().find(|set| is_coupled_hinges(set)) else { return Ok(()) };
        self.update_moments(pool, state, single)?;
        let this = &*self;
        set.schedule.run(pool, force, &|node| node, &|chunk, window| {
            let (moments, gradients) = (&this.moment[chunk.range.clone()], this.gradients(chunk.range.clone()));
            let nodes = set.nodes().as_chunks().0;
            let nodes = &nodes[chunk.range.clone()];
            vector_unit().dispatch(HingeForces { nodes, moments, gradients, first: chunk.window.start, window });
            Ok(())
        })
    }

    /// Bending energy `s . m / 2`, J.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn energy(&mut self, pool: &Pool, state: SystemState<'_>) -> Result<f64, ForceError> {
        if !state.sets.iter().any(is_coupled_hinges) {
            return Ok(0.0);
        }
        self.update_moments(pool, state, false)?;
        Ok(0.5 * self.moment.iter().zip(&self.planes).map(|(m, s)| m * s).sum::<f64>())
    }

    /// Adds the approximate Hessian of a range of hinges at the strains computed last, times `scales.stiffness`: G is replaced by a diagonal
    /// matrix, and the geometric part `m d2s/dx2` is dropped.
    pub fn add_tangent<T: Precision>(
        &self,
        set: &ElementSet,
        range: Range<usize>,
        scales: &SystemScales,
        blocks: BlocksMut<'_, T>,
    ) {
        let slots = &set.slots[10 * range.start..10 * range.end];
        let gradient = self.gradients(range.clone());
        let (mean, bound) = (&self.mean_stiffness[range.clone()], &self.stiffness_bound[range]);
        let terms = HingeHessian { gradient, mean, bound, factor: scales.stiffness, approximation: scales.hessian };
        T::add_outer(slots, blocks, &terms);
    }

    /// Gradients of a range of hinges, a plane for each corner and axis.
    fn gradients(&self, range: Range<usize>) -> [&[f64]; 12] {
        let mut gradients: [&[f64]; 12] = [&[]; 12];
        for (plane, gradient) in self.planes.chunks_exact(self.moment.len()).skip(1).zip(&mut gradients) {
            *gradient = &plane[range.clone()];
        }
        gradients
    }
}

/// Adds `-m ds/dx` of a range of hinges to a window of nodes that begins at `first`.
struct HingeForces<'a> {
    /// Nodes of the hinges.
    nodes: &'a [[u32; 4]],
    /// Bending moments of the hinges, N.
    moments: &'a [f64],
    /// Gradients of the strains by corner and axis.
    gradients: [&'a [f64]; 12],
    /// First node of the window.
    first: usize,
    /// Forces on the nodes of the window, N.
    window: &'a mut [Vec3],
}

impl pulp::NullaryFnOnce for HingeForces<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { nodes, moments, gradients, first, window } = self;
        // Equal lengths, so that the loop needs no bounds checks.
        let gradients = gradients.map(|plane| &plane[..moments.len()]);
        for (e, (nodes, m)) in nodes.iter().zip(moments).enumerate() {
            for corner in 0..4 {
                let f = &mut window[nodes[corner] as usize - first];
                for c in 0..3 {
                    f[c] += -m * gradients[3 * corner + c][e];
                }
            }
        }
    }
}

/// Terms `k g g^T` that approximate the Hessian of a range of hinges.
struct HingeHessian<'a> {
    /// Gradients g of the strains by corner and axis.
    gradient: [&'a [f64]; 12],
    /// Approximate stiffness, N/m.
    mean: &'a [f64],
    /// Upper bound of the stiffness, N/m.
    bound: &'a [f64],
    /// Factor of all terms.
    factor: f64,
    /// How k follows from the two.
    approximation: HessianApproximation,
}

impl HingeHessian<'_> {
    /// k of hinges `e` to `e + N`.
    #[inline(always)]
    fn stiffness<const N: usize>(&self, e: usize) -> [f64; N] {
        let (mean, bound) = (&self.mean[e..e + N], &self.bound[e..e + N]);
        let mut stiffness = [0.0; N];
        for i in 0..N {
            let k = match self.approximation {
                HessianApproximation::Unbounded => mean[i],
                HessianApproximation::AtLeastHalf => mean[i].max(0.5 * bound[i]),
                HessianApproximation::UpperBound => bound[i],
            };
            stiffness[i] = self.factor * k;
        }
        stiffness
    }
}

impl Hinges for HingeHessian<'_> {
    #[inline(always)]
    fn hinge(&self, e: usize) -> ([Vec3; 4], f64) {
        let mut g = [Vec3::zeros(); 4];
        for corner in 0..4 {
            for i in 0..3 {
                g[corner][i] = self.gradient[3 * corner + i][e];
            }
        }
        (g, self.stiffness::<1>(e)[0])
    }

    #[inline(always)]
    fn group<'a>(
        &'a self,
        e: usize,
        buffer: &'a mut hinge_assembly::GroupPlanes,
    ) -> ([&'a [f64; GROUP]; 12], [f64; GROUP]) {
        let mut planes = [&buffer[0]; 12];
        for line in (0..GROUP).step_by(8) {
            prefetch(self.mean, e + AHEAD + line);
            prefetch(self.bound, e + AHEAD + line);
        }
        for (plane, from) in planes.iter_mut().zip(&self.gradient) {
            for line in (0..GROUP).step_by(8) {
                prefetch(from, e + AHEAD + line);
            }
            *plane = from[e..].first_chunk().expect("a group of hinges");
        }
        (planes, self.stiffness(e))
    }
}

/// Divides the elements of `planes` into halves `halvings` times, one range for each thread, and runs `work` on each.
///
/// # Errors
/// The first error in the order of elements.
pub(super) fn par_planes<E: Send>(
    pool: &Pool,
    halvings: u32,
    mut planes: PlanesMut<'_>,
    work: &(impl Fn(&mut PlanesMut<'_>) -> Result<(), E> + Sync),
) -> Result<(), E> {
    let range = planes.range();
    if halvings == 0 || range.len() < 2 * CHUNK {
        return work(&mut planes);
    }
    let (low, high) = planes.split_at(range.start.midpoint(range.end));
    let halvings = halvings - 1;
    let (a, b) = pool.join(|| par_planes(pool, halvings, low, work), || par_planes(pool, halvings, high, work));
    a.and(b)
}

/// Extreme eigenvalues of a matrix scaled to a unit diagonal.
struct ScaledSpectrum {
    /// Least and greatest eigenvalue; the least is at least 1e-6.
    bounds: [f64; 2],
    /// Eigenvector of the least.
    least_vector: Vec3,
}

/// The spectrum of the rows and columns `inner` of `g`, scaled by its diagonal.
fn scaled_spectrum(g: &[[f64; 3]; 3], inner: &[usize]) -> ScaledSpectrum {
    let mut scaled = Matrix3::identity();
    for &i in inner {
        for &j in inner {
            scaled[(i, j)] = g[i][j] / (g[i][i] * g[j][j]).sqrt();
        }
    }
    let eigen = scaled.symmetric_eigen();
    let (at, least) = eigen.eigenvalues.argmin();
    let bounds = [least.max(1e-6), eigen.eigenvalues.max()];
    ScaledSpectrum { bounds, least_vector: eigen.eigenvectors.column(at).into_owned() }
}
