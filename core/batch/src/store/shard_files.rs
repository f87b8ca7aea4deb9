//! The journal and the table of a shard, open for writing.
//!
//! A row is written to the table first and counts once its record stands in the journal, so a reader of the journal never sees half a
//! row. Both are written at once, which a killed process survives, and brought to the disk together by [`ShardFiles::sync`], which a
//! machine without power survives: a record whose row did not reach the disk does not match its checksum.

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

/// A file and where it is.
struct Named {
    file: File,
    path: PathBuf,
    /// Bytes that count.
    length: u64,
}

impl Named {
    /// Appends bytes. What was written of them is taken back if they cannot be written whole.
    fn append(&mut self, bytes: &[u8]) -> Result<(), BatchError> {
        if let Err(error) = self.file.write_all(bytes) {
            let _ = self.cut();
            return Err(BatchError::io(&self.path, error));
        }
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Cuts off what does not count, and goes to the end.
    fn cut(&mut self) -> io::Result<()> {
        self.file.set_len(self.length)?;
        self.file.seek(SeekFrom::Start(self.length)).map(drop)
    }
}

/// The files of a shard that this process has to itself.
pub(crate) struct ShardFiles {
    journal: Named,
    table: Named,
}

/// A row to be written.
pub(crate) struct NewRow<'a> {
    pub(crate) edit: u64,
    pub(crate) key: EditKey,
    /// One line without its line break.
    pub(crate) text: &'a str,
    pub(crate) failed: Option<FailureClass>,
    pub(crate) attempts: u32,
    pub(crate) seconds: EditSeconds,
}

impl ShardFiles {
    /// Opens or makes the files of a shard in `folder`, cuts off their torn tails, and says what they hold. A row that is not what its
    /// record says is not held.
    ///
    /// # Errors
    /// Files that cannot be written, that another process has open, or that hold rows though `resume` is not given.
    pub(crate) fn open(folder: &Path, shard: Shard, resume: bool) -> Result<(Self, ShardState), BatchError> {
        std::fs::create_dir_all(folder).map_err(BatchError::at(folder))?;
        let open = |extension: &str| {
            let path = folder.join(format!("{}.{extension}", shard.stem()));
            let mut options = OpenOptions::new();
            let file = options.read(true).write(true).create(true).truncate(false).open(&path);
            file.map(|file| Named { file, path: path.clone(), length: 0 }).map_err(BatchError::at(&path))
        };
        let mut journal = open("journal")?;
        match try_lock(&journal.file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(locked(&mut journal, shard)),
            // A file system without locks: who runs a shard twice there gets rows twice, of which the last counts.
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
        (journal.length, table.length) = (state.valid, state.table_length());
        let size = table.file.metadata().map_err(BatchError::at(&table.path))?.len();
        // A table that is shorter than its journal says keeps what it has.
        table.length = table.length.min(size);
        for file in [&mut journal, &mut table] {
            file.cut().map_err(BatchError::at(&file.path))?;
        }
        let mut whole = std::collections::BTreeMap::new();
        for (edit, row) in std::mem::take(&mut state.rows) {
            if row_bytes(&mut table.file, &row).map_err(BatchError::at(&table.path))?.is_some() {
                whole.insert(edit, row);
            }
        }
        state.rows = whole;
        table.file.seek(SeekFrom::End(0)).map_err(BatchError::at(&table.path))?;
        // A file that was just made has its name on the disk too.
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

    /// Records that an edit begins.
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

    /// Records that the row of an edit no longer counts.
    pub(crate) fn drop_row(&mut self, edit: u64) -> Result<(), BatchError> {
        self.record(&Record::Drop { edit })
    }

    /// Records that this process is done.
    pub(crate) fn close(&mut self, stopped: bool) -> Result<(), BatchError> {
        self.record(&Record::Close(CloseRecord { stopped, time: now() }))
    }

    /// The bytes of a row.
    pub(crate) fn row(&mut self, row: &RowRecord) -> Result<Option<Vec<u8>>, BatchError> {
        let bytes = row_bytes(&mut self.table.file, row).map_err(BatchError::at(&self.table.path))?;
        self.table.file.seek(SeekFrom::Start(self.table.length)).map_err(BatchError::at(&self.table.path))?;
        Ok(bytes)
    }

    /// Handles through which both files are brought to the disk while rows are written.
    pub(crate) fn syncer(&self) -> Result<Syncer, BatchError> {
        let handle = |named: &Named| {
            let file = named.file.try_clone().map_err(BatchError::at(&named.path))?;
            Ok::<_, BatchError>((file, named.path.clone()))
        };
        Ok(Syncer { files: [handle(&self.table)?, handle(&self.journal)?] })
    }

    fn record(&mut self, record: &Record) -> Result<(), BatchError> {
        let line = line(record).map_err(BatchError::at(&self.journal.path))?;
        self.journal.append(&line)
    }
}

/// Brings the files of a shard to the disk.
pub(crate) struct Syncer {
    files: [(File, PathBuf); 2],
}

impl Syncer {
    /// Waits until everything written so far is on the disk.
    pub(crate) fn sync(&self) -> Result<(), BatchError> {
        self.files.iter().try_for_each(|(file, path)| file.sync_data().map_err(BatchError::at(path)))
    }
}

/// Locks a journal for this process. One who only looks holds it for a moment, so a few tries are made.
fn try_lock(file: &File) -> Result<(), TryLockError> {
    const TRIES: usize = 5;
    for _ in 1..TRIES {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(20)),
            other => return other,
        }
    }
    file.try_lock()
}

/// Who holds the lock.
fn locked(journal: &mut Named, shard: Shard) -> BatchError {
    let opened = read_state(&mut journal.file, &journal.path).ok().and_then(|state| state.opened);
    let holder = opened.map_or_else(|| "another process".into(), |open| open.process);
    BatchError::Locked { path: journal.path.clone(), shard: shard.to_string(), holder }
}

/// This process, by its number and host.
fn process() -> String {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").ok().or_else(|| std::env::var("HOSTNAME").ok());
    let host = host.map_or_else(|| "this machine".into(), |host| host.trim().to_owned());
    format!("process {} on {host}", std::process::id())
}

/// s, since 1970
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
