//! Content-addressed store of meshes: equal meshes are one file.

use crate::error::BatchError;
use pliant_engine::body::Body;
use pliant_record::{AtomicFile, hash_bytes, remove_leftovers, write_model_to};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder `meshes` of a batch. A mesh is the file `AB/ABCDEF...obj`, named by the first 128 bits of the BLAKE3 digest of its bytes, in one of
/// 256 folders.
pub(crate) struct MeshStore {
    /// Path of the folder.
    folder: PathBuf,
}

impl MeshStore {
    /// The meshes of the batch in `folder`.
    pub(crate) fn new(folder: &Path) -> Self {
        Self { folder: folder.join("meshes") }
    }

    /// Removes incomplete files of killed processes.
    pub(crate) fn remove_leftovers(&self) {
        for entry in self.folder.read_dir().into_iter().flatten().flatten() {
            remove_leftovers(&entry.path());
        }
    }

    /// Stores the deformed mesh of a body and returns its address. The file is flushed to the disk.
    ///
    /// # Errors
    /// The error of the file system, with the path.
    pub(crate) fn put(&self, body: &Body, cap_material: &str) -> Result<String, BatchError> {
        let mut bytes = Vec::new();
        write_model_to(body, cap_material, &mut bytes).map_err(BatchError::at(&self.folder))?;
        let address = hash_bytes(&bytes)[..32].to_owned();
        let path = self.folder.join(&address[..2]).join(format!("{address}.obj"));
        if !path.is_file() {
            // These errors have the path already.
            let io = |source| BatchError::io(&self.folder, source);
            let mut file = AtomicFile::create(&path).map_err(io)?;
            file.write_all(&bytes).map_err(BatchError::at(&path))?;
            file.finish().map_err(io)?;
        }
        Ok(address)
    }
}
