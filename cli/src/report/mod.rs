//! `pliant report`.

mod scenes;

use crate::args::{Cli, ReportArgs, ReportKind};
use crate::outcome::{Failure, Outcome};
use crate::text;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pliant_host::SearchPath;
use pliant_report::{
    Catalogue, Clock, Document, Journal, Kind, Measured, Opened, PerformanceCatalogue, Regression, Row, Setup,
    StabilityCatalogue,
};
use scenes::Source;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub fn report(cli: &Cli, args: &ReportArgs) -> Result<Outcome, Failure> {
    let kind = match args.kind {
        ReportKind::Accuracy => Kind::Accuracy,
        ReportKind::Stability => Kind::Stability,
        ReportKind::Performance => Kind::Performance,
    };
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("report-{}", kind.name())));
    let before = args.baseline.as_deref().map(baseline).transpose()?;
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| a != "--json" && a != "--markdown").collect();
    let mut journal = journal(&folder, &asked, args.fresh)?;
    let stop = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&stop);
    let _ = ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed));
    let bar = bar(args.quiet || cli.json);
    if journal.resumed > 0 && !args.quiet {
        bar.suspend(|| text::note(&format!("going on with {} results of a report that was stopped", journal.resumed)));
    }
    let mut progress = |done: usize, all: usize, what: &str| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
        bar.set_message(what.to_owned());
    };
    let stopped = || stop.load(Ordering::Relaxed);
    let threads = match args.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        given => given,
    };
    let mut setup = Setup {
        search: SearchPath::new(&cli.plugin_path),
        threads,
        quick: args.quick,
        only: args.case.clone(),
        seed: args.seed,
        clock: Clock::default(),
        plugins: Default::default(),
        spent: (0.0, 0.0),
        progress: &mut progress,
        stopped: &stopped,
    };
    let opened = Opened::start(&setup);
    let (rows, sections, not_run) = measure((args, &folder), kind, &mut setup, &mut journal)?;
    let mut document = opened.finish(kind, &setup, asked, rows);
    (document.sections, document.not_run) = (sections, not_run);
    bar.finish_and_clear();
    let interrupted = document.interrupted;
    let into = if interrupted { folder.join("interrupted") } else { folder };
    let written = pliant_report::write(&document, &into)?;
    if !interrupted {
        journal.finish();
    }
    let worse = before.map(|rows| pliant_report::compare(&rows, &document.rows, args.margin));
    if cli.json {
        let mut value = serde_json::to_value(&document).map_err(Failure::input)?;
        if let Some((compared, worse)) = &worse {
            value["baseline"] =
                serde_json::json!({ "compared": compared, "margin": args.margin, "regressions": worse });
        }
        text::out(&crate::pretty(&value))?;
    } else if args.markdown {
        text::out(&pliant_report::markdown(&document))?;
    }
    if !args.quiet && !cli.json {
        tell(&document, worse.as_ref(), &written.page);
    }
    Ok(match worse {
        _ if interrupted => Outcome::Stopped,
        Some((_, worse)) if !worse.is_empty() => Outcome::CheckFailed,
        _ if args.strict && !document.verdict.good => Outcome::CheckFailed,
        _ => Outcome::Done,
    })
}

fn measure(
    (args, folder): (&ReportArgs, &Path),
    kind: Kind,
    setup: &mut Setup<'_>,
    journal: &mut Journal,
) -> Result<Measured, Failure> {
    match (kind, &args.scene) {
        (Kind::Accuracy, Some(path)) => {
            let text = std::fs::read_to_string(path).map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
            Ok(pliant_report::own_scene((path, &text, &args.set), setup, journal)?)
        }
        (_, Some(_)) => Err(Failure::input("--scene: allowed with `report accuracy`")),
        (Kind::Accuracy, None) => {
            let source = Source::new(args.catalogue.as_deref(), scenes::ACCURACY)?;
            let catalogue = Catalogue::read(&source.catalogue).map_err(Failure::input)?;
            asked_for(&setup.only, catalogue.case.iter().map(|c| c.name.as_str()))?;
            let rows = pliant_report::accuracy(&catalogue, &|name| source.scene(name), setup, journal);
            let sections = pliant_report::accuracy_page(&catalogue, &rows);
            Ok((rows, sections, catalogue.not_run))
        }
        (Kind::Stability, None) => {
            let source = Source::new(args.catalogue.as_deref(), scenes::STABILITY)?;
            let catalogue = StabilityCatalogue::read(&source.catalogue).map_err(Failure::input)?;
            let named = catalogue.map.iter().flat_map(|m| [m.name.clone(), format!("limit-{}", m.name)]);
            let named: Vec<String> = named.chain(catalogue.balance.iter().map(|b| b.name.clone())).collect();
            asked_for(&setup.only, named.iter().map(String::as_str).chain(["extreme", "coupling"]))?;
            let rows = pliant_report::stability((&catalogue, folder), &|name| source.scene(name), setup, journal)?;
            let sections = pliant_report::stability_page(&catalogue, &rows);
            Ok((rows, sections, catalogue.not_run))
        }
        (Kind::Performance, None) => {
            let source = Source::new(args.catalogue.as_deref(), scenes::PERFORMANCE)?;
            let catalogue = PerformanceCatalogue::read(&source.catalogue).map_err(Failure::input)?;
            let named = catalogue.pair.iter().map(|p| format!("left-out: {}", p.name));
            let named: Vec<String> = named.chain(catalogue.sweep.iter().map(|s| s.name.clone())).collect();
            asked_for(&setup.only, named.iter().map(String::as_str).chain(["start-up", "haptic-loop"]))?;
            let mut rows = pliant_report::performance(&catalogue, &|name| source.scene(name), setup, journal);
            rows.extend(start_up(setup));
            let sections = pliant_report::performance_page(&catalogue, &rows);
            Ok((rows, sections, catalogue.not_run))
        }
    }
}

/// How long the program itself takes to start and end, doing nothing.
fn start_up(setup: &Setup<'_>) -> Option<Row> {
    let program = std::env::current_exe().ok().filter(|_| setup.wants("start-up"))?;
    let once = || {
        let began = (setup.clock.wall)();
        let ended = Command::new(&program).arg("--version").stdout(Stdio::null()).status();
        ended.is_ok_and(|s| s.success()).then(|| (setup.clock.wall)() - began)
    };
    let seconds: Vec<f64> = (0..9).filter_map(|_| once()).collect();
    let (middle, most) = (pliant_report::median(&seconds), pliant_report::percentile(&seconds, 1.0));
    let spread = (most - pliant_report::percentile(&seconds, 0.0)) / middle;
    let method = "pliant --version".to_owned();
    let row = Row { case: "start-up".into(), method, threads: 1, wall_seconds: middle, ..Row::default() };
    Some(Row { spread: Some(spread), ..row })
}

/// Refuses a name that stands for no case.
fn asked_for<'a>(only: &[String], names: impl Iterator<Item = &'a str>) -> Result<(), Failure> {
    let names: Vec<&str> = names.collect();
    match only.iter().find(|o| !names.iter().any(|n| n.contains(o.as_str()))) {
        Some(none) => {
            Err(Failure::input(format!("--case {none}: no case is called so; allowed is {}", names.join(", "))))
        }
        None => Ok(()),
    }
}

/// The rows of a report of before.
fn baseline(path: &Path) -> Result<Vec<Row>, Failure> {
    let wrong = |why: String| Failure::input(format!("--baseline {}: {why}; allowed is a report.json", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| wrong(e.to_string()))?;
    let mut value: serde_json::Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    serde_json::from_value(value["rows"].take()).map_err(|e| wrong(e.to_string()))
}

/// Goes on with what the same command left behind, if it was stopped.
fn journal(folder: &Path, asked: &[String], fresh: bool) -> Result<Journal, Failure> {
    let path: PathBuf = folder.join("journal.jsonl");
    if fresh {
        let _ = std::fs::remove_file(&path);
    }
    let what: Vec<&str> =
        asked.iter().map(String::as_str).filter(|a| !["--fresh", "-q", "--quiet"].contains(a)).collect();
    let settings = serde_json::json!({ "program": env!("CARGO_PKG_VERSION"), "command": what }).to_string();
    Journal::open(&path, &settings).map_err(|e| Failure::input(format!("{}: {e}", path.display())))
}

fn bar(quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} runs  {elapsed} gone, {eta} left  {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(1).with_style(style);
    bar.set_draw_target(if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(5) });
    bar
}

/// The verdict as a person reads it.
fn tell(document: &Document, worse: Option<&(usize, Vec<Regression>)>, page: &Path) {
    let v = &document.verdict;
    text::note(&format!("{} of {} judged results are within what they must meet", v.passed, v.judged));
    v.missed.iter().for_each(|m| text::note(&format!("  missed: {m}")));
    if let Some((compared, worse)) = worse {
        text::note(&format!("{compared} results compared with the baseline, {} got worse", worse.len()));
        for r in worse {
            text::note(&format!("  worse: {}: {} was {:.3e}, is {:.3e}", r.row, r.what, r.before, r.now));
        }
    }
    let state = if document.interrupted { "stopped; what was measured is in" } else { "the report is" };
    text::note(&format!("{state} {}", page.display()));
}
