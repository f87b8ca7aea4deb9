//! What happens in the window, for programs that watch it: a line of JSON for each event.

use serde_json::{Map, Value};
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Writes a line of JSON for each event.
pub struct EventLog {
    file: Option<File>,
    began: Instant,
}

impl EventLog {
    /// A log that writes nothing.
    pub fn none() -> Self {
        Self { file: None, began: Instant::now() }
    }

    /// Writes into a new file.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn create(path: &Path) -> std::io::Result<Self> {
        Ok(Self { file: Some(File::create(path)?), began: Instant::now() })
    }

    /// Writes an event: its seconds since the start, its name, and what belongs to it.
    pub fn event(&mut self, name: &str, fields: &[(&str, String)]) {
        let Some(file) = &mut self.file else { return };
        let mut line = Map::new();
        line.insert("seconds".into(), self.began.elapsed().as_secs_f64().into());
        line.insert("event".into(), name.into());
        line.extend(fields.iter().map(|(key, value)| ((*key).to_owned(), Value::from(value.clone()))));
        // A log that cannot be written is no reason to stop an artist.
        let _ = writeln!(file, "{}", Value::Object(line));
    }
}
