//! Parquet files of Arrow tables, compressed with Snappy.

use std::collections::HashMap;
use std::fs::File;

use arrow_array::RecordBatch;
use arrow_schema::{DataType, Field};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaDataReader;
use parquet::file::properties::WriterProperties;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::PARQUET_CREATOR;

/// Whether the metadata of a Parquet file names this crate as its writer.
pub fn is_own_parquet(file: &File) -> bool {
    let Ok(metadata) = ParquetMetaDataReader::new().parse_and_finish(file) else {
        return false;
    };
    let creator = metadata.file_metadata().created_by();
    creator.is_some_and(|creator| creator.starts_with(PARQUET_CREATOR))
}

/// A column of numbers with a unit.
pub fn field(name: &str, unit: &str) -> Field {
    let unit = HashMap::from([("unit".to_owned(), unit.to_owned())]);
    Field::new(name, DataType::Float64, false).with_metadata(unit)
}

/// Returns a Parquet file with the rows of `tables`, in the schema of the first table. Writes each table before it
/// requests the next.
///
/// # Errors
/// [`Code::Unrepresentable`] if the schemas differ, there is no table, or Parquet cannot hold the tables.
pub fn to_parquet(tables: impl IntoIterator<Item = RecordBatch>) -> Result<Vec<u8>> {
    let refused = |error: String| Diagnostic::new(Code::Unrepresentable, error);
    let mut tables = tables.into_iter();
    let first = tables.next().ok_or_else(|| refused("no table was given".to_owned()))?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("{PARQUET_CREATOR}{}", env!("CARGO_PKG_VERSION")))
        .build();
    let mut bytes = Vec::new();
    let write = || -> Result<(), ParquetError> {
        let mut writer = ArrowWriter::try_new(&mut bytes, first.schema(), Some(properties))?;
        for table in std::iter::once(first).chain(tables) {
            writer.write(&table)?;
        }
        writer.close()?;
        Ok(())
    };
    write().map_err(|error| refused(error.to_string()))?;
    Ok(bytes)
}
