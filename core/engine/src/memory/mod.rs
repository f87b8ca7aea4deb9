//! How much memory a session may take, and how much it needs, told before anything large is allocated.
//!
//! Sizes come from the scene and its models: a small file can ask for any amount. So each body is estimated from the counts that are known
//! before its storage is made (bytes of the file, triangles, occupied cells), and a session whose sum exceeds the budget is refused with
//! the body, the estimate and what would fit. A test measures the estimates against the memory of real runs.

mod account;
mod budget;
mod estimate;
mod size;

pub(crate) use account::MemoryAccount;
pub use budget::MemoryBudget;
pub use estimate::BodyMemory;
pub(crate) use estimate::total;
pub(crate) use estimate::{
    CellCosts, TETRAHEDRA_OF_CUBE, document_bytes, file_bytes, grid_bytes, sample_bytes, shape_bytes, sheet_bytes,
    tetrahedra_bytes,
};
pub use size::{format_bytes, parse_bytes};
