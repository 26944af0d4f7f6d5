//! `mocap plot`: draws curves of a joint.

use mocap::render::{Clip, Drawing, PlotOptions};
use mocap::scene::{NodeId, Scene};

use super::{check_picture, import_motion, short_name, write_drawing};
use crate::Failure;
use crate::args::PlotArgs;
use crate::kinds::nearest;

pub(crate) fn run(args: &PlotArgs) -> Result<(), Failure> {
    let format = check_picture(&[&args.file], &args.picture)?;
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
        &args.picture,
        &format,
    )
}

/// The most joint names in the message about an unknown name.
const MOST_NAMES: usize = 60;

/// The joints of the scene with these names.
pub(super) fn joints_named(scene: &Scene, names: &[String]) -> Result<Vec<NodeId>, Failure> {
    let find = |name: &String| {
        let index = scene.nodes.iter().position(|node| node.name == *name);
        index.map(NodeId::new).ok_or_else(|| {
            let names: Vec<_> = (scene.nodes.iter().map(|node| node.name.as_str()))
                .take(MOST_NAMES)
                .collect();
            let more = match scene.nodes.len() - names.len() {
                0 => String::new(),
                more => format!(" and {more} more; mocap dump prints all"),
            };
            let known = names.join(", ");
            let near = match nearest(name, scene.nodes.iter().map(|node| node.name.as_str())) {
                Some(near) => format!("did you mean \"{near}\"? "),
                None => String::new(),
            };
            Failure::Usage(format!(
                "no joint is called \"{name}\"; {near}the joints are {known}{more}"
            ))
        })
    };
    names.iter().map(find).collect()
}
