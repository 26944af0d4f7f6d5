//! A clip without the frames that show no motion: rest poses and a T-pose at the beginning, a T-pose at the end, and
//! held frames. So the measures of the motion do not depend on how long these frames last.

use glam::{Quat, Vec3};
use mocap_figure::Figure;
use mocap_scene::scene::{Animation, Channel, Keys, Scene};

use super::defects;
use super::motion::Motion;

/// Held frames of up to this time, in seconds, are kept, because they may be doubled frames.
const LONGEST: f64 = 0.1;

/// The fewest moving frames. A clip with fewer moving frames is examined as a whole.
const LEAST: usize = 8;

/// The frames in which the body moves. `None` if the body moves in all frames, or in hardly any frame.
pub(super) fn moving_frames(scene: &Scene, motion: &Motion) -> Option<Vec<usize>> {
    let longest = motion.frames_in(LONGEST);
    let mut moves = vec![true; motion.frames];
    let searched = defects::searched(motion);
    moves[..searched.start].fill(false);
    moves[searched.end..].fill(false);
    for [from, to] in super::spans(motion.frames, |frame| motion.held[frame]) {
        if to + 1 - from > longest {
            moves[from..=to].fill(false);
        }
    }
    let frames: Vec<usize> = (0..motion.frames).filter(|frame| moves[*frame]).collect();
    let has_other_frames = frames.len() < motion.frames && frames.len() >= LEAST;
    (has_other_frames && !scene.has_points()).then_some(frames)
}

/// The part of a clip in which the body moves. The part takes the keys out of the clip, because a copy of a long clip's
/// keys takes too much memory. [`give_back`](Self::give_back) returns them.
pub(super) struct MovingPart {
    pub(super) scene: Scene,
    pub(super) figure: Figure,
    /// For each frame of the part, the frame of the clip.
    pub(super) frames: Vec<usize>,
    /// The keys of the frames that are not in the part, for each channel.
    others: Vec<Others>,
}

struct Others {
    positions: OtherKeys<Vec3>,
    rotations: OtherKeys<Quat>,
    scales: OtherKeys<Vec3>,
}

/// The values of the other frames; `None` where the clip still has its keys.
type OtherKeys<T> = Option<Vec<T>>;

impl MovingPart {
    pub(super) fn take(scene: &mut Scene, animation: usize, frames: Vec<usize>) -> Self {
        let clip = &mut scene.animations[animation];
        let take = |channel: &mut Channel| {
            let (position_keys, positions) = take(&mut channel.position_keys, &frames, Keys::<Vec3>::sample);
            let (rotation_keys, rotations) = take(&mut channel.rotation_keys, &frames, Keys::<Quat>::sample);
            let (scaling_keys, scales) = take(&mut channel.scaling_keys, &frames, Keys::<Vec3>::sample);
            let channel = Channel {
                node_name: channel.node_name.clone(),
                node: channel.node,
                position_keys,
                rotation_keys,
                scaling_keys,
            };
            let others = Others {
                positions,
                rotations,
                scales,
            };
            (channel, others)
        };
        let (channels, others) = clip.channels.iter_mut().map(take).unzip();
        let animation = Animation {
            name: clip.name.clone(),
            ticks_per_second: clip.ticks_per_second,
            duration: (frames.len() - 1) as f64,
            channels,
        };
        let scene = Scene {
            nodes: scene.nodes.clone(),
            meshes: scene.meshes.clone(),
            metadata: scene.metadata.clone(),
            animations: vec![animation],
            ..Scene::default()
        };
        let figure = Figure::new(&scene);
        Self {
            scene,
            figure,
            frames,
            others,
        }
    }

    /// Gives the clip its keys back.
    pub(super) fn give_back(self, clip: &mut Animation) {
        let taken = self.scene.animations.into_iter().flat_map(|clip| clip.channels);
        for ((channel, taken), others) in clip.channels.iter_mut().zip(taken).zip(self.others) {
            give_back(
                &mut channel.position_keys,
                taken.position_keys,
                others.positions,
                &self.frames,
            );
            give_back(
                &mut channel.rotation_keys,
                taken.rotation_keys,
                others.rotations,
                &self.frames,
            );
            give_back(
                &mut channel.scaling_keys,
                taken.scaling_keys,
                others.scales,
                &self.frames,
            );
        }
    }
}

/// Returns the keys of `frames`. If these keys were moved out of `keys`, also returns the values of all other frames.
fn take<T: Copy>(
    keys: &mut Keys<T>,
    frames: &[usize],
    sample: fn(&Keys<T>, f64) -> Option<T>,
) -> (Keys<T>, OtherKeys<T>) {
    if keys.len() < 2 {
        return (keys.clone(), None);
    }
    let is_every_frame = keys.ticks.is_none() && frames.last().is_some_and(|last| *last < keys.len());
    if !is_every_frame {
        let values = frames.iter().filter_map(|frame| sample(keys, *frame as f64));
        return (Keys::every_tick(values.collect()), None);
    }
    let mut values = std::mem::take(&mut keys.values);
    let mut others = Vec::with_capacity(values.len() - frames.len());
    let mut kept = 0;
    for frame in 0..values.len() {
        if frames.get(kept) == Some(&frame) {
            values[kept] = values[frame];
            kept += 1;
        } else {
            others.push(values[frame]);
        }
    }
    values.truncate(kept);
    (Keys::every_tick(values), Some(others))
}

/// Undoes [`take`].
fn give_back<T: Copy>(keys: &mut Keys<T>, taken: Keys<T>, others: OtherKeys<T>, frames: &[usize]) {
    let Some(mut others) = others else { return };
    let mut values = taken.values;
    let mut kept = values.len();
    let Some(first) = values.first().copied() else { return };
    values.resize(kept + others.len(), first);
    for frame in (0..values.len()).rev() {
        if kept > 0 && frames[kept - 1] == frame {
            kept -= 1;
            values[frame] = values[kept];
        } else if let Some(other) = others.pop() {
            values[frame] = other;
        }
    }
    keys.values = values;
}
