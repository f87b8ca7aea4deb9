//! `pliant replay`.

use crate::args::{Cli, ReplayArgs};
use crate::outcome::{Failure, Outcome};
use crate::output::{count, note, note_warnings, progress_bar};
use crate::run_end::{print_summary, run_outcome};
use crate::scene_session::OpenedScene;
use crate::search::search_path;
use crate::stop::RunStop;
use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session};
use pliant_record::{Recorder, Recording, state_digest};
use std::path::Path;
use std::time::Instant;

/// Runs a recorded session again, and compares it with the recording if asked for.
pub fn replay(cli: &Cli, args: &ReplayArgs) -> Result<Outcome, Failure> {
    let (began, stop) = (Instant::now(), RunStop::new());
    let recording = Recording::read(&args.recording)?;
    if let Some((file, how)) = recording.changed_files().find(|(file, _)| !file.plugin) {
        let (recording, file) = (args.recording.display(), file.path.display());
        return Err(Failure::input(format!("{recording}: {file} {how} since it was recorded")));
    }
    let OpenedScene { scene, source, mut session } = open_recorded(cli, args, &recording)?;
    let folder = args.out.clone().unwrap_or_else(|| {
        Path::new("out").join(args.recording.file_stem().unwrap_or_default()).with_extension("replay")
    });
    let mut recorder = Recorder::new(&scene, &source, &session, &folder, began)?;
    let steps = recording.step_count();
    let bar = progress_bar("{bar:30} {pos}/{len} steps  {elapsed} gone, {eta} left", steps, args.quiet || cli.json);
    let (mut stopped, mut first_difference) = (false, None);
    stop.attach(&mut session);
    let each = recording.steps.iter().flat_map(|step| (0..step.count).map(move |repeat| (step, repeat)));
    for ((step, repeat), number) in each.zip(1..) {
        if repeat == 0 {
            step.commands.iter().for_each(|command| _ = session.apply(command.clone()));
        }
        session.step_with(&step.poses);
        stopped = stop.is_set();
        if session.is_cancelled() {
            break;
        }
        if args.set.is_empty() {
            session.report_device_forces(&step.device_forces);
        }
        if args.verify && first_difference.is_none() && state_digest(&session) != step.digest {
            first_difference = Some(session.time());
        }
        recorder.step(&mut session, stopped || number == steps)?;
        bar.inc(1);
        if stopped {
            break;
        }
    }
    bar.finish_and_clear();
    let summary = recorder.finish(&mut session, stopped)?;
    print_summary(&summary, &folder, cli.json, args.quiet)?;
    note_warnings(&summary.warnings);
    if let Some(time) = first_difference {
        note(&format!("not the same: the state differs from the recorded one at {time:.4} s"));
        for (file, how) in recording.changed_files() {
            note(&format!("  plugin {} {how} since it was recorded", file.path.display()));
        }
        return Ok(Outcome::CheckFailed);
    }
    if args.verify && !stopped && !args.quiet {
        note(&format!("the same state, to the bit, after each of {}", count(steps, "step")));
    }
    Ok(run_outcome(&summary))
}

/// Opens the recorded scene with the limits of the recorded devices, which are not opened.
fn open_recorded(cli: &Cli, args: &ReplayArgs, recording: &Recording) -> Result<OpenedScene, Failure> {
    let header = &recording.header;
    let (recorded, _) = scene::load_text(&header.scene, header.text.clone(), &recording.settings)?;
    let (scene, source) =
        scene::load_text(&header.scene, header.text.clone(), &[&recording.settings[..], &args.set].concat())?;
    let (was, now) = (recorded.time.dt.get_ref().si, scene.time.dt.get_ref().si);
    if was != now {
        let span = scene.time.dt.span();
        let text = format!("dt {now} s; allowed is {was} s, the time between two recorded samples of the hand");
        return Err(source.error(span, text).into());
    }
    let plan = Plan::new(&scene, &source)?;
    let options = Options {
        oversubscribe: args.oversubscribe,
        mesh: header.mesh.clone(),
        recorded: Some(recording.devices.clone()),
        memory: args.memory.unwrap_or_default(),
        ..Options::new(search_path(cli)?, args.threads)
    };
    let mut session = Session::open(&scene, &source, plan, &options)?;
    let in_use: Vec<&String> = session.devices.iter().map(|slot| &slot.name).collect();
    let known: Vec<&String> = recording.devices.iter().map(|(name, _)| name).collect();
    if in_use != known {
        let path = args.recording.display();
        return Err(Failure::input(format!(
            "{path}: the scene uses devices {in_use:?}; allowed are the recorded {known:?}"
        )));
    }
    // With other settings a step takes another time, so bodies are given up by the clock and not as recorded.
    if args.set.is_empty() {
        session.repeat_timeouts(recording.timeouts.clone());
    }
    if header.live {
        session.drive_tips();
    }
    if header.history {
        session.keep_history();
    }
    Ok(OpenedScene { scene, source, session })
}
