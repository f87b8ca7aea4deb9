//! Safe views of one call of a material: the elements it is about, and where their results go.
//!
//! A call sees a range of elements. Another thread may be running another range of the same instance, so the views that
//! can be written to cover only the nodes and blocks of this range; the host sees to it that ranges which run together
//! share neither.

use crate::abi;
use core::marker::PhantomData;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// The elements of one call, of one kind.
pub struct Elements<'a>(pub(crate) &'a abi::Batch);

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> Elements<'a> {
    /// [`abi::POINT`], [`abi::LINK`], ...
    pub fn kind(&self) -> u32 {
        self.0.kind
    }

    /// Elements in this call.
    pub fn len(&self) -> usize {
        self.0.end - self.0.begin
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of this call's first element among all of its kind, for messages.
    pub fn first(&self) -> usize {
        self.0.begin
    }

    /// Nodes of the whole body.
    pub fn nodes(&self) -> usize {
        self.0.nodes
    }

    /// s, of the state this call is about, and of the step it belongs to.
    pub fn time(&self) -> (f64, f64) {
        (self.0.time, self.0.dt)
    }

    fn range<T>(&self, ptr: *const T) -> &'a [T] {
        if ptr.is_null() || self.is_empty() {
            return &[];
        }
        // SAFETY: the host gives `count` elements behind every non-null pointer of the batch, and `end <= count`.
        unsafe { from_raw_parts(ptr.add(self.0.begin), self.len()) }
    }

    fn points(&self, ptr: *const f64) -> &'a [[f64; 3]] {
        if ptr.is_null() || self.0.nodes == 0 {
            return &[];
        }
        // SAFETY: the host gives `nodes` points of three doubles behind rest, x and v; `[f64; 3]` has their layout.
        unsafe { from_raw_parts(ptr.cast(), self.0.nodes) }
    }

    /// Nodes of each element (range x K). Empty if `K` is not the number of corners of this kind.
    pub fn corners<const K: usize>(&self) -> &'a [[u32; K]] {
        if K == self.0.corners as usize { self.range(self.0.elements.cast()) } else { &[] }
    }

    /// Family of each link (range); empty for other kinds.
    pub fn family(&self) -> &'a [u32] {
        self.range(self.0.family)
    }

    /// Measure of each element (range); its unit depends on the kind, see the header.
    pub fn measure(&self) -> &'a [f64] {
        self.range(self.0.measure)
    }

    /// Material coordinates of each corner, m (range x K x 2); empty for all but triangles.
    pub fn material<const K: usize>(&self) -> &'a [[[f64; 2]; K]] {
        if K == self.0.corners as usize { self.range(self.0.material.cast()) } else { &[] }
    }

    /// Rest positions of all nodes, m (n x 3).
    pub fn rest(&self) -> &'a [[f64; 3]] {
        self.points(self.0.rest)
    }

    /// Positions of all nodes, m (n x 3).
    pub fn x(&self) -> &'a [[f64; 3]] {
        self.points(self.0.x)
    }

    /// Velocities of all nodes, m/s (n x 3).
    pub fn v(&self) -> &'a [[f64; 3]] {
        self.points(self.0.v)
    }

    fn plane(&self, ptr: *const f64, plane: usize) -> &'a [f64] {
        if ptr.is_null() {
            return &[];
        }
        // SAFETY: planes of `count` doubles follow each other, as many as the stride the material asked for; a plane past
        // the stride is an error of the author that the conformance suite finds with guard pages of NaN.
        self.range(unsafe { ptr.add(plane * self.0.count) })
    }

    /// Plane `s` of the rest data this material wrote (range).
    pub fn rest_data(&self, s: usize) -> &'a [f64] {
        self.plane(self.0.rest_data, s)
    }

    /// Plane `s` of the history (range).
    pub fn history(&self, s: usize) -> &'a [f64] {
        self.plane(self.0.history, s)
    }
}

/// Planes of rest data or history, to be written for the elements of this call.
pub struct Planes<'a> {
    ptr: *mut f64,
    begin: usize,
    len: usize,
    count: usize,
    borrowed: PhantomData<&'a mut [f64]>,
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> Planes<'a> {
    pub(crate) fn new(batch: &abi::Batch, ptr: *mut f64) -> Self {
        let (begin, len, count) = (batch.begin, batch.end - batch.begin, batch.count);
        Self { ptr, begin, len, count, borrowed: PhantomData }
    }

    /// The first `N` planes (range each). `N` must not exceed the stride asked for.
    pub fn first<const N: usize>(&mut self) -> [&mut [f64]; N] {
        core::array::from_fn(|s| {
            if self.ptr.is_null() || self.len == 0 {
                return <&mut [f64]>::default();
            }
            // SAFETY: plane s starts at s * count; the ranges of two planes, and of two calls, do not overlap.
            unsafe { from_raw_parts_mut(self.ptr.add(s * self.count + self.begin), self.len) }
        })
    }
}

/// Where vectors on nodes go: forces, N, or products. Covers the nodes of this call's elements.
pub struct NodeVectors<'a> {
    first: usize,
    window: &'a mut [[f64; 3]],
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> NodeVectors<'a> {
    pub(crate) fn new(batch: &'a abi::Batch, ptr: *mut f64) -> Self {
        let (first, len) = (batch.node_begin, batch.node_end - batch.node_begin);
        let window = if ptr.is_null() || len == 0 {
            <&mut [[f64; 3]]>::default()
        } else {
            // SAFETY: the host gives node_end points behind `ptr`, of which this call alone uses [node_begin, node_end).
            unsafe { from_raw_parts_mut(ptr.wrapping_add(3 * first).cast(), len) }
        };
        Self { first, window }
    }

    /// Adds to one node.
    #[inline]
    pub fn add(&mut self, node: u32, value: [f64; 3]) {
        let at = &mut self.window[node as usize - self.first];
        for i in 0..3 {
            at[i] += value[i];
        }
    }

    /// The first node of the window, and the window itself (len x 3), for loops that know what they do.
    pub fn window(&mut self) -> (usize, &mut [[f64; 3]]) {
        (self.first, self.window)
    }
}

/// Where scalars on nodes go: masses, kg.
pub struct NodeScalars<'a> {
    first: usize,
    window: &'a mut [f64],
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> NodeScalars<'a> {
    pub(crate) fn new(batch: &'a abi::Batch, ptr: *mut f64) -> Self {
        let (first, len) = (batch.node_begin, batch.node_end - batch.node_begin);
        let window = if ptr.is_null() || len == 0 {
            <&mut [f64]>::default()
        } else {
            // SAFETY: as for `NodeVectors`.
            unsafe { from_raw_parts_mut(ptr.wrapping_add(first), len) }
        };
        Self { first, window }
    }

    /// Adds to one node.
    #[inline]
    pub fn add(&mut self, node: u32, value: f64) {
        self.window[node as usize - self.first] += value;
    }
}
