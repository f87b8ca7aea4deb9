//! An open session and what Python has of it.

use super::failure::{Failure, contained};
use super::lease::{Lent, take_back};
use super::open::Opened;
use pyo3::prelude::*;
use std::time::Duration;

/// An open session and what Python has of it.
pub struct Open {
    pub(super) opened: Opened,
    /// Time that opening it took.
    pub(super) opening: Duration,
    pub(super) lent: Vec<Lent>,
    /// Counts changes of positions.
    pub(super) version: u64,
    /// Version whose surface is up to date.
    embedded: u64,
}

impl Open {
    /// A session that was opened in the time `opening`.
    pub fn new(opened: Opened, opening: Duration) -> Self {
        Self { opened, opening, lent: Vec::new(), version: 0, embedded: 0 }
    }

    /// Before positions change.
    pub fn invalidate(&mut self, py: Python<'_>) {
        self.take_back(py);
        self.version += 1;
    }

    fn take_back(&mut self, py: Python<'_>) {
        let Self { opened, lent, .. } = self;
        take_back(py, lent, &mut opened.session.bodies);
    }

    /// The index of a tool in use.
    pub fn tool(&self, name: &str) -> Result<usize, Failure> {
        let tools = &self.opened.session.tools;
        tools.iter().position(|slot| slot.tool.name == name).ok_or_else(|| {
            let known: Vec<String> = tools.iter().map(|slot| format!("`{}`", slot.tool.name)).collect();
            let known = if known.is_empty() { "nothing: no edit uses a tool".into() } else { known.join(", ") };
            Failure::argument(format!("no tool `{name}` in use; allowed is {known}"))
        })
    }

    /// Brings every surface up to date, once for each step.
    pub fn embed(&mut self, py: Python<'_>) -> Result<(), Failure> {
        if self.embedded == self.version {
            return Ok(());
        }
        let session = &mut self.opened.session;
        let update = || {
            session.update_surface();
            Ok(())
        };
        py.detach(|| contained(update))?;
        self.embedded = self.version;
        Ok(())
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        Python::attach(|py| self.take_back(py));
    }
}
