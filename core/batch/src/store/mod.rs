//! Files of a batch: a journal and a table for each shard, and the store of meshes.

pub(crate) mod journal;
mod mesh_store;
mod records;
mod shard_files;
mod state;

pub(crate) use mesh_store::MeshStore;
pub(crate) use records::{OpenRecord, RowRecord};
pub(crate) use shard_files::{NewRow, ShardFiles, Syncer, journals};
pub(crate) use state::{ShardState, read_state, row_bytes};
