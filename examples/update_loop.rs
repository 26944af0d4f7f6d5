//! The loop of a first course in animation: for every tick, update the nodes' matrices, then draw.
//!
//!     cargo run --example update_loop -- walk.bvh
//!
//! Drawing is a line of text here: the origin of every node in the world.

use std::error::Error;
use std::io::{self, Write};

use mocap::glam::{Mat4, Vec3};
use mocap::{Scene, Updater};

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).ok_or("usage: update_loop FILE")?;
    run(&file, &mut io::stdout().lock())
}

pub(crate) fn run(file: &str, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let mut scene = mocap::import(file)?;
    let updater = Updater::new(&scene, 0).ok_or("the file has no motion")?;

    let duration = scene.animations[0].duration;
    let mut tick = 0.0;
    while tick <= duration {
        updater.update(&mut scene, tick);
        draw(&scene, tick, out)?;
        tick += 1.0;
    }
    Ok(())
}

/// Parents stand before their children, so the way down from the root is a loop.
fn draw(scene: &Scene, tick: f64, out: &mut impl Write) -> io::Result<()> {
    let mut node_to_world: Vec<Mat4> = Vec::with_capacity(scene.nodes.len());
    for node in &scene.nodes {
        let parent_to_world = node
            .parent
            .map_or(Mat4::IDENTITY, |parent| node_to_world[parent.index()]);
        let matrix = parent_to_world * node.transform;
        let Vec3 { x, y, z } = matrix.transform_point3(Vec3::ZERO);
        writeln!(out, "{tick} {} {x:.3} {y:.3} {z:.3}", node.name)?;
        node_to_world.push(matrix);
    }
    Ok(())
}
