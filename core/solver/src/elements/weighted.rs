//! Calls of a material for elements whose corners are weighted sums of nodes.
//!
//! Elements are called in small batches: corners are gathered into arrays on the stack, the material sees them as nodes of their own, and what it writes is
//! scattered by the same weights. A batch has the elements of a few stencils, so its arrays stay in the first cache.

use super::ElementSet;
use super::chunk::Chunk;
use super::corner_weights::{CornerWeights, NODES, Part};
use crate::algebra::{Block, Vec3};
use crate::force_model::{ElementCall, ForceError, ForceModel, StepTime};
use crate::hinge_assembly::{BlocksMut, Precision};
use crate::lanes::{Lanes, Work, widest};
use crate::nodes::Nodes;
use pliant_plugin_api::{PlanesMut, TangentScale, abi};
use std::ops::Range;

/// Elements of a batch; a multiple of the elements of every stencil.
const BATCH: usize = 32;
/// Corners of the elements of a batch.
const CORNERS: usize = 4 * BATCH;
/// Pairs of corners of an element, each with itself included.
const PAIRS: usize = 10;
/// Pairs of nodes of a stencil, each with itself included.
const NODE_PAIRS: usize = NODES * (NODES + 1) / 2;

/// Vectors at the corners of a batch, by element.
type Corners = [[f64; 3]; CORNERS];

/// Corners and slots that calls of weighted elements pass instead of those of nodes. Each element has corners of its own, numbered by its position in its batch.
#[derive(Default)]
pub(super) struct WeightedElements {
    /// Corners of each element in the arrays of its batch (m x 4).
    corners: Vec<u32>,
    /// Slots of their pairs in the blocks of its batch (m x 10).
    slots: Vec<u32>,
}

impl WeightedElements {
    /// Lists the corners and slots of `count` elements.
    pub(super) fn list(&mut self, count: usize) {
        let repeat = |of: usize| (0..count).flat_map(move |e| (0..of).map(move |i| (e % BATCH * of + i) as u32));
        self.corners.clear();
        self.corners.extend(repeat(4));
        self.slots.clear();
        self.slots.extend(repeat(PAIRS));
    }
}

/// A call for one batch.
struct Batch<'a> {
    weights: &'static CornerWeights,
    call: ElementCall<'a>,
    /// The stencils of its elements, as indices in the list of stencils.
    stencils: Range<usize>,
}

impl Batch<'_> {
    /// Range in the arrays of the batch of the elements of a stencil.
    fn parts_of(&self, stencil: usize) -> Range<usize> {
        let parts = self.weights.parts();
        let first = stencil * parts % BATCH;
        first..first + parts
    }
}

/// Gathers the corners of the elements of some stencils.
struct Gather<'a> {
    weights: &'static CornerWeights,
    nodes: &'a [u32],
    stencils: Range<usize>,
    field: &'a [Vec3],
    out: &'a mut Corners,
}

impl Work for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, _: impl Lanes) {
        let parts = self.weights.parts;
        for stencil in self.stencils {
            let nodes = &self.nodes.as_chunks::<NODES>().0[stencil];
            let at = nodes.map(|node| self.field[node as usize]);
            let first = stencil * parts.len() % BATCH;
            for (part, out) in parts.iter().zip(self.out[4 * first..].as_chunks_mut::<4>().0) {
                let mut sum = [[0.0; 4]; 3];
                for (weights, x) in part.by_node.iter().zip(&at) {
                    for axis in 0..3 {
                        for corner in 0..4 {
                            sum[axis][corner] += weights[corner] * x[axis];
                        }
                    }
                }
                for corner in 0..4 {
                    out[corner] = [sum[0][corner], sum[1][corner], sum[2][corner]];
                }
            }
        }
    }
}

/// Adds forces at the corners of the elements of a stencil to those at its nodes.
#[inline(always)]
fn pull_back(parts: &[Part], corners: &[[[f64; 3]; 4]]) -> [[f64; 12]; 3] {
    let mut sum = [[0.0; 12]; 3];
    for (part, forces) in parts.iter().zip(corners) {
        for (weights, force) in part.by_corner.iter().zip(forces) {
            for axis in 0..3 {
                for node in 0..12 {
                    sum[axis][node] += weights[node] * force[axis];
                }
            }
        }
    }
    sum
}

/// Adds the forces of some stencils to their nodes.
struct Scatter<'a> {
    weights: &'static CornerWeights,
    nodes: &'a [u32],
    stencils: Range<usize>,
    forces: &'a Corners,
    /// First node of `out`.
    first: usize,
    out: &'a mut [[f64; 3]],
}

impl Work for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, _: impl Lanes) {
        let parts = self.weights.parts;
        for stencil in self.stencils {
            let first = stencil * parts.len() % BATCH;
            let sum = pull_back(parts, &self.forces[4 * first..].as_chunks::<4>().0[..parts.len()]);
            for (place, node) in self.nodes.as_chunks::<NODES>().0[stencil].iter().enumerate() {
                let out = &mut self.out[*node as usize - self.first];
                for axis in 0..3 {
                    out[axis] += sum[axis][place];
                }
            }
        }
    }
}

/// Stiffness of a stencil: entry (r, c) of the block of nodes a and b, b >= a, at `[a][3 r + c][b]`.
type StencilStiffness = [[[f64; 12]; 9]; NODES];

/// Sums the stiffness of the elements of a stencil, whose `blocks` are those of the pairs of their corners.
struct Stiffness<'a> {
    parts: &'static [Part],
    blocks: &'a [[Block; PAIRS]],
    out: &'a mut StencilStiffness,
}

impl Work for Stiffness<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, _: impl Lanes) {
        self.out.as_flattened_mut().fill([0.0; 12]);
        for (part, blocks) in self.parts.iter().zip(self.blocks) {
            // Blocks of all pairs of corners, also of those below the diagonal.
            let mut all = [[[0.0; 9]; 4]; 4];
            let pairs = (0..4).flat_map(|i| (i..4).map(move |j| (i, j)));
            for ((i, j), block) in pairs.zip(blocks) {
                all[j][i] = std::array::from_fn(|entry| block[3 * (entry % 3) + entry / 3]);
                all[i][j] = *block;
            }
            // K W: row and entry of each corner, by node.
            let mut product = [[[0.0; 12]; 9]; 4];
            let [w0, w1, w2, w3] = &part.by_corner;
            for (product, [k0, k1, k2, k3]) in product.iter_mut().zip(&all) {
                for entry in 0..9 {
                    for node in 0..12 {
                        product[entry][node] =
                            k0[entry] * w0[node] + k1[entry] * w1[node] + k2[entry] * w2[node] + k3[entry] * w3[node];
                    }
                }
            }
            // W^T (K W), of nodes from `a` on, by four.
            for (a, out) in self.out.iter_mut().enumerate() {
                let [w0, w1, w2, w3] = part.by_node[a];
                for entry in 0..9 {
                    let rows = [0, 1, 2, 3].map(|corner| product[corner][entry].as_chunks::<4>().0);
                    for (four, out) in out[entry].as_chunks_mut::<4>().0.iter_mut().enumerate().skip(a / 4) {
                        for (lane, sum) in out.iter_mut().enumerate() {
                            *sum += w0 * rows[0][four][lane]
                                + w1 * rows[1][four][lane]
                                + w2 * rows[2][four][lane]
                                + w3 * rows[3][four][lane];
                        }
                    }
                }
            }
        }
    }
}

impl ElementSet {
    /// Adds the forces of a chunk to `out`, N, one for each node of its window.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(crate) fn add_forces(
        &self,
        material: &dyn ForceModel,
        chunk: &Chunk,
        nodes: &Nodes,
        v: &[Vec3],
        time: StepTime,
        out: &mut [[f64; 3]],
    ) -> Result<(), ForceError> {
        if self.list.weights.is_none() {
            return material.forces(&self.call(chunk, nodes, v, time), out);
        }
        self.for_each_batch(&chunk.range, nodes, v, time, |batch| {
            let mut forces = [[0.0; 3]; CORNERS];
            material.forces(&batch.call, &mut forces)?;
            widest(Scatter {
                weights: batch.weights,
                nodes: &self.list.nodes,
                stencils: batch.stencils,
                forces: &forces,
                first: chunk.window.start,
                out: &mut *out,
            });
            Ok(())
        })
    }

    /// Elastic energy of a chunk, J.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(crate) fn energy(
        &self,
        material: &dyn ForceModel,
        chunk: &Chunk,
        nodes: &Nodes,
        time: StepTime,
    ) -> Result<f64, ForceError> {
        if self.list.weights.is_none() {
            return material.energy(&self.call(chunk, nodes, &nodes.v, time));
        }
        let mut sum = 0.0;
        self.for_each_batch(&chunk.range, nodes, &nodes.v, time, |batch| {
            sum += material.energy(&batch.call)?;
            Ok(())
        })?;
        Ok(sum)
    }

    /// Adds the masses of a chunk to `out`, kg, one for each node of its window. The mass of weighted elements is given to nodes by
    /// [`CornerWeights::MASS_SHARES`].
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(crate) fn add_mass(
        &self,
        material: &dyn ForceModel,
        chunk: &Chunk,
        nodes: &Nodes,
        out: &mut [f64],
    ) -> Result<(), ForceError> {
        let time = StepTime::default();
        if self.list.weights.is_none() {
            return material.mass(&self.call(chunk, nodes, &nodes.v, time), out);
        }
        self.for_each_batch(&chunk.range, nodes, &nodes.v, time, |batch| {
            let mut masses = [0.0; CORNERS];
            material.mass(&batch.call, &mut masses)?;
            for stencil in batch.stencils.clone() {
                let mass: f64 = masses.as_chunks::<4>().0[batch.parts_of(stencil)].as_flattened().iter().sum();
                let nodes = &self.list.nodes.as_chunks::<NODES>().0[stencil];
                for (node, share) in nodes.iter().zip(CornerWeights::MASS_SHARES) {
                    out[*node as usize - chunk.window.start] += share * mass;
                }
            }
            Ok(())
        })
    }

    /// Adds the tangent of a chunk to blocks of the matrix.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(crate) fn add_tangent<T: Precision>(
        &self,
        material: &dyn ForceModel,
        chunk: &Chunk,
        nodes: &Nodes,
        time: StepTime,
        scale: TangentScale,
        mut blocks: BlocksMut<'_, T>,
    ) -> Result<(), ForceError> {
        if self.list.weights.is_none() {
            let call = self.call(chunk, nodes, &nodes.v, time);
            return T::add_tangent(material, &call, scale, &self.slots, blocks);
        }
        self.for_each_batch(&chunk.range, nodes, &nodes.v, time, |batch| {
            let mut of_elements = [[[0.0; 9]; PAIRS]; BATCH];
            material.tangent(&batch.call, scale, &self.weighted.slots, 0, of_elements.as_flattened_mut())?;
            let mut stiffness = [[[0.0; 12]; 9]; NODES];
            for stencil in batch.stencils.clone() {
                let of_stencil = &of_elements[batch.parts_of(stencil)];
                widest(Stiffness { parts: batch.weights.parts, blocks: of_stencil, out: &mut stiffness });
                scatter(&stiffness, &self.slots.as_chunks::<NODE_PAIRS>().0[stencil], &mut blocks);
            }
            Ok(())
        })
    }

    /// Updates the history of a range of elements, in `history` (stride x m), after a step.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub(crate) fn advance(
        &self,
        material: &dyn ForceModel,
        chunk: &Chunk,
        nodes: &Nodes,
        time: StepTime,
        history: &mut PlanesMut<'_>,
    ) -> Result<(), ForceError> {
        if self.list.weights.is_none() {
            return material.advance(&self.call(chunk, nodes, &nodes.v, time), history);
        }
        self.for_each_batch(&chunk.range, nodes, &nodes.v, time, |batch| material.advance(&batch.call, history))
    }

    /// Calls `run` for the elements of all calls that concern the shape at rest: for all at once, or batch by batch.
    ///
    /// # Errors
    /// Returns the first error of `run`.
    pub(super) fn for_each_rest_call(
        &self,
        nodes: &Nodes,
        mut run: impl FnMut(&ElementCall<'_>) -> Result<(), ForceError>,
    ) -> Result<(), ForceError> {
        let (count, time) = (self.count(), StepTime::default());
        if self.list.weights.is_some() {
            return self.for_each_batch(&(0..count), nodes, &nodes.v, time, |batch| run(&batch.call));
        }
        let whole = Chunk { range: 0..count, window: 0..nodes.x.len() };
        run(&self.call(&whole, nodes, &nodes.v, time))
    }

    /// Calls `run` for the batches of a range of weighted elements.
    fn for_each_batch(
        &self,
        range: &Range<usize>,
        nodes: &Nodes,
        v: &[Vec3],
        time: StepTime,
        mut run: impl FnMut(Batch<'_>) -> Result<(), ForceError>,
    ) -> Result<(), ForceError> {
        let Some(weights) = self.list.weights else { return Ok(()) };
        let parts = weights.parts();
        let last = range.end.div_ceil(parts);
        let (mut rest, mut x, mut velocity) = ([[0.0; 3]; CORNERS], [[0.0; 3]; CORNERS], [[0.0; 3]; CORNERS]);
        for first in (range.start / parts..last).step_by(BATCH / parts) {
            let stencils = first..last.min(first + BATCH / parts);
            for (field, out) in [(&nodes.rest[..], &mut rest), (&nodes.x, &mut x), (v, &mut velocity)] {
                widest(Gather { weights, nodes: &self.list.nodes, stencils: stencils.clone(), field, out });
            }
            let elements = range.start.max(stencils.start * parts)..range.end.min(stencils.end * parts);
            let call = ElementCall {
                kind: self.request.kind,
                corners: 4,
                range: elements,
                window: 0..CORNERS,
                elements: &self.weighted.corners,
                family: &self.list.family,
                measure: &self.list.measure,
                material: &self.list.material,
                rest: &rest,
                x: &x,
                v: &velocity,
                rest_data: &self.rest_data,
                history: &self.history,
                fields: &self.list.fields,
                time,
            };
            run(Batch { weights, call, stencils })?;
        }
        Ok(())
    }
}

/// Adds the stiffness of a stencil to the blocks of its pairs of nodes.
fn scatter<T: Precision>(stiffness: &StencilStiffness, slots: &[u32; NODE_PAIRS], blocks: &mut BlocksMut<'_, T>) {
    let mut slots = slots.iter();
    for (a, row) in stiffness.iter().enumerate() {
        for (b, slot) in (a..NODES).zip(slots.by_ref()) {
            if a == b && !T::HAS_DIAGONAL_BLOCKS {
                continue;
            }
            let block = &mut blocks.blocks[(slot & !abi::TRANSPOSED) as usize - blocks.first];
            let is_transposed = slot & abi::TRANSPOSED != 0;
            for entry in 0..9 {
                let from = if is_transposed { 3 * (entry % 3) + entry / 3 } else { entry };
                block[entry] += T::from_f64(row[from][b]);
            }
        }
    }
}
