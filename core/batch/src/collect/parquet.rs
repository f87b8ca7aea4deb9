//! A table as Apache Parquet, columns in groups of rows, compressed with Snappy.

use super::Table;
use crate::column::{Column, ColumnKind};
use crate::error::BatchError;
use arrow_array::builder::{BooleanBuilder, Float64Builder, Int64Builder, ListBuilder, StringBuilder};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Rows that are held at a time.
const GROUP: usize = 8192;

/// Writes the table. The metadata of a field has its unit under `unit`.
pub(super) fn write(table: &mut Table, out: &mut (impl Write + Send)) -> Result<(), BatchError> {
    let columns = table.columns().to_vec();
    let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = ArrowWriter::try_new(out, Arc::clone(&schema), Some(properties)).map_err(|e| failed(&e))?;
    let mut rows: Vec<Vec<Value>> = Vec::with_capacity(GROUP);
    let mut flush = |rows: &mut Vec<Vec<Value>>, writer: &mut ArrowWriter<_>| {
        let arrays = columns.iter().enumerate().map(|(at, column)| array(column, rows.iter().map(|row| &row[at])));
        let batch = RecordBatch::try_new(Arc::clone(&schema), arrays.collect()).map_err(|e| failed(&e))?;
        rows.clear();
        writer.write(&batch).map_err(|e| failed(&e))
    };
    table.for_each(|cells| {
        rows.push(cells);
        if rows.len() == GROUP { flush(&mut rows, &mut writer) } else { Ok(()) }
    })?;
    if !rows.is_empty() {
        flush(&mut rows, &mut writer)?;
    }
    writer.close().map(drop).map_err(|e| failed(&e))
}

fn failed(error: &dyn std::fmt::Display) -> BatchError {
    BatchError::io(Path::new("the table"), std::io::Error::other(error.to_string()))
}

/// Name, type and unit of a column.
fn field(column: &Column) -> Field {
    let kind = match column.kind {
        ColumnKind::Integer => DataType::Int64,
        ColumnKind::Number => DataType::Float64,
        ColumnKind::Flag => DataType::Boolean,
        ColumnKind::Text => DataType::Utf8,
        ColumnKind::Numbers => DataType::List(Arc::new(Field::new("item", DataType::Float64, true))),
    };
    let field = Field::new(&column.name, kind, true);
    match column.unit.is_empty() {
        true => field,
        false => field.with_metadata([("unit".to_owned(), column.unit.clone())].into()),
    }
}

/// Cells of a column; what is not of its kind is left empty.
fn array<'a>(column: &Column, cells: impl Iterator<Item = &'a Value>) -> ArrayRef {
    match column.kind {
        ColumnKind::Integer => {
            let mut builder = Int64Builder::new();
            cells.for_each(|cell| builder.append_option(cell.as_i64()));
            Arc::new(builder.finish())
        }
        ColumnKind::Number => {
            let mut builder = Float64Builder::new();
            cells.for_each(|cell| builder.append_option(cell.as_f64()));
            Arc::new(builder.finish())
        }
        ColumnKind::Flag => {
            let mut builder = BooleanBuilder::new();
            cells.for_each(|cell| builder.append_option(cell.as_bool()));
            Arc::new(builder.finish())
        }
        ColumnKind::Text => {
            let mut builder = StringBuilder::new();
            for cell in cells {
                match cell {
                    Value::Null => builder.append_null(),
                    Value::String(text) => builder.append_value(text),
                    other => builder.append_value(other.to_string()),
                }
            }
            Arc::new(builder.finish())
        }
        ColumnKind::Numbers => {
            let mut builder = ListBuilder::new(Float64Builder::new());
            for cell in cells {
                if let Some(list) = cell.as_array() {
                    list.iter().for_each(|item| builder.values().append_option(item.as_f64()));
                }
                builder.append(cell.is_array());
            }
            Arc::new(builder.finish())
        }
    }
}
