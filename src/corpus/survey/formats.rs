//! Writes the rows in file formats.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::csv_field;
use mocap_scene::report::indented_json;
use mocap_scene::visible_json;

use super::corpus::Corpus;
use super::row::{Cell, ClipRow};

impl Corpus {
    /// The extensions of the formats that [`to_format`](Self::to_format) writes.
    pub const FORMATS: [&str; 5] = ["parquet", "csv", "json", "jsonl", "txt"];

    /// The bytes of a file with the rows: `csv`, `json`, `parquet`, `jsonl` ([record](Self::to_record)) or `txt`
    /// ([list](Self::to_list) of files).
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for another format, and for Parquet in a build without the feature `parquet`.
    pub fn to_format(&self, extension: &str) -> Result<Vec<u8>> {
        Ok(match extension {
            "csv" => self.to_csv().into_bytes(),
            "json" => self.to_json().into_bytes(),
            "jsonl" => self.to_record().into_bytes(),
            "txt" => self.to_list().into_bytes(),
            #[cfg(feature = "parquet")]
            "parquet" => mocap_io::export::parquet::to_parquet([self.to_table()])?,
            #[cfg(not(feature = "parquet"))]
            "parquet" => {
                let message = "this build cannot write Parquet; build it with the feature `parquet`";
                return Err(Diagnostic::new(Code::InvalidValue, message).into());
            }
            _ => {
                let message = "a survey cannot be written in this format";
                let known = Self::FORMATS.join(", ");
                return Err(Diagnostic::new(Code::InvalidValue, message)
                    .expected_found(known, extension)
                    .into());
            }
        })
    }

    /// The rows as JSON, an array of objects.
    pub fn to_json(&self) -> String {
        let rows: Vec<&ClipRow> = self.rows().collect();
        let text = indented_json(&rows).expect("rows have string keys and finite numbers");
        visible_json(&text).into_owned()
    }

    /// The record: one line for each clip, a JSON object with the row and the data that is compared with other clips.
    pub fn to_record(&self) -> String {
        self.clips().iter().map(|clip| clip.to_line() + "\n").collect()
    }

    /// The files of the clips, one per line.
    pub fn to_list(&self) -> String {
        let files: BTreeSet<&str> = self.rows().map(|row| row.file.as_str()).collect();
        files.into_iter().map(|file| format!("{file}\n")).collect()
    }

    /// The rows as CSV, without the findings.
    pub fn to_csv(&self) -> String {
        let columns = ClipRow::column_names();
        let mut csv = columns.join(",") + "\n";
        for row in self.rows() {
            let cells = columns.iter().map(|column| match row.cell(column) {
                Some(Cell::Flag(flag)) => flag.to_string(),
                Some(Cell::Number(number)) => number.to_string(),
                Some(Cell::Text(text)) => csv_field(&text, false),
                Some(Cell::Nothing) | None => String::new(),
            });
            let _ = writeln!(csv, "{}", cells.collect::<Vec<_>>().join(","));
        }
        csv
    }
}
