//! Safe views of one call of a material: the elements of the call, and the destinations of its results.
//!
//! A call covers a range of elements. Another thread may run another range of the same instance, so a destination covers only the
//! nodes and elements of its own range; the host runs two ranges at once only where these do not overlap.

use crate::abi;
use crate::material::ElementRequest;
use crate::param::{Param, field_position};
use core::marker::PhantomData;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// The elements of one call, all of one kind.
///
/// "Range" in the shapes below is the number of elements of the call, n the number of nodes of the body.
pub struct Elements<'a>(
    pub(crate) &'a abi::Batch,
    pub(crate) Strides,
    pub(crate) &'static [Param],
    /// Fibre directions of all elements of the kind (count x 3), or null.
    pub(crate) *const f64,
);

/// Factors of a parameter that may vary per element.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a>(&'a [f64]);

impl Field<'_> {
    /// The factor of element `e` of the call, above 0; 1 where the scene gives no field.
    ///
    /// # Panics
    /// If the scene gives a field and the call has no element `e`.
    #[inline(always)]
    pub fn factor(&self, e: usize) -> f64 {
        if self.0.is_empty() { 1.0 } else { self.0[e] }
    }
}

/// Number of planes of each kind of data that the host keeps for the elements of a call.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Strides {
    /// Planes of rest data.
    pub(crate) rest: usize,
    /// Planes of history.
    pub(crate) history: usize,
}

impl Strides {
    /// The planes of elements of `kind`; where several requests have that kind, what all of them have.
    pub(crate) fn of(requests: &[ElementRequest], kind: u32) -> Self {
        let of_kind = || requests.iter().filter(|request| request.kind == kind);
        let least = |strides: Option<u32>| strides.unwrap_or(0) as usize;
        Self {
            rest: least(of_kind().map(|request| request.rest_stride).min()),
            history: least(of_kind().map(|request| request.history_stride).min()),
        }
    }
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> Elements<'a> {
    /// [`abi::POINT`], [`abi::LINK`], ...
    pub fn kind(&self) -> u32 {
        self.0.kind
    }

    /// Number of elements in this call.
    pub fn len(&self) -> usize {
        self.0.end - self.0.begin
    }

    /// Whether the call has no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of this call's first element among all of its kind in the body, for messages.
    pub fn first_index(&self) -> usize {
        self.0.begin
    }

    /// Number of nodes of the body.
    pub fn node_count(&self) -> usize {
        self.0.nodes
    }

    /// Time of the state, s.
    pub fn time(&self) -> f64 {
        self.0.time
    }

    /// Length of the step the call belongs to, s.
    pub fn dt(&self) -> f64 {
        self.0.dt
    }

    /// The values of this call's elements in an array of all elements, empty where `ptr` is null.
    fn range<T>(&self, ptr: *const T) -> &'a [T] {
        if ptr.is_null() || self.is_empty() {
            return &[];
        }
        // SAFETY: the host gives `count` elements behind every non-null pointer of the batch, and `end <= count`.
        unsafe { from_raw_parts(ptr.add(self.0.begin), self.len()) }
    }

    /// An array of vectors on all nodes, empty where `ptr` is null.
    fn node_vectors(&self, ptr: *const f64) -> &'a [[f64; 3]] {
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

    /// Family of each link (range): [`abi::STRUCTURAL`], [`abi::SHEAR`], ...; empty for other kinds.
    pub fn family(&self) -> &'a [u32] {
        self.range(self.0.family)
    }

    /// Measure of each element (range), in the unit of its kind: see [`abi::POINT`], [`abi::LINK`], ...
    pub fn measure(&self) -> &'a [f64] {
        self.range(self.0.measure)
    }

    /// Material coordinates of each corner, m (range x K x 2); empty for all kinds but triangles.
    pub fn material_coordinates<const K: usize>(&self) -> &'a [[[f64; 2]; K]] {
        if K == self.0.corners as usize { self.range(self.0.material.cast()) } else { &[] }
    }

    /// Rest positions of all nodes, m (n x 3).
    pub fn rest(&self) -> &'a [[f64; 3]] {
        self.node_vectors(self.0.rest)
    }

    /// Positions of all nodes, m (n x 3).
    pub fn x(&self) -> &'a [[f64; 3]] {
        self.node_vectors(self.0.x)
    }

    /// Velocities of all nodes, m/s (n x 3).
    pub fn v(&self) -> &'a [[f64; 3]] {
        self.node_vectors(self.0.v)
    }

    /// Plane number `plane` of plane-major data (range), empty where `ptr` is null.
    ///
    /// # Panics
    /// If the material has asked for no such plane.
    fn plane(&self, ptr: *const f64, plane: usize, planes: usize) -> &'a [f64] {
        if ptr.is_null() {
            return &[];
        }
        assert!(
            plane < planes,
            "plane {plane} of {planes}: the stride in `elements` is the number of planes there are"
        );
        // SAFETY: planes of `count` doubles follow each other, as many as the stride the material asked for.
        self.range(unsafe { ptr.add(plane * self.0.count) })
    }

    /// Plane `s` of the rest data this material wrote (range).
    ///
    /// # Panics
    /// If `s` is not below the stride the material asked for; of several requests for one kind of element, below the least.
    pub fn rest_data(&self, s: usize) -> &'a [f64] {
        self.plane(self.0.rest_data, s, self.1.rest)
    }

    /// Factors of the parameter `key`, by which its number is to be multiplied in each element.
    ///
    /// # Panics
    /// If the material has not declared `key` with [`Param::field`].
    pub fn field(&self, key: &str) -> Field<'a> {
        let Some(plane) = field_position(self.2, key) else { panic!("parameter `{key}` is not declared as a field") };
        // A host of interface 1.0 gives no fields: its batch is smaller.
        if self.0.size < size_of::<abi::Batch>() || plane >= self.0.field_count {
            return Field(&[]);
        }
        Field(self.plane(self.0.fields, plane, self.0.field_count))
    }

    /// The unit vector along the fibres of element `e` of the call, in the axes of the shape at rest; zero for an element without fibres, and
    /// for all where the scene gives none or the host knows of no directions. Its sign has no meaning. For requests with [`abi::WANTS_DIRECTIONS`],
    /// in [`Material::rest`](crate::Material::rest) alone: what other calls need of it belongs in the rest data.
    ///
    /// # Panics
    /// If there are directions and the call has no element `e`.
    pub fn direction(&self, e: usize) -> [f64; 3] {
        let all: &[[f64; 3]] = self.range(self.3.cast());
        if all.is_empty() { [0.0; 3] } else { all[e] }
    }

    /// Plane `s` of the history (range).
    ///
    /// # Panics
    /// As for [`Elements::rest_data`].
    pub fn history(&self, s: usize) -> &'a [f64] {
        self.plane(self.0.history, s, self.1.history)
    }
}

/// Destination of per-element data, plane-major (rest data, history, strains), for the elements of this call.
pub struct Planes<'a> {
    ptr: *mut f64,
    begin: usize,
    len: usize,
    /// Elements of this kind in the body: the distance of two planes.
    count: usize,
    /// Number of planes.
    planes: usize,
    borrowed: PhantomData<&'a mut [f64]>,
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> Planes<'a> {
    pub(crate) fn new(batch: &abi::Batch, ptr: *mut f64, planes: usize) -> Self {
        let (begin, len, count) = (batch.begin, batch.end - batch.begin, batch.count);
        Self { ptr, begin, len, count, planes, borrowed: PhantomData }
    }

    /// The first `N` planes (N x range).
    ///
    /// # Panics
    /// If there are fewer: of rest data and history there are as many as the stride the material asked for (of several requests for one
    /// kind of element, the least), of strains 13, of compliances 6, of tilts 3.
    pub fn first_planes<const N: usize>(&mut self) -> [&mut [f64]; N] {
        let planes = self.planes;
        assert!(N <= planes, "{N} of {planes} planes: the stride in `elements` is the number of planes there are");
        core::array::from_fn(|s| {
            if self.ptr.is_null() || self.len == 0 {
                return <&mut [f64]>::default();
            }
            // SAFETY: plane s starts at s * count; the ranges of two planes, and of two calls, do not overlap.
            unsafe { from_raw_parts_mut(self.ptr.add(s * self.count + self.begin), self.len) }
        })
    }
}

/// Destination of vectors on nodes (forces, N). Covers the nodes of this call's elements.
pub struct NodeVectors<'a> {
    window: NodeWindow<'a>,
}

/// Vectors on consecutive nodes, for loops that index them directly.
pub struct NodeWindow<'a> {
    /// The node of `values[0]`.
    pub first_node: usize,
    /// One vector per node (len x 3).
    pub values: &'a mut [[f64; 3]],
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> NodeVectors<'a> {
    pub(crate) fn new(batch: &'a abi::Batch, ptr: *mut f64) -> Self {
        let (first_node, len) = (batch.node_begin, batch.node_end - batch.node_begin);
        let values = if ptr.is_null() || len == 0 {
            <&mut [[f64; 3]]>::default()
        } else {
            // SAFETY: the host gives node_end points behind `ptr`, of which this call alone uses [node_begin, node_end).
            unsafe { from_raw_parts_mut(ptr.wrapping_add(3 * first_node).cast(), len) }
        };
        Self { window: NodeWindow { first_node, values } }
    }

    /// Adds `value` to the vector of `node`.
    ///
    /// # Panics
    /// If the node is not one of this call.
    #[inline]
    pub fn add(&mut self, node: u32, value: [f64; 3]) {
        let sum = &mut self.window.values[node as usize - self.window.first_node];
        for i in 0..3 {
            sum[i] += value[i];
        }
    }

    /// The vectors of all nodes of this call.
    pub fn window(&mut self) -> NodeWindow<'_> {
        NodeWindow { first_node: self.window.first_node, values: self.window.values }
    }
}

/// Destination of scalars on nodes (masses, kg). Covers the nodes of this call's elements.
pub struct NodeScalars<'a> {
    first_node: usize,
    values: &'a mut [f64],
}

#[allow(unsafe_code, reason = "turns the host's spans into slices")]
impl<'a> NodeScalars<'a> {
    pub(crate) fn new(batch: &'a abi::Batch, ptr: *mut f64) -> Self {
        let (first_node, len) = (batch.node_begin, batch.node_end - batch.node_begin);
        let values = if ptr.is_null() || len == 0 {
            <&mut [f64]>::default()
        } else {
            // SAFETY: as for `NodeVectors`.
            unsafe { from_raw_parts_mut(ptr.wrapping_add(first_node), len) }
        };
        Self { first_node, values }
    }

    /// Adds `value` to the scalar of `node`.
    ///
    /// # Panics
    /// If the node is not one of this call.
    #[inline]
    pub fn add(&mut self, node: u32, value: f64) {
        self.values[node as usize - self.first_node] += value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::{Body, ElementList};
    use crate::{Fault, Info, Material, NodeScalars, Params, TangentScale};
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// Points with four planes of rest data and two of history.
    struct Points;

    impl Material for Points {
        const INFO: Info = Info { id: c"points", name: c"Points", version: c"1", summary: c"", params: &[] };

        fn new(_: &Params<'_>) -> Result<Self, Fault> {
            Ok(Self)
        }

        fn elements(&self) -> Vec<ElementRequest> {
            let flags = abi::HAS_MASS | abi::HAS_FORCES;
            vec![ElementRequest { kind: abi::POINT, families: 0, flags, rest_stride: 4, history_stride: 2 }]
        }

        fn rest(&self, _: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
            let panics = |call: &mut dyn FnMut()| catch_unwind(AssertUnwindSafe(call)).is_err();
            assert!(panics(&mut || _ = out.first_planes::<5>()) && panics(&mut || _ = out.first_planes::<40>()));
            let planes = out.first_planes::<4>();
            planes.into_iter().zip(1..).for_each(|(plane, value)| plane.fill(f64::from(value)));
            Ok(())
        }

        fn mass(&self, _: &Elements<'_>, _: &mut NodeScalars<'_>) -> Result<(), Fault> {
            Ok(())
        }

        fn energy(&self, _: &Elements<'_>) -> Result<f64, Fault> {
            Ok(0.0)
        }

        fn forces(&self, elements: &Elements<'_>, _: &mut NodeVectors<'_>) -> Result<(), Fault> {
            assert!((0..4).all(|s| elements.rest_data(s) == vec![s as f64 + 1.0; 3]));
            assert!((0..2).all(|s| elements.history(s).len() == 3));
            let panics = |read: &dyn Fn() -> usize| catch_unwind(AssertUnwindSafe(read)).is_err();
            assert!([4, 30, usize::MAX].into_iter().all(|s| panics(&|| elements.rest_data(s).len())));
            assert!([2, 30, usize::MAX].into_iter().all(|s| panics(&|| elements.history(s).len())));
            Ok(())
        }

        fn tangent(&self, _: &Elements<'_>, _: TangentScale, _: &mut crate::Blocks<'_>) -> Result<(), Fault> {
            Ok(())
        }
    }

    #[test]
    fn a_plane_that_was_not_asked_for_is_refused() {
        let nodes = ElementList { nodes: vec![0, 1, 2], ..ElementList::default() };
        let body = Body::new(&Points, vec![[0.0; 3]; 3], |_| nodes.clone()).expect("no fault");
        body.forces(&Points).expect("no fault");
    }

    #[test]
    fn several_requests_for_a_kind_have_the_planes_they_share() {
        let request =
            |kind, rest_stride| ElementRequest { kind, families: 1, flags: 0, rest_stride, history_stride: 1 };
        let requests = [request(abi::LINK, 5), request(abi::LINK, 3), request(abi::POINT, 1)];
        assert_eq!(Strides::of(&requests, abi::LINK).rest, 3);
        assert_eq!((Strides::of(&requests, abi::POINT).rest, Strides::of(&requests, abi::HINGE).rest), (1, 0));
    }
}
