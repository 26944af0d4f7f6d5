//! `mocap plot`: draws curves of a joint.

use mocap::render::{Clip, Drawing, PlotOptions};
use mocap::scene::{NodeId, Scene};

use super::{import_motion, short_name, write_drawing};
use crate::args::PlotArgs;
use crate::{Failure, streams};

pub(crate) fn run(args: &PlotArgs) -> Result<(), Failure> {
    streams::check_output(&[&args.file], &args.output)?;
    let scene = import_motion(&args.read, &args.file)?;
    let joints = joints_named(&scene, &args.joint)?;
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
        &args.output,
    )
}

/// The joints of these names.
pub(super) fn joints_named(scene: &Scene, names: &[String]) -> Result<Vec<NodeId>, Failure> {
    let find = |name: &String| {
        let index = scene.nodes.iter().position(|node| node.name == *name);
        index.map(NodeId::new).ok_or_else(|| {
            let names: Vec<_> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
            let known = names.join(", ");
            Failure::Usage(format!("no joint is called \"{name}\"; the joints are {known}"))
        })
    };
    names.iter().map(find).collect()
}
