//! Nodes of your own, driven by the channels of a file: no `Scene`, no `Pose`.
//!
//!     cargo run --example own_nodes -- walk.bvh Hips LeftHand
//!
//! The names after the file make a chain, each node the child of the one before. Only what the channels say of them is
//! taken from the file.

use std::error::Error;
use std::io::{self, Write};

use mocap::glam::{Mat4, Vec3};
use mocap::scene::Animation;
use mocap::{LoopMode, Player, Trs};

/// A node as a program may have it: a tree of boxes, found by name.
struct Node {
    name: String,
    matrix: Mat4,
    children: Vec<Node>,
}

impl Node {
    fn chain(names: &[&str]) -> Option<Self> {
        let (name, below) = names.split_first()?;
        Some(Self {
            name: (*name).to_owned(),
            matrix: Mat4::IDENTITY,
            children: Self::chain(below).into_iter().collect(),
        })
    }

    fn update(&mut self, animation: &Animation, tick: f64) {
        if let Some(channel) = animation.channels.iter().find(|channel| channel.node_name == self.name) {
            self.matrix = channel.sample(tick, Trs::from_matrix(self.matrix)).matrix();
        }
        for child in &mut self.children {
            child.update(animation, tick);
        }
    }

    fn print(&self, parent_to_world: Mat4, out: &mut impl Write) -> io::Result<()> {
        let node_to_world = parent_to_world * self.matrix;
        let Vec3 { x, y, z } = node_to_world.transform_point3(Vec3::ZERO);
        writeln!(out, "  {} {x:.3} {y:.3} {z:.3}", self.name)?;
        self.children
            .iter()
            .try_for_each(|child| child.print(node_to_world, out))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let (file, names) = args.split_first().ok_or("usage: own_nodes FILE NODE...")?;
    run(file, names, &mut io::stdout().lock())
}

pub(crate) fn run(file: &str, names: &[&str], out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let animation = mocap::import(file)?.animations.pop().ok_or("the file has no motion")?;
    let mut root = Node::chain(names).ok_or("no node is named")?;

    // A fifth of a second from picture to picture, twice as fast as it was captured.
    let mut player = Player::new(&animation);
    player.speed = 2.0;
    player.loop_mode = LoopMode::Once;
    loop {
        root.update(&animation, player.tick);
        writeln!(out, "tick {:.1}", player.tick)?;
        root.print(Mat4::IDENTITY, out)?;
        if player.is_finished() {
            return Ok(());
        }
        player.advance(0.2);
    }
}
