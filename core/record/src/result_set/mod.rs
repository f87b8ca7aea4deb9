//! The results of a run as a set: all of them replace those of the run before in one rename, or none does.
//!
//! They are written into a staging folder beside the folder of results, flushed, and exchanged with it (`renameat2` on Linux, `renamex_np` on
//! macOS). A killed process leaves the old set or the new one, and a staging folder that the next run into the same folder removes. The staging
//! folder is locked, so a second run into the same folder is refused.
//!
//! Files that are not results of an earlier run are kept. A folder is not exchanged if it contains such files, is the current folder or above it,
//! is a link or a mount, or is on a file system that cannot exchange folders. The staging folder is then created in it, and files are moved one
//! by one: the old summary is moved away first, and the new one comes last. A process that is killed meanwhile leaves a set without a summary,
//! which the next run completes.

mod files;
mod flush;
mod recovery;

pub(crate) use files::{files_below, is_in_set};

use crate::atomic::{AtomicFolder, error_at, folder_of, sync_folder, temporaries};
use files::{is_result, listed};
use flush::{flush_files, sync_tree};
use recovery::{COMMITTED, complete, discard, recover, remove_if_there};
use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The file that every set has, which lists the others.
pub(crate) const SUMMARY: &str = "summary.json";
/// Folder of the frames.
pub(crate) const FRAMES: &str = "frames";
/// Folder of the results of a run that was stopped.
pub(crate) const INTERRUPTED: &str = "interrupted";
/// Beginning of the name of a staging folder inside of the folder of results.
const STAGE: &str = "results";

/// Results of a run that is under way.
pub(crate) struct ResultSet {
    /// Folder into which results are written before they get their names.
    stage: AtomicFolder,
    /// Final folder, absolute.
    folder: PathBuf,
    /// Final folder as the user has given it, for messages.
    shown: PathBuf,
}

impl ResultSet {
    /// Begins the results that will be in `folder`; creates the folders above it, and completes or removes sets that killed processes have left.
    ///
    /// # Errors
    /// Fails for a folder that cannot be written to, into which another run writes, or with files that have names of results but were not
    /// written by a run.
    pub(crate) fn begin(folder: &Path) -> io::Result<Self> {
        let (above, shown) = (folder_of(folder), folder);
        std::fs::create_dir_all(above).map_err(|e| error_at(above, e))?;
        // Absolute, so that paths of temporary folders can be compared.
        let folder = std::path::absolute(folder).map_err(|e| error_at(shown, e))?;
        if folder.exists() {
            // Fails for a file and for a folder without write permission.
            tempfile::tempfile_in(&folder).map_err(|e| error_at(shown, e))?;
        }
        let inside = folder.join(STAGE);
        let stage = match is_replaceable(&folder) {
            true => AtomicFolder::create(&folder).or_else(|_| AtomicFolder::create(&inside))?,
            false => AtomicFolder::create(&inside)?,
        };
        let left = temporaries(&folder).into_iter().chain(temporaries(&inside));
        let others: Vec<PathBuf> = left.filter(|path| path != stage.path()).collect();
        for other in others {
            match File::open(&other).map(|file| (file.try_lock().is_err(), file)) {
                Ok((true, _)) if locks_work(&stage) => {
                    let text =
                        "another run writes its results there; wait for its end, or choose another folder with `--out`";
                    return Err(error_at(shown, io::Error::new(ErrorKind::ResourceBusy, text)));
                }
                Ok((_, _lock)) => recover(&other, &folder)?,
                Err(_) => {}
            }
        }
        complete(&folder)?;
        refuse_foreign_files(&folder, shown)?;
        Ok(Self { stage, folder, shown: shown.into() })
    }

    /// The folder to write results into.
    pub(crate) fn path(&self) -> &Path {
        self.stage.path()
    }

    /// Flushes the files so far to the disk. The summary is written after them, so that a set with a summary is whole.
    ///
    /// # Errors
    /// The error of the file system, with the final path of the file.
    pub(crate) fn flush(&self) -> io::Result<()> {
        flush_files(self.path(), &self.shown)
    }

    /// Replaces the results of an earlier run; those of an interrupted run go to the folder `interrupted` in it.
    ///
    /// # Errors
    /// The error of the file system, with the path. The old results are then unchanged, unless files were being moved one by one.
    pub(crate) fn commit(self, interrupted: bool) -> io::Result<()> {
        let below = |folder: &Path| if interrupted { folder.join(INTERRUPTED) } else { folder.into() };
        let target = below(&self.folder);
        std::fs::create_dir_all(folder_of(&target)).map_err(|e| error_at(&target, e))?;
        refuse_foreign_files(&target, &below(&self.shown))?;
        sync_tree(self.path()).map_err(|e| error_at(self.path(), e))?;
        let is_beside = folder_of(self.path()) == folder_of(&self.folder);
        if (is_beside || interrupted) && is_replaceable(&target) && self.replace(&target)? {
            return Ok(());
        }
        self.move_in(&target)
    }

    /// Exchanges the folders; false if the file system cannot.
    fn replace(&self, target: &Path) -> io::Result<bool> {
        let stage = self.path();
        if let Ok(metadata) = target.metadata() {
            let _ = std::fs::set_permissions(stage, metadata.permissions());
            if exchange(stage, target).is_err() {
                return Ok(false);
            }
            sync_folder(folder_of(target));
            // The folder with the temporary name is now the old set, perhaps with files that were added during the exchange.
            discard(stage, target).map_err(|e| error_at(stage, e))?;
        } else {
            std::fs::rename(stage, target).map_err(|e| error_at(target, e))?;
            sync_folder(folder_of(target));
        }
        Ok(true)
    }

    /// Moves the files one by one, the summary last.
    fn move_in(self, target: &Path) -> io::Result<()> {
        std::fs::create_dir_all(target).map_err(|e| error_at(target, e))?;
        let committed = target.join(COMMITTED);
        if committed.is_symlink() {
            // A link is not from this program and need not be kept.
            remove_if_there(&committed).map_err(|e| error_at(&committed, e))?;
        }
        std::fs::rename(self.path(), &committed).map_err(|e| error_at(target, e))?;
        sync_folder(target);
        complete(target)
    }
}

/// Checks that files with names of results in `folder` were written by a run; errors call the folder `shown`.
fn refuse_foreign_files(folder: &Path, shown: &Path) -> io::Result<()> {
    let listed = listed(folder);
    let Ok(files) = files_below(folder) else { return Ok(()) };
    match files.into_iter().find(|file| is_result(file) && !listed.contains(file)) {
        None => Ok(()),
        Some(file) => {
            let text = "not written by a run (no summary.json beside it lists it); move it, or choose another folder with `--out`";
            Err(error_at(&shown.join(file), io::Error::new(ErrorKind::AlreadyExists, text)))
        }
    }
}

/// Whether `folder` may be exchanged: it does not exist, or it contains results and those of an interrupted run alone, and is neither a link nor a
/// mount nor the current folder or one above it.
fn is_replaceable(folder: &Path) -> bool {
    let Ok(metadata) = folder.symlink_metadata() else { return true };
    let is_current = std::env::current_dir().and_then(|current| Ok(current.starts_with(folder.canonicalize()?)));
    if !metadata.is_dir() || is_current.unwrap_or(true) || is_mount(folder, &metadata) {
        return false;
    }
    let (listed, kept) = (listed(folder), Path::new(INTERRUPTED));
    let is_known = |file: &PathBuf| listed.contains(file) || file.starts_with(kept);
    let is_known_folder = |name: &std::ffi::OsStr| name == FRAMES || name == INTERRUPTED;
    let Ok(entries) = folder.read_dir() else { return false };
    let folders_known = entries.flatten().all(|e| !e.path().is_dir() || is_known_folder(&e.file_name()));
    folders_known && files_below(folder).is_ok_and(|files| files.iter().all(is_known))
}

/// Whether a folder is on another device than the one above it.
#[cfg(unix)]
fn is_mount(folder: &Path, metadata: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    folder
        .canonicalize()
        .is_ok_and(|folder| folder_of(&folder).metadata().is_ok_and(|above| above.dev() != metadata.dev()))
}

/// Not known on this system.
#[cfg(not(unix))]
fn is_mount(_folder: &Path, _metadata: &std::fs::Metadata) -> bool {
    false
}

/// Whether the file system has locks: a second handle cannot lock the staging folder, which is locked.
fn locks_work(stage: &AtomicFolder) -> bool {
    File::open(stage.path()).is_ok_and(|file| file.try_lock().is_err())
}

/// Exchanges two folders in one step.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

/// Not possible on this system.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn exchange(_a: &Path, _b: &Path) -> io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::recovery::OLD_SUMMARY;
    use super::*;
    use std::fs::{create_dir_all, read_to_string, write};

    /// Writes a set whose files all have the text `text`, with as many frames.
    fn put(folder: &Path, text: &str, frames: usize) -> io::Result<()> {
        let set = ResultSet::begin(folder)?;
        fill(&set, text, frames);
        set.commit(false)
    }

    fn fill(set: &ResultSet, text: &str, frames: usize) {
        let names = ["final.obj", "trace.csv"].map(str::to_owned).into_iter();
        let names: Vec<String> = names.chain((0..frames).map(|i| format!("frames/frame-{i:05}.obj"))).collect();
        create_dir_all(set.path().join(FRAMES)).unwrap();
        names.iter().for_each(|name| write(set.path().join(name), text).unwrap());
        let summary = serde_json::json!({ "program": "pliant 0", "text": text, "files": names });
        write(set.path().join(SUMMARY), summary.to_string()).unwrap();
    }

    fn all(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_set_replaces_the_one_before_and_nothing_of_that_stays() {
        let bench = tempfile::tempdir().unwrap();
        let folder = bench.path().join("out");
        for (text, frames) in [("one", 3), ("two", 1), ("three", 0)] {
            put(&folder, text, frames).unwrap();
            assert_eq!(files_below(&folder).unwrap().len(), 3 + frames);
            assert!(
                files_below(&folder).unwrap().iter().all(|f| read_to_string(folder.join(f)).unwrap().contains(text))
            );
            assert_eq!(all(bench.path()), ["out"]);
        }
    }

    #[test]
    fn what_no_run_has_written_stays() {
        let bench = tempfile::tempdir().unwrap();
        let folder = bench.path().join("out");
        create_dir_all(folder.join("frames/deep")).unwrap();
        create_dir_all(folder.join("notes")).unwrap();
        let mine = ["frames/picture.png", "frames/deep/frame-1.obj", "notes/final.obj", "readme", "finale.obj.bak"];
        mine.iter().for_each(|name| write(folder.join(name), "mine").unwrap());
        for (text, frames) in [("one", 2), ("two", 0), ("three", 1)] {
            put(&folder, text, frames).unwrap();
            assert!(mine.iter().all(|name| read_to_string(folder.join(name)).unwrap() == "mine"));
            let ours = files_below(&folder).unwrap().into_iter().filter(|f| is_result(f)).count();
            assert_eq!(ours, 3 + frames, "{:?}", all(&folder));
            assert_eq!(all(bench.path()), ["out"]);
        }
        // A namesake of a result that no summary lists is not written over.
        write(folder.join("nodes.csv"), "mine").unwrap();
        let text = put(&folder, "four", 0).unwrap_err().to_string();
        assert!(text.contains("nodes.csv") && text.contains("--out"), "{text}");
        assert_eq!(read_to_string(folder.join("nodes.csv")).unwrap(), "mine");
    }

    #[test]
    fn two_writers_are_refused_and_leftovers_are_removed() {
        let bench = tempfile::tempdir().unwrap();
        let folder = bench.path().join("out");
        put(&folder, "one", 1).unwrap();
        let first = ResultSet::begin(&folder).unwrap();
        let text = put(&folder, "two", 1).unwrap_err().to_string();
        assert!(text.contains("another run"), "{text}");
        assert_eq!(all(bench.path()).len(), 2, "the refused one leaves nothing");
        fill(&first, "three", 2);
        // As a killed process leaves it: unlocked.
        let ResultSet { stage, .. } = first;
        stage.keep();
        assert_eq!(all(bench.path()).len(), 2);
        put(&folder, "four", 0).unwrap();
        assert_eq!(
            (all(bench.path()), read_to_string(folder.join("final.obj")).unwrap()),
            (vec!["out".into()], "four".into())
        );
    }

    #[test]
    fn a_set_whose_files_were_being_moved_is_completed() {
        let bench = tempfile::tempdir().unwrap();
        let folder = bench.path().join("out");
        create_dir_all(folder.join("notes")).unwrap();
        put(&folder, "old", 2).unwrap();
        for moved in 0..4 {
            let set = ResultSet::begin(&folder).unwrap();
            fill(&set, "new", 1);
            let committed = folder.join(COMMITTED);
            std::fs::rename(set.path(), &committed).unwrap();
            drop(set);
            // As after a kill in the middle of the moves.
            std::fs::rename(folder.join(SUMMARY), committed.join(OLD_SUMMARY)).unwrap();
            for name in ["final.obj", "frames/frame-00000.obj", "trace.csv"].iter().take(moved) {
                std::fs::rename(committed.join(name), folder.join(name)).unwrap();
            }
            drop(ResultSet::begin(&folder).unwrap());
            let results: Vec<_> = files_below(&folder).unwrap().into_iter().filter(|f| is_result(f)).collect();
            assert!(
                results.iter().all(|f| read_to_string(folder.join(f)).unwrap().contains("new")),
                "{moved}: {results:?}"
            );
            assert!(results.len() == 4 && !committed.exists(), "{results:?}");
            put(&folder, "old", 2).unwrap();
        }
    }

    #[test]
    #[cfg(unix)]
    fn planted_links_are_not_followed() {
        let bench = tempfile::tempdir().unwrap();
        let (folder, victim) = (bench.path().join("out"), bench.path().join("victim"));
        create_dir_all(&folder).unwrap();
        create_dir_all(victim.join("frames")).unwrap();
        write(victim.join("final.obj"), "theirs").unwrap();
        write(victim.join(SUMMARY), "{}").unwrap();
        for name in [COMMITTED, "results.pliant-AbCdEf.partial"] {
            std::os::unix::fs::symlink(&victim, folder.join(name)).unwrap();
        }
        std::os::unix::fs::symlink(&victim, bench.path().join("out.pliant-AbCdEf.partial")).unwrap();
        put(&folder, "one", 1).unwrap();
        assert_eq!(read_to_string(victim.join("final.obj")).unwrap(), "theirs");
        assert!(victim.join(SUMMARY).exists() && read_to_string(folder.join("final.obj")).unwrap() == "one");
    }
}
