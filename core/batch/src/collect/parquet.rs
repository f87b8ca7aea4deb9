//! Writing of a table as Apache Parquet, in row groups compressed with Snappy.

use super::Table;
use crate::column::{Column, ColumnType};
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

/// Rows of a group.
const GROUP: usize = 8192;

/// Writes the table. The metadata of a field has its unit under `unit`.
pub(super) fn write(table: &mut Table, out: &mut (impl Write + Send)) -> Result<(), BatchError> {
    let columns = table.columns().to_vec();
    let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = ArrowWriter::try_new(out, Arc::clone(&schema), Some(properties)).map_err(|e| failed(&e))?;
    let mut rows: Vec<Vec<Value>> = Vec::with_capacity(GROUP);
    let flush = |rows: &mut Vec<Vec<Value>>, writer: &mut ArrowWriter<_>| {
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

/// An error of the writer.
fn failed(error: &dyn std::fmt::Display) -> BatchError {
    BatchError::io(Path::new("the table"), std::io::Error::other(error.to_string()))
}

/// Name, type and unit of a column.
fn field(column: &Column) -> Field {
    let data_type = match column.column_type {
        ColumnType::Integer => DataType::Int64,
        ColumnType::Float => DataType::Float64,
        ColumnType::Boolean => DataType::Boolean,
        ColumnType::Text => DataType::Utf8,
        ColumnType::FloatList => DataType::List(Arc::new(Field::new("item", DataType::Float64, true))),
    };
    let field = Field::new(&column.name, data_type, true);
    match column.unit.is_empty() {
        true => field,
        false => field.with_metadata([("unit".to_owned(), column.unit.clone())]),
    }
}

/// Cells of a column; a value of another type becomes empty.
fn array<'a>(column: &Column, cells: impl Iterator<Item = &'a Value>) -> ArrayRef {
    match column.column_type {
        ColumnType::Integer => {
            let mut builder = Int64Builder::new();
            cells.for_each(|cell| builder.append_option(cell.as_i64()));
            Arc::new(builder.finish())
        }
        ColumnType::Float => {
            let mut builder = Float64Builder::new();
            cells.for_each(|cell| builder.append_option(cell.as_f64()));
            Arc::new(builder.finish())
        }
        ColumnType::Boolean => {
            let mut builder = BooleanBuilder::new();
            cells.for_each(|cell| builder.append_option(cell.as_bool()));
            Arc::new(builder.finish())
        }
        ColumnType::Text => {
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
        ColumnType::FloatList => {
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

#[cfg(test)]
mod tests {
    use super::super::{CollectOptions, Format, collect};
    use crate::column::row_json;
    use crate::execute::EditSeconds;
    use crate::shard::Shard;
    use crate::store::{NewRow, ShardFiles};
    use crate::sweep::Sweep;
    use arrow_array::cast::AsArray;
    use arrow_array::types::{Float64Type, Int64Type};
    use arrow_array::{Array, RecordBatch};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use serde_json::{Value, json};
    use std::fs::File;

    /// Rows of a sweep over two stiffnesses, written and read as Parquet; the second run failed.
    fn written_and_read() -> RecordBatch {
        let folder = tempfile::tempdir().unwrap();
        let scene = "format = 1\n[[body]]\nname = 'b'\nmaterial = { plugin = 'mass-spring' }\n\
            shape = { kind = 'box', cells = 2, size = ['1 cm', '1 cm', '1 cm'] }\n";
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let text = "format = 1\nscene = 'scene.toml'\n[[axis]]\npath = 'body.0.material.params.young'\n\
            list = ['5 kPa', '10 kPa']\n[keep]\nsummary = ['steps', 'largest_force', 'passed']\ntrace = ['residual']\n";
        let sweep = Sweep::parse(&folder.path().join("sweep.toml"), text.into()).unwrap();
        let shard = Shard::default();
        let (mut files, _) = ShardFiles::open(folder.path(), shard, false).unwrap();
        files.begin(&sweep, shard, "pliant test").unwrap();
        let keys: [crate::EditKey; 2] = ["a", "b"].map(|key| serde_json::from_value(json!(key)).unwrap());
        let rows: [Vec<Value>; 2] = [
            serde_json::from_value(json!([0, "a", 5, "done", null, null, 12, 0.1, true, [1e-7, null, 0.5]])).unwrap(),
            serde_json::from_value(json!([1, "b", 10, "failed", "plugin", "no, \"really\"", null, null, null, null]))
                .unwrap(),
        ];
        for (edit, (key, cells)) in keys.into_iter().zip(&rows).enumerate() {
            let text = row_json(sweep.columns(), cells);
            let (failed, attempts, seconds) = (None, 1, EditSeconds::default());
            files.put(NewRow { edit: edit as u64, key, text: &text, failed, attempts, seconds }).unwrap();
        }
        let mut collected = collect(&[folder.path().to_path_buf()], CollectOptions::default()).unwrap();
        let path = folder.path().join("table.parquet");
        collected.table.write(Format::of(&path).unwrap(), &mut File::create(&path).unwrap()).unwrap();
        let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(&path).unwrap()).unwrap();
        reader.build().unwrap().next().unwrap().unwrap()
    }

    #[test]
    fn values_units_and_what_is_missing_come_back() {
        let batch = written_and_read();
        assert_eq!(batch.num_rows(), 2);
        let schema = batch.schema();
        let unit = |name: &str| schema.field_with_name(name).unwrap().metadata().get("unit").cloned();
        assert_eq!((unit("young").as_deref(), unit("largest_force").as_deref()), (Some("kPa"), Some("N")));
        let column = |name: &str| batch.column_by_name(name).unwrap();
        assert_eq!(column("young").as_primitive::<Float64Type>().values(), &[5.0, 10.0]);
        assert_eq!(column("steps").as_primitive::<Int64Type>().value(0), 12);
        assert!(column("steps").is_null(1) && column("passed").is_null(1) && column("passed").as_boolean().value(0));
        assert_eq!(column("largest_force").as_primitive::<Float64Type>().value(0).to_bits(), 0.1_f64.to_bits());
        assert_eq!(column("message").as_string::<i32>().value(1), "no, \"really\"");
        let residuals = column("residual").as_list::<i32>();
        let first = residuals.value(0);
        let first = first.as_primitive::<Float64Type>();
        assert!(residuals.is_null(1) && first.len() == 3 && first.is_null(1) && first.value(0) == 1e-7);
    }
}
