//! Runs of a sweep, and their scenes.

use crate::key::{EditKey, KeyMaker};
use crate::sweep::Sweep;
use pliant_engine::scene::{Scene, SceneError, Source, load_text};
use serde_json::Value;
use std::path::PathBuf;

/// One run of a sweep: a base scene with a model and settings of its own.
#[derive(Clone, Debug)]
pub struct Edit {
    /// Index in the sweep, from 0.
    pub index: u64,
    /// Index of its base scene in the sweep.
    pub(crate) scene: usize,
    /// Model that replaces the first body's.
    pub model: Option<PathBuf>,
    /// Settings: paths in the scene and their values as TOML.
    pub settings: Vec<(String, String)>,
    /// Cells of the table for the scene, the model and the parameters.
    pub cells: Vec<Value>,
    /// Number of the repetition if repetitions have equal scenes, else `None`.
    pub(crate) repeat: Option<u64>,
}

/// A run with its scene read.
pub struct Resolved {
    /// The run as the sweep lists it, with its parameters.
    pub edit: Edit,
    /// Digest that identifies the run.
    pub key: EditKey,
    /// Its scene, or the error of reading it.
    pub scene: Result<(Scene, Source), SceneError>,
}

impl Resolved {
    /// Reads the scene of run `index` and computes its key.
    pub(crate) fn new(sweep: &Sweep, index: u64, keys: &KeyMaker) -> Self {
        let edit = sweep.edit(index);
        let base = sweep.base(&edit);
        let scene = load_text(&base.path, base.text.clone(), &edit.settings);
        let key = keys.key(&edit, base, scene.as_ref().ok());
        Self { edit, key, scene }
    }
}
