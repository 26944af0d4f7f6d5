//! Tests the blocks of a long motion that are packed clips.

use mocap::compress::PackedClip;
use mocap::glam::Mat4;
use mocap::scene::{NodeKind, Scene};
use mocap::{Binding, Pose, Trs};
use mocap_render::internals::pack::{Part, Storage, Tracks};

/// A truncated walk with its tracks.
fn packed(storage: Storage) -> (Scene, Vec<Vec<u8>>, f64) {
    let scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
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
    let mut pose = Pose::rest(&scene);
    let clip = PackedClip::new(&blocks[0]).unwrap();
    assert_eq!((blocks.len(), clip.frame_count()), (1, animation.frame_count()));
    let mut sampled = vec![Trs::IDENTITY; clip.node_count()];
    for frame in 0..clip.frame_count() {
        pose.sample(&binding, animation, frame as f64);
        clip.sample(frame as f64, &mut sampled);
        let mut worlds: Vec<Mat4> = Vec::new();
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
