//! `mocap plot`: draws curves of a joint.

use mocap::SkeletonMesh;
use mocap::render::{Clip, PlotOptions, plot};
use mocap::scene::NodeId;

use super::{check_output, short_name, write_drawing};
use crate::args::PlotArgs;
use crate::{Failure, report};

pub(crate) fn run(args: &PlotArgs) -> Result<(), Failure> {
    check_output(&[&args.file], &args.output)?;
    let scene = args
        .read
        .importer()
        .skeleton_mesh(SkeletonMesh::None)
        .import(&args.file)?;
    report::warnings(Some(&args.file), &scene.warnings);
    report::clip_taken(&scene);
    let mut joints = Vec::new();
    for name in &args.joint {
        let Some(index) = scene.nodes.iter().position(|node| node.name == *name) else {
            let names: Vec<_> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
            let known = names.join(", ");
            return Err(Failure::Usage(format!(
                "no joint is called \"{name}\"; the joints are {known}"
            )));
        };
        joints.push(NodeId::new(index));
    }
    let name = short_name(&args.file);
    let options = PlotOptions {
        width: args.width,
        ..PlotOptions::default()
    };
    write_drawing(
        &plot(
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
