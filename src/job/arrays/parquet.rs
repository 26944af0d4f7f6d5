//! Motion and time series as Parquet files.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::Schema;
use mocap_io::export::parquet::{field, to_parquet};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_solve::biomechanics::TimeSeries;

use crate::arrays::Arrays;

impl Arrays {
    /// The table [`to_table_with_header`](Self::to_table_with_header) as a Parquet file.
    ///
    /// # Errors
    /// [`Code::Unrepresentable`] if Parquet cannot hold the table.
    pub fn to_parquet(&self, clip: &str) -> Result<Vec<u8>> {
        to_parquet(self.tables(clip).map(|table| self.with_header(&table)))
    }
}

/// A time series as a Parquet file: `time` in seconds, then the columns. The metadata of a column has its `unit`.
///
/// # Errors
/// As [`Arrays::to_parquet`].
pub fn time_series_parquet(series: &TimeSeries) -> Result<Vec<u8>> {
    let times = (0..series.frames()).map(|frame| frame as f64 / series.frame_rate);
    let mut fields = vec![field("time", "s")];
    let mut columns: Vec<ArrayRef> = vec![Arc::new(times.collect::<Float64Array>())];
    for (index, (name, unit)) in std::iter::zip(&series.columns, &series.units).enumerate() {
        let values = series.values.chunks(series.columns.len()).map(|row| row[index]);
        fields.push(field(name, unit));
        columns.push(Arc::new(values.collect::<Float64Array>()));
    }
    let table = RecordBatch::try_new(Arc::new(Schema::new(fields)), columns);
    let table = table.map_err(|error| Diagnostic::new(Code::Unrepresentable, error.to_string()))?;
    to_parquet([table])
}
