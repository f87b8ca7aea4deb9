//! `pliant batch collect` and `pliant batch plot`.

use crate::args::{Cli, CollectArgs, PlotArgs};
use crate::outcome::{Failure, Outcome};
use crate::output::{count, note, print_json};
use pliant_batch::{CollectOptions, Collected, Format, PlotOptions, Table, collect, plot};
use pliant_record::{AtomicFile, check_replaceable};
use serde_json::json;
use std::io::Write;
use std::path::Path;

/// Merges shards to one table.
pub fn collect_table(cli: &Cli, args: &CollectArgs) -> Result<Outcome, Failure> {
    let output = args.output.clone().unwrap_or_else(|| args.folders[0].join("results.csv"));
    // Found before anything is read.
    Format::of(&output).map_err(Failure::input)?;
    check_replaceable(&output)?;
    let options = CollectOptions { mixed: args.mixed, timings: args.timings };
    let mut collected = collect(&args.folders, options)?;
    write_table(&mut collected.table, &output)?;
    let Collected { table, edits, failed, missing } = &collected;
    if cli.json {
        let rows = table.len();
        print_json(&json!({ "output": output, "edits": edits, "rows": rows, "failed": failed, "missing": missing }))?;
    } else {
        let rows = table.len();
        note(&format!("{rows} of {}, {failed} failed, in {}", count(*edits, "run"), output.display()));
        for (shard, number) in missing {
            note(&format!("{} of shard {shard} missing", count(*number, "run")));
        }
    }
    Ok(Outcome::Done)
}

/// Writes a table whole or not at all, in the format of the file's name.
pub(super) fn write_table(table: &mut Table, path: &Path) -> Result<(), Failure> {
    let format = Format::of(path).map_err(Failure::input)?;
    let mut file = AtomicFile::create_and_clean(path)?;
    table.write(format, &mut file)?;
    Ok(file.finish()?)
}

/// Draws a column of the table over another.
pub fn plot_table(cli: &Cli, args: &PlotArgs) -> Result<Outcome, Failure> {
    let name = format!("{}-over-{}.svg", args.y, args.x).replace(['/', ' '], "-");
    let output = args.output.clone().unwrap_or_else(|| args.folder.join(name));
    check_replaceable(&output)?;
    let mut collected = collect(std::slice::from_ref(&args.folder), CollectOptions::default())?;
    let options = PlotOptions { x: args.x.clone(), y: args.y.clone(), by: args.by.clone(), heat: args.heat };
    let svg = plot(&mut collected.table, &options)?;
    let mut file = AtomicFile::create_and_clean(&output)?;
    file.write_all(svg.as_bytes())?;
    file.finish()?;
    if cli.json {
        print_json(&json!({ "output": output }))?;
    } else {
        note(&format!("the picture is {}", output.display()));
    }
    Ok(Outcome::Done)
}
