//! A short part of each clip of a scene, by which a written file is compared with the scene.

use std::path::Path;

use mocap_scene::pose::Pose;
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use super::SAME;
use crate::fbx::read;
use crate::{ReadOptions, Source};

/// The number of compared times per clip.
const MOMENTS: usize = 9;

/// The frames before and after a compared frame. The reader interpolates between frames if the file has another rate.
const AROUND: usize = 2;

/// The frames of an excerpt for one compared time.
const WINDOW: usize = 2 * AROUND + 1;

pub(super) struct Excerpt {
    /// The scene without meshes. A long clip has only the frames around the compared times, one after the other.
    pub(super) scene: Scene,
    /// For each clip, the compared ticks.
    ticks: Vec<Vec<f64>>,
}

impl Excerpt {
    pub(super) fn of(scene: &Scene) -> Self {
        let (animations, ticks) = scene.animations.iter().map(of_clip).unzip();
        let scene = Scene {
            nodes: scene.nodes.clone(),
            metadata: scene.metadata.clone(),
            animations,
            ..Scene::default()
        };
        Self { scene, ticks }
    }

    /// Reads a file with the clips of the excerpt, and compares the positions of all joints.
    ///
    /// # Errors
    /// The first difference, as a phrase.
    pub(super) fn compare(&self, bytes: &[u8]) -> Result<(), String> {
        let options = ReadOptions {
            without_meshes: true,
            ..ReadOptions::default()
        };
        let source = Source::of_bytes(bytes, Path::new("output.fbx"));
        let again = read::read(&source, &options).map_err(|error| error.to_string())?;
        let scene = &self.scene;
        if again.nodes.len() != scene.nodes.len() || again.animations.len() < scene.animations.len() {
            return Err("reading the file again gives other clips".to_owned());
        }
        for (index, (clip, ticks)) in scene.animations.iter().zip(&self.ticks).enumerate() {
            let other = &again.animations[index];
            for tick in ticks {
                let seconds = tick / clip.ticks_per_second;
                let poses = [(scene, clip), (&again, other)].map(|(scene, clip)| {
                    Pose::at_tick(scene, index, (seconds * clip.ticks_per_second).min(clip.duration))
                });
                let [Some(ours), Some(theirs)] = poses else { continue };
                for node in 0..scene.nodes.len() {
                    let [a, b] = [&ours, &theirs].map(|pose| pose.position(NodeId::new(node)));
                    // A clip with another frame rate is sampled between keys, so allow 10 times the error.
                    if f64::from(a.distance(b)) > 10.0 * SAME * f64::from(1.0 + a.length()) {
                        return Err(format!(
                            "reading the file again gives another position of \"{}\"",
                            scene.nodes[node].name
                        ));
                    }
                }
            }
        }
        Ok(())
    }
}

/// The excerpt of a clip, and the ticks to compare.
fn of_clip(clip: &Animation) -> (Animation, Vec<f64>) {
    let moment = |moment: usize| clip.duration * moment as f64 / (MOMENTS - 1) as f64;
    let last = clip.duration.floor();
    if last < (MOMENTS * WINDOW) as f64 {
        return (clip.clone(), (0..MOMENTS).map(moment).collect());
    }
    let first = |index: usize| (moment(index).round() - AROUND as f64).clamp(0.0, last - (WINDOW - 1) as f64);
    let frames = (0..MOMENTS).flat_map(|index| (0..WINDOW).map(move |frame| first(index) + frame as f64));
    let frames: Vec<f64> = frames.collect();
    let every = frames.iter().copied();
    let sampled = |channel: &Channel| Channel {
        node_name: channel.node_name.clone(),
        node: channel.node,
        position_keys: Keys::every_tick(
            every
                .clone()
                .filter_map(|tick| channel.position_keys.sample(tick))
                .collect(),
        ),
        rotation_keys: Keys::every_tick(
            every
                .clone()
                .filter_map(|tick| channel.rotation_keys.sample(tick))
                .collect(),
        ),
        scaling_keys: Keys::every_tick(
            every
                .clone()
                .filter_map(|tick| channel.scaling_keys.sample(tick))
                .collect(),
        ),
    };
    let excerpt = Animation {
        name: clip.name.clone(),
        ticks_per_second: clip.ticks_per_second,
        duration: (frames.len() - 1) as f64,
        channels: clip.channels.iter().map(sampled).collect(),
    };
    let compared = (0..MOMENTS).map(|index| (index * WINDOW + AROUND) as f64);
    (excerpt, compared.collect())
}
