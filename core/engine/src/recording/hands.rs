//! Hands of a recording in the place of a device: a scene's `[[device]]` with `recording` has them.
//!
//! The poses go by the number of the step and not by time, so the scene's step must be that of the recording. Then the same scene gives the same
//! bytes as the recorded session.

use super::read::{Recording, RecordingError};
use crate::scene;
use crate::session::SessionCommand;
use pliant_host::{DeviceInfo, Pose};
use std::path::{Path, PathBuf};

/// Hands and commands of a recording by the number of a step.
pub struct RecordedHands {
    /// Path of the recording.
    path: PathBuf,
    /// The recording as it was read.
    recording: Recording,
    /// Step of the recorded session, s.
    dt: f64,
    /// Number of steps before each of the recording's [`steps`](Recording::steps), and before its end.
    starts: Vec<u64>,
}

impl RecordedHands {
    /// Reads the recording at `path`.
    ///
    /// # Errors
    /// Fails for a file that is not a recording this program can replay.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let recording = Recording::read(path)?;
        let (recorded, _) = scene::load_text(&recording.header.scene, recording.header.text.clone(), &[])
            .map_err(|error| RecordingError::new(path, format!("its scene cannot be read: {error}")))?;
        let mut starts = vec![0];
        for step in &recording.steps {
            starts.push(starts[starts.len() - 1] + u64::from(step.count));
        }
        Ok(Self { path: path.to_path_buf(), recording, dt: recorded.time.dt.get_ref().si, starts })
    }

    /// Path of the recording.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Step of the recorded session, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Names and descriptions of the recorded devices.
    pub fn devices(&self) -> &[(String, DeviceInfo)] {
        &self.recording.devices
    }

    /// Whether the recorded session undoes or redoes edits.
    pub fn has_undo(&self) -> bool {
        let commands = self.recording.steps.iter().flat_map(|step| &step.commands);
        commands.into_iter().any(|command| matches!(command, SessionCommand::Undo | SessionCommand::Redo))
    }

    /// Poses of the device with this index in step `step`, from 0; empty after the end of the recording, when all hands are absent.
    pub fn poses(&self, device: usize, step: u64) -> &[Pose] {
        let after = self.starts.partition_point(|start| *start <= step);
        self.recording.steps.get(after - 1).map_or(&[], |recorded| &recorded.poses[device])
    }

    /// Commands before step `step`, from 0.
    pub fn commands(&self, step: u64) -> &[SessionCommand] {
        let place = self.starts.binary_search(&step).ok();
        place.and_then(|place| self.recording.steps.get(place)).map_or(&[], |recorded| &recorded.commands)
    }
}
