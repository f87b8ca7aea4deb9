//! Keys of runs: digests of everything on which a result depends.

use crate::edit::Edit;
use crate::sweep::BaseScene;
use pliant_engine::scene::{Scene, Source};
use pliant_host::SearchPath;
use pliant_record::{ContentHasher, hash_file};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Digest of a run's resolved scene, the bytes of its meshes, plugins and parameter files, and the program's version: the first 128 bits of
/// BLAKE3, in hexadecimal. Runs with equal keys have equal results.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct EditKey(String);

impl fmt::Display for EditKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Computes keys; reads each file once.
pub(crate) struct KeyMaker {
    /// Program and version.
    program: String,
    /// Folders in which plugins are searched.
    search: SearchPath,
    /// Digest of each file, or the kind of the error of reading it.
    files: Mutex<HashMap<PathBuf, String>>,
}

impl KeyMaker {
    /// Computes keys of results of `program` with plugins in `search`.
    pub(crate) fn new(program: &str, search: &SearchPath) -> Self {
        Self { program: program.to_owned(), search: search.clone(), files: Mutex::default() }
    }

    /// The key of a run; `scene` is `None` if the run's scene is invalid.
    pub(crate) fn key(&self, edit: &Edit, base: &BaseScene, scene: Option<&(Scene, Source)>) -> EditKey {
        let mut digest = ContentHasher::default();
        digest.add("pliant edit 1");
        digest.add(&self.program);
        digest.add(&edit.repeat.map(|repeat| repeat.to_string()).unwrap_or_default());
        match scene {
            // The table with sorted keys: comments and spaces in the text do not matter.
            Some((_, source)) => digest.add(&source.text.parse::<toml::Table>().unwrap_or_default().to_string()),
            None => {
                digest.add(&base.text);
                edit.settings.iter().for_each(|(path, value)| digest.add(&format!("{path}={value}")));
            }
        }
        if let Some(model) = &edit.model {
            digest.add(&self.file(model));
        }
        if let Some((scene, source)) = scene {
            self.add_files(scene, source, &mut digest);
        }
        EditKey(digest.finish()[..32].to_owned())
    }

    /// Adds the files that a scene names: meshes, recordings, plugins, and parameters that are paths.
    fn add_files(&self, scene: &Scene, source: &Source, digest: &mut ContentHasher) {
        let folder = source.folder();
        let mut plugins = Vec::new();
        let mut params = Vec::new();
        for body in &scene.body {
            if let Some(mesh) = &body.mesh {
                digest.add(&self.file(&folder.join(mesh.get_ref())));
            }
            plugins.push(body.material.plugin.get_ref());
            params.push(&body.material.params);
            if !body.has_own_mesh() {
                plugins.push(body.grid.get_ref().plugin.get_ref());
                params.push(&body.grid.get_ref().params);
            }
        }
        for mesh in scene.obstacle.iter().filter_map(|obstacle| obstacle.mesh.as_ref()) {
            digest.add(&self.file(&folder.join(mesh.get_ref())));
        }
        for device in &scene.device {
            match &device.recording {
                Some(recording) => digest.add(&self.file(&folder.join(recording.get_ref()))),
                None => plugins.push(device.plugin.get_ref()),
            }
            params.push(&device.params);
        }
        for plugin in plugins {
            let file = plugin.split_once('#').map_or(plugin.as_str(), |(file, _)| file);
            match self.search.find(file, folder) {
                Ok(found) => digest.add(&self.file(&found.path)),
                Err(_) => digest.add("no such plugin"),
            }
        }
        for value in params.into_iter().flat_map(|params| params.values()) {
            // Types of parameters are known to the plugin alone; a text that names an existing file counts as a path.
            let path = value.get_ref().as_str().filter(|text| !text.is_empty()).map(|text| folder.join(text));
            if let Some(path) = path.filter(|path| path.is_file()) {
                digest.add(&self.file(&path));
            }
        }
    }

    /// Digest of a file, or the kind of the error of reading it.
    fn file(&self, path: &Path) -> String {
        let mut files = self.files.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let of_file = || hash_file(path).unwrap_or_else(|error| format!("unreadable: {:?}", error.kind()));
        files.entry(path.to_path_buf()).or_insert_with(of_file).clone()
    }
}
