//! `pliant batch script`.

use super::out_folder;
use crate::args::{Cli, EngineArg, ScriptArgs};
use crate::outcome::{Failure, Outcome};
use crate::output::{print, print_json};
use pliant_batch::{Engine, Launch, Sweep, launcher};
use serde_json::json;
use std::path::PathBuf;

/// Prints a script that has an engine run the shards of a sweep.
pub fn print_script(cli: &Cli, args: &ScriptArgs) -> Result<Outcome, Failure> {
    // One that cannot be read is better found now than by every shard.
    Sweep::read(&args.sweep)?;
    let engine = match args.engine {
        EngineArg::Slurm => Engine::Slurm,
        EngineArg::Hyperqueue => Engine::HyperQueue,
        EngineArg::Dask => Engine::Dask,
        EngineArg::Parallel => Engine::Parallel,
        EngineArg::Snakemake => Engine::Snakemake,
    };
    let folders = |option: &'static str, folders: &[PathBuf]| -> Vec<String> {
        folders.iter().flat_map(|folder| [option.to_owned(), folder.display().to_string()]).collect()
    };
    let launch = Launch {
        program: args.program.clone().map_or_else(std::env::current_exe, Ok)?,
        options: [folders("--plugin-path", &cli.plugin_path), folders("--allow-plugins", &cli.allow_plugins)].concat(),
        sweep: args.sweep.clone(),
        out: out_folder(args.out.as_ref(), &args.sweep),
        shards: args.shards,
        jobs: args.jobs,
    };
    let script = launcher(engine, &launch);
    if cli.json {
        print_json(&json!({ "engine": engine.to_string(), "script": script }))?;
    } else {
        print(&script)?;
    }
    Ok(Outcome::Done)
}
