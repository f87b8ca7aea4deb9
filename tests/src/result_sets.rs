//! The files of a run as a set, to tell the results of one run from those of another.

use crate::Bench;
use std::collections::BTreeMap;

/// Files by their paths, with their bytes.
pub type FileSet = BTreeMap<String, Vec<u8>>;

/// Every file of a folder and of those in it, with its bytes.
pub fn files(bench: &Bench, folder: &str) -> FileSet {
    let mut found = BTreeMap::new();
    for name in bench.names(folder) {
        let path = format!("{folder}/{name}");
        if bench.path(&path).is_dir() {
            found.extend(files(bench, &path));
        } else {
            found.insert(path.clone(), bench.read(&path));
        }
    }
    found
}

/// What tells the results of two scenes apart, without what the clock says.
///
/// # Panics
/// If a file is not whole.
pub fn set_of(bench: &Bench, folder: &str) -> FileSet {
    let mut set = files(bench, folder);
    for (name, bytes) in &mut set {
        if name.ends_with("trace.csv") {
            let text = String::from_utf8(bytes.clone()).expect("UTF-8");
            *bytes =
                text.lines().flat_map(|row| row.rsplit_once(',').expect("columns").0.bytes().chain([b'\n'])).collect();
        } else if name.ends_with("summary.json") {
            let summary: serde_json::Value = serde_json::from_slice(bytes).expect("whole");
            *bytes = format!("{} {} {}", summary["settings"], summary["files"], summary["probes"]).into_bytes();
        }
    }
    set.into_iter().map(|(name, bytes)| (name.replacen(folder, "", 1), bytes)).collect()
}
