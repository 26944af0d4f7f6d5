//! VRM animations on characters without some bones that VRM does not require.

use mocap::Exporter;
use mocap::figure::HumanoidBone;
use mocap::scene::report::{DataKind, DataLoss};

use crate::characters::motion;

/// A character may lack the chest and the upper chest. The report states the loss of a player without these bones, as
/// computed from the rotations of the written file.
#[test]
fn the_loss_on_a_character_without_a_chest_is_said() {
    let mut scene = mocap::import("../../fixtures/real/rokoko_dance.bvh").unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let written = mocap::Exporter::new().write_as(&scene, "dance.vrma").unwrap();
    let note = written
        .notes
        .iter()
        .find(|note| note.starts_with("bones: "))
        .unwrap()
        .clone();
    let file = mocap::Importer::new()
        .read(&written.into_bytes().unwrap(), "dance.vrma")
        .unwrap();
    let node = |bone: HumanoidBone| {
        let node = file.nodes.iter().position(|node| node.humanoid_bone == Some(bone));
        node.unwrap()
    };
    let (spine, chest) = (node(HumanoidBone::Spine), node(HumanoidBone::UpperChest));
    let mut most = 0.0_f32;
    for tick in 0..file.animations[0].frame_count() {
        let pose = mocap::Pose::at_tick(&file, 0, tick as f64).unwrap();
        let rotation = |node: usize| mocap::glam::Quat::from_mat4(&pose.node_to_world[node]);
        most = most.max(rotation(spine).angle_between(rotation(chest)).to_degrees());
    }
    assert!(
        most > 1.0 && note.contains(&format!("upperChest the shoulders by up to {most:.1} degrees")),
        "{note}, and {most}"
    );
}

/// A VRM animation stores rotations only, so joints with changing positions are reported.
#[test]
fn joints_that_move_are_said() {
    let mut source = motion("real/perception_neuron_moving_positions.bvh");
    source.trim(0.0, 40.0);
    let written = Exporter::new().write_as(&source, "motion.vrma").unwrap();
    let is_counted = |loss: &DataLoss| loss.kind == DataKind::PositionCurves && loss.count > 0;
    assert!(written.losses.iter().any(is_counted), "{:?}", written.losses);
}
