//! `pliant replay`.

use crate::args::{Cli, ReplayArgs};
use crate::outcome::{Failure, Outcome};
use crate::run::{bar, outcome, stop_flag, tell};
use crate::text;
use pliant_engine::plan::Plan;
use pliant_engine::scene::{self, Scene, Source};
use pliant_engine::session::{Options, Session};
use pliant_host::SearchPath;
use pliant_record::{Recorder, Recording, state_digest};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

pub fn replay(cli: &Cli, args: &ReplayArgs) -> Result<Outcome, Failure> {
    let began = Instant::now();
    let recording = Recording::read(&args.recording)?;
    if let Some((file, how)) = recording.changed_files().find(|(file, _)| !file.plugin) {
        let path = (args.recording.display(), file.path.display());
        return Err(Failure::input(format!("{}: model {} {how} since it was recorded", path.0, path.1)));
    }
    let (scene, source, mut session) = open(cli, args, &recording)?;
    let folder = args.out.clone().unwrap_or_else(|| {
        Path::new("out").join(args.recording.file_stem().unwrap_or_default()).with_extension("replay")
    });
    let mut recorder = Recorder::new(&scene, &source, &session, &folder, began)?;
    let bar = bar(recording.steps.len() as u64, args.quiet || cli.json);
    let stop = stop_flag();
    let (mut stopped, mut different) = (false, None);
    for (number, step) in recording.steps.iter().enumerate() {
        session.step_with(&step.poses);
        if args.set.is_empty() {
            session.tell_given(&step.device_forces);
        }
        stopped = stop.load(Ordering::Relaxed);
        if args.verify && different.is_none() && state_digest(&session) != step.digest {
            different = Some(session.time());
        }
        recorder.step(&mut session, stopped || number + 1 == recording.steps.len())?;
        bar.inc(1);
        if stopped {
            break;
        }
    }
    bar.finish_and_clear();
    let summary = recorder.finish(&mut session, stopped)?;
    if cli.json {
        text::out(&crate::pretty(&summary))?;
    } else if !args.quiet {
        tell(&summary, &folder);
    }
    if let Some(time) = different {
        text::note(&format!("not the same: the state differs from the recorded one at {time:.4} s"));
        for (file, how) in recording.changed_files() {
            text::note(&format!("  plugin {} {how} since it was recorded", file.path.display()));
        }
        return Ok(Outcome::CheckFailed);
    }
    if args.verify && !stopped && !args.quiet {
        text::note(&format!("the same state, to the bit, after each of {} steps", recording.steps.len()));
    }
    Ok(outcome(&summary, stopped))
}

fn open(cli: &Cli, args: &ReplayArgs, recording: &Recording) -> Result<(Scene, Source, Session), Failure> {
    let header = &recording.header;
    let (recorded, _) = scene::load_text(&header.scene, header.text.clone(), &[])?;
    let (scene, source) = scene::load_text(&header.scene, header.text.clone(), &args.set)?;
    let (was, now) = (recorded.time.dt.get_ref().si, scene.time.dt.get_ref().si);
    if was != now {
        let span = scene.time.dt.span();
        let text = format!("dt {now} s; allowed is {was} s, the time between two recorded samples of the hand");
        return Err(source.error(span, text).into());
    }
    let plan = Plan::new(&scene, &source)?;
    let options = Options {
        search: SearchPath::new(&cli.plugin_path),
        threads: args.threads,
        mesh: header.mesh.clone(),
        recorded: Some(recording.devices.clone()),
    };
    let mut session = Session::open(&scene, &source, plan, &options)?;
    let order = session.devices.iter().map(|slot| &slot.name);
    if !order.eq(recording.devices.iter().map(|(name, _)| name)) {
        return Err(Failure::input(format!(
            "{}: the scene now uses other devices than the recorded {:?}",
            args.recording.display(),
            recording.devices.iter().map(|(name, _)| name).collect::<Vec<_>>()
        )));
    }
    // Another material takes another time: the clock is asked again only where nothing was set.
    if args.set.is_empty() {
        session.repeat_lapses(recording.lapses.clone());
    }
    if header.live {
        session.lead_tips();
    }
    Ok((scene, source, session))
}
