//! `mocap gif`: draws an animation of a clip.

use mocap::render::{Clip, Movie, MovieOptions};

use super::{import_drawn, on_robot, output_format, short_name, unknown_extension};
use crate::args::GifArgs;
use crate::printed::PictureReport;
use crate::{Failure, streams};

pub(crate) fn run(args: &GifArgs) -> Result<(), Failure> {
    let format = output_format(&args.output, args.to.as_deref(), "gif")?;
    if !["gif", "apng", "png"].contains(&format.as_str()) {
        return Err(unknown_extension(&args.output, ".gif, .apng or .png"));
    }
    super::check_json(args.json, &args.output)?;
    streams::check_output(&[&args.file], &args.output, args.force.force)?;
    let mut scene = import_drawn(&args.read, args.up, &args.file)?;
    if let Some(robot) = &args.robot {
        scene = on_robot(scene, &args.file, robot)?;
    }
    let name = short_name(&args.file);
    let options = MovieOptions::new()
        .width(args.width)
        .height(args.height)
        .frames_per_second(args.rate)
        .speed(args.speed)
        .follow(!args.still);
    let mut movie = Movie::new(
        Clip {
            name: &name,
            scene: &scene,
        },
        &options,
    )?;
    let bytes = match format.as_str() {
        "gif" => movie.to_gif()?,
        _ => movie.to_apng()?,
    };
    streams::write(&args.output, &bytes)?;
    let found = PictureReport {
        output: args.output.display().to_string(),
        width: args.width,
        height: args.height,
        bytes: bytes.len(),
        summary: format!("{movie}, {} bytes", bytes.len()),
    };
    super::print_report(&found, args.json, super::Place::Message)
}
