//! What motions of one skeleton show together: its unit, which joint is which bone, and its T-pose.

use super::Maker;
use crate::error::Result;
use crate::figure::{Axis, Figure};
use crate::scene::{Animation, Channel, Keys, Node, Scene};

/// Motions of one skeleton of which frames are kept, at most.
const MOTIONS: usize = 16;

/// Frames of each, about.
const FRAMES: usize = 200;

/// A skeleton with which several motions may stand.
#[derive(Clone, Debug)]
pub(super) struct Skeleton {
    /// Its nodes, with some frames of its motions.
    scene: Scene,
    /// Up in the world of the motions: files of one skeleton may be written along different axes.
    up: Axis,
    /// How many motions have it, and of how many of them one is kept.
    motions: usize,
    stride: usize,
    figure: Figure,
}

/// What other motions of its skeleton say of a motion.
pub(super) struct Shared<'a> {
    /// The figure of the motion, with the bones and the unit of all.
    pub(super) figure: Figure,
    /// Frames of all, which show the T-pose.
    pub(super) shown: &'a [Animation],
}

/// The skeletons of motions that are in memory one after the other. What cannot be read is told when it is made.
pub(super) fn skeletons(maker: &Maker<'_>, scenes: impl Iterator<Item = Result<Scene>>) -> Vec<Skeleton> {
    let mut all: Vec<Skeleton> = Vec::new();
    for mut scene in scenes.flatten() {
        maker.job.source.space.state(&mut scene);
        let Ok(figure) = Figure::mapped(&scene, &maker.bones) else {
            continue;
        };
        let up = figure.up.value;
        scene.meshes.clear();
        match all
            .iter_mut()
            .find(|skeleton| skeleton.up == up && skeleton.is_of(&scene))
        {
            Some(skeleton) => skeleton.add(scene.animations),
            None => {
                let animations = std::mem::take(&mut scene.animations);
                let mut skeleton = Skeleton {
                    scene,
                    up,
                    motions: 0,
                    stride: 1,
                    figure,
                };
                skeleton.add(animations);
                all.push(skeleton);
            }
        }
    }
    all.retain(|skeleton| skeleton.motions > 1);
    for skeleton in &mut all {
        if let Ok(figure) = Figure::mapped(&skeleton.scene, &maker.bones) {
            skeleton.figure = figure;
        }
    }
    all
}

impl Skeleton {
    /// Whether a scene has these nodes: names, parents, and where those below the root are at rest.
    fn is_of(&self, scene: &Scene) -> bool {
        let is_alike = |(node, other): (&Node, &Node)| {
            let is_placed_alike = node.parent.is_none() || node.transform == other.transform;
            node.name == other.name && node.parent == other.parent && is_placed_alike
        };
        self.scene.nodes.len() == scene.nodes.len() && std::iter::zip(&self.scene.nodes, &scene.nodes).all(is_alike)
    }

    /// Adds some frames of a motion. Of many motions those are kept that are evenly spread.
    fn add(&mut self, animations: Vec<Animation>) {
        if self.motions.is_multiple_of(self.stride)
            && let Some(first) = animations.into_iter().next()
        {
            self.scene.animations.push(some_frames(first));
            if self.scene.animations.len() > MOTIONS {
                let mut index = 0;
                self.scene.animations.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.stride *= 2;
            }
        }
        self.motions += 1;
    }

    /// What the motions say of a scene of this skeleton; `None` of another.
    pub(super) fn shared(&self, scene: &Scene) -> Option<Shared<'_>> {
        if !self.is_of(scene) {
            return None;
        }
        let mut figure = Figure::with_bones(scene, self.figure.humanoid.clone());
        if !figure.survey.unit_is_stated {
            let of_all = &self.figure.survey;
            figure.survey.unit = of_all.unit.clone();
            figure.survey.metres_per_unit = of_all.metres_per_unit;
        }
        let shown = &self.scene.animations;
        (figure.up.value == self.up).then_some(Shared { figure, shown })
    }
}

/// Every so many frames of a motion, beginning with the first.
fn some_frames(animation: Animation) -> Animation {
    let step = animation.frame_count().div_ceil(FRAMES).max(1);
    let channel = |channel: Channel| Channel {
        position_keys: some_keys(channel.position_keys, step),
        rotation_keys: some_keys(channel.rotation_keys, step),
        scaling_keys: some_keys(channel.scaling_keys, step),
        ..channel
    };
    Animation {
        duration: (animation.duration / step as f64).floor(),
        ticks_per_second: animation.ticks_per_second / step as f64,
        channels: animation.channels.into_iter().map(channel).collect(),
        ..animation
    }
}

fn some_keys<T>(keys: Keys<T>, step: usize) -> Keys<T> {
    match keys.ticks {
        // A key stays at its time where not every tick has one.
        Some(ticks) => Keys::at_ticks(keys.values, ticks.iter().map(|tick| tick / step as f64).collect()),
        None => Keys::every_tick(keys.values.into_iter().step_by(step).collect()),
    }
}
