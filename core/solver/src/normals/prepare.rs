//! Preparation of an energy of normals: the triangles around each normal, and the hinges that approximate the Hessian.
//!
//! The normal of a clamped edge is that of the mirror image beyond it, which is held; a normal at a triangle that is held altogether
//! is that of the triangle. So a clamp is where it was set, not half a cell on.

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
    /// Finds the triangles of each normal and the stiffness of the hinges. Call it after nodes or elements have changed.
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
        let held = |corners: &[u32; 3]| corners.iter().all(|n| nodes.constraint[*n as usize] == Constraint::Fixed);
        let triangles = triangles.nodes().as_chunks::<3>().0;
        let walls = self.mirrored(triangles, hinges.nodes().as_chunks::<4>().0);
        let mut around = vec![Around::default(); nodes.len()];
        let held_ones = triangles.iter().filter(|t| held(t)).flatten();
        walls.iter().flat_map(|wall| &wall[..2]).chain(held_ones).for_each(|n| around[*n as usize].walled = true);
        let facet = |t: &[u32; 3]| Facet { corners: *t, counts: t.map(|n| held(t) || !around[n as usize].walled) };
        let beyond = walls.iter().map(|wall| Facet { corners: *wall, counts: [true, true, false] });
        self.field = Field::new(triangles.iter().map(facet).chain(beyond).collect(), &nodes.rest);
        self.parts = vec![[0.0; 6]; nodes.len()];
        self.stiffen(triangles, hinges.nodes().as_chunks::<4>().0, &tilt, around, held);
        Ok(())
    }

    /// The mirror images beyond clamped edges, each with the edge first: hinges that one triangle has.
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
    fn stiffen(
        &mut self,
        triangles: &[[u32; 3]],
        hinges: &[[u32; 4]],
        tilt: &[f64],
        mut around: Vec<Around>,
        held: impl Fn(&[u32; 3]) -> bool,
    ) {
        // Of each hinge the sum over its triangles that may bend, and how many they are.
        let mut sums = vec![(0.0, 0.0); hinges.len()];
        for (t, corners) in triangles.iter().enumerate().filter(|(_, t)| !held(t)) {
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
