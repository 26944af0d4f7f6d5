//! Packs a range of frames of a long motion as a packed clip. It takes less than half of the bytes of the rows that
//! `pack.rs` describes.
//!
//! Lengths are in metres, as in all packed clips. `view/packed.js` reads the packed clip.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_compress::PackedClip;
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use super::{Part, Row, Track};

/// A skeleton without names and meshes, in metres. Its motion is set to one range of frames at a time.
pub struct ClipBlocks {
    scene: Scene,
    metres_per_unit: f64,
}

impl ClipBlocks {
    /// Prepares the blocks of an animation. `None` if there is no motion, or if a scale is animated, which packed clips
    /// cannot store.
    pub(super) fn new(
        scene: &Scene,
        animation: Option<&Animation>,
        tracks: &[Track<'_>],
        metres_per_unit: f64,
    ) -> Option<Self> {
        let animation = animation.filter(|_| tracks.iter().all(|track| track.part != Part::Scale))?;
        let mut nodes = scene.nodes.clone();
        // Constant nodes keep their pose of the first frame.
        for (node, channel) in Binding::new(scene, animation).driven() {
            let node = &mut nodes[node.index()];
            let rest = Trs::from_matrix(node.transform);
            node.transform = animation.channels[channel].sample(0.0, rest).matrix();
        }
        for node in &mut nodes {
            node.name.clear();
            node.meshes.clear();
            let moved = Trs::from_matrix(node.transform);
            let translation = moved.translation * metres_per_unit as f32;
            node.transform = Trs { translation, ..moved }.matrix();
        }
        Some(Self {
            scene: Scene {
                nodes,
                ..Scene::default()
            },
            metres_per_unit,
        })
    }

    /// The bytes, and the largest distance of a joint from its position, in the file's unit. `None` if the distance
    /// would exceed `max_error`.
    pub(super) fn pack(
        &mut self,
        tracks: &[Track<'_>],
        source: &[Vec<Row>],
        frames: &Range<usize>,
        max_error: f64,
    ) -> Option<(Vec<u8>, f64)> {
        let rows: Vec<_> = std::iter::zip(tracks, source).collect();
        let of_nodes = rows.chunk_by(|(a, _), (b, _)| a.node == b.node);
        let channels = of_nodes.filter_map(|of_node| {
            let (first, _) = of_node.first()?;
            let mut channel = Channel {
                node: Some(NodeId::new(first.node)),
                ..Channel::default()
            };
            for (track, rows) in of_node {
                match track.part {
                    Part::Rotation => channel.rotation_keys = Keys::every_tick(rotations(rows)),
                    _ => channel.position_keys = Keys::every_tick(positions(rows, self.metres_per_unit)),
                }
            }
            Some(channel)
        });
        self.scene.animations = vec![Animation {
            ticks_per_second: 1.0,
            duration: (frames.len() - 1) as f64,
            channels: channels.collect(),
            ..Animation::default()
        }];
        let clip = PackedClip::encode(&self.scene, 0, max_error * self.metres_per_unit).ok()?;
        let error = clip.max_error() / self.metres_per_unit;
        Some((clip.into_bytes(), error))
    }
}

fn rotations(rows: &[Row]) -> Vec<Quat> {
    let count = rows.iter().map(Vec::len).min().unwrap_or(0);
    (0..count)
        .map(|frame| Quat::from_array(std::array::from_fn(|component| rows[component][frame])))
        .collect()
}

fn positions(rows: &[Row], metres_per_unit: f64) -> Vec<Vec3> {
    let count = rows.iter().map(Vec::len).min().unwrap_or(0);
    let metres = |value: f32| (f64::from(value) * metres_per_unit) as f32;
    (0..count)
        .map(|frame| Vec3::from_array(std::array::from_fn(|component| metres(rows[component][frame]))))
        .collect()
}
