//! What holds and up to where: maps, limits, balances, the extreme catalogue, and the coupling of a hand.

mod balance;
mod catalogue;
mod coupling;
mod extreme;
mod graded;
mod limit;
mod map;
mod page;
mod state;

pub use catalogue::{Account, Balance, Extreme, Map, Point, StabilityCatalogue};
pub use page::stability_page;
pub use state::State;

use super::{Journal, Row, Setup, Trial};
use std::path::Path;

/// Scenes by name.
pub type Scenes<'a> = &'a dyn Fn(&str) -> Option<&'a str>;

/// One thing to measure: the row as it is known before, and how it is filled.
type Task<'a> = (Row, Box<dyn Fn(Row, &mut Setup<'_>) -> Row + 'a>);

/// Runs all of it. `folder` takes the meshes that are made for it.
///
/// # Errors
/// A mesh that cannot be written.
pub fn stability<'a>(
    (catalogue, folder): (&'a StabilityCatalogue, &'a Path),
    scenes: Scenes<'a>,
    setup: &mut Setup<'_>,
    journal: &mut Journal,
) -> std::io::Result<Vec<Row>> {
    graded::write(catalogue, folder)?;
    let mut tasks: Vec<Task<'a>> = Vec::new();
    map::tasks((catalogue, folder), scenes, setup, &mut tasks);
    limit::tasks((catalogue, folder), scenes, setup, &mut tasks);
    balance::tasks(catalogue, scenes, setup, &mut tasks);
    extreme::tasks(catalogue, scenes, setup, &mut tasks);
    coupling::tasks(setup, &mut tasks);
    tasks.retain(|(row, _)| setup.wants(&row.case));
    let (all, mut rows) = (tasks.len(), Vec::with_capacity(tasks.len()));
    for (done, (blank, fill)) in tasks.into_iter().enumerate() {
        if (setup.stopped)() {
            break;
        }
        (setup.progress)(done, all, &format!("{}, {}", blank.case, blank.method));
        let row = journal.get(&blank.key()).unwrap_or_else(|| {
            let row = fill(blank, setup);
            journal.put(&row);
            row
        });
        rows.push(row);
    }
    Ok(rows)
}

/// A run of a scene with settings. `None` where there is no such scene; the row then says so.
fn trial<'t, 'a: 't>(
    scenes: Scenes<'a>,
    name: &'t str,
    set: Vec<(String, String)>,
    setup: &'t Setup<'_>,
) -> Option<Trial<'t>> {
    let text = scenes(name)?;
    let (threads, search, clock) = (setup.threads, &setup.search, setup.clock);
    Some(Trial { path: Path::new(name), text, set, threads, search, clock })
}

/// A setting as `--set` takes it.
fn set(path: &str, value: impl ToString) -> (String, String) {
    (path.to_owned(), value.to_string())
}
