//! The way of an end effector through the world, as comma-separated values.
//!
//!     cargo run --example end_effector_path -- walk.bvh > path.csv
//!     cargo run --example end_effector_path -- walk.bvh EndSite_LeftHand > path.csv
//!
//! Without a name it is the first end effector of the file.

use std::error::Error;
use std::io::{self, Write};

use mocap::{Binding, Pose};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let file = args.next().ok_or("usage: end_effector_path FILE [NODE]")?;
    run(&file, args.next().as_deref(), &mut io::stdout().lock())
}

pub(crate) fn run(file: &str, name: Option<&str>, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let scene = mocap::import(file)?;
    let animation = scene.animations.first().ok_or("the file has no motion")?;
    let end = scene
        .end_effectors()
        .find(|end| name.is_none_or(|name| scene.nodes[end.index()].name == name))
        .ok_or("the file has no end effector of this name")?;

    let binding = Binding::new(&scene, animation);
    let mut pose = Pose::rest(&scene);
    writeln!(out, "seconds,x,y,z")?;
    for tick in 0..animation.frame_count() {
        pose.sample(&binding, animation, tick as f64);
        let position = pose.position(end);
        let seconds = tick as f64 / animation.ticks_per_second;
        writeln!(
            out,
            "{seconds:.3},{:.3},{:.3},{:.3}",
            position.x, position.y, position.z
        )?;
    }
    Ok(())
}
