//! The data that motions of one skeleton share: the unit, the bone map and the T-pose.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

use mocap_figure::{Axis, Confidence, Figure};
use mocap_scene::error::Result;
use mocap_scene::scene::{Animation, Channel, Keys, Node, Scene, UpAxis};

use super::Maker;

/// The most motions of one skeleton whose frames are kept.
const MOTIONS: usize = 16;

/// The approximate number of kept frames of each motion.
const FRAMES: usize = 200;

/// A skeleton that several motions may share.
#[derive(Clone, Debug)]
pub(super) struct Skeleton {
    /// The nodes of the skeleton, with some frames of its motions.
    scene: Scene,
    /// The up axis in the world of the motions. Files of one skeleton may have different up axes.
    up: Axis,
    /// Whether the up axis of one of the motions is certain.
    up_is_sure: bool,
    /// The number of motions with the skeleton. The frames of every `stride`th motion are kept.
    motions: usize,
    stride: usize,
    figure: Figure,
}

/// The data that a motion shares with other motions of its skeleton.
pub(super) struct Shared<'a> {
    /// The figure of the motion, with the bones and the unit of all motions.
    pub(super) figure: Figure,
    /// Frames of all motions, which show the T-pose.
    pub(super) shown: &'a [Animation],
}

/// The skeletons of motions, and the skeleton of each motion. Only one motion is in memory at a time. A file that
/// cannot be read is reported when its output is made.
pub(super) fn skeletons(
    maker: &Maker<'_>,
    motions: impl Iterator<Item = (PathBuf, Result<Scene>)>,
) -> (Vec<Skeleton>, BTreeMap<PathBuf, usize>) {
    let mut all: Vec<Skeleton> = Vec::new();
    let mut of_motions = BTreeMap::new();
    for (motion, scene) in motions {
        let Ok(mut scene) = scene else { continue };
        maker.job.source.space.state(&mut scene);
        let Ok(figure) = Figure::mapped(&scene, &maker.bones) else {
            continue;
        };
        let up = figure.up.value;
        let up_is_sure = figure.up.confidence == Confidence::Sure;
        scene.meshes.clear();
        let known = all
            .iter()
            .position(|skeleton| skeleton.up == up && skeleton.is_of(&scene));
        of_motions.insert(motion, known.unwrap_or(all.len()));
        match known.map(|known| &mut all[known]) {
            Some(skeleton) => {
                skeleton.up_is_sure |= up_is_sure;
                skeleton.add(scene.animations);
            }
            None => {
                let animations = std::mem::take(&mut scene.animations);
                let mut skeleton = Skeleton {
                    scene,
                    up,
                    up_is_sure,
                    motions: 0,
                    stride: 1,
                    figure,
                };
                skeleton.add(animations);
                all.push(skeleton);
            }
        }
    }
    for skeleton in all.iter_mut().filter(|skeleton| skeleton.motions > 1) {
        if let Ok(figure) = Figure::mapped(&skeleton.scene, &maker.bones) {
            skeleton.figure = figure;
        }
    }
    (all, of_motions)
}

/// The up axis of other motions with the skeleton of a scene, if their axes are certain and agree.
pub(super) fn up_of_others(all: &[Skeleton], scene: &Scene) -> Option<UpAxis> {
    let mut sure = all
        .iter()
        .filter(|skeleton| skeleton.up_is_sure && skeleton.is_of(scene));
    let first = sure.next()?;
    first.up.up().filter(|_| sure.next().is_none())
}

impl Skeleton {
    /// Whether a scene has these nodes: equal names, parents, and rest positions below the root.
    fn is_of(&self, scene: &Scene) -> bool {
        let is_alike = |(node, other): (&Node, &Node)| {
            let is_placed_alike = node.parent.is_none() || node.transform == other.transform;
            node.name == other.name && node.parent == other.parent && is_placed_alike
        };
        self.scene.nodes.len() == scene.nodes.len() && std::iter::zip(&self.scene.nodes, &scene.nodes).all(is_alike)
    }

    /// Adds some frames of a motion. If the skeleton has many motions, keeps an evenly spread selection of them.
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

    /// All shared data as text; `None` if only one motion has the skeleton.
    pub(super) fn says(&self) -> Option<String> {
        let t_pose = self.figure.t_pose(&self.scene).filter(|_| self.motions > 1)?;
        let mut text = format!("{} {}", self.figure.survey.metres_per_unit, self.up.as_str());
        for (bone, found) in &t_pose.bones {
            let [x, y, z, w] = found.rotation.to_array().map(|part| (1e3 * part).round() + 0.0);
            let sign = if w < 0.0 { -1.0 } else { 1.0 };
            let joint = found.joint.index();
            let _ = write!(
                text,
                "\n{} {joint} {} {} {}",
                bone.as_str(),
                sign * x,
                sign * y,
                sign * z
            );
        }
        Some(text)
    }

    /// The shared data for a scene with this skeleton; `None` for another skeleton.
    pub(super) fn shared(&self, scene: &Scene) -> Option<Shared<'_>> {
        if !self.is_of(scene) || self.scene.animations.len() < 2 {
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

/// Every n-th frame of a motion, beginning with the first.
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
        // A key keeps its time if not every tick has a key.
        Some(ticks) => Keys::at_ticks(keys.values, ticks.iter().map(|tick| tick / step as f64).collect()),
        None => Keys::every_tick(keys.values.into_iter().step_by(step).collect()),
    }
}
