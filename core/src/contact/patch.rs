//! The part of the surface a touch presses on.
//!
//! A load on one node makes the touch as soft as the grid is fine (a node's stiffness is 0.816 E h), so a touch is spread
//! over a disc of at least three cells. A ball of radius R that has gone in by d presses on a disc of radius a = sqrt(R d)
//! with the pressure sqrt(1 - (r/a)^2) (Hertz 1881); the disc is sampled in the rest shape, so its cost does not depend on
//! how fine the surface is.

use crate::body::{Lattice, LatticeError, Model};
use crate::step::{Attachment, V3, axpy};
use nalgebra::Vector3;

/// A weighted disc of rest places, and the buffers to find its nodes.
#[derive(Default)]
pub struct Patch {
    /// m, rest places (s x 3)
    pub places: Vec<V3>,
    /// Share of the load at each (s), sum 1
    pub shares: Vec<f64>,
    weights: Vec<[f64; 8]>,
    /// Sum of weights by node, and which nodes have one.
    sum: Vec<f64>,
    touched: Vec<u32>,
}

/// The least radius, in edges of a cell.
const LEAST: f64 = 1.5;
/// Distance of samples, in edges of a cell, and rings at most.
const SPACING: f64 = 0.5;
const MOST_RINGS: usize = 8;

impl Patch {
    /// m, the radius of the disc under a ball of `radius` that has gone in by `depth` (m), on cells of `edge` (m).
    pub fn radius(radius: f64, depth: f64, edge: f64) -> f64 {
        let hertz = (radius * depth.max(0.0)).sqrt().min(radius);
        hertz.max(LEAST * edge)
    }

    /// Samples the disc of `radius` (m) around a point of a triangle, in the rest shape.
    pub fn sample(&mut self, model: &Model, triangle: u32, bary: V3, radius: f64, edge: f64) {
        let corners = model.surface.triangles[triangle as usize].map(|v| model.surface.points[v as usize]);
        let centre = crate::body::weigh(corners, bary);
        let [a, b, c] = corners.map(Vector3::from);
        let normal = (b - a).cross(&(c - a));
        let along = (b - a).try_normalize(0.0).unwrap_or_else(Vector3::x);
        let across = normal.cross(&along).try_normalize(0.0).unwrap_or_else(Vector3::y);
        let rings = ((radius / (SPACING * edge)).ceil() as usize).clamp(1, MOST_RINGS);
        self.places.clear();
        self.shares.clear();
        let width = radius / rings as f64;
        for ring in 0..rings {
            let (r, count) = ((ring as f64 + 0.5) * width, 6 * ring + 3);
            let pressure = (1.0 - (r / radius).powi(2)).sqrt();
            for i in 0..count {
                let angle = (i as f64 + 0.5 * (ring % 2) as f64) / count as f64 * std::f64::consts::TAU;
                let offset: Vector3<f64> = r * (angle.cos() * along + angle.sin() * across);
                self.places.push(axpy(centre, 1.0, offset.into()));
                self.shares.push(pressure * r * width / count as f64);
            }
        }
        let total: f64 = self.shares.iter().sum();
        self.shares.iter_mut().for_each(|s| *s /= total);
    }

    /// Turns the samples into weighted nodes of `out`. Samples beside the body are left out; gives whether any was on it.
    ///
    /// # Errors
    /// What the grid says.
    pub fn attach(&mut self, lattice: &mut Lattice, nodes: usize, out: &mut Attachment) -> Result<bool, LatticeError> {
        out.clear();
        self.sum.resize(nodes.max(self.sum.len()), 0.0);
        self.touched.clear();
        let (shares, sum, touched) = (&self.shares, &mut self.sum, &mut self.touched);
        lattice.stencils(&self.places, &mut self.weights, |place, node, weight| {
            let at = &mut sum[node as usize];
            if *at == 0.0 {
                touched.push(node);
            }
            *at += shares[place] * weight;
        })?;
        touched.sort_unstable();
        touched.dedup();
        let total: f64 = touched.iter().map(|&n| sum[n as usize]).sum();
        for &node in touched.iter() {
            let weight = std::mem::take(&mut sum[node as usize]);
            if total > 0.0 && weight != 0.0 {
                out.nodes.push(node);
                out.weights.push(weight / total);
            }
        }
        Ok(!out.nodes.is_empty())
    }
}
