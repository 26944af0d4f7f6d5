//! `mocap fk`: writes a motion as arrays.

use std::path::Path;

use mocap::arrays::{Arrays, arrays, csv, npz};
use mocap::export::write_file;
use mocap::{Code, Importer, Scene, SkeletonMesh};

use super::check_output;
use crate::args::FkArgs;
use crate::{Failure, report};

pub(crate) fn run(args: &FkArgs) -> Result<(), Failure> {
    let write = writer(&args.output)?;
    check_output(&[&args.input], &args.output)?;
    let scene = import(args)?;
    report::warnings(Some(&args.input), &scene.warnings);
    report::clip_taken(&scene);
    let motion = arrays(&scene, &args.arrays.options()).map_err(|error| error.with_path(&args.input))?;
    for assumption in &motion.header.provenance.assumptions {
        report::say(&assumption.to_string());
    }
    let clip = args.input.file_name().unwrap_or_default().to_string_lossy();
    let bytes = write(&motion, &clip)?;
    write_file(&args.output, &bytes)?;
    report::say(&format!(
        "{} -> {}: {} frames of {} joints, {} bytes",
        args.input.display(),
        args.output.display(),
        motion.frames,
        motion.joints().len(),
        bytes.len(),
    ));
    Ok(())
}

type Writer = fn(&Arrays, &str) -> Result<Vec<u8>, mocap::Error>;

/// The writer for the extension of `output`; its arguments are the motion and the name of the clip.
fn writer(output: &Path) -> Result<Writer, Failure> {
    let extension = output.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("npz") => Ok(|motion, _| Ok(npz::write(motion))),
        Some("csv") => Ok(|motion, _| Ok(csv::write(motion).into_bytes())),
        #[cfg(feature = "parquet")]
        Some("parquet") => Ok(mocap::arrays::parquet::write),
        #[cfg(not(feature = "parquet"))]
        Some("parquet") => {
            let message = "this build cannot write Parquet; build it with `--features parquet`";
            Err(Failure::Usage(message.to_owned()))
        }
        _ => {
            let message = format!(
                "{}: the name of the output must end in .npz, .csv or .parquet",
                output.display()
            );
            Err(Failure::Usage(message))
        }
    }
}

/// For a file without a valid frame rate, the rate to write is also the file's.
fn import(args: &FkArgs) -> Result<Scene, mocap::Error> {
    let importer = || -> Importer { args.read.importer().skeleton_mesh(SkeletonMesh::None) };
    match (importer().import(&args.input), args.arrays.fps) {
        (Err(error), Some(rate)) if error.code() == Code::FrameTime => importer().frame_rate(rate).import(&args.input),
        (result, _) => result,
    }
}
