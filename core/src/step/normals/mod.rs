//! Energies of vertex normals: the material gives E(x, n) of its triangles, the normals and what they do to the nodes are found here.
//!
//! A normal needs the ring of its vertex, which a material does not see. Forces are those of E at fixed normals, as Tripicchio,
//! D'Avella and Ruffaldi (2022) have them, and what the normals add as they turn; without that angular momentum is lost. As a
//! matrix the former alone would brake every turn, so hinges stand for all of it.
//!
//! The normal of a clamped edge is that of the mirror image beyond it, which is held; a normal at a triangle that is held altogether
//! is that of the triangle. So a clamp is where it was set, not half a cell on.

mod field;
mod stand_in;

use super::chunk::Chunk;
use super::elements::ElementSet;
use super::hinge;
use super::pool::Pool;
use super::system::Nodes;
use super::{Block, Constraint, Factors, V3};
use crate::host::{HostError, Material};
use field::{Facet, Field};
use pliant_plugin_api::abi;
use stand_in::{Around, share};

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
    /// After nodes or elements have changed.
    ///
    /// # Errors
    /// What the material says.
    pub fn prepare(&mut self, material: &Material, sets: &[ElementSet], nodes: &Nodes) -> Result<(), HostError> {
        let (Some(triangles), Some(hinges)) = (of_kind(sets, abi::TRIANGLE), of_kind(sets, abi::HINGE)) else {
            return Ok(());
        };
        let count = triangles.count();
        let mut tilt = vec![0.0; 3 * count];
        if count > 0 {
            let whole = Chunk { range: 0..count, window: 0..nodes.len() };
            material.tilt(&triangles.call(&whole, nodes, &nodes.v, (0.0, 0.0)), &mut tilt)?;
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

    /// Finds how stiff each hinge is that stands for the energy.
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

    /// Adds what the energy does to the nodes, N (n x 3).
    ///
    /// # Errors
    /// What the material says.
    pub fn forces(
        &mut self,
        pool: &Pool,
        material: &Material,
        (sets, nodes, time): (&[ElementSet], &Nodes, (f64, f64)),
        force: &mut [V3],
    ) -> Result<(), HostError> {
        let Some(set) = of_kind(sets, abi::TRIANGLE) else { return Ok(()) };
        self.field.load(pool, &nodes.x);
        self.parts.fill([0.0; 6]);
        let normals = &self.field.normal;
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
        material: &Material,
        sets: &[ElementSet],
        nodes: &Nodes,
        time: (f64, f64),
    ) -> Result<f64, HostError> {
        let Some(set) = of_kind(sets, abi::TRIANGLE) else { return Ok(0.0) };
        self.field.load(&Pool::new(1), &nodes.x);
        let normals = &self.field.normal;
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
            let first = bound(chunk.window.start);
            for (e, corners) in set.nodes().as_chunks::<4>().0[chunk.range.clone()].iter().enumerate() {
                let e = e + chunk.range.start;
                let g = hinge::gradient(corners.map(|n| nodes.x[n as usize]));
                hinge::add_outer(&set.slots[10 * e..10 * e + 10], &g, factor * self.stiffness[e], first, blocks);
            }
            Ok::<(), std::convert::Infallible>(())
        });
    }
}
