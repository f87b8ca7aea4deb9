//! `pliant run`.

use crate::args::{Cli, RunArgs};
use crate::child::{Ended, wait};
use crate::live::live;
use crate::open::open;
use crate::outcome::{Failure, Outcome};
use crate::text;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pliant_record::{CutSummary, Recorder, RecordingInputs, RecordingWriter, Summary};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

pub fn run(cli: &Cli, args: &RunArgs) -> Result<Outcome, Failure> {
    if args.isolate {
        return isolated();
    }
    if args.live {
        return live(cli, args);
    }
    let began = Instant::now();
    let (scene, source, mut session) = open(cli, &args.scene)?;
    let folder = args.out.clone().unwrap_or_else(|| default_folder(&args.scene.scene));
    let stop = stop_flag();
    let mut recorder = Recorder::new(&scene, &source, &session, &folder, began)?;
    let mut recording = match &args.record {
        Some(path) => {
            let mesh = args.scene.mesh.as_deref();
            let inputs = RecordingInputs { scene: &scene, source: &source, session: &session, mesh, live: false };
            Some(RecordingWriter::create(path, &inputs)?)
        }
        None => None,
    };
    let steps = scene.time.steps();
    let bar = bar(steps, args.quiet || cli.json);
    let mut stopped = false;
    while session.steps() < steps {
        session.step();
        stopped = stop.load(Ordering::Relaxed);
        let last = session.steps() == steps || stopped;
        if let Some(recording) = &mut recording {
            recording.step(&session, session.frame().tools.iter().map(|felt| felt.device_force))?;
        }
        recorder.step(&mut session, last)?;
        bar.inc(1);
        if stopped {
            break;
        }
    }
    bar.finish_and_clear();
    if let Some(recording) = recording {
        recording.finish()?;
    }
    let summary = recorder.finish(&mut session, stopped)?;
    if cli.json {
        text::out(&crate::pretty(&summary))?;
    } else if !args.quiet {
        tell(&summary, &folder);
    }
    Ok(outcome(&summary, stopped))
}

/// What a run whose results are written comes to.
pub fn outcome(summary: &Summary, stopped: bool) -> Outcome {
    match summary {
        _ if stopped => Outcome::Stopped,
        s if s.plugin_failed() => Outcome::Plugin,
        s if !s.passed() => Outcome::CheckFailed,
        _ => Outcome::Done,
    }
}

/// Says that Ctrl-C was pressed. Without a handler it ends the program at once; half-written files have names of their own
/// either way.
pub fn stop_flag() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&stop);
    let _ = ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed));
    stop
}

/// The same run in a child, whose death is an error and not ours.
fn isolated() -> Result<Outcome, Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(std::env::args_os().skip(1).filter(|argument| argument != "--isolate"));
    // Ctrl-C reaches the child too; this process waits for what it makes of it.
    let _ = ctrlc::set_handler(|| {});
    match wait(&mut command, None) {
        Ended::Code(0, ..) => Ok(Outcome::Done),
        Ended::Code(1, ..) => Ok(Outcome::CheckFailed),
        Ended::Code(2, ..) => Ok(Outcome::Input),
        Ended::Code(3, ..) => Ok(Outcome::Plugin),
        Ended::Code(130, ..) => Ok(Outcome::Stopped),
        ended => Err(Failure::plugin(format!("{ended}: a plugin of the scene crashed; no results were written"))),
    }
}

pub fn default_folder(scene: &Path) -> PathBuf {
    Path::new("out").join(scene.file_stem().unwrap_or_default())
}

pub fn bar(steps: u64, quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} steps  {elapsed} gone, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(steps).with_style(style);
    bar.set_draw_target(if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) });
    bar
}

/// The summary as a person reads it.
pub fn tell(summary: &Summary, folder: &Path) {
    let c = &summary.choices;
    let substeps = if c.substeps > 1 { format!(" with {} substeps", c.substeps) } else { String::new() };
    text::note(&format!(
        "{} steps of {} with {}{substeps}, at most {} nodes and {} elements active",
        summary.steps,
        text::seconds(summary.dt),
        c.integrator,
        summary.most_nodes,
        summary.most_elements
    ));
    if let Some(s) = &summary.step_seconds {
        let [p50, p99, max] = [s.p50, s.p99, s.max].map(text::seconds);
        text::note(&format!("a step took {p50} (p99 {p99}, most {max}); all {}", text::seconds(summary.wall_seconds)));
    }
    if let Some(cut) = &summary.cut {
        let (CutSummary { advances, area, length, .. }, seconds) = (cut, &cut.seconds);
        let [p50, max] = [seconds.p50, seconds.max].map(text::seconds);
        text::note(&format!(
            "cut {area:.3e} m^2 and {length:.3e} m of edge in {advances} advances of {p50} (most {max})"
        ));
    }
    if let Some(live) = &summary.live {
        crate::live::tell(live);
    }
    let contact = summary.contact_steps as f64 * summary.dt;
    text::note(&format!("in contact for {}, largest force {:.4} N", text::seconds(contact), summary.largest_force));
    for p in &summary.probes {
        let verdict = match (p.expected, p.error, p.passed) {
            (Some(expected), Some(error), Some(passed)) => {
                let word = if passed { "ok" } else { "FAILED" };
                let tolerance = p.tolerance.unwrap_or_default();
                format!(", expected {expected:.6e}: error {error:.2e} of {tolerance:.0e} allowed, {word}")
            }
            _ => String::new(),
        };
        text::note(&format!("probe {}: {:.6e} at {:.4} s{verdict}", p.name, p.value, p.time));
    }
    for (kind, count) in &summary.event_counts {
        text::note(&format!("event {}: {count}", crate::pretty(kind).trim_matches('"')));
    }
    for event in summary.events.iter().take(6) {
        text::note(&format!("  at {:.4} s: {}", event.time, event.text));
    }
    if let Some(growth) = summary.growth {
        text::note(&format!("energy grew by a factor of {growth:.4} a step"));
    }
    let folder = if summary.interrupted { folder.join("interrupted") } else { folder.to_path_buf() };
    let state = if summary.interrupted { "stopped; what was done is in" } else { "results are in" };
    text::note(&format!("{state} {}", folder.display()));
}
