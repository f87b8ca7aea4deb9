//! `pliant batch SWEEP`.

use super::out_folder;
use super::table::write_table;
use crate::args::{BatchRunArgs, Cli};
use crate::outcome::{Failure, Outcome};
use crate::output::{count, format_seconds, note, print, print_json, progress_bar, set_message};
use crate::search::search_path;
use crate::stop::stop_flag;
use pliant_batch::{
    BatchSummary, CollectOptions, Estimate, Isolation, Progress, RunOptions, Shard, Sweep, collect, estimate,
    limit_memory, run, serve,
};
use pliant_engine::memory::{MemoryBudget, format_bytes};
use pliant_record::check_replaceable;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Time between two lines of progress when standard error is not a terminal: a batch of a day leaves a log of 3000 lines.
const PROGRESS_INTERVAL: Duration = Duration::from_secs(30);

/// Runs a sweep or a shard of it, prints an estimate of its cost, or serves single runs as a child process of such a batch.
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
        return serve_runs(&sweep, &folder, &options);
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
    let summary = run(sweep, &folder, options, &mut |now| progress.show(now))?;
    progress.finish();
    let is_complete = args.shard == Shard::default() && !summary.stopped;
    if is_complete {
        let mut collected = collect(std::slice::from_ref(&folder), CollectOptions::default())?;
        write_table(&mut collected.table, &table)?;
    }
    if cli.json {
        print_json(&summary)?;
    } else if !args.quiet {
        print_summary(&summary, &title, args.shard, &folder, is_complete, args.memory.unwrap_or_default());
    }
    Ok(if summary.stopped {
        Outcome::Stopped
    } else if summary.failed > 0 {
        Outcome::CheckFailed
    } else {
        Outcome::Done
    })
}

/// Executes the runs named on standard input, within the memory limit of the sweep. The parent handles Ctrl-C and then closes this input.
fn serve_runs(sweep: &Sweep, folder: &Path, options: &RunOptions) -> Result<Outcome, Failure> {
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

/// The estimate as readable text.
fn estimate_text(sweep: &Sweep, estimate: &Estimate, shard: Shard) -> String {
    let mut lines = vec![match shard.count {
        1 => count(estimate.edits, "run"),
        _ => format!("{} of {} in shard {shard}", estimate.shard_edits, count(estimate.edits, "run")),
    }];
    let [open, steps, all] = [estimate.open_seconds, estimate.step_seconds, estimate.seconds].map(format_seconds);
    lines.push(format!(
        "about {all} with {} at a time; each: {open} to open, {steps} for all its steps with a tool in contact (measured on {})",
        estimate.jobs,
        count(estimate.opened, "run")
    ));
    lines.push(format!("table and journal: about {}", format_bytes(estimate.table_bytes)));
    if sweep.keep.meshes {
        lines.push(format!("meshes: at most {}", format_bytes(estimate.mesh_bytes)));
    }
    lines.push(format!("memory per run: about {}", format_bytes(estimate.edit_memory)));
    let columns: Vec<String> = sweep.columns().iter().map(|column| column.header()).collect();
    lines.push(format!("columns: {}", columns.join(", ")));
    lines.extend(estimate.failures.iter().map(|failure| format!("cannot be opened: {failure}")));
    lines.join("\n")
}

/// Progress as a bar, or as a log line every [`PROGRESS_INTERVAL`] when standard error is not a terminal.
struct ProgressLine {
    /// Hidden if lines are printed, or nothing.
    bar: indicatif::ProgressBar,
    /// Whether log lines are printed.
    prints_lines: bool,
    /// Time of the last log line, or of the start.
    last_printed: Instant,
}

impl ProgressLine {
    fn new(quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal();
        let bar = progress_bar("{bar:30} {pos}/{len} runs  {msg}", 0, quiet || !terminal);
        Self { bar, prints_lines: !quiet && !terminal, last_printed: Instant::now() }
    }

    fn show(&mut self, now: Progress) {
        self.bar.set_length(now.edits);
        self.bar.set_position(now.done);
        let left = now.seconds_left().map_or(String::new(), |left| format!(", {} left", format_duration(left)));
        let text = format!("{:.1}/s, {} failed{left}", now.rate(), now.failed);
        if self.prints_lines && self.last_printed.elapsed() >= PROGRESS_INTERVAL {
            self.last_printed = Instant::now();
            note(&format!("{} of {}: {text}", now.done, count(now.edits, "run")));
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

/// Prints a readable summary of the finished batch.
fn print_summary(
    summary: &BatchSummary,
    title: &str,
    shard: Shard,
    folder: &Path,
    is_complete: bool,
    memory: MemoryBudget,
) {
    if !title.is_empty() {
        note(title);
    }
    let shard_suffix = if shard.count == 1 { String::new() } else { format!(" of shard {shard}") };
    // The lower bound avoids a division of 0 by 0 if nothing was left to run.
    let rate = summary.new as f64 / summary.elapsed.max(1e-9);
    note(&format!(
        "{} of {}{shard_suffix} done, {} failed; {} in {}, {rate:.1} per second, {} at a time",
        summary.done,
        count(summary.edits, "run"),
        summary.failed,
        count(summary.new, "new one"),
        format_seconds(summary.elapsed),
        summary.jobs
    ));
    if let Some(processors) = summary.jobs_on_processors {
        note(&format!(
            "warning: `--jobs {}` exceeds the {}: {processors} run at a time; results do not depend on it. `--oversubscribe` starts all",
            summary.jobs_asked,
            count(processors as u64, "processor")
        ));
    }
    if let Some(jobs) = summary.jobs_in_memory {
        note(&format!(
            "warning: only {jobs} of {} at a time fit into {memory} of memory at about {} each; the others waited. `--memory SIZE` allows more, \
             `--oversubscribe` starts all",
            count(summary.jobs as u64, "run"),
            format_bytes(summary.edit_memory)
        ));
    }
    if summary.refused > 0 {
        note(&format!(
            "warning: the system refused to start {} of {}; ask for fewer with `--jobs`, or raise the limit of processes (`ulimit -u`, \
             `pids.max` of a container)",
            summary.refused,
            count((summary.jobs + summary.refused) as u64, "worker thread")
        ));
    }
    if summary.outdated > 0 {
        note(&format!(
            "{} out of date and computed again: the scene, one of its files or the program has changed",
            count(summary.outdated, "row")
        ));
    }
    if summary.abandoned > 0 {
        note(&format!(
            "{} abandoned in a plugin call that did not return; with --isolate runs are processes, which can be ended",
            count(summary.abandoned as u64, "thread")
        ));
    }
    let folder_text = folder.display();
    note(&if is_complete {
        format!("the table is {}", folder.join("results.csv").display())
    } else if summary.stopped {
        format!("continue with --resume; rows so far are in {folder_text}")
    } else {
        format!("rows are in {folder_text}; merge the shards with `pliant batch collect`")
    });
}
