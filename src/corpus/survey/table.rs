//! Makes an Arrow table of the rows, for Parquet files.

use std::sync::Arc;

use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray};
use arrow_schema::{Field, Schema};

use super::corpus::Corpus;
use super::row::{Cell, CellType, ClipRow};

impl Corpus {
    /// The rows as a table: numbers as float64, flags as bool, text as utf8, and the findings as JSON in `defects`.
    /// Absent values are null.
    pub fn to_table(&self) -> RecordBatch {
        let mut fields = Vec::new();
        let mut columns: Vec<ArrayRef> = Vec::new();
        for (name, kind) in ClipRow::columns() {
            let cells = self.rows().map(|row| row.cell(name).unwrap_or(Cell::Nothing));
            let column: ArrayRef = match kind {
                CellType::Flag => Arc::new(cells.map(flag).collect::<BooleanArray>()),
                CellType::Number => Arc::new(cells.map(number).collect::<Float64Array>()),
                CellType::Text => Arc::new(cells.map(text).collect::<StringArray>()),
            };
            fields.push(Field::new(name, column.data_type().clone(), true));
            columns.push(column);
        }
        let defects = |row: &ClipRow| serde_json::to_string(&row.defects).ok();
        let defects: ArrayRef = Arc::new(self.rows().map(defects).collect::<StringArray>());
        fields.push(Field::new("defects", defects.data_type().clone(), true));
        columns.push(defects);
        RecordBatch::try_new(Arc::new(Schema::new(fields)), columns).expect("columns have a cell for each row")
    }
}

fn flag(cell: Cell) -> Option<bool> {
    match cell {
        Cell::Flag(flag) => Some(flag),
        _ => None,
    }
}

fn number(cell: Cell) -> Option<f64> {
    match cell {
        Cell::Number(number) => Some(number),
        _ => None,
    }
}

fn text(cell: Cell) -> Option<String> {
    match cell {
        Cell::Text(text) => Some(text),
        _ => None,
    }
}
