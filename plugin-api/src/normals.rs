//! Safe views for an energy of vertex normals: the normals of a call, and the destination of its forces and derivatives.

use crate::abi;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// Unit normals of all nodes (n x 3), empty where `ptr` is null.
///
/// # Safety
/// `ptr` is null, or has three doubles for each node of the batch behind it that nobody writes to during the call.
#[allow(unsafe_code, reason = "turns the host's span into a slice")]
pub(crate) unsafe fn unit_normals(batch: &abi::Batch, ptr: *const f64) -> &[[f64; 3]] {
    if ptr.is_null() || batch.nodes == 0 {
        return &[];
    }
    // SAFETY: promised by the caller; `[f64; 3]` has the layout of three doubles.
    unsafe { from_raw_parts(ptr.cast(), batch.nodes) }
}

/// Destination of forces at fixed normals, N, and of derivatives by the normals, J. Covers the nodes of this call's elements.
pub struct NormalForces<'a> {
    first_node: usize,
    /// Per node: force, then derivative by the normal.
    values: &'a mut [[f64; 6]],
}

#[allow(unsafe_code, reason = "turns the host's span into a slice")]
impl<'a> NormalForces<'a> {
    pub(crate) fn new(batch: &'a abi::Batch, ptr: *mut f64) -> Self {
        let (first_node, len) = (batch.node_begin, batch.node_end - batch.node_begin);
        let values = if ptr.is_null() || len == 0 {
            <&mut [[f64; 6]]>::default()
        } else {
            // SAFETY: the host gives node_end times six doubles behind `ptr`, of which this call alone uses
            // [node_begin, node_end).
            unsafe { from_raw_parts_mut(ptr.wrapping_add(6 * first_node).cast(), len) }
        };
        Self { first_node, values }
    }

    /// Adds -dE/dx at fixed normals, N, and dE/dn, J, to `node`.
    ///
    /// # Panics
    /// If the node is not one of this call.
    #[inline]
    pub fn add(&mut self, node: u32, force: [f64; 3], normal_derivative: [f64; 3]) {
        let sum = &mut self.values[node as usize - self.first_node];
        for i in 0..3 {
            sum[i] += force[i];
            sum[3 + i] += normal_derivative[i];
        }
    }
}
