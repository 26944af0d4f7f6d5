//! Real files: read by the library, written as glTF, read back, and compared with their own text.

use mocap::glam::DVec3;
use mocap::gltf::GltfOptions;
use mocap::process::{KeyTolerance, SkeletonMesh};

use super::read::Read;
use crate::kinematics::{Capture, Root};

/// Asserts that in the glTF of a fixture every node has its position by the text of the fixture, in every frame. The
/// tolerance is 1e-5 of the skeleton's height.
#[track_caller]
fn assert_survives(file: &str) {
    let bytes = std::fs::read(format!("../../fixtures/real/{file}")).unwrap();
    let mut scene = mocap::Importer::new().read(&bytes, file).unwrap();
    scene.collapse_keys(KeyTolerance::default());
    scene.add_skeleton_mesh(SkeletonMesh::Skinned);
    let read = Read::glb(&GltfOptions::default().write_glb(&scene).unwrap());

    let capture = Capture::parse(&bytes);
    let tolerance = 1e-5 * capture.height(Root::Replace);
    assert!(tolerance > 0.0);
    for frame in 0..capture.rows.len() {
        let world = read.world((frame as f64 * capture.frame_time) as f32);
        for (index, placement) in capture.placements(frame, Root::Replace).iter().enumerate() {
            let distance = world[index].w_axis.truncate().distance(DVec3::from(placement.position));
            assert!(
                distance <= tolerance,
                "{file}, frame {frame}, {}: {distance}",
                capture.nodes[index].name
            );
        }
    }
}

#[test]
fn lecture() {
    assert_survives("lecture_Test.bvh");
}

#[test]
fn cmu() {
    assert_survives("cmu_01_01.bvh");
}

#[test]
fn perception_neuron_with_moving_positions() {
    assert_survives("perception_neuron_moving_positions.bvh");
}

#[test]
fn mocopi_with_six_channels_a_joint() {
    assert_survives("mocopi_jump_six_channels.bvh");
}

#[test]
fn mixed_rotation_orders() {
    assert_survives("cmu_mixed_rotation_orders.bvh");
}

#[test]
fn rotations_before_positions() {
    assert_survives("rotation_before_position.bvh");
}
