//! Sweeps: base scenes, models and axes; results that are kept, and limits.

mod axis;
mod columns;
mod file;
mod keep;
mod quantity;
mod random;

pub use keep::{Keep, Limits};

use crate::column::Column;
use crate::edit::Edit;
use crate::error::BatchError;
use axis::Axis;
use file::SweepFile;
use pliant_engine::scene::{SceneError, Source};
use pliant_mesh::read::read_text;
use pliant_record::ContentHasher;
use serde_json::Value as Cell;
use std::path::{Path, PathBuf};

/// The version of the sweep format that this program reads.
const FORMAT: u32 = 1;
/// Largest number of runs of a sweep: indices are exact in every table format.
const MAX_EDITS: u64 = 1 << 40;

/// A base scene.
#[derive(Clone, Debug)]
pub(crate) struct BaseScene {
    /// Path of the scene.
    pub(crate) path: PathBuf,
    /// Path as written in the sweep file.
    pub(crate) name: String,
    /// Text of the scene.
    pub(crate) text: String,
}

/// A model that replaces the first body's.
#[derive(Clone, Debug)]
struct Model {
    /// Path of the file.
    path: PathBuf,
    /// Path relative to the sweep file.
    name: String,
}

/// A parameter sweep: many runs, as combinations of scenes, models and points of axes.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Title, one line.
    pub title: String,
    /// Results of a run that are kept.
    pub keep: Keep,
    /// Limits of a run.
    pub limits: Limits,
    /// Path of the sweep file.
    path: PathBuf,
    /// Base scenes, at least one.
    scenes: Vec<BaseScene>,
    /// Models; empty to use those of the scenes.
    models: Vec<Model>,
    /// Settings of every run: paths in the scene and values as TOML.
    set: Vec<(String, String)>,
    /// Axes; the last one varies fastest.
    axes: Vec<Axis>,
    /// Number of runs.
    edits: u64,
    /// Columns of the table.
    columns: Vec<Column>,
    /// Number of columns before `status`.
    given: usize,
    /// Value of [`Sweep::digest`], computed when the sweep is read.
    digest: String,
}

impl Sweep {
    /// Reads a sweep file and its base scenes.
    ///
    /// # Errors
    /// Fails for a file that cannot be read and for an invalid sweep or scene, with the line.
    pub fn read(path: &Path) -> Result<Self, BatchError> {
        let text = read_text(path).map_err(BatchError::at(path))?;
        Self::parse(path, text)
    }

    /// Parses a sweep from `text`; relative paths in it are relative to the folder of `path`.
    ///
    /// # Errors
    /// As for [`Sweep::read`].
    pub fn parse(path: &Path, text: String) -> Result<Self, BatchError> {
        let source = Source::new(path, text);
        let file: SweepFile = toml::from_str(&source.text)
            .map_err(|e| source.error(e.span().unwrap_or(0..0), e.message().trim().replace('\n', " ")))?;
        if *file.format.get_ref() != FORMAT {
            let text = format!("format {}; allowed is {FORMAT}, the one this program reads", file.format.get_ref());
            return Err(source.error(file.format.span(), text).into());
        }
        let scenes = base_scenes(&file, &source)?;
        let models = models(&file, &source)?;
        let axes = file.axis.iter().map(|axis| Axis::from_file(axis, &source)).collect::<Result<Vec<_>, _>>()?;
        let edits = product(scenes.len(), models.len().max(1), &axes)
            .ok_or_else(|| source.whole(format!("more than {MAX_EDITS} runs; allowed is fewer")))?;
        let set = file.set.iter().map(|(path, value)| (path.clone(), value.to_string())).collect();
        let mut sweep = Self {
            title: file.title.clone(),
            keep: Keep::from_file(&file.keep, &source)?,
            limits: Limits::from_file(&file.limits, &source)?,
            path: path.to_path_buf(),
            digest: digest(&source, &scenes, &models),
            scenes,
            models,
            set,
            axes,
            edits,
            columns: Vec::new(),
            given: 0,
        };
        columns::find(&mut sweep, &source)?;
        Ok(sweep)
    }

    /// Number of runs.
    pub fn edits(&self) -> u64 {
        self.edits
    }

    /// Path of the sweep file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Columns of the table.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Columns of the results of a run, after `status`, `class` and `message`.
    pub(crate) fn result_columns(&self) -> &[Column] {
        &self.columns[self.given + columns::OUTCOME.len()..]
    }

    /// Digest of the sweep file, the base scenes and the list of models, 32 hexadecimal digits; equal for all shards of a sweep.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// The base scene of a run.
    pub(crate) fn base(&self, edit: &Edit) -> &BaseScene {
        &self.scenes[edit.scene]
    }

    /// The run with an index, from 0.
    ///
    /// # Panics
    /// If the index is not below [`Sweep::edits`].
    pub fn edit(&self, index: u64) -> Edit {
        assert!(index < self.edits, "run {index} of {}", self.edits);
        let mut rest = index;
        let mut digit = |count: usize| {
            let digit = rest % count as u64;
            rest /= count as u64;
            digit as usize
        };
        let mut points: Vec<_> = self.axes.iter().rev().map(|axis| &axis.points[digit(axis.points.len())]).collect();
        points.reverse();
        let model = (!self.models.is_empty()).then(|| &self.models[digit(self.models.len())]);
        let scene = digit(self.scenes.len());
        let (mut settings, mut cells) = (self.set.clone(), Vec::new());
        if self.scenes.len() > 1 {
            cells.push(Cell::from(self.scenes[scene].name.as_str()));
        }
        cells.extend(model.map(|model| Cell::from(model.name.as_str())));
        let mut repeat = None;
        for (axis, point) in self.axes.iter().zip(points) {
            for (parameter, value) in axis.parameters.iter().zip(point) {
                cells.push(value.cell.clone());
                match &parameter.path {
                    Some(path) => settings.push((path.clone(), value.setting.clone())),
                    None => repeat = value.cell.as_u64(),
                }
            }
        }
        Edit { index, scene, model: model.map(|model| model.path.clone()), settings, cells, repeat }
    }
}

/// Number of runs; `None` if there are too many.
fn product(scenes: usize, models: usize, axes: &[Axis]) -> Option<u64> {
    let counts = [scenes, models].into_iter().chain(axes.iter().map(|axis| axis.points.len()));
    counts.map(|n| n as u64).try_fold(1_u64, u64::checked_mul).filter(|edits| *edits <= MAX_EDITS)
}

/// Reads the base scenes.
fn base_scenes(file: &SweepFile, source: &Source) -> Result<Vec<BaseScene>, SceneError> {
    let read = |name: &String| {
        let path = source.folder().join(name);
        let text = read_text(&path).map_err(|e| {
            source.error(file.scene.span(), format!("{}: {e}; paths are relative to the sweep file", path.display()))
        })?;
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        Ok(BaseScene { path, name: name.clone(), text })
    };
    let scenes = file.scene.get_ref().all().iter().map(read).collect::<Result<Vec<_>, _>>()?;
    if scenes.is_empty() { Err(source.whole("`scene` is empty; allowed is one file or more")) } else { Ok(scenes) }
}

/// Lists the models, sorted by name within each pattern.
fn models(file: &SweepFile, source: &Source) -> Result<Vec<Model>, SceneError> {
    let mut models: Vec<Model> = Vec::new();
    let Some(patterns) = &file.models else { return Ok(models) };
    for pattern in patterns.get_ref().all() {
        let full = source.folder().join(pattern);
        let error = |text: String| source.error(patterns.span(), text);
        let paths = glob::glob(&full.to_string_lossy()).map_err(|e| error(format!("not a pattern: {e}")))?;
        let before = models.len();
        for path in paths {
            let path = path.map_err(|e| error(e.to_string()))?;
            let name = path.strip_prefix(source.folder()).unwrap_or(&path).display().to_string();
            if models.iter().all(|model| model.path != path) {
                models.push(Model { path, name });
            }
        }
        if models.len() == before {
            return Err(error(format!("no file matches {}; patterns are relative to the sweep file", full.display())));
        }
    }
    Ok(models)
}

/// The digest of a sweep, see [`Sweep::digest`].
fn digest(source: &Source, scenes: &[BaseScene], models: &[Model]) -> String {
    let mut hasher = ContentHasher::default();
    hasher.add(&source.text);
    scenes.iter().for_each(|scene| hasher.add(&scene.text));
    models.iter().for_each(|model| hasher.add(&model.name));
    hasher.finish()[..32].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// A scene with everything a sweep asks for, and no file.
    pub(crate) const SCENE: &str = "format = 1\n[[body]]\nname = 'b'\nshape = { kind = 'box', cells = 2, size = ['1 cm', '1 cm', '1 cm'] }\nmaterial = { plugin = 'mass-spring' }\n";

    fn sweep(text: &str) -> Result<Sweep, String> {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.toml", "b.toml"] {
            std::fs::write(folder.path().join(name), SCENE).unwrap();
        }
        std::fs::write(folder.path().join("m1.obj"), "").unwrap();
        std::fs::write(folder.path().join("m2.obj"), "").unwrap();
        Sweep::parse(&folder.path().join("sweep.toml"), format!("format = 1\n{text}")).map_err(|e| e.to_string())
    }

    #[test]
    fn edits_are_the_product_and_the_last_axis_varies_fastest() {
        let text = "scene = ['a.toml', 'b.toml']\nmodels = 'm*.obj'\n[set]\n'time.dt' = '2 ms'\n\
            [[axis]]\npath = 'body.0.material.params.young'\nlist = ['1 kPa', '2 kPa', '3 kPa']\n\
            [[axis]]\nrepeat = { count = 2 }\n";
        let sweep = sweep(text).unwrap();
        assert_eq!(sweep.edits(), 2 * 2 * 3 * 2);
        let cells: BTreeSet<String> = (0..24).map(|i| format!("{:?}", sweep.edit(i).cells)).collect();
        assert_eq!(cells.len(), 24, "no two are the same");
        let edit = sweep.edit(1 + 2 * 2 + 6);
        assert_eq!(edit.cells, [Cell::from("a.toml"), "m2.obj".into(), 3.into(), 1.into()]);
        let young = ("body.0.material.params.young".to_owned(), "\"3 kPa\"".to_owned());
        assert_eq!(edit.settings, [("time.dt".to_owned(), "\"2 ms\"".to_owned()), young]);
        let names: Vec<String> = sweep.columns()[..sweep.given].iter().map(Column::header).collect();
        assert_eq!(names, ["edit", "key", "scene", "model", "young_kPa", "repeat"]);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, part) in [
            ("scene = 'c.toml'", "sweep.toml:2:9"),
            ("scene = 'a.toml'\nmodels = '*.stl'", "no file matches"),
            ("scene = 'a.toml'\nmodel = 'x'", "unknown field `model`"),
            ("scene = 'a.toml'\n[[axis]]\npath = 'time.dt'\nlist = []", "an empty `list`"),
            ("scene = 'a.toml'\n[[axis]]\npath = 'nowhere.0.x'\nlist = [1]", "nowhere"),
            ("scene = 'a.toml'\n[keep]\nsummary = ['speed']", "no column `speed`"),
            ("scene = 'a.toml'\n[keep]\ntrace = ['speed']", "no column `speed`"),
            ("scene = 'a.toml'\n[limits]\nmemory = '3 parsec'", "allowed is"),
        ] {
            let error = sweep(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
