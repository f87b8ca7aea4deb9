//! `pliant batch status`.

use crate::args::Cli;
use crate::outcome::{Failure, Outcome};
use crate::output::{print, print_json};
use pliant_batch::{ShardStatus, status};
use std::path::PathBuf;

/// Prints how far the shards in some folders are.
pub fn print_status(cli: &Cli, folders: &[PathBuf]) -> Result<Outcome, Failure> {
    let mut shards = Vec::new();
    for folder in folders {
        shards.extend(status(folder)?);
    }
    if cli.json {
        print_json(&shards)?;
    } else {
        print(&status_text(&shards))?;
    }
    Ok(Outcome::Done)
}

/// A line for each shard, and one for all.
fn status_text(shards: &[ShardStatus]) -> String {
    let mut lines: Vec<String> = shards.iter().map(shard_line).collect();
    let sum = |of: fn(&ShardStatus) -> u64| shards.iter().map(of).sum::<u64>();
    let (done, edits) = (sum(|shard| shard.done), sum(|shard| shard.edits));
    let failed = sum(|shard| shard.failed.values().sum());
    let seconds: f64 = shards.iter().map(|shard| shard.edit_seconds).sum();
    let each = if done > 0 { format!(", {:.1} ms each", 1e3 * seconds / done as f64) } else { String::new() };
    lines.push(format!("all: {done} of {edits} done, {failed} failed{each}"));
    lines.join("\n")
}

fn shard_line(shard: &ShardStatus) -> String {
    let ShardStatus { shard: name, state, done, edits, process, .. } = shard;
    let failed: Vec<String> = shard.failed.iter().map(|(class, number)| format!("{number} {class}")).collect();
    let failed = if failed.is_empty() { String::new() } else { format!(", failed: {}", failed.join(", ")) };
    format!("shard {name}: {state}, {done} of {edits} done{failed} ({process}, {})", shard.program)
}
