//! `mocap fk`: writes a motion as arrays.

use mocap::arrays::{Arrays, BodyArrays, BodyLayout};
use mocap::{Code, Importer, Scene, SkeletonMesh};

use super::{Place, check_json, output_format, print_report};
use crate::args::{ArgumentSources, FkArgs};
use crate::printed::ArraysReport;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &FkArgs, given: &ArgumentSources) -> Result<(), Failure> {
    if let Some(layout) = args.to.as_deref().and_then(|name| name.parse::<BodyLayout>().ok()) {
        return body(args, given, layout);
    }
    let write = writer(args)?;
    args.arrays.check(&args.source, given)?;
    check_json(args.json, &args.output)?;
    streams::check_output(&[&args.input], &args.output, args.force.force)?;
    let mut scene = import(args)?;
    report::warnings(Some(&args.input), &scene.warnings);
    report::warnings(Some(&args.input), &args.source.contradictions(&scene));
    report::clip_taken(&mut scene);
    let motion = Arrays::of(&scene, &args.arrays.options(&args.source, &args.map))
        .map_err(|error| error.with_path(&args.input))?;
    let notes = motion
        .header
        .provenance
        .assumptions
        .iter()
        .map(ToString::to_string)
        .collect();
    let clip = args.input.file_name().unwrap_or_default().to_string_lossy();
    let bytes = write(&motion, &clip)?;
    streams::write(&args.output, &bytes)?;
    let end_sites = motion.joints().iter().filter(|joint| joint.end_site).count();
    let counts = [motion.frames, motion.joints().len() - end_sites, end_sites];
    tell(args, "", counts, bytes.len(), notes)
}

/// Reports the written frames, joints and end sites.
fn tell(
    args: &FkArgs,
    layout: &str,
    [frames, joints, end_sites]: [usize; 3],
    bytes: usize,
    notes: Vec<String>,
) -> Result<(), Failure> {
    let (input, output) = (args.input.display().to_string(), args.output.display().to_string());
    let found = ArraysReport {
        input,
        output,
        frames,
        joints,
        end_sites,
        bytes,
        notes,
        layout: layout.to_owned(),
    };
    print_report(&found, args.json, Place::Message)
}

/// Writes the motion of a humanoid in the layout of another program.
fn body(args: &FkArgs, given: &ArgumentSources, layout: BodyLayout) -> Result<(), Failure> {
    let why = "the layout determines its arrays";
    let unused = [
        "space",
        "rot",
        "rot-space",
        "joints",
        "fps",
        "trim",
        "out-unit",
        "out-up",
        "velocities",
        "contacts",
        "spreadsheet",
        "map",
    ];
    given.refuse(&unused, why)?;
    if !streams::is_unnamed(&args.output) && super::extension(&args.output) != layout.extension() {
        let message = format!(
            "{}: the arrays of {} are written to a file that ends in .{}",
            args.output.display(),
            layout.as_str(),
            layout.extension()
        );
        return Err(Failure::Usage(message));
    }
    check_json(args.json, &args.output)?;
    streams::check_output(&[&args.input], &args.output, args.force.force)?;
    let mut scene = import(args)?;
    report::warnings(Some(&args.input), &scene.warnings);
    report::clip_taken(&mut scene);
    let written = BodyArrays::new(&scene).and_then(|body| Ok((body.write(layout)?, body.frames)));
    let (bytes, frames) = written.map_err(|error| error.with_path(&args.input))?;
    streams::write(&args.output, &bytes)?;
    let layout_of = format!(" in the layout of {}", layout.as_str());
    let notes = layout.note().into_iter().collect();
    tell(args, &layout_of, [frames, layout.joints(), 0], bytes.len(), notes)
}

type Writer = fn(&Arrays, &str) -> Result<Vec<u8>, mocap::Error>;

/// The writer for the format of the output; its arguments are the motion and the name of
/// the clip.
fn writer(args: &FkArgs) -> Result<Writer, Failure> {
    let output = args.output.as_path();
    let extension = output_format(output, args.to.as_deref(), "csv")?;
    if args.spreadsheet && extension != "csv" {
        let message = "--spreadsheet would do nothing: it only affects .csv";
        return Err(Failure::Usage(message.to_owned()));
    }
    match extension.as_str() {
        "npz" => Ok(|motion, _| Ok(motion.to_npz())),
        "csv" if args.spreadsheet => Ok(|motion, _| Ok(motion.to_csv_for_spreadsheet().into_bytes())),
        "csv" => Ok(|motion, _| Ok(motion.to_csv().into_bytes())),
        #[cfg(feature = "parquet")]
        "parquet" => Ok(Arrays::to_parquet),
        #[cfg(not(feature = "parquet"))]
        "parquet" => Err(super::without_parquet()),
        _ => Err(super::unknown_extension(output, ".npz, .csv or .parquet")),
    }
}

/// Imports the motion. If the file has no valid frame rate, the rate of the options counts as the rate of the file.
fn import(args: &FkArgs) -> Result<Scene, mocap::Error> {
    let importer = || -> Importer { args.read.importer().skeleton_mesh(SkeletonMesh::None) };
    match (streams::import(&importer(), &args.input), args.arrays.fps) {
        (Err(error), Some(rate)) if error.code() == Code::FrameTime => {
            streams::import(&importer().retime(rate), &args.input)
        }
        (result, _) => result,
    }
}
