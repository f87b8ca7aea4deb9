//! Presentation of a report: sections of text, figures and tables.

/// One section of a report.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Heading of the section.
    pub title: String,
    /// Paragraphs below the heading.
    pub text: Vec<String>,
    /// Pictures: file name without ending, and SVG text.
    pub plots: Vec<(String, String)>,
    /// Tables after the pictures.
    pub tables: Vec<Table>,
}

/// A table of texts.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Line above the table.
    pub caption: String,
    /// Names and units of the columns.
    pub head: Vec<String>,
    /// Rows from top to bottom.
    pub rows: Vec<TableRow>,
}

/// One row of a table.
#[derive(Clone, Debug, Default)]
pub struct TableRow {
    /// Texts in the order of the columns.
    pub cells: Vec<String>,
    /// Whether the row failed its criterion.
    pub failed: bool,
}

impl Table {
    /// A table without rows.
    pub(crate) fn new(caption: impl Into<String>, head: &[&str]) -> Self {
        Self { caption: caption.into(), head: head.iter().map(|name| (*name).to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub(crate) fn push(&mut self, cells: Vec<String>, failed: bool) {
        self.rows.push(TableRow { cells, failed });
    }
}
