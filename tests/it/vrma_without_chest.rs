//! VRM animations on characters that lack bones which VRM does not require.

use mocap::figure::{Humanoid, HumanoidBone, HumanoidBone as Bone};
use mocap::scene::NodeId;
use mocap::{Exporter, Importer};

use crate::retarget::{character, motion};
use crate::roll::rotations;

/// Chest and upper chest are bones that a character may lack: what a player without them loses is said, as the
/// rotations in the written file give it.
#[test]
fn the_loss_on_a_character_without_a_chest_is_said() {
    let mut scene = mocap::import("fixtures/real/rokoko_dance.bvh").unwrap();
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
        most > 1.0 && note.contains(&format!("upperChest the shoulders are up to {most:.1} degrees off")),
        "{note}, and {most}"
    );
}

/// VRM has three joints for a spine of seven: they are divided as when the motion itself is put on a character, so that
/// a VRM animation moves the character alike.
#[test]
fn a_spine_of_more_joints_is_divided_as_in_retargeting() {
    let target = character("human_game_engine");
    let spine = [Bone::Spine, Bone::Chest, Bone::UpperChest, Bone::Head];
    for file in ["real/mocopi_jump_six_channels.bvh", "real/z_up_dab.bvh"] {
        let mut source = motion(file);
        source.trim(0.0, 60.0);
        let joints = Humanoid::of(&source);
        let up = |node: &NodeId| source.nodes[node.index()].parent;
        let neck = joints.joint(Bone::Neck).unwrap();
        let above_hips =
            std::iter::successors(up(&neck), up).take_while(|node| Some(*node) != joints.joint(Bone::Hips));
        assert!(above_hips.count() > 3, "{file}: a spine that VRM has");
        let written = Exporter::new().write_as(&source, "motion.vrma").unwrap();
        let read = Importer::new()
            .read(&written.into_bytes().unwrap(), "motion.vrma")
            .unwrap();
        let ticks = [0.0, 20.0, 40.0];
        let was = rotations(&source, &target, &spine, &ticks);
        let is = rotations(&read, &target, &spine, &ticks);
        for (was, is) in was.iter().flatten().zip(is.iter().flatten()) {
            assert!(was.angle_between(*is).to_degrees() < 0.1, "{file}");
        }
    }
}

/// A VRM animation has rotations alone: joints whose positions move are said.
#[test]
fn joints_that_move_are_said() {
    let mut source = motion("real/perception_neuron_moving_positions.bvh");
    source.trim(0.0, 40.0);
    let written = Exporter::new().write_as(&source, "motion.vrma").unwrap();
    let said = |note: &&String| note.starts_with("positions: ") && note.contains("joints move in their parents");
    assert!(written.notes.iter().any(|note| said(&note)), "{:?}", written.notes);
}
