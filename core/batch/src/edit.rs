//! One edit of a sweep, and the scene it stands for.

use crate::key::{EditKey, KeyMaker};
use crate::sweep::Sweep;
use pliant_engine::scene::{Scene, SceneError, Source, load_text};
use serde_json::Value;
use std::path::PathBuf;

/// One edit of a sweep.
#[derive(Clone, Debug)]
pub struct Edit {
    /// Place in the sweep, from 0.
    pub place: u64,
    /// Place of its base scene among those of the sweep.
    pub(crate) scene: usize,
    /// Model in the place of the first body's.
    pub model: Option<PathBuf>,
    /// Paths in the scene and their values, TOML.
    pub settings: Vec<(String, String)>,
    /// Cells of the scene, the model and the parameters.
    pub cells: Vec<Value>,
    /// Number of the repetition, where nothing in the scene tells repetitions apart.
    pub(crate) repeat: Option<u64>,
}

/// An edit with its scene read.
pub struct Resolved {
    /// The edit.
    pub edit: Edit,
    /// What it is known by.
    pub key: EditKey,
    /// Its scene, or why there is none.
    pub scene: Result<(Scene, Source), SceneError>,
}

impl Resolved {
    /// Reads the scene of the edit at a place and makes its key.
    pub(crate) fn new(sweep: &Sweep, place: u64, keys: &KeyMaker) -> Self {
        let edit = sweep.edit(place);
        let base = sweep.base(&edit);
        let scene = load_text(&base.path, base.text.clone(), &edit.settings);
        let key = keys.key(&edit, base, scene.as_ref().ok());
        Self { edit, key, scene }
    }
}
