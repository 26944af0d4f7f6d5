//! Plays a motion file in a window: cargo run --manifest-path examples/window/Cargo.toml -- walk.bvh

use macroquad::prelude::*;
use mocap::{Binding, Conversion, Player, Pose};

#[macroquad::main("mocap")]
async fn main() {
    let file = std::env::args().nth(1).expect("usage: window FILE");
    let mut scene = mocap::import(file).unwrap_or_else(|error| panic!("{error}"));
    Conversion::new().apply(&mut scene).expect("the defaults are sound");
    let clip = scene.animations.first().expect("the file has no motion");
    let (binding, mut player, mut pose) = (Binding::new(&scene, clip), Player::new(clip), Pose::rest(&scene));
    let mut view = Camera3D::default();
    loop {
        pose.sample(&binding, clip, player.advance(get_frame_time().into()));
        let place = |node: usize| Vec3::from(pose.node_to_world[node].w_axis.truncate().to_array());
        (view.target, view.up) = (vec3(place(0).x, 0.9, place(0).z), Vec3::Y);
        view.position = view.target + vec3(2.0, 0.7, 3.0);
        set_camera(&view);
        clear_background(BLACK);
        draw_grid(40, 0.5, GRAY, DARKGRAY);
        for (node, own) in scene.nodes.iter().enumerate() {
            if let Some(parent) = own.parent {
                draw_line_3d(place(parent.index()), place(node), ORANGE);
            }
        }
        next_frame().await;
    }
}
