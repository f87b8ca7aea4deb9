//! `pliant batch`: runs sweeps and looks at their results.

mod run;
mod script;
mod status;
mod table;

use crate::args::{BatchArgs, BatchCommand, Cli};
use crate::outcome::{Failure, Outcome};
use std::path::{Path, PathBuf};

/// Runs a sweep, or looks at results.
pub fn batch(cli: &Cli, args: &BatchArgs) -> Result<Outcome, Failure> {
    match (&args.command, &args.run.sweep) {
        (Some(BatchCommand::Collect(args)), _) => table::collect_table(cli, args),
        (Some(BatchCommand::Status { folders }), _) => status::print_status(cli, folders),
        (Some(BatchCommand::Plot(args)), _) => table::plot_table(cli, args),
        (Some(BatchCommand::Script(args)), _) => script::print_script(cli, args),
        (None, Some(sweep)) => run::run_sweep(cli, &args.run, sweep),
        (None, None) => {
            Err(Failure::input("no sweep; allowed is a TOML file, or one of collect, status, plot, script"))
        }
    }
}

/// The folder of the results of a sweep.
fn out_folder(out: Option<&PathBuf>, sweep: &Path) -> PathBuf {
    out.cloned().unwrap_or_else(|| Path::new("out").join(sweep.file_stem().unwrap_or_default()))
}
