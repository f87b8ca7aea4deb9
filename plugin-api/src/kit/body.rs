//! A small body for tests, and what a material computes for it.

mod guarded_call;
mod inputs;

pub(super) use guarded_call::{AtPage, Function, GuardChange, INPUTS, OUTPUT, PLANES, StrayWrite, Surroundings};

use super::guarded_planes::GuardedPlanes;
use super::tested_material::{Call, MaterialUnderTest};
use super::{ElementList, corners};
use crate::abi;
use crate::batch::Strides;
use crate::fault::Fault;
use crate::material::{ElementRequest, TangentScale};
use core::marker::PhantomData;
use std::collections::BTreeMap;
use std::ops::Range;
use std::ptr::null;

/// Nodes in a state, and the elements between them: a body without a host. n is the number of its nodes.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Rest positions, m (n x 3).
    pub rest: Vec<[f64; 3]>,
    /// Positions, m (n x 3).
    pub x: Vec<[f64; 3]>,
    /// Velocities, m/s (n x 3).
    pub v: Vec<[f64; 3]>,
    /// One set for each request of the material, in its order.
    sets: Vec<ElementSet>,
}

/// Values of elements with K corners, plane-major.
#[derive(Clone, Debug, Default)]
pub struct ElementPlanes<const K: usize> {
    /// (planes x m)
    pub values: Vec<f64>,
    /// Nodes of each element (m x K).
    pub corners: Vec<[u32; K]>,
}

impl<const K: usize> ElementPlanes<K> {
    /// One plane (m).
    pub fn plane(&self, plane: usize) -> &[f64] {
        let m = self.corners.len();
        &self.values[plane * m..(plane + 1) * m]
    }
}

/// The elements of one request, with their data.
#[derive(Clone, Debug)]
struct ElementSet {
    request: ElementRequest,
    corners: usize,
    nodes: Vec<u32>,
    family: Vec<u32>,
    measure: Vec<f64>,
    material: Vec<f64>,
    rest_data: GuardedPlanes,
    history: GuardedPlanes,
    /// Fibre directions, along x at first (m); empty where the request does not want them.
    directions: Vec<[f64; 3]>,
    /// Number of planes of `fields`.
    field_count: usize,
    /// Factors of the parameters that are fields (field_count x m), between planes of NaN.
    fields: GuardedPlanes,
}

impl ElementSet {
    /// Number of elements.
    fn count(&self) -> usize {
        self.nodes.len() / self.corners
    }

    /// Middles of the elements at rest, m (m), from the rest positions of all nodes.
    fn middles(&self, rest: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let middle = |nodes: &[u32]| {
            let sum = |i: usize| nodes.iter().map(|n| rest[*n as usize][i]).sum::<f64>();
            [0, 1, 2].map(|i| sum(i) / self.corners as f64)
        };
        self.nodes.chunks_exact(self.corners).map(middle).collect()
    }

    /// Number of blocks: one for each pair of corners of each element.
    fn block_count(&self) -> usize {
        self.count() * self.corners * (self.corners + 1) / 2
    }

    /// Slots by which pairs of the same two nodes share a block, and the number of blocks.
    fn shared_slots(&self) -> (Vec<u32>, usize) {
        let (mut slots, mut blocks) = (Vec::with_capacity(self.block_count()), BTreeMap::new());
        for nodes in self.nodes.chunks_exact(self.corners) {
            for (a, b) in (0..self.corners).flat_map(|a| (a..self.corners).map(move |b| (a, b))) {
                let (i, j, next) = (nodes[a], nodes[b], blocks.len() as u32);
                let block = *blocks.entry((i.min(j), i.max(j))).or_insert(next);
                slots.push(if i > j { block | abi::TRANSPOSED } else { block });
            }
        }
        (slots, blocks.len())
    }
}

/// Blocks of a body with pairs of the same two nodes added up (sets x pairs of nodes x 9), N/m.
#[derive(Debug)]
pub struct SummedBlocks {
    /// In double precision.
    pub double: Vec<Vec<[f64; 9]>>,
    /// In single precision; zero for elements without [`abi::HAS_SINGLE`], and diagonal blocks.
    pub single: Vec<Vec<[f32; 9]>>,
}

impl Body {
    /// A body at rest with the elements `elements` gives for each request of `material`, and their rest data. Elements that want fibre
    /// directions have them along x.
    ///
    /// # Errors
    /// The material's fault about the rest shape.
    ///
    /// # Panics
    /// On an element with a node that does not exist.
    pub fn new<S: MaterialUnderTest + ?Sized>(
        material: &S,
        rest: Vec<[f64; 3]>,
        elements: impl Fn(&ElementRequest) -> ElementList,
    ) -> Result<Self, Fault> {
        let mut body = Self { x: rest.clone(), v: vec![[0.0; 3]; rest.len()], rest, sets: Vec::new() };
        for request in material.element_requests()? {
            let list = elements(&request);
            let corners = corners(request.kind);
            let count = list.nodes.len() / corners;
            assert!(list.nodes.iter().all(|n| (*n as usize) < body.rest.len()), "every corner is a node");
            body.sets.push(ElementSet {
                request,
                corners,
                nodes: list.nodes,
                family: if list.family.is_empty() { vec![abi::STRUCTURAL; count] } else { list.family },
                measure: if list.measure.is_empty() { vec![1.0; count] } else { list.measure },
                material: list.material,
                rest_data: GuardedPlanes::new(request.rest_stride as usize, count),
                history: GuardedPlanes::new(request.history_stride as usize, count),
                directions: vec![[1.0, 0.0, 0.0]; if request.flags & abi::WANTS_DIRECTIONS != 0 { count } else { 0 }],
                field_count: 0,
                fields: GuardedPlanes::default(),
            });
        }
        body.write_rest_data(material)?;
        Ok(body)
    }

    /// Has the material write all rest data.
    pub(super) fn write_rest_data<S: MaterialUnderTest + ?Sized>(&mut self, material: &S) -> Result<(), Fault> {
        for s in (0..self.sets.len()).filter(|s| self.sets[*s].request.rest_stride > 0).collect::<Vec<_>>() {
            let mut data = std::mem::take(&mut self.sets[s].rest_data);
            let (set, call) = (&self.sets[s], self.call(s, 0..self.sets[s].count()));
            let written = match set.request.flags & abi::WANTS_DIRECTIONS {
                0 => material.call_rest(&call, data.planes_mut()),
                _ => material.call_directed_rest(&call, &set.directions, data.planes_mut()),
            };
            self.sets[s].rest_data = data;
            written?;
        }
        Ok(())
    }

    /// Sets the factors of the `count` parameters that are fields: `factor(field, middle of the element at rest, m)`. The material writes its
    /// rest data again.
    ///
    /// # Errors
    /// The material's fault.
    pub fn set_fields<S: MaterialUnderTest + ?Sized>(
        &mut self,
        material: &S,
        count: usize,
        factor: impl Fn(usize, [f64; 3]) -> f64,
    ) -> Result<(), Fault> {
        for set in &mut self.sets {
            let middles = set.middles(&self.rest);
            set.field_count = count;
            set.fields = GuardedPlanes::new(count, middles.len());
            set.fields.set_guards(f64::NAN);
            let elements = (0..count).flat_map(|field| middles.iter().map(move |m| (field, *m)));
            set.fields.planes_mut().iter_mut().zip(elements).for_each(|(out, (f, m))| *out = factor(f, m));
        }
        self.write_rest_data(material)
    }

    /// Sets the fibre directions of elements that want them: `direction(middle of the element at rest, m)`, a unit vector or zero. The material writes
    /// its rest data again.
    ///
    /// # Errors
    /// The material's fault.
    pub fn set_directions<S: MaterialUnderTest + ?Sized>(
        &mut self,
        material: &S,
        mut direction: impl FnMut([f64; 3]) -> [f64; 3],
    ) -> Result<(), Fault> {
        for set in self.sets.iter_mut().filter(|set| set.request.flags & abi::WANTS_DIRECTIONS != 0) {
            set.directions = set.middles(&self.rest).into_iter().map(&mut direction).collect();
        }
        self.write_rest_data(material)
    }

    /// Turns the shape at rest with its fibre directions by `rotation`, a rotation about the origin; positions and velocities stay. The material
    /// writes its rest data again.
    ///
    /// # Errors
    /// The material's fault.
    pub fn rotate_rest<S: MaterialUnderTest + ?Sized>(
        &mut self,
        material: &S,
        rotation: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<(), Fault> {
        self.rest.iter_mut().for_each(|r| *r = rotation(*r));
        self.sets.iter_mut().flat_map(|set| &mut set.directions).for_each(|d| *d = rotation(*d));
        self.write_rest_data(material)
    }

    /// The call for a range of a set's elements, with the span of nodes these have.
    fn call(&self, set: usize, range: Range<usize>) -> Call<'_> {
        let set = &self.sets[set];
        let nodes = || set.nodes[range.start * set.corners..range.end * set.corners].iter().map(|n| *n as usize);
        let or_null = |list: &[f64]| if list.is_empty() { null() } else { list.as_ptr() };
        let batch = abi::Batch {
            size: size_of::<abi::Batch>(),
            kind: set.request.kind,
            corners: set.corners as u32,
            begin: range.start,
            end: range.end,
            count: set.count(),
            node_begin: nodes().min().unwrap_or(0),
            node_end: nodes().max().map_or(0, |n| n + 1),
            nodes: self.rest.len(),
            elements: set.nodes.as_ptr(),
            family: if set.request.kind == abi::LINK { set.family.as_ptr() } else { null() },
            measure: set.measure.as_ptr(),
            material: or_null(&set.material),
            rest: self.rest.as_ptr().cast(),
            x: self.x.as_ptr().cast(),
            v: self.v.as_ptr().cast(),
            rest_data: set.rest_data.as_ptr(),
            history: set.history.as_ptr(),
            time: 0.0,
            dt: 1e-3,
            rest_stride: set.request.rest_stride as usize,
            history_stride: set.request.history_stride as usize,
            field_count: set.field_count,
            fields: set.fields.as_ptr(),
        };
        let strides = Strides { rest: set.request.rest_stride as usize, history: set.request.history_stride as usize };
        Call { batch, strides, borrowed: PhantomData }
    }

    /// Runs `run` (index of the set, call) for every set with `flag`, in calls of at most `max_elements` elements.
    pub(super) fn for_each_call(
        &self,
        flag: u32,
        max_elements: usize,
        mut run: impl FnMut(usize, &Call<'_>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        for set in (0..self.sets.len()).filter(|s| self.sets[*s].request.flags & flag != 0) {
            let count = self.sets[set].count();
            for begin in (0..count).step_by(max_elements.clamp(1, count.max(1))) {
                run(set, &self.call(set, begin..count.min(begin.saturating_add(max_elements))))?;
            }
        }
        Ok(())
    }

    /// Whether a kind of element has all of these flags ([`abi::HAS_MASS`], ...).
    pub fn has(&self, flags: u32) -> bool {
        self.sets.iter().any(|s| s.request.flags & flags == flags)
    }

    /// Every request, with the number of its elements.
    pub fn element_counts(&self) -> impl Iterator<Item = (ElementRequest, usize)> + '_ {
        self.sets.iter().map(|s| (s.request, s.count()))
    }

    /// Lumped masses, kg (n).
    ///
    /// # Errors
    /// The material's fault.
    pub fn mass<S: MaterialUnderTest + ?Sized>(&self, material: &S) -> Result<Vec<f64>, Fault> {
        let mut mass = vec![0.0; self.rest.len()];
        self.for_each_call(abi::HAS_MASS, usize::MAX, |_, call| material.call_mass(call, &mut mass))?;
        Ok(mass)
    }

    /// Elastic energy, J.
    ///
    /// # Errors
    /// The material's fault.
    pub fn energy<S: MaterialUnderTest + ?Sized>(&self, material: &S) -> Result<f64, Fault> {
        let mut energy = 0.0;
        self.for_each_call(abi::HAS_FORCES, usize::MAX, |_, call| {
            energy += material.call_energy(call)?;
            Ok(())
        })?;
        Ok(energy)
    }

    /// Adds nodal forces to `force`, N (n x 3).
    ///
    /// # Errors
    /// The material's fault.
    pub fn add_forces<S: MaterialUnderTest + ?Sized>(&self, material: &S, force: &mut [[f64; 3]]) -> Result<(), Fault> {
        self.add_forces_in_calls(material, usize::MAX, force)
    }

    /// Adds nodal forces to `force`, N (n x 3), in calls of at most `max_elements` elements.
    ///
    /// # Errors
    /// The material's fault.
    pub fn add_forces_in_calls<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        max_elements: usize,
        force: &mut [[f64; 3]],
    ) -> Result<(), Fault> {
        self.for_each_call(abi::HAS_FORCES, max_elements, |_, call| material.call_forces(call, force))
    }

    /// Nodal forces, N (n x 3).
    ///
    /// # Errors
    /// The material's fault.
    pub fn forces<S: MaterialUnderTest + ?Sized>(&self, material: &S) -> Result<Vec<[f64; 3]>, Fault> {
        let mut force = vec![[0.0; 3]; self.rest.len()];
        self.add_forces(material, &mut force)?;
        Ok(force)
    }

    /// Dense `scale.stiffness K + scale.damping C`, N/m, (3n x 3n) row-major.
    ///
    /// # Errors
    /// The material's fault.
    pub fn tangent<S: MaterialUnderTest + ?Sized>(&self, material: &S, scale: TangentScale) -> Result<Vec<f64>, Fault> {
        let blocks = self.blocks(material, scale, usize::MAX)?;
        Ok(self.dense(&blocks))
    }

    /// The blocks of every element with forces, N/m (sets x elements * pairs x 9), computed in calls of at most `max_elements` elements.
    ///
    /// # Errors
    /// The material's fault.
    pub fn blocks<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        scale: TangentScale,
        max_elements: usize,
    ) -> Result<Vec<Vec<[f64; 9]>>, Fault> {
        let slots: Vec<Vec<u32>> = self.sets.iter().map(|s| (0..s.block_count() as u32).collect()).collect();
        let mut out: Vec<Vec<[f64; 9]>> = self.sets.iter().map(|s| vec![[0.0; 9]; s.block_count()]).collect();
        self.for_each_call(abi::HAS_FORCES, max_elements, |s, call| {
            material.call_tangent(call, scale, &slots[s], &mut out[s])
        })?;
        Ok(out)
    }

    /// [`Body::blocks`] in single precision, of elements with [`abi::HAS_SINGLE`]: diagonal blocks are zero.
    ///
    /// # Errors
    /// The material's fault.
    pub fn single_blocks<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        scale: TangentScale,
        max_elements: usize,
    ) -> Result<Vec<Vec<[f32; 9]>>, Fault> {
        let slots: Vec<Vec<u32>> = self.sets.iter().map(|s| (0..s.block_count() as u32).collect()).collect();
        let mut out: Vec<Vec<[f32; 9]>> = self.sets.iter().map(|s| vec![[0.0; 9]; s.block_count()]).collect();
        self.for_each_call(abi::HAS_SINGLE, max_elements, |s, call| {
            material.call_single_tangent(call, scale, &slots[s], &mut out[s])
        })?;
        Ok(out)
    }

    /// The blocks of every set with pairs of the same two nodes added up, as in a host's matrix: their bytes depend on the order in which a material
    /// adds.
    ///
    /// # Errors
    /// The material's fault.
    pub fn summed_blocks<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        scale: TangentScale,
    ) -> Result<SummedBlocks, Fault> {
        let slots: Vec<(Vec<u32>, usize)> = self.sets.iter().map(ElementSet::shared_slots).collect();
        let mut double: Vec<_> = slots.iter().map(|(_, count)| vec![[0.0; 9]; *count]).collect();
        let mut single: Vec<_> = slots.iter().map(|(_, count)| vec![[0.0; 9]; *count]).collect();
        self.for_each_call(abi::HAS_FORCES, usize::MAX, |s, call| {
            material.call_tangent(call, scale, &slots[s].0, &mut double[s])
        })?;
        self.for_each_call(abi::HAS_SINGLE, usize::MAX, |s, call| {
            material.call_single_tangent(call, scale, &slots[s].0, &mut single[s])
        })?;
        Ok(SummedBlocks { double, single })
    }

    /// Histories after a step of 1 ms that ended in the present state, one for each request (stride x m, plane-major), computed in calls
    /// of at most `max_elements` elements.
    ///
    /// # Errors
    /// The material's fault.
    pub fn next_histories<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        max_elements: usize,
    ) -> Result<Vec<Vec<f64>>, Fault> {
        let next = self.next_guarded_histories(material, max_elements)?;
        Ok(next.iter().map(|planes| planes.planes().to_vec()).collect())
    }

    /// [`Body::next_histories`] with their guard planes.
    pub(super) fn next_guarded_histories<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        max_elements: usize,
    ) -> Result<Vec<GuardedPlanes>, Fault> {
        let mut next: Vec<GuardedPlanes> = self.sets.iter().map(|s| s.history.clone()).collect();
        self.for_each_call(abi::HAS_HISTORY, max_elements, |s, call| {
            material.call_advance(call, next[s].planes_mut())
        })?;
        Ok(next)
    }

    /// Brings the history up to date after a step of 1 ms that ended in the present state.
    ///
    /// # Errors
    /// The material's fault.
    pub fn advance<S: MaterialUnderTest + ?Sized>(&mut self, material: &S) -> Result<(), Fault> {
        let next = self.next_guarded_histories(material, usize::MAX)?;
        self.sets.iter_mut().zip(next).for_each(|(set, next)| set.history = next);
        Ok(())
    }

    /// Which elements have failed, by their history, for each request with [`abi::CAN_FAIL`] (m); empty for others.
    ///
    /// # Errors
    /// The material's fault.
    pub fn failed<S: MaterialUnderTest + ?Sized>(&self, material: &S) -> Result<Vec<Vec<u8>>, Fault> {
        let can_fail = |set: &ElementSet| set.request.flags & abi::CAN_FAIL != 0;
        let mut all: Vec<Vec<u8>> =
            self.sets.iter().map(|s| vec![0; if can_fail(s) { s.count() } else { 0 }]).collect();
        self.for_each_call(abi::CAN_FAIL, usize::MAX, |s, call| material.call_failed(call, &mut all[s]))?;
        Ok(all)
    }

    /// History of the elements of each request (stride x m, plane-major).
    pub fn histories(&self) -> impl Iterator<Item = &[f64]> {
        self.sets.iter().map(|set| set.history.planes())
    }

    /// Coupled hinges: plane 0 the strain, m, planes 1 to 12 its gradient by corner and axis. Values not written are NaN.
    ///
    /// # Errors
    /// The material's fault.
    pub fn strains<S: MaterialUnderTest + ?Sized>(&self, material: &S) -> Result<ElementPlanes<4>, Fault> {
        self.element_planes(abi::HINGE, abi::IS_COUPLED, 13, |call, out| material.call_strain(call, out))
    }

    /// Coupled triangles: compliance between the sides 01, 12, 20, m/N (6 planes). Values not written are NaN.
    ///
    /// # Errors
    /// The material's fault.
    pub fn compliances<S: MaterialUnderTest + ?Sized>(&self, material: &S) -> Result<ElementPlanes<3>, Fault> {
        self.element_planes(abi::TRIANGLE, abi::IS_COUPLED, 6, |call, out| material.call_compliance(call, out))
    }

    /// `plane_count` planes that `fill` writes for the elements of a kind with `flag`; NaN where nothing was written.
    pub(super) fn element_planes<const K: usize>(
        &self,
        kind: u32,
        flag: u32,
        plane_count: usize,
        mut fill: impl FnMut(&Call<'_>, &mut [f64]) -> Result<(), Fault>,
    ) -> Result<ElementPlanes<K>, Fault> {
        let Some(set) = self.sets.iter().find(|s| s.request.kind == kind) else { return Ok(Default::default()) };
        let mut values = vec![f64::NAN; plane_count * set.count()];
        self.for_each_call(flag, usize::MAX, |s, call| {
            if self.sets[s].request.kind == kind { fill(call, &mut values) } else { Ok(()) }
        })?;
        Ok(ElementPlanes { values, corners: set.nodes.as_chunks::<K>().0.to_vec() })
    }

    /// The sum of all elements' blocks as a dense matrix (3n x 3n), row-major.
    fn dense(&self, blocks: &[Vec<[f64; 9]>]) -> Vec<f64> {
        let width = 3 * self.rest.len();
        let mut dense = vec![0.0; width * width];
        for (set, blocks) in self.sets.iter().zip(blocks) {
            let k = set.corners;
            let pairs = (0..k).flat_map(|a| (a..k).map(move |b| (a, b)));
            for (element, e) in set.nodes.chunks_exact(k).zip(0..) {
                for ((a, b), pair) in pairs.clone().zip(0..) {
                    let (i, j) = (3 * element[a] as usize, 3 * element[b] as usize);
                    for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                        let value = blocks[e * k * (k + 1) / 2 + pair][3 * r + c];
                        dense[(i + r) * width + j + c] += value;
                        if a != b {
                            dense[(j + c) * width + i + r] += value;
                        }
                    }
                }
            }
        }
        dense
    }
}
