//! Energies of vertex normals: the material gives E(x, n) of its triangles, the normals and what they do to the nodes are found here.
//!
//! A normal needs the ring of its vertex, which a material does not see. Forces are those of E at fixed normals, as Tripicchio,
//! D'Avella and Ruffaldi (2022) have them, and what the normals add as they turn; without that angular momentum is lost. As a
//! matrix the former alone would brake every turn, so hinges stand for all of it.

mod field;
mod hinge;
mod prepare;
mod stand_in;

use super::algebra::{Block, Vec3};
use super::elements::ElementSet;
use super::factors::Factors;
use super::nodes::Nodes;
use super::outer::{Hinges, add_outer};
use super::threads::Pool;
use crate::force_model::{ForceError, ForceModel, StepTime};
use field::Field;
use pliant_plugin_api::abi;
use stand_in::share;

/// The energy of normals of a body.
#[derive(Debug, Default)]
pub struct Normals {
    /// Hinge of each triangle's sides 01, 12, 20, or `u32::MAX` (t x 3).
    pub sides: Vec<[u32; 3]>,
    field: Field,
    /// N and J, forces at fixed normals and slopes in them (n x 6)
    parts: Vec<[f64; 6]>,
    /// N m, of what stands for the energy (h)
    stiffness: Vec<f64>,
}

/// Whether a set is of triangles or hinges that normals are wanted for.
pub fn wants_normals(set: &ElementSet) -> bool {
    set.has(abi::WANTS_NORMALS)
}

fn of_kind(sets: &[ElementSet], kind: u32) -> Option<&ElementSet> {
    sets.iter().find(|set| wants_normals(set) && set.request().kind == kind)
}

impl Normals {
    /// Adds what the energy does to the nodes, N (n x 3).
    ///
    /// # Errors
    /// What the material says.
    pub fn forces(
        &mut self,
        pool: &Pool,
        material: &dyn ForceModel,
        (sets, nodes, time): (&[ElementSet], &Nodes, StepTime),
        force: &mut [Vec3],
    ) -> Result<(), ForceError> {
        let Some(set) = of_kind(sets, abi::TRIANGLE) else { return Ok(()) };
        self.field.load(pool, &nodes.x);
        self.parts.fill([0.0; 6]);
        let normals = bytemuck::cast_slice(&self.field.normal);
        set.schedule.run(pool, &mut self.parts, &|node| node, &|chunk, window| {
            material.normals_forces(&set.call(chunk, nodes, &nodes.v, time), normals, window)
        })?;
        self.field.pull_back(pool, &nodes.x, &mut self.parts, force);
        Ok(())
    }

    /// J
    ///
    /// # Errors
    /// What the material says.
    pub fn energy(
        &mut self,
        material: &dyn ForceModel,
        sets: &[ElementSet],
        nodes: &Nodes,
        time: StepTime,
    ) -> Result<f64, ForceError> {
        let Some(set) = of_kind(sets, abi::TRIANGLE) else { return Ok(0.0) };
        self.field.load(&Pool::new(1), &nodes.x);
        let normals = bytemuck::cast_slice(&self.field.normal);
        set.schedule.chunks().try_fold(0.0, |sum, chunk| {
            Ok(sum + material.normals_energy(&set.call(chunk, nodes, &nodes.v, time), normals)?)
        })
    }

    /// Adds what stands for its stiffness to a matrix; `bound` is the first block of a node.
    pub fn tangent(
        &self,
        pool: &Pool,
        (sets, nodes): (&[ElementSet], &Nodes),
        factors: Factors,
        (bound, blocks): (&(impl Fn(usize) -> usize + Sync), &mut [Block]),
    ) {
        let Some(set) = of_kind(sets, abi::HINGE) else { return };
        let factor = factors.stiffness * share(factors.stand_in);
        if factor == 0.0 {
            return;
        }
        let Ok(()) = set.schedule.run(pool, blocks, bound, &|chunk, blocks| {
            let range = chunk.range.clone();
            let corners = &set.nodes().as_chunks::<4>().0[range.clone()];
            let folds = Folds { corners, x: &nodes.x, stiffness: &self.stiffness[range.clone()], factor };
            add_outer(&set.slots[10 * range.start..10 * range.end], bound(chunk.window.start), blocks, &folds);
            Ok::<(), std::convert::Infallible>(())
        });
    }
}

/// Hinges that stand for the energy.
struct Folds<'a> {
    corners: &'a [[u32; 4]],
    x: &'a [Vec3],
    stiffness: &'a [f64],
    factor: f64,
}

impl Hinges for Folds<'_> {
    #[inline(always)]
    fn hinge(&self, e: usize) -> ([Vec3; 4], f64) {
        (hinge::gradient(self.corners[e].map(|n| self.x[n as usize])), self.factor * self.stiffness[e])
    }
}
