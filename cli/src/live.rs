//! `pliant run --live`.

use crate::args::{Cli, RunArgs};
use crate::outcome::{Failure, Outcome};
use crate::output::note_warnings;
use crate::run_end::{print_summary, run_outcome, strict_outcome};
use crate::scene_session::{OpenedScene, open_scene};
use crate::stop::RunStop;
use pliant_live::{LiveSession, LiveSettings};
use pliant_record::{Recorder, RecordingInputs, RecordingWriter, RunOutputs};
use std::time::Instant;

/// Runs a scene in real time with its devices.
pub fn run_live(cli: &Cli, args: &RunArgs) -> Result<Outcome, Failure> {
    let (began, stop) = (Instant::now(), RunStop::new());
    let OpenedScene { scene, source, mut session } = open_scene(cli, &args.scene)?;
    if session.devices.is_empty() {
        return Err(source.whole("nothing to run live: no edit uses a tool, so no device is open").into());
    }
    if let Some(recorded) = scene.device.iter().find_map(|device| device.recording.as_ref()) {
        let text =
            "hands of a recording keep the time of its steps, not that of the clock; allowed is a run without `--live`";
        return Err(source.error(recorded.span(), text).into());
    }
    let noted = session.warnings().len();
    let folder = args.out_folder();
    let outputs = RunOutputs { folder: &folder, recording: args.record.as_deref() };
    let mut recorder = Recorder::new(&scene, &source, &session, outputs, began)?;
    let mesh = args.scene.mesh.as_deref();
    let inputs =
        RecordingInputs { scene: &scene, source: &source, session: &session, mesh, live: true, history: false };
    let mut recording = args.record.as_ref().map(|path| RecordingWriter::create(path, &inputs)).transpose()?;
    let duration = args.duration.unwrap_or(scene.time.duration.get_ref().si);
    stop.attach(&mut session);
    let mut live = LiveSession::start(&mut session, LiveSettings { rate: args.rate, view: None })?;
    let (mut stopped, mut last) = (false, false);
    while !last {
        let samples = live.step(&mut session);
        if session.is_cancelled() {
            stopped = true;
            break;
        }
        if let Some(recording) = &mut recording {
            recording.step(&session, samples.device_forces.iter().copied())?;
        }
        stopped |= stop.is_set();
        last = stopped || !live.is_alive() || live.seconds() >= duration;
        recorder.step(&mut session, last)?;
    }
    // The devices are stopped before anything is written.
    let live_summary = live.finish();
    let panicked = live_summary.panicked;
    recorder.live = Some(live_summary);
    // The results are kept even if the recording cannot be.
    let recorded = recording.map(RecordingWriter::finish).transpose();
    let summary = recorder.finish(&mut session, stopped)?;
    print_summary(&summary, &folder, cli.json, args.quiet)?;
    note_warnings(&summary.warnings[noted.min(summary.warnings.len())..]);
    recorded?;
    if panicked {
        return Err(Failure::plugin("the haptic thread ended by a panic; the devices were stopped"));
    }
    Ok(strict_outcome(run_outcome(&summary), &summary, args.scene.strict))
}
