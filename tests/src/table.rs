//! Tables of a run, by the names of their columns.

use crate::Bench;

/// A CSV file with a line of names.
#[derive(Debug)]
pub struct Table {
    /// Names of the columns, in order.
    pub names: Vec<String>,
    /// Cells of the rows, in the order of the names.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a file of a bench.
    ///
    /// # Panics
    /// If it is not there or empty.
    pub fn read(bench: &Bench, name: &str) -> Self {
        let text = String::from_utf8(bench.read(name)).expect("UTF-8");
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let names = lines.next().expect("a line of names");
        Self { names, rows: lines.collect() }
    }

    /// The number in a row under a name.
    ///
    /// # Panics
    /// If there is no such row, name or number.
    pub fn number(&self, row: usize, name: &str) -> f64 {
        let at = self.names.iter().position(|known| known == name);
        let at = at.unwrap_or_else(|| panic!("no column {name} among {:?}", self.names));
        self.rows[row][at].parse().unwrap_or_else(|_| panic!("{name} of row {row}: {}", self.rows[row][at]))
    }
}
