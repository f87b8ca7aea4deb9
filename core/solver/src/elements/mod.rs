//! Element sets: the elements of a body that a material requests, with their rest data and history.

pub mod chunk;
pub mod corner_weights;
pub mod fused_assembly;
mod weighted;

use super::algebra::Vec3;
use super::nodes::Nodes;
use crate::force_model::{ElementCall, ForceError, ForceModel, StepTime};
use crate::threads::Pool;
use chunk::{Chunk, Schedule};
use corner_weights::CornerWeights;
use pliant_plugin_api::{ElementRequest, abi};
use std::ops::Range;
use weighted::WeightedElements;

/// The elements a discretisation provides for one request of a material: m elements of k nodes each, or m elements at stencils of ten nodes.
#[derive(Clone, Debug, Default)]
pub struct ElementList {
    /// Node indices (m x k), or with `weights` those of the stencils.
    pub nodes: Vec<u32>,
    /// Weights of the nodes in the corners, for tetrahedra whose corners are weighted sums of nodes; the elements of one stencil are consecutive.
    pub weights: Option<&'static CornerWeights>,
    /// Family of each element, such as structural or shear (m), or empty.
    pub family: Vec<u32>,
    /// Volume, area or length that each element represents, in the unit of its kind (m).
    pub measure: Vec<f64>,
    /// Material coordinates of the corners, m (m x k x 2), or empty.
    pub material: Vec<f64>,
    /// Factors of the material's parameters that may differ from element to element (fields x m), or empty.
    pub fields: Vec<f64>,
    /// Fibre directions in the axes of the rest shape, unit vectors or zero (m x 3), or empty (`WANTS_DIRECTIONS`).
    pub directions: Vec<[f64; 3]>,
}

/// The elements of one request with their rest data, history and chunks.
pub struct ElementSet {
    /// The request of the material.
    pub(super) request: ElementRequest,
    /// Whether every call has all elements, and no two calls run at once.
    pub(super) is_whole: bool,
    /// Number of nodes of an element, k.
    pub(super) corners: usize,
    /// Nodes, sizes and material coordinates of the elements.
    pub(super) list: ElementList,
    /// Rest data that the material has written (stride x m).
    pub(super) rest_data: Vec<f64>,
    /// History of the elements (stride x m).
    pub(super) history: Vec<f64>,
    /// History after the current step (stride x m), exchanged with `history` when the step is complete.
    pub(super) next_history: Vec<f64>,
    /// History at the beginning of a step that may be taken again (stride x m).
    pub(super) start_history: Vec<f64>,
    /// Which elements have failed: 1 for each, else 0 (m); empty if none can be.
    pub(super) failed: Vec<u8>,
    /// Buffer for the next `failed` (m).
    pub(super) next_failed: Vec<u8>,
    /// Number of elements that have failed.
    pub(super) failed_count: usize,
    /// Number of times `failed` has changed.
    pub(super) failed_changes: u64,
    /// Whether the history has changed since `failed` was written.
    pub(super) failed_is_stale: bool,
    /// Chunks of the list.
    pub(super) schedule: Schedule,
    /// Slots in the matrix of each pair of nodes of a stencil (stencils x pairs); empty without a matrix.
    pub(super) slots: Vec<u32>,
    /// Corners and slots that calls of weighted elements pass to the material instead of those of nodes.
    weighted: WeightedElements,
}

impl ElementSet {
    /// An empty set for a request. With `is_whole` every call has all elements, and no two calls run at once.
    pub fn new(request: ElementRequest, is_whole: bool) -> Self {
        Self {
            request,
            is_whole,
            corners: request.corners(),
            list: ElementList::default(),
            rest_data: Vec::new(),
            history: Vec::new(),
            next_history: Vec::new(),
            start_history: Vec::new(),
            failed: Vec::new(),
            next_failed: Vec::new(),
            failed_count: 0,
            failed_changes: 0,
            failed_is_stale: false,
            schedule: Schedule::default(),
            slots: Vec::new(),
            weighted: WeightedElements::default(),
        }
    }

    /// Number of elements.
    pub fn count(&self) -> usize {
        self.list.nodes.len() / self.stencil() * self.parts()
    }

    /// Number of nodes of a stencil: nodes that together determine the corners of one element, or of several whose corners are weighted sums of them.
    pub fn stencil(&self) -> usize {
        if self.list.weights.is_some() { corner_weights::NODES } else { self.corners }
    }

    /// Number of elements of a stencil.
    pub fn parts(&self) -> usize {
        self.list.weights.map_or(1, CornerWeights::parts)
    }

    /// Number of times that the list is halved between threads in a call for ranges of planes.
    pub(super) fn halvings(&self, pool: &Pool) -> u32 {
        if self.is_whole { 0 } else { pool.halvings() }
    }

    /// The span of node indices of a range of elements that begins and ends with a stencil.
    fn window(&self, range: &Range<usize>) -> Range<usize> {
        let parts = self.parts();
        chunk::window(&self.list.nodes, self.stencil(), &(range.start / parts..range.end / parts))
    }

    /// The request of the material.
    pub fn request(&self) -> &ElementRequest {
        &self.request
    }

    /// Node indices of the stencils.
    pub fn nodes(&self) -> &[u32] {
        &self.list.nodes
    }

    /// Factors of the parameters that vary, one row of all elements for each (planes x m); empty where none varies.
    pub fn fields(&self) -> &[f64] {
        &self.list.fields
    }

    /// Fibre directions, unit vectors or zero (m x 3); empty where none are given.
    pub fn directions(&self) -> &[[f64; 3]] {
        &self.list.directions
    }

    /// History of the elements (stride x m).
    pub fn history(&self) -> &[f64] {
        &self.history
    }

    /// Sets the history (stride x m).
    ///
    /// # Panics
    /// If the length differs from that of [`ElementSet::history`].
    pub fn set_history(&mut self, history: &[f64]) {
        self.history.copy_from_slice(history);
        self.failed_is_stale = true;
    }

    /// Which elements have failed: 1 for each, else 0 (m); empty if none can be. Current after [`System::update_failed`](crate::System::update_failed).
    pub fn failed(&self) -> &[u8] {
        &self.failed
    }

    /// Number of elements that have failed.
    pub fn failed_count(&self) -> usize {
        self.failed_count
    }

    /// Number of changes of [`ElementSet::failed`] and of the elements; two equal numbers mean the same list.
    pub fn failed_changes(&self) -> u64 {
        self.failed_changes
    }

    /// Calls `run` for the parts of a chunk between failed elements, in order; for the whole chunk if none of its elements has failed.
    pub(super) fn for_each_intact<E>(
        &self,
        chunk: &Chunk,
        mut run: impl FnMut(&Chunk) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.failed_count == 0 {
            return run(chunk);
        }
        let mut start = chunk.range.start;
        for end in chunk.range.clone().filter(|e| self.failed[*e] != 0).chain([chunk.range.end]) {
            if start < end {
                run(&Chunk { range: start..end, window: chunk.window.clone() })?;
            }
            start = end + 1;
        }
        Ok(())
    }

    /// Updates the list of failed elements by the material, if the history or the rest data have changed since the last update. After an error the list
    /// is as before, and the next call tries again.
    pub(super) fn update_failed(&mut self, material: &dyn ForceModel, nodes: &Nodes) -> Result<(), ForceError> {
        if !(self.failed_is_stale && self.has(abi::CAN_FAIL)) {
            return Ok(());
        }
        let (count, mut next) = (self.count(), std::mem::take(&mut self.next_failed));
        next.fill(0);
        let checked = match count {
            0 => Ok(()),
            _ => self.for_each_rest_call(nodes, |call| material.failed(call, &mut next)),
        };
        self.next_failed = next;
        checked?;
        self.failed_is_stale = false;
        if self.next_failed != self.failed {
            std::mem::swap(&mut self.failed, &mut self.next_failed);
            self.failed_count = self.failed.iter().filter(|failed| **failed != 0).count();
            self.failed_changes += 1;
        }
        Ok(())
    }

    /// Whether the request has a flag, one of those of [`pliant_plugin_api::abi`].
    pub fn has(&self, flag: u32) -> bool {
        self.request.flags & flag != 0
    }

    /// The list, to be refilled. Call [`System::prepare`](crate::System::prepare) next.
    pub fn list_mut(&mut self) -> &mut ElementList {
        &mut self.list
    }

    /// Divides the list into chunks, sets the history to zero and has the material write its rest data.
    pub(super) fn prepare(&mut self, material: &dyn ForceModel, nodes: &Nodes) -> Result<(), ForceError> {
        let count = self.count();
        if self.is_whole {
            let whole = (count > 0).then(|| Chunk { range: 0..count, window: self.window(&(0..count)) });
            self.schedule.assign(whole.into_iter());
        } else {
            self.schedule.cut(&self.list.nodes, self.stencil(), self.parts());
        }
        self.weighted.list(if self.list.weights.is_some() { count } else { 0 });
        self.history.clear();
        self.history.resize(count * self.request.history_stride as usize, 0.0);
        self.next_history.clone_from(&self.history);
        self.start_history.clone_from(&self.history);
        self.failed.clear();
        self.failed.resize(if self.has(abi::CAN_FAIL) { count } else { 0 }, 0);
        self.next_failed.clone_from(&self.failed);
        self.failed_changes += 1;
        let written = self.rest(material, nodes);
        // Without a history none has failed.
        (self.failed_count, self.failed_is_stale) = (0, false);
        written
    }

    /// Has the material write its rest data again, after the rest positions have changed.
    pub(super) fn rest(&mut self, material: &dyn ForceModel, nodes: &Nodes) -> Result<(), ForceError> {
        let count = self.count();
        // Which elements have failed follows from rest data too.
        self.failed_is_stale = true;
        let mut data = std::mem::take(&mut self.rest_data);
        data.clear();
        data.resize(count * self.request.rest_stride as usize, 0.0);
        let written = if count > 0 && self.request.rest_stride > 0 {
            self.for_each_rest_call(nodes, |call| match self.has(abi::WANTS_DIRECTIONS) {
                true => material.directed_rest(call, &self.list.directions, &mut data),
                false => material.rest(call, &mut data),
            })
        } else {
            Ok(())
        };
        // Kept after an error too, so that later calls pass arrays of the promised length.
        self.rest_data = data;
        written
    }

    /// The call for one chunk of elements whose corners are nodes, with velocities `v`.
    pub(super) fn call<'a>(
        &'a self,
        chunk: &Chunk,
        nodes: &'a Nodes,
        v: &'a [Vec3],
        time: StepTime,
    ) -> ElementCall<'a> {
        ElementCall {
            kind: self.request.kind,
            corners: self.corners,
            range: chunk.range.clone(),
            window: chunk.window.clone(),
            elements: &self.list.nodes,
            family: &self.list.family,
            measure: &self.list.measure,
            material: &self.list.material,
            rest: bytemuck::cast_slice(&nodes.rest),
            x: bytemuck::cast_slice(&nodes.x),
            v: bytemuck::cast_slice(v),
            rest_data: &self.rest_data,
            history: &self.history,
            fields: &self.list.fields,
            time,
        }
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod whole_list_tests;
