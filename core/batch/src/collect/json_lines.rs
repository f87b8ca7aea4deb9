//! Writing of a table as JSON Lines.

use super::Table;
use crate::column::row_json;
use crate::error::BatchError;
use std::io::Write;
use std::path::Path;

/// Writes an object for each row, with keys in the order of the columns.
pub(super) fn write(table: &mut Table, out: &mut impl Write) -> Result<(), BatchError> {
    let columns = table.columns().to_vec();
    // The writer has no path: errors name what is written.
    table.for_each(|cells| {
        writeln!(out, "{}", row_json(&columns, &cells)).map_err(|source| BatchError::io(Path::new("the table"), source))
    })
}
