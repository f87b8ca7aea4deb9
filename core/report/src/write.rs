//! Writes the files of a report.

use crate::csv::csv;
use crate::document::Document;
use crate::html::html;
use pliant_record::{AtomicFile, check_replaceable, remove_leftovers};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Paths of the main files of a report.
#[derive(Clone, Debug)]
pub struct ReportFiles {
    /// Path of `report.html`.
    pub page: PathBuf,
    /// Path of `report.json`.
    pub json: PathBuf,
}

/// Names of the files that every report has.
const FILES: [&str; 3] = ["report.csv", "report.json", "report.html"];

/// Checks, before anything is measured, that the files of a report can be written into a folder.
///
/// # Errors
/// Names the file, what is there and what is allowed.
pub fn check_report_folder(folder: &Path) -> io::Result<()> {
    FILES.iter().try_for_each(|name| check_replaceable(&folder.join(name)))
}

/// Writes `report.json`, `report.csv`, `report.html` and the pictures into a folder.
///
/// # Errors
/// Returns the error of the file system with the path.
pub fn write_report(document: &Document, folder: &Path) -> io::Result<ReportFiles> {
    remove_leftovers(folder);
    let put = |name: &str, text: &str| -> io::Result<PathBuf> {
        let path = folder.join(name);
        let mut file = AtomicFile::create(&path)?;
        file.write_all(text.as_bytes())?;
        file.finish()?;
        Ok(path)
    };
    for (name, svg) in document.sections.iter().flat_map(|s| &s.plots) {
        put(&format!("{name}.svg"), svg)?;
    }
    put(FILES[0], &csv(&document.rows))?;
    let json = put(FILES[1], &serde_json::to_string_pretty(document).map_err(io::Error::other)?)?;
    let page = put(FILES[2], &html(document))?;
    Ok(ReportFiles { page, json })
}
