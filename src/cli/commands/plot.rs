//! `mocap plot`: draws curves of a joint.

use std::path::Path;

use mocap::figure::Humanoid;
use mocap::figure::names::node_named;
use mocap::render::{Clip, Drawing, PlotOptions};
use mocap::scene::{NodeId, Scene};

use super::{check_picture, import_motion, short_name, write_drawing};
use crate::Failure;
use crate::args::PlotArgs;

pub(crate) fn run(args: &PlotArgs) -> Result<(), Failure> {
    let format = check_picture(&[&args.file], &args.picture)?;
    let scene = import_motion(&args.read, &args.file)?;
    let joints = joints_named(&scene, &args.joint, &args.file)?;
    let name = short_name(&args.file);
    let options = PlotOptions::new().width(args.width);
    write_drawing(
        &Drawing::plot(
            &Clip {
                name: &name,
                scene: &scene,
            },
            &joints,
            &options,
        ),
        &args.picture,
        &format,
    )
}

/// The joints of the scene with these names, or with these bones.
pub(super) fn joints_named(scene: &Scene, names: &[String], file: &Path) -> Result<Vec<NodeId>, Failure> {
    let humanoid = Humanoid::of(scene);
    let find = |name: &String| node_named(scene, name, |bone| humanoid.joint(bone));
    let found: mocap::Result<_> = names.iter().map(find).collect();
    Ok(found.map_err(|error| error.with_path(file))?)
}
