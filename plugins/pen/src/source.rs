//! Where events come from: a device of the kernel, or a recording of one that plays in its own time.

use crate::axes::Axes;
use crate::event::{BYTES, EV_SYN, Event, SYN_REPORT};
use crate::find;
use crate::state::PenState;
use pliant_plugin_api::Fault;
use std::fs::{File, FileType};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

/// A source of events.
pub(crate) enum Source {
    /// A device, or a pipe: what is there is taken at once.
    Live(LiveEvents),
    /// A file of events: each frame comes as long after the first as it did then.
    Recorded(RecordedEvents),
}

/// Events of a file that never waits.
pub(crate) struct LiveEvents {
    file: File,
    /// Its name, for errors.
    path: PathBuf,
    /// Bytes of an event that has not arrived whole, and their number.
    part: [u8; BYTES],
    count: usize,
}

/// Events of a recording.
pub(crate) struct RecordedEvents {
    events: Vec<Event>,
    /// The next one.
    next: usize,
}

/// Largest recording, bytes.
const RECORDING_LIMIT: u64 = 1 << 28;
/// Events that one call takes at most, so that a flood cannot hold up the servo loop.
const MAX_EVENTS: usize = 1024;

/// What to do about a file that may not be read.
pub(crate) const RIGHTS_REMEDY: &str =
    "add yourself to the group `input` (sudo usermod -aG input $USER) and log in again";

/// The file of the pen: the given one, or the first pen that the system has.
pub(crate) fn find_file(given: Option<&str>) -> Result<PathBuf, Fault> {
    if let Some(path) = given {
        return Ok(PathBuf::from(path));
    }
    if cfg!(not(target_os = "linux")) {
        return Err(Fault::unsupported(
            "pens are read from evdev, which Linux has; `device` may name a recording of one",
        ));
    }
    let found = find::pens(Path::new(find::CLASS), Path::new(find::FILES)).into_iter().next();
    let none = || Fault::io(format!("no input device in {} is a pen; connect a tablet, or give `device`", find::CLASS));
    found.map(|pen| pen.path).ok_or_else(none)
}

/// What went wrong with a file, and what to do.
pub(crate) fn cannot_open(path: &Path, error: &std::io::Error) -> Fault {
    let remedy = if error.kind() == ErrorKind::PermissionDenied { format!("; {RIGHTS_REMEDY}") } else { String::new() };
    Fault::io(format!("{}: {error}{remedy}", path.display()))
}

impl Source {
    /// Opens a file; gives the axes of a device, which are absent for one that has no position, and `None` for a recording or a pipe.
    ///
    /// # Errors
    /// A file that cannot be opened, and a recording that is cut off, too large or has no events.
    pub fn open(path: &Path) -> Result<(Self, Option<Axes>), Fault> {
        let failed = |error: std::io::Error| cannot_open(path, &error);
        let kind = path.metadata().map_err(failed)?.file_type();
        if kind.is_file() {
            return RecordedEvents::read(path).map(|events| (Self::Recorded(events), None));
        }
        let file = open_without_waiting(path).map_err(failed)?;
        let axes = axes_of(&file).or(is_device(kind).then(Axes::default));
        Ok((Self::Live(LiveEvents { file, path: path.to_path_buf(), part: [0; BYTES], count: 0 }), axes))
    }

    /// Gives the state what has happened up to `time_ns` since the device was opened.
    ///
    /// # Errors
    /// The device was taken away.
    pub fn advance(&mut self, state: &mut PenState, time_ns: u64) -> Result<(), Fault> {
        match self {
            Self::Live(live) => live.advance(state),
            Self::Recorded(recorded) => {
                recorded.advance(state, time_ns);
                Ok(())
            }
        }
    }
}

impl LiveEvents {
    fn advance(&mut self, state: &mut PenState) -> Result<(), Fault> {
        for _ in 0..MAX_EVENTS {
            match self.file.read(&mut self.part[self.count..]) {
                // The writer of a pipe has gone, or has not come yet.
                Ok(0) => {
                    state.leave();
                    self.count = 0;
                    return Ok(());
                }
                Ok(count) => self.count += count,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    let text =
                        format!("{}: {error}; the pen no longer answers: was it unplugged?", self.path.display());
                    return Err(Fault::io(text));
                }
            }
            if self.count == BYTES {
                self.count = 0;
                state.take(Event::read(&self.part));
            }
        }
        Ok(())
    }
}

impl RecordedEvents {
    fn read(path: &Path) -> Result<Self, Fault> {
        let failed = |error: std::io::Error| cannot_open(path, &error);
        let wrong = |what: String| Fault::io(format!("{}: {what}", path.display()));
        let mut bytes = Vec::new();
        File::open(path).map_err(failed)?.take(RECORDING_LIMIT + 1).read_to_end(&mut bytes).map_err(failed)?;
        if bytes.len() as u64 > RECORDING_LIMIT {
            return Err(wrong(format!("more than {RECORDING_LIMIT} bytes; allowed is a recording of that size")));
        }
        let (whole, rest) = bytes.as_chunks::<BYTES>();
        if whole.is_empty() || !rest.is_empty() {
            return Err(wrong(format!(
                "{} bytes; allowed are whole events of {BYTES} bytes, as `cat /dev/input/eventN` gives them",
                bytes.len()
            )));
        }
        let events: Vec<Event> = whole.iter().map(Event::read).collect();
        if !events.iter().any(|event| event.kind == EV_SYN && event.code == SYN_REPORT) {
            return Err(wrong("no frame of events ends in it; allowed is what `cat /dev/input/eventN` gives".into()));
        }
        Ok(Self { events, next: 0 })
    }

    fn advance(&mut self, state: &mut PenState, time_ns: u64) {
        let first = self.events.first().map_or(0, |event| event.time_ns);
        while let Some(event) = self.events.get(self.next) {
            if event.time_ns.saturating_sub(first) > time_ns {
                return;
            }
            state.take(*event);
            self.next += 1;
        }
        state.leave();
    }
}

/// Opens a file for reading; neither this nor reading it waits, as for somebody who writes to a pipe.
#[cfg(target_os = "linux")]
pub(crate) fn open_without_waiting(path: &Path) -> std::io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    Ok(rustix::fs::open(path, OFlags::RDONLY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?.into())
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn open_without_waiting(_: &Path) -> std::io::Result<File> {
    Err(std::io::Error::new(ErrorKind::Unsupported, "pens are read from evdev, which only Linux has"))
}

#[cfg(target_os = "linux")]
fn axes_of(file: &File) -> Option<Axes> {
    Axes::of_device(file)
}

#[cfg(target_os = "linux")]
fn is_device(kind: FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_char_device()
}

#[cfg(not(target_os = "linux"))]
fn is_device(_: FileType) -> bool {
    false
}

#[cfg(not(target_os = "linux"))]
fn axes_of(_: &File) -> Option<Axes> {
    None
}
