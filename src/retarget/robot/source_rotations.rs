//! The rotations of the source's joints, each relative to its parent. They explain rotations of the robot's joints.
//!
//! The bones that the robot follows are not used. Such a bone may combine the rotations of several joints of the
//! source, and has a roll that was computed for the robot. So jumps are judged by the rotations in the file.

use glam::Quat;

use mocap_figure::Humanoid;
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::HumanoidBone as Bone;
use mocap_scene::scene::{Animation, NodeId, Scene, Side};

/// The number of limbs: the trunk, and the arms and legs of both sides.
pub(super) const LIMBS: usize = 5;

/// The bones of the trunk and of limbs. Fingers, toes and the face are missing, because they move no limb of a robot.
const BONES: [Bone; 20] = [
    Bone::Hips,
    Bone::Spine,
    Bone::Chest,
    Bone::UpperChest,
    Bone::Neck,
    Bone::Head,
    Bone::LeftShoulder,
    Bone::LeftUpperArm,
    Bone::LeftLowerArm,
    Bone::LeftHand,
    Bone::RightShoulder,
    Bone::RightUpperArm,
    Bone::RightLowerArm,
    Bone::RightHand,
    Bone::LeftUpperLeg,
    Bone::LeftLowerLeg,
    Bone::LeftFoot,
    Bone::RightUpperLeg,
    Bone::RightLowerLeg,
    Bone::RightFoot,
];

/// The rotations of the joints in each frame.
#[derive(Clone, Debug)]
pub struct SourceRotations {
    /// Each bone, its joint, and the rotation of the joint relative to its parent in each frame. The rotation of the
    /// hips is relative to the world.
    tracks: Vec<(Bone, NodeId, Vec<Quat>)>,
}

impl SourceRotations {
    /// The rotations without a frame yet.
    pub fn empty(bones: &Humanoid) -> Self {
        let joints = BONES
            .into_iter()
            .filter_map(|bone| Some((bone, bones.joint(bone)?, Vec::new())));
        Self {
            tracks: joints.collect(),
        }
    }

    pub(super) fn new(source: &Scene, animation: &Animation, bones: &Humanoid) -> Self {
        let mut rotations = Self::empty(bones);
        let binding = Binding::new(source, animation);
        let mut pose = Pose::rest(source);
        for frame in 0..animation.frame_count() {
            pose.sample(&binding, animation, frame as f64);
            rotations.push(&pose);
        }
        rotations
    }

    /// Adds a frame.
    pub(super) fn push(&mut self, pose: &Pose) {
        for (bone, joint, track) in &mut self.tracks {
            let matrices = match bone {
                Bone::Hips => &pose.node_to_world,
                _ => &pose.node_to_parent,
            };
            track.push(Trs::from_matrix(matrices[joint.index()]).rotation);
        }
    }

    /// Drops the first frames.
    pub(super) fn forget(&mut self, frames: usize) {
        self.tracks
            .iter_mut()
            .for_each(|(_, _, track)| drop(track.drain(..frames)));
    }

    /// The largest rotation of a joint of each limb between two frames, in radians. Rotations of the other side count
    /// too, because some devices name the sides as in a mirror.
    pub(super) fn between(&self, from: usize, to: usize) -> [f64; LIMBS] {
        let mut found = [0.0; LIMBS];
        for (bone, _, track) in &self.tracks {
            let by = f64::from(track[from].angle_between(track[to]));
            let both: &[usize] = match limb(*bone) {
                0 => &[0],
                1 | 2 => &[1, 2],
                _ => &[3, 4],
            };
            for limb in both {
                found[*limb] = f64::max(found[*limb], by);
            }
        }
        found
    }
}

/// The index of a bone's limb; 0 is the trunk.
pub(super) fn limb(bone: Bone) -> usize {
    let side = match bone.side() {
        None => return 0,
        Some(Side::Left) => 1,
        Some(Side::Right) => 2,
    };
    match bone.on(Side::Left) {
        Bone::LeftUpperLeg | Bone::LeftLowerLeg | Bone::LeftFoot | Bone::LeftToes => 2 + side,
        _ => side,
    }
}
