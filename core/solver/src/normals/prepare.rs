//! Preparation of an energy of normals: the triangles around each normal, and the hinges that approximate the Hessian.
//!
//! At a clamped edge, a hinge with one triangle and a fixed mirror image of it, the normal is that of the mirror image. At a fixed triangle it is
//! that of the triangle. The clamp is thus at the edge itself, and not half a cell away.

use super::field::{Facet, Field};
use super::hessian_approximation::Around;
use super::{NormalsEnergy, of_kind};
use crate::constraint::Constraint;
use crate::elements::ElementSet;
use crate::elements::chunk::Chunk;
use crate::force_model::{ForceError, ForceModel, StepTime};
use crate::nodes::Nodes;
use pliant_plugin_api::abi;

impl NormalsEnergy {
    /// Lists the triangles of each normal and computes the stiffness of the hinges. Call it after nodes or elements have changed.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn prepare(&mut self, material: &dyn ForceModel, sets: &[ElementSet], nodes: &Nodes) -> Result<(), ForceError> {
        let (Some(triangles), Some(hinges)) = (of_kind(sets, abi::TRIANGLE), of_kind(sets, abi::HINGE)) else {
            return Ok(());
        };
        let count = triangles.count();
        let mut tilt = vec![0.0; 3 * count];
        if count > 0 {
            let whole = Chunk { range: 0..count, window: 0..nodes.len() };
            material.tilt(&triangles.call(&whole, nodes, &nodes.v, StepTime::default()), &mut tilt)?;
        }
        let is_fixed = |corners: &[u32; 3]| corners.iter().all(|n| nodes.constraint[*n as usize] == Constraint::Fixed);
        let triangles = triangles.nodes().as_chunks::<3>().0;
        let clamped = self.mirrored(triangles, hinges.nodes().as_chunks::<4>().0);
        let mut around = vec![Around::default(); nodes.len()];
        let fixed = triangles.iter().filter(|t| is_fixed(t)).flatten();
        clamped.iter().flat_map(|image| &image[..2]).chain(fixed).for_each(|n| around[*n as usize].is_clamped = true);
        let facet =
            |t: &[u32; 3]| Facet { corners: *t, counts: t.map(|n| is_fixed(t) || !around[n as usize].is_clamped) };
        let images = clamped.iter().map(|image| Facet { corners: *image, counts: [true, true, false] });
        self.field = Field::new(triangles.iter().map(facet).chain(images).collect(), &nodes.rest);
        self.parts = vec![[0.0; 6]; nodes.len()];
        self.compute_stiffness(triangles, hinges.nodes().as_chunks::<4>().0, &tilt, around, is_fixed);
        Ok(())
    }

    /// The mirror images at clamped edges, each with the nodes of the edge first: the second triangles of hinges that have a single one.
    fn mirrored(&self, triangles: &[[u32; 3]], hinges: &[[u32; 4]]) -> Vec<[u32; 3]> {
        let mut owners = vec![(0, 0); hinges.len()];
        for (t, sides) in self.sides.iter().enumerate() {
            for (i, side) in sides.iter().enumerate().filter(|(_, side)| **side != u32::MAX) {
                owners[*side as usize] = (owners[*side as usize].0 + 1, 3 * t + i);
            }
        }
        let alone = hinges.iter().zip(&owners).filter(|(_, (count, _))| *count == 1);
        alone
            .map(|(&[a, b, left, right], (_, side))| {
                let third = triangles[side / 3][(side % 3 + 2) % 3];
                if third == left { [b, a, right] } else { [a, b, left] }
            })
            .collect()
    }

    /// Computes the stiffness of the hinges that approximate the energy.
    fn compute_stiffness(
        &mut self,
        triangles: &[[u32; 3]],
        hinges: &[[u32; 4]],
        tilt: &[f64],
        mut around: Vec<Around>,
        is_fixed: impl Fn(&[u32; 3]) -> bool,
    ) {
        // Sum of the stiffness of the triangles of each hinge that can bend, and their number.
        let mut sums = vec![(0.0, 0.0); hinges.len()];
        for (t, corners) in triangles.iter().enumerate().filter(|(_, t)| !is_fixed(t)) {
            corners.iter().for_each(|n| around[*n as usize].triangles += 1);
            for (i, side) in self.sides[t].iter().enumerate().filter(|(_, side)| **side != u32::MAX) {
                let (sum, count) = &mut sums[*side as usize];
                (*sum, *count) = (*sum + tilt[i * triangles.len() + t], *count + 1.0);
            }
        }
        for ([a, b, ..], _) in hinges.iter().zip(&sums).filter(|(_, (_, count))| *count > 0.0) {
            [a, b].into_iter().for_each(|n| around[*n as usize].hinges += 1);
        }
        let spread = |n: u32| around[n as usize].spread();
        let stiffness = |([a, b, ..], (sum, count)): (&[u32; 4], &(f64, f64))| {
            if *count > 0.0 { (spread(*a) + spread(*b)) * sum / count } else { 0.0 }
        };
        self.stiffness = hinges.iter().zip(&sums).map(stiffness).collect();
    }
}
