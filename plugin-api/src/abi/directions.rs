//! `pliant.directions/1`: fibre directions of elements, for solids that are not the same in all directions.

use super::{Batch, Plugin, Status};
use core::ffi::CStr;

/// Flag of a tetrahedron request: fibre directions, by [`Directions`]. A host that does not know the flag calls `rest` of
/// [`super::Material`], without directions.
pub const WANTS_DIRECTIONS: u32 = 512;

/// Extension id of [`Directions`]; optional.
pub const DIRECTIONS: &CStr = c"pliant.directions/1";

/// Function table of [`DIRECTIONS`].
#[repr(C)]
pub struct Directions {
    /// `size_of` this struct.
    pub size: usize,
    /// Writes rest data, plane-major, in place of `rest` of [`super::Material`]. `directions` (m x 3) holds the unit vector along the fibres of
    /// each element in the axes of the shape at rest, or zeros for an element without fibres; its sign has no meaning.
    pub rest: Option<
        unsafe extern "C" fn(*const Plugin, *const Batch, directions: *const f64, rest_data: *mut f64) -> Status,
    >,
}
