//! `mocap forces` and `mocap analog`: the data of a C3D file other than markers, as time series.

use std::fmt;

use mocap::biomechanics::TimeSeries;
use mocap::{Scene, SkeletonMesh};
use serde::Serialize;

use super::{Place, check_json, print_report};
use crate::args::SeriesArgs;
use crate::{Failure, report, streams};

/// The output of `--json`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct SeriesReport<'a> {
    input: String,
    output: String,
    samples: usize,
    frame_rate: f64,
    columns: &'a [String],
    units: &'a [String],
    notes: &'a [String],
}

impl fmt::Display for SeriesReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.notes.iter().try_for_each(|note| writeln!(f, "{note}"))?;
        let (input, output, samples) = (&self.input, &self.output, self.samples);
        let (columns, rate) = (self.columns.len(), self.frame_rate);
        write!(
            f,
            "{input} -> {output}: {samples} samples of {columns} columns at {rate} Hz"
        )
    }
}

pub(crate) fn forces(args: &SeriesArgs) -> Result<(), Failure> {
    write(args, TimeSeries::ground_forces)
}

pub(crate) fn analog(args: &SeriesArgs) -> Result<(), Failure> {
    write(args, TimeSeries::analog)
}

fn write(args: &SeriesArgs, of_scene: fn(&Scene) -> mocap::Result<TimeSeries>) -> Result<(), Failure> {
    let format = super::output_format(&args.output, args.to.as_deref(), "csv")?;
    let to_bytes: fn(&TimeSeries) -> mocap::Result<Vec<u8>> = match format.as_str() {
        "mot" | "sto" => |series| Ok(series.to_mot().into_bytes()),
        "csv" => |series| Ok(series.to_csv().into_bytes()),
        #[cfg(feature = "parquet")]
        "parquet" => mocap::arrays::time_series_parquet,
        #[cfg(not(feature = "parquet"))]
        "parquet" => return Err(super::without_parquet()),
        _ => return Err(super::unknown_extension(&args.output, ".mot, .sto, .csv or .parquet")),
    };
    check_json(args.json, &args.output)?;
    streams::check_output(&[&args.input], &args.output, args.force.force)?;
    let importer = args.read.importer().skeleton_mesh(SkeletonMesh::None);
    let mut scene = streams::import(&importer, &args.input)?;
    report::warnings(Some(&args.input), &scene.warnings);
    report::clip_taken(&mut scene);
    let series = of_scene(&scene).map_err(|error| error.with_path(&args.input))?;
    streams::write(&args.output, &to_bytes(&series)?)?;
    let found = SeriesReport {
        input: args.input.display().to_string(),
        output: args.output.display().to_string(),
        samples: series.frames(),
        frame_rate: series.frame_rate,
        columns: &series.columns,
        units: &series.units,
        notes: &series.notes,
    };
    print_report(&found, args.json, Place::Message)
}
