//! Motions of one skeleton have one T-pose: in a folder, in one output, and in a part of a motion.

use std::fs;

use mocap::figure::{Humanoid, HumanoidBone as Bone};
use mocap::glam::Quat;
use mocap::{Pose, Scene};

use crate::at_root;
use crate::cut;
use crate::program::Folder;

/// A file without evidence in its rest pose, and a part with little evidence. From this part alone, forearms would be
/// rolled by 90 degrees or more against the whole motion.
const FILE: &str = "fixtures/skeletons/animics_all_along_z.bvh";
const PART: std::ops::Range<usize> = 36..56;

/// The largest angle, in degrees, between a part of a motion and the same part in the whole motion.
const LAW: f32 = 2.0;

/// A folder with the whole motion, the part, and a character.
fn folder() -> Folder {
    let folder = Folder::with(&[]);
    let whole = fs::read_to_string(at_root(FILE)).unwrap();
    folder.write("in/whole.bvh", whole.as_bytes());
    folder.write("in/part.bvh", cut::frames(&whole, PART).as_bytes());
    let hero = fs::read(at_root("fixtures/skeletons/human_game_engine.gltf")).unwrap();
    folder.write("hero.gltf", &hero);
    folder
}

/// The largest angle between the bones of the part and the bones of the whole motion in the world, in degrees.
fn off(whole: &Scene, part: (&Scene, usize)) -> f32 {
    let bones = Humanoid::of(whole);
    let frames_per_second = mocap::import(at_root(FILE)).unwrap().animations[0].ticks_per_second;
    let rotation = |pose: &Pose, bone: Bone| -> Option<Quat> {
        let matrix = pose.node_to_world[bones.joint(bone)?.index()];
        Some(matrix.to_scale_rotation_translation().1)
    };
    let at = |scene: &Scene, clip: usize, frame: usize| {
        let tick = frame as f64 * scene.animations[clip].ticks_per_second / frames_per_second;
        Pose::at_tick(scene, clip, tick).unwrap()
    };
    let frames = (0..PART.len()).flat_map(|frame| {
        let was = at(whole, 0, PART.start + frame);
        let is = at(part.0, part.1, frame);
        let angle = |bone: &Bone| Some(rotation(&was, *bone)?.angle_between(rotation(&is, *bone)?).to_degrees());
        Bone::ALL.iter().filter_map(angle).collect::<Vec<f32>>()
    });
    frames.fold(0.0, f32::max)
}

fn import(folder: &Folder, file: &str) -> Scene {
    mocap::import(folder.path(file)).unwrap()
}

#[test]
fn files_of_a_folder_with_one_skeleton_have_one_t_pose() {
    let folder = folder();
    folder.succeeds("retarget in --character hero.gltf -o out/ --feet free --hands free");
    let (whole, part) = (import(&folder, "out/whole.gltf"), import(&folder, "out/part.gltf"));
    let together = off(&whole, (&part, 0));
    assert!(together < LAW, "{together} degrees");
    folder.succeeds("retarget in/part.bvh hero.gltf -o alone.gltf --feet free --hands free");
    let alone = off(&whole, (&import(&folder, "alone.gltf"), 0));
    assert!(alone > 45.0, "the part alone shows as much: {alone} degrees");
}

#[test]
fn a_shard_looks_at_all_files_of_the_folder() {
    let folder = folder();
    let command = "retarget in --character hero.gltf --feet free";
    folder.succeeds(&format!("{command} -o all/"));
    for shard in ["1/2", "2/2"] {
        folder.succeeds(&format!("{command} -o shards/ --shard {shard}"));
    }
    for file in ["whole.bin", "part.bin"] {
        assert!(
            folder.read(&format!("all/{file}")) == folder.read(&format!("shards/{file}")),
            "{file}"
        );
    }
}

#[test]
fn motions_of_one_output_with_one_skeleton_have_one_t_pose() {
    let folder = folder();
    folder.succeeds("retarget in/part.bvh in/whole.bvh --character hero.gltf -o both.gltf --feet free --hands free");
    let both = import(&folder, "both.gltf");
    assert_eq!(both.animations[0].name, "part");
    let mut whole = both.clone();
    whole.animations.remove(0);
    let found = off(&whole, (&both, 0));
    assert!(found < LAW, "{found} degrees");
}

#[test]
fn a_part_of_a_vrm_animation_is_that_part_of_the_whole() {
    let folder = folder();
    let trim = format!("--trim {}f..{}f", PART.start, PART.end - 1);
    folder.succeeds("convert in/whole.bvh whole.vrma");
    folder.succeeds(&format!("convert in/whole.bvh part.vrma {trim}"));
    let found = off(&import(&folder, "whole.vrma"), (&import(&folder, "part.vrma"), 0));
    assert!(found < LAW, "{found} degrees");
}
