//! Corruptions of Parquet: of columns, rows and the header.

use std::collections::HashMap;
use std::io::Write;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type};
use arrow_array::{ArrayRef, Float32Array, Float64Array, RecordBatch, StringArray};
use arrow_schema::Schema;
use mocap::arrays::table::to_parquet;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::{Files, Plant, of_walk};

const PARQUET: &[&str] = &["parquet"];

/// Changes the table of a file.
fn with(files: &mut Files, change: impl FnOnce(RecordBatch) -> Option<RecordBatch>) -> bool {
    let bytes = files.main();
    let mut copy = tempfile::tempfile().unwrap();
    copy.write_all(bytes).unwrap();
    let reader = ParquetRecordBatchReaderBuilder::try_new(copy).unwrap();
    let schema = reader.schema().clone();
    let batches: Vec<RecordBatch> = reader
        .with_batch_size(1 << 20)
        .build()
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let [batch] = batches.as_slice() else {
        panic!("one batch")
    };
    let batch = RecordBatch::try_new(schema, batch.columns().to_vec()).unwrap();
    match change(batch) {
        Some(changed) => {
            *bytes = to_parquet([changed]).unwrap();
            true
        }
        None => false,
    }
}

fn with_column(batch: &RecordBatch, name: &str, column: ArrayRef) -> Option<RecordBatch> {
    let index = batch.schema().index_of(name).ok()?;
    let mut columns = batch.columns().to_vec();
    columns[index] = column;
    RecordBatch::try_new(batch.schema(), columns).ok()
}

/// Changes the numbers of a column; `row` counts from 0.
fn floats(files: &mut Files, name: &str, change: impl Fn(usize, f32) -> f32) -> bool {
    with(files, |batch| {
        let column = batch.column_by_name(name)?.as_primitive::<Float32Type>();
        let changed = column
            .values()
            .iter()
            .enumerate()
            .map(|(row, value)| change(row, *value));
        with_column(&batch, name, Arc::new(changed.collect::<Float32Array>()))
    })
}

fn header(files: &mut Files, from: &str, to: &str) -> bool {
    with(files, |batch| {
        let schema = batch.schema();
        let header = schema.metadata().get("mocap")?;
        let changed = header.replacen(from, to, 1);
        let is_there = changed != *header;
        let metadata = HashMap::from([("mocap".to_owned(), changed)]);
        let schema = Schema::clone(&schema).with_metadata(metadata);
        let made = RecordBatch::try_new(Arc::new(schema), batch.columns().to_vec()).ok();
        made.filter(|_| is_there)
    })
}

pub(super) const PLANTS: &[Plant] = &[
    of_walk("units: another unit stated", PARQUET, |files| {
        header(files, r#""metres_per_unit":1.0"#, r#""metres_per_unit":0.01"#)
    }),
    of_walk("units: another up axis stated", PARQUET, |files| {
        header(files, r#""up":"y""#, r#""up":"z""#)
    }),
    of_walk("file: times shifted", PARQUET, |files| {
        with(files, |batch| {
            let column = batch.column_by_name("time")?.as_primitive::<Float64Type>();
            let changed = column.values().iter().map(|time| time + 0.1);
            with_column(&batch, "time", Arc::new(changed.collect::<Float64Array>()))
        })
    }),
    of_walk("file: a joint renamed", PARQUET, |files| {
        with(files, |batch| {
            let column = batch.column_by_name("joint")?.as_string::<i32>();
            let changed = column.iter().map(|name| name.map(|name| name.replace("Head", "Heap")));
            with_column(&batch, "joint", Arc::new(changed.collect::<StringArray>()))
        })
    }),
    of_walk("file: one frame wrong", PARQUET, |files| {
        floats(files, "y", |row, value| if row == 800 { value + 0.05 } else { value })
    }),
    of_walk("file: one rotation wrong", PARQUET, |files| {
        floats(files, "qy", |row, value| if row == 800 { value + 0.3 } else { value })
    }),
    of_walk("file: an end site moved", PARQUET, |files| {
        // The last row of the first frame.
        floats(files, "z", |row, value| if row == 37 { value + 0.05 } else { value })
    }),
    of_walk("file: a column swapped", PARQUET, |files| {
        with(files, |batch| {
            let [x, z] = ["x", "z"].map(|name| batch.column_by_name(name).unwrap().clone());
            with_column(&with_column(&batch, "x", z)?, "z", x)
        })
    }),
    of_walk("file: a row dropped", PARQUET, |files| {
        with(files, |batch| Some(batch.slice(0, batch.num_rows() - 1)))
    }),
    of_walk("file: a frame dropped", PARQUET, |files| {
        with(files, |batch| Some(batch.slice(0, batch.num_rows() - 38)))
    }),
    of_walk("file: velocities halved", PARQUET, |files| {
        floats(files, "vy", |_, value| value * 0.5)
    }),
];
