//! Unit normals of a sheet's nodes, and how slopes in them come to forces.
//!
//! `n = N / |N|`, N the sum of the area vectors of the triangles around a node. What a function E(x, n) of places and normals
//! does to the nodes is -dE/dx and, by way of the normals, the transpose of dn/dx on -dE/dn: exact, so that all of it is
//! the slope of one energy and keeps momentum, linear and angular.

use crate::algebra::Vec3;
use crate::elements::chunk::Schedule;
use crate::threads::Pool;

/// Of the rest area around a node, the least over which its area vector still counts as a direction: below, a normal is shorter
/// than 1, for the normal of a sheet that is folded onto itself turns faster than anything can follow.
const CRUMPLED: f64 = 1e-2;
/// Nodes in a piece of work for a thread.
const PIECE: usize = 1024;

/// Triangles with the corners whose normals they are part of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facet {
    pub(super) corners: [u32; 3],
    pub(super) counts: [bool; 3],
}

/// Normals of all nodes.
#[derive(Debug, Default)]
pub(super) struct Field {
    facets: Vec<Facet>,
    schedule: Schedule,
    /// m^2, least length of N (n)
    least: Vec<f64>,
    /// 1/m^2, over N (n)
    inverse: Vec<f64>,
    /// (n x 3)
    pub(super) normal: Vec<Vec3>,
}

impl Field {
    pub(super) fn new(facets: Vec<Facet>, rest: &[Vec3]) -> Self {
        let nodes: Vec<u32> = facets.iter().flat_map(|f| f.corners).collect();
        let (mut schedule, n) = (Schedule::default(), rest.len());
        schedule.cut(&nodes, 3);
        let mut field =
            Self { facets, schedule, least: vec![0.0; n], inverse: vec![0.0; n], normal: vec![Vec3::zeros(); n] };
        for facet in &field.facets {
            let area = area_vector(facet.corners.map(|n| rest[n as usize]));
            let share = CRUMPLED * area.norm();
            (0..3).filter(|i| facet.counts[*i]).for_each(|i| field.least[facet.corners[i] as usize] += share);
        }
        field.least.iter_mut().for_each(|least| *least = least.max(f64::MIN_POSITIVE));
        field
    }

    /// Finds the normals at places `x` (n x 3).
    pub(super) fn load(&mut self, pool: &Pool, x: &[Vec3]) {
        let Self { facets, schedule, least, inverse, normal } = self;
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
        pool.par_chunks((&mut normal[..], &mut inverse[..]), PIECE, &|first, (normal, inverse)| {
            for (i, (n, inverse)) in normal.iter_mut().zip(inverse).enumerate() {
                *inverse = 1.0 / n.norm().max(least[first + i]);
                *n *= *inverse;
            }
        });
    }

    /// To `force` adds that of `parts`: forces at fixed normals, N, and slopes in the normals, J, which become slopes in N.
    pub(super) fn pull_back(&self, pool: &Pool, x: &[Vec3], parts: &mut [[f64; 6]], force: &mut [Vec3]) {
        pool.par_chunks((&mut *parts, &mut *force), PIECE, &|first, (parts, force)| {
            for (i, ([fx, fy, fz, p, q, r], f)) in parts.iter_mut().zip(force).enumerate() {
                *f += Vec3::new(*fx, *fy, *fz);
                let (n, inverse, slope) = (self.normal[first + i], self.inverse[first + i], Vec3::new(*p, *q, *r));
                let whole = inverse * self.least[first + i] < 1.0;
                let turning = if whole { slope - n.dot(&slope) * n } else { slope };
                [*p, *q, *r] = (inverse * turning).into();
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
                let places = facet.corners.map(|n| x[n as usize]);
                for i in 0..3 {
                    let side = places[(i + 1) % 3] - places[(i + 2) % 3];
                    let f = &mut window[facet.corners[i] as usize - chunk.window.start];
                    *f -= 0.5 * side.cross(&slope);
                }
            }
            Ok::<(), std::convert::Infallible>(())
        });
    }
}

/// m^2, along the normal
#[inline(always)]
fn area_vector([a, b, c]: [Vec3; 3]) -> Vec3 {
    0.5 * (b - a).cross(&(c - a))
}
