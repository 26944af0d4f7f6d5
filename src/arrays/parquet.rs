//! Parquet files of Arrow tables, compressed with Snappy.

use std::collections::HashMap;
use std::fs::File;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaDataReader;
use parquet::file::properties::WriterProperties;

use crate::arrays::Arrays;
use crate::biomechanics::TimeSeries;
use crate::error::{Code, Diagnostic, Result};
use crate::files::PARQUET_CREATOR;

/// Whether `file` is a Parquet file that says that this crate wrote it.
pub fn is_own_parquet(file: &File) -> bool {
    let Ok(metadata) = ParquetMetaDataReader::new().parse_and_finish(file) else {
        return false;
    };
    let creator = metadata.file_metadata().created_by();
    creator.is_some_and(|creator| creator.starts_with(PARQUET_CREATOR))
}

impl Arrays {
    /// A Parquet file of [`to_table_with_header`](Self::to_table_with_header).
    ///
    /// # Errors
    /// [`Code::Unrepresentable`] where Parquet cannot hold the table.
    pub fn to_parquet(&self, clip: &str) -> Result<Vec<u8>> {
        to_parquet(&[self.to_table_with_header(clip)])
    }
}

impl TimeSeries {
    /// A Parquet file: `time` in seconds, then the columns, whose fields have their `unit` as metadata.
    ///
    /// # Errors
    /// As [`Arrays::to_parquet`].
    pub fn to_parquet(&self) -> Result<Vec<u8>> {
        let times = (0..self.frames()).map(|frame| frame as f64 / self.frame_rate);
        let mut fields = vec![field("time", "s")];
        let mut columns: Vec<ArrayRef> = vec![Arc::new(times.collect::<Float64Array>())];
        for (index, (name, unit)) in std::iter::zip(&self.columns, &self.units).enumerate() {
            let values = self.values.chunks(self.columns.len()).map(|row| row[index]);
            fields.push(field(name, unit));
            columns.push(Arc::new(values.collect::<Float64Array>()));
        }
        let table = RecordBatch::try_new(Arc::new(Schema::new(fields)), columns);
        let table = table.map_err(|error| Diagnostic::new(Code::Unrepresentable, error.to_string()))?;
        to_parquet(&[table])
    }
}

fn field(name: &str, unit: &str) -> Field {
    let unit = HashMap::from([("unit".to_owned(), unit.to_owned())]);
    Field::new(name, DataType::Float64, false).with_metadata(unit)
}

/// A Parquet file with the rows of `tables`, which have the schema of the first.
///
/// # Errors
/// [`Code::Unrepresentable`] where their schemas differ, there is no table, or Parquet cannot hold them.
pub fn to_parquet(tables: &[RecordBatch]) -> Result<Vec<u8>> {
    let refused = |error: String| Diagnostic::new(Code::Unrepresentable, error);
    let first = tables.first().ok_or_else(|| refused("no table was given".to_owned()))?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("{PARQUET_CREATOR}{}", env!("CARGO_PKG_VERSION")))
        .build();
    let mut bytes = Vec::new();
    let write = || -> Result<(), ParquetError> {
        let mut writer = ArrowWriter::try_new(&mut bytes, first.schema(), Some(properties))?;
        for table in tables {
            writer.write(table)?;
        }
        writer.close()?;
        Ok(())
    };
    write().map_err(|error| refused(error.to_string()))?;
    Ok(bytes)
}
