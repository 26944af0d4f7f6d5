//! A clip without the frames that show no motion: rest poses and a T-pose at its beginning, a T-pose at its end, and
//! frames that repeat the previous frame. What is measured in the others does not depend on how long these are held.

use glam::{Quat, Vec3};
use mocap_figure::Figure;
use mocap_scene::scene::{Animation, Keys, Scene};

use super::defects;
use super::motion::Motion;

/// Repeats of a frame up to this time in seconds stay: they may be doubled frames.
const LONGEST: f64 = 0.1;

/// The fewest frames that are a motion.
const LEAST: usize = 8;

/// The part of a clip in which the body moves.
pub(super) struct MovingPart {
    pub(super) scene: Scene,
    pub(super) figure: Figure,
    /// Of each of its frames, the frame of the clip.
    pub(super) frames: Vec<usize>,
}

impl MovingPart {
    /// `None` where the body moves all the time, or hardly ever.
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
        let mut animation = animation.clone();
        for channel in &mut animation.channels {
            keep(&mut channel.position_keys, &frames, Keys::<Vec3>::sample);
            keep(&mut channel.rotation_keys, &frames, Keys::<Quat>::sample);
            keep(&mut channel.scaling_keys, &frames, Keys::<Vec3>::sample);
        }
        animation.duration = (frames.len() - 1) as f64;
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

fn keep<T: Copy>(keys: &mut Keys<T>, frames: &[usize], sample: fn(&Keys<T>, f64) -> Option<T>) {
    if keys.len() > 1 {
        let values = frames.iter().filter_map(|frame| sample(keys, *frame as f64));
        *keys = Keys::every_tick(values.collect());
    }
}
