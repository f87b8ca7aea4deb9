//! `pliant report`.

mod catalogues;
mod command;

pub use command::report;
