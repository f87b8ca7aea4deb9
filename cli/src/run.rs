//! `pliant run`.

use crate::args::{Cli, RunArgs};
use crate::child::{ChildEnd, run_to_end};
use crate::live::run_live;
use crate::outcome::{Failure, Outcome};
use crate::output::progress_bar;
use crate::run_end::{print_summary, run_outcome, stop_flag};
use crate::scene_session::{OpenedScene, open_scene};
use pliant_record::{Recorder, RecordingInputs, RecordingWriter};
use std::process::Command;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Runs a scene, in a process of its own or in real time if asked for.
pub fn run(cli: &Cli, args: &RunArgs) -> Result<Outcome, Failure> {
    if args.isolate {
        return run_isolated();
    }
    if args.live {
        return run_live(cli, args);
    }
    let began = Instant::now();
    let OpenedScene { scene, source, mut session } = open_scene(cli, &args.scene)?;
    let folder = args.out_folder();
    let stop = stop_flag();
    let mut recorder = Recorder::new(&scene, &source, &session, &folder, began)?;
    let mesh = args.scene.mesh.as_deref();
    let inputs = RecordingInputs { scene: &scene, source: &source, session: &session, mesh, live: false };
    let mut recording = args.record.as_ref().map(|path| RecordingWriter::create(path, &inputs)).transpose()?;
    let steps = scene.time.steps();
    let bar = progress_bar("{bar:30} {pos}/{len} steps  {elapsed} gone, {eta} left", steps, args.quiet || cli.json);
    let mut stopped = false;
    while session.steps() < steps && !stopped {
        session.step();
        stopped = stop.load(Ordering::Relaxed);
        let last = session.steps() == steps || stopped;
        if let Some(recording) = &mut recording {
            recording.step(&session, session.frame().tools.iter().map(|felt| felt.device_force))?;
        }
        recorder.step(&mut session, last)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    recording.map(RecordingWriter::finish).transpose()?;
    let summary = recorder.finish(&mut session, stopped)?;
    print_summary(&summary, &folder, cli.json, args.quiet)?;
    Ok(run_outcome(&summary))
}

/// Runs the same command in a child process, so that a plugin that crashes ends the child only.
fn run_isolated() -> Result<Outcome, Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(std::env::args_os().skip(1).filter(|argument| argument != "--isolate"));
    // Ctrl-C reaches the child too; this process waits for the child to end.
    let _ = ctrlc::set_handler(|| {});
    let end = run_to_end(&mut command, None);
    let outcome = match &end {
        ChildEnd::Exited { code, .. } => Outcome::from_exit_code(*code),
        ChildEnd::Signalled(_) | ChildEnd::TimedOut(_) | ChildEnd::NotStarted(_) => None,
    };
    outcome.ok_or_else(|| Failure::plugin(format!("{end}: a plugin of the scene crashed; no results were written")))
}
