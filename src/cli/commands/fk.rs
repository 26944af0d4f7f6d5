//! `mocap fk`: writes a motion as arrays.

use mocap::arrays::{Arrays, BodyArrays, BodyLayout};
use mocap::{Code, Importer, Scene, SkeletonMesh};

use super::output_format;
use crate::args::{FkArgs, Given};
use crate::{Failure, report, streams};

pub(crate) fn run(args: &FkArgs, given: &Given) -> Result<(), Failure> {
    if let Some(layout) = args.to.as_deref().and_then(|name| name.parse::<BodyLayout>().ok()) {
        return body(args, given, layout);
    }
    let write = writer(args)?;
    args.arrays.check(&args.source, given)?;
    streams::check_output(&[&args.input], &args.output, args.force)?;
    let scene = import(args)?;
    report::warnings(Some(&args.input), &scene.warnings);
    report::clip_taken(&scene);
    let motion = Arrays::of(&scene, &args.arrays.options(&args.source, &args.map))
        .map_err(|error| error.with_path(&args.input))?;
    for assumption in &motion.header.provenance.assumptions {
        report::say(&assumption.to_string());
    }
    let clip = args.input.file_name().unwrap_or_default().to_string_lossy();
    let bytes = write(&motion, &clip)?;
    streams::write(&args.output, &bytes)?;
    let end_sites = motion.joints().iter().filter(|joint| joint.end_site).count();
    report::say(&format!(
        "{} -> {}: {}, {}, {}, {} bytes",
        args.input.display(),
        args.output.display(),
        report::counted(motion.frames, "frame"),
        report::counted(motion.joints().len() - end_sites, "joint"),
        report::counted(end_sites, "end site"),
        bytes.len(),
    ));
    Ok(())
}

/// Writes the motion of a humanoid in the layout of another program.
fn body(args: &FkArgs, given: &Given, layout: BodyLayout) -> Result<(), Failure> {
    let why = "the layout of another program says what its arrays are";
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
    streams::check_output(&[&args.input], &args.output, args.force)?;
    let scene = import(args)?;
    report::warnings(Some(&args.input), &scene.warnings);
    report::clip_taken(&scene);
    let written = BodyArrays::new(&scene).and_then(|body| Ok((body.write(layout)?, body.frames)));
    let (bytes, frames) = written.map_err(|error| error.with_path(&args.input))?;
    streams::write(&args.output, &bytes)?;
    report::say(BodyLayout::NOTE);
    report::say(&format!(
        "{} -> {}: {frames} frames in the layout of {}, {} bytes",
        args.input.display(),
        args.output.display(),
        layout.as_str(),
        bytes.len(),
    ));
    Ok(())
}

type Writer = fn(&Arrays, &str) -> Result<Vec<u8>, mocap::Error>;

/// The writer for the format of the output; its arguments are the motion and the name of
/// the clip.
fn writer(args: &FkArgs) -> Result<Writer, Failure> {
    let output = args.output.as_path();
    let extension = output_format(output, args.to.as_deref(), "csv")?;
    if args.spreadsheet && extension != "csv" {
        let message = "--spreadsheet would do nothing: only .csv is opened in a spreadsheet";
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

/// For a file without a valid frame rate, the rate to write is also the file's.
fn import(args: &FkArgs) -> Result<Scene, mocap::Error> {
    let importer = || -> Importer { args.read.importer().skeleton_mesh(SkeletonMesh::None) };
    match (streams::import(&importer(), &args.input), args.arrays.fps) {
        (Err(error), Some(rate)) if error.code() == Code::FrameTime => {
            streams::import(&importer().retime(rate), &args.input)
        }
        (result, _) => result,
    }
}
