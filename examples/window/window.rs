//! Plays a motion file in a window: cargo run --manifest-path examples/window/Cargo.toml -- walk.bvh

use macroquad::prelude::*;
use mocap::scene::{NodeKind, Scene};
use mocap::{Binding, Conversion, Player, Pose};

#[macroquad::main("mocap")]
async fn main() {
    let file = std::env::args().nth(1).expect("usage: window FILE");
    let mut scene = mocap::import(file).unwrap_or_else(|error| panic!("{error}"));
    Conversion::new().apply(&mut scene).expect("the defaults are sound");
    let clip = scene.animations.first().expect("the file has no motion");
    let (binding, mut player, mut pose) = (Binding::new(&scene, clip), Player::new(clip), Pose::rest(&scene));
    let framing = Framing::new(&scene, &binding, &mut pose);
    let mut is_paused = false;
    loop {
        is_paused ^= is_key_pressed(KeyCode::Space);
        for (key, ticks) in [(KeyCode::Right, 1.0), (KeyCode::Left, -1.0)] {
            if is_key_pressed(key) {
                is_paused = true;
                player.tick = (player.tick + ticks).round().rem_euclid(clip.duration.floor() + 1.0);
            }
        }
        if is_key_pressed(KeyCode::R) {
            player.tick = 0.0;
        } else if !is_paused {
            player.advance(get_frame_time().into());
        }
        pose.sample(&binding, clip, player.tick);
        clear_background(BLACK);
        set_camera(&framing.camera(&pose));
        draw_grid(40, framing.grid(), GRAY, DARKGRAY);
        draw_skeleton(&scene, &pose, 0.02 * framing.radius);
        set_default_camera();
        let text = format!("tick {:.2} / {}    space: pause, arrows: step, R: reset", player.tick, clip.duration);
        draw_text(&text, 16.0, 28.0, 24.0, WHITE);
        next_frame().await;
    }
}

/// The place of a node. macroquad has a glam of its own.
fn place(pose: &Pose, node: usize) -> Vec3 {
    Vec3::from(pose.node_to_world[node].w_axis.truncate().to_array())
}

/// A ball for each joint, and a box as thick as a finger for each link.
fn draw_skeleton(scene: &Scene, pose: &Pose, thickness: f32) {
    for (node, own) in scene.nodes.iter().enumerate().filter(|(_, own)| own.kind != NodeKind::Group) {
        let at = place(pose, node);
        draw_sphere(at, 0.8 * thickness, None, YELLOW);
        if let Some(parent) = own.parent.filter(|parent| scene.nodes[parent.index()].kind != NodeKind::Group) {
            let link = at - place(pose, parent.index());
            let (side, other) = link.normalize_or_zero().any_orthonormal_pair();
            let (side, other) = (side * thickness, other * thickness);
            draw_affine_parallelepiped(at - link - 0.5 * (side + other), link, side, other, None, ORANGE);
        }
    }
}

/// What the camera has to see: all places of all joints, as seen from the first joint, which it follows.
struct Framing {
    root: usize,
    /// From the root.
    middle: Vec3,
    radius: f32,
}

impl Framing {
    fn new(scene: &Scene, binding: &Binding, pose: &mut Pose) -> Self {
        let joints = |node: &usize| scene.nodes[*node].kind != NodeKind::Group;
        let root = (0..scene.nodes.len()).find(joints).unwrap_or(0);
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for tick in 0..=scene.animations[0].duration as u32 {
            pose.sample(binding, &scene.animations[0], tick.into());
            for node in (0..scene.nodes.len()).filter(joints) {
                let at = place(pose, node) - place(pose, root);
                (low, high) = (low.min(at), high.max(at));
            }
        }
        let radius = 0.5 * (high - low).length();
        Self { root, middle: 0.5 * (low + high), radius: if radius > 0.0 { radius } else { 1.0 } }
    }

    fn camera(&self, pose: &Pose) -> Camera3D {
        let target = place(pose, self.root) + self.middle;
        // From so far a ball of this radius fills the picture from top to bottom.
        let distance = self.radius / (0.5 * FIELD_OF_VIEW).sin();
        Camera3D {
            position: target + distance * vec3(0.45, 0.3, 1.0).normalize(),
            target,
            up: Vec3::Y,
            fovy: FIELD_OF_VIEW,
            z_near: 0.01 * distance,
            z_far: 100.0 * distance,
            ..Camera3D::default()
        }
    }

    /// The distance of two lines on the ground: a power of ten, about a fifth of the figure.
    fn grid(&self) -> f32 {
        10_f32.powf((0.4 * self.radius).log10().round())
    }
}

/// From top to bottom, in radians.
const FIELD_OF_VIEW: f32 = 0.8;
