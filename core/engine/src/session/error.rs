//! Errors of opening a scene.

use crate::body::LatticeError;
use crate::scene::SceneError;
use pliant_host::HostError;
use pliant_mesh::{MeshError, ObjError, TetMeshError};
use pliant_solver::ForceError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a scene cannot be opened.
#[derive(Debug, Error)]
pub enum SessionError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A model cannot be read.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// A tetrahedral mesh cannot be read.
    #[error(transparent)]
    Tetrahedra(#[from] TetMeshError),
    /// A model cannot be used.
    #[error("{}: body `{body}`: {error}", file.display())]
    Mesh {
        /// Path of the model.
        file: PathBuf,
        /// Name of the body.
        body: String,
        /// What is wrong with the model.
        error: Box<MeshError>,
    },
    /// A body needs more memory than the session may take.
    #[error(transparent)]
    Memory(SceneError),
    /// A plugin cannot be used.
    #[error(transparent)]
    Host(#[from] HostError),
    /// A material failed.
    #[error(transparent)]
    Force(#[from] ForceError),
    /// A body cannot be embedded.
    #[error("body `{body}`: {error}")]
    Lattice {
        /// Name of the body.
        body: String,
        /// Why it cannot be embedded.
        error: LatticeError,
    },
    /// An explicit integrator would be unstable.
    #[error("{0}")]
    StepLimit(String),
    /// `$PLIANT_VECTOR_UNIT` names no vector unit of this processor.
    #[error("{0}")]
    VectorUnit(String),
}

impl SessionError {
    /// Whether a plugin or device failed, rather than the input.
    pub fn is_plugin(&self) -> bool {
        match self {
            Self::Host(error) | Self::Lattice { error: LatticeError::Host(error), .. } => !error.is_refusal(),
            Self::Force(_) | Self::Lattice { error: LatticeError::Massless { .. } | LatticeError::Force(_), .. } => {
                true
            }
            Self::Lattice { error: LatticeError::ContactLaw { error, .. }, .. } => !error.is_refusal(),
            Self::Lattice {
                error: LatticeError::Unsupported { .. } | LatticeError::Memory { .. } | LatticeError::Empty { .. },
                ..
            }
            | Self::Scene(_)
            | Self::Obj(_)
            | Self::Tetrahedra(_)
            | Self::Mesh { .. }
            | Self::Memory(_)
            | Self::StepLimit(_)
            | Self::VectorUnit(_) => false,
        }
    }
}
