//! Journal of measured rows in a file, from which a stopped report resumes.

use crate::row::Row;
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Rows by key, in a file beside the report: a line of settings, then a line of JSON per row.
#[derive(Default)]
pub struct Journal {
    rows: HashMap<String, Row>,
    file: Option<(PathBuf, File)>,
    /// Number of rows that were in the file when it was opened.
    pub resumed: usize,
}

impl Journal {
    /// A journal that stores nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// Opens or creates the file at `path`. Its rows are used if its `settings` are the same; otherwise it is overwritten.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or written.
    pub fn open(path: &Path, settings: &str) -> io::Result<Self> {
        let mut rows = HashMap::new();
        if let Ok(old) = File::open(path) {
            let mut lines = BufReader::new(old).lines();
            if lines.next().transpose()?.as_deref() == Some(settings) {
                // A truncated last line is ignored.
                let read = lines.map_while(Result::ok).filter_map(|line| serde_json::from_str::<Row>(&line).ok());
                rows.extend(read.map(|row| (row.key(), row)));
            }
        }
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let mut file = OpenOptions::new().create(true).write(true).truncate(true).open(path)?;
        writeln!(file, "{settings}")?;
        let resumed = rows.len();
        let mut journal = Self { rows, file: Some((path.to_path_buf(), file)), resumed };
        let known: Vec<Row> = journal.rows.values().cloned().collect();
        known.iter().for_each(|row| journal.put(row));
        Ok(journal)
    }

    /// The row with this key; `None` if it has not been measured.
    pub fn get(&self, key: &str) -> Option<Row> {
        self.rows.get(key).cloned()
    }

    /// Stores a row. If the file cannot be written, the report continues but cannot be resumed.
    pub fn put(&mut self, row: &Row) {
        if let (Some((_, file)), Ok(line)) = (&mut self.file, serde_json::to_string(row)) {
            let _ = writeln!(file, "{line}");
        }
    }

    /// Removes the file after the report is complete.
    pub fn finish(self) {
        if let Some((path, _)) = self.file {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resumes_with_the_same_settings_only_and_ignores_a_cut_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/journal.jsonl");
        let row = |n| Row { case: "c".into(), n, error: Some(0.5), ..Row::default() };
        let mut first = Journal::open(&path, "a").unwrap();
        first.put(&row(1));
        first.put(&row(2));
        drop(first);
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.truncate(text.len() - 9);
        std::fs::write(&path, text).unwrap();
        let again = Journal::open(&path, "a").unwrap();
        assert_eq!((again.resumed, again.get(&row(1).key()), again.get(&row(2).key())), (1, Some(row(1)), None));
        drop(again);
        assert_eq!(Journal::open(&path, "b").unwrap().resumed, 0);
        Journal::open(&path, "b").unwrap().finish();
        assert!(!path.exists());
    }
}
