//! `pliant batch SWEEP`.

use super::out_folder;
use super::table::write_table;
use crate::args::{BatchRunArgs, Cli};
use crate::outcome::{Failure, Outcome};
use crate::output::{count, format_seconds, note, print, print_json, progress_bar, set_message};
use crate::search::search_path;
use crate::stop::stop_flag;
use pliant_batch::{
    BatchEnd, CollectOptions, Estimate, Isolation, Progress, RunOptions, Shard, Sweep, collect, estimate, limit_memory,
    run, serve,
};
use pliant_engine::memory::{MemoryBudget, format_bytes};
use pliant_record::check_replaceable;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Time from one line of progress to the next, where standard error is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(30);

/// Runs a sweep or a shard of it, prints an estimate of its cost, or runs single edits as a child of such a run.
pub fn run_sweep(cli: &Cli, args: &BatchRunArgs, file: &Path) -> Result<Outcome, Failure> {
    let sweep = Sweep::read(file)?;
    let folder = out_folder(args.out.as_ref(), file);
    let mut options = RunOptions {
        shard: args.shard,
        jobs: args.jobs,
        oversubscribe: args.oversubscribe,
        memory: args.memory.unwrap_or_default(),
        resume: args.resume,
        retry_failed: args.retry_failed,
        isolate: args.isolate,
        ..RunOptions::new(search_path(cli)?)
    };
    if args.child {
        return serve_edits(&sweep, &folder, &options);
    }
    if args.dry_run {
        return dry_run(cli, &sweep, &options);
    }
    let table = folder.join("results.csv");
    check_replaceable(&table)?;
    options.isolation = Some(Isolation::new(child_command()?));
    options.stop = stop_flag();
    let title = sweep.title.clone();
    let mut progress = ProgressLine::new(args.quiet || cli.json);
    let end = run(sweep, &folder, options, &mut |now| progress.show(now))?;
    progress.finish();
    let whole = args.shard == Shard::default() && !end.stopped;
    if whole {
        let mut collected = collect(std::slice::from_ref(&folder), CollectOptions::default())?;
        write_table(&mut collected.table, &table)?;
    }
    if cli.json {
        print_json(&end)?;
    } else if !args.quiet {
        note_end(&end, &title, args.shard, &folder, whole, args.memory.unwrap_or_default());
    }
    Ok(match &end {
        end if end.stopped => Outcome::Stopped,
        end if end.failed > 0 => Outcome::CheckFailed,
        _ => Outcome::Done,
    })
}

/// Runs the edits named on standard input, within the memory limit of the sweep. The parent handles Ctrl-C and then closes this input.
fn serve_edits(sweep: &Sweep, folder: &Path, options: &RunOptions) -> Result<Outcome, Failure> {
    let _ = ctrlc::set_handler(|| {});
    #[cfg(unix)]
    pliant_host::end_with_parent(std::os::unix::process::parent_id());
    if let Some(bytes) = sweep.limits.memory {
        limit_memory(bytes)?;
    }
    serve(sweep, folder, options, io::stdin().lock(), &mut io::stdout().lock())?;
    Ok(Outcome::Done)
}

/// Makes commands that start this program as a child, with the arguments it was given.
fn child_command() -> io::Result<impl Fn() -> Command + Send + Sync + 'static> {
    let program = std::env::current_exe()?;
    let args: Vec<OsString> = std::env::args_os().skip(1).collect();
    Ok(move || {
        let mut command = Command::new(&program);
        command.args(&args).arg("--child");
        command
    })
}

/// Prints the estimated time, storage and memory of a sweep.
fn dry_run(cli: &Cli, sweep: &Sweep, options: &RunOptions) -> Result<Outcome, Failure> {
    let estimate = estimate(sweep, options)?;
    if cli.json {
        print_json(&estimate)?;
    } else {
        print(&estimate_text(sweep, &estimate, options.shard))?;
    }
    Ok(Outcome::Done)
}

/// The estimate as people read it.
fn estimate_text(sweep: &Sweep, estimate: &Estimate, shard: Shard) -> String {
    let mut lines = vec![match shard.count {
        1 => count(estimate.edits, "edit"),
        _ => format!("{} of {} in shard {shard}", estimate.shard_edits, count(estimate.edits, "edit")),
    }];
    let [open, steps, all] = [estimate.open_seconds, estimate.step_seconds, estimate.seconds].map(format_seconds);
    lines.push(format!(
        "about {all} with {} at a time; each takes {open} to open and {steps} for its steps with a tool in contact (measured on {})",
        estimate.jobs,
        count(estimate.opened, "edit")
    ));
    lines.push(format!("table and journal: about {}", format_bytes(estimate.table_bytes)));
    if sweep.keep.meshes {
        lines.push(format!("meshes: at most {}", format_bytes(estimate.mesh_bytes)));
    }
    lines.push(format!("memory of an edit: about {}", format_bytes(estimate.edit_memory)));
    let columns: Vec<String> = sweep.columns().iter().map(|column| column.header()).collect();
    lines.push(format!("columns: {}", columns.join(", ")));
    lines.extend(estimate.failures.iter().map(|failure| format!("cannot be opened: {failure}")));
    lines.join("\n")
}

/// Progress as a bar, or as a line now and then where nobody would see a bar.
struct ProgressLine {
    bar: indicatif::ProgressBar,
    lines: bool,
    last: Instant,
}

impl ProgressLine {
    fn new(quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal();
        let bar = progress_bar("{bar:30} {pos}/{len} edits  {msg}", 0, quiet || !terminal);
        Self { bar, lines: !quiet && !terminal, last: Instant::now() }
    }

    fn show(&mut self, now: Progress) {
        self.bar.set_length(now.edits);
        self.bar.set_position(now.done);
        let left = now.seconds_left().map_or(String::new(), |left| format!(", {} left", format_duration(left)));
        let text = format!("{:.1}/s, {} failed{left}", now.rate(), now.failed);
        if self.lines && self.last.elapsed() >= LINE_EVERY {
            self.last = Instant::now();
            note(&format!("{} of {}: {text}", now.done, count(now.edits, "edit")));
        }
        set_message(&self.bar, &text);
    }

    fn finish(self) {
        self.bar.finish_and_clear();
    }
}

/// A duration (s) in hours, minutes and seconds.
fn format_duration(seconds: f64) -> String {
    let s = seconds.round() as u64;
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{} min {} s", s / 60, s % 60),
        _ => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}

/// Prints how a run ended for people.
fn note_end(end: &BatchEnd, title: &str, shard: Shard, folder: &Path, whole: bool, memory: MemoryBudget) {
    if !title.is_empty() {
        note(title);
    }
    let of = if shard.count == 1 { String::new() } else { format!(" of shard {shard}") };
    let rate = end.new as f64 / end.elapsed.max(1e-9);
    note(&format!(
        "{} of {}{of} done, {} failed; {} in {}, {rate:.1} a second, {} at a time",
        end.done,
        count(end.edits, "edit"),
        end.failed,
        count(end.new, "new one"),
        format_seconds(end.elapsed),
        end.jobs
    ));
    if let Some(processors) = end.jobs_on_processors {
        note(&format!(
            "warning: {} at a time are asked for and there are {}: no more run side by side. Results are the same; ask for fewer with `--jobs`, or \
             start them all with `--oversubscribe`",
            count(end.jobs_asked as u64, "edit"),
            count(processors as u64, "processor")
        ));
    }
    if let Some(jobs) = end.jobs_in_memory {
        note(&format!(
            "warning: memory allows {} at a time of {}, at about {} each within {memory}: others waited for their turn. Results are the same; allow more \
             with `--memory SIZE`, ask for fewer with `--jobs`, or start them all with `--oversubscribe`",
            count(jobs as u64, "edit"),
            end.jobs,
            format_bytes(end.edit_memory)
        ));
    }
    if end.refused > 0 {
        note(&format!(
            "warning: the system gave threads for {} at a time instead of {}; ask for fewer with `--jobs`, or raise the limit of processes (`ulimit \
             -u`, `pids.max` of a container)",
            count(end.jobs as u64, "edit"),
            end.jobs + end.refused
        ));
    }
    if end.outdated > 0 {
        note(&format!(
            "{} no longer counted: a scene, a file of it, or the program has changed",
            count(end.outdated, "row")
        ));
    }
    if end.abandoned > 0 {
        note(&format!(
            "{} did not return from a plugin and was left behind; --isolate runs edits in processes that can be ended",
            count(end.abandoned as u64, "thread")
        ));
    }
    match whole {
        true => note(&format!("the table is {}", folder.join("results.csv").display())),
        false if end.stopped => note(&format!("go on with --resume; rows so far are in {}", folder.display())),
        false => note(&format!("rows are in {}; merge the shards with `pliant batch collect`", folder.display())),
    }
}
