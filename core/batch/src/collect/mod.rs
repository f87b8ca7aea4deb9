//! Merging of the shards of a batch into one table.

mod csv;
mod json_lines;
#[cfg(feature = "parquet")]
mod parquet;

use crate::column::{Column, ColumnType, float_cell};
use crate::error::BatchError;
use crate::store::{OpenRecord, RowRecord, journals, read_state, row_bytes};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Options of [`collect`].
#[derive(Clone, Copy, Debug, Default)]
pub struct CollectOptions {
    /// Whether shards of different program versions are merged; a column then names the program.
    pub mixed: bool,
    /// Whether to add columns of times, which differ from run to run.
    pub timings: bool,
}

/// Formats of tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated values with a header; lists and objects are JSON in a cell.
    Csv,
    /// JSON Lines: an object for each row.
    JsonLines,
    /// Apache Parquet; units are in the metadata of the columns.
    #[cfg(feature = "parquet")]
    Parquet,
}

impl Format {
    /// The format of a file, by its extension.
    ///
    /// # Errors
    /// Returns a message with the extensions that are allowed.
    pub fn of(path: &Path) -> Result<Self, String> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("jsonl") => Ok(Self::JsonLines),
            #[cfg(feature = "parquet")]
            Some("parquet") => Ok(Self::Parquet),
            #[cfg(not(feature = "parquet"))]
            Some("parquet") => Err(
                "this program was built without Parquet; build it with `--features parquet`, or write .csv or .jsonl"
                    .into(),
            ),
            _ => Err(format!("{}: allowed is a file that ends in .csv, .jsonl or .parquet", path.display())),
        }
    }
}

/// The table of a shard, open for reading.
struct ShardRows {
    /// The file with its rows.
    table: File,
    /// Path of the file.
    path: PathBuf,
    /// Program and version of its results.
    program: String,
}

/// Rows of all shards, sorted by run; they are read one by one.
pub struct Table {
    /// Columns of the table, in order.
    columns: Vec<Column>,
    /// Tables of the shards.
    shards: Vec<ShardRows>,
    /// Rows by the index of their run.
    rows: BTreeMap<u64, TableRow>,
    /// Options of [`collect`].
    options: CollectOptions,
}

/// A row of a table.
struct TableRow {
    /// Index of its shard.
    shard: usize,
    /// Its record in the journal.
    record: RowRecord,
}

/// Result of [`collect`].
pub struct Collected {
    /// Rows of all shards, sorted by their index in the sweep.
    pub table: Table,
    /// Number of runs of the sweep.
    pub edits: u64,
    /// Number of rows of failed runs.
    pub failed: u64,
    /// Number of missing runs by shard (`I/N`), of shards with missing runs.
    pub missing: BTreeMap<String, u64>,
}

/// Reads the shards in `folders` as one table.
///
/// # Errors
/// Fails for folders without shards, shards of different sweeps or, unless `mixed`, of different versions, and files that cannot be read.
pub fn collect(folders: &[PathBuf], options: CollectOptions) -> Result<Collected, BatchError> {
    let mut first: Option<(OpenRecord, PathBuf)> = None;
    let mut table = Table { columns: Vec::new(), shards: Vec::new(), rows: BTreeMap::new(), options };
    let mut counts: BTreeSet<u64> = BTreeSet::new();
    for folder in folders {
        for path in journals(folder)? {
            let mut journal = File::open(&path).map_err(BatchError::at(&path))?;
            let state = read_state(&mut journal, &path)?;
            let Some(open) = state.opened else { continue };
            counts.insert(open.shards);
            let rows_path = path.with_extension("rows");
            let mut rows = File::open(&rows_path).map_err(BatchError::at(&rows_path))?;
            let shard = table.shards.len();
            for (edit, record) in state.rows {
                if row_bytes(&mut rows, &record).map_err(BatchError::at(&rows_path))?.is_some() {
                    table.rows.entry(edit).or_insert(TableRow { shard, record });
                }
            }
            table.shards.push(ShardRows { table: rows, path: rows_path, program: open.program.clone() });
            match &first {
                None => first = Some((open, path)),
                Some((known, of)) => check_same(known, of, &open, &path, options)?,
            }
        }
    }
    let Some((open, _)) = first else {
        return Err(BatchError::Input("no shard has been begun in these folders".into()));
    };
    table.columns = open.columns.clone();
    table.columns.extend(extra_columns(options));
    let failed = table.rows.values().filter(|row| row.record.failed.is_some()).count() as u64;
    let missing = missing_by_shard(&table, &open, &counts);
    Ok(Collected { table, edits: open.edits, failed, missing })
}

/// Checks that two shards are of the same sweep and, unless `mixed`, of the same program.
fn check_same(
    known: &OpenRecord,
    of: &Path,
    other: &OpenRecord,
    path: &Path,
    options: CollectOptions,
) -> Result<(), BatchError> {
    let refuse = |what: String| Err(BatchError::Journal { path: path.to_path_buf(), reason: what });
    if other.sweep != known.sweep || other.columns != known.columns || other.edits != known.edits {
        return refuse(format!("is of another sweep than {}; resume it with the sweep as it is now", of.display()));
    }
    if other.program != known.program && !options.mixed {
        return refuse(format!(
            "has results of {}, and {} of {}; resume one of them with the other's version, or give --mixed",
            other.program,
            of.display(),
            known.program
        ));
    }
    Ok(())
}

/// Columns that are not in the tables of the shards.
fn extra_columns(options: CollectOptions) -> Vec<Column> {
    let mut columns = Vec::new();
    if options.mixed {
        columns.push(Column::new("program", "", ColumnType::Text));
    }
    if options.timings {
        columns.push(Column::new("attempts", "1", ColumnType::Integer));
        columns.extend(["open_time", "step_time", "edit_time"].map(|name| Column::new(name, "s", ColumnType::Float)));
    }
    columns
}

/// Numbers of missing runs by shard. `counts` are the numbers of shards into which the sweep was divided.
fn missing_by_shard(table: &Table, open: &OpenRecord, counts: &BTreeSet<u64>) -> BTreeMap<String, u64> {
    // With several divisions the shard of a missing run is not known.
    let shards = if counts.len() == 1 { open.shards } else { 1 };
    let mut missing = BTreeMap::new();
    let mut next = 0;
    for edit in table.rows.keys().copied().chain([open.edits]) {
        for absent in next..edit.min(open.edits) {
            *missing.entry(format!("{}/{shards}", absent % shards + 1)).or_default() += 1;
        }
        next = edit + 1;
    }
    missing
}

impl Table {
    /// Columns of the table, in order.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Writes the table.
    ///
    /// # Errors
    /// Fails for a shard that cannot be read and with the errors of `out`.
    pub fn write(&mut self, format: Format, out: &mut (impl Write + Send)) -> Result<(), BatchError> {
        match format {
            Format::Csv => csv::write(self, out),
            Format::JsonLines => json_lines::write(self, out),
            #[cfg(feature = "parquet")]
            Format::Parquet => parquet::write(self, out),
        }
    }

    /// Calls `visit` with the cells of each row, in the order of the sweep.
    ///
    /// # Errors
    /// Fails for a shard that cannot be read and with the errors of `visit`.
    pub fn for_each(&mut self, mut visit: impl FnMut(Vec<Value>) -> Result<(), BatchError>) -> Result<(), BatchError> {
        for TableRow { shard, record: row } in self.rows.values() {
            let ShardRows { table, path, program } = &mut self.shards[*shard];
            let Some(bytes) = row_bytes(table, row).map_err(BatchError::at(path))? else { continue };
            let mut cells: Map<String, Value> = serde_json::from_slice(&bytes)
                .map_err(|e| BatchError::Journal { path: path.clone(), reason: format!("run {}: {e}", row.edit) })?;
            if self.options.mixed {
                cells.insert("program".into(), program.as_str().into());
            }
            if self.options.timings {
                let times = row.seconds;
                cells.insert("attempts".into(), row.attempts.into());
                let times = [("open_time", times.open), ("step_time", times.steps), ("edit_time", times.all)];
                cells.extend(times.map(|(name, seconds)| (name.to_owned(), float_cell(seconds))));
            }
            let cells = self.columns.iter().map(|column| cells.remove(&column.name).unwrap_or_default());
            visit(cells.collect())?;
        }
        Ok(())
    }
}
