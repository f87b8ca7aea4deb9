//! A recorded session as a scene: its bodies, tools and edits as they were, its hands from the recording.

use pliant_engine::scene::Source;
use pliant_engine::session::{LIVE_TIP_MASS, Session};
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Item, TableLike, TomlError, Value, value};

/// A session that has been recorded, for [`SessionScene::to_toml`].
#[derive(Clone, Copy)]
pub struct SessionScene<'a> {
    /// Text and file of the scene that was opened.
    pub source: &'a Source,
    /// The session as it is now.
    pub session: &'a Session,
    /// File that takes the place of the first body's model, if it is not the one that the scene names.
    pub model: Option<&'a Path>,
    /// Path of the recording that the hands come from.
    pub recording: &'a Path,
}

impl SessionScene<'_> {
    /// The scene as TOML, for a file in `folder`, an absolute path. It lasts as long as the session so far. `pliant run` of it gives the bytes of the
    /// session, as long as none of its bodies was given up for taking too long.
    ///
    /// # Errors
    /// Returns the parser's error if the text of the scene is not TOML.
    pub fn to_toml(&self, folder: &Path) -> Result<String, TomlError> {
        let mut scene: DocumentMut = self.source.text.parse()?;
        let was_in = std::path::absolute(self.source.folder()).unwrap_or_else(|_| self.source.folder().into());
        if was_in != folder {
            relocate(scene.as_table_mut(), &was_in, folder);
        }
        let steps = self.session.steps().max(1);
        scene["time"]["duration"] = value(steps as f64 * self.session.dt());
        let recording = relative(self.recording, folder);
        for device in entries(&mut scene, "device") {
            ["plugin", "params", "recorded"].iter().for_each(|key| _ = device.remove(key));
            device.insert("recording", value(recording.clone()));
        }
        if let (Some(model), Some(body)) = (self.model, entries(&mut scene, "body").next()) {
            body.remove("shape");
            body.insert("mesh", value(relative(model, folder)));
        }
        // Live tips on sheets have a mass, also where the scene gives none.
        if self.session.bodies.iter().any(|body| body.discretization.sheet().is_some()) {
            for tool in entries(&mut scene, "tool").filter(|tool| !tool.contains_key("mass")) {
                tool.insert("mass", value(LIVE_TIP_MASS));
            }
        }
        Ok(scene.to_string())
    }
}

/// The entries of an array of tables, in either notation.
fn entries<'a>(scene: &'a mut DocumentMut, key: &str) -> Box<dyn Iterator<Item = &'a mut dyn TableLike> + 'a> {
    match scene.get_mut(key) {
        Some(Item::ArrayOfTables(tables)) => Box::new(tables.iter_mut().map(|table| table as &mut dyn TableLike)),
        Some(Item::Value(Value::Array(array))) => {
            let tables = array.iter_mut().filter_map(Value::as_inline_table_mut);
            Box::new(tables.map(|table| table as &mut dyn TableLike))
        }
        _ => Box::new(std::iter::empty()),
    }
}

/// Rewrites texts that name a file relative to the folder `from`, so that they name it relative to the folder `to`. Whether a parameter is a path is known
/// to its plugin alone, so every text that names an existing file counts as one.
fn relocate(table: &mut dyn TableLike, from: &Path, to: &Path) {
    for (_, item) in table.iter_mut() {
        match item {
            Item::ArrayOfTables(tables) => tables.iter_mut().for_each(|table| relocate(table, from, to)),
            Item::Table(table) => relocate(table, from, to),
            Item::Value(value) => relocate_value(value, from, to),
            Item::None => {}
        }
    }
}

/// As [`relocate`], for the texts of one value.
fn relocate_value(value: &mut Value, from: &Path, to: &Path) {
    match value {
        Value::String(text) => {
            let path = from.join(text.value());
            if !text.value().is_empty() && path.is_file() {
                *value = relative(&path, to).into();
            }
        }
        Value::Array(array) => array.iter_mut().for_each(|value| relocate_value(value, from, to)),
        Value::InlineTable(table) => relocate(table, from, to),
        Value::Integer(_) | Value::Float(_) | Value::Boolean(_) | Value::Datetime(_) => {}
    }
}

/// The path relative to `folder` if it is inside of it, otherwise the absolute path.
fn relative(path: &Path, folder: &Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| PathBuf::from(path));
    path.strip_prefix(folder).unwrap_or(&path).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_files_follow_and_other_texts_stay() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old"), folder.path().join("new"));
        std::fs::create_dir_all(new.join("deeper")).unwrap();
        std::fs::create_dir(&old).unwrap();
        std::fs::write(old.join("a.obj"), "").unwrap();
        std::fs::write(new.join("deeper/b.csv"), "").unwrap();
        let text = "title = \"a.o\"\n[[body]]\nname = \"a\"\nmesh = \"a.obj\"\n\
            field = [{ file = \"../new/deeper/b.csv\" }]\nmaterial = { params = { fabric = \"denim\" } }\n";
        let mut scene: DocumentMut = text.parse().unwrap();
        relocate(scene.as_table_mut(), &old, &new);
        let body = scene["body"].as_array_of_tables().unwrap().get(0).unwrap();
        assert_eq!(body["mesh"].as_str(), Some(old.join("a.obj").to_str().unwrap()));
        let file = body["field"][0]["file"].as_str().unwrap();
        assert!(new.join(file).is_file(), "{file}");
        assert_eq!(body["material"]["params"]["fabric"].as_str(), Some("denim"));
        assert_eq!(scene["title"].as_str(), Some("a.o"));
    }
}
