//! A clip without the frames that show no motion: rest poses and a T-pose at the beginning, a T-pose at the end, and
//! held frames. So the measures of the motion do not depend on how long these frames last.

use glam::{Quat, Vec3};
use mocap_figure::Figure;
use mocap_scene::scene::{Animation, Channel, Keys, Scene};

use super::defects;
use super::motion::Motion;

/// Held frames of up to this time, in seconds, are kept, because they may be doubled frames.
const LONGEST: f64 = 0.1;

/// The fewest frames of a motion.
const LEAST: usize = 8;

/// The part of a clip in which the body moves.
pub(super) struct MovingPart {
    pub(super) scene: Scene,
    pub(super) figure: Figure,
    /// For each frame of the part, the frame of the clip.
    pub(super) frames: Vec<usize>,
}

impl MovingPart {
    /// Returns `None` if the body moves in all frames, or in hardly any frame.
    pub(super) fn new(scene: &Scene, animation: &Animation, motion: &Motion) -> Option<Self> {
        let longest = motion.frames_in(LONGEST);
        let mut moves = vec![true; motion.frames];
        moves[..defects::starts(motion)].fill(false);
        moves[defects::stops(motion)..].fill(false);
        for [from, to] in super::spans(motion.frames, |frame| motion.held[frame]) {
            if to + 1 - from > longest {
                moves[from..=to].fill(false);
            }
        }
        let frames: Vec<usize> = (0..motion.frames).filter(|frame| moves[*frame]).collect();
        if scene.has_points() || frames.len() == motion.frames || frames.len() < LEAST {
            return None;
        }
        let channels = animation.channels.iter().map(|channel| Channel {
            node_name: channel.node_name.clone(),
            node: channel.node,
            position_keys: kept(&channel.position_keys, &frames, Keys::<Vec3>::sample),
            rotation_keys: kept(&channel.rotation_keys, &frames, Keys::<Quat>::sample),
            scaling_keys: kept(&channel.scaling_keys, &frames, Keys::<Vec3>::sample),
        });
        let animation = Animation {
            name: animation.name.clone(),
            ticks_per_second: animation.ticks_per_second,
            duration: (frames.len() - 1) as f64,
            channels: channels.collect(),
        };
        let scene = Scene {
            nodes: scene.nodes.clone(),
            meshes: scene.meshes.clone(),
            metadata: scene.metadata.clone(),
            animations: vec![animation],
            ..Scene::default()
        };
        let figure = Figure::new(&scene);
        Some(Self { scene, figure, frames })
    }
}

fn kept<T: Copy>(keys: &Keys<T>, frames: &[usize], sample: fn(&Keys<T>, f64) -> Option<T>) -> Keys<T> {
    if keys.len() < 2 {
        return keys.clone();
    }
    let mut values = Vec::with_capacity(frames.len());
    values.extend(frames.iter().filter_map(|frame| sample(keys, *frame as f64)));
    Keys::every_tick(values)
}
