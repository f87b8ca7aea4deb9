//! Energies of vertex normals: the material gives E(x, n) of its triangles; the normals, and the forces through them, are computed here.
//!
//! A normal depends on all triangles around its vertex, which a material does not see. Forces are those of E at fixed normals, as in Tripicchio,
//! D'Avella and Ruffaldi (2022), and those through the change of the normals, without which angular momentum is not conserved. The Hessian at
//! fixed normals would resist rotation, so the whole Hessian is approximated by hinges.

mod field;
mod hessian_approximation;
mod hinge;
mod prepare;

use super::algebra::{Block, Vec3};
use super::elements::ElementSet;
use super::hinge_assembly::{BlocksMut, Hinges, Precision};
use super::nodes::Nodes;
use super::system::SystemState;
use super::system_scales::SystemScales;
use super::threads::Pool;
use crate::force_model::ForceError;
use field::Field;
use hessian_approximation::bound_factor;
use pliant_plugin_api::abi;

/// An energy of the vertex normals of a body.
#[derive(Debug, Default)]
pub struct NormalsEnergy {
    /// Hinge of each triangle's sides 01, 12, 20, or `u32::MAX` for none (t x 3).
    pub sides: Vec<[u32; 3]>,
    /// Normals of all nodes, with the triangles they are computed from.
    field: Field,
    /// Force at fixed normals, N, and minus the derivative by the normal, J, of each node (n x 6).
    parts: Vec<[f64; 6]>,
    /// Stiffness of each hinge that approximates the energy, N m (h).
    stiffness: Vec<f64>,
}

/// Whether a set consists of triangles or hinges of an energy of normals.
pub fn wants_normals(set: &ElementSet) -> bool {
    set.has(abi::WANTS_NORMALS)
}

/// The set of an element kind that belongs to an energy of normals.
fn of_kind(sets: &[ElementSet], kind: u32) -> Option<&ElementSet> {
    sets.iter().find(|set| wants_normals(set) && set.request().kind == kind)
}

impl NormalsEnergy {
    /// Adds the forces of the energy, N, to `force` (n x 3).
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn forces(&mut self, pool: &Pool, state: SystemState<'_>, force: &mut [Vec3]) -> Result<(), ForceError> {
        let SystemState { material, sets, nodes, time } = state;
        let Some(set) = of_kind(sets, abi::TRIANGLE) else { return Ok(()) };
        self.field.update(pool, &nodes.x);
        self.parts.fill([0.0; 6]);
        let normals = bytemuck::cast_slice(&self.field.normal);
        set.schedule.run(pool, &mut self.parts, &|node| node, &|chunk, window| {
            material.normals_forces(&set.call(chunk, nodes, &nodes.v, time), normals, window)
        })?;
        self.field.pull_back(pool, &nodes.x, &mut self.parts, force);
        Ok(())
    }

    /// The energy of a state, J.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn energy(&mut self, state: SystemState<'_>) -> Result<f64, ForceError> {
        let SystemState { material, sets, nodes, time } = state;
        let Some(set) = of_kind(sets, abi::TRIANGLE) else { return Ok(0.0) };
        self.field.update(&Pool::new(1), &nodes.x);
        let normals = bytemuck::cast_slice(&self.field.normal);
        set.schedule.chunks().try_fold(0.0, |sum, chunk| {
            Ok(sum + material.normals_energy(&set.call(chunk, nodes, &nodes.v, time), normals)?)
        })
    }

    /// Adds the approximate Hessian of the energy to the blocks of a matrix; those of node i are `row[i]..row[i + 1]`.
    pub fn add_tangent(
        &self,
        pool: &Pool,
        sets: &[ElementSet],
        nodes: &Nodes,
        scales: SystemScales,
        row: &[usize],
        blocks: &mut [Block],
    ) {
        let Some(set) = of_kind(sets, abi::HINGE) else { return };
        let factor = scales.stiffness * bound_factor(scales.hessian);
        if factor == 0.0 {
            return;
        }
        let Ok(()) = set.schedule.run(pool, blocks, &|node| row[node], &|chunk, blocks| {
            let range = chunk.range.clone();
            let corners = &set.nodes().as_chunks::<4>().0[range.clone()];
            let terms = HingeHessian { corners, x: &nodes.x, stiffness: &self.stiffness[range.clone()], factor };
            let blocks = BlocksMut { first: row[chunk.window.start], blocks };
            f64::add_outer(&set.slots[10 * range.start..10 * range.end], blocks, &terms);
            Ok::<(), std::convert::Infallible>(())
        });
    }
}

/// Terms `k g g^T` of hinges that approximate the Hessian.
struct HingeHessian<'a> {
    /// Nodes of the hinges.
    corners: &'a [[u32; 4]],
    /// Positions of all nodes, m.
    x: &'a [Vec3],
    /// Stiffness of the hinges, N m.
    stiffness: &'a [f64],
    /// Factor of all terms.
    factor: f64,
}

impl Hinges for HingeHessian<'_> {
    #[inline(always)]
    fn hinge(&self, e: usize) -> ([Vec3; 4], f64) {
        (hinge::gradient(self.corners[e].map(|n| self.x[n as usize])), self.factor * self.stiffness[e])
    }
}
