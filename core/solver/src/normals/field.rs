//! Vertex normals of a sheet, and the forces of an energy that depends on them.
//!
//! The normal is `n = N / |N|`, with N the sum of the area vectors of the triangles around a node. The force of an energy E(x, n) of positions
//! and normals is `-dE/dx - (dn/dx)^T dE/dn`. It is the exact gradient of one energy, so it conserves linear and angular momentum.

use crate::algebra::Vec3;
use crate::elements::chunk::Schedule;
use crate::threads::Pool;

/// Least length of N over the rest area around a node at which the normal has unit length. Below it, where the sheet is folded onto itself, N is
/// divided by that least length instead: the direction of N would change too fast for any step.
const MIN_AREA_RATIO: f64 = 1e-2;
/// Nodes in a chunk of work for a thread.
const CHUNK: usize = 1024;

/// A triangle that contributes to the normals of some of its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facet {
    /// Nodes of its three corners.
    pub(super) corners: [u32; 3],
    /// Whether it contributes to the normal of each corner.
    pub(super) counts: [bool; 3],
}

/// Normals of all nodes.
#[derive(Debug, Default)]
pub(super) struct Field {
    /// Triangles that contribute to a normal.
    facets: Vec<Facet>,
    /// Chunks of the triangles.
    schedule: Schedule,
    /// Least length by which N is divided, m^2 (n).
    min_length: Vec<f64>,
    /// Factor of N in the normal, 1/m^2 (n).
    inverse: Vec<f64>,
    /// Normals (n x 3).
    pub(super) normal: Vec<Vec3>,
}

impl Field {
    /// Normals for these triangles, zero until [`Field::update`]; `rest` are the rest positions, m (n x 3).
    pub(super) fn new(facets: Vec<Facet>, rest: &[Vec3]) -> Self {
        let nodes: Vec<u32> = facets.iter().flat_map(|f| f.corners).collect();
        let (mut schedule, n) = (Schedule::default(), rest.len());
        schedule.cut(&nodes, 3, 1);
        let mut field =
            Self { facets, schedule, min_length: vec![0.0; n], inverse: vec![0.0; n], normal: vec![Vec3::zeros(); n] };
        for facet in &field.facets {
            let area = area_vector(facet.corners.map(|n| rest[n as usize]));
            let share = MIN_AREA_RATIO * area.norm();
            (0..3).filter(|i| facet.counts[*i]).for_each(|i| field.min_length[facet.corners[i] as usize] += share);
        }
        field.min_length.iter_mut().for_each(|length| *length = length.max(f64::MIN_POSITIVE));
        field
    }

    /// Computes the normals at positions `x`, m (n x 3).
    pub(super) fn update(&mut self, pool: &Pool, x: &[Vec3]) {
        let Self { facets, schedule, min_length, inverse, normal } = self;
        normal.fill(Vec3::zeros());
        let Ok(()) = schedule.run(pool, normal, &|node| node, &|chunk, window| {
            for facet in &facets[chunk.range.clone()] {
                let area = area_vector(facet.corners.map(|n| x[n as usize]));
                for i in (0..3).filter(|i| facet.counts[*i]) {
                    let sum = &mut window[facet.corners[i] as usize - chunk.window.start];
                    *sum += area;
                }
            }
            Ok::<(), std::convert::Infallible>(())
        });
        pool.par_chunks((&mut normal[..], &mut inverse[..]), CHUNK, &|first, (normal, inverse)| {
            for (i, (n, inverse)) in normal.iter_mut().zip(inverse).enumerate() {
                *inverse = 1.0 / n.norm().max(min_length[first + i]);
                *n *= *inverse;
            }
        });
    }

    /// Adds to `force`, N (n x 3), the forces of an energy at positions `x`, m. The rows of `parts` (n x 6) are the force at fixed normals, N, and
    /// minus the derivative by the normal, J; the latter is overwritten by that by the area vector.
    pub(super) fn pull_back(&self, pool: &Pool, x: &[Vec3], parts: &mut [[f64; 6]], force: &mut [Vec3]) {
        pool.par_chunks((&mut *parts, &mut *force), CHUNK, &|first, (parts, force)| {
            for (i, ([fx, fy, fz, p, q, r], f)) in parts.iter_mut().zip(force).enumerate() {
                *f += Vec3::new(*fx, *fy, *fz);
                let (n, inverse, slope) = (self.normal[first + i], self.inverse[first + i], Vec3::new(*p, *q, *r));
                let is_unit = inverse * self.min_length[first + i] < 1.0;
                let tangential = if is_unit { slope - n.dot(&slope) * n } else { slope };
                [*p, *q, *r] = (inverse * tangential).into();
            }
        });
        let parts = &*parts;
        let Ok(()) = self.schedule.run(pool, force, &|node| node, &|chunk, window| {
            for facet in &self.facets[chunk.range.clone()] {
                let mut slope = Vec3::zeros();
                for i in (0..3).filter(|i| facet.counts[*i]) {
                    let [.., p, q, r] = parts[facet.corners[i] as usize];
                    slope += Vec3::new(p, q, r);
                }
                let positions = facet.corners.map(|n| x[n as usize]);
                for i in 0..3 {
                    let side = positions[(i + 1) % 3] - positions[(i + 2) % 3];
                    let f = &mut window[facet.corners[i] as usize - chunk.window.start];
                    *f -= 0.5 * side.cross(&slope);
                }
            }
            Ok::<(), std::convert::Infallible>(())
        });
    }
}

/// Area vector of a triangle, m^2: its area along its normal.
#[inline(always)]
fn area_vector([a, b, c]: [Vec3; 3]) -> Vec3 {
    0.5 * (b - a).cross(&(c - a))
}
