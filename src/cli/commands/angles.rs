//! `mocap angles` and `mocap gait`: joint angles and gait parameters for biomechanics.

use std::fmt;

use mocap::biomechanics::report::{AngleCycle, AnimalGait, MeanAndDeviation, OutputDifference, SideOfGait};
use mocap::biomechanics::{BodyGait, Gait, JointAngles};
use mocap::figure::Side;
use serde::Serialize;

use super::{Place, check_json, import_motion, mapped_figure, print_report};
use crate::args::{AnglesArgs, GaitArgs};
use crate::printed::{AnglesReport, beside};
use crate::{Failure, report, streams};

pub(crate) fn angles(args: &AnglesArgs) -> Result<(), Failure> {
    let format = super::output_format(&args.output, args.to.as_deref(), "csv")?;
    if !["mot", "csv"].contains(&format.as_str()) {
        return Err(super::unknown_extension(&args.output, ".mot or .csv"));
    }
    check_json(args.json, &args.output)?;
    streams::check_output(&[&args.input], &args.output, args.force.force)?;
    let mut scene = import_motion(&args.read, &args.input)?;
    report::warnings(Some(&args.input), &args.source.contradictions(&scene));
    args.source.state(&mut scene);
    let figure = mapped_figure(&scene, &args.map)?;
    let angles = JointAngles::of_figure(&scene, &figure).map_err(|error| error.with_path(&args.input))?;
    let text = match format.as_str() {
        "mot" => angles.to_mot(),
        _ => angles.to_csv(),
    };
    streams::write(&args.output, text.as_bytes())?;
    let found = AnglesReport {
        input: args.input.display().to_string(),
        output: args.output.display().to_string(),
        frames: angles.frames(),
        columns: &angles.columns,
        note: faces_aside(&angles),
        beside_outputs: angles.beside_outputs(&scene),
    };
    print_report(&found, args.json, Place::Message)
}

/// The warning about a pelvis that does not face the laboratory's forward axis. Tilt and list are angles about the
/// laboratory's axes, so they do not fit such a pelvis.
fn faces_aside(angles: &JointAngles) -> Option<String> {
    /// The angle between the pelvis and the laboratory's forward axis above which the command warns, in degrees. At
    /// twice this angle, tilt and list are exchanged.
    const ASIDE: f64 = 45.0;
    let column = angles.columns.iter().position(|name| name == "pelvis_rotation")?;
    let rows = angles.values.chunks_exact(angles.columns.len());
    let (sin, cos) = rows.fold((0.0, 0.0), |(sin, cos), row| {
        let rotation = row[column].to_radians();
        (sin + rotation.sin(), cos + rotation.cos())
    });
    let mean = sin.atan2(cos).to_degrees();
    let side = if mean > 0.0 { "left" } else { "right" };
    (mean.abs() > ASIDE).then(|| {
        format!(
            "on average, the pelvis faces {:.0} degrees to the {side} of +Z, the laboratory's forward direction. \
             Pelvic tilt and list are about axes of the laboratory, not of the walk. mocap edit --step turn:facing=z \
             turns the motion to +Z",
            mean.abs()
        )
    })
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(crate) enum GaitReport<'a> {
    Person(GaitOfPerson<'a>),
    Animal(GaitOfAnimal<'a>),
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct GaitOfPerson<'a> {
    file: String,
    #[serde(flatten)]
    gait: &'a Gait,
    /// The differences between the angles and the angles that a model stated in the file.
    beside_outputs: Vec<OutputDifference>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct GaitOfAnimal<'a> {
    file: String,
    #[serde(flatten)]
    gait: &'a AnimalGait,
}

pub(crate) fn gait(args: &GaitArgs) -> Result<(), Failure> {
    let mut scene = import_motion(&args.read, &args.file)?;
    report::warnings(Some(&args.file), &args.source.contradictions(&scene));
    args.source.state(&mut scene);
    let figure = mapped_figure(&scene, &args.map)?;
    let file = args.file.display().to_string();
    let gait = match BodyGait::of_figure(&scene, &figure).map_err(|error| error.with_path(&args.file))? {
        BodyGait::Humanoid(gait) => gait,
        BodyGait::Animal(gait) => {
            let found = GaitReport::Animal(GaitOfAnimal { file, gait: &gait });
            return print_report(&found, args.json, Place::Result);
        }
    };
    let has_outputs = scene
        .metadata
        .recorded
        .as_ref()
        .is_some_and(|recorded| !recorded.outputs.is_empty());
    let angles = has_outputs.then(|| JointAngles::of_figure(&scene, &figure)).transpose();
    let angles = angles.map_err(|error| error.with_path(&args.file))?;
    let found = GaitReport::Person(GaitOfPerson {
        file,
        gait: &gait,
        beside_outputs: angles.map_or_else(Vec::new, |angles| angles.beside_outputs(&scene)),
    });
    print_report(&found, args.json, Place::Result)
}

/// A row of the table: its name, its unit, and the measure of a side.
type Row = (&'static str, &'static str, fn(&SideOfGait) -> Option<MeanAndDeviation>);

const ROWS: [Row; 7] = [
    ("speed", "m/s", |side| side.speed),
    ("stride length", "m", |side| side.stride_length),
    ("step length", "m", |side| side.step_length),
    ("step width", "m", |side| side.step_width),
    ("stride time", "s", |side| side.stride_time),
    ("step time", "s", |side| side.step_time),
    ("stance", "%", |side| side.stance),
];

impl fmt::Display for GaitReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Person(found) => found.fmt(f),
            Self::Animal(found) => write_stretches(f, &found.file, found.gait),
        }
    }
}

impl fmt::Display for GaitOfPerson<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gait = self.gait;
        let strides = |side: Side| gait.strides.iter().filter(|stride| stride.side == side).count();
        let (left, right) = (strides(Side::Left), strides(Side::Right));
        writeln!(
            f,
            "{}: {left} strides of the left foot, {right} of the right",
            self.file
        )?;
        if let Some(cadence) = gait.cadence {
            writeln!(f, "cadence: {cadence:.1} steps/min")?;
        }
        if gait.events_of_file {
            writeln!(f, "the events come from the file")?;
        }
        if gait.events_of_plates > 0 {
            writeln!(
                f,
                "the times of {} events come from force plates",
                gait.events_of_plates
            )?;
        }
        if !gait.alternates {
            writeln!(f, "the feet do not alternate: this may not be a walk")?;
        }
        if gait.in_place {
            writeln!(f, "the body stays in place, as on a treadmill: no lengths, no speed")?;
        }
        writeln!(f)?;
        writeln!(f, "{:22}{:>17}{:>17}", "mean +- deviation", "left", "right")?;
        for (name, unit, measure) in ROWS {
            let cells = [&gait.left, &gait.right].map(|side| cell(measure(side)));
            if cells.iter().any(|cell| cell != "-") {
                writeln!(f, "{:22}{:>17}{:>17}", format!("{name}, {unit}"), cells[0], cells[1])?;
            }
        }
        write_cycles(f, gait)?;
        writeln!(f)?;
        for (time, side, event) in events(gait) {
            writeln!(f, "{time:9.3} s  {side:5}  {event}")?;
        }
        beside(&self.beside_outputs).try_for_each(|line| writeln!(f, "{line}"))
    }
}

/// Prints the gaits of an animal.
fn write_stretches(f: &mut fmt::Formatter<'_>, file: &str, gait: &AnimalGait) -> fmt::Result {
    writeln!(f, "{file}: an animal on four legs\n")?;
    let head = [
        "frames",
        "time, s",
        "gait",
        "confidence",
        "strides",
        "duty",
        "lag",
        "m/s",
    ];
    let [frames, time, name, confidence, strides, duty, lag, speed] = head;
    writeln!(
        f,
        "{frames:>13}  {time:>13}  {name:7} {confidence:10} {strides:>7} {duty:>6} {lag:>6} {speed:>6}"
    )?;
    for stretch in &gait.stretches {
        let frames = stretch.frames.map(|frame| frame.to_string()).join(" - ");
        let time = stretch
            .frames
            .map(|frame| format!("{:.2}", frame as f64 / gait.frame_rate));
        let [duty, lag, speed] = [stretch.duty_factor, stretch.lag, stretch.speed]
            .map(|measure| measure.map_or_else(|| "-".to_owned(), |measure| format!("{measure:.2}")));
        let (name, confidence) = (stretch.gait.as_str(), stretch.confidence.as_str());
        let (time, strides) = (time.join(" - "), stretch.strides);
        writeln!(
            f,
            "{frames:>13}  {time:>13}  {name:7} {confidence:10} {strides:>7} {duty:>6} {lag:>6} {speed:>6}"
        )?;
    }
    Ok(())
}

/// The angles that are printed over the average stride. With `--json`, all angles are printed.
const CYCLES: [&str; 3] = ["hip_flexion", "knee_angle", "ankle_angle"];

/// The step between two printed values of a stride, in per cent of the stride.
const CYCLE_STEP: usize = 10;

/// Prints the most used angles over the average stride.
fn write_cycles(f: &mut fmt::Formatter<'_>, gait: &Gait) -> fmt::Result {
    let is_printed = |cycle: &&AngleCycle| CYCLES.iter().any(|name| cycle.column.starts_with(name));
    let cycles: Vec<&AngleCycle> = [&gait.left, &gait.right]
        .into_iter()
        .flat_map(|side| side.cycles.iter().filter(is_printed))
        .collect();
    if cycles.is_empty() {
        return Ok(());
    }
    let steps = || (0..=100).step_by(CYCLE_STEP);
    let head: String = steps().map(|per_cent| format!("{per_cent:5}%")).collect();
    writeln!(f, "\n{:14}{head}", "mean, degrees")?;
    for cycle in cycles {
        let row: String = steps()
            .map(|per_cent| format!("{:6.1}", cycle.mean[per_cent]))
            .collect();
        writeln!(f, "{:14}{row}", cycle.column)?;
    }
    Ok(())
}

/// Time, foot and event, sorted by time.
fn events(gait: &Gait) -> Vec<(f64, &'static str, &'static str)> {
    let mut events = Vec::new();
    for (name, side) in [("left", &gait.left), ("right", &gait.right)] {
        events.extend(side.heel_strikes.iter().map(|time| (*time, name, "heel strike")));
        events.extend(side.toe_offs.iter().map(|time| (*time, name, "toe off")));
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    events
}

fn cell(measure: Option<MeanAndDeviation>) -> String {
    let Some(MeanAndDeviation {
        mean, deviation, count, ..
    }) = measure
    else {
        return "-".to_owned();
    };
    match count {
        1 => format!("{mean:.2}"),
        _ => format!("{mean:.2} +- {deviation:.2}"),
    }
}
