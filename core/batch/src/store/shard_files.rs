//! The journal and the table of a shard, open for writing.
//!
//! A row is written to the table first and is valid once its record is in the journal, so a reader of the journal never finds an incomplete row.
//! Both files are written without buffering, so rows survive a killed process, and are flushed together by [`Syncer::sync`], so rows survive a
//! power failure: if the row of a record did not reach the disk, its checksum does not match.

use super::journal::line;
use super::records::{CloseRecord, OpenRecord, Record, RowRecord};
use super::state::{FORMAT, ShardState, read_state, row_bytes};
use crate::error::BatchError;
use crate::execute::{EditSeconds, FailureClass};
use crate::key::EditKey;
use crate::shard::Shard;
use crate::sweep::Sweep;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// A file that is appended to.
struct AppendFile {
    /// The file, positioned at its end.
    file: File,
    /// Where the file is.
    path: PathBuf,
    /// Length of its valid part, bytes.
    length: u64,
}

impl AppendFile {
    /// Appends bytes. If they cannot be written completely, the file keeps its length.
    fn append(&mut self, bytes: &[u8]) -> Result<(), BatchError> {
        if let Err(error) = self.file.write_all(bytes) {
            let _ = self.truncate();
            return Err(BatchError::io(&self.path, error));
        }
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Removes everything after the valid part, and seeks to its end.
    fn truncate(&mut self) -> io::Result<()> {
        self.file.set_len(self.length)?;
        self.file.seek(SeekFrom::Start(self.length)).map(drop)
    }
}

/// The files of a shard, locked by this process.
pub(crate) struct ShardFiles {
    /// Records of runs that began and of rows that ended.
    journal: AppendFile,
    /// Rows of the results.
    table: AppendFile,
}

/// A row to be written.
pub(crate) struct NewRow<'a> {
    /// Index of the run.
    pub(crate) edit: u64,
    /// Key of the run.
    pub(crate) key: EditKey,
    /// The row, one line without its line break.
    pub(crate) text: &'a str,
    /// Class of the failure, if the run failed.
    pub(crate) failed: Option<FailureClass>,
    /// Number of attempts.
    pub(crate) attempts: u32,
    /// Times of its phases.
    pub(crate) seconds: EditSeconds,
}

impl ShardFiles {
    /// Opens or creates the files of a shard in `folder`, removes incomplete ends, and returns their state. Rows that do not match their
    /// checksums are left out.
    ///
    /// # Errors
    /// Fails for files that cannot be written, that another process has locked, or that have rows without `resume`.
    pub(crate) fn open(folder: &Path, shard: Shard, resume: bool) -> Result<(Self, ShardState), BatchError> {
        std::fs::create_dir_all(folder).map_err(BatchError::at(folder))?;
        let open = |extension: &str| {
            let path = folder.join(format!("{}.{extension}", shard.stem()));
            let mut options = OpenOptions::new();
            let file = options.read(true).write(true).create(true).truncate(false).open(&path);
            file.map(|file| AppendFile { file, path: path.clone(), length: 0 }).map_err(BatchError::at(&path))
        };
        let mut journal = open("journal")?;
        match try_lock(&journal.file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(locked(&mut journal, shard)),
            // Without locks two processes may run the shard; of two rows of a run the last one is valid.
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(BatchError::io(&journal.path, error)),
        }
        let mut table = open("rows")?;
        let mut state = read_state(&mut journal.file, &journal.path)?;
        if !state.rows.is_empty() && !resume {
            let rows = match state.rows.len() {
                1 => "1 row".to_owned(),
                more => format!("{more} rows"),
            };
            return Err(BatchError::Exists { path: journal.path, rows });
        }
        (journal.length, table.length) = (state.journal_length, state.table_length());
        let size = table.file.metadata().map_err(BatchError::at(&table.path))?.len();
        // The table may be shorter than the journal says after a power failure.
        table.length = table.length.min(size);
        for file in [&mut journal, &mut table] {
            file.truncate().map_err(BatchError::at(&file.path))?;
        }
        let mut valid = std::collections::BTreeMap::new();
        for (edit, row) in std::mem::take(&mut state.rows) {
            if row_bytes(&mut table.file, &row).map_err(BatchError::at(&table.path))?.is_some() {
                valid.insert(edit, row);
            }
        }
        state.rows = valid;
        table.file.seek(SeekFrom::End(0)).map_err(BatchError::at(&table.path))?;
        // Flushes the names of new files.
        #[cfg(unix)]
        File::open(folder).and_then(|folder| folder.sync_all()).map_err(BatchError::at(folder))?;
        Ok((Self { journal, table }, state))
    }

    /// Records that this process runs the shard of a sweep.
    pub(crate) fn begin(&mut self, sweep: &Sweep, shard: Shard, program: &str) -> Result<(), BatchError> {
        self.record(&Record::Open(OpenRecord {
            format: FORMAT,
            program: program.to_owned(),
            sweep: sweep.digest().to_owned(),
            title: sweep.title.clone(),
            shard: shard.number,
            shards: shard.count,
            edits: sweep.edits(),
            columns: sweep.columns().to_vec(),
            process: process(),
            time: now(),
        }))
    }

    /// Records that a run begins.
    pub(crate) fn begin_edit(&mut self, edit: u64, attempt: u32) -> Result<(), BatchError> {
        self.record(&Record::Begin { edit, attempt })
    }

    /// Appends a row and records it.
    pub(crate) fn put(&mut self, row: NewRow<'_>) -> Result<(), BatchError> {
        let mut bytes = Vec::with_capacity(row.text.len() + 1);
        bytes.extend_from_slice(row.text.as_bytes());
        bytes.push(b'\n');
        let NewRow { edit, key, failed, attempts, seconds, .. } = row;
        let (at, length, crc) = (self.table.length, bytes.len() as u64, crc32fast::hash(&bytes));
        self.table.append(&bytes)?;
        self.record(&Record::Row(RowRecord { edit, key, at, length, crc, failed, attempts, seconds }))
    }

    /// Records that the row of a run is invalid.
    pub(crate) fn drop_row(&mut self, edit: u64) -> Result<(), BatchError> {
        self.record(&Record::Drop { edit })
    }

    /// Records that this process closes the shard.
    pub(crate) fn close(&mut self, stopped: bool) -> Result<(), BatchError> {
        self.record(&Record::Close(CloseRecord { stopped, time: now() }))
    }

    /// The bytes of a row; `None` if they do not match their checksum.
    pub(crate) fn row(&mut self, row: &RowRecord) -> Result<Option<Vec<u8>>, BatchError> {
        let bytes = row_bytes(&mut self.table.file, row).map_err(BatchError::at(&self.table.path))?;
        self.table.file.seek(SeekFrom::Start(self.table.length)).map_err(BatchError::at(&self.table.path))?;
        Ok(bytes)
    }

    /// Handles by which another thread can flush both files while rows are written.
    pub(crate) fn syncer(&self) -> Result<Syncer, BatchError> {
        let handle = |open: &AppendFile| {
            let file = open.file.try_clone().map_err(BatchError::at(&open.path))?;
            Ok::<_, BatchError>((file, open.path.clone()))
        };
        Ok(Syncer { files: [handle(&self.table)?, handle(&self.journal)?] })
    }

    /// Appends a record to the journal.
    fn record(&mut self, record: &Record) -> Result<(), BatchError> {
        let line = line(record).map_err(BatchError::at(&self.journal.path))?;
        self.journal.append(&line)
    }
}

/// Flushes the files of a shard to the disk.
pub(crate) struct Syncer {
    /// The files and their paths.
    files: [(File, PathBuf); 2],
}

impl Syncer {
    /// Flushes everything written so far, and waits for it.
    pub(crate) fn sync(&self) -> Result<(), BatchError> {
        self.files.iter().try_for_each(|(file, path)| file.sync_data().map_err(BatchError::at(path)))
    }
}

/// Locks a journal for this process. Readers hold the lock for a moment, so a few attempts are made.
fn try_lock(file: &File) -> Result<(), TryLockError> {
    const ATTEMPTS: usize = 5;
    for _ in 1..ATTEMPTS {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(20)),
            other => return other,
        }
    }
    file.try_lock()
}

/// The error of a shard that another process has locked.
fn locked(journal: &mut AppendFile, shard: Shard) -> BatchError {
    let opened = read_state(&mut journal.file, &journal.path).ok().and_then(|state| state.opened);
    let holder = opened.map_or_else(|| "another process".into(), |open| open.process);
    BatchError::Locked { path: journal.path.clone(), shard: shard.to_string(), holder }
}

/// Name of this process: its id and host.
fn process() -> String {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").ok().or_else(|| std::env::var("HOSTNAME").ok());
    let host = host.map_or_else(|| "this machine".into(), |host| host.trim().to_owned());
    format!("process {} on {host}", std::process::id())
}

/// The time, s since 1970.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

/// Journals of all shards in a folder, sorted by name.
pub(crate) fn journals(folder: &Path) -> Result<Vec<PathBuf>, BatchError> {
    let entries = folder.read_dir().map_err(BatchError::at(folder))?;
    let paths = entries.flatten().map(|entry| entry.path());
    let mut paths: Vec<PathBuf> = paths.filter(|path| path.extension().is_some_and(|e| e == "journal")).collect();
    paths.sort();
    if paths.is_empty() {
        return Err(BatchError::Input(format!("{}: no shard of a batch is in this folder", folder.display())));
    }
    Ok(paths)
}
