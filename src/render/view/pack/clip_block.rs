//! A run of frames of a long motion as a packed clip, which takes less than half of the bytes of rows.
//!
//! Its lengths are in metres, as those of all packed clips. `view/packed.js` reads it.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_compress::PackedClip;
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use super::{Part, Row, Track};

/// A skeleton without names and meshes, in metres, whose motion is that of a run of frames.
pub(super) struct ClipBlocks {
    scene: Scene,
    metres_per_unit: f64,
}

impl ClipBlocks {
    /// None where there is no motion, or where a scale moves, which no packed clip has.
    pub(super) fn new(
        scene: &Scene,
        animation: Option<&Animation>,
        tracks: &[Track<'_>],
        metres_per_unit: f64,
    ) -> Option<Self> {
        let animation = animation.filter(|_| tracks.iter().all(|track| track.part != Part::Scale))?;
        let mut nodes = scene.nodes.clone();
        // What does not move stands as it does at the first frame.
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

    /// The bytes, and the largest distance of a joint from its position in any of the frames, in the file's unit. None
    /// where that would be above `max_error`.
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

#[cfg(test)]
mod tests {
    use super::super::{Storage, Tracks};
    use super::*;
    use mocap_scene::scene::NodeKind;

    /// A walk without its end, and its tracks.
    fn packed(storage: Storage) -> (Scene, Vec<Vec<u8>>, f64) {
        let scene = mocap_io::import::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
        let animation = &scene.animations[0];
        let mut tracks = Tracks::new(&scene, animation.frame_count() as u64);
        for (node, channel) in Binding::new(&scene, animation).driven() {
            let channel = &animation.channels[channel];
            let rest = Trs::from_matrix(scene.nodes[node.index()].transform);
            tracks.push(node.index(), Part::Rotation, channel, rest);
            if channel.position_keys.len() > 1 {
                tracks.push(node.index(), Part::Translation, channel, rest);
            }
        }
        let packed = tracks.pack_all(storage, 15.0, 0.06);
        (scene.clone(), packed.blocks, packed.max_error)
    }

    #[test]
    fn a_block_is_a_packed_clip_within_the_bound() {
        let (scene, blocks, max_error) = packed(Storage::Clips);
        let (_, rows, _) = packed(Storage::Rows);
        let [bytes, rows] = [&blocks, &rows].map(|blocks| blocks.iter().map(Vec::len).sum::<usize>());
        assert!(2 * bytes < rows, "{bytes} of {rows}");
        assert!(max_error > 0.0 && max_error <= 1.5e-3, "{max_error}");
        let animation = &scene.animations[0];
        let binding = Binding::new(&scene, animation);
        let mut pose = mocap_scene::pose::Pose::rest(&scene);
        let clip = PackedClip::new(&blocks[0]).unwrap();
        assert_eq!((blocks.len(), clip.frame_count()), (1, animation.frame_count()));
        let mut sampled = vec![Trs::IDENTITY; clip.node_count()];
        for frame in 0..clip.frame_count() {
            pose.sample(&binding, animation, frame as f64);
            clip.sample(frame as f64, &mut sampled);
            let mut worlds: Vec<glam::Mat4> = Vec::new();
            for (index, node) in scene.nodes.iter().enumerate() {
                let local = sampled[index].matrix();
                worlds.push(node.parent.map_or(local, |parent| worlds[parent.index()] * local));
                let [found, expected] = [worlds[index], pose.node_to_world[index]].map(|world| world.w_axis.truncate());
                let distance = f64::from((found / 0.06).distance(expected));
                assert!(
                    distance <= 1.5e-3 + 1e-4,
                    "{distance} at {} in frame {frame}",
                    node.name
                );
            }
        }
        assert!(scene.nodes.iter().any(|node| node.kind == NodeKind::EndSite));
    }
}
