//! `pliant run`.

use crate::args::{Cli, RunArgs};
use crate::isolate::{is_child, run_isolated};
use crate::live::run_live;
use crate::outcome::{Failure, Outcome};
use crate::output::{note_warnings, progress_bar};
use crate::run_end::{print_summary, run_outcome, strict_outcome};
use crate::scene_session::{OpenedScene, open_scene};
use crate::stop::RunStop;
use pliant_record::{Recorder, RecordingInputs, RecordingWriter, RunOutputs};
use std::time::Instant;

/// Runs a scene, in a process of its own or in real time if asked for.
pub fn run(cli: &Cli, args: &RunArgs) -> Result<Outcome, Failure> {
    if args.isolate && !is_child() {
        return run_isolated(args);
    }
    if args.live {
        return run_live(cli, args);
    }
    let (began, stop) = (Instant::now(), RunStop::new());
    let OpenedScene { scene, source, mut session } = open_scene(cli, &args.scene)?;
    let noted = session.warnings().len();
    let folder = args.out_folder();
    let outputs = RunOutputs { folder: &folder, recording: args.record.as_deref() };
    let mut recorder = Recorder::new(&scene, &source, &session, outputs, began)?;
    let mesh = args.scene.mesh.as_deref();
    let inputs =
        RecordingInputs { scene: &scene, source: &source, session: &session, mesh, live: false, history: false };
    let mut recording = args.record.as_ref().map(|path| RecordingWriter::create(path, &inputs)).transpose()?;
    let steps = scene.time.steps();
    let bar = progress_bar("{bar:30} {pos}/{len} steps  {elapsed} gone, {eta} left", steps, args.quiet || cli.json);
    let mut stopped = false;
    stop.attach(&mut session);
    while session.steps() < steps && !stopped {
        session.step();
        stopped = stop.is_set();
        if session.is_cancelled() {
            break;
        }
        let last = session.steps() == steps || stopped;
        if let Some(recording) = &mut recording {
            recording.step(&session, session.frame().tools.iter().map(|felt| felt.device_force))?;
        }
        recorder.step(&mut session, last)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    // Before anything is written.
    session.stop_devices();
    // The results are kept even if the recording cannot be.
    let recorded = recording.map(RecordingWriter::finish).transpose();
    let summary = recorder.finish(&mut session, stopped)?;
    print_summary(&summary, &folder, cli.json, args.quiet)?;
    note_warnings(&summary.warnings[noted.min(summary.warnings.len())..]);
    recorded?;
    Ok(strict_outcome(run_outcome(&summary), &summary, args.scene.strict))
}
