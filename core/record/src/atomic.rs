//! Files and folders that appear whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file under a temporary name beside its final one. Dropping it unfinished removes it.
pub struct AtomicFile {
    path: PathBuf,
    partial: PathBuf,
    writer: Option<BufWriter<File>>,
}

impl AtomicFile {
    /// Begins `path`, making its folder if there is none.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn create(path: &Path) -> io::Result<Self> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| with_path(folder, e))?;
        }
        let partial = partial(path);
        let file = File::create(&partial).map_err(|e| with_path(&partial, e))?;
        Ok(Self { path: path.to_path_buf(), partial, writer: Some(BufWriter::with_capacity(1 << 16, file)) })
    }

    /// Puts it in the place of whatever had its name.
    ///
    /// # Errors
    /// What the file system says, with the path; what was there before stays.
    pub fn finish(self) -> io::Result<()> {
        let path = self.path.clone();
        self.finish_as(&path)
    }

    /// Puts it under another name of the same file system.
    ///
    /// # Errors
    /// As for [`AtomicFile::finish`].
    pub fn finish_as(mut self, path: &Path) -> io::Result<()> {
        let writer = self.writer.take().expect("only taken here");
        let file = writer.into_inner().map_err(|e| with_path(&self.partial, e.into_error()))?;
        file.sync_all().map_err(|e| with_path(&self.partial, e))?;
        drop(file);
        std::fs::rename(&self.partial, path).map_err(|e| with_path(path, e))
    }
}

/// A folder under a temporary name beside its final one. Dropping it unfinished removes it and what is in it.
pub struct AtomicFolder {
    partial: PathBuf,
}

impl AtomicFolder {
    /// Begins `path`, making the folders above it.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn create(path: &Path) -> io::Result<Self> {
        let partial = partial(path);
        std::fs::create_dir_all(&partial).map_err(|e| with_path(&partial, e))?;
        Ok(Self { partial })
    }

    /// Where its files go for now.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Puts it in the place of whatever had the name `path` in the same file system.
    ///
    /// # Errors
    /// What the file system says, with the path; what was there before stays.
    pub fn finish_as(self, path: &Path) -> io::Result<()> {
        // A folder with something in it cannot be written over.
        let old = path.with_extension(format!("{}.old", std::process::id()));
        let moved = match std::fs::rename(path, &old) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(with_path(path, error)),
            moved => moved.is_ok(),
        };
        std::fs::rename(&self.partial, path).map_err(|e| with_path(path, e))?;
        if moved { std::fs::remove_dir_all(&old).map_err(|e| with_path(&old, e)) } else { Ok(()) }
    }
}

impl Drop for AtomicFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.partial);
    }
}

/// The temporary name.
fn partial(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.partial", std::process::id()));
    path.with_file_name(name)
}

/// The same error, naming the file.
pub(super) fn with_path(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.as_mut().expect("taken by `finish` alone").write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().expect("taken by `finish` alone").flush()
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if self.writer.take().is_some() {
            let _ = std::fs::remove_file(&self.partial);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_takes_the_place_of_an_older_one_or_leaves_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames");
        for (i, finished) in [true, false, true].into_iter().enumerate() {
            let new = AtomicFolder::create(&path).unwrap();
            std::fs::write(new.path().join(format!("{i}.obj")), "").unwrap();
            if finished {
                new.finish_as(&path).unwrap()
            } else {
                drop(new)
            }
            let names: Vec<_> = path.read_dir().unwrap().map(|e| e.unwrap().file_name()).collect();
            assert_eq!(names, [["0.obj", "0.obj", "2.obj"][i]]);
            assert_eq!(folder.path().read_dir().unwrap().count(), 1, "nothing else is left");
        }
    }

    #[test]
    fn what_is_not_finished_leaves_nothing_and_harms_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/result.txt");
        let mut first = AtomicFile::create(&path).unwrap();
        first.write_all(b"whole").unwrap();
        first.finish().unwrap();
        let mut second = AtomicFile::create(&path).unwrap();
        second.write_all(b"ha").unwrap();
        drop(second);
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
        assert_eq!(path.parent().unwrap().read_dir().unwrap().count(), 1);
    }
}
