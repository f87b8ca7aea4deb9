//! Makes a report: measures, writes, compares with a baseline, prints.

use super::catalogues::{ACCURACY, CatalogueFiles, PERFORMANCE, STABILITY};
use crate::args::{AccuracyArgs, Cli, ReportCommand, ReportOptionArgs};
use crate::call_watchdog::CallWatchdog;
use crate::outcome::{Failure, Outcome};
use crate::output::{note, print, print_json, progress_bar, set_message};
use crate::search::search_path;
use crate::stop::stop_flag;
use pliant_engine::session::{CancelToken, processors};
use pliant_mesh::read::read_text;
use pliant_report::{
    AccuracyCatalogue, Clock, Comparison, Document, Journal, Measurements, PerformanceCatalogue, Progress,
    ReportBuilder, ReportContext, ReportKind, ReportOptions, Row, SceneInput, StabilityCatalogue, accuracy,
    check_report_folder, compare, markdown, performance, self_convergence, stability, write_report,
};
use std::path::{Path, PathBuf};

/// Arguments that do not change what is measured: a report is resumed whatever they are.
const OUTPUT_ARGUMENTS: [&str; 5] = ["--json", "--markdown", "--fresh", "-q", "--quiet"];

/// Makes a report of any kind.
pub fn report(cli: &Cli, command: &ReportCommand) -> Result<Outcome, Failure> {
    let (kind, args) = match command {
        ReportCommand::Accuracy(args) => (ReportKind::Accuracy, &args.options),
        ReportCommand::Stability(args) => (ReportKind::Stability, args),
        ReportCommand::Performance(args) => (ReportKind::Performance, args),
    };
    if args.print_catalogue {
        let catalogue = match kind {
            ReportKind::Accuracy => ACCURACY,
            ReportKind::Stability => STABILITY,
            ReportKind::Performance => PERFORMANCE,
        };
        print(catalogue.trim_end())?;
        return Ok(Outcome::Done);
    }
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("report-{}", kind.name())));
    let baseline = args.baseline.as_deref().map(read_baseline).transpose()?;
    check_report_folder(&folder)?;
    let mut journal = open_journal(&folder, args.fresh)?;
    let stop = stop_flag();
    let bar = progress_bar("{bar:24} {pos}/{len} runs  {elapsed} gone, {eta} left  {msg}", 1, args.quiet || cli.json);
    if journal.resumed > 0 && !args.quiet {
        bar.suspend(|| note(&format!("resuming with {} results of a report that was stopped", journal.resumed)));
    }
    let mut progress = |progress: Progress<'_>| {
        bar.set_length(progress.total as u64);
        bar.set_position(progress.done as u64);
        set_message(&bar, progress.what);
    };
    let _watchdog = CallWatchdog::start(args.call_limit, "the report was ended; the same command resumes it");
    let mut context = ReportContext::new(options(cli, args)?, &mut progress, CancelToken::from(stop));
    let builder = ReportBuilder::start(&context);
    let measurements = match command {
        ReportCommand::Accuracy(args) => measure_accuracy(args, &mut context, &mut journal)?,
        ReportCommand::Stability(args) => measure_stability(args, &folder, &mut context, &mut journal)?,
        ReportCommand::Performance(args) => measure_performance(args, &mut context, &mut journal)?,
    };
    let asked = std::env::args().skip(1).filter(|a| a != "--json" && a != "--markdown").collect();
    let document = builder.finish(kind, &context, asked, measurements);
    bar.finish_and_clear();
    let folder = if document.interrupted { folder.join("interrupted") } else { folder };
    let files = write_report(&document, &folder)?;
    if !document.interrupted {
        journal.finish();
    }
    let comparison = baseline.map(|rows| compare(&rows, &document.rows, args.margin));
    if cli.json {
        print_json(&document_json(&document, comparison.as_ref(), args.margin)?)?;
    } else if args.markdown {
        print(&markdown(&document))?;
    }
    if !args.quiet && !cli.json {
        note_verdict(&document, comparison.as_ref(), &files.page);
    }
    Ok(match comparison {
        _ if document.interrupted => Outcome::Stopped,
        Some(comparison) if !comparison.regressions.is_empty() => Outcome::CheckFailed,
        _ if args.strict && !document.verdict.good => Outcome::CheckFailed,
        _ => Outcome::Done,
    })
}

/// The options of a report.
fn options(cli: &Cli, args: &ReportOptionArgs) -> Result<ReportOptions, Failure> {
    let threads = match (args.threads, processors()) {
        (0, processors) => processors,
        (asked, processors) if asked > processors => {
            note(&format!(
                "warning: `--threads {asked}` exceeds the {processors} processors: the report runs on {processors}; 0 uses all"
            ));
            processors
        }
        (asked, _) => asked,
    };
    Ok(ReportOptions {
        search: search_path(cli)?,
        threads,
        quick: args.quick,
        cases: args.case.clone(),
        seed: args.seed,
        clock: Clock::default(),
    })
}

/// Cases with known answers, or a scene against its own refined solution.
fn measure_accuracy(
    args: &AccuracyArgs,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Result<Measurements, Failure> {
    if let Some(path) = &args.scene {
        let text = read_text(path).map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
        return Ok(self_convergence(SceneInput { path, text: &text, settings: &args.set }, context, journal)?);
    }
    let files = CatalogueFiles::read(args.options.catalogue.as_deref(), ACCURACY)?;
    let catalogue = AccuracyCatalogue::parse(&files.catalogue).map_err(Failure::input)?;
    require_cases(&args.options.case, &catalogue.case_names())?;
    Ok(accuracy(&catalogue, &|name| files.scene(name), context, journal))
}

/// The stability report.
fn measure_stability(
    args: &ReportOptionArgs,
    folder: &Path,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Result<Measurements, Failure> {
    let files = CatalogueFiles::read(args.catalogue.as_deref(), STABILITY)?;
    let catalogue = StabilityCatalogue::parse(&files.catalogue).map_err(Failure::input)?;
    require_cases(&args.case, &catalogue.case_names())?;
    Ok(stability(&catalogue, &|name| files.scene(name), folder, context, journal)?)
}

/// The performance report.
fn measure_performance(
    args: &ReportOptionArgs,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Result<Measurements, Failure> {
    let files = CatalogueFiles::read(args.catalogue.as_deref(), PERFORMANCE)?;
    let catalogue = PerformanceCatalogue::parse(&files.catalogue).map_err(Failure::input)?;
    require_cases(&args.case, &catalogue.case_names())?;
    let program = std::env::current_exe().ok();
    Ok(performance(&catalogue, &|name| files.scene(name), program.as_deref(), context, journal))
}

/// Refuses a `--case` that no case of the catalogue has in its name.
fn require_cases(wanted: &[String], names: &[String]) -> Result<(), Failure> {
    match wanted.iter().find(|wanted| !names.iter().any(|name| name.contains(wanted.as_str()))) {
        Some(unknown) => Err(Failure::input(format!(
            "--case {unknown}: no case has this in its name; allowed is a part of {}",
            names.join(", ")
        ))),
        None => Ok(()),
    }
}

/// The rows of an older report.
fn read_baseline(path: &Path) -> Result<Vec<Row>, Failure> {
    let wrong = |why: String| Failure::input(format!("--baseline {}: {why}; allowed is a report.json", path.display()));
    let text = read_text(path).map_err(|e| wrong(e.to_string()))?;
    let mut value: serde_json::Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    serde_json::from_value(value["rows"].take()).map_err(|e| wrong(e.to_string()))
}

/// The journal of this command in the folder of the report. A report that was stopped is resumed unless `fresh`.
fn open_journal(folder: &Path, fresh: bool) -> Result<Journal, Failure> {
    let path: PathBuf = folder.join("journal.jsonl");
    if fresh {
        let _ = std::fs::remove_file(&path);
    }
    let command: Vec<String> = std::env::args().skip(1).filter(|a| !OUTPUT_ARGUMENTS.contains(&a.as_str())).collect();
    let settings = serde_json::json!({ "program": env!("CARGO_PKG_VERSION"), "command": command }).to_string();
    Journal::open(&path, &settings).map_err(|e| Failure::input(format!("{}: {e}", path.display())))
}

/// The report as JSON, with the comparison if there is one.
fn document_json(
    document: &Document,
    comparison: Option<&Comparison>,
    margin: f64,
) -> Result<serde_json::Value, Failure> {
    let mut value = serde_json::to_value(document).map_err(Failure::input)?;
    if let Some(Comparison { compared, regressions }) = comparison {
        value["baseline"] = serde_json::json!({ "compared": compared, "margin": margin, "regressions": regressions });
    }
    Ok(value)
}

/// Prints the verdict for people.
fn note_verdict(document: &Document, comparison: Option<&Comparison>, page: &Path) {
    let v = &document.verdict;
    note(&format!("{} of {} judged results meet their criterion", v.passed, v.judged));
    v.failed.iter().for_each(|m| note(&format!("  failed: {m}")));
    if let Some(Comparison { compared, regressions }) = comparison {
        note(&format!("{compared} results compared with the baseline, {} got worse", regressions.len()));
        for r in regressions {
            note(&format!("  worse: {}: {} was {:.3e}, is {:.3e}", r.row, r.what, r.before, r.now));
        }
    }
    let state = if document.interrupted { "stopped; results so far are in" } else { "the report is" };
    note(&format!("{state} {}", page.display()));
}
